//! Cloth that is thick: contact at half its thickness from the true distance, against closed forms.

use crate::plies::of_ply;
use crate::rings::{radius_of, ring, with_sphere};
use fabric_kernel::{AttachmentKind, Code, Drive, Faces, Projectile, Scene, Shape, Sim, Solid, Stack};
use fabric_tests::reference::{V3, add, cross, dot, length, scale, sub};
use fabric_tests::{cuboid_faces, number, positions, set_off, sim_of, small_sheet, stepped, tetrahedron, velocities};

/// Bits of all motion, energies and outcomes.
fn bits(sim: &Sim<'_>) -> (Vec<u64>, String) {
    let (body, energy) = (sim.projectile().unwrap(), sim.energy().unwrap());
    let nodes = positions(sim).into_iter().chain(velocities(sim)).chain([body.velocity, body.angular_velocity]);
    let text = format!("{energy:?} {:?} {:?}", sim.outcomes(), sim.counters());
    (nodes.flatten().map(f64::to_bits).collect(), text)
}

/// A sphere on thick cloth is the larger sphere, of its mass, on cloth without thickness, to the last bit: on
/// one ply, bonded ones, an arc, a ring on its case, and where it sticks in tow.
#[test]
fn a_sphere_on_thick_cloth_is_a_larger_sphere() {
    let (thickness, radius) = (0.4e-3, 6e-3);
    let ball = |mut scene: Scene, radius: f64| {
        (scene.projectile.radius, scene.projectile.position[2]) = (radius, -6.25e-3);
        scene
    };
    let sheet = small_sheet(41, 100.0);
    let mut curved = sheet;
    (curved.sheet.radius, curved.projectile.position[2]) = (0.05, 0.043);
    let mut case = with_sphere(ring(96, 41), radius + 0.5 * thickness, 100.0, false);
    (case.casing.radius, case.casing.window_angle, case.casing.window_place) =
        (case.sheet.radius, [0.0, 0.9], [0.0, 0.01]);
    for (name, scene, plies) in
        [("flat", ball(sheet, 0.0), 1), ("bonded", ball(sheet, 0.0), 8), ("arc", curved, 1), ("ring", case, 1)]
    {
        let mut thick = scene;
        (thick.projectile.radius, thick.sheet.plies, thick.sheet.thickness) =
            (radius, plies, thickness / f64::from(plies));
        if thick.casing.radius > 0.0 {
            thick.casing.radius -= 0.5 * thickness;
        }
        let mut larger = Scene { sheet: scene.sheet, ..thick };
        larger.sheet.plies = plies;
        (larger.projectile.radius, larger.casing) = (radius + 0.5 * thickness, scene.casing);
        let [thick, larger] = [thick, larger].map(|scene| stepped(&scene, 3000));
        assert!(
            (thick.counters().failed_segments > 0 || name == "ring") && thick.contact().unwrap().work > 0.0,
            "{name}"
        );
        assert!(bits(&thick) == bits(&larger), "{name}");
    }
}

/// A face on thick cloth is a face half the thickness farther ahead, to the last bit, while it covers the
/// sheet.
#[test]
fn a_face_on_thick_cloth_is_a_face_ahead() {
    let end = |thickness: f64, ahead: f64| {
        let mut scene = small_sheet(11, 80.0);
        scene.sheet.thickness = thickness;
        let faces = cuboid_faces([0.02, 0.02, ahead]);
        let body = Projectile { shape: Shape::Polyhedron, faces, moments: [1e-6; 3], ..scene.projectile };
        scene.projectile = Projectile { position: [0.0, 0.0, -0.0101], ..body };
        let sim = stepped(&scene, 600);
        assert!(sim.contact().unwrap().work > 0.0);
        bits(&sim)
    };
    assert!(end(0.125e-3, 0.01) == end(0.0, 0.01 + 0.0625e-3));
}

/// A node at the distance s beside a straight edge, which lies in the plane of a face, touches when that is
/// sqrt(t^2/4 - s^2) above it.
#[test]
fn an_edge_is_rounded_by_half_the_thickness() {
    let (t, speed) = (0.5e-3, 100.0);
    for shape in [Shape::Box, Shape::Polyhedron, Shape::Cylinder] {
        for s in [0.0, 0.06e-3, 0.15e-3, 0.24e-3] {
            let mut scene = small_sheet(41, 0.0);
            (scene.attachment.kind, scene.sheet.thickness) = (AttachmentKind::TwoSides, t);
            let (a, height) = (8e-3, (0.25 * t * t - s * s).sqrt());
            let body = Projectile { shape, size: [0.05, 2.0 * a, 0.01], radius: a, length: 0.01, ..scene.projectile };
            let body = Projectile { faces: cuboid_faces([0.025, a, 5e-3]), moments: [1e-6; 3], ..body };
            // The round body has one node before its middle.
            let beside = scene.half_size()[1] + a + s;
            scene.projectile =
                Projectile { position: [0.0, beside, -5e-3 - height - 1e-5], velocity: [0.0, 0.0, speed], ..body };
            let mut sim = sim_of(&scene);
            let dt = sim.step_limits().dt;
            sim.advance((1e-5 / (speed * dt)) as u64).unwrap();
            assert_eq!(sim.contact().unwrap().work, 0.0, "{shape:?} {s:e}");
            sim.advance(2).unwrap();
            assert!(sim.contact().unwrap().work > 0.0, "{shape:?} {s:e}");
        }
    }
}

