//! The program's name until version 0.1.0.

fn main() -> std::process::ExitCode {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "fabric-study is called fabric now: cargo run --release -p fabric -- run FILE");
    std::process::ExitCode::from(2)
}
