//! Scenes for users with friction and with several plies: each ends by itself, and its energy balance closes within 1 % of the impact
//! energy with the default time step.

use std::path::Path;
use std::process::Command;

fn run(scene: &str) -> serde_json::Value {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{scene}.toml"));
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(scene);
    let program = Command::new(env!("CARGO_BIN_EXE_fabric")).arg("run").arg(file).arg("--out").arg(&out).output();
    assert!(program.unwrap().status.success(), "{scene}");
    serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn the_balances_of_scenes_with_friction_and_plies_close() {
    for scene in ["rough_sphere", "turned_plies", "hybrid_pack"] {
        let summary = run(scene);
        let residual = summary["energy_residual_relative"].as_f64().unwrap();
        assert!(residual.abs() < 0.01, "{scene}: {residual}");
        assert_eq!(summary["ended_by"], "exited", "{scene}");
    }
}
