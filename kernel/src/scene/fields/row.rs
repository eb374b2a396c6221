//! A row of the table: where a parameter stands in a scene, what it may be, and how it is read, set and
//! checked by itself.

use crate::ground::error::{Code, Error, finite, not_negative, positive};
use crate::scene::fields::choices::Choice;
use crate::scene::fields::quantities::Quantity;
use crate::scene::parts::{MAX_NODES_PER_SIDE, Scene};

/// Where a parameter stands in a scene, and its type.
#[derive(Clone, Copy)]
pub enum Place {
    /// Real numbers of this shape; an empty shape is a single number.
    Reals(fn(&mut Scene) -> &mut [f64], &'static [usize]),
    /// A count, 0 ..= 2^32 - 1.
    Count(fn(&mut Scene) -> &mut u32),
    /// A seed, 0 ..= 2^64 - 1.
    Seed(fn(&mut Scene) -> &mut u64),
    /// A truth value, 0 or 1.
    Flag(fn(&mut Scene) -> &mut bool),
    /// A choice: its number, and how it is set (not, if there is no such number).
    Choice(&'static Choice, fn(&Scene) -> u32, fn(&mut Scene, u32)),
}

/// Range of a number by itself. Every real number must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Anything.
    Any,
    /// > 0.
    Positive,
    /// >= 0.
    NotNegative,
    /// From the first to the second, both included.
    Within(f64, f64),
    /// Greater than the first, at most the second.
    Above(f64, f64),
    /// At least the first, less than the second.
    Below(f64, f64),
    /// Nodes along a side: 2 ..= [`MAX_NODES_PER_SIDE`].
    Nodes,
    /// Four numbers of unit length, to 1e-3.
    UnitQuaternion,
}

/// One row of the table.
#[derive(Clone, Copy)]
pub struct Field {
    /// Name: the path in [`Scene`], in C, in scene files and in the FMUs.
    pub name: &'static str,
    /// Place and type.
    pub place: Place,
    /// Kind of a real parameter.
    pub quantity: Option<&'static Quantity>,
    /// Range.
    pub range: Range,
    /// Number of its elements that the scene reads.
    pub read: fn(&Scene) -> usize,
    /// Whether an image fits only scenes with the same value, see
    /// [`fingerprint`](crate::sim::fingerprint::fingerprint).
    pub in_fingerprint: bool,
    /// Value reference in the FMUs, of its first element. Never changes once released.
    pub fmi: u32,
    /// Meaning, and what else holds.
    pub about: &'static str,
}

impl Field {
    /// Dimensions; empty for a single number.
    pub const fn shape(&self) -> &'static [usize] {
        match self.place {
            Place::Reals(_, shape) => shape,
            _ => &[],
        }
    }

    /// Number of elements.
    pub const fn size(&self) -> usize {
        let (mut size, mut shape) = (1, self.shape());
        while let [first, rest @ ..] = shape {
            size *= *first;
            shape = rest;
        }
        size
    }

    /// Whether its elements are real numbers; else they are whole.
    pub const fn is_real(&self) -> bool {
        matches!(self.place, Place::Reals(..))
    }

    /// An element as 64 bits: those of a real number, or a whole number. 0 for an element that there is not.
    pub fn word(&self, scene: &mut Scene, element: usize) -> u64 {
        match self.place {
            Place::Reals(place, _) => place(scene).get(element).map_or(0, |x| x.to_bits()),
            Place::Count(place) => u64::from(*place(scene)),
            Place::Seed(place) => *place(scene),
            Place::Flag(place) => u64::from(*place(scene)),
            Place::Choice(_, get, _) => u64::from(get(scene)),
        }
    }

    /// Sets an element from such bits.
    ///
    /// # Errors
    /// [`Code::UnknownChoice`], or for a count beyond 32 bits the code of its range; nothing is changed.
    pub fn set_word(&self, scene: &mut Scene, element: usize, word: u64) -> Result<(), Error> {
        let small = u32::try_from(word);
        let known = match self.place {
            Place::Choice(choice, ..) => word < choice.items.len() as u64,
            Place::Flag(_) => word <= 1,
            _ => true,
        };
        if !known {
            return Err(Error::new(Code::UnknownChoice, self.name, word as f64, 0.0));
        }
        match (self.place, small) {
            (Place::Reals(place, _), _) => {
                if let Some(x) = place(scene).get_mut(element) {
                    *x = f64::from_bits(word);
                }
            }
            (Place::Seed(place), _) => *place(scene) = word,
            (Place::Flag(place), _) => *place(scene) = word == 1,
            (Place::Count(place), Ok(count)) => *place(scene) = count,
            (Place::Choice(_, _, set), Ok(number)) => set(scene, number),
            (_, Err(_)) => return self.check_element(word as f64),
        }
        Ok(())
    }

    /// The word of a number given as a real one. Whole parameters are cut to whole numbers.
    pub fn word_of(&self, value: f64) -> u64 {
        if self.is_real() { value.to_bits() } else { value as u64 }
    }

    /// The number that a word is.
    pub fn value_of(&self, word: u64) -> f64 {
        if self.is_real() { f64::from_bits(word) } else { word as f64 }
    }

    /// Refuses an element that cannot be, whatever the others are. A quaternion is checked as a whole.
    pub(super) fn check_element(&self, value: f64) -> Result<(), Error> {
        finite(self.name, value)?;
        let ([least, greatest], [from, to]) = (self.limits(), self.ends());
        match self.range {
            Range::Positive => positive(self.name, value),
            Range::NotNegative => not_negative(self.name, value),
            Range::Nodes if value > greatest => Err(Error::new(Code::TooManyNodes, self.name, value, greatest)),
            _ if value < least => Err(Error::new(Code::OutOfRange, self.name, value, from)),
            _ if value > greatest => Err(Error::new(Code::OutOfRange, self.name, value, to)),
            _ => Ok(()),
        }
    }

    /// Least and greatest value that an element may have; infinite where there is none.
    pub fn limits(&self) -> [f64; 2] {
        let [from, to] = self.ends();
        match self.range {
            // Only a polyhedron has moments of its own: else they stay at 0.
            Range::Positive if self.name == "projectile.moments" => [from, to],
            Range::Positive | Range::Above(..) => [from.next_up(), to],
            Range::Below(..) => [from, to.next_down()],
            _ => [from, to],
        }
    }

    /// Ends of its range, whether or not they belong to it.
    fn ends(&self) -> [f64; 2] {
        match (self.range, self.place) {
            (Range::Positive | Range::NotNegative, _) => [0.0, f64::INFINITY],
            (Range::Within(from, to) | Range::Above(from, to) | Range::Below(from, to), _) => [from, to],
            (Range::Nodes, _) => [2.0, MAX_NODES_PER_SIDE as f64],
            (_, Place::Reals(..)) => [f64::NEG_INFINITY, f64::INFINITY],
            (_, Place::Choice(choice, ..)) => [0.0, choice.items.len() as f64 - 1.0],
            (_, Place::Flag(_)) => [0.0, 1.0],
            (_, Place::Seed(_)) => [0.0, u64::MAX as f64],
            (_, Place::Count(_)) => [0.0, u32::MAX as f64],
        }
    }

    pub(super) const fn read(self, read: fn(&Scene) -> usize) -> Field {
        Field { read, ..self }
    }

    pub(super) const fn not_in_fingerprint(self) -> Field {
        Field { in_fingerprint: false, ..self }
    }
}
