//! Curved sheets: arcs and rings about an axis along y.
//!
//! Method: displacements are counted from rest as in a flat sheet, and only the places of rest lie on a
//! circle. Column i rests at the angle a_i = (i - (n - 1)/2) s at (R sin a_i, y, R cos a_i), with R to the
//! nodes and the step s of which a chord is the node spacing: 2 R sin(s/2) = h, of a ring of n nodes s = 2
//! pi/n. The segment from column i to the next has the rest vector c_i = (cos(a_i + s/2), 0, -sin(a_i + s/2))
//! in spacings, which takes the place of (1, 0, 0) in (M2) and (M4). In a ring the last segment of a row
//! pulls its first node, too: its force is found before the row is swept, from places and damage at the start
//! of the step, and its damage is committed where the sweep comes to it. After the last node stands an image
//! of the first one. Separate plies lie on circles of their own: ply k has the radius R_k = R + k gap, and
//! its rest vectors and natural lengths are R_k/R times those of the first. The plies push on each other
//! along the normal (sin a_i, 0, cos a_i) that their column has at rest.
//! Limits: the fabric does not bend; between two nodes it is straight. A turn about the axis turns no normal
//! of a column.
//! Reference: docs/model.md, "Curved sheets and rings"; of the preset NASA, Research and Technology 2001,
//! NTRS 20050207394, and data/fabrics/zylon_as_500_35.toml.

use crate::body::pose::Vector;
use crate::ground::error::{Code, Error};
use crate::ground::lanes::Lane;
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, Chunk};
use crate::scene::features::Feature;
use crate::scene::parts::{Attachment, AttachmentKind, Casing, Projectile, Scene, Shape, Sheet, Yarn};
use crate::sheet::columns::{
    self, CHORD, CHORD_Z, COLUMN_PLANES, INVERSE_SQUARE, INVERSE_WIDTH, NORMAL_X, NORMAL_Z, PLACE, PLACE_Z, SEGMENTS,
    WIDTH,
};
use crate::sheet::textile::centinewton_per_dtex;
use crate::yarn::law::Rest;
use core::f64::consts::PI;

/// Largest radius, spacings: places of rest are then rounded by 1e-10 of one.
const LARGEST_RADIUS: f64 = 1e6;

/// Largest deviation of the radius of a ring from that which its chords close, a part of it.
pub(crate) const CLOSES: f64 = 1e-6;

/// The circle on which the nodes of a row rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hoop {
    /// Radius to the nodes, spacings.
    pub radius: f64,
    /// Angle from one column to the next, rad.
    step: f64,
    nodes: u32,
}

impl Hoop {
    /// That of a scene; None of a flat sheet.
    pub fn of(scene: &Scene) -> Option<Hoop> {
        if !Feature::Curved.is_in(scene) {
            return None;
        }
        let nodes = scene.sheet.nodes_x;
        if Feature::Closed.is_in(scene) {
            return Some(Hoop { radius: closed_radius(nodes), step: 2.0 * PI / f64::from(nodes), nodes });
        }
        let radius = scene.sheet.radius / scene.sheet.spacing;
        let step = 2.0 * math::atan2(0.5, math::sqrt((radius - 0.5) * (radius + 0.5)));
        Some(Hoop { radius, step, nodes })
    }

    /// Rest place of a column along x and z, spacings.
    pub fn place(&self, i: usize) -> [f64; 2] {
        let angle = self.angle(f64::from(i as u32));
        math::sine_and_cosine(angle).map(|part| self.radius * part)
    }

    /// (M23) Rest vector along x and z of the segment from a column to the next, spacings.
    pub fn chord(&self, i: usize) -> [f64; 2] {
        let [sine, cosine] = math::sine_and_cosine(self.angle(f64::from(i as u32) + 0.5));
        [cosine, -sine]
    }

    /// Angle of a place along the row, in columns; exactly antisymmetric about the middle.
    fn angle(&self, column: f64) -> f64 {
        (column - 0.5 * (f64::from(self.nodes) - 1.0)) * self.step
    }

