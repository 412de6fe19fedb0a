#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bsdfkit_fuzz::xml_parts(bytes));
