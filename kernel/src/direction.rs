//! What the segments of one direction have in common: how they lie at rest, their law and their mean constants.
//!
//! Reference: docs/model.md, "Unlike directions, crimp and pre-tension".

use crate::planes::Axis;
use crate::scene::Scene;
use crate::yarn::{DamageLaw, Rest, Viscosity};

/// Constants of the horizontal or of the vertical segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// How they lie in the flat sheet.
    pub rest: Rest,
    /// Their damage law; of drawn strength that of the sheet's weakest segment.
    pub law: DamageLaw,
    /// q at its critical stretch: none of them is damaged below.
    pub critical: f64,
    /// Undamaged stiffness kk = E A_0 dt^2/(2 m h l) of the mean segment.
    pub stiffness: f64,
    /// Damage rate of the mean segment.
    pub damage_rate: f64,
    /// Modulus over kk, Pa.
    pub modulus_per_stiffness: f64,
    /// Volume A_0 l of a segment over that of a horizontal one.
    pub volume: f64,
    /// Their viscosity.
    pub viscosity: Viscosity,
}

impl Direction {
    /// No constants: a place for them.
    pub(crate) const NOTHING: Direction = Direction {
        rest: Rest::PLAIN,
        law: DamageLaw { critical_stretch: 0.0, a: 0.0, b: 0.0, alpha_fail: 0.0 },
        critical: 0.0,
        stiffness: 0.0,
        damage_rate: 0.0,
        modulus_per_stiffness: 0.0,
        volume: 0.0,
        viscosity: Viscosity::NONE,
    };

    /// Constants of the segments of one direction for passes of dt, s.
    fn of(scene: &Scene, axis: Axis, dt: f64) -> Direction {
        let h = scene.sheet.spacing;
        let rest_of = |axis: Axis| Rest::of(scene.spacing(axis) / h, scene.rest_stretch(axis));
        let volume_of = |axis: Axis| scene.yarn_area(axis) * rest_of(axis).length;
        let (rest, law, mean) = (rest_of(axis), scene.damage_law(axis), scene.mean_segment(axis));
        // kk = E A_0 dt^2 / (2 m h l); plies cancel.
        let modulus_per_stiffness = 2.0 * scene.sheet.node_mass * (h * rest.length) / (scene.yarn_area(axis) * dt * dt);
        let (critical, stiffness) = (law.critical_twice_strain(), mean.modulus / modulus_per_stiffness);
        Direction {
            rest,
            law,
            critical,
            stiffness,
            damage_rate: mean.damage_rate,
            modulus_per_stiffness,
            volume: volume_of(axis) / volume_of(Axis::Horizontal),
            viscosity: Viscosity::of(scene.viscosity(), stiffness, critical),
        }
    }
}

/// Horizontal and vertical segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// Along x: the warp.
    pub horizontal: Direction,
    /// Along y: the weft.
    pub vertical: Direction,
    /// Whether all segments lie at their natural length, the same along x and y, with the same critical stretch, as in the paper.
    pub plain: bool,
}

impl Directions {
    /// No constants: a place for them.
    pub(crate) const NOTHING: Directions =
        Directions { horizontal: Direction::NOTHING, vertical: Direction::NOTHING, plain: true };

    /// Derives the directions of a scene for passes of dt, s, where they are: a copy would add to the stack of the caller.
    #[inline(never)]
    pub(crate) fn derive(&mut self, scene: &Scene, dt: f64) {
        self.horizontal = Direction::of(scene, Axis::Horizontal, dt);
        self.vertical = Direction::of(scene, Axis::Vertical, dt);
        let Directions { horizontal, vertical, .. } = self;
        let at_rest = horizontal.rest == Rest::PLAIN && vertical.rest == Rest::PLAIN;
        self.plain = at_rest && horizontal.critical == vertical.critical;
    }

    /// Goes over to passes of half the time, or back: all factors are powers of two, so nothing is rounded.
    pub(crate) fn use_half_steps(&mut self, halves: bool) {
        let factor = if halves { 0.25 } else { 4.0 };
        for direction in [&mut self.horizontal, &mut self.vertical] {
            direction.modulus_per_stiffness /= factor;
            direction.stiffness *= factor;
            direction.viscosity = direction.viscosity.of_pass(if halves { 0.5 } else { 2.0 });
        }
    }

    /// What segments along x and along y have in common in a ply that may be turned by 90 degrees.
    pub(crate) fn of_ply(&self, turned: bool) -> Along<'_> {
        let (horizontal, vertical) =
            if turned { (&self.vertical, &self.horizontal) } else { (&self.horizontal, &self.vertical) };
        Along { horizontal, vertical, plain: self.plain }
    }

    /// The direction of an axis.
    #[inline(always)]
    pub fn along(&self, axis: Axis) -> &Direction {
        match axis {
            Axis::Horizontal => &self.horizontal,
            Axis::Vertical => &self.vertical,
        }
    }

    /// Whether segments pull in the flat sheet.
    pub fn are_tense(&self) -> bool {
        self.horizontal.rest.twice_strain > 0.0 || self.vertical.rest.twice_strain > 0.0
    }
}

/// The directions of one ply.
#[derive(Clone, Copy)]
pub struct Along<'a> {
    /// Of the segments along x.
    pub horizontal: &'a Direction,
    /// Of the segments along y.
    pub vertical: &'a Direction,
    /// [`Directions::plain`].
    pub plain: bool,
}

impl<'a> Along<'a> {
    /// That of an axis.
    pub fn along(&self, axis: Axis) -> &'a Direction {
        match axis {
            Axis::Horizontal => self.horizontal,
            Axis::Vertical => self.vertical,
        }
    }
}
