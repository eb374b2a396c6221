//! The yarns of a scene: the damage law that all segments share, the mean segment, and the draws of
//! stochastic yarn.
//!
//! Method: every segment has random numbers of its own, keyed by seed and number, so that no draw depends on
//! the order of drawing. A drawn strength comes from a normal score z = sqrt(c) z_yarn + sqrt(1 - c)
//! z_segment, whose part below gives the critical strain of a Weibull distribution: U_c - 1 = scale (-ln(1 -
//! Phi(z)))^(1/m), scale = (critical_stretch - 1) (L/l)^(1/m). The weakest of n independent segments of the
//! natural length l then has the scale at the length n l, exactly.
//! Limits: with the correlation c > 0 the weakest of a yarn is stronger than that; with c = 1 all its
//! segments are alike. U_c is cut at 2.
//! Reference: docs/model.md, (M6); Powell and Zohdi (2009), their relation of damage rate and modulus; W.
//! Weibull, J. Appl. Mech. 18 (1951) 293.

use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::ground::random::{self, Purpose};
use crate::scene::features::Feature;
use crate::scene::measures::Cloth;
use crate::scene::parts::{Back, CRITICAL_STRETCH_MAX, DAMAGE_RATE_MIN, Draw, Scene, StrengthDraw, Weft, Yarn};
use crate::sheet::weave;
use crate::yarn::law::{DamageLaw, Segment};

impl Scene {
    /// The damage law of the segments of one direction, of the front fabric.
    pub fn damage_law(&self, axis: Axis) -> DamageLaw {
        self.law_of(axis, Cloth::Front)
    }

    /// The damage law of the segments of one direction of a fabric.
    pub(crate) fn law_of(&self, axis: Axis, cloth: Cloth) -> DamageLaw {
        let own = axis == Axis::Vertical && self.weft.critical_stretch != 0.0;
        DamageLaw {
            critical_stretch: match (cloth, own) {
                (Cloth::Back, _) => self.back.critical_stretch,
                (Cloth::Front, true) => self.weft.critical_stretch,
                (Cloth::Front, false) => self.yarn.critical_stretch,
            },
            a: self.yarn.damage_a,
            b: self.yarn.damage_b,
            alpha_fail: self.yarn.alpha_fail,
        }
    }

    /// The segment all others of its direction vary about, of the front fabric: mean modulus and the damage
    /// rate on its line.
    pub fn mean_segment(&self, axis: Axis) -> Segment {
        self.scatter(axis, Cloth::Front).mean()
    }

    /// Standard deviation of the modulus along a direction, Pa.
    pub(crate) fn modulus_sd(&self, axis: Axis) -> f64 {
        self.scatter(axis, Cloth::Front).modulus_sd
    }

    /// Mean modulus of one direction of a fabric, Pa.
    pub(crate) fn mean_modulus(&self, axis: Axis, cloth: Cloth) -> f64 {
        self.scatter(axis, cloth).modulus_mean
    }

    /// Upper bound of the sampled moduli of one direction, Pa.
    pub(crate) fn largest_modulus(&self, axis: Axis, cloth: Cloth) -> f64 {
        let Scatter { modulus_mean, modulus_sd, .. } = self.scatter(axis, cloth);
        modulus_mean + if self.is_drawn(cloth) { random::LARGEST_NORMAL * modulus_sd } else { 0.0 }
    }

    /// Whether modulus and damage rate of a fabric are drawn.
    pub(crate) fn is_drawn(&self, cloth: Cloth) -> bool {
        Feature::Drawn.is_built() && if cloth == Cloth::Back { self.back.is_drawn() } else { self.yarn.stochastic }
    }

    /// Whether the critical stretch of a fabric is drawn.
    pub(crate) fn is_strength_drawn(&self, cloth: Cloth) -> bool {
        let asked = if cloth == Cloth::Back {
            self.back.weibull_shape != 0.0
        } else {
            self.yarn.strength_draw != StrengthDraw::None
        };
        Feature::Strength.is_built() && asked
    }

