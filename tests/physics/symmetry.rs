//! Half and quarter models: the same motion as the mirrored whole sheet. Without contact every expression is the same, so
//! every bit is, through failure too; with contact the sum over the nodes is taken in another order.

use fabric::{AttachmentKind, Code, Scene, Shape, Sim, Symmetry};
use fabric_tests::reference::length;
use fabric_tests::{Buffers, close, positions, small_sheet, tilted_cylinder, velocities};

const PLANES: [Symmetry; 3] = [
    Symmetry { mirror_x: true, mirror_y: false },
    Symmetry { mirror_x: false, mirror_y: true },
    Symmetry { mirror_x: true, mirror_y: true },
];
const QUARTER: Symmetry = PLANES[2];

/// A sheet that is set in motion by itself: v_z = v0 cos cos, or v0 and sideways where it is free. The projectile is far away.
pub(crate) fn with_wave<'a>(buffers: &'a mut Buffers, scene: &Scene, v0: f64) -> Sim<'a> {
    let mut sim = buffers.sim(scene);
    let x: Vec<f64> = positions(&sim).into_iter().flatten().collect();
    let fixed = fabric_tests::reference::fixed_nodes(&Scene { symmetry: Symmetry::default(), ..*scene });
    let (nx, modelled) = (scene.sheet.nodes_x as usize, sim.layout().nodes_x);
    let half = scene.half_size();
    let wave = |x: f64, half: f64| (1.3 * x / half).cos();
    let mut v = vec![0.0; x.len()];
    for (k, (x, v)) in x.as_chunks::<3>().0.iter().zip(v.as_chunks_mut::<3>().0).enumerate() {
        if !fixed[k / modelled * nx + k % modelled] {
            let height = wave(x[0], half[0]) * wave(x[1], half[1]);
            *v = [40.0 * x[0] / half[0], -60.0 * x[1] / half[1], v0 * height];
        }
    }
    sim.set_motion(&x, &v).unwrap();
    sim
}

/// Numbers of the whole sheet's nodes that a model with mirror planes holds.
pub(crate) fn modelled_nodes(whole: &Scene, part: &Sim<'_>) -> Vec<usize> {
    let nx = whole.sheet.nodes_x as usize;
    let (columns, rows) = (part.layout().nodes_x, part.layout().nodes_y);
    (0..rows).flat_map(|j| (0..columns).map(move |i| j * nx + i)).collect()
}

#[test]
fn without_contact_every_bit_is_that_of_the_whole_sheet() {
    for (nx, ny) in [(20, 21), (21, 20), (15, 16)] {
        for kind in
            [AttachmentKind::FourSides, AttachmentKind::TwoSides, AttachmentKind::FourCorners, AttachmentKind::Free]
        {
            let yarns = ["plain", "viscous", "rate"];
            for (symmetry, yarn) in PLANES.into_iter().flat_map(|symmetry| yarns.map(|yarn| (symmetry, yarn))) {
                let mut scene = small_sheet(nx, 0.0);
                if yarn == "rate" {
                    (scene.yarn.rate_modulus, scene.yarn.rate_stretch) = (0.13, 0.16);
                    (scene.yarn.rate_reference, scene.yarn.rate_limit) = (300.0, 17000.0);
                }
                if yarn == "viscous" {
                    (scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic) = (0.06, 1.5);
                    scene.yarn.viscosity_bending = 0.06;
                }
                scene.sheet.nodes_y = ny;
                scene.attachment.kind = kind;
                (scene.attachment.disc_inset, scene.attachment.disc_radius) = (1.6e-3, 1.5e-3);
                scene.projectile.radius = 1e-3;
                scene.projectile.position = [0.0, 0.0, -1.0];
                let (mut buffers, mut part_buffers) = (Buffers::of(&scene), Buffers::of(&Scene { symmetry, ..scene }));
                let mut whole = with_wave(&mut buffers, &scene, 1400.0);
                let mut part = with_wave(&mut part_buffers, &Scene { symmetry, ..scene }, 1400.0);
                let nodes = modelled_nodes(&scene, &part);
                for _ in 0..6 {
                    whole.advance(40).unwrap();
                    part.advance(40).unwrap();
                    let (x, v) = (positions(&whole), velocities(&whole));
                    let expected: Vec<_> = nodes.iter().map(|&k| (x[k], v[k])).collect();
                    let found: Vec<_> = positions(&part).into_iter().zip(velocities(&part)).collect();
                    assert!(found == expected, "{nx} x {ny} {kind:?} {symmetry:?}");
                    assert_eq!(part.counters().failed_segments, whole.counters().failed_segments);
                    let (a, b) = (part.energy().unwrap(), whole.energy().unwrap());
                    close(a.fabric_kinetic, b.fabric_kinetic, 1e-12);
                    close(a.strain, b.strain, 1e-12);
                    close(a.dissipated, b.dissipated, 1e-12);
                    close(a.viscous, b.viscous, 1e-12);
                    let (a, b) = (part.support().unwrap(), whole.support().unwrap());
                    let scale = b.attachments.iter().flatten().fold(1e-9, |m: f64, x| m.max(x.abs()));
                    for (a, b) in a.attachments.iter().flatten().zip(b.attachments.iter().flatten()) {
                        assert!((a - b).abs() <= 1e-12 * scale, "{kind:?} {symmetry:?} {a:e} {b:e}");
                    }
                }
                let failed = whole.counters().failed_segments;
                assert!(kind == AttachmentKind::Free || failed > 20, "{kind:?}: {failed}");
            }
        }
    }
}

