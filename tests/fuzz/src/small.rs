//! Small sound scenes: every shape, attachment, yarn and rule, with few nodes, near enough for contact in a
//! few steps.

use crate::bytes::Bytes;
use fabric_kernel::{
    AttachmentKind, Back, Casing, Draw, Drive, Faces, Grading, Integrator, IntegratorKind, RotationRule, Scene, Sector,
    Shape, Stack, StepCheck, StrengthDraw, Symmetry, TimeStep, Weft,
};

/// Most nodes of a sheet that is stepped.
pub const MOST_NODES: u64 = 100;
/// Most iterations of the theta rule.
pub const MOST_ITERATIONS: u32 = 40;

/// A scene as the bytes choose it. Nearly all are accepted.
pub fn scene(bytes: &mut Bytes) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    let h = scene.sheet.spacing;
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (2 + bytes.below(6) as u32, 2 + bytes.below(6) as u32);
    scene.seed = u64::from(bytes.byte());

    let choices = bytes.byte();
    let bit = |k: u8| choices >> k & 1 == 1;
    scene.yarn.stochastic = bit(0);
    scene.yarn.draw = if bit(1) { Draw::Yarn } else { Draw::Segment };
    scene.track_detachment = !bit(2);
    scene.track_support = !bit(3);
    scene.track_through = bit(4);
    scene.slack_balance = bit(5);
    scene.drive = if bit(6) { Drive::Prescribed } else { Drive::Free };
    let kinds =
        [AttachmentKind::FourSides, AttachmentKind::TwoSides, AttachmentKind::FourCorners, AttachmentKind::Free];
    scene.attachment.kind = bytes.choose(&kinds);
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (0.0, 0.1 * h);

    // As hard as the yarn of the paper, or so weak that it fails at once.
    scene.yarn.critical_stretch = bytes.choose(&[1.03, 1.001, 1.2]);
    scene.sheet.plies = bytes.choose(&[1, 1, 3]);
    scene.time_step = match bytes.below(4) {
        0 => TimeStep::fraction(0.4),
        1 => TimeStep::fraction(0.1),
        2 => TimeStep::seconds(1e-8),
        _ => {
            scene.step_check = StepCheck::None;
            TimeStep::fraction(0.9)
        }
    };

    let body = &mut scene.projectile;
    let shapes = [
        Shape::Sphere,
        Shape::Cylinder,
        Shape::HemisphericalCylinder,
        Shape::Box,
        Shape::Polyhedron,
        Shape::DiscSector,
    ];
    body.shape = bytes.choose(&shapes);
    body.radius = h * bytes.choose(&[1.0, 1.5, 3.0]);
    body.length = 2.5 * body.radius;
    let edge = 2.0 * body.radius;
    body.size = [edge, 1.25 * edge, 1.5 * edge];
    body.mass = bytes.choose(&[8.4e-3, 1e-4, 3e-7]);
    let [a, b, c] = body.size.map(|edge| 0.5 * edge);
    // A box with one edge cut off.
    body.faces = Faces::of(&[
        [1.0, 0.0, 0.0, a],
        [-1.0, 0.0, 0.0, a],
        [0.0, 1.0, 0.0, b],
        [0.0, -1.0, 0.0, b],
        [0.0, 0.0, 1.0, c],
        [0.0, 0.0, -1.0, c],
        [0.6, 0.8, 0.0, 0.9 * (0.6 * a + 0.8 * b)],
    ]);
    body.moments = [b * b + c * c, c * c + a * a, a * a + b * b].map(|squares| body.mass / 3.0 * squares);
    let (inner_radius, outer_radius) = (body.radius, 4.0 * body.radius);
    body.sector = Sector { inner_radius, outer_radius, angle: 1.8, thickness: edge };
    // Far enough from the plane in any orientation, and at times just touching it.
    let nose = match body.shape {
        Shape::Sphere => body.radius,
        Shape::Cylinder => 0.5 * body.length,
        Shape::HemisphericalCylinder => 0.7 * body.length,
        Shape::Box | Shape::Polyhedron => c,
        Shape::DiscSector => 0.5 * body.sector.thickness,
    };
    body.velocity = [0.0, 0.0, bytes.choose(&[100.0, 1000.0, 5000.0, 0.0, -300.0])];
    body.angular_velocity = [0.0; 3];
    body.position = [0.0, 0.0, -nose - h * bytes.choose(&[0.0, 1e-3, 0.1])];
    match bytes.below(4) {
        0 => {}
        1 => {
            (body.orientation, body.position[2]) = ([0.96, 0.28, 0.0, 0.0], -1.6 * body.length);
            body.angular_velocity = [8e4, 0.0, -1.5e5];
        }
        2 => {
            (body.position[0], body.velocity[0]) = (0.6 * h, -100.0);
            body.angular_velocity = [0.0, 1e4, 0.0];
        }
        _ => {
            scene.sheet.position = [1.0, -2.0, 3.0];
            scene.sheet.orientation = [0.5, 0.5, -0.5, 0.5];
            // The sheet's normal in the host's frame: (0.5, 0.5, -0.5, 0.5) turns z into -y.
            let [z, v] = [body.position[2], body.velocity[2]];
            let normal = turned_z(scene.sheet.orientation);
            body.position = [0, 1, 2].map(|k| scene.sheet.position[k] + z * normal[k]);
            body.velocity = normal.map(|n| n * v);
            body.orientation = scene.sheet.orientation;
        }
    }

    match bytes.below(8) {
        0 => {
            scene.integrator =
                Integrator { theta: 0.5, tolerance: 1e-6, max_iterations: MOST_ITERATIONS, ..Integrator::THETA };
            scene.slack_balance = false;
        }
        1 => scene.rotation_rule = RotationRule::theta(0.75),
        2 => {
            scene.symmetry = Symmetry { mirror_x: true, mirror_y: bytes.once_in(2) };
            (scene.yarn.stochastic, scene.drive) = (false, Drive::Free);
        }
        3 => scene.contact_capacity = 1 + bytes.below(8) as u32,
        4 => scene.force_window = 1e-7,
        5 => scene.projectile.mass *= f64::from(u8::from(scene.drive == Drive::Free)),
        6 => {
            scene.sheet.spacing_y = bytes.choose(&[0.0, 0.7, 1.4]) * h;
            scene.sheet.crimp = [bytes.choose(&[0.0, 0.01]), bytes.choose(&[0.0, 0.5])];
            let held = scene.attachment.kind == AttachmentKind::FourSides && !scene.yarn.stochastic;
            if held && scene.sheet.crimp == [0.0; 2] {
                scene.sheet.pre_strain = [0.0005, bytes.choose(&[0.0, 0.0009])];
            }
            let strip = scene.attachment.kind == AttachmentKind::TwoSides
                && (!scene.yarn.stochastic || scene.yarn.draw == Draw::Yarn);
            if bytes.once_in(2) && strip && scene.sheet.crimp[0] == 0.0 {
                scene.sheet.pre_strain = [0.0005, 0.0];
            }
            scene.weft = Weft { modulus_mean: 90e9, damage_intercept: 100.0, ..scene.weft };
        }
        _ => {
            let yarn = &mut scene.yarn;
            (yarn.strength_draw, yarn.weibull_shape) = (StrengthDraw::Weibull, bytes.choose(&[14.7, 1.0, 5.0]));
            yarn.weibull_gauge_length = bytes.choose(&[0.0, 0.05, 1e-5]);
            yarn.weibull_correlation = bytes.choose(&[0.0, 0.3, 1.0]);
        }
    }
    if scene.integrator.kind == IntegratorKind::Verlet && scene.symmetry == Symmetry::default() {
        let plies = bytes.choose(&[1, 1, 2, 5]);
        let gap = h * bytes.choose(&[0.0, 0.3, 1.5]);
        scene.stack = Stack { plies, gap, turned: scene.sheet.spacing_y == 0.0 && plies == 5 };
        if plies == 5 && bytes.once_in(2) {
            scene.back = Back { plies: 2, node_mass: 0.3 * scene.sheet.node_mass, weibull_shape: 5.0, ..scene.back };
        }
    }
    let explicit = scene.integrator.kind == IntegratorKind::Verlet;
    if explicit && bytes.once_in(5) {
        (scene.attachment.hold, scene.attachment.grip, scene.attachment.strength) = (40.0, 0.5 * h, 300.0);
    }
    match bytes.below(4) {
        1 if explicit && scene.stack.plies == 1 => scene.contact.friction = bytes.choose(&[0.3, 1e-3, 10.0]),
        2 if explicit => {
            let yarn = &mut scene.yarn;
            (yarn.viscosity_linear, yarn.viscosity_bending) = (0.06, bytes.choose(&[0.0, 0.06]));
            yarn.viscosity_quadratic = bytes.choose(&[0.0, 0.3]);
        }
        3 if explicit && scene.stack.plies == 1 && scene.sheet.pre_strain == [0.0; 2] => {
            let yarn = &mut scene.yarn;
            (yarn.rate_modulus, yarn.rate_stretch) = (0.13, bytes.choose(&[0.0, 0.16]));
            (yarn.rate_reference, yarn.rate_limit) = (30.0, 170.0);
            (scene.slack_balance, scene.contact.friction) = (false, bytes.choose(&[0.0, 0.3]));
        }
        _ if scene.stack.plies == 1 && bytes.once_in(3) => {
            scene.sheet.grading = Grading { largest: 2, run: 1, centre: [0.0; 2], half_width: [0.3 * h; 2] };
        }
        _ => {}
    }
    curve(&mut scene, bytes.below(8));
    // The body starts as far from the face of the cloth.
    scene.sheet.thickness = h * bytes.choose(&[0.0, 0.0, 1e-3, 0.1]);
    let (normal, body) = (turned_z(scene.sheet.orientation), &mut scene.projectile);
    let place: f64 = (0..3).map(|k| (body.position[k] - scene.sheet.position[k]) * normal[k]).sum();
    let away = 0.5 * scene.sheet.thickness * place.signum();
    body.position = [0, 1, 2].map(|k| body.position[k] + away * normal[k]);
    scene
}

