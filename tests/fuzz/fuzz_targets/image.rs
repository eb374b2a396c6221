//! Fuzz target: see `fabric_fuzz::image`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fabric_fuzz::tally::count(fabric_fuzz::image::run(data)));
