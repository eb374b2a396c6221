//! Graded networks: far from the hit one bar stands for 2, 4, 8 ... yarns and as many crossings.
//!
//! Method: rows and columns keep only some of the crossings of the fabric, so the network stays a grid, the
//! product of two lines of nodes at unlike distances. A bar from one kept crossing to the next has the
//! natural length of a segments in series and the section of w yarns in parallel, where w is the node's
//! width: half the sum of the bars on both sides. A node has the mass of w_x w_y nodes of the fabric. In
//! units of a node of the fabric the change of its velocity is (right - left)/w_x + (up - down)/w_y with the
//! forces of one yarn: the width of a row does not enter those along it. Beyond the last node half a segment
//! is added, so that all widths of a line together are its crossings: no mass is lost. A bar's draws follow
//! from those of its segments: the compliance is the mean along a yarn, the modulus that over the yarns;
//! damage rates are means; a yarn is as strong as its weakest segment, a bar as its yarns on average. The
//! damage rate is multiplied by a, because one segment of the a fails: the dissipated energy is then that of
//! one segment of each yarn.
//! Limits: waves shorter than some bars are reflected where the bars grow. A body that strikes coarse parts
//! of the sheet may slip through between their nodes.
//! Reference: docs/model.md, "Graded networks".

use crate::body::pose::{self, Pose};
use crate::body::shape::Solid;
use crate::ground::error::{Code, Error, finite};
use crate::ground::math;
use crate::ground::planes::{Axis, CHUNK, Chunk};
use crate::scene::features::Feature;
use crate::scene::parts::{AttachmentKind, Grading, Scene, Symmetry};
use crate::sheet::columns::{
    self, CHORD, CHORD_Z, COLUMN_PLANES, INVERSE_SQUARE, INVERSE_WIDTH, NORMAL_X, NORMAL_Z, PLACE, PLACE_Z, SEGMENTS,
    WIDTH,
};
use crate::sheet::places::Places;
use crate::sheet::weave;
use crate::yarn::law::Rest;

/// Least and greatest error that [`Scene::set_grading`] can be asked for.
pub const GRADING_ERRORS: [f64; 2] = [0.005, 0.1];

/// Yarn of a bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Segments of the fabric in series.
    pub segments: f64,
    /// Young's modulus, Pa.
    pub modulus: f64,
    /// Damage rate, dimensionless.
    pub damage_rate: f64,
    /// Critical stretch.
    pub critical_stretch: f64,
}

/// Fills the line of constants of a line of nodes at z, spacings, from the first on. `rest`: a segment of the
/// fabric along it.
/// After the last node the constants repeat and are of no consequence.
pub(crate) fn fill(line: &mut [Chunk<COLUMN_PLANES>], first: usize, places: &Places, rest: &Rest, z: f64) {
    let nodes = places.nodes() as usize;
    for k in first..line.len() * CHUNK {
        let k_in_line = (k - first).min(nodes.saturating_sub(1));
        let [before, after] = places.around(k_in_line).map(f64::from);
        let (width, bar) = (0.5 * (before + after), rest.in_series(after));
        let place = places.offset(k_in_line) * rest.spacing;
        let constants = [
            (CHORD, bar.spacing),
            (CHORD_Z, 0.0),
            (INVERSE_SQUARE, bar.inverse_square),
            (INVERSE_WIDTH, 1.0 / width),
            (PLACE, place),
            (PLACE_Z, z),
            (NORMAL_X, 0.0),
            (NORMAL_Z, 1.0),
            (WIDTH, width),
            (SEGMENTS, after),
        ];
        columns::set(line, k, constants);
    }
}

