//! The time step that a scene allows: from the stiffest segments and the strongest, and from viscosity.
//!
//! Method: (M11) and (M18). Every segment of a stochastic sheet is drawn, or a sample for a first look.
//! Limits: a scene that `check.rs` accepts.
//! Reference: docs/model.md, "The step" and "Viscosity".

use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::ground::planes::{AT_REST, Axis};
use crate::scene::features::Feature;
use crate::scene::measures::Cloth;
use crate::scene::parts::{CRITICAL_STRETCH_MAX, STEP_MAX_FRACTION, Scene, StepCheck, StepLimits, TimeStep};
use core::iter::StepBy;
use core::ops::Range;

/// Upper bound of the speed that counts as rest, m/s; a step so short that it is faster is refused.
const SLOWEST_MOTION: f64 = 1e-30;
/// Largest mass of a node m, kg, m h/dt, N s, and m (h/dt)^2, J, and largest k dt^2/m: within these all that
/// a step makes of a state that is not lost are numbers, and so are its momentum and energy.
const LARGEST_UNIT: f64 = 1e90;
const LARGEST_STIFFNESS: f64 = 1e6;

impl Scene {
    /// The step in use and its limits, of a scene that has been checked. Of two fabrics the one that allows
    /// less counts.
    ///
    /// (M11) omega^2 = (k/m) [2 (3 U_c^2 - 1) + 2 (U_c^2 - 1)] with k = E A_0/l: the bound of a taut plane
    /// net at U_c, where the tangent stiffness is largest; dt_crit = 2/omega. Of unlike directions the first
    /// bracket takes its k and U_c from one, the second from the other, and the greater omega counts.
    pub(crate) fn limits_of_all(&self) -> Result<StepLimits, Error> {
        self.limits(&mut Sampling::at(u64::MAX / 2))
    }

    /// The step in use and its limits, of a scene that has been checked, from [`LOOKED_AT`]
    /// segments at most.
    pub(crate) fn limits_of_a_sample(&self) -> Result<StepLimits, Error> {
        let mut sampling = Sampling::at(LOOKED_AT);
        let mut limits = self.limits(&mut sampling)?;
        if !sampling.is_complete && self.time_step.seconds == 0.0 {
            // Nothing is too fast that may be slow enough.
            limits.dt = self.time_step.fraction * self.least_dt_crit();
        }
        Ok(limits)
    }

    /// The step in use and its limits, of a scene that has been checked.
    fn limits(&self, sampling: &mut Sampling) -> Result<StepLimits, Error> {
        let front = self.bounds(Cloth::Front, sampling)?;
        let back = if self.back.plies > 0 { self.bounds(Cloth::Back, sampling)? } else { front };
        let dt_crit = math::min(front.dt_crit, back.dt_crit);
        let step_max = math::min(front.step_max, back.step_max);
        let TimeStep { fraction, seconds } = self.time_step;
        let dt = if seconds != 0.0 { seconds } else { fraction * dt_crit };
        if self.step_check == StepCheck::Refuse && dt > step_max {
            return Err(Error::new(Code::StepTooLarge, "time_step.seconds", dt, step_max));
        }
        let speed = self.sheet.spacing / dt;
        let mass = self.largest_mass();
        let units = [mass, mass * speed, mass * speed * speed];
        let stiffnesses = [front.per_mass, back.per_mass].map(|per_mass| per_mass.map(|k| dt * dt * k));
        // Densities of energy come from stiffnesses by moduli over them.
        let has_density = |cloth: Cloth, axis: Axis| {
            let over = self.node_mass(cloth) * self.spacing(axis) / (self.area_of(axis, cloth) * dt * dt);
            over.is_normal() && (LARGEST_STIFFNESS * over).is_finite()
        };
        let have_densities = |cloth| has_density(cloth, Axis::Horizontal) && has_density(cloth, Axis::Vertical);
        let usable = units.iter().all(|unit| unit.is_normal() && *unit <= LARGEST_UNIT)
            && have_densities(Cloth::Front)
            && (self.back.plies == 0 || have_densities(Cloth::Back))
            && stiffnesses.as_flattened().iter().all(|k| k.is_normal() && *k <= LARGEST_STIFFNESS)
            && AT_REST * speed <= SLOWEST_MOTION;
        if !usable {
            return Err(Error::new(Code::StepLimitUnusable, "time_step.seconds", dt, step_max));
        }
        Ok(StepLimits { dt, dt_crit, step_max })
    }

