//! The rigid case under a ring: a cylinder about its axis, which nodes may lift off but not enter.
//!
//! Method: a node at the height g above the cylinder, with the outward normal n and the velocity v that the
//! yarns leave it, gets the push J = max(0, -max(g, 0)/dt - n.v) along n, with restitution 0. It then ends on
//! or outside of the tangent plane at its foot, and so on or outside of the cylinder. The pushes of a row are
//! summed lane by lane and then in order, whatever the instruction set.
//! Limits: no friction. A node that is deeper within than a spacing has come in through the window, and is
//! left alone. A node that projectile and case push in one step gets the case's push first, whose work
//! follows the velocity that the projectile then leaves; where the projectile presses it on the case:
//! `contact/backing.rs`.
//! Reference: docs/model.md, "Curved sheets and rings".

use crate::ground::error::{Code, Error};
use crate::ground::lanes::Lane;
use crate::ground::math;
use crate::ground::planes::{Axis, CHUNK};
use crate::scene::features::Feature;
use crate::scene::parts::Scene;
use crate::sheet::ring::{CLOSES, Hoop};
use core::f64::consts::PI;

/// Whether this build has cases.
pub(crate) const IS_BUILT: bool = Feature::Casing.is_built();

/// Beyond every push.
const ANY_PUSH: f64 = 1e300;

/// The case in spacings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Radius at which it carries the middle of the cloth.
    pub radius: f64,
    /// Direction from the axis to the middle of the window along x and z, and the cosine of half its angle; 2
    /// without a window, -2 of one all around.
    window: [f64; 3],
    /// Middle of the window along y and half its length.
    along: [f64; 2],
}

impl Cylinder {
    /// That of a scene, if it has one.
    pub fn of(scene: &Scene) -> Option<Cylinder> {
        let hoop = Hoop::of(scene).filter(|_| Feature::Casing.is_in(scene))?;
        let (h, [angle, half_angle], [place, half]) =
            (scene.sheet.spacing, scene.casing.window_angle, scene.casing.window_place);
        // A case that bears the ring at rest does so to rounding.
        let radius = if is_snug(scene) { hoop.radius } else { carried(scene) / h };
        let cosine = if half_angle == 0.0 || half == 0.0 {
            2.0
        } else if half_angle >= PI {
            -2.0
        } else {
            math::cos(half_angle)
        };
        Some(Cylinder { radius, window: [math::sin(angle), math::cos(angle), cosine], along: [place / h, half / h] })
    }

    /// (M24) The push of the case on nodes, spacings a step, and its parts along x and z: what it adds to
    /// their change of velocity. `place`: at the start of the step, spacings from the axis; `before`:
    /// velocity along x and z then; `change`: by the yarns. Adds to the sums of the push along x and z and of
    /// the energy that it takes, in units of m (h/dt)^2.
    #[inline(always)]
    pub fn push<L: Lane>(
        &self,
        [x, y, z]: [L; 3],
        before: [L; 2],
        change: [L; 2],
        [sum_x, sum_z, dissipated]: [&mut L::Group; 3],
    ) -> (L, [L; 2]) {
        let (zero, radius) = (L::splat(0.0), L::splat(self.radius));
        let from_axis = x.mul(x).add(z.mul(z)).sqrt();
        let n = [x.div(from_axis), z.div(from_axis)];
        let speed_before = n[0].mul(before[0]).add(n[1].mul(before[1]));
        let speed = speed_before.add(n[0].mul(change[0]).add(n[1].mul(change[1])));
        let height = from_axis.sub(radius).max(zero);
        let wanted = zero.sub(height.add(speed)).max(zero);
        // Above 0 for a node that the case does not meet: deep within, or before the window.
        let deep = radius.sub(L::splat(1.0)).sub(from_axis);
        let [to_x, to_z, cosine] = [L::splat(self.window[0]), L::splat(self.window[1]), L::splat(self.window[2])];
        let [middle, half] = [L::splat(self.along[0]), L::splat(self.along[1])];
        let across = n[0].mul(to_x).add(n[1].mul(to_z)).sub(cosine);
        let off = y.sub(middle);
        let within = across.min(half.sub(off.max(zero.sub(off))));
        let push = wanted.or_zero_below(deep.max(within).max(zero).mul(L::splat(ANY_PUSH)));
        let mean = L::splat(0.5).mul(speed_before.add(speed.add(push)));
        let push_along = [push.mul(n[0]), push.mul(n[1])];
        L::load(sum_x).add(push_along[0]).store(sum_x);
        L::load(sum_z).add(push_along[1]).store(sum_z);
        L::load(dissipated).sub(push.mul(mean)).store(dissipated);
        (push, push_along)
    }