    /// Modulus and damage rate of one direction of a fabric.
    fn scatter(&self, axis: Axis, cloth: Cloth) -> Scatter {
        if cloth == Cloth::Back {
            let Back { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd, .. } = self.back;
            Scatter { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd }
        } else if axis == Axis::Vertical && self.weft.modulus_mean != 0.0 {
            let Weft { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd, .. } = self.weft;
            Scatter { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd }
        } else {
            let Yarn { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd, .. } = self.yarn;
            Scatter { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd }
        }
    }

    /// Seed of the random samples of a ply: a single sheet with this seed has its yarns. That of ply 0 is the
    /// scene's own.
    pub fn ply_seed(&self, ply: u32) -> u64 {
        // Two rounds, so that neighbouring seeds and plies have nothing in common.
        if ply == 0 { self.seed } else { random::splitmix64(random::splitmix64(self.seed) ^ u64::from(ply)) }
    }

    /// Arrangement of the plies of a stack.
    pub(crate) fn arrangement(&self) -> Arrangement {
        Arrangement { turned: self.stack.plies > 1 && self.stack.turned, front: self.front_plies() as usize }
    }

    /// Where a segment is, by its number.
    fn place_of_segment(&self, number: u64) -> SegmentPlace {
        let of_ply = self.segments_of_ply().max(1);
        let (ply, number) = if number < of_ply { (0, number) } else { ((number / of_ply) as u32, number % of_ply) };
        let (along, plies) = (weave::axis_of_segment(self, number), self.arrangement());
        let axis = if plies.is_turned(ply as usize) { along.other() } else { along };
        SegmentPlace { seed: self.ply_seed(ply), number, axis, cloth: plies.cloth(ply as usize) }
    }

    /// Direction of the fabric that a segment is of, by its number: in a turned ply the other one than that
    /// along which it lies.
    pub(crate) fn axis_of_segment(&self, number: u64) -> Axis {
        self.place_of_segment(number).axis
    }

    /// (M6) Modulus and damage rate of one segment, by its number (ply by ply, horizontal segments first, row
    /// by row, then vertical). A modulus <= 0 or a rate below 3 or beyond all numbers is drawn again; after
    /// 1000 refusals the scatter makes no sense.
    pub fn draw_segment(&self, number: u64) -> Result<Segment, Error> {
        self.draw_counted(number).map(|(segment, _)| segment)
    }

    /// Draw with the number of draws that were refused.
    pub(crate) fn draw_counted(&self, number: u64) -> Result<(Segment, u64), Error> {
        let SegmentPlace { seed, number, axis, cloth } = self.place_of_segment(number);
        let scatter = self.scatter(axis, cloth);
        if !self.is_drawn(cloth) {
            return Ok((scatter.mean(), 0));
        }
        let number = match self.yarn.draw {
            Draw::Segment => number,
            Draw::Yarn => weave::yarn_of_segment(self, number),
        };
        for retry in 0..1000 {
            let g1 = random::normal(seed, number, Purpose::Modulus, retry);
            let g2 = random::normal(seed, number, Purpose::DamageRate, retry);
            let modulus = scatter.modulus_mean + scatter.modulus_sd * g1;
            let damage_rate = scatter.damage_slope * modulus + scatter.damage_intercept + scatter.damage_sd * g2;
            if modulus > 0.0 && damage_rate >= DAMAGE_RATE_MIN && damage_rate.is_finite() {
                return Ok((Segment { modulus, damage_rate }, retry));
            }
        }
        let weft = axis == Axis::Vertical && self.weft.modulus_mean != 0.0;
        let field = match (cloth, weft) {
            (Cloth::Back, _) => "back.damage_sd",
            (Cloth::Front, true) => "weft.damage_sd",
            (Cloth::Front, false) => "yarn.damage_sd",
        };
        Err(Error::new(Code::DamageRateTooSmall, field, scatter.damage_sd, DAMAGE_RATE_MIN))
    }

