//! The yarns of a scene: the damage law that all segments share, the mean segment, and the draws of stochastic yarn.
//!
//! Method: every segment has random numbers of its own, keyed by seed and number, so that no draw depends on the order of drawing.
//! Reference: docs/model.md, (M6); Powell and Zohdi (2009), their relation of damage rate and modulus.

use crate::error::{Code, Error};
use crate::planes::Axis;
use crate::random::{self, Purpose};
use crate::scene::{DAMAGE_RATE_MIN, Draw, Scene};
use crate::weave;
use crate::yarn::{DamageLaw, Segment};

impl Scene {
    /// The damage law of the segments of one direction.
    pub fn damage_law(&self, axis: Axis) -> DamageLaw {
        let own = axis == Axis::Vertical && self.weft.critical_stretch != 0.0;
        DamageLaw {
            critical_stretch: if own { self.weft.critical_stretch } else { self.yarn.critical_stretch },
            a: self.yarn.damage_a,
            b: self.yarn.damage_b,
            alpha_fail: self.yarn.alpha_fail,
        }
    }

    /// The segment all others of its direction vary about: mean modulus and the damage rate on its line.
    pub fn mean_segment(&self, axis: Axis) -> Segment {
        let scatter = self.scatter(axis);
        let modulus = scatter.modulus_mean;
        Segment { modulus, damage_rate: scatter.damage_slope * modulus + scatter.damage_intercept }
    }

    /// Standard deviation of the modulus along a direction, Pa.
    pub(crate) fn modulus_sd(&self, axis: Axis) -> f64 {
        self.scatter(axis).modulus_sd
    }

    /// Modulus and damage rate of one direction.
    fn scatter(&self, axis: Axis) -> Scatter {
        let (yarn, weft) = (&self.yarn, &self.weft);
        if axis == Axis::Vertical && weft.modulus_mean != 0.0 {
            Scatter {
                modulus_mean: weft.modulus_mean,
                modulus_sd: weft.modulus_sd,
                damage_slope: weft.damage_slope,
                damage_intercept: weft.damage_intercept,
                damage_sd: weft.damage_sd,
            }
        } else {
            Scatter {
                modulus_mean: yarn.modulus_mean,
                modulus_sd: yarn.modulus_sd,
                damage_slope: yarn.damage_slope,
                damage_intercept: yarn.damage_intercept,
                damage_sd: yarn.damage_sd,
            }
        }
    }

    /// (M6) Modulus and damage rate of one segment, by its number (horizontal segments first, row by row, then vertical).
    /// A modulus <= 0 or a rate below 3 or beyond all numbers is drawn again; after 1000 refusals the scatter makes no sense.
    pub fn draw_segment(&self, number: u64) -> Result<Segment, Error> {
        let axis = weave::axis_of_segment(self.sheet.nodes_x, self.sheet.nodes_y, number);
        if !self.yarn.stochastic {
            return Ok(self.mean_segment(axis));
        }
        let scatter = self.scatter(axis);
        let number = match self.yarn.draw {
            Draw::Segment => number,
            Draw::Yarn => weave::yarn_of_segment(self.sheet.nodes_x, self.sheet.nodes_y, number),
        };
        for retry in 0..1000 {
            let g1 = random::normal(self.seed, number, Purpose::Modulus, retry);
            let g2 = random::normal(self.seed, number, Purpose::DamageRate, retry);
            let modulus = scatter.modulus_mean + scatter.modulus_sd * g1;
            let damage_rate = scatter.damage_slope * modulus + scatter.damage_intercept + scatter.damage_sd * g2;
            if modulus > 0.0 && damage_rate >= DAMAGE_RATE_MIN && damage_rate.is_finite() {
                return Ok(Segment { modulus, damage_rate });
            }
        }
        let weft = axis == Axis::Vertical && self.weft.modulus_mean != 0.0;
        let field = if weft { "weft.damage_sd" } else { "yarn.damage_sd" };
        Err(Error::new(Code::DamageRateTooSmall, field, scatter.damage_sd, DAMAGE_RATE_MIN))
    }
}

/// Mean, scatter and line of the draws (M6).
struct Scatter {
    modulus_mean: f64,
    modulus_sd: f64,
    damage_slope: f64,
    damage_intercept: f64,
    damage_sd: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_draw_per_yarn_makes_rows_and_columns_alike() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.draw = Draw::Yarn;
        let horizontal = |i, j| scene.draw_segment(weave::horizontal_number(105, i, j)).unwrap();
        let vertical = |i, j| scene.draw_segment(weave::vertical_number(105, 105, i, j)).unwrap();
        assert_eq!(horizontal(0, 7), horizontal(103, 7));
        assert_ne!(horizontal(0, 7), horizontal(0, 8));
        assert_eq!(vertical(7, 0), vertical(7, 103));
        assert_ne!(vertical(7, 0), horizontal(0, 7));
    }

    #[test]
    fn mean_damage_rate_lies_on_the_line() {
        assert!((Scene::sheet_3in_sphere().mean_segment(Axis::Horizontal).damage_rate - 230.6011).abs() < 1e-9);
    }
}
