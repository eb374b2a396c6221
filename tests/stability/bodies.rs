//! Projectiles: from as light as a node to 10^9 times heavier, to 30 km/s, striking in every way, rubbing,
//! and through plies.

use crate::{End, ROUNDING, Row, all, changed, near, row, turned};
use fabric_kernel::{AttachmentKind, Drive, Outcome, Scene, Shape};
use fabric_tests::{drawn, small_sheet};
use std::f64::consts::PI;

#[test]
fn masses_from_that_of_a_node() {
    let of = |ratio: f64| {
        let scene = changed(small_sheet(41, 100.0), |scene| scene.projectile.mass = ratio * scene.sheet.node_mass);
        // Up to some 10^4 nodes' mass the sheet throws it back; beyond, it goes through.
        let (end, expected) = match ratio < 1e4 {
            true => (Outcome::Arrested, "thrown back, sound, none inside"),
            false => (Outcome::Exited, "goes through, sound, none inside"),
        };
        row(format!("{ratio:e} nodes' mass"), expected, scene, 100_000, move |found| {
            found.latched(end) && found.sound() && found.outside(ROUNDING)
        })
    };
    all([1.0, 10.0, 1e3, 1e6, 1e9].map(of).into());
}

#[test]
fn velocities_from_subnormal_to_30_km_s() {
    all(vec![
        row("V = 5e-324 m/s", "absorbed 0 to rounding", small_sheet(41, 5e-324), 20_000, |end| {
            end.contact.work.abs() < 1e-300
        }),
        row("V = 1 m/s", "arrested whole, sound, none inside", small_sheet(41, 1.0), 400_000, |end| {
            end.only(Outcome::Arrested) && end.sound() && end.outside(ROUNDING) && end.counters.failed_segments == 0
        }),
        // As mass swept up times V^2: (30/20)^2 of the 3041 J at 20 km/s.
        row("V = 30 km/s", "exits, sound, absorbed 6840 J (10 %)", small_sheet(41, 3e4), 100_000, |end| {
            near(end.contact.work, 6842.0, 0.1) && end.latched(Outcome::Exited) && end.sound()
        }),
    ]);
}

/// Above 1301 m/s the yarns break at first contact: the sphere sweeps up nodes, each of which takes m V^2/2
/// as motion and as much as loss. About half of what is absorbed is loss, and the sum grows with V^2.
#[test]
fn very_fast_projectiles_sweep_up_nodes() {
    let expected = "exits, closed, absorbed what it swept up, half of it as loss";
    let of = |[velocity, residual, absorbed, loss]: [f64; 4]| {
        row(format!("V = {velocity} m/s"), expected, small_sheet(41, velocity), 50_000, move |end| {
            let [work, lost] = [end.contact.work, end.contact.loss];
            let exact = near(end.body.velocity[2], residual, 1e-5) && near(lost, loss, 5e-3);
            let swept = near(work, absorbed, 1e-3) && (0.45..0.55).contains(&(lost / work));
            swept
                && (velocity > 1e4 || exact)
                && end.latched(Outcome::Exited)
                && end.energy.residual.abs() < 0.01 * work
        })
    };
    let mut small = small_sheet(9, 0.0);
    let fastest = small.sheet.spacing / small.step_limits().unwrap().dt;
    small.projectile.velocity[2] = 0.999 * fastest;
    let mut rows: Vec<Row> =
        [[2000.0, 1998.05, 32.73, 15.6], [5000.0, 4995.36, 194.8, 98.1], [20_000.0, f64::NAN, 3041.0, f64::NAN]]
            .map(of)
            .into();
    rows.push(
        row("the largest velocity that is accepted", "runs", small, 2000, |end| end.contact.work > 0.0).for_its_steps(),
    );
    all(rows);
}

/// A body on a sheet of 41 x 41 at this velocity.
fn on_sheet(shape: Shape, size: [f64; 3], velocity: f64) -> Scene {
    changed(small_sheet(41, velocity), |scene| {
        let body = &mut scene.projectile;
        (body.shape, body.size, body.length) = (shape, size, 0.02);
    })
}

const BRICK: [f64; 3] = [0.01, 0.012, 0.014];

fn spinning(scene: Scene, spin: [f64; 3]) -> Scene {
    changed(scene, |scene| scene.projectile.angular_velocity = spin)
}

/// A 60 degree sector of a disc, its rim ahead and tilted by 20 degrees so that one corner strikes first.
fn sector() -> Scene {
    changed(small_sheet(61, 80.0), |scene| {
        let body = &mut scene.projectile;
        let sector = &mut body.sector;
        (body.shape, body.mass) = (Shape::DiscSector, 0.028);
        (sector.inner_radius, sector.outer_radius, sector.angle, sector.thickness) = (0.01, 0.03, PI / 3.0, 0.008);
        body.position[2] = -0.01078288280;
        let [a, b] = [0.5792279653395692, 0.40557978767263886];
        body.orientation = [a, -a, -b, -b];
    })
}

