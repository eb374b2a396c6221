//! Ballistic fabric as a network of trusses, hit by a rigid projectile: deterministic, allocation-free, on the caller's memory.
//!
//! One bar per yarn segment between crossings, whose stiffness and gradual rupture come from hundreds of randomly misaligned
//! fibrils (Powell and Zohdi 2009). Nodes carry the mass; contact with the rigid projectile is by impulses; time stepping is
//! explicit. The same scene and the same calls give the same bits on every supported machine.
//!
//! Units are SI throughout. Three blocks of memory (model, state, scratch) are the caller's; there is no allocation, no
//! global state, no thread, no panic.
//!
//! ```
//! use fabric::{CacheLine, Layout, Outcome, Scene, Sim};
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
//! sim.advance_until(Outcome::Arrested | Outcome::Exited, 20_000)?;
//! println!("residual velocity {:.1} m/s", sim.projectile()?.velocity[2]);
//! println!("absorbed energy {:.2} J", sim.contact()?.work);
//! println!("failed segments {}", sim.counters().failed_segments);
//! # Ok::<(), fabric::Error>(())
//! ```
#![no_std]
#![deny(unsafe_code, missing_docs)]

#[cfg(test)]
extern crate std;

pub mod bands;
mod blocks;
mod body;
#[cfg(feature = "micro")]
pub mod calibrate;
pub mod candidate;
mod check;
pub mod contact;
mod direction;
mod draw;
pub mod energy;
pub mod error;
#[cfg(feature = "micro")]
pub mod fibril;
pub mod fields;
pub mod friction;
pub mod grading;
pub mod lanes;
pub mod layout;
mod marks;
pub mod math;
mod model;
mod newton;
pub mod outcome;
pub mod path;
mod pieces;
pub mod places;
pub mod planes;
pub mod polyhedron;
pub mod pose;
pub mod prism;
pub mod projectile;
pub mod random;
mod ranges;
mod rate;
mod readout;
mod relaxation;
mod rows;
pub mod scene;
pub mod shape;
pub mod sim;
pub mod snapshot;
mod stack;
mod start;
pub mod state;
mod step;
pub mod sweep;
pub mod symmetry;
mod system;
pub mod textile;
#[cfg(feature = "implicit")]
mod theta;
pub mod toe;
mod viscosity;
pub mod watch;
mod waves;
pub mod weave;
pub mod yarn;

pub use bands::Bands;
pub use energy::{Energy, Ply};
pub use error::{Code, Error, Failure};
pub use lanes::{CacheLine, InstructionSet};
pub use layout::Layout;
pub use path::Path;
pub use projectile::Motion;
pub use scene::{
    Attachment, AttachmentKind, Back, ContactLaw, Draw, Drive, Faces, Grading, Integrator, IntegratorKind, MAX_FACES,
    Projectile, RotationKind, RotationRule, Scene, Sector, Shape, Sheet, Stack, StepAfterFailure, StepCheck,
    StepLimits, StrengthDraw, Symmetry, TimeStep, Weft, Yarn,
};
pub use sim::{Contact, Counters, Fabric, Outcomes, Sim, Status, Support};
pub use textile::{TEXTILE_VISCOSITY, Textile, Threads};
pub use watch::{Latch, Outcome, OutcomeSet};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Version of this crate. Another version may give other bits: images and models of one are not for the other.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