    /// Fills the line of constants of a ply with `ratio` times the radius of the first one, whose segments
    /// along the row lie at rest so. After its last node there is a place that no case and no projectile
    /// meets.
    pub(crate) fn fill(&self, line: &mut [Chunk<COLUMN_PLANES>], rest: &Rest, ratio: f64) {
        let radius = ratio * self.radius;
        let nowhere = [4.0 * radius, 0.0, 0.0, 0.0, 0.0, 0.0];
        for i in 0..line.len() * CHUNK {
            let (normal, chord) = (math::sine_and_cosine(self.angle(f64::from(i as u32))), self.chord(i));
            let ([x, z], [along, across]) = (normal.map(|part| radius * part), chord.map(|part| ratio * part));
            let is_node = i < self.nodes as usize;
            let [x, z, along, across, sine, cosine] =
                if is_node { [x, z, along, across, normal[0], normal[1]] } else { nowhere };
            let constants = [
                (PLACE, x),
                (PLACE_Z, z),
                (CHORD, along),
                (CHORD_Z, across),
                (NORMAL_X, sine),
                (NORMAL_Z, cosine),
                (INVERSE_SQUARE, rest.inverse_square),
                (INVERSE_WIDTH, 1.0),
                (WIDTH, 1.0),
                (SEGMENTS, 1.0),
            ];
            columns::set(line, i, constants);
        }
    }
}

/// Radius to the nodes of a ring of so many chords of length 1.
fn closed_radius(nodes: u32) -> f64 {
    let [sine, _] = math::sine_and_cosine(PI / f64::from(nodes));
    0.5 / sine
}

/// A vector in the axes of a column with this normal: along the hoop, along the axis, and outwards.
#[inline(always)]
pub fn column_axes<L: Lane>([x, y, z]: [L; 3], [sine, cosine]: [L; 2]) -> [L; 3] {
    [cosine.mul(x).sub(sine.mul(z)), y, sine.mul(x).add(cosine.mul(z))]
}

/// Vector from the axis of a curved sheet to a place.
pub fn from_axis(place: &Vector) -> Vector {
    Vector::new(place.x, 0.0, place.z)
}

/// The box about plies at rest along x and z, m: its least and its greatest corner.
pub(crate) fn box_at_rest(hoop: &[Chunk<COLUMN_PLANES>], [chunks, nodes]: [usize; 2], spacing: f64) -> [[f64; 2]; 2] {
    let mut ends = [[f64::MAX; 2], [f64::MIN; 2]];
    for (row, i) in hoop.chunks_exact(chunks.max(1)).flat_map(|row| (0..nodes).map(move |i| (row, i))) {
        for (k, plane) in [PLACE, PLACE_Z].into_iter().enumerate() {
            let place = planes::get(row, plane, i).unwrap_or(0.0) * spacing;
            ends[0][k] = math::min(place, ends[0][k]);
            ends[1][k] = math::max(place, ends[1][k]);
        }
    }
    ends
}

