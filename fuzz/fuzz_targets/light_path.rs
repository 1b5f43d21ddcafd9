#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| texmap_fuzz::light_path(bytes));
