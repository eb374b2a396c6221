//! Writing a capsule: each call when it has been done, and the digest after it at a stride.
//!
//! Method: every record goes to the sink at once, in pieces, so that what a program wrote before it crashed can be replayed.
//! Limit: a refused call has changed nothing and is not written.

use crate::{Call, Check, FORMAT, Kind, MAGIC, numbers_of};
use fabric_kernel::fields::FIELDS;
use fabric_kernel::{Error, Scene, Sim, VERSION};

/// Where a capsule goes.
pub trait Sink {
    /// Takes bytes; false if it cannot. Then the log ends there, and [`Log::is_whole`] is false from there on.
    fn take(&mut self, bytes: &[u8]) -> bool;

    /// Receives the end of a record; false if it could not be kept.
    fn record_ends(&mut self) -> bool {
        true
    }
}

impl<F: FnMut(&[u8]) -> bool> Sink for F {
    fn take(&mut self, bytes: &[u8]) -> bool {
        self(bytes)
    }
}

/// A capsule being written.
pub struct Log<S> {
    sink: S,
    check: Check,
    stride: u64,
    /// Calls since the last digest.
    since: u64,
    whole: bool,
}

/// Does a call, and writes it if a log is kept.
///
/// # Errors
/// Errors of the call.
pub fn run<S: Sink>(log: &mut Option<Log<S>>, sim: &mut Sim<'_>, call: &Call<'_>) -> Result<(), Error> {
    match log {
        Some(log) => log.run(sim, call),
        None => call.apply(sim),
    }
}

impl<S: Sink> Log<S> {
    /// Puts the simulation back to step 0 and begins its capsule. stride: calls from one digest of the state to the next, at least 1; a
    /// digest takes about as long as a step, and a replay can say no closer than that where the first difference is.
    pub fn begin(sim: &mut Sim<'_>, stride: u64, sink: S) -> Log<S> {
        sim.reset();
        let mut log = Log { sink, check: Check::default(), stride: stride.max(1), since: 0, whole: true };
        log.put(&MAGIC.to_le_bytes());
        log.put(&FORMAT.to_le_bytes());
        log.record(Kind::Origin, &[&stride.max(1).to_le_bytes(), VERSION.as_bytes()]);
        log.scene(*sim.scene());
        log.record(Kind::Start, &[&sim.digest().to_le_bytes()]);
        log
    }

    /// Does a call, and writes it.
    ///
    /// # Errors
    /// Errors of the call.
    pub fn run(&mut self, sim: &mut Sim<'_>, call: &Call<'_>) -> Result<(), Error> {
        let result = call.apply(sim);
        // Steps count though they end in a failure; any other call that is refused has changed nothing.
        if result.is_ok() || matches!(call, Call::Advance(_)) {
            self.note(call, sim);
        }
        result
    }

    /// Writes a call that the host has done: steps also if they ended in a failure, with as many as were asked for.
    pub fn note(&mut self, call: &Call<'_>, sim: &Sim<'_>) {
        match call {
            Call::Advance(steps) => {
                let status = sim.failure().map_or(0, |failure| Error::from(failure).code.number());
                let behind = sim.step_count().to_le_bytes();
                self.record(Kind::Advance, &[&steps.to_le_bytes(), &i64::from(status).to_le_bytes(), &behind]);
            }
            Call::Path(path, ahead) => {
                let [first, steps] = [path.first, path.steps].map(u64::to_le_bytes);
                self.record(
                    Kind::Path,
                    &[&first, &steps, numbers_of(&path.end).map(f64::to_le_bytes).as_flattened(), &ahead.to_le_bytes()],
                );
            }
            Call::ExternalLoad(force, torque) => {
                let [force, torque] = [force, torque].map(|vector| vector.map(f64::to_le_bytes));
                self.record(Kind::ExternalLoad, &[force.as_flattened(), torque.as_flattened()]);
            }
            Call::Motion(positions, velocities) => self.numbers(Kind::Motion, [positions, velocities]),
            Call::LargestStretch(stretches) => self.numbers(Kind::LargestStretch, [stretches, &[]]),
            Call::Load(image) => self.record(Kind::Load, &[image]),
            Call::Reset => self.record(Kind::Reset, &[]),
        }
        self.since += 1;
        if self.since >= self.stride {
            self.since = 0;
            self.record(Kind::Digest, &[&sim.digest().to_le_bytes()]);
        }
    }

    /// Writes the digest at the end.
    pub fn end(&mut self, sim: &Sim<'_>) {
        self.record(Kind::End, &[&sim.digest().to_le_bytes()]);
    }

    /// Whether the sink took everything so far.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// The sink, to hand over what it has.
    pub fn sink_mut(&mut self) -> &mut S {
        &mut self.sink
    }

    /// The numbers that the preset does not have.
    #[inline(never)] // A scene takes a kilobyte of stack.
    fn scene(&mut self, mut scene: Scene) {
        let mut preset = Scene::sheet_3in_sphere();
        for field in FIELDS {
            let elements = 0..field.size();
            if elements.clone().all(|element| field.word(&mut scene, element) == field.word(&mut preset, element)) {
                continue;
            }
            self.head(Kind::Number, 1 + field.name.len() + 8 * field.size());
            self.put(&[field.name.len() as u8]);
            self.put(field.name.as_bytes());
            elements.for_each(|element| self.put(&field.word(&mut scene, element).to_le_bytes()));
            self.close();
        }
    }

    fn numbers(&mut self, kind: Kind, arrays: [&[f64]; 2]) {
        self.head(kind, 8 * arrays.map(<[f64]>::len).iter().sum::<usize>());
        arrays.iter().copied().flatten().for_each(|number| self.put(&number.to_le_bytes()));
        self.close();
    }

    fn record(&mut self, kind: Kind, pieces: &[&[u8]]) {
        self.head(kind, pieces.iter().map(|piece| piece.len()).sum());
        pieces.iter().for_each(|piece| self.put(piece));
        self.close();
    }

    fn head(&mut self, kind: Kind, length: usize) {
        // An array that no such length can say is longer than any sheet's: it would end the log.
        self.whole &= u32::try_from(length).is_ok();
        let [a, b, c, d] = (length as u32).to_le_bytes();
        self.put(&[kind as u8, a, b, c, d]);
    }

    fn close(&mut self) {
        let check = self.check.0.value().to_le_bytes();
        self.whole = self.whole && self.sink.take(&check) && self.sink.record_ends();
    }

    fn put(&mut self, bytes: &[u8]) {
        self.check.take(bytes);
        self.whole = self.whole && self.sink.take(bytes);
    }
}