/// The sphere and the flat cylinder, positions to 1e-11 of the spacing. Only for 400 steps (8.5 us): soon after, contact itself
/// amplifies any rounding a millionfold, in two whole sheets whose velocities differ by 1e-14 just as here.
#[test]
fn a_centred_hit_is_that_of_the_whole_sheet() {
    for nodes in [40, 41] {
        for shape in [Shape::Sphere, Shape::Cylinder, Shape::Box] {
            for kind in [AttachmentKind::FourSides, AttachmentKind::TwoSides, AttachmentKind::FourCorners] {
                let mut scene = match shape {
                    Shape::Sphere => small_sheet(nodes, 25.0),
                    _ => tilted_cylinder(nodes, 0.0, 12.0),
                };
                scene.attachment.kind = kind;
                (scene.attachment.disc_inset, scene.attachment.disc_radius) = (2.5e-3, 2e-3);
                if shape == Shape::Box {
                    scene.projectile.shape = shape;
                    scene.projectile.size = [9e-3, 7e-3, 0.0381];
                }
                let quarter = Scene { symmetry: QUARTER, ..scene };
                let (mut whole, mut part) = (sim_of(&scene), sim_of(&quarter));
                let nodes = modelled_nodes(&scene, &part);
                whole.advance(400).unwrap();
                part.advance(400).unwrap();
                let x = positions(&whole);
                let h = scene.sheet.spacing;
                for (found, &k) in positions(&part).iter().zip(&nodes) {
                    assert!((0..3).all(|axis| (found[axis] - x[k][axis]).abs() < 1e-11 * h));
                }
                let (a, b) = (part.contact().unwrap(), whole.contact().unwrap());
                close(a.impulse[2], b.impulse[2], 1e-11);
                close(a.work, b.work, 1e-11);
                close(a.loss, b.loss, 1e-9);
                assert_eq!(a.impulse[..2], [0.0; 2]);
                close(part.energy().unwrap().fabric_kinetic, whole.energy().unwrap().fabric_kinetic, 1e-11);
                let (a, b) = (part.support().unwrap().total[2], whole.support().unwrap().total[2]);
                assert!((a - b).abs() <= 1e-11 * b.abs().max(1e-6));
                let momentum = scene.projectile.mass * scene.projectile.velocity[2];
                assert!(part.momentum_residual().unwrap().iter().all(|x| x.abs() < 1e-12 * momentum));
            }
        }
    }
}

