//! Against closed forms, and the balance of energy. A force linear in the Green-Lagrange strain, as the
//! network's.

use crate::body::Body;
use crate::cloth::{Cloth, End, Sim, dot};
use crate::{damage, given, placed, shoot};

fn cloth(more: &str) -> (Cloth, Body) {
    let arguments: Vec<String> = more.split_whitespace().map(String::from).collect();
    let (cloth, body, _) = given(&arguments).unwrap();
    (cloth, body)
}

/// Without a body in reach.
fn alone(cloth: Cloth, mut body: Body) -> Sim {
    body.at[2] = -1.0;
    body.v = [0.0; 3];
    Sim::new(cloth, body)
}

fn near(name: &str, found: f64, expected: f64, part: f64) {
    println!("{name}: {found:.5} (closed form {expected:.5}, {:+.3} %)", 100.0 * (found / expected - 1.0));
    assert!((found / expected - 1.0).abs() < part, "{name}: {found} instead of {expected}");
}

/// Front of the kink in the laboratory and velocity at a stretch: docs/validation.md, "One yarn hit across".
fn smith(c: &Cloth, stretch: f64) -> (f64, f64) {
    let force = c.stiffness * 0.5 * stretch * (stretch * stretch - 1.0);
    let (inwards, kink) = ((force * (stretch - 1.0) / c.line_mass).sqrt(), (force * stretch / c.line_mass).sqrt());
    (kink - inwards, (kink * kink - (kink - inwards).powi(2)).sqrt())
}

#[test]
fn a_yarn_hit_across_has_the_strain_and_the_kink_of_theory() {
    for pieces in [3, 6] {
        let (mut c, body) = cloth(&format!("velocity=200 radius=1e-4 mass=1000 pinned=1 crimped=0 pieces={pieces}"));
        (c.yarns, c.bare) = ([1, 600], true);
        let mut sim = placed(c.clone(), body, [0.0, 0.0]);
        let (mut low, mut high) = (1.0, 1.1);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if smith(&c, middle).1 < 200.0 { low = middle } else { high = middle }
        }
        let half = 300.0 * c.spacing;
        // Where the straight line between the body and the kink would meet the yarn at rest: the kink itself
        // spreads with time.
        let kink = |sim: &Sim| {
            let (x, z, n) = (&sim.axes[0].at, &sim.axes[2].at, sim.nodes[0]);
            let deep = z[..n].iter().fold(0.0_f64, |a, b| a.max(*b));
            let at = |part: f64| {
                let k = (n / 2..n - 1).find(|k| z[*k] < part * deep).unwrap();
                (x[k - 1] + (x[k] - x[k - 1]) * (z[k - 1] - part * deep) / (z[k - 1] - z[k]), part * deep)
            };
            let (a, b) = (at(0.8), at(0.4));
            b.0 + (b.0 - a.0) * b.1 / (a.1 - b.1) - sim.body.at[0]
        };
        let until = half / (c.stiffness / c.line_mass).sqrt();
        while sim.time() < 0.5 * until {
            sim.step();
        }
        let (first, start) = (kink(&sim), sim.time());
        while sim.time() < 0.95 * until {
            sim.step();
        }
        // The plateau between kink and longitudinal front.
        let n = sim.nodes[0];
        let (from, to) = (n / 2 + n / 8, n / 2 + n / 4);
        let tension = (from..to).map(|k| sim.tension(0, k)).sum::<f64>() / (to - from) as f64;
        let expected = c.stiffness * 0.5 * low * (low * low - 1.0);
        near(&format!("plateau at 200 m/s, {pieces} pieces, N"), tension, expected, 0.01);
        near(
            &format!("kink at 200 m/s, {pieces} pieces, m/s"),
            (kink(&sim) - first) / (sim.time() - start),
            smith(&c, low).0,
            0.02,
        );
    }
}

