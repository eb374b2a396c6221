//! Features: additions of a scene to a plain sheet, and of a build to plain steps; one record each.
//!
//! From the records follow which fields ask for a feature, whether this build has it, what it does not go
//! with. [`Features`] is the set that one scene has. Code that serves a feature asks [`Features::has`] once,
//! where it begins: in a build without the feature the compiler leaves the code out.

use crate::ground::error::Error;
use crate::scene::parts::{Drive, IntegratorKind, RotationKind, Scene, Shape, StrengthDraw, Weft};

/// Feature of a scene or a build: the record of each in [`FEATURES`] says what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum Feature {
    Rate,
    PreTension,
    Friction,
    Viscosity,
    Plies,
    Slack,
    Drawn,
    Strength,
    Prescribed,
    Mirrors,
    Grading,
    Theta,
    ThetaRotation,
    Crimp,
    Unlike,
    Polyhedra,
    Detachment,
    Through,
    Snapshot,
    Bands,
    Blocks,
    Curved,
    Closed,
    Casing,
    Vectors,
    Slip,
    Clamps,
    Thickness,
}

/// Whether a scene asks for something.
pub type Asks = fn(&Scene) -> bool;

/// All that is to be known of a feature.
pub struct Record {
    /// Which one.
    pub feature: Feature,
    /// Cargo feature that builds it.
    pub name: &'static str,
    /// Whether this build has it.
    pub built: bool,
    /// Fields that ask for it, and whether they do; none for what a call asks for, or the machine.
    pub asked_by: &'static [(&'static str, Asks)],
    /// Features that a scene cannot have, too. Each pair stands once.
    pub not_with: &'static [Feature],
    /// Meaning.
    pub about: &'static str,
}

use Feature::*;

/// Record of a feature that a scene cannot ask for, unless more is said, and that goes with all others.
macro_rules! feature {
    ($feature:ident, $name:literal, $about:literal) => {
        Record {
            feature: Feature::$feature,
            name: $name,
            built: cfg!(feature = $name),
            asked_by: &[],
            not_with: &[],
            about: $about,
        }
    };
}

