//! From a textile's data sheet to a scene: node spacing, yarn area, node mass, crimp and yarn law.
//!
//! Method: a yarn of the linear density mu (kg/m) and fibres of the density rho has the area A_0 = mu/rho.
//! The warp runs along x, the weft along y, so the node spacing along x is the distance of two picks and that
//! along y the distance of two ends: h_x = 1/(picks per metre), h_y = 1/(ends per metre). With the crimp c
//! (length of the yarn over that of the cloth, less 1) a node carries m = mu_warp (1 + c_warp) h_x + mu_weft
//! (1 + c_weft) h_y, so that the areal density m/(h_x h_y) is that of the textile. The law is that of (M1) to
//! (M5) with the modulus E of the yarn and U_c = 1 + (1 - w) e_f, with the failure strain e_f and the weaving
//! loss w; from the strength s instead it is the U_c at which the nominal stress E U (U^2 - 1)/2 is (1 - w)
//! s.
//! Limits: strength and failure strain cannot both be met, as E follows from neither; so one of them is
//! given. Beyond U_c the yarn weakens at the rate `damage_rate`, which no data sheet has: `calibrate.rs`
//! finds it for a bundle of misaligned fibrils; the energy that it dissipates is proportional to the length
//! of a segment.
//! Reference: docs/model.md, "From a textile to a scene".

use crate::ground::error::{Code, Error, finite, not_negative, positive};
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::scene::features::Feature;
use crate::scene::parts::{Back, CRITICAL_STRETCH_MAX, DAMAGE_RATE_MIN, Scene, StrengthDraw, WEIBULL_SHAPES, Weft};
use crate::yarn::law::twice_strain_at;

/// The yarns of one direction of a textile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Threads {
    /// Mass of a yarn over its length, kg/m, > 0.
    pub linear_density: f64,
    /// Yarns per metre of cloth, 1/m, > 0: ends of the warp, picks of the weft.
    pub count: f64,
    /// Crimp: length of a yarn over that of the cloth, less 1, in [0, 1].
    pub crimp: f64,
}

/// A textile of two directions of one fibre, per ply.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Textile {
    /// Yarns along x.
    pub warp: Threads,
    /// Yarns along y.
    pub weft: Threads,
    /// Density of the fibre, kg/m^3, > 0.
    pub fibre_density: f64,
    /// Young's modulus of a yarn, over the area of its fibres, Pa, > 0.
    pub modulus: f64,
    /// Standard deviation of that modulus among segments, Pa, >= 0; 0: all have the same.
    pub modulus_sd: f64,
    /// Strain at which a yarn begins to fail, in (0, 1]; 0: `strength` says it. With a Weibull shape: the
    /// Weibull scale.
    pub failure_strain: f64,
    /// Force at which a yarn begins to fail over the area of its fibres at rest, Pa, > 0; 0: `failure_strain`
    /// says it.
    pub strength: f64,
    /// Part of the failure strain, or of the strength, that weaving has taken, in [0, 1); 0 for yarn taken
    /// from the fabric.
    pub weaving_loss: f64,
    /// Damage rate lambda beyond the failure strain, dimensionless, at least 3; 0: ln(100)/0.002.
    pub damage_rate: f64,
    /// Weibull shape of the failure strain, in [1, 1000]; 0: all segments fail at the same strain.
    pub weibull_shape: f64,
    /// Gauge length of the failure strain, m, >= 0; 0: the length of a segment. Read with a Weibull shape
    /// only.
    pub gauge_length: f64,
    /// Thickness of the ply, m, >= 0; 0: unknown, and [`Textile::assumed_thickness`] is taken.
    pub thickness: f64,
}

/// Share of fibre in the volume of cloth whose thickness is unknown: that of five packs of Twaron CT612
/// (0.119 kg/m^2, 1440 kg/m^3 and 0.161 to 0.171 mm a layer; docs/validation.md).
const SHARE_OF_FIBRE: f64 = 0.48;

/// Damage rate of a textile whose data sheet has none, as all: ln(100)/0.002, so that a yarn keeps 1 % of its
/// stiffness 0.2 % of strain beyond the failure strain, which it thus hardly exceeds.
const DAMAGE_RATE: f64 = 2302.6;