    /// Bounds of a fabric.
    fn bounds(&self, cloth: Cloth, sampling: &mut Sampling) -> Result<Bounds, Error> {
        let (moduli, strongest) = (self.stiffest(cloth, sampling)?, self.strongest(cloth, sampling)?);
        let mass = self.node_mass(cloth);
        let dt_crit = 2.0 / math::sqrt(self.largest_omega2(moduli, strongest, cloth));
        if !dt_crit.is_normal() {
            let field = if cloth == Cloth::Back { "back.node_mass" } else { "sheet.node_mass" };
            return Err(Error::new(Code::StepLimitUnusable, field, mass, 0.0));
        }
        let step_max = self.largest_fraction(moduli, strongest, cloth)? * dt_crit;
        Ok(Bounds { dt_crit, step_max, per_mass: self.stiffnesses(moduli, cloth).map(|k| k / mass) })
    }

    /// k = E A_0/l of segments along x and along y with these moduli, N/m.
    fn stiffnesses(&self, [x, y]: [f64; 2], cloth: Cloth) -> [f64; 2] {
        [(Axis::Horizontal, x), (Axis::Vertical, y)].map(|(axis, modulus)| {
            let length = self.spacing(axis) / self.stretch_at_rest(axis, cloth);
            modulus * self.area_of(axis, cloth) / length
        })
    }

    /// ln(r_1/r_0) of yarn that depends on the rate of strain, else 0.
    fn largest_logarithm(&self) -> f64 {
        if Feature::Rate.is_in(self) { math::ln(self.yarn.rate_limit / self.yarn.rate_reference) } else { 0.0 }
    }

    /// U_c^2 along x and along y, at the largest rate of strain; of drawn strength that of the strongest
    /// segment, if it is known.
    fn critical_squares(&self, strongest: Option<f64>, cloth: Cloth) -> [f64; 2] {
        [Axis::Horizontal, Axis::Vertical].map(|axis| {
            let critical = strongest.unwrap_or(self.law_of(axis, cloth).critical_stretch);
            if self.yarn.rate_stretch == 0.0 {
                return critical * critical;
            }
            1.0 + (critical * critical - 1.0) * (1.0 + self.yarn.rate_stretch * self.largest_logarithm())
        })
    }

    /// omega^2 of (M11) with these moduli along x and along y, 1/s^2. The tangent modulus of yarn that
    /// depends on the rate is at most E (1 + C_E (1 + ln(r_1/r_0))).
    fn largest_omega2(&self, moduli: [f64; 2], strongest: Option<f64>, cloth: Cloth) -> f64 {
        let tangent = 1.0 + self.yarn.rate_modulus * (1.0 + self.largest_logarithm());
        let moduli = moduli.map(|modulus| modulus * tangent);
        let ([kx, ky], [ux, uy]) = (self.stiffnesses(moduli, cloth), self.critical_squares(strongest, cloth));
        let largest = math::max(kx, ky);
        // Shares of the larger stiffness, so that nothing overflows before the result does.
        let omega2 = |along: f64, u_along: f64, across: f64, u_across: f64| {
            let (own, other) = (2.0 * (3.0 * u_along - 1.0), 2.0 * (u_across - 1.0));
            largest / self.node_mass(cloth) * (along / largest * own + across / largest * other)
        };
        math::max(omega2(kx, ux, ky, uy), omega2(ky, uy, kx, ux))
    }

