//! A command whose reader has gone, as after `| head`, ends without a panic and with the exit code that it would have had.

use std::io::pipe;
use std::process::{Command, Output};

/// Runs `fabric` with a pipe that nobody reads in place of the standard output.
fn unread(arguments: &[&str]) -> Output {
    let (reader, writer) = pipe().unwrap();
    drop(reader);
    Command::new(env!("CARGO_BIN_EXE_fabric")).args(arguments).stdout(writer).output().unwrap()
}

#[test]
fn a_reader_that_has_gone_is_no_panic() {
    let out = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("unread");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/four_sides_40J.toml");
    let run = ["run", scene, "--steps", "64", "--until", "none", "--out", &out.to_string_lossy()];
    for arguments in
        [&run[..], &["fabrics"], &["fabrics", "kevlar_km2_s706"], &["scene", "sheet_3in_sphere"], &["--help"]]
    {
        let ended = unread(arguments);
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success() && !said.contains("panic"), "{arguments:?}: {}: {said}", ended.status);
    }
    assert!(out.join("summary.json").exists() && out.join("frames.json").exists());
    assert_eq!(unread(&["scene", "no_preset"]).status.code(), Some(2));
}
