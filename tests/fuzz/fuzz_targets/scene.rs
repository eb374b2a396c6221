//! Fuzz target: see `fabric_fuzz::scene`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fabric_fuzz::tally::count(fabric_fuzz::scene::run(data)));
