//! How a run ends, and what it leaves behind.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// An empty folder with a small scene of this file name in it, and the command that runs it there.
fn scene(test: &str, file: &str, parameters: &str) -> (PathBuf, Command) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let text = format!("preset = \"sheet_3in_sphere\"\nsheet = {{ nodes_x = 31, nodes_y = 31 }}\n{parameters}\n");
    fs::write(folder.join(file), text).unwrap();
    // Tests may run where the signal is ignored.
    let mut command = Command::new("env");
    command.args(["--default-signal=INT", env!("CARGO_BIN_EXE_fabric"), "run", file]);
    command.current_dir(&folder).stdout(Stdio::null());
    (folder, command)
}

#[test]
fn the_exit_status_says_how_a_run_has_ended() {
    for (arguments, parameters, status, ended_by) in [
        (&["--until", "exited"][..], "projectile.velocity = [0.0, 0.0, 300.0]", 0, "exited"),
        (&["--until", "through"], "projectile.velocity = [0.0, 0.0, 300.0]", 0, "through"),
        (&["--steps", "64"], "", 3, "TIMEOUT"),
        (&["--steps", "64", "--until", "none"], "", 0, "TIMEOUT"),
        (&["--until", "detached", "--steps", "300"], "projectile.velocity = [0.0, 0.0, 300.0]", 3, "TIMEOUT"),
        (&[], "contact_capacity = 1", 1, ""),
        (&[], "projectile.mass = 0.0", 2, ""),
    ] {
        let (folder, mut command) = scene("status", "shot.toml", parameters);
        assert_eq!(command.args(arguments).status().unwrap().code(), Some(status), "{arguments:?} {parameters}");
        let summary = fs::read_to_string(folder.join("target/fabric/shot/summary.json")).unwrap_or_default();
        assert!(ended_by.is_empty() || summary.contains(&format!("\"ended_by\": \"{ended_by}\"")), "{summary}");
        assert_eq!(folder.join("target/fabric/shot").exists(), status != 2);
    }
}

#[test]
fn a_run_that_is_stopped_leaves_no_empty_folder() {
    let (folder, mut command) = scene("stopped", "shot.toml", "projectile.velocity = [0.0, 0.0, 0.0]");
    let mut run = command.args(["--steps", "1000000000"]).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert!(run.try_wait().unwrap().is_none(), "it runs");
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), None, "the signal has ended it");
    assert!(!folder.join("target/fabric/shot").exists());
}

/// Named after its file, a folder could be the one above.
#[test]
fn results_stay_in_their_folder_whatever_the_scene_is_called() {
    for (file, name) in [("..toml", "scene"), ("...toml", "scene"), (".toml", ".toml"), ("a.b.toml", "a.b")] {
        let (folder, mut command) = scene("names", file, "");
        assert!(command.args(["--steps", "64", "--until", "none"]).status().unwrap().success());
        let made: Vec<_> =
            fs::read_dir(folder.join("target/fabric")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(made, [name], "{file}");
        assert!(folder.join("target/fabric").join(name).join("summary.json").exists());
    }
}
