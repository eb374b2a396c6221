//! Reading a capsule: every record and its check before anything is done, the scene that it begins with, and each call.
//!
//! Limit: a file without a last record is taken as far as it goes, for the program may have crashed ([`Capsule::ended`]); one that ends
//! within a record is refused, and [`Broken::whole`] says how much of it may be used.

use crate::{CHECK, Call, Check, FORMAT, HEAD, KINDS, Kind, MAGIC, motion_of};
use core::fmt;
use fabric_kernel::fields::{FIELDS, Field};
use fabric_kernel::{Path, Scene};

/// Why bytes are no capsule, or not a whole one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// Defect that was found.
    pub what: What,
    /// Where, bytes from the start.
    pub at: usize,
    /// Bytes before it that are whole: as a capsule these can be read, unless the scene is not among them.
    pub whole: usize,
}

/// Defect of a capsule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// It does not begin like one.
    NoCapsule,
    /// It has another version of the format.
    OtherFormat(u32),
    /// It ends within a record, or before its scene is whole.
    Truncated,
    /// Bytes were altered.
    Altered,
    /// A record of a kind that there is not, or where it cannot stand.
    UnknownRecord(u8),
    /// A record whose content does not fit its kind.
    Malformed(u8),
    /// A parameter that this version does not know, or a value it cannot have.
    UnknownNumber,
    /// Something stands after its last record.
    BehindTheEnd,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.what {
            What::NoCapsule => write!(f, "not a capsule: it does not begin with FKCAPSUL"),
            What::OtherFormat(format) => write!(f, "a capsule of format {format}; this program reads format {FORMAT}"),
            What::Truncated => write!(f, "the capsule is cut off at byte {}", self.at),
            What::Altered => write!(f, "the capsule was altered before byte {}: its check does not fit", self.at),
            What::UnknownRecord(kind) => {
                write!(f, "no record of kind {kind} can stand at byte {} of the capsule", self.at)
            }
            What::Malformed(kind) => {
                write!(f, "the record of kind {kind} at byte {} of the capsule has a wrong content", self.at)
            }
            What::UnknownNumber => {
                write!(f, "the number of the scene at byte {} of the capsule is unknown here, or cannot be", self.at)
            }
            What::BehindTheEnd => {
                write!(f, "something stands behind the last record of the capsule, at byte {}", self.at)
            }
        }
    }
}

impl core::error::Error for Broken {}

/// A capsule that was read through.
#[derive(Clone, Copy, Debug)]
pub struct Capsule<'c> {
    /// Version of the kernel that wrote it.
    pub version: &'c str,
    /// Calls from one digest to the next.
    pub stride: u64,
    /// Digest of step 0.
    pub start: u64,
    /// Calls in it.
    pub calls: u64,
    /// Steps in it, of all calls together.
    pub steps: u64,
    /// True if its program ended it.
    pub ended: bool,
    /// The records of the scene, and those after it.
    numbers: &'c [u8],
    pub(crate) records: &'c [u8],
}

/// A record: its kind and content, and what follows it.
pub(crate) struct Record<'c> {
    pub kind: Kind,
    pub content: &'c [u8],
    pub rest: &'c [u8],
}

/// The next record, whatever its check.
pub(crate) fn record(bytes: &[u8]) -> Result<Record<'_>, What> {
    let ([number, length @ ..], rest) = bytes.split_first_chunk::<HEAD>().ok_or(What::Truncated)?;
    let kind = *KINDS.get(usize::from(*number).wrapping_sub(1)).ok_or(What::UnknownRecord(*number))?;
    let (content, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or(What::Truncated)?;
    let (_, rest) = rest.split_first_chunk::<CHECK>().ok_or(What::Truncated)?;
    Ok(Record { kind, content, rest })
}

/// The words of a record, if it has so many.
pub(crate) fn words<const N: usize>(content: &[u8]) -> Option<[u64; N]> {
    let (words, []) = content.as_chunks::<8>() else { return None };
    words.first_chunk::<N>().filter(|_| words.len() == N).map(|words| words.map(u64::from_le_bytes))
}

