//! A capsule done again: same bits, or where the first difference is.

use crate::Result;
use crate::memory::Buffers;
use fabric_capsule::{Broken, Capsule, Replay, Seen, What};

/// Steps between two looks at the progress.
const STRIDE: u64 = 64;

/// What a replay found.
pub struct Found {
    /// Version of the kernel that wrote the capsule.
    pub version: String,
    /// Calls done, the step count after them, and digests found equal.
    pub calls: u64,
    /// See `calls`.
    pub step: u64,
    /// See `calls`.
    pub digests: u64,
    /// Digest of the state at the end.
    pub digest: u64,
    /// Whether the capsule was ended by its program.
    pub ended: bool,
    /// The first difference, in words; None: same bits.
    pub difference: Option<String>,
    /// Where the capsule is cut off: what is whole before it was replayed.
    pub cut: Option<Broken>,
}

/// Replays a capsule, or the log of an FMU's host with one. `look` sees the steps taken, those of all calls,
/// and where it stands; false ends the replay there.
///
/// # Errors
/// Bytes that are no capsule, a scene that is refused or takes too much memory, the end by `look`.
pub fn replay(bytes: &[u8], mut look: impl FnMut(u64, u64, &str) -> bool) -> Result<Found> {
    let of_log = from_log(bytes);
    let bytes = of_log.as_deref().unwrap_or(bytes);
    let (capsule, cut) = match Capsule::open(bytes) {
        Ok(capsule) => (capsule, None),
        // What a crash left.
        Err(broken) => match bytes.get(..broken.whole).map(Capsule::open) {
            Some(Ok(capsule)) if broken.what == What::Truncated => (capsule, Some(broken)),
            _ => return Err(broken.into()),
        },
    };
    let scene = capsule.scene().map_err(|_| "the capsule's scene has a number that this version does not know")?;
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let (mut replay, mut room) = (Replay::default(), vec![0.0; capsule.room()]);
    let difference = loop {
        match replay.next(&capsule, &mut sim, &mut room, STRIDE) {
            Ok(Seen::More) => {
                if !look(replay.steps, capsule.steps, &format!("call {}, step {}", replay.calls, sim.step_count())) {
                    return Err("stopped".into());
                }
            }
            Ok(Seen::Same) => break None,
            Err(difference) => break Some(difference),
        }
    };
    let (calls, step) = (replay.calls, sim.step_count());
    let difference = difference.map(|difference| {
        let (call, at) = (replay.equal_calls, replay.equal_step);
        let before = match replay.digests {
            0 => "the simulations are not alike from the start: another build, or another scene".to_string(),
            _ => format!("the states were last found equal behind call {call}, at step {at}"),
        };
        format!("differs at call {calls}, step {step}: {difference}; {before}")
    });
    let (version, digest) = (capsule.version.to_string(), sim.digest());
    Ok(Found { version, calls, step, digests: replay.digests, digest, ended: capsule.ended, difference, cut })
}

/// The last capsule in the log of an FMU's host, lines that hold "capsule: " and hexadecimal digits; None if
/// there is none.
fn from_log(bytes: &[u8]) -> Option<Vec<u8>> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut found = Vec::new();
    for line in text.lines().filter_map(|line| line.split_once("capsule: ")) {
        let (pairs, _) = line.1.as_bytes().as_chunks::<2>();
        let piece: Vec<u8> = pairs.iter().map_while(|pair| byte_of(*pair)).collect();
        if piece.starts_with(b"FKCAPSUL") {
            found.clear();
        }
        found.extend(piece);
    }
    (!found.is_empty()).then_some(found)
}

/// The byte of two hexadecimal digits.
fn byte_of(digits: [u8; 2]) -> Option<u8> {
    let [high, low] = digits.map(|digit| char::from(digit).to_digit(16));
    Some((16 * high? + low?) as u8)
}
