//! Structures and constants of the C interface. SI units; vectors in the host's frame; quaternions scalar first.
//!
//! Each read-out of a run has one structure for Rust and C: the aliases below. The scene's structure, with its comments,
//! and the constants of its choices are made from `fabric_kernel::fields`, those of the statuses from `fabric_kernel::Code`, by
//! `cargo xtask header`.
#![allow(non_camel_case_types)] // C names.

use core::ffi::c_char;
use fabric_kernel::fields::{FIELDS, Field, SLOTS};
use fabric_kernel::{Error, Scene};
#[rustfmt::skip]
pub use fabric_capsule::{Replay as fk_replay_place};

pub use fabric_kernel::{
    Contact as fk_contact, Counters as fk_counters, Energy as fk_energy, Fabric as fk_fabric, Motion as fk_motion,
    Path as fk_path, Ply as fk_ply, Slip as fk_slip, StepLimits as fk_step_limits, Support as fk_support,
    Textile as fk_textile, Threads as fk_threads,
};

/// Version of this interface: goes up whenever a structure or a function is added. A host needs a library of at least its own.
pub const FK_ABI_VERSION: u32 = 1;

/// Success.
pub const FK_OK: i32 = 0;

/// Most bands for fk_bands_begin.
pub const FK_MAX_BANDS: u32 = 32;

/// Preset of the paper's 3 in sheet (105 x 105) with four sides held and the 8.4 g sphere.
pub const FK_PRESET_SHEET_3IN_SPHERE: u32 = 0;
/// Preset of the paper's 10 in sheet (350 x 350) with two sides held and the 37 g cylinder.
pub const FK_PRESET_SHEET_10IN_CYLINDER: u32 = 1;
/// Preset of the 10 in sheet with four sides held and a third of a small turbine disc, rim first, as a polyhedron: set
/// projectile.shape to FK_SHAPE_DISC_SECTOR to change it by its dimensions. Its mass does not follow from them.
pub const FK_PRESET_TURBINE_DISC_SECTOR: u32 = 2;
/// Preset of a ring of NASA's tests, 40 in across within: five plies of Zylon on a case, and the sector of a disc that left the axis.
pub const FK_PRESET_RING_40IN: u32 = 3;

/// Bit of the outcome "arrested" in masks.
pub const FK_ARRESTED: u32 = 1;
/// Bit of the outcome "detached".
pub const FK_DETACHED: u32 = 2;
/// Bit of the outcome "exited".
pub const FK_EXITED: u32 = 4;
/// Bit of the outcome "passed".
pub const FK_PASSED: u32 = 8;
/// Bit of the outcome "through"; it comes only with track_through.
pub const FK_THROUGH: u32 = 16;
/// Bit of the outcome "rebounded".
pub const FK_REBOUNDED: u32 = 32;
/// Bit of the outcome "attachment_failed"; it comes only with attachment.strength.
pub const FK_ATTACHMENT_FAILED: u32 = 64;
/// Bits of the outcomes that end a shot: arrested, exited, passed, rebounded.
pub const FK_ENDS: u32 = 45;

/// fk_outcome's status: no contact in the last step.
pub const FK_STATUS_FLIGHT: u32 = 0;
/// fk_outcome's status: contact in the last step.
pub const FK_STATUS_CONTACT: u32 = 1;

/// fk_energy's gained over the kinetic energy at impact, above which the outcome is not to be trusted.
pub const FK_MOST_GAINED: f64 = 1e-3;
const _: () = assert!(FK_MOST_GAINED == fabric_kernel::MOST_GAINED);

/// A step count that has not happened.
pub const FK_NEVER: u64 = u64::MAX;

/// fk_replayed's end: there is more to do.
pub const FK_REPLAY_GOES_ON: u64 = 0;
/// fk_replayed's end: all of it was done, with the same bits.
pub const FK_REPLAY_SAME: u64 = 1;
/// fk_replayed's end: a digest of the state differs.
pub const FK_REPLAY_DIGEST: u64 = 2;
/// fk_replayed's end: a call ended at another step.
pub const FK_REPLAY_STEPS: u64 = 3;
/// fk_replayed's end: a call failed otherwise, or is refused; both numbers are statuses.
pub const FK_REPLAY_STATUS: u64 = 4;

/// Contents of a capsule.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct fk_capsule {
    /// Calls.
    pub calls: u64,
    /// Steps of all calls together.
    pub steps: u64,
    /// Calls from one digest to the next.
    pub stride: u64,
    /// Numbers that fk_replay needs room for.
    pub room: u64,
    /// 1 if its program ended it, else 0.
    pub ended: u64,
    /// Byte at which it is broken; 0 if it is not.
    pub broken_at: u64,
    /// Bytes that are whole.
    pub whole: u64,
}