/// Planes of a body with 16 faces: a prism of twelve sides with a chisel.
fn chisel() -> Vec<[f64; 4]> {
    let side = |k: u32| (f64::from(k) * std::f64::consts::PI / 6.0).sin_cos();
    let sides = (0..12).map(side).map(|(sine, cosine)| [cosine, sine, 0.0, 2.7e-3]);
    let slope = 35f64.to_radians();
    let roof = [1.0, -1.0].map(|sign| [0.0, sign * slope.cos(), slope.sin(), 3e-3]);
    sides.chain(roof).chain([[0.0, 0.0, 1.0, 3.2e-3], [0.0, 0.0, -1.0, 3.2e-3]]).collect()
}

/// Nearest point of {x : n.x <= b} to a point outside, by quadratic programming: the nearest of the feet on
/// planes, on lines where two meet and of the points where three do, as far as these lie in all half-spaces.
fn nearest(planes: &[[f64; 4]], corners: &[V3], p: V3) -> V3 {
    let plane = |k: usize| ([planes[k][0], planes[k][1], planes[k][2]], planes[k][3]);
    let mut feet = corners.to_vec();
    for i in 0..planes.len() {
        let (n, b) = plane(i);
        let g = dot(n, p) - b;
        feet.push(sub(p, scale(n, g)));
        for j in 0..i {
            let (m, c) = plane(j);
            let (h, cosine) = (dot(m, p) - c, dot(n, m));
            let determinant = 1.0 - cosine * cosine;
            if determinant > 1e-9 {
                let [x, y] = [(g - cosine * h) / determinant, (h - cosine * g) / determinant];
                feet.push(sub(p, add(scale(n, x), scale(m, y))));
            }
        }
    }
    let inside = feet.into_iter().filter(|&x| (0..planes.len()).all(|k| dot(plane(k).0, x) - plane(k).1 < 2e-15));
    inside.min_by(|&a, &b| length(sub(p, a)).total_cmp(&length(sub(p, b)))).unwrap()
}

fn corners(planes: &[[f64; 4]]) -> Vec<V3> {
    let (mut found, n) = (Vec::new(), |k: usize| [planes[k][0], planes[k][1], planes[k][2]]);
    for i in 0..planes.len() {
        for j in 0..i {
            for k in 0..j {
                let volume = dot(n(i), cross(n(j), n(k)));
                if volume.abs() > 1e-6 {
                    let parts = [(i, j, k), (j, k, i), (k, i, j)]
                        .map(|(a, b, c)| scale(cross(n(b), n(c)), planes[a][3] / volume));
                    found.push(add(parts[0], add(parts[1], parts[2])));
                }
            }
        }
    }
    found
}

