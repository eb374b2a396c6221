//! Measures of a scene: sizes, masses and cross-sections of the sheet and of its fabrics.

use crate::ground::planes::Axis;
use crate::scene::features::Feature;
use crate::scene::parts::{Scene, Shape, StrengthDraw, Weft};

/// One of the two fabrics of a stack; the front one is that of a sheet without a second one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cloth {
    Front,
    Back,
}

impl Scene {
    /// Whether contact can turn the projectile: every body with friction, without it all but a sphere.
    pub fn projectile_turns(&self) -> bool {
        self.projectile.shape != Shape::Sphere || self.contact.friction > 0.0
    }

    /// Linear, quadratic and bending viscosity.
    pub fn viscosity(&self) -> [f64; 3] {
        [self.yarn.viscosity_linear, self.yarn.viscosity_quadratic, self.yarn.viscosity_bending]
    }

    /// Plies of the front fabric: all without a second one.
    pub fn front_plies(&self) -> u32 {
        self.stack.plies.saturating_sub(self.back.plies)
    }

    /// Scene with the back fabric in all plies, and no second one.
    pub fn all_of_back(&self) -> Scene {
        let mut scene = *self;
        let Scene { sheet, weft, yarn, back, .. } = &mut scene;
        (back.plies, *weft) = (0, Weft::LIKE_WARP);
        (sheet.node_mass, sheet.crimp) = (back.node_mass, back.crimp);
        (sheet.yarn_area, sheet.yarn_area_y) = (back.yarn_area, back.yarn_area_y);
        (yarn.modulus_mean, yarn.modulus_sd) = (back.modulus_mean, back.modulus_sd);
        (yarn.damage_slope, yarn.damage_intercept, yarn.damage_sd) =
            (back.damage_slope, back.damage_intercept, back.damage_sd);
        yarn.stochastic = back.is_drawn();
        yarn.critical_stretch = back.critical_stretch;
        yarn.strength_draw = if back.weibull_shape == 0.0 { StrengthDraw::None } else { StrengthDraw::Weibull };
        (yarn.weibull_shape, yarn.weibull_gauge_length) = (back.weibull_shape, back.weibull_gauge_length);
        scene
    }

    /// Mass of one node of all bonded plies together, of the front fabric, kg.
    pub fn lumped_mass(&self) -> f64 {
        self.sheet.node_mass * self.sheet.plies as f64
    }

    /// Mass of the heaviest node, all bonded plies, kg.
    pub fn largest_mass(&self) -> f64 {
        let back = if self.back.plies > 0 { self.back.node_mass * self.sheet.plies as f64 } else { 0.0 };
        let front = self.lumped_mass();
        if back > front { back } else { front }
    }

    /// Node spacing along a direction, m.
    pub fn spacing(&self, axis: Axis) -> f64 {
        let own = axis == Axis::Vertical && self.sheet.spacing_y != 0.0;
        if own { self.sheet.spacing_y } else { self.sheet.spacing }
    }

    /// Node spacings along x and y, m.
    pub fn spacings(&self) -> [f64; 2] {
        [self.spacing(Axis::Horizontal), self.spacing(Axis::Vertical)]
    }

    /// The larger node spacing, m: a projectile must be larger to be seen by nodes, and what is nearer to it
    /// is a candidate.
    pub fn largest_spacing(&self) -> f64 {
        let [x, y] = self.spacings();
        if y > x { y } else { x }
    }

    /// Cross-section of one yarn of one ply along a direction, of the front fabric, m^2.
    pub fn yarn_area(&self, axis: Axis) -> f64 {
        self.area_of(axis, Cloth::Front)
    }

    /// Cross-section of one yarn of a fabric along a direction, m^2.
    pub(crate) fn area_of(&self, axis: Axis, cloth: Cloth) -> f64 {
        let (x, y) = if cloth == Cloth::Back {
            (self.back.yarn_area, self.back.yarn_area_y)
        } else {
            (self.sheet.yarn_area, self.sheet.yarn_area_y)
        };
        if axis == Axis::Vertical && y != 0.0 { y } else { x }
    }

    /// Mass of a node of one ply of a fabric, kg.
    pub(crate) fn node_mass(&self, cloth: Cloth) -> f64 {
        if cloth == Cloth::Back { self.back.node_mass } else { self.sheet.node_mass }
    }

    /// Stretch of the segments of a direction in the flat sheet: below 1 with crimp, above 1 with
    /// pre-tension.
    pub fn rest_stretch(&self, axis: Axis) -> f64 {
        self.stretch_at_rest(axis, Cloth::Front)
    }

    /// Stretch of the segments of a direction of a fabric at rest.
    pub(crate) fn stretch_at_rest(&self, axis: Axis, cloth: Cloth) -> f64 {
        let [crimp_x, crimp_y] = if cloth == Cloth::Back { self.back.crimp } else { self.sheet.crimp };
        let [strain_x, strain_y] = self.sheet.pre_strain;
        let (crimp, strain) = match axis {
            Axis::Horizontal => (crimp_x, strain_x),
            Axis::Vertical => (crimp_y, strain_y),
        };
        (1.0 + strain) / (1.0 + crimp)
    }

    /// Cross-section of one yarn along x of all plies together, m^2.
    pub fn lumped_area(&self) -> f64 {
        self.sheet.yarn_area * self.sheet.plies as f64
    }

    /// Half edge lengths of the sheet along x and y, m.
    pub fn half_size(&self) -> [f64; 2] {
        [
            0.5 * (self.sheet.nodes_x as f64 - 1.0) * self.sheet.spacing,
            0.5 * (self.sheet.nodes_y as f64 - 1.0) * self.spacing(Axis::Vertical),
        ]
    }

    /// Segments in a row: nx - 1, or nx of a ring.
    pub fn segments_of_row(&self) -> u64 {
        u64::from(self.sheet.nodes_x) - u64::from(!Feature::Closed.is_in(self))
    }

    /// Number of segments of one ply: those of ny rows, and nx (ny - 1).
    pub fn segments_of_ply(&self) -> u64 {
        let (nx, ny) = (self.sheet.nodes_x as u64, self.sheet.nodes_y as u64);
        self.segments_of_row() * ny + nx * (ny - 1)
    }

    /// Number of segments of all separate plies.
    pub fn segments(&self) -> u64 {
        self.segments_of_ply() * self.stack.plies as u64
    }

    /// Thickness of one network, of all the plies that are bonded into it, m.
    pub fn thickness(&self) -> f64 {
        if Feature::Thickness.is_built() { self.sheet.thickness * f64::from(self.sheet.plies) } else { 0.0 }
    }

    /// Distance of the middle surfaces of neighbouring plies where they rest, m; 0 where there is one.
    pub(crate) fn ply_gap(&self) -> f64 {
        if self.stack.plies > 1 { self.stack.gap + self.thickness() } else { 0.0 }
    }

    /// Distance of the last ply from the first where they rest, m.
    pub fn stack_height(&self) -> f64 {
        (self.stack.plies as f64 - 1.0) * self.ply_gap()
    }
}