impl<'c> Capsule<'c> {
    /// Reads a capsule through.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn open(bytes: &'c [u8]) -> Result<Capsule<'c>, Broken> {
        let mut at = 0;
        let mut found =
            Capsule { version: "", stride: 0, start: 0, calls: 0, steps: 0, ended: false, numbers: &[], records: &[] };
        found.read(bytes, &mut at).map_err(|what| Broken { what, at, whole: at })?;
        Ok(found)
    }

    /// at: where the record begins that is being read.
    fn read(&mut self, bytes: &'c [u8], at: &mut usize) -> Result<(), What> {
        let (magic, rest) = bytes.split_first_chunk().ok_or(What::NoCapsule)?;
        if u64::from_le_bytes(*magic) != MAGIC {
            return Err(What::NoCapsule);
        }
        let (format, mut rest) = rest.split_first_chunk().ok_or(What::Truncated)?;
        if u32::from_le_bytes(*format) != FORMAT {
            return Err(What::OtherFormat(u32::from_le_bytes(*format)));
        }
        let mut check = Check::default();
        check.take(magic);
        check.take(format);
        let mut before = None;
        loop {
            *at = bytes.len() - rest.len();
            let in_scene = matches!(before, None | Some(Kind::Origin | Kind::Number));
            if rest.is_empty() && !in_scene {
                return Ok(());
            }
            let next = record(rest)?;
            let length = HEAD + next.content.len();
            check.take(rest.get(..length).unwrap_or_default());
            let found = rest.get(length..).and_then(|rest| rest.first_chunk::<CHECK>());
            if found.is_none_or(|found| u64::from_le_bytes(*found) != check.0.value()) {
                return Err(What::Altered);
            }
            if before == Some(Kind::End) {
                return Err(What::BehindTheEnd);
            }
            self.take(before, &next)?;
            match next.kind {
                Kind::Origin => self.numbers = next.rest,
                Kind::Start => self.records = next.rest,
                _ => {}
            }
            (before, rest) = (Some(next.kind), next.rest);
        }
    }

    /// Takes a record in, after one of that kind.
    fn take(&mut self, before: Option<Kind>, record: &Record<'c>) -> Result<(), What> {
        let kind = record.kind as u8;
        let malformed = What::Malformed(kind);
        let in_scene = matches!(before, Some(Kind::Origin | Kind::Number));
        match record.kind {
            Kind::Origin if before.is_none() => {
                let (stride, version) = record.content.split_first_chunk().ok_or(malformed)?;
                self.stride = u64::from_le_bytes(*stride);
                self.version = core::str::from_utf8(version).map_err(|_| malformed)?;
            }
            Kind::Number if in_scene => _ = number(record.content).ok_or(What::UnknownNumber)?,
            Kind::Start if in_scene => [self.start] = words(record.content).ok_or(malformed)?,
            Kind::Origin | Kind::Number | Kind::Start => return Err(What::UnknownRecord(kind)),
            _ if before.is_none() || in_scene => return Err(What::UnknownRecord(kind)),
            Kind::Digest | Kind::End => {
                words::<1>(record.content).ok_or(malformed)?;
                self.ended = record.kind == Kind::End;
            }
            Kind::Advance => {
                let [steps, _, _] = words(record.content).ok_or(malformed)?;
                self.steps = self.steps.checked_add(steps).ok_or(malformed)?;
                self.calls += 1;
            }
            kind => {
                let fits = match kind {
                    Kind::Path => words::<16>(record.content).is_some(),
                    Kind::ExternalLoad => words::<6>(record.content).is_some(),
                    Kind::Motion => record.content.len().is_multiple_of(16),
                    Kind::LargestStretch => record.content.len().is_multiple_of(8),
                    Kind::Reset => record.content.is_empty(),
                    _ => true,
                };
                self.calls += 1;
                return if fits { Ok(()) } else { Err(malformed) };
            }
        }
        Ok(())
    }

    /// Scene that was simulated. Nothing of it is checked but that each number can be one.
    ///
    /// # Errors
    /// [`What::UnknownNumber`]: a choice that this version does not have, or the like.
    #[inline(never)] // A scene takes a kilobyte of stack.
    pub fn scene(&self) -> Result<Scene, What> {
        let (mut scene, mut rest) = (Scene::sheet_3in_sphere(), self.numbers);
        while let Ok(next) = record(rest)
            && next.kind == Kind::Number
        {
            let (field, values) = number(next.content).ok_or(What::UnknownNumber)?;
            for (element, value) in values.iter().enumerate() {
                let word = u64::from_le_bytes(*value);
                field.set_word(&mut scene, element, word).map_err(|_| What::UnknownNumber)?;
            }
            rest = next.rest;
        }
        Ok(scene)
    }

    /// Numbers that [`Replay::next`](crate::Replay::next) needs room for: those of the largest array of a call.
    pub fn room(&self) -> usize {
        let (mut rest, mut most) = (self.records, 0);
        while let Ok(next) = record(rest) {
            if matches!(next.kind, Kind::Motion | Kind::LargestStretch) {
                most = most.max(next.content.len() / 8);
            }
            rest = next.rest;
        }
        most
    }
}

/// A number of the scene: its row, and its elements.
fn number(content: &[u8]) -> Option<(&'static Field, &[[u8; 8]])> {
    let (length, rest) = content.split_first()?;
    let (name, values) = rest.split_at_checked(usize::from(*length))?;
    // Byte by byte: a comparison of texts would need another function of a bare machine.
    let same = |field: &&Field| field.name.len() == name.len() && field.name.bytes().zip(name).all(|(a, b)| a == *b);
    let field = FIELDS.iter().find(same)?;
    let (values, []) = values.as_chunks::<8>() else { return None };
    (values.len() == field.size()).then_some((field, values))
}

/// The call of a record, if it is one that fits and takes no steps; arrays in `room`.
pub(crate) fn call<'a>(kind: Kind, content: &'a [u8], room: &'a mut [f64]) -> Option<Call<'a>> {
    let numbers = |room: &'a mut [f64]| -> Option<&'a [f64]> {
        let (words, _) = content.as_chunks::<8>();
        let place = room.get_mut(..words.len())?;
        place.iter_mut().zip(words).for_each(|(number, word)| *number = f64::from_le_bytes(*word));
        Some(place)
    };
    match kind {
        Kind::Path => {
            let [first, steps, end @ .., ahead] = words::<16>(content)?;
            Some(Call::Path(Path { first, steps, end: motion_of(end.map(f64::from_bits)) }, ahead))
        }
        Kind::ExternalLoad => {
            let [a, b, c, d, e, f] = words::<6>(content)?.map(f64::from_bits);
            Some(Call::ExternalLoad([a, b, c], [d, e, f]))
        }
        Kind::Motion => numbers(room).map(|all| all.split_at(all.len() / 2)).map(|(x, v)| Call::Motion(x, v)),
        Kind::LargestStretch => numbers(room).map(Call::LargestStretch),
        Kind::Load => Some(Call::Load(content)),
        Kind::Reset => Some(Call::Reset),
        _ => None,
    }
}
