//! Keys of scene files from which parameters follow: the width of a sheet, a coarser network of its fabric, a
//! projectile of a material and where it hits.
//! Meaning and defaults: data/fabrics/README.md. A file that gives one of these and a parameter that follows
//! from it is refused.

use crate::density::{LIGHTEST, density, volume};
use crate::notes::unlikely_body;
use crate::{BadKey, Result, bad, polyhedron, reals, short, units};
use fabric_kernel::math::{abs, cos, length, round, sin};
use fabric_kernel::pose::{Pose, Vector, into_body, normalised};
use fabric_kernel::{Drive, Feature, MAX_FACES, Projectile, Scene, Shape, Solid};
use std::f64::consts::{FRAC_PI_2, TAU};
use toml::{Table, Value};

/// A key, its SI unit (that of a material is a name), and the parameters and keys that follow from it, which
/// are not given beside it.
pub type Key = (&'static str, &'static str, &'static [&'static str]);
/// The keys.
pub const KEYS: [Key; 14] = [
    ("sheet.width", "m", &["sheet.nodes_x", "sheet.nodes_y"]),
    ("sheet.width_y", "m", &["sheet.nodes_y"]),
    ("sheet.yarns_per_bar", "1", NETWORK),
    ("projectile.diameter", "m", &["projectile.radius"]),
    ("projectile.material", "", &["projectile.density", "projectile.mass"]),
    ("projectile.density", "kg/m3", &["projectile.mass"]),
    (FSP, "", &[PLANES, "projectile.moments", "projectile.vertices", "projectile.material", "projectile.density"]),
    ("projectile.calibre", "", &["projectile.mass", "projectile.diameter"]),
    ("projectile.vertices", "m", &[PLANES, "projectile.moments"]),
    ("aim.point", "m", &["projectile.position"]),
    ("aim.stand_off", "m", &["projectile.position"]),
    ("aim.angle", "rad", &["projectile.position", "projectile.velocity"]),
    ("aim.towards", "rad", &["projectile.position", "projectile.velocity"]),
    ("aim.speed", "m/s", &["projectile.position", "projectile.velocity"]),
];
const NETWORK: &[&str] =
    &["sheet.spacing", "sheet.spacing_y", "sheet.node_mass", "sheet.yarn_area", "sheet.yarn_area_y"];

/// Key of a fragment simulator, a shape that the kernel has as a polyhedron.
pub const FSP: &str = "projectile.shape = \"fsp\"";
const PLANES: &str = "projectile.faces.planes";

/// Materials of projectiles with their densities and sources.
const MATERIALS: &str = include_str!("materials.toml");

/// Sizes of fragment simulators with their sources.
const FRAGMENTS: &str = include_str!("fragments.toml");

/// Most vertices that a file may give.
const MOST_VERTICES: usize = 64;

/// Keys and their values.
pub type Given = Vec<(String, Value)>;

/// What is given twice, by its names.
pub fn conflicts(given: &Given) -> impl Iterator<Item = BadKey> {
    let named = |key: &str| given.iter().any(|(name, _)| name == key);
    let pairs = KEYS.iter().flat_map(|(key, _, others)| others.iter().map(move |other| (*key, *other)));
    pairs.filter(move |(key, other)| named(key) && named(other)).map(|(key, other)| BadKey {
        key: key.to_string(),
        text: format!("{key} and {other}: one follows from the other, so give one of them"),
    })
}

fn of<'a>(given: &'a Given, key: &str) -> Option<&'a Value> {
    given.iter().find(|(name, _)| name == key).map(|(_, value)| value)
}

/// The number of a key, if it is given; `range` says what is allowed.
fn within(given: &Given, key: &str, allowed: impl Fn(f64) -> bool, range: &str) -> Result<Option<f64>> {
    let Some(value) = of(given, key) else { return Ok(None) };
    let si = KEYS.iter().find(|(name, ..)| *name == key).map_or("1", |(_, si, _)| si);
    match units::number(value, si) {
        Some(number) if allowed(number) => Ok(Some(number)),
        Some(number) => {
            let others = units::plain(value).map_or(Vec::new(), |number| units::likely(number, si, &allowed));
            let asked = others.first().map_or(String::new(), |other| format!("; did you mean {other}?"));
            bad(key, format!("{key} = {number}: must be {range}{asked}"))
        }
        None => units::refused(key, value, si, "", &allowed),
    }
}

