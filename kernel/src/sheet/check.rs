//! Limits of the numbers of a scene together.
//!
//! Each number by itself is checked by its row in `fields/table.rs`, before anything here.

use crate::body::shape;
use crate::ground::error::{Code, Error, finite, positive};
use crate::ground::math;
use crate::ground::planes::Axis;
use crate::scene::features::{self, Feature};
use crate::scene::fields;
use crate::scene::parts::{
    AttachmentKind, DAMAGE_RATE_MIN, Draw, MAX_GAP, STRAIN_RATES, Scene, Stack, StepCheck, StepLimits, Symmetry,
    TimeStep, WEIBULL_SHAPES,
};
use crate::sheet::weave;

/// Largest ratio of the two node spacings: contact looks for nodes within one spacing.
const LARGEST_SPACING_RATIO: f64 = 10.0;
/// Least width of the sheet over its thickness: a network has no stiffness against bending.
const THINNEST: f64 = 10.0;

impl Scene {
    /// The step in use and its limits, with the checks of [`Scene::check`]. Draws every segment of a
    /// stochastic sheet to find the stiffest, and of drawn strength the strongest.
    pub fn step_limits(&self) -> Result<StepLimits, Error> {
        self.check()?;
        self.limits_of_all()
    }

    /// Checks every number by itself, in the order of the table, and then what goes with what; the first bad
    /// one is named. The time step against dt_crit is checked by [`Scene::step_limits`].
    pub fn check(&self) -> Result<(), Error> {
        features::check_built(self)?;
        fields::check(self)?;
        features::check_pairs(self)?;
        self.check_thickness()?;
        self.check_directions()?;
        self.check_yarn()?;
        self.check_rate()?;
        self.check_rest()?;
        self.check_curve()?;
        self.check_casing()?;
        self.check_grading()?;
        self.check_projectile()?;
        self.check_stack()?;
        self.check_attachment()?;
        self.check_clamps()?;
        if Feature::Plies.is_built() && self.back.plies > 0 {
            self.check_back()?;
        }
        self.check_step()
    }

    /// Checks of the front fabric, for the back one, too.
    fn check_back(&self) -> Result<(), Error> {
        let shape = self.back.weibull_shape;
        if shape != 0.0 && shape < WEIBULL_SHAPES[0] {
            return Err(Error::new(Code::OutOfRange, "back.weibull_shape", shape, WEIBULL_SHAPES[0]));
        }
        let back = self.all_of_back();
        back.check_yarn().and_then(|()| back.check_rest()).map_err(of_back)
    }

    fn check_step(&self) -> Result<(), Error> {
        let TimeStep { fraction, seconds } = self.time_step;
        let largest = self.step_max_fraction()?;
        if seconds == 0.0 && self.step_check == StepCheck::Refuse && fraction > largest {
            return Err(Error::new(Code::OutOfRange, "time_step.fraction", fraction, largest));
        }
        Ok(())
    }

    /// A network, with all the plies that are bonded into it, is thin.
    fn check_thickness(&self) -> Result<(), Error> {
        let ([x, y], thickness) = (self.half_size(), self.sheet.thickness);
        let limit = 2.0 * math::min(x, y) / THINNEST / f64::from(self.sheet.plies);
        if thickness > limit {
            return Err(Error::new(Code::OutOfRange, "sheet.thickness", thickness, limit).from("sheet.plies"));
        }
        Ok(())
    }

    /// Numbers of one direction that do not go together: crimp and strain along it, plies that are turned and
    /// spacings that differ.
    fn check_directions(&self) -> Result<(), Error> {
        let ([strain_x, strain_y], [crimp_x, crimp_y]) = (self.sheet.pre_strain, self.sheet.crimp);
        let [back_x, back_y] = if self.back.plies > 0 { self.back.crimp } else { [0.0; 2] };
        for (crimp, of_back, strain) in [(crimp_x, back_x, strain_x), (crimp_y, back_y, strain_y)] {
            let crimps = [("sheet.crimp", crimp != 0.0), ("back.crimp", of_back != 0.0)];
            if let Some((field, _)) = crimps.into_iter().find(|(_, has)| *has && strain != 0.0) {
                return Err(Error::beside(field, "sheet.pre_strain"));
            }
        }
        // A ply is turned within the same grid.
        let [x, y] = self.spacings();
        let turned = self.stack.plies > 1 && self.stack.turned;
        if turned && x != y { Err(Error::beside("stack.turned", "sheet.spacing_y")) } else { Ok(()) }
    }

