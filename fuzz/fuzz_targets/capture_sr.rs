#![no_main]

use canbaud_capture::Format;

// The raw bytes of an archive, or (first byte odd) a sound archive of unsound members: metadata up
// to the first zero, then samples.
libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((kind, data)) = data.split_first() else { return };
    if kind % 2 == 0 {
        canbaud_fuzz::stream(data.to_vec(), Some(Format::SigrokSr));
        return;
    }
    let at = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    let (metadata, samples) = data.split_at(at);
    let (first, second) = samples.split_at(samples.len() / 2);
    let members = [
        ("version", b"2".as_slice()),
        ("metadata", metadata),
        ("logic-1-1", first),
        ("logic-1-2", second),
        ("analog-1-1-1", samples),
        ("analog-1-2-1", second),
    ];
    if let Some(file) = canbaud_fuzz::archive(&members) {
        canbaud_fuzz::stream(file, Some(Format::SigrokSr));
    }
});