/// Viscosity of a textile: linear, quadratic and of bending (docs/model.md, "Viscosity").
pub const TEXTILE_VISCOSITY: [f64; 3] = [0.06, 1.5, 0.06];

/// Largest effect of the quadratic part on the largest step, eta of (M18).
const QUADRATIC_SHARE: f64 = 0.25;

/// -ln of the part of drawn segments, 1e-9, that may be stronger than the viscosity is made for.
const STRONGEST: f64 = 20.72;

/// The [`TEXTILE_VISCOSITY`], with less of the quadratic part for yarn of which a segment may fail beyond 7 %
/// of strain: it then takes the default step, too.
fn viscosity_at(critical_stretch: f64) -> [f64; 3] {
    let [linear, quadratic, bending] = TEXTILE_VISCOSITY;
    let critical = twice_strain_at(critical_stretch) * critical_stretch * critical_stretch;
    [linear, math::min(QUADRATIC_SHARE / critical, quadratic), bending]
}

/// kg/m of so many denier: grams in 9000 m.
pub fn denier(value: f64) -> f64 {
    value * 1e-3 / 9000.0
}

/// kg/m of so many dtex: grams in 10 000 m.
pub fn dtex(value: f64) -> f64 {
    value * 1e-3 / 10_000.0
}

/// 1/m of so many yarns per inch.
pub fn per_inch(value: f64) -> f64 {
    value / 0.0254
}

/// Pa of a tenacity or modulus in cN/dtex: of fibres of this density, kg/m^3.
pub fn centinewton_per_dtex(value: f64, fibre_density: f64) -> f64 {
    value * 1e5 * fibre_density
}

impl Threads {
    fn check(&self, [linear_density, count, crimp]: [&'static str; 3]) -> Result<(), Error> {
        positive(linear_density, self.linear_density)?;
        positive(count, self.count)?;
        within(crimp, self.crimp, 1.0)
    }

    /// kg of yarn in a square metre of cloth.
    fn areal_density(&self) -> f64 {
        self.linear_density * (1.0 + self.crimp) * self.count
    }
}

/// Refuses what is not in [0, greatest].
fn within(field: &'static str, value: f64, greatest: f64) -> Result<(), Error> {
    not_negative(field, value)?;
    if value <= greatest { Ok(()) } else { Err(Error::new(Code::OutOfRange, field, value, greatest)) }
}

impl Textile {
    /// Mass of a square metre of one ply, kg/m^2.
    pub fn areal_density(&self) -> f64 {
        self.warp.areal_density() + self.weft.areal_density()
    }

    /// Thickness of a ply, m, of which 0.48 are fibre.
    pub fn assumed_thickness(&self) -> f64 {
        self.areal_density() / (SHARE_OF_FIBRE * self.fibre_density)
    }

    /// Speed of a longitudinal wave in a straight yarn by itself at small strain, m/s: sqrt(E/rho).
    pub fn wave_speed(&self) -> f64 {
        math::sqrt(self.modulus / self.fibre_density)
    }

    /// Critical stretch U_c.
    ///
    /// # Errors
    /// As [`Scene::set_textile`], of the numbers that it depends on.
    pub fn critical_stretch(&self) -> Result<f64, Error> {
        within("textile.failure_strain", self.failure_strain, CRITICAL_STRETCH_MAX - 1.0)?;
        not_negative("textile.strength", self.strength)?;
        positive("textile.modulus", self.modulus)?;
        not_negative("textile.weaving_loss", self.weaving_loss)?;
        if self.weaving_loss >= 1.0 {
            return Err(Error::new(Code::OutOfRange, "textile.weaving_loss", self.weaving_loss, 1.0));
        }
        let left = 1.0 - self.weaving_loss;
        let stretch = match (self.failure_strain > 0.0, self.strength > 0.0) {
            (true, true) => return Err(Error::beside("textile.strength", "textile.failure_strain")),
            (false, false) => return Err(Error::plain(Code::NotPositive, "textile.failure_strain")),
            (true, false) => 1.0 + left * self.failure_strain,
            (false, true) => {
                // E U (U^2 - 1)/2 is 3 E at U = 2.
                let limit = 3.0 * self.modulus / left;
                if self.strength > limit {
                    return Err(Error::new(Code::OutOfRange, "textile.strength", self.strength, limit));
                }
                stretch_at(left * self.strength / self.modulus)
            }
        };
        let beyond = if self.strength > 0.0 {
            ("textile.strength", self.strength)
        } else {
            ("textile.failure_strain", self.failure_strain)
        };
        if stretch > 1.0 { Ok(stretch) } else { Err(Error::new(Code::OutOfRange, beyond.0, beyond.1, f64::EPSILON)) }
    }