impl Scene {
    /// Chooses a graded network for a hit as the projectile starts: fine about the place where it meets the
    /// sheet's plane, and so far beyond it that absorbed energy and residual velocity are expected to be
    /// wrong by at most `error`, a part of them in [0.005, 0.1]: 80 spacings below 1 %, 50 below 3 %, else
    /// 30, then two bars each of 2 and 4 yarns, and bars of 8. Viscous yarn damps what coarse bars send back:
    /// twice, once or half the body's own size, at least 24, 12 or 8 spacings, then four bars each. No
    /// grading is chosen where this leaves no bar, nor for four corners, whose discs need every node. Sets
    /// `sheet.grading`; the other numbers stay, and the choice does not follow them later.
    ///
    /// The rule is a summary of measurements and no bound: docs/accuracy.md, "Graded networks", says what was
    /// found. A projectile that starts by moving away from the sheet, or along it, is taken to hit below
    /// itself.
    ///
    /// # Errors
    /// An error out of range, and whatever [`Scene::check`] refuses, with grading too; nothing is changed
    /// then.
    pub fn set_grading(&mut self, error: f64) -> Result<(), Error> {
        let [least, greatest] = GRADING_ERRORS;
        let limit = if error < least { least } else { greatest };
        finite("error", error)?;
        if error < least || error > greatest {
            return Err(Error::new(Code::OutOfRange, "error", error, limit));
        }
        self.check()?;
        let (centre, extents) = self.expected_hit();
        // Spacings and sizes of the body beyond it; along the yarn and across it waves are damped, or not.
        let [linear, _, bending] = self.viscosity();
        let damped = Feature::Viscosity.is_built() && linear > 0.0 && bending > 0.0;
        let (spacings, sizes) = match (damped, error < 0.01, error < 0.03) {
            (true, true, _) => (24.0, 2.0),
            (true, _, true) => (12.0, 1.0),
            (true, ..) => (8.0, 0.5),
            (false, true, _) => (80.0, 0.0),
            (false, _, true) => (50.0, 0.0),
            (false, ..) => (30.0, 0.0),
        };
        // Without the cloth.
        let size = 2.0 * math::max(extents[0], extents[1]) - self.thickness();
        let reach = |k: usize, axis: Axis| extents[k] + math::max(sizes * size, spacings * self.spacing(axis));
        let half_width = [reach(0, Axis::Horizontal), reach(1, Axis::Vertical)];
        let before = self.sheet.grading;
        self.sheet.grading = Grading { largest: 8, run: if damped { 4 } else { 2 }, centre, half_width };
        if self.attachment.kind == AttachmentKind::FourCorners
            || self.network() == [self.sheet.nodes_x, self.sheet.nodes_y]
        {
            self.sheet.grading = Grading { largest: 0, ..before };
        }
        // Some options go with a whole fabric only.
        self.check().inspect_err(|_| self.sheet.grading = before)
    }

    /// Where the projectile's centre meets the sheet's plane, and the half extents of its box there, m,
    /// sheet's frame.
    fn expected_hit(&self) -> ([f64; 2], [f64; 3]) {
        let (pose, body) = (Pose::of_sheet(&self.sheet), &self.projectile);
        let ([x, y, z], [vx, vy, vz]) = (pose.point_in(body.position), pose.vector_in(body.velocity));
        let time = if z * vz < 0.0 { -z / vz } else { 0.0 };
        let extents = Solid::of_scene(self).half_extents(&pose::normalised(pose.orientation_in(body.orientation)));
        let Symmetry { mirror_x, mirror_y } = self.symmetry;
        let across = |mirrored: bool, x: f64| if mirrored || !x.is_finite() { 0.0 } else { x };
        ([across(mirror_x, x + time * vx), across(mirror_y, y + time * vy)], extents)
    }

