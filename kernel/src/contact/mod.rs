pub(crate) mod book;
pub mod candidate;
pub mod friction;
pub(crate) mod newton;
pub mod passage;
pub mod search;
pub mod solve;
pub mod stack;

/// What the unit tests of several files use.
#[cfg(test)]
mod tests {
    use crate::body::projectile::{Body, Inertia, Motion};
    use crate::body::shape::Solid;
    use crate::scene::parts::Scene;

    pub fn sphere() -> (Solid, Inertia, Body) {
        let scene = Scene::sheet_3in_sphere();
        let solid = Solid::of(&scene.projectile);
        let inertia = Inertia::of(&solid, scene.projectile.mass, true);
        let motion = Motion {
            position: [0.0; 3],
            velocity: [0.0, 0.0, 100.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        };
        (solid, inertia, Body::of(&motion))
    }

    /// Numbers from -1 to 1 without visible order.
    pub fn number(k: u64) -> f64 {
        2.0 * (crate::ground::random::splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}