    fn check(&self) -> Result<f64, Error> {
        self.warp.check(["textile.warp.linear_density", "textile.warp.count", "textile.warp.crimp"])?;
        self.weft.check(["textile.weft.linear_density", "textile.weft.count", "textile.weft.crimp"])?;
        positive("textile.fibre_density", self.fibre_density)?;
        let critical_stretch = self.critical_stretch()?;
        not_negative("textile.modulus_sd", self.modulus_sd)?;
        finite("textile.damage_rate", self.damage_rate)?;
        if self.damage_rate != 0.0 && self.damage_rate < DAMAGE_RATE_MIN {
            return Err(Error::new(Code::DamageRateTooSmall, "textile.damage_rate", self.damage_rate, DAMAGE_RATE_MIN));
        }
        within("textile.weibull_shape", self.weibull_shape, WEIBULL_SHAPES[1])?;
        if self.weibull_shape != 0.0 && self.weibull_shape < WEIBULL_SHAPES[0] {
            return Err(Error::new(Code::OutOfRange, "textile.weibull_shape", self.weibull_shape, WEIBULL_SHAPES[0]));
        }
        not_negative("textile.gauge_length", self.gauge_length)?;
        not_negative("textile.thickness", self.thickness)?;
        Ok(critical_stretch)
    }
}

/// The stretch at which the nominal stress is `s` times the modulus: U (U^2 - 1)/2 = s, for s in [0, 3].
///
/// Newton's method from 1 + s, which is above the root: the function is convex there, so it comes down to it.
fn stretch_at(s: f64) -> f64 {
    // In the strain x = U - 1, so that small ones keep their digits: x + 1.5 x^2 + 0.5 x^3 = s.
    let mut x = s;
    for _ in 0..12 {
        let value = x * (1.0 + x * (1.5 + 0.5 * x)) - s;
        x -= value / (1.0 + x * (3.0 + 1.5 * x));
    }
    1.0 + x
}

impl Scene {
    /// Makes the sheet of this textile: spacings, areas, node mass, crimp, thickness, the yarn law, without a
    /// law of the weft's own, and the [`TEXTILE_VISCOSITY`]; with crimp also `slack_balance`, but where yarn
    /// depends on the rate. The theta rule takes neither. Number of nodes and plies, place, pre-strain,
    /// supports, `yarn.alpha_fail`, `yarn.draw` and all else stay.
    ///
    /// # Errors
    /// Fields `textile.*`: not finite, not positive, out of the range stated; both or none of failure strain
    /// and strength. Nothing is changed then. Whether it goes with the rest of the scene is left to
    /// [`Scene::check`].
    pub fn set_textile(&mut self, textile: &Textile) -> Result<(), Error> {
        let critical_stretch = textile.check()?;
        let damage_rate = if textile.damage_rate == 0.0 { DAMAGE_RATE } else { textile.damage_rate };
        let (warp, weft) = (&textile.warp, &textile.weft);
        let (h_x, h_y) = (1.0 / weft.count, 1.0 / warp.count);
        let area = |threads: &Threads| threads.linear_density / textile.fibre_density;
        let sheet = &mut self.sheet;
        sheet.spacing = h_x;
        sheet.yarn_area = area(warp);
        // What is alike in both directions is said once: the sheet of a plain textile is a plain one.
        sheet.spacing_y = if warp.count == weft.count { 0.0 } else { h_y };
        sheet.yarn_area_y = if warp.linear_density == weft.linear_density { 0.0 } else { area(weft) };
        sheet.node_mass =
            warp.linear_density * (1.0 + warp.crimp) * h_x + weft.linear_density * (1.0 + weft.crimp) * h_y;
        sheet.crimp = [warp.crimp, weft.crimp];
        let assumed = if Feature::Thickness.is_built() { textile.assumed_thickness() } else { 0.0 };
        sheet.thickness = if textile.thickness == 0.0 { assumed } else { textile.thickness };
        self.weft = Weft::LIKE_WARP;
        let yarn = &mut self.yarn;
        (yarn.modulus_mean, yarn.modulus_sd) = (textile.modulus, textile.modulus_sd);
        (yarn.damage_slope, yarn.damage_intercept, yarn.damage_sd) = (0.0, damage_rate, 0.0);
        (yarn.damage_a, yarn.damage_b) = (1.0, 0.0);
        yarn.critical_stretch = critical_stretch;
        yarn.stochastic = textile.modulus_sd > 0.0;
        yarn.strength_draw = StrengthDraw::None;
        let mut strongest = critical_stretch;
        if textile.weibull_shape > 0.0 {
            yarn.strength_draw = StrengthDraw::Weibull;
            (yarn.weibull_shape, yarn.weibull_gauge_length) = (textile.weibull_shape, textile.gauge_length);
            let lengths = if textile.gauge_length > 0.0 { textile.gauge_length / math::min(h_x, h_y) } else { 1.0 };
            let factor = math::exp(math::ln(math::max(lengths * STRONGEST, 1.0)) / textile.weibull_shape);
            strongest = math::min(1.0 + (critical_stretch - 1.0) * factor, CRITICAL_STRETCH_MAX);
        }
        [yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending] = viscosity_at(strongest);
        self.slack_balance = self.sheet.crimp != [0.0; 2] && !Feature::Rate.is_in(self);
        if Feature::Curved.is_in(self) {
            self.yarn.viscosity_bending = 0.0;
        }
        Ok(())
    }

