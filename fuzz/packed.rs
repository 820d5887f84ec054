//! Any bytes packed with zstd as a whole, or as what is packed.
#![no_main]

mod read;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let magic = [0x28, 0xb5, 0x2f, 0xfd];
    let packed = match kind % 2 {
        0 => [&magic, bytes].concat(),
        _ => zstd::encode_all(bytes, 1).expect("memory is written to"),
    };
    // A packed byte may hold many.
    read::read_all(&read::written("input.zstd", &packed), usize::MAX);
});