    /// Critical stretch U_c of one segment, by its number, in [1, 2].
    pub fn draw_critical_stretch(&self, number: u64) -> f64 {
        let yarn = &self.yarn;
        let SegmentPlace { seed, number, axis, cloth } = self.place_of_segment(number);
        let critical_stretch = self.law_of(axis, cloth).critical_stretch;
        if !self.is_strength_drawn(cloth) {
            return critical_stretch;
        }
        let (shape, gauge_length) = if cloth == Cloth::Back {
            (self.back.weibull_shape, self.back.weibull_gauge_length)
        } else {
            (yarn.weibull_shape, yarn.weibull_gauge_length)
        };
        let woven = weave::yarn_of_segment(self, number);
        let shared = random::normal(seed, woven, Purpose::Strength, 1);
        let own = random::normal(seed, number, Purpose::Strength, 0);
        let c = yarn.weibull_correlation;
        let score = math::sqrt(c) * shared + math::sqrt(1.0 - c) * own;
        // -ln(1 - Phi), from the smaller of the two tails.
        let hazard =
            if score < 0.0 { -math::ln_1p(-math::normal_above(-score)) } else { -math::ln(math::normal_above(score)) };
        let length = self.spacing(axis) / self.stretch_at_rest(axis, cloth);
        let lengths = if gauge_length > 0.0 { gauge_length / length } else { 1.0 };
        let strain = (critical_stretch - 1.0) * math::exp(math::ln(lengths * hazard) / shape);
        math::min(1.0 + strain, CRITICAL_STRETCH_MAX)
    }
}

/// Fabric of each ply of a stack, and whether it is turned by 90 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arrangement {
    /// Every other one is turned by 90 degrees.
    turned: bool,
    /// Number of those of the front fabric, which come first.
    front: usize,
}

impl Arrangement {
    /// A single sheet.
    pub const SINGLE: Arrangement = Arrangement { turned: false, front: 1 };

    /// Whether a ply is turned by 90 degrees.
    pub fn is_turned(self, ply: usize) -> bool {
        self.turned && ply % 2 == 1
    }

    /// Fabric of a ply.
    pub fn cloth(self, ply: usize) -> Cloth {
        if ply >= self.front { Cloth::Back } else { Cloth::Front }
    }
}

/// Where a segment is.
struct SegmentPlace {
    /// Seed of its ply.
    seed: u64,
    /// Number in the ply.
    number: u64,
    /// Direction of the fabric that it is of.
    axis: Axis,
    /// Fabric that it is of.
    cloth: Cloth,
}

/// Mean, scatter and line of the draws (M6).
struct Scatter {
    modulus_mean: f64,
    modulus_sd: f64,
    damage_slope: f64,
    damage_intercept: f64,
    damage_sd: f64,
}

impl Scatter {
    /// The segment that the others vary about.
    fn mean(&self) -> Segment {
        let modulus = self.modulus_mean;
        Segment { modulus, damage_rate: self.damage_slope * modulus + self.damage_intercept }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_draw_per_yarn_makes_rows_and_columns_alike() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.draw = Draw::Yarn;
        let horizontal = |i, j| scene.draw_segment(weave::horizontal_number(&scene, i, j)).unwrap();
        let vertical = |i, j| scene.draw_segment(weave::vertical_number(&scene, i, j)).unwrap();
        assert_eq!(horizontal(0, 7), horizontal(103, 7));
        assert_ne!(horizontal(0, 7), horizontal(0, 8));
        assert_eq!(vertical(7, 0), vertical(7, 103));
        assert_ne!(vertical(7, 0), horizontal(0, 7));
    }

    /// 401 x 401 nodes of drawn strength: 320 800 segments.
    fn drawn(shape: f64, gauge_length: f64, correlation: f64) -> Scene {
        let mut scene = crate::tests::sheet(401, 401);
        let yarn = &mut scene.yarn;
        (yarn.strength_draw, yarn.weibull_shape) = (StrengthDraw::Weibull, shape);
        (yarn.weibull_gauge_length, yarn.weibull_correlation) = (gauge_length, correlation);
        scene
    }

    /// Mean and variance.
    fn moments(values: impl Iterator<Item = f64>) -> (f64, f64, f64) {
        let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
        values.for_each(|x| (n, sum, squares) = (n + 1.0, sum + x, squares + x * x));
        (n, sum / n, squares / n - (sum / n) * (sum / n))
    }

