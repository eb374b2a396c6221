//! The sheet in plain formulas, written without looking at the kernel's: what the tests compare its numbers
//! with.

use fabric_kernel::Scene;

/// A vector.
pub type V3 = [f64; 3];

/// a + b.
pub fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a - b.
pub fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s a.
pub fn scale(a: V3, s: f64) -> V3 {
    [s * a[0], s * a[1], s * a[2]]
}

/// a . b.
pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b.
pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|.
pub fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// Largest distance between two lists of points, m.
pub fn largest_distance(a: &[V3], b: &[V3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| length(sub(*a, *b))).fold(0.0, f64::max)
}

/// The rotation matrix of a unit quaternion (scalar first), applied to a vector.
pub fn turn(q: [f64; 4], v: V3) -> V3 {
    let [w, x, y, z] = q;
    let rows = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ];
    [dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)]
}

/// The inverse rotation.
pub fn turn_back(q: [f64; 4], v: V3) -> V3 {
    turn([q[0], -q[1], -q[2], -q[3]], v)
}

/// Segments in a row: of a ring one more, from its last node to its first.
fn segments_across(scene: &Scene) -> usize {
    scene.sheet.nodes_x as usize - usize::from(!scene.sheet.closed)
}

/// The two nodes of every segment in the order of the segments' numbers: horizontal row by row, then
/// vertical.
pub fn segment_ends(scene: &Scene) -> Vec<[usize; 2]> {
    let (nx, ny, across) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize, segments_across(scene));
    let along = (0..ny).flat_map(|j| (0..across).map(move |i| [j * nx + i, j * nx + (i + 1) % nx]));
    along.chain((0..(ny - 1) * nx).map(|k| [k, k + nx])).collect()
}

/// Node spacings along x and y, m.
pub fn spacings(scene: &Scene) -> [f64; 2] {
    let sheet = &scene.sheet;
    [sheet.spacing, if sheet.spacing_y == 0.0 { sheet.spacing } else { sheet.spacing_y }]
}

/// Sections of a yarn along x and y, all plies, m^2.
pub fn areas(scene: &Scene) -> [f64; 2] {
    let sheet = &scene.sheet;
    let y = if sheet.yarn_area_y == 0.0 { sheet.yarn_area } else { sheet.yarn_area_y };
    [sheet.yarn_area, y].map(|area| area * f64::from(sheet.plies))
}

/// Natural lengths of a segment along x and y, m.
pub fn natural_lengths(scene: &Scene) -> [f64; 2] {
    let (sheet, h) = (&scene.sheet, spacings(scene));
    [0, 1].map(|k| h[k] * (1.0 + sheet.crimp[k]) / (1.0 + sheet.pre_strain[k]))
}

/// 0 for a horizontal segment, 1 for a vertical one, by its number.
pub fn direction(scene: &Scene, number: usize) -> usize {
    usize::from(number >= segments_across(scene) * scene.sheet.nodes_y as usize)
}

/// Rest positions, m.
pub fn rest_positions(scene: &Scene) -> Vec<V3> {
    let (nx, ny) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize);
    let middle = |n: usize| 0.5 * (n as f64 - 1.0);
    let h = spacings(scene);
    let place = |k: usize| [((k % nx) as f64 - middle(nx)) * h[0], ((k / nx) as f64 - middle(ny)) * h[1], 0.0];
    (0..nx * ny).map(place).collect()
}

/// Which nodes are fixed.
pub fn fixed_nodes(scene: &Scene) -> Vec<bool> {
    let (nx, ny) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize);
    let rest = rest_positions(scene);
    let edge = |k: usize| {
        let (left_right, up_down) = (k.is_multiple_of(nx) || k % nx == nx - 1, k / nx == 0 || k / nx == ny - 1);
        match scene.attachment.kind {
            fabric_kernel::AttachmentKind::Free => false,
            fabric_kernel::AttachmentKind::TwoSides => left_right,
            fabric_kernel::AttachmentKind::FourSides => left_right || up_down,
            fabric_kernel::AttachmentKind::FourCorners => {
                let (x, half) = (rest[k], scene.half_size());
                let (inset, radius) = (scene.attachment.disc_inset, scene.attachment.disc_radius);
                (x[0].abs() - half[0] + inset).hypot(x[1].abs() - half[1] + inset) <= radius
            }
        }
    };
    (0..nx * ny).map(edge).collect()
}