fn positive(given: &Given, key: &str) -> Result<Option<f64>> {
    within(given, key, |x| x > 0.0 && x.is_finite(), "greater than 0 and finite")
}

/// The radius of a diameter; of a fragment simulator the diameter is no radius.
pub fn radius(given: &Given) -> Result<Option<f64>> {
    if of(given, FSP).is_some() {
        return Ok(None);
    }
    Ok(positive(given, "projectile.diameter")?.map(|diameter| 0.5 * diameter))
}

/// Force at which one yarn of the scene breaks, N: that of its law at the critical stretch U, E A (U^2 - 1)/2
/// U, of a bar of one ply.
pub fn yarn_strength(scene: &Scene) -> f64 {
    let stretch = scene.yarn.critical_stretch;
    scene.yarn.modulus_mean * scene.sheet.yarn_area * (0.5 * (stretch * stretch - 1.0)) * stretch
}

/// How many yarns a bar stands for, as the file says it.
pub fn yarns_per_bar(given: &Given) -> f64 {
    of(given, "sheet.yarns_per_bar").and_then(|value| units::number(value, "1")).unwrap_or(1.0)
}

/// Force for "0.4 of the yarn" or "40 % of the yarn", a part of its strength, N a yarn; None otherwise.
pub fn hold(value: &Value, given: &Given, scene: &Scene) -> Result<Option<f64>> {
    let Some(part) = value.as_str().and_then(|text| text.strip_suffix("of the yarn")) else { return Ok(None) };
    match part.trim().parse::<f64>().ok().or_else(|| units::number(&part.trim().into(), "1")) {
        // The area is that of a bar by now.
        Some(part) if (0.0..=100.0).contains(&part) => Ok(Some(part * yarn_strength(scene) / yarns_per_bar(given))),
        _ => bad(
            "attachment.hold",
            format!("attachment.hold = {value}: must be from 0 to 100 of the yarn, as in \"40 % of the yarn\""),
        ),
    }
}

/// Network and number of nodes. `counted`: whether the file has the number of nodes along x and along y.
pub fn sheet(given: &Given, scene: &mut Scene, counted: [bool; 2]) -> Result<()> {
    let before = scene.half_size();
    let yarns = within(given, "sheet.yarns_per_bar", |n| (0.1..=100.0).contains(&n), "from 0.1 to 100")?;
    if let Some(n) = yarns {
        let sheet = &mut scene.sheet;
        (sheet.spacing, sheet.spacing_y, sheet.node_mass) =
            (sheet.spacing * n, sheet.spacing_y * n, sheet.node_mass * (n * n));
        (sheet.yarn_area, sheet.yarn_area_y) = (sheet.yarn_area * n, sheet.yarn_area_y * n);
        if scene.back.plies > 0 {
            let back = &mut scene.back;
            (back.node_mass, back.yarn_area, back.yarn_area_y) =
                (back.node_mass * (n * n), back.yarn_area * n, back.yarn_area_y * n);
        }
    }
    let spacings = scene.spacings();
    let nodes = |k: usize, width: f64| round(width / spacings[k]) + 1.0;
    let width = |k: usize, key: &str| {
        // So many in both directions are the most that the kernel counts.
        let allowed = |width| (2.0..=65_535.0).contains(&nodes(k, width));
        within(given, key, allowed, &format!("as wide as 2 to 65535 nodes, {:.4} mm apart", 1e3 * spacings[k]))
    };
    let width_x = width(0, "sheet.width")?;
    let width_y = width(1, "sheet.width_y")?.or(width_x);
    for (k, width) in [width_x, width_y].into_iter().enumerate() {
        // A coarser network keeps the size of the sheet.
        let kept = (yarns.is_some() && !counted[k]).then_some(2.0 * before[k]);
        let Some(width) = width.or(kept) else { continue };
        *[&mut scene.sheet.nodes_x, &mut scene.sheet.nodes_y][k] = nodes(k, width) as u32;
    }
    // A ring has as many nodes as its radius takes, and then the radius that they close.
    let sheet = &mut scene.sheet;
    if sheet.closed && sheet.radius > 0.0 && !counted[0] && width_x.is_none() {
        let nodes = round(TAU * sheet.radius / sheet.spacing);
        if !(3.0..=65_535.0).contains(&nodes) {
            let text =
                format!("sheet.radius = {}: a ring of it has {nodes} nodes; there may be 3 to 65535", sheet.radius);
            return bad("sheet.radius", text);
        }
        sheet.nodes_x = nodes as u32;
        scene.sheet.radius = scene.closed_radius();
    }
    Ok(())
}

