//! Volume and density of a projectile.

use fabric_kernel::math::sin;
use fabric_kernel::{Projectile, Shape, Solid};
use std::f64::consts::PI;

/// Volume of a projectile, m^3; none of a polyhedron.
pub fn volume(body: &Projectile) -> Option<f64> {
    let (r, sector) = (body.radius, &body.sector);
    let (disc, ball) = (PI * (r * r), 4.0 / 3.0 * PI * (r * r * r));
    match body.shape {
        Shape::Sphere => Some(ball),
        Shape::Cylinder => Some(disc * body.length),
        Shape::HemisphericalCylinder => Some(disc * (body.length - r) + 0.5 * ball),
        Shape::Box => Some(body.size[0] * body.size[1] * body.size[2]),
        Shape::DiscSector => {
            // Eight chords of the rim, less the triangle below the one chord of the bore.
            let (outer, inner) = (sector.outer_radius, sector.inner_radius);
            let area = 4.0 * (outer * outer) * sin(sector.angle / 8.0) - 0.5 * (inner * inner) * sin(sector.angle);
            Some(area * sector.thickness)
        }
        Shape::Polyhedron => None,
    }
}

/// No solid body has less, kg/m^3.
pub const LIGHTEST: f64 = 0.01;

/// Density of a projectile, kg/m^3; of a polyhedron the least that it may have, that of the sphere around it.
pub fn density(body: &Projectile) -> f64 {
    let reach = Solid::of(body).reach();
    body.mass / volume(body).unwrap_or(4.0 / 3.0 * PI * (reach * reach * reach))
}
