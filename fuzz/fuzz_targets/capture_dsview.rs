#![no_main]

use canbaud_capture::Format;

// As capture_sr.
libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((kind, data)) = data.split_first() else { return };
    if kind % 2 == 0 {
        canbaud_fuzz::stream(data.to_vec(), Some(Format::DsView));
        return;
    }
    let at = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    let (header, samples) = data.split_at(at);
    let (first, second) = samples.split_at(samples.len() / 2);
    let members = [("header", header), ("L-0/0", first), ("L-0/1", second), ("L-7/0", samples)];
    if let Some(file) = canbaud_fuzz::archive(&members) {
        canbaud_fuzz::stream(file, Some(Format::DsView));
    }
});
