//! Scenes as TOML: a preset, and whatever differs from it. Keys are the field names of [`fabric::Scene`]; an unknown key is an error.
//!
//! ```toml
//! preset = "sheet_3in_sphere"          # or "sheet_10in_cylinder", "turbine_disc_sector"
//! time_step = { fraction = 0.4 }       # of dt_crit; or { seconds = 2e-8 }
//! integrator = "verlet"                # or "theta", or { theta = { tolerance = 1e-8 } }
//!
//! [attachment]
//! kind = "four_corners"
//!
//! [projectile]
//! velocity = [0.0, 0.0, 154.3]
//! ```
//!
//! All keys with units and defaults: study/scenes/every_key.toml.
//!
//! `faces` are rows `[n_x, n_y, n_z, b]`. A disc sector gets its faces, mass centre and moments from its dimensions:
//! `disc_sector = { inner_radius = 0.015, outer_radius = 0.04, angle = 2.0944, thickness = 0.01 }` beside `mass`.

use crate::Result;
use fabric::{
    AttachmentKind, Draw, Drive, Faces, Integrator, RotationRule, Scene, Shape, StepAfterFailure, StepCheck, ThetaRule,
    TimeStep, prism,
};
use serde::Deserialize;
use serde::de::Error as _;
use std::path::Path;

