//! Constants of the segments of one direction: state at rest, law and mean constants.
//!
//! Reference: docs/model.md, "Unlike directions, crimp and pre-tension".

use crate::ground::planes::Axis;
use crate::scene::features::Feature;
use crate::scene::measures::Cloth;
use crate::scene::parts::Scene;
use crate::sheet::casing::{self, Cylinder};
use crate::sheet::draw::Arrangement;
use crate::yarn::law::{DamageLaw, Rest, Viscosity};
use crate::yarn::rate::RateLaw;

/// Constants of the horizontal or of the vertical segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// State at rest in the flat sheet.
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
    /// Volume A_0 l of a segment over that of a horizontal one, of the front fabric.
    pub volume: f64,
    /// Their viscosity.
    pub viscosity: Viscosity,
    /// Dependence on the rate of strain, at no time.
    pub rate: RateLaw,
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
        rate: RateLaw::NONE,
    };

    /// Constants of the segments of one direction for passes of dt, s. `unit`: volume of a horizontal segment
    /// of the front fabric, in m^2 and spacings.
    fn of(scene: &Scene, axis: Axis, dt: f64, unit: f64) -> Direction {
        let h = scene.sheet.spacing;
        let (rest, law, mean) = (rest_of(scene, axis), scene.damage_law(axis), scene.mean_segment(axis));
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
            volume: volume_of(scene, axis) / unit,
            viscosity: Viscosity::of(scene.viscosity(), stiffness, critical),
            rate: RateLaw::of(scene, rest.twice_strain),
        }
    }
}

/// State at rest of the segments of a direction.
fn rest_of(scene: &Scene, axis: Axis) -> Rest {
    Rest::of(scene.spacing(axis) / scene.sheet.spacing, scene.rest_stretch(axis))
}

/// Volume A_0 l of a segment, m^2 and spacings.
fn volume_of(scene: &Scene, axis: Axis) -> f64 {
    scene.yarn_area(axis) * rest_of(scene, axis).length
}

/// Warp and weft of one fabric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpAndWeft {
    /// Direction along x of a ply that is not turned: the warp.
    pub horizontal: Direction,
    /// Along y: the weft.
    pub vertical: Direction,
    /// Whether all segments lie at their natural length, the same along x and y, with the same critical
    /// stretch, as in the paper.
    pub plain: bool,
}

/// Horizontal and vertical segments of every ply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// Directions of the sheet, or of a stack's first plies.
    pub front: WarpAndWeft,
    /// Directions of the last plies, where they are of another fabric, else those of the front.
    pub back: WarpAndWeft,
    /// Fabric of each ply, and whether it is turned by 90 degrees.
    plies: Arrangement,
    /// Growth of the radius of a curved sheet from ply to ply, over that of the first.
    growth: f64,
    /// The case that a ring lies on.
    casing: Option<Cylinder>,
}

impl Directions {
    /// No constants: a place for them.
    pub(crate) const NOTHING: Directions = Directions {
        front: WarpAndWeft::NOTHING,
        back: WarpAndWeft::NOTHING,
        plies: Arrangement::SINGLE,
        growth: 0.0,
        casing: None,
    };

    /// Directions of a scene for passes of dt, s.
    #[inline(never)]
    pub(crate) fn of(scene: &Scene, dt: f64) -> Directions {
        let unit = volume_of(scene, Axis::Horizontal);
        let front = WarpAndWeft::of(scene, dt, unit);
        Directions {
            front,
            back: if scene.back.plies > 0 { WarpAndWeft::of(&scene.all_of_back(), dt, unit) } else { front },
            plies: scene.arrangement(),
            growth: if Feature::Curved.is_in(scene) { scene.ply_gap() / scene.sheet.radius } else { 0.0 },
            casing: Cylinder::of(scene),
        }
    }

    /// The case that a ring lies on.
    #[inline(always)]
    pub(crate) fn case(&self) -> Option<&Cylinder> {
        if casing::IS_BUILT { self.casing.as_ref() } else { None }
    }

    /// Constants of segments along x and along y in a ply, which may be turned by 90 degrees.
    pub(crate) fn of_ply(&self, ply: usize) -> PlyDirections<'_> {
        let WarpAndWeft { horizontal, vertical, plain } = if self.is_back(ply) { &self.back } else { &self.front };
        let (horizontal, vertical) =
            if self.plies.is_turned(ply) { (vertical, horizontal) } else { (horizontal, vertical) };
        let radius_ratio = self.radius_ratio(ply);
        PlyDirections { horizontal, vertical, plain: *plain && radius_ratio == 1.0, radius_ratio }
    }

    /// Radius of a ply of a curved sheet over that of the first; 1 in a flat one.
    pub(crate) fn radius_ratio(&self, ply: usize) -> f64 {
        1.0 + f64::from(ply as u32) * self.growth
    }

    /// Whether a ply is of the back fabric.
    pub(crate) fn is_back(&self, ply: usize) -> bool {
        self.plies.cloth(ply) == Cloth::Back
    }

    /// Whether segments pull in the flat sheet. What pre-tension there is all plies have.
    pub fn are_tense(&self) -> bool {
        self.front.horizontal.rest.twice_strain > 0.0 || self.front.vertical.rest.twice_strain > 0.0
    }
}

impl WarpAndWeft {
    /// No constants: a place for them.
    const NOTHING: WarpAndWeft =
        WarpAndWeft { horizontal: Direction::NOTHING, vertical: Direction::NOTHING, plain: true };

    fn of(scene: &Scene, dt: f64, unit: f64) -> WarpAndWeft {
        let [horizontal, vertical] =
            [Axis::Horizontal, Axis::Vertical].map(|axis| Direction::of(scene, axis, dt, unit));
        let at_rest = horizontal.rest == Rest::PLAIN && vertical.rest == Rest::PLAIN;
        WarpAndWeft { horizontal, vertical, plain: at_rest && horizontal.critical == vertical.critical }
    }

    /// With drawn strength the law becomes that of the weakest segment.
    pub(crate) fn weaken(&mut self, weakest: f64) {
        for direction in [&mut self.horizontal, &mut self.vertical] {
            direction.law = direction.law.at(weakest);
            direction.critical = direction.law.critical_twice_strain();
        }
    }
}

/// Constants of the segments of one ply, by direction.
#[derive(Clone, Copy)]
pub struct PlyDirections<'a> {
    /// Constants of the segments along x.
    pub horizontal: &'a Direction,
    /// Constants of the segments along y.
    pub vertical: &'a Direction,
    /// [`WarpAndWeft::plain`], of the radius of the first ply.
    pub plain: bool,
    /// Length of segments along x over that in the first ply of a curved sheet; 1 in a flat one.
    pub radius_ratio: f64,
}

impl<'a> PlyDirections<'a> {
    /// State at rest of the segments along x of a curved sheet.
    pub fn around(&self) -> Rest {
        self.horizontal.rest.in_series(self.radius_ratio)
    }

    /// States at rest of segments along x and along y of a flat sheet.
    #[inline(always)]
    pub fn rests(&self) -> [&'a Rest; 2] {
        [&self.horizontal.rest, &self.vertical.rest]
    }

    /// Constants of the segments along an axis.
    pub fn along(&self, axis: Axis) -> &'a Direction {
        match axis {
            Axis::Horizontal => self.horizontal,
            Axis::Vertical => self.vertical,
        }
    }
}
