//! Scenes and calls that must be refused, with code and field, changing nothing.

use super::flight::uniform;
use super::{Answer, Case, fmu};
use crate::memory::{self, Buffers};
use fabric::{AttachmentKind, Code, Drive, Error, Integrator, Motion, Path, RotationRule, Scene, Shape, Sim, TimeStep};

/// Scenes that must be refused, with code and field.
pub fn scenes() -> Vec<Case> {
    use Code::*;
    let nan = f64::NAN;
    let inf = f64::INFINITY;
    vec![
        refused("dt = 0", NotPositive, "time_step.fraction", |s| s.time_step = TimeStep::seconds(0.0)),
        refused("dt < 0", OutOfRange, "time_step.seconds", |s| s.time_step = TimeStep::seconds(-1e-8)),
        refused("dt NaN", NotFinite, "time_step.seconds", move |s| s.time_step = TimeStep::seconds(nan)),
        refused("dt infinite", NotFinite, "time_step.seconds", move |s| s.time_step = TimeStep::seconds(inf)),
        refused("dt subnormal", StepLimitUnusable, "time_step.seconds", |s| s.time_step = TimeStep::seconds(1e-310)),
        refused("scatter of the modulus 1e300 Pa: dt below 1e-150 s", StepLimitUnusable, "time_step.seconds", |s| {
            s.yarn.stochastic = true;
            (s.yarn.modulus_sd, s.yarn.damage_slope, s.yarn.damage_intercept) = (1e300, 0.0, 230.0);
        }),
        refused("dt above 0.5 dt_crit", StepTooLarge, "time_step.seconds", |s| s.time_step = TimeStep::seconds(2.7e-8)),
        refused("step fraction 0.51", OutOfRange, "time_step.fraction", |s| s.time_step = TimeStep::fraction(0.51)),
        refused("theta = 0.4", OutOfRange, "integrator.theta", |s| {
            s.integrator = Integrator { theta: 0.4, ..Integrator::THETA };
        }),
        refused("theta of the rotation = 1.1", OutOfRange, "rotation_rule.theta", |s| {
            s.rotation_rule = RotationRule::theta(1.1);
        }),
        refused("node mass 0", NotPositive, "sheet.node_mass", |s| s.sheet.node_mass = 0.0),
        refused("node mass NaN", NotFinite, "sheet.node_mass", move |s| s.sheet.node_mass = nan),
        refused("spacing < 0", NotPositive, "sheet.spacing", |s| s.sheet.spacing = -1e-3),
        refused("yarn area < 0", NotPositive, "sheet.yarn_area", |s| s.sheet.yarn_area = -1e-7),
        refused("modulus 0", NotPositive, "yarn.modulus_mean", |s| s.yarn.modulus_mean = 0.0),
        refused("U_c = 1", OutOfRange, "yarn.critical_stretch", |s| s.yarn.critical_stretch = 1.0),
        refused("alpha_fail < 0", OutOfRange, "yarn.alpha_fail", |s| s.yarn.alpha_fail = -0.01),
        refused("alpha_fail = 1", OutOfRange, "yarn.alpha_fail", |s| s.yarn.alpha_fail = 1.0),
        refused("B = 1", OutOfRange, "yarn.damage_b", |s| s.yarn.damage_b = 1.0),
        refused("A = 0", NotPositive, "yarn.damage_a", |s| s.yarn.damage_a = 0.0),
        refused("A (1 - B) = 1.1", OutOfRange, "yarn.damage_a", |s| s.yarn.damage_a = 1.1),
        refused("lambda < 3", DamageRateTooSmall, "yarn.damage_intercept", |s| s.yarn.damage_intercept = -1107.0),
        refused("one node along x", OutOfRange, "sheet.nodes_x", |s| s.sheet.nodes_x = 1),
        refused("0 plies", OutOfRange, "sheet.plies", |s| s.sheet.plies = 0),
        refused("1001 plies", OutOfRange, "sheet.plies", |s| s.sheet.plies = 1001),
        refused("projectile mass 0", NotPositive, "projectile.mass", |s| s.projectile.mass = 0.0),
        refused("lighter than a node", ProjectileTooLight, "projectile.mass", |s| s.projectile.mass = 6e-8),
        refused("R below the spacing", ProjectileTooSmall, "projectile.radius", |s| s.projectile.radius = 7e-4),
        refused("cylinder, L = 0", NotPositive, "projectile.length", |s| {
            s.projectile.shape = Shape::Cylinder;
            s.projectile.length = 0.0;
        }),
        refused("box thinner than two spacings", ProjectileTooSmall, "projectile.size", |s| {
            s.projectile.shape = Shape::Box;
            s.projectile.size[1] = 1e-3;
        }),
        refused("polyhedron without faces", OutOfRange, "projectile.faces", |s| s.projectile.shape = Shape::Polyhedron),
        refused("position NaN", NotFinite, "projectile.position", move |s| s.projectile.position[1] = nan),
        refused("velocity infinite", NotFinite, "projectile.velocity", move |s| s.projectile.velocity[2] = inf),
        refused("angular velocity NaN", NotFinite, "projectile.angular_velocity", move |s| {
            s.projectile.angular_velocity[0] = nan;
        }),
        refused("quaternion NaN", NotFinite, "projectile.orientation", move |s| s.projectile.orientation[3] = nan),
        refused("quaternion zero", BadQuaternion, "projectile.orientation", |s| s.projectile.orientation = [0.0; 4]),
        refused("sheet quaternion zero", BadQuaternion, "sheet.orientation", |s| s.sheet.orientation = [0.0; 4]),
        refused("overlap at the start", InitialOverlap, "projectile.position", |s| s.projectile.position[2] += 1e-4),
        refused("a fixed node inside at the start", InitialOverlap, "projectile.position", |s| {
            let half = s.half_size();
            s.projectile.position = [half[0], half[1], 0.0];
        }),
        refused("V dt > h", ProjectileTooFast, "projectile.velocity", |s| s.projectile.velocity[2] = 3.7e4),
        refused("spin 1e9 rad/s", ProjectileTooFast, "projectile.velocity", |s| {
            s.projectile.shape = Shape::Cylinder;
            s.projectile.position[2] = -0.02;
            s.projectile.angular_velocity[0] = 1e9;
        }),
        refused("corner discs overlap", DiscsOverlap, "attachment.disc_radius", |s| {
            s.attachment.kind = AttachmentKind::FourCorners;
            (s.attachment.disc_inset, s.attachment.disc_radius) = (25.4e-3, 19.05e-3);
        }),
        refused("quarter model of an off-centre hit", NotSymmetric, "projectile.position", |s| {
            (s.symmetry.mirror_x, s.symmetry.mirror_y) = (true, true);
            s.projectile.position[0] = 1e-3;
        }),
        refused("quarter model of random yarn", NotSymmetric, "yarn.stochastic", |s| {
            s.symmetry.mirror_x = true;
            s.yarn.stochastic = true;
        }),
    ]
}