/// Density of a material, kg/m^3.
fn density_of(name: &Value) -> Result<f64> {
    let known: Table = MATERIALS.parse()?;
    let material = name.as_str().and_then(|name| known.get(name)?.get("density"));
    material.and_then(|density| units::number(density, "kg/m3")).map_or_else(
        || {
            let names = known.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let name = short(&name.to_string());
            let text = format!("projectile.material = {name}: one of {names}; of another give projectile.density");
            bad("projectile.material", text)
        },
        Ok,
    )
}

/// The line of a scene file from which the projectile's mass follows, after its source; none if the mass is
/// another one.
pub fn written_material(textiles: &Table, scene: &Scene) -> Option<String> {
    let body = textiles.get("projectile")?.as_table()?;
    let given = body.iter().map(|(key, value)| (format!("projectile.{key}"), value.clone())).collect();
    let mut again = *scene;
    projectile(&given, &mut again, false).ok()?;
    let same = again.projectile.mass.to_bits() == scene.projectile.mass.to_bits();
    let source = body.get("material").and_then(Value::as_str).map_or(String::new(), |name| {
        MATERIALS
            .lines()
            .find(|line| line.starts_with(&format!("{name} = ")))
            .map_or(String::new(), |line| format!("# {line}\n"))
    });
    same.then(|| format!("# The mass, {} kg, follows from it.\n{source}{body}", again.projectile.mass))
}

/// Gives the projectile faces, mass and moments, if the file has a fragment simulator or vertices, and
/// returns whether it has. `density` and
/// `mass`: those of the file, kg/m^3 and kg; `steel`: density of a fragment simulator.
fn shape(given: &Given, body: &mut Projectile, density: Option<f64>, mass: Option<f64>, steel: f64) -> Result<bool> {
    const VERTICES: &str = "projectile.vertices";
    if of(given, FSP).is_some() {
        let (mass, diameter) = size(given, mass)?;
        let Some(planes) = polyhedron::chisel(mass / steel, diameter) else {
            let text = format!(
                "{mass} kg of steel are too short for a chisel nose {diameter} m wide: give another mass or diameter"
            );
            return bad("projectile.diameter", format!("projectile.diameter: {text}"));
        };
        polyhedron::set(body, &planes, |volume| mass / volume);
        return Ok(true);
    }
    if of(given, "projectile.calibre").is_some() {
        return bad("projectile.calibre", "projectile.calibre: read with shape = \"fsp\" only".into());
    }
    let Some(value) = of(given, VERTICES) else { return Ok(false) };
    let refused = |text: String| bad(VERTICES, format!("{VERTICES}: {text}"));
    let mut numbers = Vec::new();
    if reals(value, &[MOST_VERTICES, 3], &|_| "m", &mut numbers).is_none() || !numbers.iter().all(|x| x.is_finite()) {
        return refused(format!("must be at most {MOST_VERTICES} rows of 3 numbers{}", units::expected("m")));
    }
    if body.shape != Shape::Polyhedron {
        return refused("read with shape = \"polyhedron\" only".into());
    }
    let Some(weighed) = density.or(mass) else {
        return refused("no mass: give projectile.material, density or mass".into());
    };
    let planes = polyhedron::hull(&numbers);
    if !(4..=MAX_FACES).contains(&planes.len()) {
        return refused(format!("the convex hull has {} faces; there may be 4 to {MAX_FACES}", planes.len()));
    }
    polyhedron::set(body, &planes, |volume| if density.is_some() { weighed } else { weighed / volume });
    Ok(true)
}

