//! Flat faces that slide over held nodes: the nodes take the motion along the face's normal and leave the
//! rest as it is.

use crate::contact::gap;
use fabric_kernel::{Energy, Faces, Projectile, Scene, Sector, Shape, Sim, Solid, TimeStep, pose};
use fabric_tests::reference::{V3, add, cross, length, sub};
use fabric_tests::{close, number, sim_of, small_sheet};
use rayon::prelude::*;
use std::cell::Cell;

/// Gaps between a face and the nodes below it, parts of R: touching, and off by a rounding or by what
/// roundings add up to.
const GAPS: [f64; 5] = [0.0, 1e-16, -1e-16, 1e-12, -1e-12];

fn spacing() -> f64 {
    small_sheet(2, 0.0).sheet.spacing
}

/// Held nodes, and a body that slides over them. All is given in axes of its own, in which the flat face
/// looks along z, and is turned by `turn` into the sheet's.
struct Slide {
    points: Vec<V3>,
    body: Projectile,
    turn: [f64; 4],
    friction: f64,
}

impl Slide {
    fn turned(&self, v: V3) -> V3 {
        pose::rotate(&pose::normalised(self.turn), &v.into()).into()
    }

    /// A place in the sheet's frame: beside the flat sheet, where the body may not start.
    fn placed(&self, x: V3) -> V3 {
        add(self.turned(x), [0.0, 0.0, if self.turn == turns()[0] { 0.0 } else { 100.0 * spacing() }])
    }

    /// A place of the sheet's frame in the axes of the slide.
    fn lifted(&self, x: V3) -> V3 {
        self.back(sub(x, self.placed([0.0; 3])))
    }

    /// A vector of the sheet's frame in the axes of the slide.
    fn back(&self, v: V3) -> V3 {
        pose::into_body(&pose::normalised(self.turn), &v.into()).into()
    }

    fn scene(&self) -> Scene {
        let mut scene = small_sheet(2, 0.0);
        scene.sheet.nodes_x = self.points.len().div_ceil(2).max(2) as u32;
        scene.time_step = TimeStep::fraction(0.5);
        scene.contact.friction = self.friction;
        let body = self.body;
        let orientation = pose::normalised(self.turn) * pose::normalised(body.orientation);
        scene.projectile = Projectile {
            position: self.placed(body.position),
            velocity: self.turned(body.velocity),
            angular_velocity: self.turned(body.angular_velocity),
            orientation: pose::components(&orientation),
            ..body
        };
        scene
    }

