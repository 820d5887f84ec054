//! The `limpid` command: arguments in, library calls, text out.

mod cli;

use std::process::ExitCode;

use limpid::Error;

fn main() -> ExitCode {
    silence_wayland();
    match cli::run(std::env::args().collect()) {
        Ok(code) => code,
        Err(error) => {
            cli::tell(&error);
            ExitCode::from(code_of(&error))
        }
    }
}

/// Mesa's layer that orders Vulkan devices asks for a Wayland display, and Wayland's library complains on standard error of
/// a missing `XDG_RUNTIME_DIR`, which only desktop sessions have. A folder that holds no display has it find none in silence.
///
/// The library does not do this: the environment belongs to the program that embeds it.
fn silence_wayland() {
    let is_set =
        std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| folder.as_encoded_bytes().starts_with(b"/"));
    if cfg!(target_os = "linux") && !is_set {
        #[expect(unsafe_code, reason = "a change of the environment is unsafe beside other threads")]
        // SAFETY: this is the first statement of `main`, and no thread has been started.
        unsafe {
            std::env::set_var("XDG_RUNTIME_DIR", "/dev/null");
        }
    }
}

/// 2 for wrong usage, 1 for what goes wrong in spite of right usage.
fn code_of(error: &Error) -> u8 {
    match error {
        Error::Config { .. } | Error::Yaml(_) | Error::Output { .. } => 2,
        Error::Partial { cause, .. } => code_of(cause),
        _ => 1,
    }
}
