//! What the segments of one direction have in common: how they lie at rest, their law and their mean constants.
//!
//! Reference: docs/model.md, "Unlike directions, crimp and pre-tension".

use crate::planes::Axis;
use crate::yarn::{DamageLaw, Rest};

/// Constants of the horizontal or of the vertical segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// How they lie in the flat sheet.
    pub rest: Rest,
    /// Their damage law.
    pub law: DamageLaw,
    /// q at the critical stretch.
    pub critical: f64,
    /// Undamaged stiffness kk = E A_0 dt^2/(2 m h l) of the mean segment.
    pub stiffness: f64,
    /// Damage rate of the mean segment.
    pub damage_rate: f64,
    /// Modulus over kk, Pa.
    pub modulus_per_stiffness: f64,
    /// Volume A_0 l of a segment over that of a horizontal one.
    pub volume: f64,
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
    };
}

/// Horizontal and vertical segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// Along x: the warp.
    pub horizontal: Direction,
    /// Along y: the weft.
    pub vertical: Direction,
}

impl Directions {
    /// No constants: a place for them.
    pub(crate) const NOTHING: Directions = Directions { horizontal: Direction::NOTHING, vertical: Direction::NOTHING };

    /// The direction of an axis.
    #[inline(always)]
    pub fn of(&self, axis: Axis) -> &Direction {
        match axis {
            Axis::Horizontal => &self.horizontal,
            Axis::Vertical => &self.vertical,
        }
    }

    /// Whether segments pull in the flat sheet.
    pub fn are_tense(&self) -> bool {
        self.horizontal.rest.twice_strain > 0.0 || self.vertical.rest.twice_strain > 0.0
    }

    /// Whether all segments lie at their natural length, the same along x and y, with the same critical stretch, as in the paper.
    pub fn are_plain(&self) -> bool {
        let Directions { horizontal, vertical } = self;
        horizontal.rest == Rest::PLAIN && vertical.rest == Rest::PLAIN && horizontal.critical == vertical.critical
    }
}
