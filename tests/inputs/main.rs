//! Writes tests/inputs/cases: the cases of bad input as the C host and the FMI tests read them.
//!
//! cargo run -p fabric-tests --bin inputs

/// The list, beside this file.
const LIST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/inputs/cases");

fn main() -> std::io::Result<()> {
    std::fs::write(LIST, fabric_tests::inputs::listed())
}