/// A scene file. What is absent keeps the preset's value.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    preset: Preset,
    #[serde(default)]
    sheet: SheetFile,
    #[serde(default)]
    symmetry: SymmetryFile,
    #[serde(default)]
    attachment: AttachmentFile,
    #[serde(default)]
    yarn: YarnFile,
    #[serde(default)]
    projectile: ProjectileFile,
    drive: Option<DriveName>,
    seed: Option<u64>,
    time_step: Option<TimeStepFile>,
    step_check: Option<StepCheckName>,
    integrator: Option<IntegratorFile>,
    step_after_failure: Option<StepAfterFailureName>,
    slack_toe: Option<f64>,
    rotation_rule: Option<RotationFile>,
    force_window: Option<f64>,
    track_detachment: Option<bool>,
    track_support: Option<bool>,
    contact_capacity: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Preset {
    #[serde(rename = "sheet_3in_sphere")]
    Sheet3inSphere,
    #[serde(rename = "sheet_10in_cylinder")]
    Sheet10inCylinder,
    TurbineDiscSector,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SheetFile {
    nodes_x: Option<u32>,
    nodes_y: Option<u32>,
    spacing: Option<f64>,
    node_mass: Option<f64>,
    yarn_area: Option<f64>,
    plies: Option<u32>,
    position: Option<[f64; 3]>,
    orientation: Option<[f64; 4]>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [symmetry] with mirror_x, mirror_y")]
struct SymmetryFile {
    mirror_x: Option<bool>,
    mirror_y: Option<bool>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [attachment] with kind, disc_inset, disc_radius")]
struct AttachmentFile {
    kind: Option<AttachmentName>,
    disc_inset: Option<f64>,
    disc_radius: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct YarnFile {
    modulus_mean: Option<f64>,
    modulus_sd: Option<f64>,
    damage_slope: Option<f64>,
    damage_intercept: Option<f64>,
    damage_sd: Option<f64>,
    critical_stretch: Option<f64>,
    damage_a: Option<f64>,
    damage_b: Option<f64>,
    alpha_fail: Option<f64>,
    stochastic: Option<bool>,
    draw: Option<DrawName>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProjectileFile {
    shape: Option<ShapeName>,
    radius: Option<f64>,
    length: Option<f64>,
    size: Option<[f64; 3]>,
    faces: Option<Vec<[f64; 4]>>,
    moments: Option<[f64; 3]>,
    disc_sector: Option<DiscSectorFile>,
    mass: Option<f64>,
    position: Option<[f64; 3]>,
    velocity: Option<[f64; 3]>,
    orientation: Option<[f64; 4]>,
    angular_velocity: Option<[f64; 3]>,
}

/// A sector of a disc in place of `shape`, `faces` and `moments`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DiscSectorFile {
    inner_radius: f64,
    outer_radius: f64,
    angle: f64,
    thickness: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum AttachmentName {
    TwoSides,
    FourSides,
    FourCorners,
    Free,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum DrawName {
    Segment,
    Yarn,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum ShapeName {
    Sphere,
    Cylinder,
    HemisphericalCylinder,
    Box,
    Polyhedron,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum DriveName {
    Free,
    Prescribed,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum StepCheckName {
    Refuse,
    None,
}

#[derive(Deserialize)]
#[serde(untagged, deny_unknown_fields, expecting = "`time_step` is { fraction = 0.4 } or { seconds = 2e-8 }")]
enum TimeStepFile {
    Fraction { fraction: f64 },
    Seconds { seconds: f64 },
}

#[derive(Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "`integrator` is \"verlet\", \"theta\", or { theta = { theta, tolerance, max_iterations } }"
)]
enum IntegratorFile {
    Name(IntegratorName),
    Rule { theta: ThetaFile },
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum IntegratorName {
    Verlet,
    Theta,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ThetaFile {
    theta: Option<f64>,
    tolerance: Option<f64>,
    max_iterations: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum StepAfterFailureName {
    Keep,
    Half,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum RotationFile {
    Midpoint,
    Theta(f64),
}

/// Reads a scene. The kernel's own checks come later, when a simulation is made of it.
pub fn read(path: &Path) -> Result<Scene> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// The scene that a text describes.
pub fn parse(text: &str) -> std::result::Result<Scene, toml::de::Error> {
    let file: SceneFile = toml::from_str(text)?;
    let mut scene = match file.preset {
        Preset::Sheet3inSphere => Scene::sheet_3in_sphere(),
        Preset::Sheet10inCylinder => Scene::sheet_10in_cylinder(),
        Preset::TurbineDiscSector => Scene::turbine_disc_sector(),
    };
    let sheet = &mut scene.sheet;
    set(&mut sheet.nodes_x, file.sheet.nodes_x);
    set(&mut sheet.nodes_y, file.sheet.nodes_y);
    set(&mut sheet.spacing, file.sheet.spacing);
    set(&mut sheet.node_mass, file.sheet.node_mass);
    set(&mut sheet.yarn_area, file.sheet.yarn_area);
    set(&mut sheet.plies, file.sheet.plies);
    set(&mut sheet.position, file.sheet.position);
    set(&mut sheet.orientation, file.sheet.orientation);

    set(&mut scene.symmetry.mirror_x, file.symmetry.mirror_x);
    set(&mut scene.symmetry.mirror_y, file.symmetry.mirror_y);

    let attachment = &mut scene.attachment;
    set(&mut attachment.kind, file.attachment.kind.map(attachment_kind));
    set(&mut attachment.disc_inset, file.attachment.disc_inset);
    set(&mut attachment.disc_radius, file.attachment.disc_radius);

    let yarn = &mut scene.yarn;
    set(&mut yarn.modulus_mean, file.yarn.modulus_mean);
    set(&mut yarn.modulus_sd, file.yarn.modulus_sd);
    set(&mut yarn.damage_slope, file.yarn.damage_slope);
    set(&mut yarn.damage_intercept, file.yarn.damage_intercept);
    set(&mut yarn.damage_sd, file.yarn.damage_sd);
    set(&mut yarn.critical_stretch, file.yarn.critical_stretch);
    set(&mut yarn.damage_a, file.yarn.damage_a);
    set(&mut yarn.damage_b, file.yarn.damage_b);
    set(&mut yarn.alpha_fail, file.yarn.alpha_fail);
    set(&mut yarn.stochastic, file.yarn.stochastic);
    set(&mut yarn.draw, file.yarn.draw.map(draw));

    let given = &file.projectile;
    if given.disc_sector.is_some() && (given.shape.is_some() || given.faces.is_some() || given.moments.is_some()) {
        return Err(toml::de::Error::custom("`disc_sector` stands in place of `shape`, `faces` and `moments`"));
    }
    let body = &mut scene.projectile;
    set(&mut body.shape, file.projectile.shape.map(shape));
    set(&mut body.radius, file.projectile.radius);
    set(&mut body.length, file.projectile.length);
    set(&mut body.size, file.projectile.size);
    set(&mut body.faces, file.projectile.faces.map(|faces| Faces::of(&faces)));
    set(&mut body.moments, file.projectile.moments);
    set(&mut body.mass, file.projectile.mass);
    if let Some(sector) = file.projectile.disc_sector {
        let made =
            prism::disc_sector(sector.inner_radius, sector.outer_radius, sector.angle, sector.thickness, body.mass);
        let made = made.map_err(toml::de::Error::custom)?.projectile;
        (body.shape, body.faces, body.moments) = (made.shape, made.faces, made.moments);
    }
    set(&mut body.position, file.projectile.position);
    set(&mut body.velocity, file.projectile.velocity);
    set(&mut body.orientation, file.projectile.orientation);
    set(&mut body.angular_velocity, file.projectile.angular_velocity);

    set(&mut scene.drive, file.drive.map(drive));
    set(&mut scene.seed, file.seed);
    set(&mut scene.time_step, file.time_step.map(time_step));
    set(&mut scene.step_check, file.step_check.map(step_check));
    set(&mut scene.integrator, file.integrator.map(integrator));
    set(&mut scene.step_after_failure, file.step_after_failure.map(step_after_failure));
    set(&mut scene.slack_toe, file.slack_toe);
    set(&mut scene.rotation_rule, file.rotation_rule.map(rotation_rule));
    set(&mut scene.force_window, file.force_window);
    set(&mut scene.track_detachment, file.track_detachment);
    set(&mut scene.track_support, file.track_support);
    set(&mut scene.contact_capacity, file.contact_capacity);
    Ok(scene)
}

fn set<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}

fn attachment_kind(name: AttachmentName) -> AttachmentKind {
    match name {
        AttachmentName::TwoSides => AttachmentKind::TwoSides,
        AttachmentName::FourSides => AttachmentKind::FourSides,
        AttachmentName::FourCorners => AttachmentKind::FourCorners,
        AttachmentName::Free => AttachmentKind::Free,
    }
}

fn draw(name: DrawName) -> Draw {
    match name {
        DrawName::Segment => Draw::Segment,
        DrawName::Yarn => Draw::Yarn,
    }
}

fn shape(name: ShapeName) -> Shape {
    match name {
        ShapeName::Sphere => Shape::Sphere,
        ShapeName::Cylinder => Shape::Cylinder,
        ShapeName::HemisphericalCylinder => Shape::HemisphericalCylinder,
        ShapeName::Box => Shape::Box,
        ShapeName::Polyhedron => Shape::Polyhedron,
    }
}

fn drive(name: DriveName) -> Drive {
    match name {
        DriveName::Free => Drive::Free,
        DriveName::Prescribed => Drive::Prescribed,
    }
}

fn step_check(name: StepCheckName) -> StepCheck {
    match name {
        StepCheckName::Refuse => StepCheck::Refuse,
        StepCheckName::None => StepCheck::None,
    }
}

fn integrator(value: IntegratorFile) -> Integrator {
    match value {
        IntegratorFile::Name(IntegratorName::Verlet) => Integrator::Verlet,
        IntegratorFile::Name(IntegratorName::Theta) => Integrator::Theta(ThetaRule::default()),
        IntegratorFile::Rule { theta: file } => {
            let mut rule = ThetaRule::default();
            set(&mut rule.theta, file.theta);
            set(&mut rule.tolerance, file.tolerance);
            set(&mut rule.max_iterations, file.max_iterations);
            Integrator::Theta(rule)
        }
    }
}

fn step_after_failure(name: StepAfterFailureName) -> StepAfterFailure {
    match name {
        StepAfterFailureName::Keep => StepAfterFailure::Keep,
        StepAfterFailureName::Half => StepAfterFailure::Half,
    }
}

fn rotation_rule(value: RotationFile) -> RotationRule {
    match value {
        RotationFile::Midpoint => RotationRule::Midpoint,
        RotationFile::Theta(theta) => RotationRule::Theta(theta),
    }
}

fn time_step(value: TimeStepFile) -> TimeStep {
    match value {
        TimeStepFile::Fraction { fraction } => TimeStep::Fraction(fraction),
        TimeStepFile::Seconds { seconds } => TimeStep::Seconds(seconds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_alone_is_that_preset() {
        assert_eq!(parse("preset = \"sheet_3in_sphere\"").unwrap(), Scene::sheet_3in_sphere());
        assert_eq!(parse("preset = \"sheet_10in_cylinder\"").unwrap(), Scene::sheet_10in_cylinder());
        assert_eq!(parse("preset = \"turbine_disc_sector\"").unwrap(), Scene::turbine_disc_sector());
    }

    #[test]
    fn given_keys_override_and_the_rest_stays() {
        let text = "preset = \"sheet_3in_sphere\"\nseed = 7\ntime_step = { seconds = 1e-8 }\n\
                    [attachment]\nkind = \"four_corners\"\n[projectile]\nvelocity = [1.0, 2.0, 3.0]\n";
        let mut expected = Scene::sheet_3in_sphere();
        expected.seed = 7;
        expected.time_step = TimeStep::Seconds(1e-8);
        expected.attachment.kind = AttachmentKind::FourCorners;
        expected.projectile.velocity = [1.0, 2.0, 3.0];
        assert_eq!(parse(text).unwrap(), expected);
    }

    #[test]
    fn every_key_with_its_default_is_the_preset() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/every_key.toml");
        assert_eq!(read(&path).unwrap(), Scene::sheet_3in_sphere());
    }

    #[test]
    fn a_choice_written_the_wrong_way_is_told_the_right_one() {
        for (text, right) in [
            ("integrator = \"verlt\"", "\"verlet\", \"theta\", or {"),
            ("symmetry = \"quarter\"", "[symmetry] with mirror_x"),
            ("attachment = \"four_sides\"", "[attachment] with kind"),
            ("time_step = 2e-8", "{ seconds = 2e-8 }"),
        ] {
            let message = parse(&format!("preset = \"sheet_3in_sphere\"\n{text}\n")).unwrap_err().to_string();
            assert!(message.contains(right), "{message}");
        }
        let by_name = parse("preset = \"sheet_3in_sphere\"\nintegrator = \"theta\"").unwrap();
        assert_eq!(by_name.integrator, Integrator::Theta(ThetaRule::default()));
    }

    #[test]
    fn options_of_the_theta_rule_and_of_symmetry() {
        let text = "preset = \"sheet_3in_sphere\"\nintegrator = { theta = { tolerance = 1e-8 } }\n\
                    rotation_rule = { theta = 0.5 }\n[symmetry]\nmirror_x = true\n[yarn]\ndraw = \"yarn\"\n";
        let mut expected = Scene::sheet_3in_sphere();
        expected.integrator = Integrator::Theta(ThetaRule { tolerance: 1e-8, ..ThetaRule::default() });
        expected.rotation_rule = RotationRule::Theta(0.5);
        expected.symmetry.mirror_x = true;
        expected.yarn.draw = Draw::Yarn;
        assert_eq!(parse(text).unwrap(), expected);
    }

    #[test]
    fn shapes_and_their_dimensions() {
        let parsed = |shape: &str| parse(&format!("preset = \"sheet_3in_sphere\"\n[projectile]\n{shape}"));
        let body = |text: &str| parsed(text).unwrap().projectile;
        assert_eq!(body("shape = \"hemispherical_cylinder\"").shape, Shape::HemisphericalCylinder);
        let cuboid = body("shape = \"box\"\nsize = [0.01, 0.02, 0.03]");
        assert_eq!((cuboid.shape, cuboid.size), (Shape::Box, [0.01, 0.02, 0.03]));
        let faces = "faces = [[1.0, 0.0, 0.0, 0.01], [0.0, 1.0, 0.0, 0.02]]\nmoments = [1.0, 2.0, 3.0]";
        let given = body(&format!("shape = \"polyhedron\"\n{faces}"));
        assert_eq!(given.faces.in_use(), [[1.0, 0.0, 0.0, 0.01], [0.0, 1.0, 0.0, 0.02]]);
        assert_eq!((given.shape, given.moments), (Shape::Polyhedron, [1.0, 2.0, 3.0]));
        let sector = "disc_sector = { inner_radius = 0.01, outer_radius = 0.03, angle = 1.0, thickness = 0.008 }";
        let sector = format!("{sector}\nmass = 0.02");
        let made = prism::disc_sector(0.01, 0.03, 1.0, 0.008, 0.02).unwrap().projectile;
        let read = body(&sector);
        assert_eq!((read.shape, read.faces, read.moments, read.mass), (made.shape, made.faces, made.moments, 0.02));
        for (text, named) in [
            (format!("{sector}\nshape = \"sphere\""), "disc_sector"),
            (sector.replace("angle = 1.0", "angle = 3.2"), "disc_sector.angle: out of range"),
            (sector.replace("angle = 1.0", "turn = 1.0"), "`turn`"),
        ] {
            assert!(parsed(&text).unwrap_err().to_string().contains(named), "{named}");
        }
    }

    #[test]
    fn an_unknown_key_is_named() {
        for text in
            ["preset = \"sheet_3in_sphere\"\nwindow = 1.0", "preset = \"sheet_3in_sphere\"\n[sheet]\nwindow = 1.0"]
        {
            assert!(parse(text).unwrap_err().to_string().contains("`window`"));
        }
    }

    #[test]
    fn the_scenes_in_this_folder_are_sound() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let scene = read(&entry.unwrap().path()).unwrap();
            scene.step_limits().unwrap();
            count += 1;
        }
        assert!(count > 0);
    }
}