#[test]
fn hits_of_every_kind() {
    let [cylinder, brick] = [Shape::Cylinder, Shape::Box].map(|shape| on_sheet(shape, BRICK, 100.0));
    let along = changed(small_sheet(41, 10.0), |scene| {
        (scene.projectile.position[0], scene.projectile.velocity[0]) = (-0.01, 300.0);
    });
    let rim = changed(small_sheet(41, 100.0), |scene| {
        scene.projectile.position[0] = scene.half_size()[0] + scene.projectile.radius - 1.5 * scene.sheet.spacing;
    });
    let scenes = [
        ("sphere along the sheet at 300 m/s, down at 10 m/s", along),
        ("sphere, its rim on the outermost free nodes", rim),
        ("cylinder flat-on", turned(cylinder, [1.0, 0.0, 0.0], 0.0)),
        ("cylinder edge-on, 45 degrees", turned(cylinder, [1.0, 0.3, 0.0], 0.25 * PI)),
        ("cylinder on its side", turned(cylinder, [0.0, 1.0, 0.0], 0.5 * PI)),
        ("cylinder tumbling", spinning(turned(cylinder, [1.0, 0.0, 0.0], 0.4), [3000.0, 500.0, 0.0])),
        ("box corner first", turned(brick, [1.0, -1.0, 0.0], 0.955)),
        ("box tumbling", spinning(turned(brick, [1.0, 0.2, 0.1], 0.7), [4000.0, -3000.0, 100.0])),
        ("disc sector edge-on, 80 m/s", sector()),
    ];
    let hit = |(name, scene): (&str, Scene)| {
        let turns = scene.projectile.shape != Shape::Sphere;
        let check = move |end: &End<'_>| {
            let depth = if turns { end.turning_allows() } else { ROUNDING };
            end.sound() && end.outside(depth) && end.contact.work > 0.0
        };
        let row = row(name, "sound, no deeper than turning allows", scene, 6000, check);
        Row { until: Outcome::Exited.into(), ..row }
    };
    all(scenes.map(hit).into());
}

/// Under a face as large as the sheet some solves among 1521 nodes end at their limit.
#[test]
fn slabs_wider_than_the_sheet() {
    let flat = changed(on_sheet(Shape::Box, [0.04, 0.04, 0.004], 50.0), |scene| {
        (scene.projectile.mass, scene.projectile.position[2]) = (0.05, -0.002);
    });
    let slab = |(name, scene)| {
        let expected = "balances close, under 1 % of the solves given up, no deeper than turning allows";
        row(name, expected, scene, 6000, |end| {
            end.few_given_up() && end.outside(end.turning_allows()) && end.contact.work > 0.0
        })
        .for_its_steps()
    };
    all([("slab", flat), ("slab tilted by 3 degrees", turned(flat, [1.0, 0.5, 0.0], 0.05))].map(slab).into());
}

/// With friction, moving along x as fast as along z, and spinning.
fn rubbing(scene: Scene, coefficient: f64, spin: f64) -> Scene {
    changed(spinning(scene, [0.0, 0.6 * spin, 0.8 * spin]), |scene| {
        scene.contact.friction = coefficient;
        scene.projectile.velocity[0] = scene.projectile.velocity[2];
    })
}

#[test]
fn friction_up_to_its_largest_coefficient() {
    let sphere = |coefficient: f64| {
        let scene = rubbing(small_sheet(41, 100.0), coefficient, 5e4);
        row(format!("sphere askew, spinning, coefficient {coefficient:e}"), "sound, none inside", scene, 6000, |end| {
            end.sound() && end.outside(ROUNDING) && end.energy.friction > 0.0
        })
    };
    let mut rows: Vec<Row> = [1e-6, 0.1, 1.0, 10.0].map(sphere).into();
    let light = changed(rubbing(small_sheet(41, 60.0), 10.0, 1e4), |scene| scene.projectile.mass = 1e-6);
    let expected = "balances close, none inside, under 1 % of the solves given up";
    rows.push(row("sphere of 15 nodes' mass", expected, light, 6000, |end| {
        end.few_given_up() && end.outside(ROUNDING)
    }));
    let brick = changed(on_sheet(Shape::Box, BRICK, 100.0), |scene| scene.projectile.position[2] = -0.0106);
    let brick = turned(brick, [1.0, 0.6, 0.0], 0.7);
    let free = changed(brick, |scene| scene.attachment.kind = AttachmentKind::Free);
    let drum = changed(on_sheet(Shape::Cylinder, BRICK, 60.0), |scene| scene.drive = Drive::Prescribed);
    let drum = turned(drum, [1.0, 0.0, 0.0], 0.5 * PI);
    for (name, scene, spin) in [
        ("box on a corner", brick, 5e3),
        ("the same on a free sheet", free, 5e3),
        ("drum that its host presses in while it turns", drum, 2e4),
    ] {
        rows.push(row(name, "sound", rubbing(scene, 10.0, spin), 3000, |end| end.sound() && end.energy.friction > 0.0));
    }
    let clamped = changed(brick, |scene| (scene.sheet.nodes_x, scene.sheet.nodes_y) = (3, 3));
    // Solves on supports may be given up.
    rows.push(row("box on eight fixed nodes of 3 x 3", "balances close", rubbing(clamped, 10.0, 5e3), 3000, |end| {
        end.closed() && end.energy.friction > 0.0
    }));
    all(rows);
}

