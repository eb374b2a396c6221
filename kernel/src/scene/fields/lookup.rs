//! Look-ups in the whole table: places of parameters, and the check of each number by itself.

use crate::ground::error::{Error, unit_quaternion};
use crate::scene::fields::row::{Field, Place, Range};
use crate::scene::fields::table::FIELDS;
use crate::scene::parts::Scene;

/// Number of elements of all parameters together.
pub const SLOTS: usize = slot_of(FIELDS.len());

/// Number of elements before a row: where it stands in the C structure, in words of 64 bits, after the first.
pub const fn slot_of(row: usize) -> usize {
    let (mut slots, mut k) = (0, 0);
    while k < row && k < FIELDS.len() {
        slots += FIELDS[k].size();
        k += 1;
    }
    slots
}

/// Row of a name. Compared byte by byte: whole strings are compared by `bcmp`, which not every target has.
pub fn field(name: &str) -> Option<&'static Field> {
    FIELDS.iter().find(|field| field.name.bytes().eq(name.bytes()))
}

/// Refuses the first number, in the order of the table, that cannot be, whatever the others are. What the
/// scene does not read may be anything.
#[inline(never)]
pub fn check(scene: &Scene) -> Result<(), Error> {
    let mut copy = *scene;
    for field in FIELDS {
        let read = (field.read)(scene).min(field.size());
        for element in 0..read {
            field.check_element(field.value_of(field.word(&mut copy, element)))?;
        }
        if let (Range::UnitQuaternion, Place::Reals(place, _)) = (field.range, field.place)
            && let Some(quaternion) = place(&mut copy).first_chunk()
        {
            unit_quaternion(field.name, *quaternion)?;
        }
    }
    Ok(())
}