    /// Makes the back fabric of this textile, in the scene's own grid: a bar stands for as many yarns as
    /// there are in a spacing, so areal density, stiffness and strength per width are those of the textile.
    /// The number of its plies, `back.plies`, stays, and so does the thickness of a ply, that of the front.
    /// The quadratic viscosity becomes that of the textile of the two that takes less.
    ///
    /// # Errors
    /// As [`Scene::set_textile`], and a thickness that is not `sheet.thickness`.
    pub fn set_back_textile(&mut self, textile: &Textile) -> Result<(), Error> {
        // In a scene of its own that has the grid of the textile.
        let mut alone = *self;
        alone.set_textile(textile)?;
        if textile.thickness != 0.0 && textile.thickness != self.sheet.thickness {
            return Err(Error::beside("textile.thickness", "sheet.thickness"));
        }
        let [h_x, h_y] = self.spacings();
        let [own_x, own_y] = alone.spacings();
        // Yarns along x in a spacing along y, and the other way round.
        let (along_x, along_y) = (h_y / own_y, h_x / own_x);
        let (warp, weft, sheet, yarn) = (&textile.warp, &textile.weft, &alone.sheet, &alone.yarn);
        let [area_x, area_y] =
            [(Axis::Horizontal, along_x), (Axis::Vertical, along_y)].map(|(axis, yarns)| alone.yarn_area(axis) * yarns);
        self.back = Back {
            plies: self.back.plies,
            node_mass: warp.linear_density * (1.0 + warp.crimp) * h_x * along_x
                + weft.linear_density * (1.0 + weft.crimp) * h_y * along_y,
            yarn_area: area_x,
            yarn_area_y: if area_x == area_y { 0.0 } else { area_y },
            crimp: sheet.crimp,
            modulus_mean: yarn.modulus_mean,
            modulus_sd: yarn.modulus_sd,
            damage_slope: yarn.damage_slope,
            damage_intercept: yarn.damage_intercept,
            damage_sd: yarn.damage_sd,
            critical_stretch: yarn.critical_stretch,
            weibull_shape: if yarn.strength_draw == StrengthDraw::None { 0.0 } else { yarn.weibull_shape },
            weibull_gauge_length: if yarn.strength_draw == StrengthDraw::None {
                0.0
            } else {
                yarn.weibull_gauge_length
            },
        };
        self.yarn.viscosity_quadratic = math::min(yarn.viscosity_quadratic, self.yarn.viscosity_quadratic);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::close;

    /// Unlike directions with crimp.
    fn unlike() -> Textile {
        Textile {
            warp: Threads { linear_density: denier(600.0), count: per_inch(34.0), crimp: 0.013 },
            weft: Threads { linear_density: dtex(930.0), count: 900.0, crimp: 0.004 },
            fibre_density: 1440.0,
            modulus: 84.62e9,
            failure_strain: 0.0355,
            damage_rate: 2300.0,
            ..Textile::default()
        }
    }

    /// One yarn both ways, without crimp.
    fn plain() -> Textile {
        let threads = Threads { linear_density: denier(600.0), count: per_inch(34.0), crimp: 0.0 };
        Textile { warp: threads, weft: threads, ..unlike() }
    }

    fn scene_of(textile: &Textile) -> Scene {
        let mut scene = Scene::sheet_3in_sphere();
        scene.set_textile(textile).unwrap();
        scene.check().unwrap();
        scene
    }

    /// Strong segments are stiff against fast stretching: the viscosity of widely drawn strength is made for
    /// them.
    #[test]
    fn any_drawn_strength_takes_the_default_step() {
        for weibull_shape in [1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 15.0, 40.0] {
            for gauge_length in [0.0, 0.05] {
                let mut scene = Scene::sheet_3in_sphere();
                scene.set_textile(&Textile { weibull_shape, gauge_length, ..plain() }).unwrap();
                scene.step_limits().unwrap();
            }
        }
    }

    #[test]
    fn units_of_data_sheets() {
        // 9000 m of one denier and 10 000 m of one dtex weigh a gram; 25.4 yarns an inch are 1000 a metre.
        close(denier(9000.0), 1e-3, 1e-15);
        close(dtex(10_000.0), 1e-3, 1e-15);
        close(per_inch(25.4), 1000.0, 1e-15);
        // 1 N on 1 tex, 1e-6 kg/m, is 1 N on an area of 1e-6/1540 m^2: 1.54 GPa; it is 10 cN/dtex.
        close(centinewton_per_dtex(10.0, 1540.0), 1.54e9, 1e-15);
    }

    #[test]
    fn the_sheet_weighs_what_the_textile_weighs() {
        for textile in [plain(), unlike()] {
            let scene = scene_of(&textile);
            let [h_x, h_y] = scene.spacings();
            close(scene.sheet.node_mass / (h_x * h_y), textile.areal_density(), 1e-14);
        }
        // 2 x 600 g in 9000 m x 34/0.0254 yarns a metre.
        close(plain().areal_density(), 0.178_477_690, 1e-8);
    }

    #[test]
    fn a_yarn_by_itself_has_the_wave_speed_of_its_fibre() {
        let textile = plain();
        let scene = scene_of(&textile);
        // E A_0 over the mass per length of one of the two yarns that meet at a node.
        let mu = 0.5 * scene.sheet.node_mass / scene.sheet.spacing;
        let speed = math::sqrt(scene.yarn.modulus_mean * scene.sheet.yarn_area / mu);
        close(speed, textile.wave_speed(), 1e-14);
        close(speed, math::sqrt(84.62e9 / 1440.0), 1e-14);
    }

    #[test]
    fn the_warp_runs_along_x_and_its_yarns_are_spaced_along_y() {
        let scene = scene_of(&unlike());
        close(scene.spacing(Axis::Horizontal), 1.0 / 900.0, 1e-15);
        close(scene.spacing(Axis::Vertical), 0.0254 / 34.0, 1e-15);
        close(scene.yarn_area(Axis::Horizontal), 600e-3 / 9000.0 / 1440.0, 1e-14);
        close(scene.yarn_area(Axis::Vertical), 93e-6 / 1440.0, 1e-14);
        assert_eq!(scene.sheet.crimp, [0.013, 0.004]);
    }

    /// In any grid a back fabric weighs what its textile weighs, and its bars have the wave speed of its
    /// yarns: stiffness per width over areal density.
    #[test]
    fn a_back_fabric_keeps_mass_and_stiffness_in_another_grid() {
        for textile in [plain(), unlike()] {
            let mut scene = Scene::sheet_3in_sphere();
            for spacing_y in [0.0, 9e-4] {
                scene.sheet.spacing_y = spacing_y;
                scene.set_back_textile(&textile).unwrap();
                let ([h_x, h_y], back) = (scene.spacings(), scene.all_of_back());
                close(back.sheet.node_mass / (h_x * h_y), textile.areal_density(), 1e-14);
                let own = textile.warp.linear_density / textile.fibre_density;
                close(back.yarn_area(Axis::Horizontal) / h_y, own * textile.warp.count, 1e-14);
                let own = textile.weft.linear_density / textile.fibre_density;
                close(back.yarn_area(Axis::Vertical) / h_x, own * textile.weft.count, 1e-14);
            }
        }
    }

    /// The textile of the front plies as that of the back ones changes no number.
    #[test]
    fn the_same_textile_behind_is_the_same_fabric() {
        for textile in
            [plain(), unlike(), Textile { modulus_sd: 1e9, weibull_shape: 14.7, gauge_length: 0.05, ..unlike() }]
        {
            let mut scene = scene_of(&textile);
            scene.set_back_textile(&textile).unwrap();
            let mut back = scene.all_of_back();
            // Areas alike in both directions, and draws that are not read.
            (back.sheet.yarn_area_y, scene.sheet.yarn_area_y) =
                (back.yarn_area(Axis::Vertical), scene.yarn_area(Axis::Vertical));
            back.back = scene.back;
            if scene.yarn.strength_draw == StrengthDraw::None {
                (back.yarn.weibull_shape, scene.yarn.weibull_shape) = (0.0, 0.0);
            }
            assert_eq!(back, scene);
        }
    }

    #[test]
    fn what_both_directions_share_is_said_once() {
        let scene = scene_of(&plain());
        assert_eq!((scene.sheet.spacing_y, scene.sheet.yarn_area_y, scene.weft), (0.0, 0.0, Weft::LIKE_WARP));
        close(scene.sheet.yarn_area, 4.629_629_6e-8, 1e-8);
        close(scene.sheet.node_mass, 9.960_784e-8, 1e-6);
    }

    #[test]
    fn strength_gives_the_stretch_at_which_the_law_has_it() {
        for s in [1e-12, 1e-4, 0.04, 0.3, 1.0, 3.0] {
            let strength = s * 84.62e9;
            let textile = Textile { failure_strain: 0.0, strength, ..plain() };
            let u = textile.critical_stretch().unwrap();
            let nominal = 0.5 * textile.modulus * u * twice_strain_at(u);
            close(nominal, strength, if s < 1e-3 { 1e-3 } else { 1e-13 });
            let woven = Textile { strength: 1.25 * strength, weaving_loss: 0.2, ..textile };
            close(woven.critical_stretch().unwrap(), u, 1e-14);
        }
        let woven = Textile { failure_strain: 0.05, weaving_loss: 0.3, ..plain() };
        close(woven.critical_stretch().unwrap(), 1.035, 1e-15);
    }

    #[test]
    fn the_law_is_that_of_the_data() {
        let mut scene = scene_of(&plain());
        let yarn = scene.yarn;
        assert_eq!((yarn.modulus_mean, yarn.critical_stretch, yarn.stochastic), (84.62e9, 1.0355, false));
        assert_eq!(scene.mean_segment(Axis::Horizontal).damage_rate, 2300.0);
        assert_eq!(yarn.strength_draw, StrengthDraw::None);
        let scattered =
            Textile { modulus_sd: 1e9, weibull_shape: 14.7, gauge_length: 0.05, damage_rate: 1000.0, ..plain() };
        scene.set_textile(&scattered).unwrap();
        let yarn = scene.yarn;
        assert_eq!((yarn.stochastic, yarn.modulus_sd, yarn.damage_sd), (true, 1e9, 0.0));
        assert_eq!(yarn.strength_draw, StrengthDraw::Weibull);
        assert_eq!((yarn.weibull_shape, yarn.weibull_gauge_length), (14.7, 0.05));
    }

    #[test]
    fn yarn_of_a_textile_is_viscous_and_takes_the_default_step() {
        let scene = scene_of(&plain());
        assert_eq!((scene.viscosity(), scene.slack_balance), (TEXTILE_VISCOSITY, false));
        assert!(scene_of(&unlike()).slack_balance);
        scene.step_limits().unwrap();
        // Yarn that gives more has less of the quadratic part, and takes it too.
        for failure_strain in [0.07, 0.075, 0.15, 0.3, 1.0] {
            let scene = scene_of(&Textile { failure_strain, ..plain() });
            let [linear, quadratic, bending] = scene.viscosity();
            assert_eq!((linear, bending), (0.06, 0.06));
            assert_eq!(quadratic == 1.5, failure_strain < 0.073, "{failure_strain}: {quadratic}");
            assert!(quadratic > 0.0 && scene.step_limits().is_ok());
        }
    }

    #[test]
    fn bad_numbers_are_named_and_change_nothing() {
        type Change = fn(&mut Textile, f64);
        let cases: [(&str, Change, &[f64], Code); 21] = [
            ("textile.warp.linear_density", |t, x| t.warp.linear_density = x, &[0.0, -1.0], Code::NotPositive),
            ("textile.warp.count", |t, x| t.warp.count = x, &[0.0, -1.0], Code::NotPositive),
            ("textile.warp.crimp", |t, x| t.warp.crimp = x, &[-0.1, 1.1], Code::OutOfRange),
            ("textile.weft.linear_density", |t, x| t.weft.linear_density = x, &[0.0], Code::NotPositive),
            ("textile.weft.count", |t, x| t.weft.count = x, &[0.0], Code::NotPositive),
            ("textile.weft.crimp", |t, x| t.weft.crimp = x, &[-0.1, 1.1], Code::OutOfRange),
            ("textile.fibre_density", |t, x| t.fibre_density = x, &[0.0], Code::NotPositive),
            ("textile.modulus", |t, x| t.modulus = x, &[0.0, -1.0], Code::NotPositive),
            ("textile.modulus_sd", |t, x| t.modulus_sd = x, &[-1.0], Code::OutOfRange),
            ("textile.failure_strain", |t, x| t.failure_strain = x, &[-0.1, 1.1, 1e-20], Code::OutOfRange),
            ("textile.failure_strain", |t, x| t.failure_strain = x, &[0.0], Code::NotPositive),
            ("textile.strength", |t, x| t.strength = x, &[-1.0], Code::OutOfRange),
            ("textile.strength", |t, x| t.strength = x, &[3e9], Code::DoesNotGoWith),
            ("textile.strength", |t, x| (t.failure_strain, t.strength) = (0.0, x), &[1e12, 1e-9], Code::OutOfRange),
            ("textile.weaving_loss", |t, x| t.weaving_loss = x, &[-0.1, 1.0], Code::OutOfRange),
            ("textile.damage_rate", |t, x| t.damage_rate = x, &[-1.0, 2.9], Code::DamageRateTooSmall),
            ("textile.weibull_shape", |t, x| t.weibull_shape = x, &[-1.0, 0.5, 1001.0], Code::OutOfRange),
            ("textile.gauge_length", |t, x| t.gauge_length = x, &[-1.0], Code::OutOfRange),
            ("textile.modulus", |t, x| t.modulus = x, &[f64::NAN], Code::NotFinite),
            ("textile.weft.crimp", |t, x| t.weft.crimp = x, &[f64::INFINITY], Code::NotFinite),
            ("textile.damage_rate", |t, x| t.damage_rate = x, &[f64::NAN], Code::NotFinite),
        ];
        for (field, change, values, code) in cases {
            for &value in values {
                let (mut scene, mut textile) = (Scene::sheet_3in_sphere(), plain());
                change(&mut textile, value);
                let error = scene.set_textile(&textile).unwrap_err();
                assert_eq!((error.field, error.code), (field, code), "{value}");
                assert_eq!(scene, Scene::sheet_3in_sphere());
            }
        }
    }
}
