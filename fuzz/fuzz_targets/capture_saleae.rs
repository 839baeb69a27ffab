#![no_main]

use canbaud_capture::{Format, WordSize};

// The first byte chooses the export.
libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((kind, data)) = data.split_first() else { return };
    let word = WordSize::ALL[usize::from(kind % 4)];
    let format = match kind / 4 % 4 {
        0 => Format::Logic1Samples(word),
        1 => Format::Logic1Changes(word),
        2 => Format::TekIsf,
        _ => Format::SaleaeBinary,
    };
    canbaud_fuzz::stream(data.to_vec(), Some(format));
});