fn stacked(nodes: u32, velocity: f64, plies: u32, gap: f64) -> Scene {
    changed(small_sheet(nodes, velocity), |scene| (scene.stack.plies, scene.stack.gap) = (plies, gap))
}

/// Spacing of the nodes, m.
const H: f64 = 0.0254 / 35.0;
/// What counts as touching (`contact/edge.rs`), m.
const TOUCHING: f64 = 1e-9 * H;

/// No ply ever in another.
fn apart(end: &End<'_>) -> bool {
    end.counters.ply_penetration < 1e-12 * H
}

#[test]
fn plies_on_each_other() {
    let askew = changed(drawn(stacked(31, 60.0, 4, 5e-5)), |scene| {
        (scene.stack.turned, scene.sheet.crimp) = (true, [0.01, 0.002]);
        // As a textile has them: without, a crimped sheet gains energy.
        scene.slack_balance = true;
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic, scene.yarn.viscosity_bending) = (0.06, 1.5, 0.06);
        scene.projectile.velocity[0] = 30.0;
    });
    all(vec![
        row(
            "five plies of drawn yarn, gap 0, 40 J",
            "sound, none inside by 1e-9 h, yarns fail",
            drawn(stacked(31, 97.59, 5, 0.0)),
            20_000,
            |end| end.sound() && end.outside(TOUCHING) && end.counters.failed_segments > 0,
        ),
        row(
            "the same, 1 J",
            "arrested, sound, none inside by 1e-9 h, no ply in another",
            drawn(stacked(31, 15.43, 5, 0.0)),
            20_000,
            |end| end.only(Outcome::Arrested) && end.sound() && end.outside(TOUCHING) && apart(end),
        ),
        row("four crimped plies, turned, hit askew", "sound, none inside by 1e-9 h", askew, 20_000, |end| {
            end.sound() && end.outside(TOUCHING)
        }),
    ]);
}

/// A thousand plies, and a cylinder of 8 mm and 4 g, its rim first, through 62 at 1000 m/s.
#[test]
#[ignore = "a minute; cargo xtask verify runs it"]
fn very_many_plies() {
    let free = changed(stacked(2, 100.0, 1000, 1e-5), |scene| scene.attachment.kind = AttachmentKind::Free);
    let fragment = changed(drawn(stacked(21, 1000.0, 62, 1e-4)), |scene| {
        let body = &mut scene.projectile;
        (body.shape, body.radius, body.length, body.mass) = (Shape::Cylinder, 3e-3, 8e-3, 4e-3);
    });
    let expected = "exits, balances close, under 1 % of the solves given up, no deeper than turning allows";
    all(vec![
        row(
            "1000 free plies of 2 x 2 nodes, 0.01 mm apart",
            "sound, momentum to 1e-12, none inside by 1e-9 h, no ply in another",
            free,
            20_000,
            |end| end.sound() && end.off[1] < 1e-12 && end.outside(TOUCHING) && apart(end),
        )
        .for_its_steps(),
        row(
            "1000 held plies of 2 x 2 nodes, gap 0",
            "arrested, sound, none inside by 1e-9 h, more than 99 % of the 42 J lost",
            stacked(2, 100.0, 1000, 0.0),
            20_000,
            move |end| {
                end.only(Outcome::Arrested) && end.sound() && end.outside(TOUCHING) && end.contact.work > 0.99 * 42.0
            },
        ),
        row("a fragment through 62 plies", expected, turned(fragment, [1.0, 0.3, 0.0], 0.5), 20_000, |end| {
            end.latched(Outcome::Exited) && end.few_given_up() && end.outside(end.turning_allows())
        }),
    ]);
}