/// Elastic force on every node, N: each segment pulls its ends together with A_0 U S, S = alpha E (U^2 -
/// 1)/2, in tension.
/// `alpha` and the moduli by segment number.
pub fn forces(scene: &Scene, positions: &[V3], alpha: &[f64]) -> Vec<V3> {
    let mut forces = vec![[0.0; 3]; positions.len()];
    let (areas, lengths) = (areas(scene), natural_lengths(scene));
    for (number, ends) in segment_ends(scene).iter().enumerate() {
        let along = sub(positions[ends[1]], positions[ends[0]]);
        let (area, natural) = (areas[direction(scene, number)], lengths[direction(scene, number)]);
        let stretch = length(along) / natural;
        if stretch > 1.0 {
            let modulus = scene.draw_segment(number as u64).expect("drawn").modulus;
            let stress = alpha[number] * modulus * 0.5 * (stretch * stretch - 1.0);
            let force = scale(along, area * stretch * stress / length(along));
            forces[ends[0]] = add(forces[ends[0]], force);
            forces[ends[1]] = sub(forces[ends[1]], force);
        }
    }
    forces
}

/// Principal moments of inertia of the scene's projectile, kg m^2.
pub fn moments(scene: &Scene) -> V3 {
    let body = &scene.projectile;
    let (m, r2) = (body.mass, body.radius * body.radius);
    match body.shape {
        fabric_kernel::Shape::Sphere => [0.4 * m * r2; 3],
        fabric_kernel::Shape::Cylinder => {
            let across = m * (3.0 * r2 + body.length * body.length) / 12.0;
            [across, across, 0.5 * m * r2]
        }
        fabric_kernel::Shape::HemisphericalCylinder => {
            // About the middle of the hemisphere's flat, where the parts meet, then moved to the centre of
            // mass.
            let shank = body.length - body.radius;
            let rod = m * shank / (shank + 2.0 * body.radius / 3.0);
            let there = rod * (0.25 * r2 + shank * shank / 3.0) + (m - rod) * 0.4 * r2;
            let across = there - m * nose(scene) * nose(scene);
            [across, across, 0.5 * rod * r2 + 0.4 * (m - rod) * r2]
        }
        fabric_kernel::Shape::Box => {
            let [a, b, c] = body.size.map(|edge| edge * edge);
            [b + c, c + a, a + b].map(|sum| m * sum / 12.0)
        }
        fabric_kernel::Shape::Polyhedron => body.moments,
        fabric_kernel::Shape::DiscSector => fabric_kernel::Solid::of(body).inertia(m),
    }
}

/// Distance of the hemisphere's centre from the centre of mass of a hemispherical cylinder, along its axis,
/// m.
pub fn nose(scene: &Scene) -> f64 {
    let (r, shank) = (scene.projectile.radius, scene.projectile.length - scene.projectile.radius);
    let (rod, cap) = (shank, 2.0 * r / 3.0);
    (rod * 0.5 * shank - cap * 0.375 * r) / (rod + cap)
}

/// Kinetic energy of the projectile, J.
pub fn projectile_energy(scene: &Scene, motion: &fabric_kernel::Motion) -> f64 {
    let w = turn_back(motion.orientation, motion.angular_velocity);
    let i = moments(scene);
    let spin = i[0] * w[0] * w[0] + i[1] * w[1] * w[1] + i[2] * w[2] * w[2];
    0.5 * scene.projectile.mass * dot(motion.velocity, motion.velocity) + 0.5 * spin
}