    /// Yarn of the bar from node (i, j) of the network. `places`: along x and y; `before`: segments of the
    /// plies before it.
    ///
    /// # Errors
    /// Errors of [`Scene::draw_segment`].
    pub(crate) fn draw_bar(
        &self,
        [x, y]: &[Places; 2],
        before: u64,
        axis: Axis,
        [i, j]: [usize; 2],
    ) -> Result<Bar, Error> {
        let (along, across, from, line) = match axis {
            Axis::Horizontal => (x, y, i, j),
            Axis::Vertical => (y, x, j, i),
        };
        let first = along.crossing(from as u32);
        let [_, segments] = along.around(from);
        let in_ply = |yarn: u32, segment: u32| match axis {
            Axis::Horizontal => weave::horizontal_number(self, segment as usize, yarn as usize),
            Axis::Vertical => weave::vertical_number(self, yarn as usize, segment as usize),
        };
        let number = |yarn: u32, segment: u32| before + in_ply(yarn, segment);
        let count = f64::from(segments);
        let (mut width, mut modulus, mut damage_rate, mut critical_stretch) = (0.0, 0.0, 0.0, 0.0);
        for (yarn, share) in across.yarns(line) {
            let mut weakest = self.draw_critical_stretch(number(yarn, first));
            let segment = self.draw_segment(number(yarn, first))?;
            // Relative to the first, so that a bar of one segment is that segment to the bit.
            let (mut compliance, mut rates) = (1.0, segment.damage_rate);
            for k in 1..segments {
                let next = self.draw_segment(number(yarn, first + k))?;
                compliance += segment.modulus / next.modulus;
                rates += next.damage_rate;
                weakest = math::min(self.draw_critical_stretch(number(yarn, first + k)), weakest);
            }
            width += share;
            modulus += share * (segment.modulus * (count / compliance));
            // The mean rate times the segments.
            damage_rate += share * rates;
            critical_stretch += share * weakest;
        }
        let (damage_rate, critical_stretch) = (damage_rate / width, critical_stretch / width);
        Ok(Bar { segments: count, modulus: modulus / width, damage_rate, critical_stretch })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::planes;
    use crate::scene::parts::StrengthDraw;
    use std::vec;
    use std::vec::Vec;

    fn graded(nodes: u32, centre: f64, half: f64, largest: u32, run: u32) -> Scene {
        let mut scene = Scene::sheet_3in_sphere();
        let h = scene.sheet.spacing;
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
        scene.sheet.grading = Grading { largest, run, centre: [centre * h; 2], half_width: [half * h; 2] };
        scene
    }

    /// Nodes from edge to edge, every crossing within the fine part, no bar longer than one and a half of the
    /// largest, widths that sum up to the crossings, and every yarn in one node or in halves in two.
    #[test]
    fn a_line_holds_every_yarn_once() {
        for nodes in [2, 3, 7, 40, 105, 350] {
            for (centre, half) in [(0.0, 0.0), (0.0, 10.3), (-7.2, 3.0), (30.0, 0.0), (0.0, 1e9), (-1e9, 5.0)] {
                for (largest, run) in [(2, 1), (4, 3), (64, 1), (8, 1000)] {
                    let places = Places::of(&graded(nodes, centre, half, largest, run), Axis::Horizontal);
                    let crossings: Vec<u32> = (0..places.nodes()).map(|k| places.crossing(k)).collect();
                    assert_eq!((crossings[0], *crossings.last().unwrap()), (0, nodes - 1), "{places:?}");
                    let bars = crossings.windows(2).map(|ends| ends[1] - ends[0]);
                    assert!(bars.clone().all(|bar| bar >= 1 && 2 * bar < 3 * largest), "{crossings:?}");
                    let [first, last] = places.fine;
                    assert!((first..=last).all(|crossing| crossings.contains(&crossing)));
                    if centre == 0.0 {
                        let mirrored: Vec<u32> = crossings.iter().rev().map(|crossing| nodes - 1 - crossing).collect();
                        assert_eq!(crossings, mirrored);
                    }
                    let mut shares = vec![0.0; nodes as usize];
                    let (scene, mut line) = (Scene::sheet_3in_sphere(), vec![[[0.0; CHUNK]; COLUMN_PLANES]; 50]);
                    fill(&mut line, 0, &places, &Rest::of(1.0, scene.rest_stretch(Axis::Horizontal)), 0.0);
                    for k in 0..crossings.len() {
                        let yarns: Vec<_> = places.yarns(k).collect();
                        let width: f64 = yarns.iter().map(|(_, share)| share).sum();
                        assert_eq!(planes::get(&line, WIDTH, k), Some(width));
                        yarns.into_iter().for_each(|(yarn, share)| shares[yarn as usize] += share);
                    }
                    assert!(shares.iter().all(|share| *share == 1.0), "{crossings:?} {shares:?}");
                }
            }
        }
    }

    /// A bar of a segments and w yarns from its segments' draws, one by one.
    #[test]
    fn a_bar_has_the_draws_of_its_segments() {
        let mut scene = graded(61, 3.0, 4.0, 8, 2);
        scene.yarn.strength_draw = StrengthDraw::Weibull;
        let places = Places::both(&scene);
        let (i, j) = (1, 3);
        let [x, y] = &places;
        let (from, to) = (x.crossing(i), x.crossing(i + 1));
        let (mut modulus, mut rate, mut critical, mut width) = (0.0, 0.0, 0.0, 0.0);
        for (yarn, share) in y.yarns(j) {
            let numbers = || (from..to).map(|k| weave::horizontal_number(&scene, k as usize, yarn as usize));
            let segments: Vec<_> = numbers().map(|k| scene.draw_segment(k).unwrap()).collect();
            modulus += share * segments.len() as f64 / segments.iter().map(|s| 1.0 / s.modulus).sum::<f64>();
            rate += share * segments.iter().map(|s| s.damage_rate).sum::<f64>();
            critical += share * numbers().map(|k| scene.draw_critical_stretch(k)).fold(9.0, f64::min);
            width += share;
        }
        assert!(to - from > 2 && width > 2.0);
        let bar = scene.draw_bar(&places, 0, Axis::Horizontal, [i as usize, j]).unwrap();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-13, "{a} {b}");
        close(bar.modulus, modulus / width);
        close(bar.damage_rate, rate / width);
        close(bar.critical_stretch, critical / width);
        assert_eq!(bar.segments, f64::from(to - from));
        // Single segments to the bit.
        let centre = (0..x.nodes()).find(|&k| x.crossing(k) == 33).unwrap() as usize;
        let (bar, number) = (
            scene.draw_bar(&places, 0, Axis::Vertical, [centre, centre]).unwrap(),
            weave::vertical_number(&scene, 33, 33),
        );
        let segment = scene.draw_segment(number).unwrap();
        assert_eq!((bar.modulus, bar.damage_rate), (segment.modulus, segment.damage_rate));
        assert_eq!(bar.critical_stretch, scene.draw_critical_stretch(number));
    }