    fn check_yarn(&self) -> Result<(), Error> {
        let yarn = &self.yarn;
        let first = yarn.damage_a * (1.0 - yarn.damage_b);
        // One rounding above 1 is what A = 1/(1 - B) gives.
        if !(first > 0.0 && first <= 1.0 + 4.0 * f64::EPSILON) {
            let limit = 1.0 / (1.0 - yarn.damage_b);
            return Err(Error::new(Code::OutOfRange, "yarn.damage_a", yarn.damage_a, limit).from("yarn.damage_b"));
        }
        for (axis, slope, intercept) in [
            (Axis::Horizontal, "yarn.damage_slope", "yarn.damage_intercept"),
            (Axis::Vertical, "weft.damage_slope", "weft.damage_intercept"),
        ] {
            let rate = self.mean_segment(axis).damage_rate;
            finite(slope, rate)?;
            if rate < DAMAGE_RATE_MIN {
                return Err(Error::new(Code::DamageRateTooSmall, intercept, rate, DAMAGE_RATE_MIN));
            }
        }
        let critical = self.weft.critical_stretch;
        if critical != 0.0 && critical <= 1.0 {
            return Err(Error::new(Code::OutOfRange, "weft.critical_stretch", critical, 1.0));
        }
        Ok(())
    }

    /// The rates of yarn that depends on them.
    fn check_rate(&self) -> Result<(), Error> {
        if !Feature::Rate.is_in(self) {
            return Ok(());
        }
        let (yarn, [slowest, _]) = (&self.yarn, STRAIN_RATES);
        if yarn.rate_reference < slowest {
            return Err(Error::new(Code::OutOfRange, "yarn.rate_reference", yarn.rate_reference, slowest));
        }
        if yarn.rate_limit < yarn.rate_reference {
            let refused = Error::new(Code::OutOfRange, "yarn.rate_limit", yarn.rate_limit, yarn.rate_reference);
            return Err(refused.from("yarn.rate_reference"));
        }
        Ok(())
    }

    /// Spacings and pre-tension, and whether a sheet with pre-tension is in equilibrium.
    fn check_rest(&self) -> Result<(), Error> {
        let [x, y] = self.spacings();
        if y > LARGEST_SPACING_RATIO * x || x > LARGEST_SPACING_RATIO * y {
            let limit = if y > x { LARGEST_SPACING_RATIO * x } else { x / LARGEST_SPACING_RATIO };
            return Err(Error::new(Code::OutOfRange, "sheet.spacing_y", y, limit).from("sheet.spacing"));
        }
        let kind = self.attachment.kind;
        let all_sides = kind == AttachmentKind::FourSides;
        let [strain_x, strain_y] = self.sheet.pre_strain;
        let along_x =
            (Axis::Horizontal, strain_x, all_sides || kind == AttachmentKind::TwoSides || self.has_snug_casing());
        for (axis, strain, held) in [along_x, (Axis::Vertical, strain_y, all_sides)] {
            if strain == 0.0 {
                continue;
            }
            let limit = self.damage_law(axis).critical_stretch - 1.0;
            if strain >= limit {
                return Err(
                    Error::new(Code::OutOfRange, "sheet.pre_strain", strain, limit).from("yarn.critical_stretch")
                );
            }
            if !held {
                return Err(Error::new(Code::NotInEquilibrium, "sheet.pre_strain", strain, 0.0).from("attachment.kind"));
            }
            // Segments of one line at one stretch pull alike only if their moduli are alike.
            if self.yarn.stochastic && self.yarn.draw == Draw::Segment && self.modulus_sd(axis) > 0.0 {
                return Err(Error::plain(Code::NotInEquilibrium, "yarn.draw").from("sheet.pre_strain"));
            }
        }
        Ok(())
    }