/// How far a replay is, and what it found.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct fk_replayed {
    /// How far it is; all zeros at the beginning.
    pub at: fk_replay_place,
    /// FK_REPLAY_GOES_ON, or how it ended.
    pub end: u64,
    /// Number in the capsule, where the two differ.
    pub written: u64,
    /// Number found, where the two differ.
    pub found: u64,
}

/// A scene: what is simulated. In C it has a member for each row of `fabric_kernel::fields::FIELDS`, in that order, each number in 64 bits.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_scene {
    /// The structure's size in bytes, then the numbers.
    pub words: [u64; 1 + SLOTS],
}

/// Why a request was refused or a step failed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_fault {
    /// Status number: FK_OK, or an error's.
    pub status: i32,
    /// 0.
    pub reserved: u32,
    /// Offending value in SI units; 0 where none applies.
    pub value: f64,
    /// Limit crossed, SI units; 0 where none applies. For FK_STEP_TOO_LARGE the largest allowed step, s; for
    /// FK_WRONG_LENGTH and FK_SHORT_BUFFER the length wanted.
    pub limit: f64,
    /// Name of the field, zero-terminated, as in fk_scene, e.g. "sheet.spacing"; empty if no single field is to blame.
    pub field: [c_char; 48],
    /// One line for a log, zero-terminated.
    pub text: [c_char; 168],
}

/// Modelled part of the sheet, and so the lengths of the arrays of fk_copy_... and fk_set_... Of a stack it is what one ply
/// has, and arrays hold `plies` times as much, ply by ply.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_grid {
    /// Nodes along x: sheet.nodes_x, of a graded network its own, or what symmetry.mirror_x leaves of them.
    pub nodes_x: u64,
    /// Nodes along y: sheet.nodes_y, of a graded network its own, or what symmetry.mirror_y leaves of them.
    pub nodes_y: u64,
    /// Segments along x, row by row, horizontal / nodes_y in each row.
    pub horizontal: u64,
    /// Segments along y, row by row, nodes_x in each row; in arrays they come after those along x.
    pub vertical: u64,
    /// Separate plies.
    pub plies: u64,
}

/// Outcomes; FK_NEVER for what has not happened.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_outcome {
    /// FK_STATUS_FLIGHT or FK_STATUS_CONTACT: what is true now, whatever has latched.
    pub status: u32,
    /// FK_ARRESTED | FK_DETACHED | ...: the bits of all latched outcomes.
    pub mask: u32,
    /// Step count at whose start the first impulse acted; FK_NEVER before.
    pub first_contact: u64,
    /// Step count at which arrested, detached, exited, passed, through, rebounded, attachment_failed latched, in this order; FK_NEVER before.
    pub step: [u64; 7],
    /// Work of the projectile on the fabric until then, J; 0 before.
    pub work: [f64; 7],
}

/// Every number of a scene: its row and its element, in the order of the structure.
fn numbers() -> impl Iterator<Item = (&'static Field, usize)> {
    FIELDS.iter().flat_map(|field| (0..field.size()).map(move |element| (field, element)))
}

impl fk_scene {
    /// The structure of a scene.
    pub fn of(mut scene: Scene) -> fk_scene {
        let mut words = [size_of::<fk_scene>() as u64; 1 + SLOTS];
        fk_scene::fill(&mut words[1..], &mut scene);
        fk_scene { words }
    }

    /// Takes a scene's numbers, as many as there are places, from where it is. The scene is not changed.
    pub(crate) fn fill(places: &mut [u64], scene: &mut Scene) {
        let places = places.iter_mut();
        places.zip(numbers()).for_each(|(word, (field, element))| *word = field.word(scene, element));
    }

    /// The scene that the words of a structure describe. What an older, shorter one lacks is as in the 10 in preset.
    ///
    /// # Errors
    /// A choice that has no such number, or a count beyond 32 bits, named.
    pub fn scene(words: &[u64]) -> Result<Scene, Error> {
        let mut scene = Scene::sheet_10in_cylinder();
        let given = numbers().zip(words.iter().skip(1));
        for ((field, element), word) in given {
            field.set_word(&mut scene, element, *word)?;
        }
        Ok(scene)
    }
}

impl fk_fault {
    /// Fault of a call that was not refused.
    pub const NONE: fk_fault =
        fk_fault { status: FK_OK, reserved: 0, value: 0.0, limit: 0.0, field: [0; 48], text: [0; 168] };

    /// The structure of an error.
    pub fn of(error: &Error) -> fk_fault {
        let mut fault =
            fk_fault { status: error.code.number(), value: error.value, limit: error.limit, ..fk_fault::NONE };
        copy_text(&mut fault.field, error.field);
        copy_text(&mut fault.text, &error.text());
        fault
    }
}

/// Copies what fits and leaves a zero at the end.
fn copy_text(to: &mut [c_char], text: &str) {
    let room = to.len().saturating_sub(1);
    to.iter_mut().take(room).zip(text.bytes()).for_each(|(slot, byte)| *slot = byte as c_char);
}