/// One plane leaves the turning about its normal and the hit's place along it free.
#[test]
fn half_a_sheet_under_a_tilted_cylinder() {
    let mut scene = tilted_cylinder(41, 0.3, 15.0);
    scene.projectile.position[1] = 1e-3;
    scene.projectile.angular_velocity = [300.0, 0.0, 0.0];
    let half = Scene { symmetry: PLANES[0], ..scene };
    let (mut whole, mut part) = (sim_of(&scene), sim_of(&half));
    whole.advance(900).unwrap();
    part.advance(900).unwrap();
    let (a, b) = (part.projectile().unwrap(), whole.projectile().unwrap());
    assert!((a.angular_velocity[0] - 300.0).abs() > 1e-3);
    close(a.angular_velocity[0], b.angular_velocity[0], 1e-12);
    for axis in 1..3 {
        close(a.position[axis], b.position[axis], 1e-12);
        close(a.velocity[axis], b.velocity[axis], 1e-12);
    }
}

/// A quarter is stepped through the whole event; its balances close as a whole sheet's do.
#[test]
fn the_balances_of_a_quarter_close_through_failure() {
    let mut scene = small_sheet(41, 95.0);
    scene.symmetry = QUARTER;
    let mut sim = sim_of(&scene);
    sim.advance(5000).unwrap();
    let energy = sim.energy().unwrap();
    let first = 0.5 * scene.projectile.mass * 95.0 * 95.0;
    assert!(sim.counters().failed_segments > 50);
    close(energy.projectile_kinetic + energy.contact_work, first, 1e-12);
    assert!(energy.residual.abs() < 0.01 * first, "{}", energy.residual);
    let momentum = scene.projectile.mass * 95.0;
    let off = length(sim.momentum_residual().unwrap()) / momentum;
    println!("figure 17: quarter of a sheet through failure: {off:.1e}");
    assert!(sim.momentum_residual().unwrap().iter().all(|x| x.abs() < 1e-12 * momentum));
}

#[test]
fn what_a_plane_would_change_is_refused() {
    type Change = fn(&mut Scene);
    let cases: [(&str, Change); 5] = [
        ("projectile.shape", |s| {
            s.projectile.faces = Scene::turbine_disc_sector().projectile.faces;
            s.projectile.moments = Scene::turbine_disc_sector().projectile.moments;
            s.projectile.shape = Shape::Polyhedron;
        }),
        ("projectile.position", |s| s.projectile.position[0] = 1e-6),
        ("projectile.velocity", |s| s.projectile.velocity[1] = 1e-3),
        ("projectile.orientation", |s| s.projectile.orientation = [0.1f64.cos(), 0.0, 0.1f64.sin(), 0.0]),
        ("projectile.angular_velocity", |s| s.projectile.angular_velocity = [0.0, 0.0, 1.0]),
    ];
    for (field, change) in cases {
        let mut scene = tilted_cylinder(41, 0.0, 20.0);
        scene.projectile.position[2] -= 0.01;
        scene.symmetry = QUARTER;
        assert!(fabric::Layout::of(&scene).is_ok());
        change(&mut scene);
        let mut whole = scene;
        whole.symmetry = Symmetry::default();
        let mut buffers = Buffers::of(&whole);
        let error = Sim::new(&scene, &mut buffers.lines).err().expect("refused");
        assert_eq!((error.code, error.field), (Code::NotSymmetric, field));
    }
    let mut scene = small_sheet(41, 20.0);
    scene.symmetry = QUARTER;
    let mut sim = sim_of(&scene);
    assert!(sim.set_external_load([0.0, 0.0, 3.0], [0.0; 3]).is_ok());
    let error = sim.set_external_load([1.0, 0.0, 0.0], [0.0; 3]).unwrap_err();
    assert_eq!((error.code, error.field), (Code::NotSymmetric, "external.force"));
}

/// The quarter's memory is about a quarter.
#[test]
fn a_quarter_takes_a_quarter_of_the_memory() {
    let mut scene = Scene::sheet_10in_cylinder();
    scene.yarn.stochastic = false;
    let whole = fabric::Layout::of(&scene).unwrap().bytes();
    scene.symmetry = QUARTER;
    assert!((fabric::Layout::of(&scene).unwrap().bytes() as f64) < 0.27 * whole as f64);
}