/// The 3 in sheet, uniform, changed so that it must be refused.
pub fn refused(
    name: &str,
    code: Code,
    field: &'static str,
    change: impl Fn(&mut Scene) + Sync + Send + 'static,
) -> Case {
    let check = move || {
        let mut scene = uniform(105, 100.0);
        change(&mut scene);
        let refused = memory::refusal(&scene);
        let fmu = refused.and_then(|error| fmu::refusal(&scene, &error));
        Ok(Answer { fmu, ..compare(refused.map_or(Ok(()), Err), code, field) })
    };
    let expected = refusal_text(code, field);
    Case { theme: "Refused scenes", name: name.to_string(), expected, long: false, check: Box::new(check) }
}

fn refusal_text(code: Code, field: &str) -> String {
    format!("refused: {code:?}, {field}")
}

fn compare(result: Result<(), Error>, code: Code, field: &str) -> Answer {
    match result {
        Ok(()) => Answer::plain("accepted".to_string(), false),
        Err(error) => {
            let pass = error.code == code && error.field == field;
            let happened = if pass { error.text().to_string() } else { refusal_text(error.code, error.field) };
            Answer::plain(happened, pass)
        }
    }
}

/// Calls on a sound simulation that must be refused and change no bit.
pub fn calls() -> Vec<Case> {
    let motion = |change: fn(&mut Motion)| {
        let mut end = Motion {
            position: [0.0, 0.0, -6.3e-3],
            velocity: [0.0, 0.0, 1.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        };
        change(&mut end);
        Path { first: 0, steps: 100, end }
    };
    let path = |name, code, field, change: fn(&mut Motion)| {
        unchanged(name, code, field, Drive::Prescribed, move |sim| sim.follow(&motion(change), 100))
    };
    vec![
        unchanged("set_motion with a NaN", Code::NotFinite, "positions", Drive::Free, |sim| place(sim, f64::NAN)),
        unchanged("set_motion 1e160 m away", Code::OutOfRange, "positions", Drive::Free, |sim| place(sim, 1e160)),
        unchanged("external force infinite", Code::NotFinite, "external.force", Drive::Free, |sim| {
            sim.set_external_load([0.0, f64::INFINITY, 0.0], [0.0; 3])
        }),
        path("path with position NaN", Code::NotFinite, "path.position", |end| end.position[0] = f64::NAN),
        path("path with velocity infinite", Code::NotFinite, "path.velocity", |end| end.velocity[0] = f64::INFINITY),
        path("path with quaternion zero", Code::BadQuaternion, "path.orientation", |end| end.orientation = [0.0; 4]),
        path("path faster than h/dt", Code::ProjectileTooFast, "path.velocity", |end| end.position[2] = 1.0),
        unchanged("external load on a prescribed body", Code::WrongDrive, "drive", Drive::Prescribed, |sim| {
            sim.set_external_load([1.0, 0.0, 0.0], [0.0; 3])
        }),
    ]
}

/// Puts the height of a node somewhere else.
fn place(sim: &mut Sim<'_>, height: f64) -> Result<(), Error> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    positions[17] = height;
    let velocities = vec![0.0; positions.len()];
    sim.set_motion(&positions, &velocities)
}

fn unchanged(
    name: &str,
    code: Code,
    field: &'static str,
    drive: Drive,
    call: impl Fn(&mut Sim<'_>) -> Result<(), Error> + Sync + Send + 'static,
) -> Case {
    let check = move || {
        let mut scene = uniform(21, 100.0);
        scene.drive = drive;
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let before = sim.digest();
        let mut answer = compare(call(&mut sim), code, field);
        if sim.digest() != before {
            answer.pass = false;
            answer.happened += "; STATE CHANGED";
        }
        Ok(answer)
    };
    let expected = refusal_text(code, field) + ", same digest";
    Case { theme: "Refused calls", name: name.to_string(), expected, long: false, check: Box::new(check) }
}
