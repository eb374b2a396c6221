//! Ballistic fabric as a network of trusses, hit by a rigid projectile: deterministic, allocation-free, on
//! the caller's memory.
//!
//! One bar per yarn segment between crossings, whose stiffness and gradual rupture come from hundreds of
//! randomly misaligned fibrils (Powell and Zohdi 2009). Nodes carry the mass; contact with the rigid
//! projectile is by impulses; time stepping is explicit. The same scene and the same calls give the same bits
//! on every supported machine.
//!
//! Units are SI throughout. Three blocks of memory (model, state, scratch) are the caller's; there is no
//! allocation, no global state, no thread, no panic.
//!
//! ```
//! use fabric_kernel::{CacheLine, Layout, OutcomeSet, Scene, Sim};
//!
//! // The paper's 3 in sheet, smaller here, hit by the 8.4 g sphere at 60 m/s.
//! let mut scene = Scene::sheet_3in_sphere();
//! scene.sheet.nodes_x = 41;
//! scene.sheet.nodes_y = 41;
//! scene.projectile.velocity = [0.0, 0.0, 60.0];
//!
//! let layout = Layout::of(&scene)?;
//! let mut memory = vec![CacheLine::ZERO; layout.lines()];
//! let mut sim = Sim::new(&scene, &mut memory)?;
//!
//! sim.advance_until(OutcomeSet::ENDS, 20_000)?;
//! println!("residual velocity {:.1} m/s", sim.projectile()?.velocity[2]);
//! println!("absorbed energy {:.2} J", sim.contact()?.work);
//! println!("failed segments {}", sim.counters().failed_segments);
//! # Ok::<(), fabric_kernel::Error>(())
//! ```
#![no_std]
#![deny(unsafe_code, missing_docs)]
#![warn(clippy::too_many_lines)]
// What only tests, studies and fibrils use, or what a feature left out needs, is not called in every build.
#![cfg_attr(not(all(feature = "internals", feature = "micro", feature = "default")), allow(dead_code))]

#[cfg(test)]
extern crate std;

// `#[inline(never)]` saves code or stack. Each was removed alone: one costs up to 4.8 kB of code
// (`Yarns::dissipated`) or 0.6 kB of stack (`Bands::complete`). With none of them the bounds are not all
// proven, and no library links. `cargo xtask test --only gates` prints the code and the deepest calls.

// The rooms, from the ground up. A file imports from its own room and from those before it, never from one
// after it.

/// Floor 1: what everything stands on. Mathematics, errors, random numbers, hash, lanes of vector
/// instructions, planes and ranges.
mod ground;

/// Floor 2: what is simulated. The parts of a scene, and the table of all its parameters.
mod scene;

/// Floor 3: the law of a yarn. Stress and damage, rate; fibrils, and the law that is fitted to them.
mod yarn;

/// Floor 3: the rigid projectile. Pose, shapes and their gaps, inertia, a prescribed path.
mod body;

/// Floor 4: the sheet. Places, weave, directions, draws, grading, mirror planes, data sheets, and checks.
mod sheet;

/// Floor 5: the caller's memory. What is in it and where, and the system that all steps work on.
mod memory;

/// Floor 6: the sweep over the rows. Segments and the effects on them, one pass, and its sums.
mod sweep;

/// Floor 7: impulses. Between nodes and projectile, between plies, and their friction.
mod contact;

/// Floor 8: one time step. The sweep of the whole sheet, motion, one step, the theta rule, steps in blocks,
/// bands; read-outs, energy, outcomes.
mod step;

/// Floor 9: a simulation. Its start, its calls, its image, and the table of all its outputs.
mod sim;

pub use body::path::{Path, exponential};
pub use body::pose;
pub use body::projectile::{Body, Inertia, Motion};
pub use body::shape::{Form, Solid};
pub use ground::error::{Code, Error, Failure};
pub use ground::hash::Hash;
pub use ground::lanes::{CacheLine, InstructionSet};
pub use ground::math;
pub use memory::layout::{Layout, MAX_BANDS};
pub use memory::watch::{Latch, Outcome, OutcomeSet};
pub use scene::features::{FEATURES, Feature};
pub use scene::fields;
pub use scene::parts::{
    Attachment, AttachmentKind, Back, Casing, ContactLaw, Draw, Drive, Faces, Grading, Integrator, IntegratorKind,
    MAX_FACES, MAX_NODES_PER_SIDE, MAX_PLIES, Projectile, RotationKind, RotationRule, Scene, Sector, Shape, Sheet,
    Stack, StepCheck, StepLimits, StrengthDraw, Symmetry, TimeStep, Weft, Yarn,
};
pub use scene::sentence::number;
pub use sheet::textile::{self, TEXTILE_VISCOSITY, Textile, Threads};
pub use sim::outputs;
pub use sim::simulation::{Contact, Counters, Fabric, Outcomes, Sim, Status, Support};
pub use sim::snapshot::FORMAT;
pub use step::bands::Bands;
pub use step::energy::{Energy, MOST_GAINED, Ply};
pub use step::outcome::TEST_INTERVAL;
pub use step::slip::Slip;
#[cfg(feature = "micro")]
pub use yarn::{calibrate, fibril};