    /// Runs over a way, m, under a load, N, in the sheet's axes, and checks every step. Energies are those
    /// after the last step with an impulse, and at the end: what rubs and what the body has change by nothing
    /// else.
    fn run(&self, load: V3, way: f64, check: impl Fn(&Sim<'_>, &Energy, &str), name: &str) {
        let scene = self.scene();
        let mut sim = sim_of(&scene);
        let mut x = vec![[1e3 * spacing(), 0.0, 0.0]; sim.layout().nodes()];
        for (place, point) in x.iter_mut().zip(&self.points) {
            *place = self.placed(*point);
        }
        // Broken yarns pull at nothing.
        let broken = vec![2.0; sim.layout().segments()];
        sim.set_largest_stretch(&broken).unwrap();
        sim.set_motion(x.as_flattened(), &vec![0.0; 3 * x.len()]).unwrap();
        sim.set_external_load(load, [0.0; 3]).unwrap();
        let speed = length(self.body.velocity);
        let steps = (way / (speed * sim.step_limits().dt)) as u64;
        let (mut energy, mut impulse) = (sim.energy().unwrap(), [0.0; 3]);
        for step in 1..=steps {
            sim.step().unwrap();
            let last = std::mem::replace(&mut impulse, sim.contact().unwrap().impulse);
            if impulse != last || load != [0.0; 3] || step == steps {
                energy = sim.energy().unwrap();
            }
            check(&sim, &energy, name);
        }
    }
}

/// Bodies that look along z with a flat face, and how far that is from the centre of mass, m: a box, a prism
/// over an uneven pentagon, a polyhedron with slanting sides, a cylinder on its end, one with a hemisphere
/// above its flat end, and a sector of a disc.
fn bodies() -> [(Projectile, f64); 6] {
    let (h, base) = (spacing(), Projectile { mass: 0.01, ..small_sheet(2, 0.0).projectile });
    let cuboid = Projectile { shape: Shape::Box, size: [20.0 * h, 6.0 * h, 8.0 * h], ..base };
    let (n, m) = (0.8, 0.6);
    let sides = [[0.0, -1.0, 4.0], [n, -m, 8.0], [m, n, 7.0], [-0.28, 0.96, 5.0], [-0.96, -0.28, 9.0]];
    let sides = sides.map(|[x, y, distance]| [x, y, 0.0, distance * h]);
    let faces = Faces::of(&[&sides[..], &[[0.0, 0.0, 1.0, 3.5 * h], [0.0, 0.0, -1.0, 3.5 * h]]].concat());
    let pentagon = Projectile { shape: Shape::Polyhedron, faces, moments: [6e-8, 1.3e-7, 1.5e-7], ..base };
    let sides = [[n, 0.0, -m, 6.0 * h], [-n, 0.0, -m, 6.0 * h], [0.0, n, m, 4.0 * h], [0.0, -n, m, 4.0 * h]];
    let faces = Faces::of(&[&sides[..], &[[0.0, 0.0, 1.0, 3.0 * h], [0.0, 0.0, -1.0, 3.0 * h]]].concat());
    let slanting = Projectile { shape: Shape::Polyhedron, faces, moments: [3e-8, 7e-8, 8e-8], ..base };
    let cylinder = Projectile { shape: Shape::Cylinder, radius: 5.0 * h, length: 7.0 * h, ..base };
    // Half a turn about x: its flat end looks along -z.
    let (shape, orientation) = (Shape::HemisphericalCylinder, [0.0, 1.0, 0.0, 0.0]);
    let bullet = Projectile { shape, orientation, radius: 6.0 * h, length: 9.0 * h, ..base };
    let flat_end = Solid::of(&bullet).support(&[0.0, 0.0, -1.0].into());
    let sector = Sector { inner_radius: 2.0 * h, outer_radius: 12.0 * h, angle: 1.5, thickness: 5.0 * h };
    let sector = Projectile { shape: Shape::DiscSector, sector, ..base };
    [
        (cuboid, 4.0 * h),
        (pentagon, 3.5 * h),
        (slanting, 3.0 * h),
        (cylinder, 3.5 * h),
        (bullet, flat_end),
        (sector, 2.5 * h),
    ]
}

/// Nodes on straight rails along x at these y, from `first` to `last` in spacings, at the height 0.
fn rails(places: &[f64], first: i32, last: i32) -> Vec<V3> {
    let h = spacing();
    places.iter().flat_map(|y| (first..=last).map(move |i| [f64::from(i) * h, y * h, 0.0])).collect()
}

/// Turns of the whole: none, and some that leave no number round.
fn turns() -> [[f64; 4]; 3] {
    [[1.0, 0.0, 0.0, 0.0], [0.9, 0.1, -0.3, 0.2], [0.3, -0.8, 0.1, 0.5]]
}

/// Speed at which the widest of the gaps at the start closes within the first step, m/s: so much is left
/// after it, and goes in the next.
/// With it what rounding leaves of gaps, four last places of where the body is.
fn closing(slide: &Slide, sim: &Sim<'_>) -> f64 {
    let rounding = 4.0 * f64::EPSILON * length(sim.projectile().unwrap().position);
    (1e-12 * slide.body.position[2].abs() + rounding) / sim.step_limits().dt
}

/// What a body must have after its face has landed. The face takes M V_z along its normal, and mu M V_z
/// against its way, at the height d below the middle. Impulses of the nodes can hold the moment mu M V_z d as
/// long as mu d is less than the face reaches on over the nodes ahead of the middle; then the body does not
/// tip, and goes on at V_x - mu V_z. What is rubbed away is mu M V_z times the mean of both velocities.
fn lands_and_slides(slide: &Slide, sim: &Sim<'_>, energy: &Energy, name: &str) {
    let (mass, mu, [x, _, z]) = (slide.body.mass, slide.friction, slide.body.velocity);
    let (motion, left) = (sim.projectile().unwrap(), closing(slide, sim));
    let (v, w) = (slide.back(motion.velocity), slide.back(motion.angular_velocity));
    assert!(length(sub(v, [x - mu * z, 0.0, 0.0])) < (1.0 + mu) * left, "{name}: {v:?}");
    assert!(length(w) * spacing() < left, "{name}: {w:?}");
    close(sim.contact().unwrap().loss, 0.5 * mass * z * z, 1e-8);
    if mu > 0.0 {
        close(energy.friction, mu * mass * z * (x - 0.5 * mu * z), 1e-8 + left / z);
    }
    let counters = sim.counters();
    assert_eq!(counters.unconverged, 0, "{name}: {:e}", counters.contact_residual);
    assert!(counters.worst_penetration < 2e-9 * spacing(), "{name}: {:e}", counters.worst_penetration);
}

/// Two rails, one below the middle, and three: a body whose face comes down on them at 10 m/s while it goes
/// along at 100 m/s loses M V_z^2/2 and goes on along, from node to node; with friction it loses what Coulomb
/// says.
#[test]
fn a_face_goes_on_over_held_rails() {
    let h = spacing();
    let smooth = [&[-0.5, 0.5][..], &[0.0], &[-2.0, 0.3, 2.0]].map(|places| (places, 0.0));
    let rough = [0.1, 0.3].map(|mu| (&[-1.0, 1.5][..], mu));
    for (b, (body, below)) in bodies().into_iter().enumerate() {
        for (p, (places, friction)) in smooth.into_iter().chain(rough).enumerate() {
            for (g, gap) in GAPS.into_iter().enumerate() {
                // With one of the turns: each choice of any three of the four occurs.
                let turn = turns()[(b + p + g) % 3];
                // Narrow enough for the face, and long enough for the way.
                let way = 10;
                let points = rails(places, -3 * way / 2, 2 * way);
                let position = [-0.5 * f64::from(way) * h, 0.0, -below - gap * below];
                let body = Projectile { position, velocity: [100.0, 0.0, 10.0], ..body };
                let slide = Slide { points, body, turn, friction };
                let name = format!("{:?} {places:?} {friction} {gap:e} {turn:?}", body.shape);
                slide.run(
                    [0.0; 3],
                    f64::from(way) * h,
                    |sim, energy, name| lands_and_slides(&slide, sim, energy, name),
                    &name,
                );
            }
        }
    }
}

/// A box on a row of the nodes of a sheet held on four sides, and on two of them: what its face does not meet
/// it does not lose.
#[test]
fn a_box_loses_what_the_rows_of_a_sheet_stop() {
    let h = spacing();
    for (velocity, row, width, lost) in [([100.0, 0.0, 10.0], 0.0, 6.0, 0.5), ([30.0, 0.0, 20.0], 0.5, 1.9, 2.0)] {
        let mut scene = small_sheet(201, 0.0);
        scene.sheet.nodes_y = 2;
        let (size, position) = ([20.0 * h, width * h, 8.0 * h], [-60.0 * h, row * h, -4.0 * h]);
        let size = size.map(|edge| edge.max(2.0 * h));
        scene.projectile = Projectile { shape: Shape::Box, size, mass: 0.01, velocity, position, ..scene.projectile };
        let mut sim = sim_of(&scene);
        sim.advance((50.0 * h / (velocity[0] * sim.step_limits().dt)) as u64).unwrap();
        let (contact, along) = (sim.contact().unwrap(), sim.projectile().unwrap().velocity[0]);
        println!("{velocity:?}: {along} m/s, lost {} J", contact.loss);
        close(contact.loss, lost, 1e-9);
        close(along, velocity[0], 1e-9);
    }
}

/// A rough box under a steady load W, its only weight, slides from node to node and is slowed down by mu W/M.
#[test]
fn a_rough_box_under_load_is_slowed_down_by_coulomb_from_node_to_node() {
    let (h, mu, load, speed) = (spacing(), 0.2, 1000.0, 50.0);
    let [(body, below), ..] = bodies();
    let body = Projectile { size: [5.0 * h, 6.0 * h, 2.0 * h], velocity: [speed, 0.0, 0.0], ..body };
    let body = Projectile { position: [-4.0 * h, 0.0, -0.25 * below], ..body };
    let slide = Slide { points: rails(&[-2.0, 2.0], -7, 7), body, turn: turns()[0], friction: mu };
    slide.run(
        [0.0, 0.0, load],
        6.0 * h,
        |sim, energy, name| {
            let v = sim.projectile().unwrap().velocity;
            let left = speed - mu * load / body.mass * sim.time();
            assert!(length(sub(v, [left, 0.0, 0.0])) < 1e-7 * speed, "{name}: {v:?} {left}");
            let rubbed = 0.5 * body.mass * (speed * speed - left * left);
            assert!((energy.friction - rubbed).abs() < 1e-7 * rubbed, "{name}");
        },
        "loaded",
    );
}

/// With an edge down in a groove of held nodes, along which it slides: two faces stop what is across the
/// groove, and no more.
#[test]
fn an_edge_goes_on_along_a_groove_of_held_nodes() {
    let (h, r) = (spacing(), 0.5f64.sqrt());
    let [(body, _), ..] = bodies();
    // Each wall of the groove holds rails at these distances from its bottom.
    let [width, height] = [6.0, 8.0];
    let mut points = Vec::new();
    for at in [1.0, 2.9, 4.7] {
        points.extend(
            rails(&[0.0], -30, 40)
                .into_iter()
                .flat_map(|[x, ..]| [[x, r * at * h, -r * at * h], [x + 0.3 * h, -r * at * h, -r * at * h]]),
        );
    }
    for (gap, turn) in GAPS.into_iter().flat_map(|gap| turns().map(|turn| (gap, turn))) {
        // An eighth of a turn about x; then +y and +z look down into the groove.
        let (half_cosine, half_sine) = ((0.5 + 0.5 * r).sqrt(), (0.5 - 0.5 * r).sqrt());
        let orientation = [half_cosine, half_sine, 0.0, 0.0];
        let down = [0.5 * width * h, 0.5 * height * h].map(|reach| reach * (1.0 + gap));
        // The middle is that far from both walls, which look along (0, r, -r) and (0, -r, -r).
        let position = [-10.0 * h, r * (down[1] - down[0]), -r * (down[0] + down[1])];
        let body = Projectile { orientation, position, velocity: [100.0, 1.0, 10.0], ..body };
        let slide = Slide { points: points.clone(), body, turn, friction: 0.0 };
        let check = |sim: &Sim<'_>, _: &Energy, name: &str| {
            let motion = sim.projectile().unwrap();
            let v = slide.back(motion.velocity);
            assert!(length(sub(v, [100.0, 0.0, 0.0])) < 2.0 * closing(&slide, sim), "{name}: {v:?}");
            close(sim.contact().unwrap().loss, 0.5 * body.mass * (1.0 + 100.0), 1e-7);
        };
        slide.run([0.0; 3], 20.0 * h, check, &format!("{gap:e} {turn:?}"));
    }
}