    /// Largest accepted part of dt_crit with segments as stiff as these moduli along x and along y.
    ///
    /// (M18) Viscosity makes of a mode x_{n+1} - 2 x_n + x_{n-1} + Omega^2 x_n + K (x_n - x_{n-1}) = 0, which
    /// is stable while Omega^2 + 2 K < 4. With Omega = omega dt, C = c dt/h of the mean segment and E/E_mean
    /// = s at most, K <= 4 C b_1 s U_c^2 + 2 b_2 s q_c U_c^2 + 32 C b_3, because no strain grows by more than
    /// q_c within a step. So Omega^2 + 4 xi Omega + 4 eta < 4: dt < dt_crit (sqrt(1 - eta + xi^2) - xi).
    fn largest_fraction(&self, moduli: [f64; 2], strongest: Option<f64>, cloth: Cloth) -> Result<f64, Error> {
        let [linear, quadratic, bending] = self.viscosity();
        if [linear, quadratic, bending] == [0.0; 3] {
            return Ok(STEP_MAX_FRACTION);
        }
        let means = [Axis::Horizontal, Axis::Vertical].map(|axis| self.mean_modulus(axis, cloth));
        let ([kx, ky], [mean_x, mean_y]) = (self.stiffnesses(moduli, cloth), self.stiffnesses(means, cloth));
        let (scatter, [ux, uy]) = (math::max(kx / mean_x, ky / mean_y), self.critical_squares(strongest, cloth));
        let squared = math::max(ux, uy);
        // c/(h omega)
        let sound = math::sqrt(
            math::max(mean_x, mean_y) / self.node_mass(cloth) / self.largest_omega2(moduli, strongest, cloth),
        );
        let pulled = scatter * squared;
        let xi = sound * (2.0 * linear * pulled + 16.0 * bending);
        let eta = quadratic * (pulled * (squared - 1.0));
        if eta >= 1.0 {
            return Err(Error::new(Code::OutOfRange, "yarn.viscosity_quadratic", quadratic, quadratic / eta));
        }
        let stable = math::sqrt(1.0 - eta + xi * xi) - xi;
        Ok(math::min(stable, STEP_MAX_FRACTION))
    }

    /// Segments of a fabric to be looked at, by their numbers.
    fn numbers_of(&self, cloth: Cloth, sampling: &mut Sampling) -> StepBy<Range<u64>> {
        let (of_ply, front) = (self.segments_of_ply(), u64::from(self.front_plies()));
        let numbers = if cloth == Cloth::Back { front * of_ply..self.segments() } else { 0..front * of_ply };
        let stride = (numbers.end - numbers.start).div_ceil(sampling.most.max(1)).max(1);
        sampling.is_complete &= stride == 1;
        numbers.step_by(usize::try_from(stride).unwrap_or(usize::MAX).max(1))
    }

    /// Lower bound of dt_crit, whatever is sampled, s.
    fn least_dt_crit(&self) -> f64 {
        let of = |cloth| {
            let moduli = [Axis::Horizontal, Axis::Vertical].map(|axis| self.largest_modulus(axis, cloth));
            let strongest = self.is_strength_drawn(cloth).then_some(CRITICAL_STRETCH_MAX);
            2.0 / math::sqrt(self.largest_omega2(moduli, strongest, cloth))
        };
        if self.back.plies > 0 { math::min(of(Cloth::Front), of(Cloth::Back)) } else { of(Cloth::Front) }
    }

    /// Modulus of the stiffest segment along x and along y, Pa; directions of one law share it.
    fn stiffest(&self, cloth: Cloth, sampling: &mut Sampling) -> Result<[f64; 2], Error> {
        let mut stiffest = [Axis::Horizontal, Axis::Vertical].map(|axis| self.mean_modulus(axis, cloth));
        if self.is_drawn(cloth) {
            stiffest = [0.0; 2];
            let shared = cloth == Cloth::Back || self.weft.modulus_mean == 0.0;
            let mut draws = 0;
            for number in self.numbers_of(cloth, sampling) {
                let (segment, refused) = self.draw_counted(number)?;
                let modulus = segment.modulus;
                let axis = self.axis_of_segment(number);
                let [x, y] = &mut stiffest;
                if shared || axis == Axis::Horizontal {
                    *x = math::max(modulus, *x);
                }
                if shared || axis == Axis::Vertical {
                    *y = math::max(modulus, *y);
                }
                draws += 1 + refused;
                if draws > 2 * sampling.most {
                    sampling.is_complete = false;
                    break;
                }
            }
        }
        Ok(stiffest)
    }

    /// Critical stretch of the strongest segment of drawn strength. The weakest must bear the pre-tension.
    fn strongest(&self, cloth: Cloth, sampling: &mut Sampling) -> Result<Option<f64>, Error> {
        if !self.is_strength_drawn(cloth) {
            return Ok(None);
        }
        let [strain_x, strain_y] = self.sheet.pre_strain;
        let mut strongest = 1.0;
        for number in self.numbers_of(cloth, sampling) {
            let critical = self.draw_critical_stretch(number);
            let weft = self.axis_of_segment(number) == Axis::Vertical;
            let strain = if weft { strain_y } else { strain_x };
            if strain > 0.0 && strain >= critical - 1.0 {
                return Err(
                    Error::new(Code::OutOfRange, "sheet.pre_strain", strain, critical - 1.0).from("yarn.strength_draw")
                );
            }
            strongest = math::max(critical, strongest);
        }
        Ok(Some(strongest))
    }

