//! `resolved KEY=VALUE ...`: one shot at one ply of resolved yarns, told as a line of JSON. `cloth.rs` has the method and its limits.

mod body;
mod cloth;
#[cfg(test)]
mod closed;
mod contact;

use std::fmt::Write;

use body::{Body, Shape};
use cloth::{Cloth, End, Sim};

/// What a shot is, besides cloth and body: the place of the hit from a crossing in spacings, and files for the shape of the yarns.
struct Shot {
    aim: [f64; 2],
    longest: f64,
    shape: Option<String>,
}

/// Kevlar KM2 S706 as fabrics/kevlar_km2_s706.toml has it, and the sphere of 5.556 mm; thickness and width are oneply.py's.
fn given(arguments: &[String]) -> Result<(Cloth, Body, Shot), String> {
    let mut cloth = Cloth {
        spacing: 0.0254 / 34.0, pieces: 3, yarns: [79, 79], stiffness: 84.62e9 * 4.62963e-8, line_mass: 6.66667e-5, critical_stretch: 1.0355,
        damage_rate: 2302.6, thickness: 0.115e-3, width: 0.55e-3, friction: 0.2, adhesion: 0.0, crimped: true, pinned: false, bare: false,
        viscosity: [0.06, 1.5, 0.06], slack: 0.02, damping: 0.2, hardness: 1.0, step: 0.6, pre_strain: [0.0; 2], clamp: End::Held,
    };
    let zero = [0.0; 3];
    let mut body = Body { shape: Shape::Sphere, radius: 2.778e-3, mass: 6.9e-4, friction: 0.0, at: zero, v: zero, old: zero, lost: zero, taken: 0.0 };
    let mut shot = Shot { aim: [0.0; 2], longest: 2e-3, shape: None };
    for argument in arguments {
        let (key, text) = argument.split_once('=').ok_or(format!("{argument}: must be KEY=VALUE"))?;
        if key == "shape" {
            shot.shape = Some(text.into());
            continue;
        }
        let value: f64 = text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or(format!("{key} = {text}: must be a finite number"))?;
        let count = || if value >= 1.0 && value <= 4096.0 { Ok(value as usize) } else { Err(format!("{key} = {value}: must be 1 to 4096")) };
        match key {
            "spacing" => cloth.spacing = value,
            "pieces" => cloth.pieces = count()?,
            "yarns" => cloth.yarns = [count()?; 2],
            "stiffness" => cloth.stiffness = value,
            "line_mass" => cloth.line_mass = value,
            "critical_stretch" => cloth.critical_stretch = value,
            "damage_rate" => cloth.damage_rate = value,
            "thickness" => cloth.thickness = value,
            "width" => cloth.width = value,
            "friction" => cloth.friction = value,
            "adhesion" => cloth.adhesion = value,
            "crimped" => cloth.crimped = value != 0.0,
            "pinned" => cloth.pinned = value != 0.0,
            "linear" => cloth.viscosity[0] = value,
            "quadratic" => cloth.viscosity[1] = value,
            "bending" => cloth.viscosity[2] = value,
            "slack" => cloth.slack = value,
            "damping" => cloth.damping = value,
            "hardness" => cloth.hardness = value,
            "step" => cloth.step = value,
            "clamp" => cloth.clamp = if value > 0.0 { End::Slips(value) } else { End::Held },
            "radius" => body.radius = value,
            "length" => body.shape = if value > 0.0 { Shape::Cylinder(value) } else { Shape::Sphere },
            "mass" => body.mass = value,
            "body_friction" => body.friction = value,
            "velocity" => body.v[2] = value,
            "x" => shot.aim[0] = value,
            "y" => shot.aim[1] = value,
            "longest" => shot.longest = value,
            _ => return Err(format!("{key}: no such key")),
        }
    }
    if cloth.pieces < 3 || !(cloth.crimped || cloth.pinned) {
        return Err("pieces must be at least 3, and straight yarns pinned".into());
    }
    let smallest = [cloth.spacing, cloth.stiffness, cloth.line_mass, cloth.thickness, cloth.width, cloth.step, body.radius, body.mass, body.v[2]];
    if smallest.iter().any(|v| *v <= 0.0) || cloth.width >= cloth.spacing || cloth.friction < 0.0 || body.friction < 0.0 {
        return Err("spacing, stiffness, line_mass, thickness, width, step, radius, mass and velocity must be above 0, width below spacing, friction at least 0".into());
    }
    Ok((cloth, body, shot))
}