/// Random boxes with any spin come down flush on a held grid, at any angle to it, and the whole at any angle
/// to the sheet's axes.
///
/// The impulses act along the face's normal, which is a principal axis: they change V_z and the spin about x
/// and y, and not the motion in the face's plane. So the loss is at most what these three hold,
/// E = M V_z^2/2 + (I_x w_x^2 + I_y w_y^2)/2. It is all of it if impulses of the nodes can stop the three:
/// pushes, whose
/// sum is M V_z at the centre of percussion (I_y w_y, -I_x w_x)/(M V_z). They can if that point lies within
/// the hull of the nodes under the face, and then rest is the solution, which is unique. All four nodes of
/// the mesh around a point lie within sqrt(2) h of it: the hull holds the face less a rim of sqrt(2) h. At
/// rest along z the face stays in its plane and meets no node any more, however it turns about z.
///
/// With friction the pushes' sum P = M V_z must stop the spin about x and y against the moment of friction,
/// too: the centre of percussion moves on by at most mu d along the way, d the height of the middle, and must
/// stay within the hull. Friction is at most mu P.
///
/// Every other box spins about the axis across its way alone, if at all. The centre of percussion is then on
/// the line of the way, all nodes slide along it, and the body goes on at V - mu V_z without spin. The moment
/// of friction, mu P d about the axis across, works on the spin w there: of the loss of both, mu P d w/2 goes
/// from the pushes to friction.
#[test]
fn random_boxes_on_a_held_grid_lose_the_motion_along_the_normal_and_what_coulomb_says() {
    let h = spacing();
    (0..80_u64).into_par_iter().for_each(|k| {
        let smooth = k < 40;
        let draw = |m: u64| 2.0 * number(100 * k + m) - 1.0;
        let between = |m: u64, low: f64, high: f64| 0.5 * (low + high) + 0.5 * (high - low) * draw(m);
        let (least, highest) = if smooth { (4.0, 8.0) } else { (6.0, 4.0) };
        let size = [between(0, least, 12.0) * h, between(1, least, 9.0) * h, between(2, 2.0, highest) * h];
        let (mass, speed, heading) =
            (between(3, 1e-3, 2e-2), between(4, 30.0, 800.0), between(5, 0.0, std::f64::consts::TAU));
        let (down, yaw) = (speed * between(6, 0.01, 0.3), between(10, 0.0, std::f64::consts::TAU));
        let [i, j] = [0, 1].map(|axis| mass * (size[1 - axis] * size[1 - axis] + size[2] * size[2]) / 12.0);
        let (room, d) = (0.95 * (0.5 * size[0].min(size[1]) - 2f64.sqrt() * h), 0.5 * size[2]);
        let mu = if smooth { 0.0 } else { between(7, 0.05, 0.5f64.min(0.5 * room / d)) };
        // The centre of percussion without friction, from the middle of the face, in the body's axes.
        let (ahead, way) = ((room - mu * d) * draw(8), [(heading - yaw).cos(), (heading - yaw).sin()]);
        let straight = k % 2 == 0;
        let [p, q] = if straight { way.map(|x| x * ahead) } else { [ahead * draw(9).cos(), ahead * draw(9).sin()] };
        let about_z = if straight { 0.0 } else { 0.3 * speed / size[0] * draw(17) };
        let local = [-q * mass * down / i, p * mass * down / j, about_z];
        let orientation = [(0.5 * yaw).cos(), 0.0, 0.0, (0.5 * yaw).sin()];
        let gap = GAPS[k as usize % GAPS.len()];
        let position = [between(11, -1.0, 1.0) * h, between(12, -1.0, 1.0) * h, -d * (1.0 + gap)];
        let velocity = [speed * heading.cos(), speed * heading.sin(), down];
        let angular_velocity = pose::rotate(&pose::normalised(orientation), &local.into()).into();
        let base = small_sheet(2, 0.0).projectile;
        let body =
            Projectile { shape: Shape::Box, size, mass, position, velocity, orientation, angular_velocity, ..base };
        let (reach, way_on) = if smooth { (18, 8.0 * h) } else { (12, 3.0 * h) };
        let rows: Vec<f64> = (-reach..=reach).map(f64::from).collect();
        let turn = if k % 3 == 0 { turns()[0] } else { [draw(13), draw(14), draw(15), draw(16)] };
        let slide = Slide { points: rails(&rows, -reach, reach), body, turn, friction: mu };
        let kinetic = 0.5 * mass * (speed * speed + down * down);
        let turning = 0.5 * (i * local[0] * local[0] + j * local[1] * local[1]);
        let spinning = 0.5 * mass * (size[0] * size[0] + size[1] * size[1]) / 12.0 * about_z * about_z;
        let across = way[0] * local[1] - way[1] * local[0];
        let shifted = 0.5 * mu * mass * down * d * across;
        let check = |sim: &Sim<'_>, energy: &Energy, name: &str| {
            let motion = sim.projectile().unwrap();
            let (v, w) = (slide.back(motion.velocity), slide.back(motion.angular_velocity));
            let ([loss, rubbed], most) = ([sim.contact().unwrap().loss, energy.friction], mu * down);
            let near = (1.0 + mu) * closing(&slide, sim);
            let slowed = length(sub([v[0], v[1], 0.0], [velocity[0], velocity[1], 0.0]));
            assert!(v[2].abs() < near, "{name}: {v:?}");
            assert!(length([w[0], w[1], 0.0]) * h < near, "{name}: {w:?}");
            assert!(slowed < most + near, "{name}: slowed by {slowed} m/s of {most}");
            let left = energy.projectile_kinetic + loss + rubbed;
            assert!((kinetic + turning + spinning - left).abs() < 1e-9 * (kinetic + turning), "{name}: {left} J");
            if smooth {
                let along = [velocity[0], velocity[1], 0.0];
                assert!(length(sub(v, along)) < 1e-9 * speed, "{name}: {v:?} of {velocity:?}");
                assert!(length(sub(w, [0.0, 0.0, local[2]])) * h < 1e-9 * speed, "{name}: {w:?} of {local:?}");
                assert!((loss - 0.5 * mass * down * down - turning).abs() < 1e-9 * mass * speed * speed, "{name}");
            }
            if straight {
                let left = [heading.cos(), heading.sin(), 0.0].map(|x| x * (speed - most));
                assert!(length(sub(v, left)) < near, "{name}: {v:?} {left:?}");
                let pushed = 0.5 * mass * down * down + turning - shifted;
                assert!((loss - pushed).abs() < 1e-9 * (kinetic + turning), "{name}: lost {loss} J of {pushed}");
                let coulomb = most * mass * (speed - 0.5 * most) + shifted;
                assert!(
                    (rubbed - coulomb).abs() < 1e-9 * (kinetic + turning),
                    "{name}: rubbed {rubbed} J of {coulomb}"
                );
            }
        };
        slide.run([0.0; 3], way_on, check, &format!("{k}"));
    });
}