/// Every feature, in the order of [`Feature`], which is that of the refusals.
pub const FEATURES: [Record; 28] = [
    feature!(Rate, "rate", "Modulus and strength that depend on the rate of strain")
        .fields(&[
            ("yarn.rate_modulus", |s| s.yarn.rate_modulus != 0.0),
            ("yarn.rate_stretch", |s| s.yarn.rate_stretch != 0.0),
        ])
        .not_with(&[Plies, Theta]),
    feature!(PreTension, "crimp", "A sheet that is held strained")
        .fields(&[("sheet.pre_strain", |s| s.sheet.pre_strain != [0.0; 2])])
        // A strain that is there before the load has no rate.
        .not_with(&[Rate]),
    feature!(Friction, "friction", "Friction between yarn and projectile")
        .fields(&[("contact.friction", |s| s.contact.friction != 0.0)])
        .not_with(&[Theta]),
    feature!(Viscosity, "viscosity", "Viscous yarn")
        .fields(&[
            ("yarn.viscosity_linear", |s| s.yarn.viscosity_linear != 0.0),
            ("yarn.viscosity_quadratic", |s| s.yarn.viscosity_quadratic != 0.0),
            ("yarn.viscosity_bending", |s| s.yarn.viscosity_bending != 0.0),
        ])
        .not_with(&[Theta]),
    feature!(Plies, "plies", "Separate plies in contact, of two fabrics if need be")
        .fields(&[("stack.plies", |s| s.stack.plies > 1)])
        .not_with(&[Theta, Mirrors]),
    feature!(Slack, "slack", "Correction of the energy error of segments that become slack or taut")
        .fields(&[("slack_balance", |s| s.slack_balance)])
        // The work of a stress that relaxes is not known within a step.
        .not_with(&[Rate, Theta]),
    feature!(Drawn, "drawn", "A modulus and a damage rate sampled for every segment or yarn")
        .fields(&[
            ("yarn.stochastic", |s| s.yarn.stochastic),
            ("back.modulus_sd", |s| s.back.plies > 0 && s.back.is_drawn()),
        ])
        // Mirror planes need yarn that is alike everywhere and a body that contact alone moves.
        .not_with(&[Mirrors]),
    feature!(Strength, "strength", "A critical stretch sampled for every segment")
        .fields(&[
            ("yarn.strength_draw", |s| s.yarn.strength_draw != StrengthDraw::None),
            ("back.weibull_shape", |s| s.back.plies > 0 && s.back.weibull_shape != 0.0),
        ])
        .not_with(&[Mirrors]),
    feature!(Prescribed, "prescribed", "A projectile on a path that the host gives")
        .fields(&[("drive", |s| s.drive != Drive::Free)])
        .not_with(&[Mirrors]),
    feature!(Mirrors, "mirrors", "Mirror planes through the middle of the sheet")
        .fields(&[("symmetry.mirror_x", |s| s.symmetry.mirror_x), ("symmetry.mirror_y", |s| s.symmetry.mirror_y)]),
    feature!(Grading, "grading", "A graded network: bars that stand for several yarns away from the hit")
        .fields(&[("sheet.grading.largest", |s| s.sheet.grading.largest > 1)]),
    feature!(Theta, "theta", "The theta rule for the nodes, by fixed-point iteration")
        .fields(&[("integrator.kind", |s| s.integrator.kind == IntegratorKind::Theta)]),
    feature!(ThetaRotation, "theta", "The theta rule for the projectile's rotation")
        .fields(&[("rotation_rule.kind", |s| s.rotation_rule.kind == RotationKind::Theta)]),
    feature!(Crimp, "crimp", "Yarn that is longer than its place in the sheet").fields(&[
        ("sheet.crimp", |s| s.sheet.crimp != [0.0; 2]),
        ("back.crimp", |s| s.back.plies > 0 && s.back.crimp != [0.0; 2]),
    ]),
    feature!(Unlike, "unlike", "A weft with a spacing, a yarn or a strength of its own")
        .fields(&[("sheet.spacing_y", |s| s.sheet.spacing_y != 0.0), ("weft", |s| s.weft != Weft::LIKE_WARP)]),
    feature!(Polyhedra, "polyhedra", "Boxes, convex polyhedra, prisms and sectors of discs")
        .fields(&[("projectile.shape", |s| {
            matches!(s.projectile.shape, Shape::Box | Shape::Polyhedron | Shape::DiscSector)
        })]),
    feature!(Detachment, "detachment", "The outcome that a part of the sheet has torn off its supports")
        .fields(&[("track_detachment", |s| s.track_detachment)]),
    feature!(Through, "detachment", "The outcome that held yarn does not stop the projectile any more")
        .fields(&[("track_through", |s| s.track_through)]),
    feature!(Snapshot, "snapshot", "Images of a simulation, to go back to and to go on from elsewhere"),
    feature!(Bands, "bands", "Bands of rows for threads of the host"),
    feature!(Blocks, "blocks", "Several steps of a large sheet in one pass over its memory, which is fetched ahead"),
    feature!(Curved, "rings", "A sheet that is curved about an axis along y")
        .fields(&[("sheet.radius", |s| s.sheet.radius != 0.0)])
        .not_with(&[Rate, Grading, Theta, Mirrors]),
    feature!(Closed, "rings", "A ring: the last node of a row is joined to its first")
        .fields(&[("sheet.closed", |s| s.sheet.closed)]),
    feature!(Casing, "rings", "A rigid case that a ring lies on")
        .fields(&[("casing.radius", |s| s.casing.radius != 0.0)]),
    feature!(Vectors, "vectors", "AVX2 and AVX-512 on machines that have them"),
    feature!(Slip, "slip", "The read-out of crossings that would slip"),
    feature!(Clamps, "clamps", "Attachments that slip, let go and tear out")
        .fields(&[
            ("attachment.hold", |s| s.attachment.hold != 0.0),
            ("attachment.strength", |s| s.attachment.strength != 0.0),
        ])
        .not_with(&[Theta]),
    feature!(Thickness, "thickness", "Cloth that touches at half of its thickness")
        .fields(&[("sheet.thickness", |s| s.sheet.thickness != 0.0)]),
];

impl Feature {
    /// Whether this build has it.
    #[inline(always)] // As `Features::has`.
    pub const fn is_built(self) -> bool {
        FEATURES[self as usize].built
    }

    /// Whether a scene asks for it, and this build has it.
    #[inline(always)] // As `Features::has`.
    pub fn is_in(self, scene: &Scene) -> bool {
        self.is_built() && FEATURES[self as usize].asked_by(scene).is_some()
    }

