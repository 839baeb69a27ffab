#![no_main]

use canbaud_capture::Format;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    canbaud_fuzz::stream(data.to_vec(), Some(Format::LogicData));
});
