#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| steerwright_fuzzing::target("definitions").unwrap()(data));