    /// Largest accepted fraction of dt_crit; of drawn viscous yarn that of the mean segments, which is a
    /// little more.
    ///
    /// # Errors
    /// A quadratic viscosity that no step allows.
    pub fn step_max_fraction(&self) -> Result<f64, Error> {
        let of_means = |cloth| {
            let moduli = [Axis::Horizontal, Axis::Vertical].map(|axis| self.mean_modulus(axis, cloth));
            self.largest_fraction(moduli, None, cloth)
        };
        let front = of_means(Cloth::Front)?;
        if self.back.plies > 0 { Ok(math::min(front, of_means(Cloth::Back)?)) } else { Ok(front) }
    }
}

/// Most segments that a check draws of each kind, and nodes that it looks for under the projectile.
pub(crate) const LOOKED_AT: u64 = 1 << 13;

/// Sample of the segments by which the step is limited: the most of them, and whether it is all.
struct Sampling {
    most: u64,
    /// Whether no segment was left out so far.
    is_complete: bool,
}

impl Sampling {
    fn at(most: u64) -> Sampling {
        Sampling { most, is_complete: true }
    }
}

/// Bounds of a fabric.
#[derive(Clone, Copy)]
struct Bounds {
    /// 2/omega_max, s.
    dt_crit: f64,
    /// Largest accepted step, s.
    step_max: f64,
    /// k/m of the stiffest segments along x and along y, 1/s^2.
    per_mass: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakest_segment_must_bear_the_pre_tension_and_the_strongest_sets_the_step() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.sheet.pre_strain) = (21, 21, [0.0, 0.02]);
        scene.yarn.stochastic = false;
        let alike = scene.step_limits().unwrap().dt_crit;
        (scene.yarn.strength_draw, scene.yarn.weibull_shape) = (crate::StrengthDraw::Weibull, 200.0);
        let drawn = scene.step_limits().unwrap().dt_crit;
        let strongest = (0..scene.segments()).map(|k| scene.draw_critical_stretch(k)).fold(1.0, f64::max);
        let bound = |u: f64| 2.0 * (3.0 * u * u - 1.0) + 2.0 * (u * u - 1.0);
        // omega^2 is proportional to the bound; the directions differ in their natural lengths alone, and
        // alike in both sheets.
        assert!((drawn / alike / math::sqrt(bound(1.03) / bound(strongest)) - 1.0).abs() < 1e-4, "{strongest}");
        // The weakest of 840 segments of shape 5 has a scale of 840^(-1/5).
        scene.yarn.weibull_shape = 5.0;
        let error = scene.step_limits().unwrap_err();
        assert_eq!((error.code, error.field, error.value), (Code::OutOfRange, "sheet.pre_strain", 0.02));
        scene.sheet.pre_strain = [0.0; 2];
        scene.step_limits().unwrap();
    }

    /// In a net with twice the stiffness along y the motion along y sets the limit, with its share of the
    /// yarns along x.
    #[test]
    fn step_limit_of_unlike_directions() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.stochastic = false;
        let omega2 = |scene: &Scene| {
            let dt_crit = scene.step_limits().unwrap().dt_crit;
            4.0 / (dt_crit * dt_crit) * scene.sheet.node_mass / (scene.yarn.modulus_mean * scene.sheet.yarn_area)
                * scene.sheet.spacing
        };
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        let (long, cross) = (2.0 * (3.0 * 1.03 * 1.03 - 1.0), 2.0 * (1.03 * 1.03 - 1.0));
        close(omega2(&scene), long + cross);
        scene.sheet.yarn_area_y = 2.0 * scene.sheet.yarn_area;
        close(omega2(&scene), 2.0 * long + cross);
        scene.sheet.spacing_y = 1.5 * scene.sheet.spacing;
        close(omega2(&scene), 2.0 / 1.5 * long + cross);
        scene.sheet.crimp = [0.0, 1.0];
        close(omega2(&scene), long + 2.0 / 3.0 * cross);
        scene.sheet.crimp = [0.0; 2];
        scene.sheet.pre_strain = [0.02, 0.0];
        close(omega2(&scene), 2.0 / 1.5 * long + 1.02 * cross);
        scene.weft =
            crate::Weft { modulus_mean: 280.42e9, damage_intercept: 50.0, critical_stretch: 1.1, ..scene.weft };
        close(omega2(&scene), 4.0 / 1.5 * 2.0 * (3.0 * 1.1 * 1.1 - 1.0) + 1.02 * cross);
    }
}
