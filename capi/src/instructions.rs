//! The choice of vector instructions, for comparing the digests of all. Not in the shipped library.

use crate::block::{self, ToChange};
use fabric_kernel::InstructionSet;

/// Uses the instruction set of this number (`InstructionSet`). FK_UNKNOWN_CHOICE if there is none or this machine lacks it.
///
/// # Safety
/// As of [`crate::calls`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_use_instructions(mut sim: ToChange, set: u32) -> i32 {
    let Some(set) = InstructionSet::ALL.into_iter().find(|known| *known as u32 == set) else {
        return fabric_kernel::Code::UnknownChoice.number();
    };
    let chosen = block::open(&mut sim).and_then(|block| block.sim.use_instructions(set));
    chosen.map_or_else(|error| error.code.number(), |()| 0)
}