/// Distances of 100 000 points from bodies with faces, and their normals, against quadratic programming.
#[test]
fn distances_are_those_of_the_nearest_point() {
    let base = small_sheet(2, 0.0).projectile;
    let of = |planes: &[[f64; 4]]| Projectile {
        shape: Shape::Polyhedron,
        faces: Faces::of(planes),
        moments: [1e-6; 3],
        ..base
    };
    let sector = Scene::turbine_disc_sector().projectile;
    let random: Vec<[f64; 4]> = (0..16)
        .map(|k| {
            let n: V3 = [0, 1, 2].map(|m| number(100 * k + m) - 0.5);
            let n = scale(n, 1.0 / length(n));
            [n[0], n[1], n[2], 4e-3 + 2e-3 * number(100 * k + 3)]
        })
        .collect();
    let cuboid = Projectile { shape: Shape::Box, size: [0.01, 0.016, 0.024], ..base };
    let box_planes = cuboid_faces([5e-3, 8e-3, 0.012]);
    let mut worst = [0.0f64; 2];
    for (name, body, planes) in [
        ("box", cuboid, box_planes.in_use()),
        ("chisel", of(&chisel()), &chisel()[..]),
        ("sector", sector, sector.faces.in_use()),
        ("tetrahedron", of(tetrahedron(4e-3).in_use()), tetrahedron(4e-3).in_use()),
        ("random", of(&random), &random[..]),
    ] {
        let (solid, corners) = (Solid::of(&body), corners(planes));
        let (size, mut outside) = (solid.reach(), 0);
        for k in 0..20_000 {
            let p: V3 = [0, 1, 2].map(|m| 3.0 * size * (number(3 * k + m) - 0.5));
            let gap = solid.gap(&p.into());
            if gap.distance > 0.0 {
                let way = sub(p, nearest(planes, &corners, p));
                let (distance, normal) = (length(way), scale(way, 1.0 / length(way)));
                worst[0] = worst[0].max((gap.distance - distance).abs() / size);
                worst[1] = worst[1].max(length(sub(gap.normal.into(), normal)) * distance / size);
                outside += 1;
            }
        }
        assert!(outside > 10_000, "{name}: {outside}");
    }
    println!("distances off by {:.0e} of the size (allowed 1e-13), normals by {:.0e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-13 && worst[1] < 1e-12, "{worst:?}");
}

/// Plies of thickness t that a prescribed face pushes together from one side, and the last of them flies on
/// from the other: none comes nearer to the face or to the next than its thickness, and at last all lie on
/// each other.
#[test]
fn plies_come_no_nearer_than_their_thickness() {
    let (n, t, gap) = (5u32, 0.2e-3, 0.1e-3);
    let mut scene = small_sheet(11, 20.0);
    (scene.stack, scene.sheet.thickness) = (Stack { plies: n, gap, turned: false }, t);
    (scene.attachment.kind, scene.drive) = (AttachmentKind::Free, Drive::Prescribed);
    let body = Projectile { shape: Shape::Box, size: [0.04, 0.04, 0.01], ..scene.projectile };
    scene.projectile = Projectile { position: [0.0, 0.0, -5e-3 - 0.5 * t - 1e-5], ..body };
    let mut sim = sim_of(&scene);
    let nodes = sim.layout().nodes() / n as usize;
    let pitch = |sim: &Sim<'_>, ply: usize| of_ply(sim, ply)[0][2] - of_ply(sim, ply - 1)[0][2];
    assert!((1..n as usize).all(|ply| (pitch(&sim, ply) - t - gap).abs() < 1e-18), "at rest");
    set_off(&mut sim, |k, x| [x, [0.0, 0.0, if k / nodes == n as usize - 1 { -20.0 } else { 0.0 }]]);
    let steps = (5.0 * gap / 20.0 / sim.step_limits().dt) as u64;
    let mut least = f64::INFINITY;
    for _ in 0..steps {
        sim.step().unwrap();
        let face = sim.projectile().unwrap().position[2] + 5e-3;
        let first = of_ply(&sim, 0).iter().map(|x| x[2] - face).fold(f64::INFINITY, f64::min);
        assert!(first > 0.5 * t - 1e-12, "{first:e} {:?}", sim.counters());
        let whole = of_ply(&sim, n as usize - 1)[60][2] - face + 0.5 * t;
        (1..n as usize).for_each(|ply| assert!(pitch(&sim, ply) > t - 1e-12, "{ply}: {:e}", pitch(&sim, ply)));
        least = least.min(whole);
    }
    println!("{n} plies pressed to {:.12} of their thickness", least / (f64::from(n) * t));
    assert!((least / (f64::from(n) * t) - 1.0).abs() < 1e-9);
}

/// What contradicts a thickness is refused: a body that starts within half of it, cloth thicker than a tenth
/// of the sheet, a case that would be inside of it.
#[test]
fn contradictions_are_refused() {
    let refusal = |scene: &Scene| scene.check_start().map_err(|error| (error.code, error.field));
    let mut scene = small_sheet(41, 60.0);
    scene.projectile.position[2] = -scene.projectile.radius - 0.1e-3;
    for (thickness, plies, expected) in [
        (0.19e-3, 1, Ok(())),
        (0.21e-3, 1, Err((Code::InitialOverlap, "projectile.position"))),
        (0.05e-3, 5, Err((Code::InitialOverlap, "projectile.position"))),
        (3e-3, 1, Err((Code::OutOfRange, "sheet.thickness"))),
        (0.3e-3, 10, Err((Code::OutOfRange, "sheet.thickness"))),
        (-1e-4, 1, Err((Code::OutOfRange, "sheet.thickness"))),
        (f64::NAN, 1, Err((Code::NotFinite, "sheet.thickness"))),
    ] {
        (scene.sheet.thickness, scene.sheet.plies) = (thickness, plies);
        assert_eq!(refusal(&scene), expected, "{thickness} {plies}");
    }
    let mut case = with_sphere(ring(96, 41), 6e-3, 100.0, false);
    (case.casing.radius, case.sheet.thickness) = (case.sheet.radius, 0.2e-3);
    case.projectile.position[2] += 1e-3;
    assert_eq!(refusal(&case), Err((Code::OutOfRange, "casing.radius")));
    case.casing.radius -= 0.1e-3;
    assert_eq!(refusal(&case), Ok(()));
    let sim = stepped(&case, 10);
    assert!(positions(&sim).into_iter().all(|x| (radius_of(x) / case.sheet.radius - 1.0).abs() < 1e-12));
}