/// Mass, kg, and diameter, m, of a fragment simulator: of its calibre, or as they are given.
fn size(given: &Given, mass: Option<f64>) -> Result<(f64, f64)> {
    let key = "projectile.calibre";
    let known: Table = FRAGMENTS.parse()?;
    let calibre = of(given, key);
    let number = |part: &str, si| units::number(known.get(calibre?.as_str()?)?.get(part)?, si);
    let found = match calibre {
        Some(_) => number("mass", "kg").zip(number("diameter", "m")),
        None => mass.zip(positive(given, "projectile.diameter")?),
    };
    let names = known.keys().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let value = calibre.map_or("missing".into(), |value| short(&value.to_string()));
    let text = format!("{key}: {value}: one of {names}; of another fragment give projectile.mass and diameter");
    found.map_or_else(|| bad(key, text), Ok)
}

/// Shape of a polyhedron, mass of a material, and where the projectile hits. `weighed`: whether the file has
/// the mass.
pub fn projectile(given: &Given, scene: &mut Scene, weighed: bool) -> Result<()> {
    let material = of(given, "projectile.material").map(density_of).transpose()?;
    let density = positive(given, "projectile.density")?.or(material);
    let mass = weighed.then_some(scene.projectile.mass);
    if !shape(given, &mut scene.projectile, density, mass, density_of(&"steel".into())?)?
        && let Some(density) = density
    {
        let Some(volume) = volume(&scene.projectile) else {
            let key = if material.is_some() { "projectile.material" } else { "projectile.density" };
            return bad(
                key,
                format!("{key}: not with a polyhedron of faces, whose mass and moments are given; with its vertices"),
            );
        };
        scene.projectile.mass = density * volume;
    }
    if !given.iter().any(|(name, _)| name.starts_with("aim.")) {
        return Ok(());
    }
    let right = "from 0 to below 90 deg; a number without a unit is in rad";
    let angle = within(given, "aim.angle", |x| (0.0..FRAC_PI_2).contains(&x), right)?;
    let towards = within(given, "aim.towards", f64::is_finite, "finite")?;
    let speed = positive(given, "aim.speed")?;
    let mut point = Vec::new();
    let value = of(given, "aim.point").cloned().unwrap_or_else(|| vec![0, 0].into());
    if reals(&value, &[2], &|_| "m", &mut point).is_none() {
        let meant = units::meant(&value, "m", &f64::is_finite);
        let value = short(&value.to_string());
        return bad(
            "aim.point",
            format!("aim.point = {value}: must be an array of 2 numbers{}{meant}", units::expected("m")),
        );
    }
    if angle.or(towards).or(speed).is_some() {
        let speed = speed.unwrap_or_else(|| length(scene.projectile.velocity));
        let (angle, towards) = (angle.unwrap_or(0.0), towards.unwrap_or(0.0));
        let along = speed * sin(angle);
        let [x, y, z] = [along * cos(towards), along * sin(towards), speed * cos(angle)];
        let velocity = match hoop_angle(scene, point[0]) {
            Some(hoop) => [x * cos(hoop) + z * sin(hoop), y, z * cos(hoop) - x * sin(hoop)],
            None => [x, y, z],
        };
        scene.projectile.velocity = Pose::of_sheet(&scene.sheet).vector_out(velocity);
    }
    let stand_off = within(given, "aim.stand_off", |x| x >= 0.0 && x.is_finite(), "at least 0")?.unwrap_or(0.0);
    scene.projectile.position = aimed(scene, "aim.point", [point[0], point[1]], stand_off)?;
    Ok(())
}

/// The angle about the axis of a curved sheet, rad, so far along its hoop, m.
fn hoop_angle(scene: &Scene, along: f64) -> Option<f64> {
    Feature::Curved.is_in(scene).then(|| along / scene.sheet.radius)
}