    /// # Errors
    /// `field`, a call or one of its arguments, needs it, and this build does not have it.
    pub(crate) fn needed_by(self, field: &'static str) -> Result<(), Error> {
        if self.is_built() { Ok(()) } else { Err(Error::not_built(field, FEATURES[self as usize].name)) }
    }
}

impl Record {
    const fn fields(self, asked_by: &'static [(&'static str, Asks)]) -> Record {
        Record { asked_by, ..self }
    }

    const fn not_with(self, not_with: &'static [Feature]) -> Record {
        Record { not_with, ..self }
    }

    /// The first of its fields by which a scene asks for it.
    pub fn asked_by(&self, scene: &Scene) -> Option<&'static str> {
        self.asked_by.iter().find(|(_, asks)| asks(scene)).map(|(field, _)| *field)
    }
}

/// The features that a scene has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features(u32);

impl Features {
    /// None.
    pub const NONE: Features = Features(0);

    /// Features that a scene asks for.
    pub fn of(scene: &Scene) -> Features {
        let asked = FEATURES.iter().filter(|record| record.asked_by(scene).is_some());
        asked.fold(Features::NONE, |all, record| all.with(record.feature))
    }

    /// These and one more.
    pub const fn with(self, feature: Feature) -> Features {
        Features(self.0 | 1 << feature as u32)
    }

    /// Whether viscosity or the rate dissipates energy.
    pub const fn dissipate(self) -> bool {
        self.has(Feature::Viscosity) || self.has(Feature::Rate)
    }

    /// Whether what contact impulses dissipate has parts of several kinds, or supports that move.
    pub const fn share_losses(self) -> bool {
        self.has(Feature::Friction)
            || self.has(Feature::Plies)
            || self.has(Feature::Casing)
            || self.has(Feature::Clamps)
    }

    /// Whether the feature is among them: never one that this build does not have.
    #[inline(always)] // So that the compiler knows of each one whether it is built.
    pub const fn has(self, feature: Feature) -> bool {
        feature.is_built() && self.0 & 1 << feature as u32 != 0
    }
}

impl Scene {
    /// Whether contact and loads move the projectile, and not the host.
    pub fn is_free(&self) -> bool {
        !Feature::Prescribed.is_built() || self.drive == Drive::Free
    }
}

/// Refuses a feature that this build does not have: the first that the scene asks for is named.
pub(crate) fn check_built(scene: &Scene) -> Result<(), Error> {
    check_in(scene, |record| record.built)
}

/// [`check_built`] in a build that has what is `built`.
fn check_in(scene: &Scene, built: fn(&Record) -> bool) -> Result<(), Error> {
    let mut missing = FEATURES.iter().filter(|record| !built(record));
    match missing.find_map(|record| Some((record.asked_by(scene)?, record.name))) {
        Some((field, name)) => Err(Error::not_built(field, name)),
        None => Ok(()),
    }
}

/// Refuses two features that do not go together: the first two that the scene has are named.
pub(crate) fn check_pairs(scene: &Scene) -> Result<(), Error> {
    for record in &FEATURES {
        let Some(field) = record.asked_by(scene) else { continue };
        let beside = |&other: &Feature| FEATURES[other as usize].asked_by(scene);
        if let Some(with) = record.not_with.iter().find_map(beside) {
            return Err(Error::beside(field, with));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_stand_in_the_order_of_their_names_and_each_pair_once() {
        for (k, record) in FEATURES.iter().enumerate() {
            assert_eq!(record.feature as usize, k);
            for &other in record.not_with {
                assert!(other != record.feature && !FEATURES[other as usize].not_with.contains(&record.feature));
            }
            assert!(Features::NONE.with(record.feature).has(record.feature) == record.built);
        }
    }

    #[test]
    fn a_build_without_a_feature_refuses_it_by_field_and_feature() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.yarn.stochastic, scene.contact.friction) = (false, 0.1);
        assert_eq!(check_in(&scene, |_| true), Ok(()));
        let refusal = check_in(&scene, |record| record.feature != Friction).unwrap_err();
        assert_eq!(refusal, Error::not_built("contact.friction", "friction"));
        assert_eq!(
            refusal.text().as_str(),
            "contact.friction: needs the feature `friction`, which this build lacks: fabric-kernel = { ..., features = [\"friction\"] } in Cargo.toml"
        );
    }
}