#[test]
fn a_wave_runs_with_the_speed_of_sound() {
    let (mut c, body) = cloth("velocity=1 pinned=1 crimped=0 linear=0.06");
    (c.yarns, c.bare) = ([1, 300], true);
    let mut sim = alone(c.clone(), body);
    sim.ends[0][1] = End::Moves(5.0);
    let (n, plateau) = (sim.nodes[0], 5.0 * (c.stiffness * c.line_mass).sqrt());
    let mut times = [0.0; 2];
    while times[1] == 0.0 {
        sim.step();
        for (time, bar) in times.iter_mut().zip([n - n / 4, n / 4]) {
            if *time == 0.0 && sim.tension(0, bar) > 0.5 * plateau {
                *time = sim.time();
            }
        }
    }
    let path = (n - n / 4 - n / 4) as f64 * sim.length[0][0];
    near("speed of sound, m/s", path / (times[1] - times[0]), (c.stiffness / c.line_mass).sqrt(), 0.01);
    near("plateau behind the wave, N", sim.tension(0, n / 2), plateau, 0.01);
}

/// A wave of tension T from a moved end meets a clamp that holds up to F. It comes back with as much, so 2 T
/// less than F is held; else the clamp slips with (2 T - F)/Z, Z = T over the velocity of the moved end, and
/// takes F times the way.
#[test]
fn a_clamp_slips_where_the_reflected_wave_exceeds_its_force() {
    for clamp in [3.0, 5.2] {
        let (mut c, body) = cloth(&format!("velocity=1 pinned=1 crimped=0 linear=0.06 clamp={clamp}"));
        (c.yarns, c.bare) = ([1, 300], true);
        let mut sim = alone(c.clone(), body);
        sim.ends[0][1] = End::Moves(5.0);
        let impedance = (c.stiffness * c.line_mass).sqrt();
        let once = 301.0 * c.spacing / (c.stiffness / c.line_mass).sqrt();
        let [early, late] = [1.3, 1.7].map(|times| {
            while sim.time() < times * once {
                sim.step();
            }
            (sim.time(), sim.axes[0].at[0], sim.tension(0, 8), sim.book.clamps)
        });
        let (way, slides) = (late.1 - early.1, 2.0 * 5.0 * impedance > clamp);
        if slides {
            near("velocity of a slipping clamp, m/s", way / (late.0 - early.0), 10.0 - clamp / impedance, 0.01);
            near("what a slipping clamp takes, J", late.3 - early.3, clamp * way, 0.01);
        }
        assert!(slides || way == 0.0 && late.3 == 0.0);
        near("tension at a clamp, N", late.2, if slides { clamp } else { 10.0 * impedance }, 0.01);
    }
}