impl Scene {
    /// The ring of NASA's tests, 40 in across within and 10 in long, as far as it is known: five bonded plies
    /// of Zylon AS, 35 x 35 per inch, in place of braided ones, 1,155 x 88 nodes of four yarns a bar, 21 in
    /// from the axis, on a case with a window. The sector of the preset `turbine_disc_sector` has left its
    /// disc at 4,000 rad/s on the engine's axis and is about to meet the middle of the window.
    pub fn ring_40in() -> Scene {
        let small = Scene::sheet_3in_sphere();
        let (yarns, denier, per_metre) = (4.0, 1e-3 / 9000.0, 35.0 / 0.0254);
        let mut scene = Scene {
            sheet: Sheet {
                nodes_x: 1155,
                nodes_y: 88,
                spacing: yarns / per_metre,
                node_mass: yarns * yarns * (2.0 * 500.0 * denier / per_metre),
                yarn_area: yarns * (500.0 * denier / 1540.0),
                plies: 5,
                closed: true,
                ..small.sheet
            },
            attachment: Attachment { kind: AttachmentKind::Free, ..small.attachment },
            yarn: Yarn {
                modulus_mean: centinewton_per_dtex(1150.0, 1540.0),
                modulus_sd: 0.0,
                damage_slope: 0.0,
                damage_intercept: 2302.6,
                damage_sd: 0.0,
                critical_stretch: 1.035,
                stochastic: false,
                viscosity_linear: 0.06,
                viscosity_quadratic: 1.5,
                ..small.yarn
            },
            ..small
        };
        let radius = scene.closed_radius();
        scene.sheet.radius = radius;
        // Twice as wide as the fragment: how much of a case it tears away is not known.
        scene.casing = Casing { radius, window_angle: [0.0, 0.15], window_place: [0.0, 0.04] };
        // How far the sector's centre of mass was from the axis, and is from the rim.
        let (arm, rim, rate) = (0.022984880036043084, 0.017015119963956916, 4000.0);
        scene.projectile = Projectile {
            shape: Shape::DiscSector,
            mass: 0.118,
            position: [-arm, 0.0, radius - rim - 2e-3],
            velocity: [0.0, 0.0, rate * arm],
            orientation: [0.5, -0.5, -0.5, -0.5],
            angular_velocity: [0.0, rate, 0.0],
            ..small.projectile
        };
        scene
    }

    /// The radius that a ring of the sheet's nodes and spacing has, m: h/(2 sin(pi/n)).
    pub fn closed_radius(&self) -> f64 {
        self.sheet.spacing * closed_radius(self.sheet.nodes_x)
    }

    /// Radius, and how the ends are held, of a curved sheet.
    pub(crate) fn check_curve(&self) -> Result<(), Error> {
        let (radius, kind) = (self.sheet.radius, self.attachment.kind);
        if !Feature::Curved.is_in(self) {
            return if Feature::Closed.is_in(self) {
                Err(Error::new(Code::NotPositive, "sheet.radius", radius, 0.0).from("sheet.closed"))
            } else {
                Ok(())
            };
        }
        let closes = self.closed_radius();
        if self.sheet.nodes_x < 3 {
            return Err(
                Error::new(Code::OutOfRange, "sheet.nodes_x", self.sheet.nodes_x.into(), 3.0).from("sheet.radius")
            );
        }
        let limit = LARGEST_RADIUS * self.sheet.spacing;
        if radius > limit {
            return Err(Error::new(Code::OutOfRange, "sheet.radius", radius, limit).from("sheet.spacing"));
        }
        let off = radius - closes;
        if off < -CLOSES * closes || Feature::Closed.is_in(self) && off > CLOSES * closes {
            return Err(Error::new(Code::OutOfRange, "sheet.radius", radius, closes).from("sheet.nodes_x"));
        }
        if kind == AttachmentKind::FourCorners || Feature::Closed.is_in(self) && kind == AttachmentKind::TwoSides {
            let with = if Feature::Closed.is_in(self) { "sheet.closed" } else { "sheet.radius" };
            return Err(Error::beside("attachment.kind", with));
        }
        if self.viscosity()[2] != 0.0 {
            return Err(Error::beside("yarn.viscosity_bending", "sheet.radius"));
        }
        // Yarn that is taut along a curve pulls inwards.
        let strain = self.sheet.pre_strain[Axis::Horizontal as usize];
        if strain != 0.0 && !self.has_snug_casing() {
            return Err(Error::new(Code::NotInEquilibrium, "sheet.pre_strain", strain, 0.0).from("casing.radius"));
        }
        if strain != 0.0 && self.stack.plies > 1 && self.stack.gap > 0.0 {
            return Err(Error::new(Code::NotInEquilibrium, "stack.gap", self.stack.gap, 0.0).from("sheet.pre_strain"));
        }
        Ok(())
    }
}
