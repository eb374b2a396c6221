//! `resolved KEY=VALUE ...`: one shot at one ply of resolved yarns, told as a line of JSON. `cloth.rs` has
//! the method and its limits.

#![allow(clippy::disallowed_methods)] // Its bits need not be those of every target.

mod body;
#[cfg(test)]
mod closed;
mod cloth;
mod contact;

use std::collections::BTreeMap;
use std::fmt::Write;

use body::{Body, Shape};
use cloth::{Cloth, End, Sim};

/// Shot without its cloth and body: where it hits, in spacings from a crossing, its longest time, and a
/// file for the shape of the yarns.
struct Shot {
    aim: [f64; 2],
    longest: f64,
    shape: Option<String>,
}

/// What the arguments say. Without them the fabric is data/fabrics/kevlar_km2_s706.toml and the body a sphere
/// of 5.556 mm.
fn given(arguments: &[String]) -> Result<(Cloth, Body, Shot), String> {
    let mut left = BTreeMap::new();
    for argument in arguments {
        let (key, text) = argument.split_once('=').ok_or(format!("{argument}: must be KEY=VALUE"))?;
        left.insert(key, text);
    }
    let shape = left.remove("shape").map(String::from);
    let mut take = |key: &str, default: f64, least: f64, most: f64| match left.remove(key).map(str::parse) {
        None => Ok(default),
        Some(Ok(value)) if value >= least && value <= most => Ok(value),
        Some(_) => Err(format!("{key}: must be a number from {least:e} to {most:e}")),
    };
    let (tiny, huge) = (1e-12, 1e12);
    let yarns = take("yarns", 79.0, 1.0, 4096.0)? as usize;
    let clamp = take("clamp", 0.0, 0.0, huge)?;
    let spacing = take("spacing", 0.0254 / 34.0, tiny, huge)?;
    let crimped = take("crimped", 1.0, 0.0, 1.0)? != 0.0;
    let cloth = Cloth {
        spacing,
        pieces: take("pieces", 3.0, 3.0, 64.0)? as usize,
        yarns: [yarns; 2],
        stiffness: take("stiffness", 84.62e9 * 4.62963e-8, tiny, huge)?,
        line_mass: take("line_mass", 6.66667e-5, tiny, huge)?,
        critical_stretch: take("critical_stretch", 1.0355, 1.0, 2.0)?,
        damage_rate: take("damage_rate", 2302.6, 3.0, huge)?,
        thickness: take("thickness", 0.115e-3, tiny, 0.5 * spacing)?,
        width: take("width", 0.55e-3, tiny, 0.99 * spacing)?,
        friction: take("friction", 0.2, 0.0, 10.0)?,
        adhesion: take("adhesion", 0.0, 0.0, huge)?,
        crimped,
        // Straight yarns would lie in each other.
        pinned: take("pinned", f64::from(u8::from(!crimped)), f64::from(u8::from(!crimped)), 1.0)? != 0.0,
        bare: false,
        viscosity: [
            take("linear", 0.06, 0.0, 1.0)?,
            take("quadratic", 1.5, 0.0, 3.0)?,
            take("bending", 0.06, 0.0, 0.1)?,
        ],
        slack: take("slack", 0.02, 0.0, 1.0)?,
        damping: take("damping", 0.2, 0.0, 1.0)?,
        step: take("step", 0.6, 0.01, 0.95)?,
        pre_strain: [0.0; 2],
        clamp: if clamp > 0.0 { End::Slips(clamp) } else { End::Held },
    };
    let length = take("length", 0.0, 0.0, huge)?;
    let body = Body {
        shape: if length > 0.0 { Shape::Cylinder(length) } else { Shape::Sphere },
        radius: take("radius", 2.778e-3, tiny, huge)?,
        mass: take("mass", 6.9e-4, tiny, huge)?,
        friction: take("body_friction", 0.0, 0.0, 10.0)?,
        v: [0.0, 0.0, take("velocity", 0.0, tiny, 5000.0)?],
        ..Body::default()
    };
    let shot = Shot {
        aim: [take("x", 0.0, -100.0, 100.0)?, take("y", 0.0, -100.0, 100.0)?],
        longest: take("longest", 2e-3, 0.0, 1.0)?,
        shape,
    };
    match left.keys().next() {
        Some(key) => Err(format!("{key}: no such key")),
        None => Ok((cloth, body, shot)),
    }
}