/// Where the projectile's centre must be, m, in the host's frame, so that it has this distance from the first
/// ply in its way with its foremost point, and flies through a point of it, given in the sheet's plane, or
/// along its hoop and its axis, from its middle, m.
///
/// # Errors
/// A body that is too large for the ring that it starts in. A point that lies more than a mesh beside the
/// sheet, by its `key`: a millimetre is easily written as a metre. A velocity that leads along the sheet.
pub fn aimed(scene: &Scene, key: &str, point: [f64; 2], stand_off: f64) -> Result<[f64; 3]> {
    let ([x, y], [half_x, half_y]) = (point, scene.half_size());
    let mesh = scene.largest_spacing();
    if !(abs(x) <= half_x + mesh && abs(y) <= half_y + mesh) {
        let reach = format!(
            "the sheet reaches {half_x:.4} m and {half_y:.4} m from its middle; a number without a unit is in m"
        );
        return bad(key, format!("{key}: ({x}, {y}) m lies beside the sheet; {reach}"));
    }
    let (body, pose) = (&scene.projectile, Pose::of_sheet(&scene.sheet));
    let velocity = pose.vector_in(body.velocity);
    let up = velocity[2] > 0.0;
    let ahead = Vector::new(0.0, 0.0, if up { 1.0 } else { -1.0 });
    let orientation = normalised(pose.orientation_in(body.orientation));
    if let Some(hoop) = hoop_angle(scene, x) {
        let solid = Solid::of_scene(scene);
        let support = |n: Vector| solid.support(&into_body(&orientation, &n));
        let outwards = velocity[0] * sin(hoop) + velocity[2] * cos(hoop) > 0.0;
        let radius = scene.sheet.radius + if outwards { 0.0 } else { scene.stack_height() };
        let position = before_curve(radius, [hoop, y], velocity, [stand_off, solid.reach()], support);
        let far =
            || format!("{key}: the projectile does not fit into the sheet on its way there; give projectile.position");
        return position.map_or_else(|| bad(key, far()), |position| Ok(pose.point_out(position)));
    }
    let reach = Solid::of_scene(scene).support(&into_body(&orientation, &ahead)) + stand_off;
    let height = if up { 0.0 } else { scene.stack_height() };
    let back = -reach / abs(velocity[2]);
    let position = [x + velocity[0] * back, y + velocity[1] * back, height - ahead.z * reach];
    let position = pose.point_out(position);
    if position.iter().all(|x| x.is_finite()) {
        return Ok(position);
    }
    bad("projectile.velocity", "projectile.velocity: does not lead to the sheet".into())
}

/// Moves the projectile so that it is as far from the cloth as it was before that became another thickness.
pub fn keep_distance(scene: &mut Scene, before: &Scene) {
    let thicker = [scene, before].map(|scene| 0.5 * scene.thickness());
    let (by, pose) = (thicker[0] - thicker[1], Pose::of_sheet(&scene.sheet));
    let [x, y, z] = pose.point_in(scene.projectile.position);
    let radius = length([x, 0.0, z]);
    let position = if !Feature::Curved.is_in(scene) {
        let beyond = by + scene.stack_height() - before.stack_height();
        [x, y, if z < 0.0 { z - by } else { z + beyond }]
    } else if radius > 0.0 {
        let scale = 1.0 + if radius < scene.sheet.radius { -by } else { by } / radius;
        [x * scale, y, z * scale]
    } else {
        return;
    };
    let position = pose.point_out(position);
    if position.iter().all(|x| x.is_finite()) {
        scene.projectile.position = position;
    }
}

/// Where a body must be on its way to a place of a curved sheet, by its angle and along the axis, so that all
/// of it is within the sheet's cylinder, or outside of it, by the stand-off. `support`: how far it reaches
/// along a direction; `reach`: along any. None if there is no such place.
fn before_curve(
    radius: f64,
    [hoop, y]: [f64; 2],
    velocity: [f64; 3],
    [stand_off, reach]: [f64; 2],
    support: impl Fn(Vector) -> f64,
) -> Option<[f64; 3]> {
    const DIRECTIONS: u32 = 1440;
    let ([vx, vy, vz], [sine, cosine]) = (velocity, [sin(hoop), cos(hoop)]);
    let outwards = vx * sine + vz * cosine;
    let at = |t: f64| [radius * sine - vx * t, y - vy * t, radius * cosine - vz * t];
    // Greatest over the directions: how far the body reaches from the axis, or the nearest plane before it.
    // Convex in the time t.
    let far = |t: f64| {
        let ([x, _, z], side) = (at(t), if outwards > 0.0 { 1.0 } else { -1.0 });
        let turns = (0..DIRECTIONS).map(|k| f64::from(k) * (TAU / f64::from(DIRECTIONS)));
        let reaches = turns.map(|turn| {
            let (a, b) = (sin(turn), cos(turn));
            x * a + z * b + side * support(Vector::new(side * a, 0.0, side * b))
        });
        reaches.fold(f64::NEG_INFINITY, f64::max)
    };
    // The directions are so far apart that a corner may be missed by this.
    let missed = radius * (1.0 - cos(0.5 * TAU / f64::from(DIRECTIONS)));
    let is_clear =
        |t: f64| if outwards > 0.0 { far(t) + missed <= radius - stand_off } else { far(t) >= radius + stand_off };
    // The place nearest to the axis, or one beyond everything.
    let beyond = 2.0 * radius + stand_off + reach;
    let mut ends = [0.0, if outwards > 0.0 { radius * outwards / (vx * vx + vz * vz) } else { beyond / -outwards }];
    if !is_clear(ends[1]) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (ends[0] + ends[1]);
        ends[usize::from(is_clear(middle))] = middle;
    }
    Some(at(ends[1]))
}

