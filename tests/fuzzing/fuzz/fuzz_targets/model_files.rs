#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzzing::target("model_files").unwrap()(data));