/// The body where it just touches the cloth, above a place that is so many spacings from the crossing nearest
/// to the middle.
fn placed(cloth: Cloth, mut body: Body, aim: [f64; 2]) -> Sim {
    for (a, aim) in aim.into_iter().enumerate() {
        let even = cloth.yarns[1 - a].is_multiple_of(2);
        body.at[a] = (aim + if even { 0.5 } else { 0.0 }) * cloth.spacing;
    }
    let reach = if body.shape == Shape::Sphere { body.radius } else { 0.0 };
    body.at[2] = -reach - if cloth.crimped { 1.2 } else { 0.5 } * cloth.thickness;
    body.old = body.v;
    Sim::new(cloth, body)
}

/// Shoots until the body stops, time is up, or it is through: the cloth slows it by less than 0.5 % in 20 us,
/// and a slow body has no node ahead.
fn shoot(sim: &mut Sim, longest: f64) -> (&'static str, f64) {
    let (first, start, span) = (sim.body.v[2], 0.5 * sim.body.mass * sim.body.v[2] * sim.body.v[2], 20e-6);
    let (mut worst, mut checked) = (0.0_f64, (0.0, first));
    loop {
        sim.step();
        if sim.steps.is_multiple_of(512) {
            let energy = sim.energy();
            worst = if energy.is_finite() { worst.max((energy / start - 1.0).abs()) } else { f64::INFINITY };
        }
        let mut over = match sim.body.v[2] {
            v if v <= 0.0 => "arrested",
            v if v.is_nan() || v > 10.0 * first => "lost",
            _ if sim.time() > longest => "unknown",
            _ => "",
        };
        if sim.time() > checked.0 + span {
            let slow = sim.body.v[2] * span < 0.25 * sim.body.radius;
            if checked.0 > 0.0 && sim.body.v[2] > 0.995 * checked.1 && !(slow && ahead(sim)) {
                over = "through";
            }
            checked = (sim.time(), sim.body.v[2]);
        }
        if !over.is_empty() {
            return (over, worst.max((sim.energy() / start - 1.0).abs()));
        }
    }
}

/// Whether a node is ahead of the body, within half of its radius.
fn ahead(sim: &Sim) -> bool {
    let [x, y, z] = [0, 1, 2].map(|a| &sim.axes[a].at);
    let [u, v, w] = sim.body.at;
    (0..z.len()).any(|k| z[k] > w && (x[k] - u).hypot(y[k] - v) < 0.5 * sim.body.radius)
}

/// Largest slip of a crossing along a yarn, spacings; crossings within 5 and 10 spacings of the middle that
/// slipped by a tenth of one; broken yarns.
fn damage(sim: &Sim) -> (f64, [usize; 2], usize) {
    let (p, [warps, wefts]) = (sim.cloth.pieces as f64, sim.cloth.yarns);
    let (mut largest, mut slipped) = (0.0_f64, [0; 2]);
    for (c, crossing) in sim.crossings.iter().enumerate().filter(|(_, crossing)| crossing.on) {
        let number = [c % wefts, c / wefts];
        let slip = (0..2).map(|k| (crossing.s[k] / p - (number[k] + 1) as f64).abs()).fold(0.0, f64::max);
        let off = |k: usize, yarns: usize| number[k] as f64 - 0.5 * (yarns - 1) as f64;
        let far = off(0, wefts).hypot(off(1, warps));
        largest = largest.max(slip);
        for (count, most) in slipped.iter_mut().zip([5.0, 10.0]) {
            *count += usize::from(far <= most && slip > 0.1);
        }
    }
    (largest, slipped, sim.broken.iter().filter(|b| **b).count())
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
    let (slip, [near, around], yarns) = damage(&sim);
    let mut line = format!("{{\"end\": \"{end}\"");
    // Energies in parts of the impact's.
    for (name, value) in [
        ("velocity", sim.body.v[2]),
        ("time", sim.time()),
        ("broken_yarns", yarns as f64),
        ("residual", residual.min(1e9)),
        ("dissipated", (sim.kinetic().1 + sim.body.taken) / start),
        ("clamps", sim.book.clamps / start),
        ("slip", slip),
        ("slipped_5", near as f64),
        ("slipped_10", around as f64),
        ("deflection", sim.body.at[2] + sim.body.radius),
    ] {
        let _ = write!(line, ", \"{name}\": {value:e}");
    }
    println!("{line}}}");
    if let Some(path) = shot.shape
        && let Err(error) = std::fs::write(&path, shape(&sim))
    {
        eprintln!("error: {path}: {error}");
        std::process::exit(1)
    }
}