/// Boxes come down on a held grid with their rear first, rock and slap down on it while they slide forward.
///
/// In every step all impulses act along the normal of the face at the step's start, until the lower edge in
/// front comes below the grid, where nodes really meet the side in front. By less than twice the depth of the
/// others it is below by the error of turning.
#[test]
fn tilted_boxes_are_pushed_along_the_normal_of_their_face() {
    let h = spacing();
    let mut slid = 0;
    for k in 0..16 {
        let between = |m: u64, low: f64, high: f64| {
            0.5 * (low + high) + 0.5 * (high - low) * (2.0 * number(7000 + 100 * k + m) - 1.0)
        };
        let size = [between(0, 8.0, 14.0) * h, between(1, 4.0, 9.0) * h, between(2, 2.0, 6.0) * h];
        let (mass, speed, tilt) = (between(3, 1e-3, 2e-2), between(4, 30.0, 500.0), between(5, 1e-3, 0.03));
        let reach = 0.5 * (size[0] * tilt.sin() + size[2] * tilt.cos());
        let body = Projectile {
            shape: Shape::Box,
            size,
            mass,
            position: [between(6, -14.0, -10.0) * h, between(7, -1.0, 1.0) * h, -reach],
            velocity: [speed, 0.0, speed * between(8, 0.02, 0.2)],
            orientation: [(0.5 * tilt).cos(), 0.0, (0.5 * tilt).sin(), 0.0],
            ..small_sheet(2, 0.0).projectile
        };
        let rows: Vec<f64> = (-6..=6).map(f64::from).collect();
        let slide = Slide { points: rails(&rows, -24, 24), body, turn: turns()[k as usize % 3], friction: 0.0 };
        // Impulse so far and the face's normal, steps flush with the grid, whether the front comes below it
        // and has struck nodes.
        let (scene, placed) = (slide.scene(), slide.points.iter().map(|x| slide.placed(*x)).collect::<Vec<V3>>());
        let (last, flush) = (Cell::new([[0.0; 3]; 2]), Cell::new(0));
        let (below, struck) = (Cell::new(true), Cell::new(false));
        let check = |sim: &Sim<'_>, _: &Energy, name: &str| {
            let motion = sim.projectile().unwrap();
            let in_slide = |v: V3| slide.back(pose::rotate(&pose::quaternion(motion.orientation), &v.into()).into());
            let [before, normal] = last.replace([sim.contact().unwrap().impulse, in_slide([0.0, 0.0, 1.0])]);
            let taken = slide.back(sub(sim.contact().unwrap().impulse, before));
            let off = length(cross(taken, normal));
            let along_normal = off < 1e-9 * mass * speed;
            assert!(below.get() || along_normal, "{name}: {taken:?} {normal:?}");
            struck.set(struck.get() || !along_normal);
            // The lower edge in front, now and as it goes on in the next step.
            let arm = in_slide([0.5 * size[0], 0.0, 0.5 * size[2]]);
            let [v, w] = [motion.velocity, motion.angular_velocity].map(|v| slide.back(v));
            let front = arm[2] + slide.lifted(motion.position)[2];
            let next = front + (v[2] + cross(w, arm)[2]) * sim.step_limits().dt;
            let depths = placed.iter().map(|x| -gap(&scene, &motion, *x));
            let error = 2.0 * depths.fold(0.0, f64::max) + 1e-10 * h;
            below.set(struck.get() || next.max(front) > error);
            flush.set(flush.get() + u32::from(!below.get() && front.abs() < error));
        };
        slide.run([0.0; 3], 14.0 * h, check, &format!("{k}"));
        slid += u32::from(flush.get() > 100);
    }
    println!("{slid} came down flush and slid on");
    assert!(slid >= 4, "{slid}");
}