    const EULER: f64 = 0.577_215_664_901_532_9;
    /// Variance and fourth central moment of the logarithm of an exponential number.
    const VARIANCE: f64 = core::f64::consts::PI * core::f64::consts::PI / 6.0;
    const FOURTH: f64 = 5.4 * VARIANCE * VARIANCE;

    /// ln of a Weibull number: mean ln(scale) - gamma/m, variance pi^2/(6 m^2). Within four standard errors.
    #[track_caller]
    fn is_weibull(strains: impl Iterator<Item = f64>, scale: f64, shape: f64) {
        let (n, mean, variance) = moments(strains.map(|strain| shape * math::ln(strain / scale)));
        assert!((mean + EULER).abs() < 4.0 * math::sqrt(VARIANCE / n), "{mean}");
        assert!((variance - VARIANCE).abs() < 4.0 * math::sqrt((FOURTH - VARIANCE * VARIANCE) / n), "{variance}");
    }

    /// Whatever the correlation, each segment by itself has the distribution asked for. (One segment of each
    /// yarn is looked at.)
    #[test]
    fn critical_strains_have_the_weibull_distribution_asked_for() {
        for (shape, correlation) in [(3.0, 0.0), (14.7, 0.0), (14.7, 0.6), (14.7, 1.0)] {
            let scene = drawn(shape, 0.0, correlation);
            let every = if correlation == 0.0 { 1 } else { 400 };
            let numbers = (0..160_400).step_by(every);
            is_weibull(numbers.map(|k| scene.draw_critical_stretch(k) - 1.0), 0.03, shape);
        }
    }

    #[test]
    fn the_scale_follows_the_length_exactly() {
        let (at, of) = (drawn(14.7, 0.05, 0.0), drawn(14.7, 0.4, 0.0));
        for k in 0..1000 {
            let ratio = (of.draw_critical_stretch(k) - 1.0) / (at.draw_critical_stretch(k) - 1.0);
            assert!((ratio / math::exp(math::ln(8.0) / 14.7) - 1.0).abs() < 1e-12, "{ratio}");
        }
    }

    #[test]
    fn segments_of_a_yarn_share_what_is_asked_for() {
        // Normal scores from the strains: their correlation within yarns, and none between yarns.
        let scores = |scene: &Scene, k: u64| {
            let strain = scene.draw_critical_stretch(k) - 1.0;
            math::ln(strain / 0.03) * 14.7
        };
        for correlation in [0.0, 0.5, 1.0] {
            let scene = drawn(14.7, 0.0, correlation);
            let pairs = |step: u64| {
                let products = (0..400_u64).flat_map(|yarn| (0..200).map(move |i| 400 * yarn + 2 * i));
                let centred = |k: u64| scores(&scene, k) + EULER;
                let (_, mean, _) = moments(products.map(|k| centred(k) * centred((k + step) % 160_400)));
                mean / VARIANCE
            };
            // A Gumbel number is no linear function of its score: of 0.5 some 0.03 are lost.
            assert!((pairs(1) - correlation).abs() < 0.06, "{correlation}: {}", pairs(1));
            assert!(pairs(400).abs() < 0.06, "{correlation}: {}", pairs(400));
        }
        let alike = drawn(14.7, 0.0, 1.0);
        assert_eq!(alike.draw_critical_stretch(400 * 7), alike.draw_critical_stretch(400 * 7 + 399));
        assert_ne!(alike.draw_critical_stretch(400 * 7), alike.draw_critical_stretch(400 * 8));
    }

    #[test]
    fn strength_is_not_drawn_unless_asked_for_and_never_leaves_its_range() {
        let mut scene = drawn(1.0, 1e3, 0.0);
        let all = || 0..10_000;
        assert!(all().all(|k| (1.0..=CRITICAL_STRETCH_MAX).contains(&scene.draw_critical_stretch(k))));
        assert!(all().any(|k| scene.draw_critical_stretch(k) == CRITICAL_STRETCH_MAX));
        scene.yarn.strength_draw = StrengthDraw::None;
        assert!(all().all(|k| scene.draw_critical_stretch(k) == 1.03));
    }
}
