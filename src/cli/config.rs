//! `limpid config`.

use limpid::config::EXAMPLE;

pub(crate) fn execute() {
    print!("{EXAMPLE}");
}
