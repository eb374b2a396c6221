//! Flat faces that slide over held nodes: the nodes take the motion along the face's normal and leave the rest as it is.

use fabric::{Faces, Projectile, Scene, Shape, Sim, TimeStep, pose, prism};
use fabric_tests::reference::{V3, add, length, sub};
use fabric_tests::{Buffers, close, small_sheet};

/// Gaps between a face and the nodes below it, parts of R: touching, and off by a rounding or by what roundings add up to.
const GAPS: [f64; 5] = [0.0, 1e-16, -1e-16, 1e-12, -1e-12];

/// Numbers from -1 to 1 without visible order.
fn number(k: u64) -> f64 {
    2.0 * (fabric::random::splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
}

fn spacing() -> f64 {
    small_sheet(2, 0.0).sheet.spacing
}

/// Held nodes, and a body that slides over them. All is given in axes of its own, in which the flat face looks along z, and is
/// turned by `turn` into the sheet's.
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

    /// Runs over a way, m, or to the end, and checks that all is lost that the face's normal stops and nothing else.
    fn run(&self, way: f64, check: impl Fn(&Sim<'_>, &str), name: &str) {
        let scene = self.scene();
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        let mut x = vec![[1e3 * spacing(), 0.0, 0.0]; sim.layout().nodes()];
        for (place, point) in x.iter_mut().zip(&self.points) {
            *place = self.placed(*point);
        }
        // Broken yarns pull at nothing.
        let broken = vec![2.0; sim.layout().segments()];
        sim.set_largest_stretch(&broken).unwrap();
        sim.set_motion(x.as_flattened(), &vec![0.0; 3 * x.len()]).unwrap();
        let speed = length(self.body.velocity);
        let steps = (way / (speed * sim.step_limits().dt)) as u64;
        for _ in 0..10 {
            sim.advance(steps / 10).unwrap();
            check(&sim, name);
        }
    }
}

/// Bodies that look along z with a flat face, and how far that is from the centre of mass, m: a box, a prism over an uneven
/// pentagon and a polyhedron with slanting sides.
fn bodies() -> [(Projectile, f64); 3] {
    let (h, base) = (spacing(), Projectile { mass: 0.01, ..small_sheet(2, 0.0).projectile });
    let cuboid = Projectile { shape: Shape::Box, size: [20.0 * h, 6.0 * h, 8.0 * h], ..base };
    let corners = [[8.0, -4.0], [10.0, 1.0], [2.0, 5.0], [-9.0, 4.0], [-8.0, -4.0]].map(|x| x.map(|x| x * h));
    let pentagon = prism::prism(&corners, 7.0 * h, 0.01).unwrap();
    let (n, m) = (0.8, 0.6);
    let sides = [[n, 0.0, -m, 6.0 * h], [-n, 0.0, -m, 6.0 * h], [0.0, n, m, 4.0 * h], [0.0, -n, m, 4.0 * h]];
    let faces = Faces::of(&[&sides[..], &[[0.0, 0.0, 1.0, 3.0 * h], [0.0, 0.0, -1.0, 3.0 * h]]].concat());
    let slanting = Projectile { shape: Shape::Polyhedron, faces, moments: [3e-8, 7e-8, 8e-8], ..base };
    [(cuboid, 4.0 * h), (pentagon.projectile, 3.5 * h), (slanting, 3.0 * h)]
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

/// What a body must have after its face has landed: its velocity without the part along z, in the axes of the slide, and the same
/// spin about z.
fn lands_and_slides(slide: &Slide, sim: &Sim<'_>, name: &str) {
    let (body, mass) = (slide.body, slide.body.mass);
    let motion = sim.projectile().unwrap();
    let (v, w) = (slide.back(motion.velocity), slide.back(motion.angular_velocity));
    let [x, y, z] = body.velocity;
    let speed = length(body.velocity);
    let lost = 0.5 * mass * z * z;
    let kinetic = 0.5 * mass * speed * speed;
    assert!(length(sub(v, [x, y, 0.0])) < 1e-9 * speed, "{name}: {v:?} of {:?}", body.velocity);
    assert!(length(w) * spacing() < 1e-9 * speed, "{name}: {w:?}");
    let contact = sim.contact().unwrap();
    assert!((contact.loss - lost).abs() < 1e-9 * kinetic, "{name}: lost {} J, not {lost}", contact.loss);
    assert!(sim.counters().worst_penetration < 2e-9 * spacing(), "{name}: {:e}", sim.counters().worst_penetration);
}

/// Two rails, one below the middle, and three: a body whose face comes down on them at 10 m/s while it goes along at 100 m/s loses
/// M V_z^2/2 and goes on along, from node to node.
#[test]
fn a_face_goes_on_over_held_rails() {
    let h = spacing();
    for (body, below) in bodies() {
        for places in [&[-0.5, 0.5][..], &[0.0], &[-2.0, 0.3, 2.0]] {
            for (gap, turn) in GAPS.into_iter().flat_map(|gap| turns().map(|turn| (gap, turn))) {
                // Narrow enough for the face, and long enough for the way.
                let points = rails(places, -30, 40);
                let position = [-10.0 * h, 0.0, -below - gap * below];
                let body = Projectile { position, velocity: [100.0, 0.0, 10.0], ..body };
                let slide = Slide { points, body, turn, friction: 0.0 };
                let name = format!("{:?} {places:?} {gap:e} {turn:?}", body.shape);
                slide.run(20.0 * h, |sim, name| lands_and_slides(&slide, sim, name), &name);
            }
        }
    }
}

/// The two scenes in which this was found: two rows of a sheet held on four sides, and one of them alone, below a box.
#[test]
fn a_box_loses_what_the_rows_of_a_sheet_stop() {
    let h = spacing();
    for (velocity, across, lost) in [([100.0, 0.0, 10.0], 0.0, 0.5), ([30.0, 0.0, 20.0], 3.4, 2.0)] {
        let mut scene = small_sheet(201, 0.0);
        scene.sheet.nodes_y = 2;
        let size = [20.0 * h, 6.0 * h, 8.0 * h];
        let position = [-60.0 * h, across * h, -4.0 * h];
        scene.projectile = Projectile { shape: Shape::Box, size, mass: 0.01, velocity, position, ..scene.projectile };
        if across > 0.0 {
            // It cannot turn to the side.
            scene.projectile.position[1] = 0.5 * h;
            scene.projectile.size[1] = 2.0 * h;
        }
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        sim.advance((50.0 * h / (velocity[0] * sim.step_limits().dt)) as u64).unwrap();
        let contact = sim.contact().unwrap();
        println!("{velocity:?}: {} m/s, lost {} J", sim.projectile().unwrap().velocity[0], contact.loss);
        close(contact.loss, lost, 1e-9);
        close(sim.projectile().unwrap().velocity[0], velocity[0], 1e-9);
    }
}
