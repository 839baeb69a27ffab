#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| canbaud_fuzz::stream(data.to_vec(), None));