    #[test]
    fn the_automatic_choice_lies_about_the_hit() {
        let mut scene = Scene::sheet_10in_cylinder();
        scene.projectile.position = [-0.03, 0.01, -0.02];
        scene.projectile.velocity = [100.0, 0.0, 100.0];
        for error in [0.0, 0.2, f64::NAN] {
            assert_eq!(scene.set_grading(error).unwrap_err().field, "error");
        }
        let reach = |scene: &Scene, error: f64| {
            let mut scene = *scene;
            scene.set_grading(error).unwrap();
            scene.check().unwrap();
            scene.sheet.grading
        };
        let chosen = reach(&scene, 0.01);
        assert!((chosen.centre[0] + 0.01).abs() < 1e-12 && (chosen.centre[1] - 0.01).abs() < 1e-12);
        assert!((chosen.half_width[0] - (6.35e-3 + 50.0 * scene.sheet.spacing)).abs() < 1e-12);
        assert!(reach(&scene, 0.05).half_width[0] < chosen.half_width[0]);
        // Viscous yarn: sizes of the body, or so many spacings.
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_bending) = (0.06, 0.06);
        for (error, sizes, spacings) in [(0.005, 2.0, 24.0), (0.01, 1.0, 12.0), (0.1, 0.5, 8.0)] {
            let beyond = f64::max(sizes * 12.7e-3, spacings * scene.sheet.spacing);
            assert!((reach(&scene, error).half_width[0] - (6.35e-3 + beyond)).abs() < 1e-12);
        }
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_bending) = (0.0, 0.0);
        // Nothing to gain, and nothing to be graded.
        assert!(reach(&Scene::sheet_3in_sphere(), 0.01).largest == 0);
        scene.attachment.kind = AttachmentKind::FourCorners;
        assert!(reach(&scene, 0.05).largest == 0);
    }
}