    /// The sizes of bars, and mirror planes through the middle of the fine part.
    fn check_grading(&self) -> Result<(), Error> {
        let grading = &self.sheet.grading;
        if !grading.largest.is_power_of_two() && grading.largest != 0 {
            let size = grading.largest.next_power_of_two();
            return Err(Error::new(Code::OutOfRange, "sheet.grading.largest", grading.largest.into(), size.into()));
        }
        if !Feature::Grading.is_in(self) {
            return Ok(());
        }
        let Symmetry { mirror_x, mirror_y } = self.symmetry;
        let [x, y] = grading.centre;
        for (mirrored, centre, plane) in [(mirror_x, x, "symmetry.mirror_x"), (mirror_y, y, "symmetry.mirror_y")] {
            if mirrored && centre != 0.0 {
                return Err(Error::new(Code::NotSymmetric, "sheet.grading.centre", centre, 0.0).from(plane));
            }
        }
        Ok(())
    }

    fn check_projectile(&self) -> Result<(), Error> {
        let body = &self.projectile;
        shape::check(body, self.largest_spacing())?;
        if self.is_free() || body.mass != 0.0 {
            positive("projectile.mass", body.mass)?;
            let least = self.largest_mass();
            if body.mass < least {
                return Err(
                    Error::new(Code::ProjectileTooLight, "projectile.mass", body.mass, least).from("sheet.node_mass")
                );
            }
        }
        Ok(())
    }

    fn check_stack(&self) -> Result<(), Error> {
        let (Stack { plies, gap, turned }, back) = (self.stack, self.back.plies);
        if back >= plies {
            let refused = Error::new(Code::OutOfRange, "back.plies", f64::from(back), f64::from(plies) - 1.0);
            return Err(refused.from("stack.plies"));
        }
        if plies == 1 {
            return Ok(());
        }
        let limit = MAX_GAP * self.sheet.spacing;
        if gap > limit {
            return Err(Error::new(Code::OutOfRange, "stack.gap", gap, limit).from("sheet.spacing"));
        }
        // Half of the plies have their pre-tension along y.
        if turned && self.sheet.pre_strain != [0.0; 2] && self.attachment.kind != AttachmentKind::FourSides {
            return Err(Error::plain(Code::NotInEquilibrium, "stack.turned").from("attachment.kind"));
        }
        Ok(())
    }

    fn check_attachment(&self) -> Result<(), Error> {
        if self.attachment.kind != AttachmentKind::FourCorners {
            return Ok(());
        }
        let radius = self.attachment.disc_radius;
        let centre = weave::disc_centre(self);
        if centre[0] <= radius || centre[1] <= radius {
            let limit = math::min(centre[0], centre[1]);
            return Err(Error::new(Code::DiscsOverlap, "attachment.disc_radius", radius, limit));
        }
        // The discs are clear of the projectile's bounding circle about the sheet's centre line where it
        // starts.
        let pose = crate::body::pose::Pose::of_sheet(&self.sheet);
        let offset = pose.point_in(self.projectile.position);
        let orientation = crate::body::pose::normalised(pose.orientation_in(self.projectile.orientation));
        let reach = shape::reach_in_plane(&self.projectile, &orientation) + 0.5 * self.thickness();
        for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let gap = math::length([offset[0] - sx * centre[0], offset[1] - sy * centre[1], 0.0]) - reach;
            if gap <= radius {
                return Err(Error::new(Code::DiscTouchesProjectile, "attachment.disc_radius", radius, gap));
            }
        }
        let nearest2 = weave::disc_to_nearest_node2(self);
        if nearest2 > radius * radius {
            return Err(Error::new(Code::HoldsNothing, "attachment.disc_radius", radius, math::sqrt(nearest2)));
        }
        Ok(())
    }
}

/// The refusal of the back fabric, found where it stood in the place of the front one.
fn of_back(error: Error) -> Error {
    let field = match error.field {
        "yarn.damage_slope" => "back.damage_slope",
        "yarn.damage_intercept" => "back.damage_intercept",
        field => field,
    };
    Error { field, ..error }
}