/// An arc, or a ring with or without a case, of a sheet that may be one, hit from outside: in half of the
/// choices below 8.
fn curve(scene: &mut Scene, choice: usize) {
    let (h, kind) = (scene.sheet.spacing, scene.attachment.kind);
    let pulls_in = scene.sheet.pre_strain != [0.0; 2] || kind == AttachmentKind::FourCorners;
    let takes = scene.yarn.rate_modulus != 0.0 || scene.yarn.viscosity_bending != 0.0;
    let other = scene.sheet.grading.largest > 1 || scene.symmetry != Symmetry::default();
    if choice.is_multiple_of(2)
        || pulls_in
        || takes
        || other
        || scene.integrator.kind != IntegratorKind::Verlet
        || scene.sheet.nodes_x < 3
    {
        return;
    }
    scene.sheet.closed = kind != AttachmentKind::TwoSides && choice % 4 == 1;
    scene.sheet.radius = if scene.sheet.closed { scene.closed_radius() } else { 20.0 * h };
    if scene.sheet.closed && choice == 1 {
        let (window_angle, window_place) = ([0.3, 1.0], [0.0, h]);
        scene.casing = Casing { radius: 0.9 * scene.sheet.radius, window_angle, window_place };
    }
    let normal = turned_z(scene.sheet.orientation);
    let along = |a: [f64; 3]| (0..3).map(|k| a[k] * normal[k]).sum::<f64>();
    let reach = scene.sheet.radius + scene.stack_height();
    let body = &mut scene.projectile;
    let place = along([0, 1, 2].map(|k| body.position[k] - scene.sheet.position[k]));
    let speed = along(body.velocity);
    let by = reach - 2.0 * place;
    body.position = [0, 1, 2].map(|k| body.position[k] + by * normal[k]);
    body.velocity = [0, 1, 2].map(|k| body.velocity[k] - 2.0 * speed * normal[k]);
}

/// Where a unit quaternion turns the z axis.
fn turned_z([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
}
