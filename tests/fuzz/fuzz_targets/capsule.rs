//! Fuzz target: see `fabric_fuzz::capsule`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fabric_fuzz::tally::count(fabric_fuzz::capsule::run(data)));
