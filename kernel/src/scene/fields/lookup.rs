//! What is read off the whole table: places of parameters, the check of each number by itself, and the
//! fingerprint of a scene.

use crate::ground::error::{Error, unit_quaternion};
use crate::scene::fields::row::{Field, Image, Place, Range};
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

/// The row of a name.
pub fn field(name: &str) -> Option<&'static Field> {
    FIELDS.iter().find(|field| field.name == name)
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

/// Shows the words of a scene's fingerprint, in their order. `dt`: the step in use, s.
#[inline(never)]
pub fn fingerprint_words(scene: &Scene, dt: f64, take: &mut impl FnMut(u64)) {
    let mut copy = *scene;
    for field in FIELDS {
        let elements = match field.image {
            Image::Always => field.size(),
            Image::WhereRead => (field.read)(scene).min(field.size()),
            Image::StepInUse => {
                take(dt.to_bits());
                0
            }
            Image::Later(_) | Image::LaterWhereRead | Image::Never => 0,
        };
        (0..elements).for_each(|element| take(field.word(&mut copy, element)));
    }
    for (k, field) in FIELDS.iter().enumerate() {
        let read = (field.read)(scene).min(field.size());
        let shares = |other: &&Field| other.image == field.image;
        match field.image {
            Image::LaterWhereRead => (0..read).for_each(|element| take(field.word(&mut copy, element))),
            Image::Later(_) if FIELDS.iter().take(k).any(|other| shares(&other)) => {} // shown with the first
            Image::Later(tag) if field.is_real() => {
                let used = (0..read).any(|element| field.value_of(field.word(&mut copy, element)) != 0.0);
                if used {
                    take(tag);
                    (0..read).for_each(|element| take(field.word(&mut copy, element)));
                }
            }
            Image::Later(tag) if read > 0 => {
                let bits = FIELDS.iter().filter(shares).enumerate();
                let sum = bits.map(|(bit, other)| other.word(&mut copy, 0) << bit).sum::<u64>();
                if sum > 0 {
                    take(tag + sum);
                }
            }
            _ => {}
        }
    }
}