/// A sentence on a file that says what flies but not where it begins: then place and speed are those of the
/// preset.
pub fn unplaced(file: &Table, scene: &Scene) -> Option<String> {
    let body = file.get("projectile")?.as_table()?;
    let sized = ["shape", "radius", "diameter", "length", "size", "sector", "vertices"]
        .iter()
        .any(|key| body.contains_key(*key));
    let speed = length(scene.projectile.velocity);
    (sized && !body.contains_key("position") && !file.contains_key("aim")).then(|| {
        let of = if body.contains_key("velocity") {
            "begins where the preset's does"
        } else {
            "begins where the preset's does and as fast"
        };
        format!("the projectile {of} ({speed} m/s): give [aim], as in [aim] speed = \"150 m/s\"")
    })
}

/// Refuses a free projectile that flies away from the sheet or along it, and one that is lighter than any
/// body of its size.
pub fn refuse_what_cannot_be_meant(scene: &Scene) -> Result<()> {
    let (body, pose) = (&scene.projectile, Pose::of_sheet(&scene.sheet));
    let (height, speed) = (pose.point_in(body.position)[2], pose.vector_in(body.velocity)[2]);
    let away = (height < 0.0 && speed <= 0.0) || (height > scene.stack_height() && speed >= 0.0);
    if away && !Feature::Curved.is_in(scene) && scene.drive == Drive::Free && length(body.velocity) > 0.0 {
        let ([x, y, z], [u, v, w]) = (body.position, body.velocity);
        let text = format!(
            "projectile.velocity = [{u}, {v}, {w}]: never leads from projectile.position = [{x}, {y}, {z}] to the sheet; turn one of the two \
             round, or give [aim]"
        );
        return bad("projectile.velocity", text);
    }
    let key = match body.shape {
        Shape::Box => "projectile.size",
        Shape::Polyhedron => "projectile.faces.planes",
        Shape::DiscSector => "projectile.sector.outer_radius",
        _ => "projectile.radius",
    };
    match unlikely_body(scene) {
        Some(note) if density(body) < LIGHTEST => bad(key, format!("{key}: {note}")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{parse, textile, write};
    use std::f64::consts::PI;

    const PRESET: &str = "preset = \"sheet_3in_sphere\"\n";

    #[track_caller]
    fn of(text: &str) -> Scene {
        parse(&format!("{PRESET}{text}\n")).unwrap()
    }

    #[track_caller]
    fn close(value: f64, expected: f64) {
        assert!((value / expected - 1.0).abs() < 1e-12, "{value:e} is not {expected:e}");
    }

    /// The scene of data/fabrics/README.md with a data sheet's words is that of its numbers, to the last bit.
    #[test]
    fn a_scene_in_words_is_the_scene_in_numbers() {
        let words = "fabric = \"kevlar_km2_s706\"\nsheet.width = \"101 mm\"\nprojectile.diameter = \"5.556 mm\"\nprojectile.mass = \"0.69 g\"\n\
                     aim.speed = \"150 m/s\"";
        let numbers = "[fabric]\nname = \"kevlar_km2_s706\"\n[sheet]\nnodes_x = 136\nnodes_y = 136\n[projectile]\nradius = 2.778e-3\n\
                       mass = 6.9e-4\nposition = [0, 0, -2.778e-3]\nvelocity = [0, 0, 150]";
        let (words, mut numbers) = (of(words), of(numbers));
        // The foremost point touches the face of the cloth.
        numbers.projectile.position[2] = -(2.778e-3 + 0.5 * words.sheet.thickness);
        assert_eq!(words, numbers);
    }

    #[test]
    fn a_coarser_network_keeps_weight_stiffness_and_size_of_the_fabric() {
        let text = "stack.plies = 2\nback.plies = 1\nback_fabric = \"zylon_as_500_35\"\nsheet.width = \"100 mm\"\nsheet.width_y = \"60 mm\"\n\
                    fabric = { name = \"kevlar_km2_s706\", warp.count = \"30 /in\" }";
        let (fine, coarse) = (of(text), of(&format!("{text}\nsheet.yarns_per_bar = 2")));
        let per_area = |scene: &Scene| {
            let ([h_x, h_y], sheet, back) = (scene.spacings(), scene.sheet, scene.back);
            [sheet.node_mass / (h_x * h_y), sheet.yarn_area / h_y, back.node_mass / (h_x * h_y), back.yarn_area / h_y]
        };
        per_area(&fine).iter().zip(per_area(&coarse)).for_each(|(fine, coarse)| close(coarse, *fine));
        close(coarse.spacings()[1], 2.0 * 0.0254 / 30.0);
        // To half a spacing of 1.49 mm along x and 1.69 mm along y.
        let [half_x, half_y] = coarse.half_size();
        assert!((half_x - 0.05).abs() < 0.38e-3 && (half_y - 0.03).abs() < 0.43e-3, "{half_x} {half_y}");
        assert_eq!((fine.sheet.nodes_x, coarse.sheet.nodes_x), (135, 68));
        // A sheet without a width has that of the preset; of a scene that has its back fabric already that,
        // too.
        let mut again = fine;
        again.attachment.hold = 20.0;
        let table = "sheet.yarns_per_bar = 2".parse().unwrap();
        crate::apply(&mut again, table).unwrap();
        per_area(&fine).iter().zip(per_area(&again)).for_each(|(fine, coarse)| close(coarse, *fine));
        assert_eq!((again.sheet.nodes_x, again.attachment.hold), (68, 40.0));
    }

    #[test]
    fn the_mass_is_that_of_the_volume() {
        let mass = |shape: &str| {
            of(&format!("projectile.density = \"2 g/cm3\"\n{shape}\nprojectile.position = [0, 0, -1]")).projectile.mass
        };
        close(mass("projectile.diameter = \"10 mm\""), 2000.0 * PI * 1e-6 / 6.0);
        let round = "projectile.radius = \"5 mm\"\nprojectile.length = \"20 mm\"";
        close(mass(&format!("projectile.shape = \"cylinder\"\n{round}")), 2000.0 * PI * 0.5e-6);
        // A cylinder of 15 mm and half a sphere.
        let nose = PI * (25e-6 * 15e-3 + 2.0 / 3.0 * 125e-9);
        close(mass(&format!("projectile.shape = \"hemispherical_cylinder\"\n{round}")), 2000.0 * nose);
        close(mass("projectile.shape = \"box\"\nprojectile.size = [\"1 cm\", 0.02, \"30 mm\"]"), 0.012);
        // By the corners of the kernel's polygon, whose area is half the sum of their cross products.
        let (outer, inner, angle) = (0.03, 0.01, PI / 3.0);
        let rim = (0..=8).map(|k| (outer, angle * f64::from(k) / 8.0));
        let corners: Vec<_> =
            rim.chain([(inner, angle), (inner, 0.0)]).map(|(r, a)| [r * cos(a), r * sin(a)]).collect();
        let next = |k: usize| corners[(k + 1) % corners.len()];
        let area: f64 =
            (0..corners.len()).map(|k| 0.5 * (corners[k][0] * next(k)[1] - next(k)[0] * corners[k][1])).sum();
        let sector = "projectile.shape = \"disc_sector\"\nprojectile.sector = { inner_radius = \"1 cm\", outer_radius = \"3 cm\", \
                      angle = \"60 deg\", thickness = \"8 mm\" }";
        close(mass(sector), 2000.0 * 8e-3 * area);
        close(
            of("projectile.material = \"steel\"").projectile.mass,
            7850.0 * 4.0 / 3.0 * PI * 0.00635 * 0.00635 * 0.00635,
        );
        let faces = format!("{PRESET}projectile.shape = \"polyhedron\"\nprojectile.material = \"steel\"");
        assert!(parse(&faces).unwrap_err().to_string().starts_with("projectile.material: not with a polyhedron"));
    }

    #[test]
    fn a_projectile_is_placed_where_it_hits() {
        let flown = |text: &str| {
            let body = of(text).projectile;
            (body.position, body.velocity)
        };
        assert_eq!(flown("[aim]"), flown(""));
        let (position, velocity) = flown(
            "[aim]\npoint = [\"10 mm\", \"-5 mm\"]\nangle = \"30 deg\"\ntowards = \"90 deg\"\nspeed = 80\nstand_off = \"1 mm\"",
        );
        let (sine, cosine) = (0.5, fabric_kernel::math::sqrt(0.75));
        close(velocity[1], 80.0 * sine);
        close(velocity[2], 80.0 * cosine);
        assert!(velocity[0].abs() < 1e-14);
        close(position[2], -7.35e-3);
        close(position[1], -5e-3 - 7.35e-3 * sine / cosine);
        close(position[0], 10e-3);
        // Another sheet, another way up: the same in its frame.
        let aim = "[aim]\nangle = \"30 deg\"\nstand_off = \"1 mm\"";
        let turned = of(&format!("sheet.position = [1, 2, 3]\nsheet.orientation = [0.6, 0.8, 0, 0]\n{aim}"));
        let pose = Pose::of_sheet(&turned.sheet);
        let own = [pose.point_in(turned.projectile.position), pose.vector_in(turned.projectile.velocity)].concat();
        let (position, velocity) = flown(aim);
        let other = [position, velocity].concat();
        assert!(own.iter().zip(other).all(|(own, other)| (own - other).abs() < 1e-12 * (1.0 + other.abs())), "{own:?}");
    }

    #[test]
    fn a_scene_written_back_keeps_its_fabric_and_the_sources() {
        let text = "fabric = \"kevlar_km2_s706\"\nstack.plies = 2\n[yarn]\nmodulus_mean = \"140.21 GPa\"\n\
                    [back_fabric]\nname = \"zylon_as_500_35\"\ncount = { value = 30, unit = \"1/in\", source = \"counted\" }\n\
                    [back]\nplies = 1\nmodulus_mean = \"140.21 GPa\"\n\
                    [projectile]\ndiameter = \"5 mm\"\nmaterial = \"steel\"";
        let textiles = textile::of(&crate::table_of(text).unwrap());
        let written = write("sheet_3in_sphere", &of(text), &textiles);
        assert_eq!(parse(&written).unwrap(), of(text));
        let again = textile::of(&crate::table_of(&written).unwrap());
        assert_eq!(textile::names(&again), ["kevlar_km2_s706", "zylon_as_500_35"].map(|name| Some(name.to_string())));
        for part in [
            "source = \"counted\"",
            "# modulus = { value = 84.62, unit = \"GPa\", mark = \"2\", source = ",
            "\nmaterial = \"steel\"\n",
            "# steel = {",
        ] {
            assert!(written.contains(part), "{written}");
        }
        assert_eq!(write("sheet_3in_sphere", &parse(&written).unwrap(), &again), written);
        let mut heavier = of(text);
        heavier.projectile.mass *= 2.0;
        assert_eq!(parse(&write("sheet_3in_sphere", &heavier, &textiles)).unwrap(), heavier);
    }

    #[test]
    fn every_material_has_a_source_and_every_key_is_on_the_page() {
        for (name, material) in MATERIALS.parse::<Table>().unwrap() {
            let source = material["source"].as_str().unwrap();
            assert!(
                density_of(&name.clone().into()).unwrap() > 1e3 && source.len() > 5 && material["mark"].is_str(),
                "{name}"
            );
        }
        let page = include_str!("../fabrics/README.md");
        KEYS.iter().for_each(|(key, ..)| assert!(page.contains(&format!("`{key}`")), "{key} is not on the page"));
    }
}