#[test]
fn a_weave_at_rest_stays_so() {
    let (c, body) = cloth("velocity=1 yarns=12");
    let mut sim = alone(c, body);
    let before: Vec<f64> = sim.axes[2].at.clone();
    for _ in 0..4000 {
        sim.step();
    }
    let moved = before.iter().zip(&sim.axes[2].at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!(
        "weave at rest: moved by {:.1e} of its thickness, energy {:.1e} J",
        moved / sim.cloth.thickness,
        sim.energy()
    );
    assert!(moved < 1e-6 * sim.cloth.thickness && sim.energy() < 1e-12);
}

/// A warp among stretched wefts is pulled at one end against a force at the other: forces at both ends, sum
/// of the angles by which it turns at crossings, of their normal forces, their number, and how far it moved.
fn pulled(more: &str, tail: f64, pre: f64) -> [f64; 5] {
    let (mut c, body) = cloth(&format!("velocity=1 damping=0.5 linear=0 quadratic=0 bending=0 slack=1 {more}"));
    c.yarns = [5, 12];
    c.pre_strain = [0.0, pre];
    let mut sim = alone(c, body);
    sim.ends[2] = [End::Pulled(tail), End::Held];
    let (way, first, n) = sim.yarn(2);
    assert_eq!(way, 0);
    let (settle, total, pull) = (100e-6, 1000e-6, 1.0);
    let (mut sums, mut count) = ([0.0; 5], 0.0);
    let start = sim.axes[0].at[first + n - 1];
    while sim.time() < total {
        if sim.time() > settle {
            let velocity = pull * ((sim.time() - settle) / 100e-6).min(1.0);
            sim.ends[2][1] = End::Moves(velocity);
        }
        // Everything but the pull is slow.
        let keep = 1.0 - sim.dt / 3e-6;
        for axis in 0..3 {
            let mean = if axis == 0 && sim.time() > settle { sim.axes[0].v[first + n - 1] } else { 0.0 };
            for k in 0..sim.axes[axis].v.len() {
                let base = if (first..first + n).contains(&k) { mean } else { 0.0 };
                sim.axes[axis].v[k] = base + keep * (sim.axes[axis].v[k] - base);
            }
        }
        sim.step();
        if sim.time() > 0.6 * total && sim.steps.is_multiple_of(16) {
            // Direction of the bar at the arc coordinate s.
            let along = |s: f64| {
                let k = first + s as usize;
                let d = [0, 1, 2].map(|a| sim.axes[a].at[k + 1] - sim.axes[a].at[k]);
                let length = dot(d, d).sqrt();
                d.map(|x| x / length)
            };
            let (mut angle, mut force) = (0.0, 0.0);
            for j in 0..12 {
                let [before, own, after] = [-1, 0, 1].map(|k| {
                    let (j, p) = (j + k, sim.cloth.pieces as f64);
                    let edge = if j < 0 {
                        -p
                    } else if j > 11 {
                        p
                    } else {
                        0.0
                    };
                    sim.crossings[(24 + j.clamp(0, 11)) as usize].s[0] + edge
                });
                angle += dot(along(0.5 * (before + own)), along(0.5 * (own + after))).min(1.0).acos();
                force += sim.crossings[(24 + j) as usize].force;
            }
            let drag = [sim.tension(2, 0), sim.tension(2, n - 2)];
            for (sum, value) in sums.iter_mut().zip([drag[0], drag[1], angle, force, 12.0]) {
                *sum += value;
            }
            count += 1.0;
        }
    }
    println!("moved {:.2} spacings", (sim.axes[0].at[first + n - 1] - start) / sim.cloth.spacing);
    sums.map(|sum| sum / count)
}

#[test]
fn a_yarn_pulled_over_others_is_a_capstan() {
    for friction in [0.1, 0.2] {
        let [tail, head, angle, force, _] = pulled(&format!("friction={friction} pieces=6"), 4.0, 0.002);
        near(
            &format!("pull-out with {friction}: difference of forces over friction times normal forces"),
            (head - tail) / (friction * force),
            1.0,
            0.05,
        );
        near(&format!("capstan with {friction}, angle {angle:.2}"), head / tail, (friction * angle).exp(), 0.05);
    }
}

#[test]
fn adhesion_holds_a_yarn_at_each_crossing_beside_friction() {
    let [tail, head, _, force, crossings] = pulled("friction=0.1 adhesion=0.05 pieces=6", 4.0, 0.002);
    near("pull-out, n (f0 + mu N), N", head - tail, crossings * 0.05 + 0.1 * force, 0.03);
}

#[test]
fn half_the_step_changes_little_and_energy_closes() {
    for (name, more, limit) in [
        ("pinned", "pinned=1 crimped=0", 0.01),
        ("crimped", "friction=0.2 body_friction=0.2", 0.01),
        ("window", "friction=0 x=0.5 y=0.5", 0.02),
    ] {
        let ends: Vec<(f64, f64)> = [0.6, 0.3]
            .iter()
            .map(|step| {
                let (c, mut body) = cloth(&format!("velocity=30 yarns=25 step={step} {more}"));
                body.mass *= if name == "window" { 2.0 } else { 1.0 };
                let mut sim = placed(c, body, if name == "window" { [0.5, 0.5] } else { [0.0, 0.0] });
                let (end, residual) = shoot(&mut sim, 3e-4);
                println!(
                    "{name}, step {step}: {end}, {:.3} m/s, residual {residual:.1e}, broken {:?}",
                    sim.body.v[2],
                    damage(&sim)
                );
                assert!(residual < limit);
                (sim.body.at[2], sim.body.v[2])
            })
            .collect();
        assert!((ends[0].1 - ends[1].1).abs() < 0.3, "{ends:?}");
        assert!((ends[0].0 / ends[1].0 - 1.0).abs() < 0.01 || name == "window", "{ends:?}");
    }
}
