//! Places for the nodes under the projectile: by default there is one for every node, so that no scene can
//! run out of them.

use fabric_kernel::{AttachmentKind, Draw, Failure, Scene, Shape, Symmetry};
use fabric_tests::{cuboid_faces, image_of, positions, sim_of, small_sheet};

const SHAPES: [Shape; 5] =
    [Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box, Shape::Polyhedron];
const KINDS: [AttachmentKind; 4] =
    [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners, AttachmentKind::Free];

/// A small body, `size` spacings from its middle to its ends, a third of a spacing before a sheet: the sheet
/// is many times what wraps it.
fn small_body(nodes: [u32; 2], shape: Shape, size: f64, kind: AttachmentKind) -> Scene {
    let mut scene = small_sheet(3, 0.0);
    [scene.sheet.nodes_x, scene.sheet.nodes_y] = nodes;
    let half = size * scene.sheet.spacing;
    scene.attachment.kind = kind;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) =
        (1.2 * scene.sheet.spacing, 1.1 * scene.sheet.spacing);
    let body = &mut scene.projectile;
    (body.shape, body.radius, body.length, body.size) = (shape, half, 2.0 * half, [2.0 * half; 3]);
    (body.faces, body.moments) = (cuboid_faces([half; 3]), [1e-9; 3]);
    // From the centre of mass of the body with one hemispherical end to its tip it is 1.15 radii.
    let tip = if shape == Shape::HemisphericalCylinder { 1.15 * half } else { half };
    body.position = [0.0, 0.0, -tip - scene.sheet.spacing / 3.0];
    scene
}

/// Uniform yarn, a draw per segment, a draw per yarn; mirror planes go with uniform yarn only.
fn yarns() -> impl Iterator<Item = (bool, Draw, Symmetry)> {
    let planes = [(false, false), (true, false), (false, true), (true, true)];
    let uniform = planes.map(|(mirror_x, mirror_y)| (false, Draw::Segment, Symmetry { mirror_x, mirror_y }));
    let drawn = [Draw::Segment, Draw::Yarn].map(|draw| (true, draw, Symmetry::default()));
    uniform.into_iter().chain(drawn)
}

/// All that is not held lies crumpled under the body, far more than could wrap it.
#[test]
fn every_free_node_of_the_sheet_finds_a_place_under_the_body() {
    for (shape, kind) in SHAPES.into_iter().flat_map(|shape| KINDS.map(|kind| (shape, kind))) {
        for (stochastic, draw, symmetry) in yarns() {
            let mut scene = small_body([25, 24], shape, 1.1, kind);
            (scene.yarn.stochastic, scene.yarn.draw, scene.symmetry) = (stochastic, draw, symmetry);
            let mut sim = sim_of(&scene);
            let mut points = positions(&sim);
            let mut free = 0;
            for (node, point) in points.iter_mut().enumerate() {
                let (i, j) = (node % sim.layout().nodes_x, (node / sim.layout().nodes_x));
                let held = fabric_kernel::internals::weave::fixed_runs(&scene, j);
                if !held.iter().any(|[first, end]| (*first as usize..*end as usize).contains(&i)) {
                    *point = point.map(|x| 0.01 * x);
                    free += 1;
                }
            }
            let points = points.as_flattened();
            sim.set_motion(points, &vec![0.0; points.len()]).unwrap();
            sim.advance(50).unwrap();
            let counters = sim.counters();
            assert_eq!(counters.most_candidates, free, "{shape:?} {kind:?} {draw:?} {symmetry:?}");
            assert_eq!(counters.candidate_capacity, sim.layout().nodes() as u64, "one for every node");
        }
    }
}

/// Room changes no bit of the motion, and an image taken with little room goes on with more: the cure where
/// the room was too little.
#[test]
fn an_image_goes_on_with_more_room() {
    let little = Scene { contact_capacity: 120, ..small_sheet(31, 300.0) };
    let ample = Scene { contact_capacity: 0, ..little };
    let (mut short, mut cured, mut whole) = (sim_of(&little), sim_of(&ample), sim_of(&ample));
    let mut image;
    let failure = loop {
        image = image_of(&short);
        if let Err(failure) = short.advance(20) {
            break failure;
        }
    };
    assert_eq!(failure, Failure::ContactCapacity);
    cured.load(&image).unwrap();
    assert!(cured.step_count() > 20);
    cured.advance(2000).unwrap();
    whole.advance(cured.step_count()).unwrap();
    assert_eq!(cured.digest(), whole.digest());
}

/// A sheet once round a cylinder with its ends folded over the caps, the rest of it trailing: every node of
/// the piece that wraps the body is near it, and the number that docs/embedding.md gives for a held sheet has
/// room for half as many more.
#[test]
fn a_sheet_wrapped_about_a_cylinder_fits_in_the_number_of_the_docs() {
    let mut scene = small_sheet(3, 0.0);
    let h = scene.sheet.spacing;
    let (radius, length) = (6.0 * h, 20.0 * h);
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (121, 33);
    scene.attachment.kind = fabric_kernel::AttachmentKind::FourCorners;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (2.0 * h, 1.5 * h);
    scene.projectile.shape = fabric_kernel::Shape::Cylinder;
    (scene.projectile.radius, scene.projectile.length) = (radius, length);
    scene.projectile.velocity = [0.0; 3];
    // The axis along y, just below the flat sheet.
    scene.projectile.orientation = [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0];
    scene.projectile.position = [0.0, 0.0, -radius - 2.0 * h];
    // 1.6 times 2 pi r (l + 2 r)/h^2 with a margin h all round.
    scene.contact_capacity = (1.6 * std::f64::consts::TAU * 7.0 * (22.0 + 14.0)) as u32;
    let mut sim = sim_of(&scene);
    let mut points = positions(&sim);
    // Away from the surface, but nearer than h.
    let away = 0.05 * h;
    let turn = std::f64::consts::PI * (radius + away);
    let mut wrapped = 0;
    for point in &mut points {
        // Round the body: x becomes an arc from above; what is left hangs from where the arc is closed.
        let (x, y) = (point[0], point[1]);
        let angle = x.clamp(-turn, turn) / (radius + away);
        let hanging = (x.abs() - turn).max(0.0);
        // Over the cap: y beyond the end becomes a way towards the axis.
        let beyond = (y.abs() - 0.5 * length - away).max(0.0);
        let out = (radius + away - beyond).max(0.0);
        point[0] = out * angle.sin();
        point[1] = y.clamp(-0.5 * length - away, 0.5 * length + away);
        point[2] = scene.projectile.position[2] + out * angle.cos() - hanging;
        wrapped += u64::from(hanging == 0.0);
    }
    let points = points.as_flattened();
    sim.set_motion(points, &vec![0.0; points.len()]).unwrap();
    sim.step().unwrap();
    let counters = sim.counters();
    assert!(counters.candidate_capacity < sim.layout().nodes() as u64, "the sheet is larger than the room");
    assert!(counters.most_candidates >= wrapped && wrapped > 1000, "{wrapped} of {}", counters.most_candidates);
    assert!(3 * counters.most_candidates <= 2 * counters.candidate_capacity, "{counters:?}");
}