/// The files of the kernel, for its tests, studies and fuzzing. A host does not need them, and nothing here
/// is promised to stay.
#[cfg(feature = "internals")]
pub mod internals {
    pub use crate::body::*;
    pub use crate::contact::*;
    pub use crate::ground::*;
    pub use crate::memory::*;
    pub use crate::scene::*;
    pub use crate::sheet::*;
    pub use crate::sim::*;
    pub use crate::step::*;
    pub use crate::sweep::*;
    pub use crate::yarn::*;
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Version of this crate. Another version may give other bits: images and models of one are not for the
/// other.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Helpers of the unit tests of several files.
#[cfg(test)]
mod tests {
    use crate::body::projectile::Motion;
    use crate::ground::random::splitmix64;
    use crate::memory::arrays::Contacts;
    use crate::memory::model::Model;
    use crate::memory::network::Network;
    use crate::scene::parts::Scene;
    use crate::sheet::direction::Directions;
    use crate::{Body, CacheLine, Layout, Sim, Solid};
    use std::vec;
    use std::vec::Vec;

    /// A body at rest in the origin.
    pub const AT_REST: Motion = Motion {
        position: [0.0; 3],
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };

    /// The preset's sphere at 100 m/s.
    pub fn sphere() -> (Solid, Body) {
        let solid = Solid::of(&Scene::sheet_3in_sphere().projectile);
        (solid, Body::of(&Motion { velocity: [0.0, 0.0, 100.0], ..AT_REST }))
    }

    /// Equal but for this share of what is expected.
    #[track_caller]
    pub fn close(value: f64, expected: f64, relative: f64) {
        assert!((value - expected).abs() <= relative * expected.abs(), "{value:e} is not {expected:e}");
    }

    /// Numbers from -1 to 1 without visible order.
    pub fn number(k: u64) -> f64 {
        2.0 * (splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }

    /// The 3 in preset on another number of nodes.
    pub fn sheet(nodes_x: u32, nodes_y: u32) -> Scene {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes_x, nodes_y);
        scene
    }

    /// 21 x 21 nodes, four sides held, every option that adds to the state; the preset sphere at 150 m/s.
    pub fn torn_by_a_sphere() -> Scene {
        let mut scene = sheet(21, 21);
        (scene.track_detachment, scene.track_support, scene.projectile.velocity) = (true, true, [0.0, 0.0, 150.0]);
        (scene.yarn.stochastic, scene.slack_balance) = (true, true);
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_bending) = (0.06, 0.06);
        scene
    }

    /// A simulation of the scene, in memory of its own.
    pub fn sim(scene: &Scene) -> Sim<'static> {
        let memory = vec![CacheLine::ZERO; Layout::of(scene).unwrap().lines()];
        Sim::new(scene, memory.leak()).unwrap()
    }

    /// Network of the scene at rest, room for its contacts, and the projectile's solid, without a simulation.
    pub fn network(scene: &Scene) -> (Network<'static>, Contacts<'static>, Solid) {
        let (layout, limits, solid) =
            (Layout::of(scene).unwrap(), scene.step_limits().unwrap(), Solid::of_scene(scene));
        let (model, directions) = (Model::of(scene, limits, &solid), Directions::of(scene, limits.dt));
        let mut network = Network { scene: *scene, layout, model, directions, ..Network::NOTHING };
        let mut contacts = Contacts::nothing();
        network.arrays.carve(&mut contacts, vec![CacheLine::ZERO; layout.lines()].leak(), &layout).unwrap();
        network.fill_model().unwrap();
        network.clear();
        network.refill(|_, _| true);
        (network, contacts, solid)
    }

    pub fn saved(sim: &Sim<'_>) -> Vec<u8> {
        let mut image = vec![0; sim.snapshot_bytes()];
        sim.save(&mut image).unwrap();
        image
    }

    pub fn word_of(image: &[u8], at: usize) -> u64 {
        u64::from_le_bytes(*image[8 * at..].first_chunk().unwrap())
    }
}