/// The body where it just touches the cloth, above a place that is so many spacings from the crossing nearest to the middle.
fn placed(cloth: Cloth, mut body: Body, aim: [f64; 2]) -> Sim {
    for (a, aim) in aim.into_iter().enumerate() {
        let even = cloth.yarns[1 - a] % 2 == 0;
        body.at[a] = (aim + if even { 0.5 } else { 0.0 }) * cloth.spacing;
    }
    let reach = if body.shape == Shape::Sphere { body.radius } else { 0.0 };
    body.at[2] = -reach - if cloth.crimped { 1.2 } else { 0.5 } * cloth.thickness;
    body.old = body.v;
    Sim::new(cloth, body)
}

/// Shoots until the body stops, time is up, or the cloth does not slow it any more: by less than 0.5 % in 20 us.
fn shoot(sim: &mut Sim, longest: f64) -> (&'static str, f64) {
    let (first, start) = (sim.body.v[2], 0.5 * sim.body.mass * sim.body.v[2] * sim.body.v[2]);
    let (mut worst, mut checked) = (0.0_f64, (0.0, first));
    loop {
        sim.step();
        if sim.steps % 512 == 0 {
            worst = if sim.energy().is_finite() { worst.max((sim.energy() / start - 1.0).abs()) } else { f64::INFINITY };
        }
        let over = if sim.body.v[2] <= 0.0 {
            "arrested"
        } else if !(sim.body.v[2] < 10.0 * first) {
            "lost"
        } else if sim.time() > 30e-6 && sim.time() > checked.0 + 20e-6 && sim.body.v[2] > 0.995 * checked.1 {
            "through"
        } else if sim.time() > longest {
            "unknown"
        } else {
            if sim.time() > checked.0 + 20e-6 {
                checked = (sim.time(), sim.body.v[2]);
            }
            continue;
        };
        return (over, worst.max((sim.energy() / start - 1.0).abs()));
    }
}

/// Largest slip of a crossing along a yarn, spacings, and broken yarns.
fn damage(sim: &Sim) -> (f64, usize) {
    let p = sim.cloth.pieces as f64;
    let of = |c: usize, way: usize| {
        let number = if way == 0 { c % sim.cloth.yarns[1] } else { c / sim.cloth.yarns[1] };
        (sim.crossings[c].s[way] / p - (number + 1) as f64).abs()
    };
    let slip = (0..sim.crossings.len()).filter(|c| sim.crossings[*c].on).map(|c| of(c, 0).max(of(c, 1))).fold(0.0, f64::max);
    (slip, sim.broken.iter().filter(|b| **b).count())
}

/// The nodes of all yarns, a line each: yarn, x, y, z, and whether the bar after it is whole.
fn shape(sim: &Sim) -> String {
    let mut text = String::new();
    for yarn in 0..sim.ends.len() {
        let (_, first, n) = sim.yarn(yarn);
        for k in first..first + n {
            let [x, y, z] = [0, 1, 2].map(|a| sim.axes[a].at[k]);
            let _ = writeln!(text, "{yarn} {x:.7} {y:.7} {z:.7} {}", u8::from(sim.alpha[k] > 0.0));
        }
    }
    text
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (cloth, body, shot) = given(&arguments).unwrap_or_else(|error| {
        eprintln!("error: {error}");
        std::process::exit(2)
    });
    let mut sim = placed(cloth, body, shot.aim);
    let start = 0.5 * sim.body.mass * sim.body.v[2] * sim.body.v[2];
    let (end, residual) = shoot(&mut sim, shot.longest);
    let (slip, yarns) = damage(&sim);
    let (book, taken) = (&sim.book, (sim.kinetic().1 + sim.body.taken) / start);
    let first = book.first_break.map_or("null".into(), |t| format!("{t:e}"));
    println!(
        "{{\"end\": \"{end}\", \"velocity\": {}, \"time\": {:e}, \"steps\": {}, \"broken_bars\": {}, \"broken_yarns\": {yarns}, \"first_break\": {first}, \
         \"residual\": {residual:e}, \"dissipated\": {taken:e}, \"rubbed\": {:e}, \"rubbed_body\": {:e}, \"clamps\": {:e}, \"damage\": {:e}, \
         \"dropped\": {:e}, \"moved\": {:e}, \"slip\": {slip:e}, \"depth\": {:e}, \"depth_body\": {:e}, \"deflection\": {:e}}}",
        sim.body.v[2], sim.time(), sim.steps, book.broken, book.rubbed[0] / start, book.rubbed[1] / start, book.rubbed[2] / start, book.damage / start,
        book.dropped / start, book.moved / start, book.depth, book.on_body, sim.body.at[2] + sim.body.radius,
    );
    if let Some(path) = shot.shape
        && let Err(error) = std::fs::write(&path, shape(&sim))
    {
        eprintln!("error: {path}: {error}");
        std::process::exit(1)
    }
}