    /// Velocity along this normal of its column that the case adds to that of a node at `place` which is
    /// pushed along the normal by `push`; 0 where it is free to move. Spacings.
    pub(crate) fn room(&self, place: [f64; 3], [sine, cosine]: [f64; 2], push: f64) -> f64 {
        let [mut sum_x, mut sum_z, mut dissipated] = [[0.0]; 3];
        let sums = [&mut sum_x, &mut sum_z, &mut dissipated];
        let (held, [x, z]) = self.push(place, [0.0; 2], [push * sine, push * cosine], sums);
        // Where a node has slid along the case its normal is another.
        let along = x * sine + z * cosine;
        if push < 0.0 && along > 0.0 { held * (held / along) } else { 0.0 }
    }

    /// The change of velocity of a node that rests on the case, at `place`, spacings, where the yarns give it
    /// this one.
    pub(crate) fn carry(&self, [x, y, z]: [f64; 3], [a, b, c]: [f64; 3]) -> [f64; 3] {
        if math::length([x, 0.0, z]) - self.radius > CLOSES {
            return [a, b, c];
        }
        let [mut sum_x, mut sum_z, mut dissipated] = [[0.0]; 3];
        // As if it lay on the case to rounding.
        let on_casing = Cylinder { radius: math::length([x, 0.0, z]), ..*self };
        let (_, push) = on_casing.push([x, y, z], [0.0; 2], [a, c], [&mut sum_x, &mut sum_z, &mut dissipated]);
        [a + push[0], b, c + push[1]]
    }
}

/// Radius of the middle of the cloth that lies on the case, m: the case carries its inner face.
fn carried(scene: &Scene) -> f64 {
    scene.casing.radius + 0.5 * scene.thickness()
}

/// Whether the case touches the ring at rest.
fn is_snug(scene: &Scene) -> bool {
    math::abs(carried(scene) - scene.sheet.radius) <= CLOSES * scene.sheet.radius
}

/// Impulse of the case on the node of column i, spacings a step times its mass; 0 without. `place`: that of
/// its chunk.
#[inline(always)]
pub(crate) fn impulse_on(impulses: &[[f64; CHUNK]], place: usize, i: usize) -> f64 {
    if IS_BUILT { impulses.get(place).map_or(0.0, |chunk| chunk[i % CHUNK]) } else { 0.0 }
}

impl Scene {
    /// Whether the case bears a ring that is taut at rest.
    pub(crate) fn has_snug_casing(&self) -> bool {
        IS_BUILT && Feature::Closed.is_in(self) && is_snug(self)
    }

    /// A case lies within a ring, and its window along it.
    pub(crate) fn check_casing(&self) -> Result<(), Error> {
        let (casing, ring) = (&self.casing, self.sheet.radius);
        if !IS_BUILT || casing.radius == 0.0 {
            return Ok(());
        }
        if !Feature::Closed.is_in(self) {
            return Err(Error::new(Code::OutOfRange, "casing.radius", casing.radius, 0.0).from("sheet.closed"));
        }
        if carried(self) > ring * (1.0 + CLOSES) {
            let limit = ring - 0.5 * self.thickness();
            return Err(Error::new(Code::OutOfRange, "casing.radius", casing.radius, limit).from("sheet.radius"));
        }
        let ([middle, half], [_, y]) = (casing.window_place, self.half_size());
        let (beyond, end) = (math::abs(middle) + half, y + self.spacing(Axis::Vertical));
        if half < 0.0 || beyond > end {
            let value = if half < 0.0 { half } else { beyond };
            let limit = if half < 0.0 { 0.0 } else { end };
            return Err(Error::new(Code::OutOfRange, "casing.window_place", value, limit).from("sheet.nodes_y"));
        }
        Ok(())
    }
}
