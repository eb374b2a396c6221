//! Calls of FMI 2.0 and 3.0 in any order with odd numbers, against the standard's state machine.
//!
//! `tests/fmi/calls/states.inc` has the answer to each call in each state. A call that is refused, or that
//! has a bad number, returns Error (a step with bad inputs: Discard) and changes nothing: the bytes of the
//! serialised state before and after are equal. A state that is restored gives the bytes it was saved with.
//! Wrong pointers, lengths and types are tried in
//! `tests/fmi/calls`.

use crate::bytes::Bytes;
use crate::image::forge;
use crate::memory::{from, into, to};
use fabric_fmu::calls::{Handle, Text};
use fabric_fmu::fmi2::*;
use fabric_fmu::fmi3::*;
use fabric_fmu::instance::Instance;
use fabric_fmu::kept::Saved;
use fabric_fmu::log::Status;
use fabric_fmu::operations::exported::*;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::table::{self, Id, Kind, MOST_ELEMENTS, Role, VARIABLES, Variable};
use fabric_fmu::{Input, Output};
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

/// Most calls of one input.
const MOST_CALLS: usize = 24;
/// Most states a host holds.
const MOST_STATES: usize = 4;
/// Internal step of the sheets here, s.
const DT: f64 = 2e-8;

const OK: Status = Status::Ok;
const DISCARD: Status = Status::Discard;
const ERROR: Status = Status::Error;

/// States: columns of the table of answers.
const INSTANTIATED: usize = 0;
const INITIALIZATION: usize = 1;
const EVENT: usize = 2;
const STEP: usize = 3;
const TERMINATED: usize = 5;
const FAILED: usize = 6;

/// What the model knows of an instance; saved and restored with its states.
#[derive(Clone, Copy)]
struct Known {
    state: usize,
    start: f64,
    stop: f64,
    time: f64,
}

/// A state that the host holds.
#[derive(Clone)]
struct Held {
    pointer: *mut Saved,
    known: Known,
    /// Serialised. Not of a forged one, which need not be restored.
    bytes: Vec<u8>,
    forged: bool,
}

/// Functions that the two versions have alike.
type Plain = unsafe extern "C" fn(Handle) -> Status;
type Freeing = unsafe extern "C" fn(Handle);
type ToState = unsafe extern "C" fn(Handle, *mut Saved) -> Status;
type OfState = unsafe extern "C" fn(Handle, Output<*mut Saved>) -> Status;
type ToBytes = unsafe extern "C" fn(Handle, *mut Saved, Output<u8>, usize) -> Status;
type OfBytes = unsafe extern "C" fn(Handle, Input<u8>, usize, Output<*mut Saved>) -> Status;

struct Host<'d> {
    bytes: Bytes<'d>,
    three: bool,
    events: bool,
    early: bool,
    instance: *mut Instance,
    known: Known,
    held: Vec<Held>,
    stepped: bool,
}

/// The target.
pub fn run(data: &[u8]) -> bool {
    let mut bytes = Bytes::new(data);
    let kind = bytes.byte();
    let known = Known { state: INSTANTIATED, start: 0.0, stop: f64::INFINITY, time: 0.0 };
    let mut host = Host {
        bytes,
        three: kind & 1 == 1,
        events: kind & 2 == 2,
        early: kind & 4 == 4,
        instance: null_mut(),
        known,
        held: Vec::new(),
        stepped: false,
    };
    host.instantiate();
    // Most inputs are about what comes after.
    if kind & 24 != 0 {
        host.begin_soundly();
    }
    let mut before = host.image();
    for _ in 0..MOST_CALLS {
        if host.bytes.is_empty() {
            break;
        }
        let changes = host.call();
        let after = host.image();
        assert!(changes || before == after, "a call that was refused, or only reads, has changed the state");
        before = after;
    }
    // SAFETY: the instance is not used again.
    unsafe { host.free() };
    host.stepped
}

/// The variable of a name.
fn named(name: &str) -> &'static Variable {
    table::variable(name).unwrap_or(&VARIABLES[0])
}

/// The host's logger of FMI 3.0. Only the FMU calls it.
extern "C" fn logger(environment: *mut c_void, status: c_int, category: *const c_char, message: *const c_char) {
    assert!(environment.is_null() && (0..=4).contains(&status) && !category.is_null() && !message.is_null());
    // SAFETY: a text that ends with a zero.
    assert!(unsafe { std::ffi::CStr::from_ptr(message) }.to_bytes().len() > 3);
}

impl Host<'_> {
    /// Whether the table of answers allows a function in the present state.
    fn allowed(&self, function: &str) -> bool {
        let starts = ["BOTH", self.of("FMI2", "FMI3")].map(|version| format!("{version}({function}, \""));
        let mut rows = include_str!("../../fmi/calls/states.inc").lines();
        let answers = rows.find_map(|row| starts.iter().find_map(|start| row.strip_prefix(start.as_str())));
        answers.expect("a row of the table").as_bytes()[2 * self.known.state] == b'+'
    }

    /// The instance, as the host names it.
    fn c(&self) -> Handle {
        // SAFETY: a live instance, used by one call at a time.
        unsafe { Handle::given(self.instance) }
    }

    /// The function of this instance's version.
    fn of<F>(&self, two: F, three: F) -> F {
        if self.three { three } else { two }
    }

    /// The status of a call: Ok where it is allowed and has sound arguments, else Error.
    fn expected(&self, function: &str, sound: bool) -> Status {
        if sound && self.allowed(function) { OK } else { ERROR }
    }

    // ---- Life ---------------------------------------------------------------------------------------------

    /// A new instance, with a small sheet.
    fn instantiate(&mut self) {
        let token = fabric_fmu::token::text(fabric_fmu::starts::Starts::own().token);
        let token = CString::new(token.to_vec()).unwrap_or_default();
        let (events, early) = (u8::from(self.events), u8::from(self.early));
        // FMI 2.0's functions: no logger, whose arguments vary, and nothing else that is used.
        let callbacks = [null_mut::<c_void>(); 5];
        // SAFETY: texts that end with a zero; five pointers are the callbacks' structure.
        self.instance = unsafe {
            let (name, id) = (Text::given(c"fuzz".as_ptr()), Text::given(token.as_ptr()));
            match self.three {
                #[rustfmt::skip]
                true => fmi3InstantiateCoSimulation(
                    name, id, null(), 0, 1, events, early, null(), 0, null_mut(), Some(logger), null(),
                ),
                false => fmi2Instantiate(name, 1, id, null(), Input::given(callbacks.as_ptr().cast()), 0, 1),
            }
        };
        assert!(!self.instance.is_null());
        self.make_small();
    }

    /// # Safety
    /// The instance is not used again.
    unsafe fn free(&mut self) {
        // SAFETY: the caller's promise.
        unsafe { self.of::<Freeing>(fmi2FreeInstance, fmi3FreeInstance)(self.c()) };
        self.held.clear();
    }

    /// Few nodes, drive, step: all that must be right for a run to be short.
    fn make_small(&mut self) {
        self.known = Known { state: INSTANTIATED, start: 0.0, stop: f64::INFINITY, time: 0.0 };
        let nodes = [3 + self.bytes.below(4) as i32, 3 + self.bytes.below(4) as i32];
        let driven = self.bytes.once_in(2);
        for (name, value) in [("sheet.nodes_x", nodes[0]), ("sheet.nodes_y", nodes[1]), ("drive", i32::from(driven))] {
            assert_eq!(self.set(named(name), &[f64::from(value)]), OK);
        }
        let touching = [0.0, 0.0, -1.905_01e-2];
        assert_eq!(self.set(named("projectile.start.position"), &touching), OK);
    }

    /// From instantiation to the first step.
    fn begin_soundly(&mut self) {
        let status = self.setup(0.0, Some(1e-3));
        assert_eq!(status, OK);
        assert_eq!(self.enter(), OK);
        let status = self.exit();
        assert_eq!(status, OK);
        if self.three && self.events {
            // SAFETY: a live instance.
            assert_eq!(unsafe { fmi3EnterStepMode(self.c()) }, OK);
            self.known.state = STEP;
        }
    }

    fn setup(&mut self, start: f64, stop: Option<f64>) -> Status {
        let sound = start.is_finite() && stop.is_none_or(|stop| stop.is_finite() && stop >= start);
        let expected = self.expected(self.of("SetupExperiment", "EnterInitializationMode"), sound);
        // SAFETY: a live instance.
        let status = unsafe {
            let (given, end) = (stop.is_some(), stop.unwrap_or(0.0));
            if self.three {
                fmi3EnterInitializationMode(self.c(), 0, 0.0, start, u8::from(given), end)
            } else {
                fmi2SetupExperiment(self.c(), 0, 0.0, start, c_int::from(given), end)
            }
        };
        assert_eq!(status, expected);
        if status == OK {
            (self.known.start, self.known.time, self.known.stop) = (start, start, stop.unwrap_or(f64::INFINITY));
            if self.three {
                self.known.state = INITIALIZATION;
            }
        }
        status
    }

    fn enter(&mut self) -> Status {
        if self.three {
            return OK; // done with the times
        }
        // SAFETY: a live instance.
        let status = unsafe { fmi2EnterInitializationMode(self.c()) };
        assert_eq!(status, self.expected("EnterInitializationMode", true));
        if status == OK {
            self.known.state = INITIALIZATION;
        }
        status
    }

    fn exit(&mut self) -> Status {
        // SAFETY: a live instance.
        let status = unsafe { self.of::<Plain>(fmi2ExitInitializationMode, fmi3ExitInitializationMode)(self.c()) };
        if !self.allowed("ExitInitializationMode") {
            assert_eq!(status, ERROR);
        }
        // With parameters that the kernel refuses the host may try again.
        assert!([OK, ERROR].contains(&status));
        if status != ERROR {
            self.known.state = if self.three && self.events { EVENT } else { STEP };
        }
        status
    }

    // ---- Calls --------------------------------------------------------------------------------------------

    /// One call. Whether it may have changed the state.
    fn call(&mut self) -> bool {
        match self.bytes.below(27) {
            0..8 => self.do_step(),
            8..12 => self.set_any(),
            12..14 => self.get_any(),
            14 => self.save(),
            15 => self.restore(),
            16 => self.free_state(),
            17 => self.serialise(),
            18 => self.deserialise(),
            19 => {
                let start = if self.bytes.once_in(2) { self.bytes.odd(1e-3) } else { 0.0 };
                let stop = if self.bytes.once_in(2) { Some(self.bytes.odd(1e-3)) } else { None };
                self.setup(start, stop) == OK
            }
            20 => self.enter() == OK,
            21 => self.exit() != ERROR,
            22 => {
                self.modes();
                true
            }
            23 => {
                let expected = self.expected("Terminate", true);
                // SAFETY: a live instance.
                assert_eq!(unsafe { self.of::<Plain>(fmi2Terminate, fmi3Terminate)(self.c()) }, expected);
                if expected == OK {
                    self.known.state = TERMINATED;
                }
                expected == OK
            }
            24 => {
                // SAFETY: a live instance.
                assert_eq!(unsafe { self.of::<Plain>(fmi2Reset, fmi3Reset)(self.c()) }, OK);
                self.make_small();
                if self.bytes.once_in(2) {
                    self.begin_soundly();
                }
                true
            }
            25 => {
                // SAFETY: the instance is not used again.
                unsafe { self.free() };
                self.instantiate();
                true
            }
            _ => self.steer(),
        }
    }

    fn do_step(&mut self) -> bool {
        let Known { time, stop, .. } = self.known;
        let (mut t, mut h) = (time, DT * f64::from(self.bytes.byte() % 24 + 1) * 0.5);
        if self.bytes.once_in(16) {
            h = 70.0 * DT;
        }
        if self.bytes.once_in(8) {
            match self.bytes.below(4) {
                0 => t = self.bytes.odd(t),
                1 => t += h * self.bytes.choose(&[-1.0, 1.0, 1e-4, -1e-4, 0.1]),
                2 => h = self.bytes.choose(&[0.0, -h, f64::NAN, f64::INFINITY, -0.0, f64::NEG_INFINITY, f64::MAX]),
                _ => h = 2.0 * (stop - t),
            }
        }
        // The host may be off by a thousandth of its step, and by rounding; a step that rounding swallows is
        // none.
        let slack = 1e-3 * h + 4.0 * f64::EPSILON * t.abs();
        let sound = t.is_finite()
            && h.is_finite()
            && h > 0.0
            && t + h != t
            && (t - time).abs() <= slack
            && t + h <= stop + slack;
        if sound && (h > 200.0 * DT || t + h - time > 200.0 * DT) {
            return false; // longer steps are sound, and take as long as asked for
        }
        let (mut flags, mut reached) = ([7; 3], 7.5);
        // SAFETY: a live instance, and numbers.
        let status = unsafe {
            if self.three {
                let [event, terminate, early] = &mut flags;
                fmi3DoStep(self.c(), t, h, 0, into(event), into(terminate), into(early), into(&mut reached))
            } else {
                fmi2DoStep(self.c(), t, h, 1)
            }
        };
        if !(sound && self.allowed("DoStep")) {
            assert_eq!(status, ERROR, "a step that is not possible");
            return false;
        }
        if status == ERROR && self.faulted() {
            self.known.state = FAILED;
            return true;
        }
        assert_ne!(status, ERROR, "a possible step refused");
        if !self.three {
            // SAFETY: a live instance, and a number.
            assert_eq!(unsafe { fmi2GetRealStatus(self.c(), 2, into(&mut reached)) }, OK);
        }
        // A discarded step has not moved time; in FMI 2.0 one that ended the simulation has.
        let stopped = status == DISCARD && reached != time;
        if status == DISCARD && !stopped {
            return false;
        }
        assert!(stopped <= !self.three && [OK, DISCARD].contains(&status));
        let [event, terminate, early] = flags;
        if self.three {
            assert!(event <= u8::from(self.events) && terminate <= 1 && early <= u8::from(self.early));
        }
        let ended_early = early == 1 || stopped;
        assert!(if ended_early { reached <= t + h + DT } else { reached == t + h }, "where the step ended");
        self.known.time = reached;
        self.stepped = true;
        true
    }

    /// Whether the simulation has failed: then no state can be saved.
    fn faulted(&self) -> bool {
        let mut state = null_mut();
        // SAFETY: a live instance; the state is freed at once.
        unsafe {
            let status = fmi2GetFMUstate(self.c(), into(&mut state));
            if status == OK {
                fmi2FreeFMUstate(self.c(), into(&mut state));
            }
            status == ERROR
        }
    }

    /// Moves the body's given pose to where the simulation has it, as a host does that moves it.
    fn steer(&mut self) -> bool {
        if self.known.state != STEP {
            return false;
        }
        for name in ["position", "velocity"] {
            let mut values = [0.0; 3];
            assert_eq!(self.get(named(&format!("state.{name}")), &mut values), OK);
            assert_eq!(self.set(named(&format!("projectile.{name}")), &values), OK);
        }
        true
    }

    /// Sets a whole variable with the functions of its type.
    fn set(&mut self, variable: &Variable, values: &[f64]) -> Status {
        let (first, n) = (variable.reference, values.len());
        let integers: Vec<i32> = values.iter().map(|x| *x as i32).collect();
        let longs: Vec<i64> = values.iter().map(|x| *x as i64).collect();
        let truths: Vec<u8> = values.iter().map(|x| u8::from(*x != 0.0)).collect();
        let references: Vec<u32> = (first..first + n.max(1) as u32).collect();
        // SAFETY: a live instance, and arrays of the lengths said, or longer.
        unsafe {
            let (c, one, all) = (self.c(), from(&references), from(&references));
            match (self.three, variable.kind) {
                (true, Kind::Real) => fmi3SetFloat64(c, one, 1, from(values), n),
                (true, Kind::Integer) => fmi3SetInt32(c, one, 1, from(&integers), n),
                (true, Kind::Choice(_)) => fmi3SetInt64(c, one, 1, from(&longs), n),
                (true, Kind::Boolean) => fmi3SetBoolean(c, one, 1, from(&truths), n),
                (false, Kind::Real) => fmi2SetReal(c, all, n, from(values)),
                (false, Kind::Integer | Kind::Choice(_)) => fmi2SetInteger(c, all, n, from(&integers)),
                (false, Kind::Boolean) => fmi2SetBoolean(c, all, n, from(&integers)),
            }
        }
    }

    /// Any variable, to a value that is usual or odd.
    fn set_any(&mut self) -> bool {
        let variable = &VARIABLES[self.bytes.below(VARIABLES.len())];
        let mut values = [1.0; MOST_ELEMENTS];
        let n = variable.size();
        Parameters::default().get(variable, &mut values);
        for value in values.iter_mut().take(n) {
            let usual = *value;
            *value = match variable.kind {
                Kind::Real if self.bytes.once_in(3) => self.bytes.odd(usual),
                Kind::Real => usual * self.bytes.factor(),
                _ => f64::from(self.bytes.choose(&[0, 1, 2, 3, 4, 5, -1, i32::MAX, i32::MIN])),
            };
        }
        match variable.name {
            // More nodes are sound, and take as long as asked for.
            "sheet.nodes_x" | "sheet.nodes_y" => {
                values[0] = f64::from(self.bytes.choose(&[4, 3, 5, 0, 1, -1, 1 << 21, i32::MAX]))
            }
            "time_step.seconds" => {
                values[0] = self.bytes.choose(&[DT, DT, 0.0, -1.0, f64::NAN, f64::INFINITY, 1.0, 1e-300])
            }
            _ => {}
        }
        let function = match variable.role {
            Role::Fixed => Some("SetParameter"),
            Role::Input | Role::Tunable => Some("SetInput"),
            Role::Continuous | Role::Discrete => None,
        };
        let truth = variable.kind == Kind::Boolean;
        let sound = values.iter().take(n).all(|x| truth || Parameters::acceptable(variable, *x));
        let status = self.set(variable, &values[..n]);
        let expected = function.map_or(ERROR, |function| self.expected(function, sound));
        assert_eq!(status, expected, "{}", variable.name);
        status == OK
    }

    /// Reads a whole variable with the functions of its type.
    fn get(&mut self, variable: &Variable, values: &mut [f64]) -> Status {
        let (first, n) = (variable.reference, values.len());
        let (mut integers, mut longs, mut truths) = (vec![0_i32; n], vec![0_i64; n], vec![0_u8; n]);
        let references: Vec<u32> = (first..first + n as u32).collect();
        // SAFETY: a live instance, and arrays of the lengths said, or longer.
        unsafe {
            let (c, one, all) = (self.c(), from(&references), from(&references));
            match (self.three, variable.kind) {
                (true, Kind::Real) => fmi3GetFloat64(c, one, 1, to(values), n),
                (true, Kind::Integer) => fmi3GetInt32(c, one, 1, to(&mut integers), n),
                (true, Kind::Choice(_)) => fmi3GetInt64(c, one, 1, to(&mut longs), n),
                (true, Kind::Boolean) => fmi3GetBoolean(c, one, 1, to(&mut truths), n),
                (false, Kind::Real) => fmi2GetReal(c, all, n, to(values)),
                (false, Kind::Integer | Kind::Choice(_)) => fmi2GetInteger(c, all, n, to(&mut integers)),
                (false, Kind::Boolean) => fmi2GetBoolean(c, all, n, to(&mut integers)),
            }
        }
    }

    /// Any variable.
    fn get_any(&mut self) -> bool {
        let variable = &VARIABLES[self.bytes.below(VARIABLES.len())];
        let status = self.get(variable, &mut vec![0.0; variable.size()]);
        let output = variable.role.is_output();
        let function = if output && variable.id != Id::Status { "GetOutput" } else { "GetInput" };
        let expected = self.expected(function, true);
        // The parameters may be no scene yet.
        let open = output && expected == OK && self.known.state <= INITIALIZATION;
        assert!(status == expected || open && status == ERROR, "{}: {status:?}", variable.name);
        false
    }

    // ---- States -------------------------------------------------------------------------------------------

    /// The serialised state; None of a failed one.
    fn image(&self) -> Option<Vec<u8>> {
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: a live instance, and arrays and numbers of this function.
        unsafe {
            let status = fmi2GetFMUstate(self.c(), into(&mut state));
            assert_eq!(status, self.expected("GetFMUState", true));
            if status == ERROR {
                return None;
            }
            assert_eq!(fmi2SerializedFMUstateSize(self.c(), state, into(&mut size)), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(self.c(), state, to(&mut bytes), size), OK);
            assert_eq!(fmi2FreeFMUstate(self.c(), into(&mut state)), OK);
            assert!(state.is_null());
            Some(bytes)
        }
    }

    fn save(&mut self) -> bool {
        let given = self.bytes.below(8);
        let place = self.bytes.below(self.held.len().max(1));
        let over = given >= 4 && !self.held.is_empty();
        let mut state = if over { self.held[place].pointer } else { null_mut() };
        if !over && self.held.len() >= MOST_STATES {
            return false;
        }
        let expected = self.expected("GetFMUState", true);
        let bytes = self.image();
        // SAFETY: a live instance, and a pointer.
        let status = unsafe { self.of::<OfState>(fmi2GetFMUstate, fmi3GetFMUState)(self.c(), into(&mut state)) };
        assert_eq!(status, expected);
        if expected == OK {
            let held = Held { pointer: state, known: self.known, bytes: bytes.unwrap_or_default(), forged: false };
            if over {
                self.held[place] = held;
            } else {
                self.held.push(held);
            }
        }
        false
    }

    fn restore(&mut self) -> bool {
        let Some(held) = self.held.get(self.bytes.below(self.held.len().max(1))).cloned() else { return false };
        // SAFETY: a live instance, and a state of its own.
        let status = unsafe { self.of::<ToState>(fmi2SetFMUstate, fmi3SetFMUState)(self.c(), held.pointer) };
        assert!(status == OK || (held.forged && status == ERROR), "a state not restored");
        if status == OK {
            self.known = held.known;
            assert!(held.forged || self.image().as_ref() == Some(&held.bytes), "not the state that was saved");
        }
        status == OK
    }

    fn free_state(&mut self) -> bool {
        let place = self.bytes.below(self.held.len().max(1));
        let mut state = if place < self.held.len() { self.held.swap_remove(place).pointer } else { null_mut() };
        // SAFETY: a live instance, and a state of its own or null.
        let status = unsafe { self.of::<OfState>(fmi2FreeFMUstate, fmi3FreeFMUState)(self.c(), into(&mut state)) };
        assert_eq!((status, state.is_null()), (OK, true));
        false
    }

    fn serialise(&mut self) -> bool {
        let Some(held) = self.held.get(self.bytes.below(self.held.len().max(1))) else { return false };
        let mut size = 0;
        // SAFETY: a live instance, a state of its own, and arrays of the lengths said.
        unsafe {
            assert_eq!(fmi2SerializedFMUstateSize(self.c(), held.pointer, into(&mut size)), OK);
            let mut bytes = vec![0; size];
            let status = self.of::<ToBytes>(fmi2SerializeFMUstate, fmi3SerializeFMUState)(
                self.c(),
                held.pointer,
                to(&mut bytes),
                size,
            );
            assert_eq!(status, OK);
            assert!(held.forged || bytes == held.bytes);
        }
        false
    }

    /// Bytes of a state held, as they are, altered, or altered and forged.
    fn deserialise(&mut self) -> bool {
        let Some(held) = self.held.get(self.bytes.below(self.held.len().max(1))).cloned() else { return false };
        if self.held.len() >= MOST_STATES || held.forged {
            return false;
        }
        let mut bytes = held.bytes.clone();
        let (kind, words) = (self.bytes.below(4), bytes.len() / 8);
        match kind {
            1 => {
                let place = self.bytes.word() as usize % bytes.len();
                bytes[place] ^= 1 << self.bytes.below(8);
            }
            2 => {
                let length = self.bytes.word() as usize % bytes.len();
                bytes.truncate(length);
            }
            3 => {
                // The kernel's image alone, at the end: forged parameters are a sound scene, as large as
                // asked for.
                let (places, _) = bytes.as_chunks_mut::<8>();
                let place = words - 2 - (self.bytes.byte() as usize % 200).min(words / 8);
                let old = f64::from_bits(u64::from_le_bytes(places[place]));
                places[place] = self.bytes.odd(old).to_bits().to_le_bytes();
                forge(&mut bytes);
            }
            _ => {}
        }
        let mut state = null_mut();
        // SAFETY: a live instance, and an array of the length said.
        let status = unsafe {
            self.of::<OfBytes>(fmi2DeSerializeFMUstate, fmi3DeserializeFMUState)(
                self.c(),
                from(&bytes),
                bytes.len(),
                into(&mut state),
            )
        };
        let altered = bytes != held.bytes;
        if kind < 3 {
            assert_eq!(status, if altered { ERROR } else { OK });
        }
        if status == OK {
            self.held.push(Held { pointer: state, known: held.known, forged: altered, bytes });
        } else {
            assert!(status == ERROR && state.is_null());
        }
        false
    }

    // ---- The rest -----------------------------------------------------------------------------------------

    /// Into and out of event mode.
    fn modes(&mut self) {
        if !self.three {
            return;
        }
        let kind = self.bytes.below(3);
        let (expected, next) = match kind {
            0 => (self.expected("EnterEventMode", self.events), Some(EVENT)),
            1 => (self.expected("EnterStepMode", true), Some(STEP)),
            _ => (self.expected("UpdateDiscreteStates", true), None),
        };
        let (mut flags, mut time) = ([7; 5], 7.5);
        let [a, b, d, e, f] = &mut flags;
        // SAFETY: a live instance, and numbers.
        let status = unsafe {
            match kind {
                0 => fmi3EnterEventMode(self.c()),
                1 => fmi3EnterStepMode(self.c()),
                _ => fmi3UpdateDiscreteStates(self.c(), into(a), into(b), into(d), into(e), into(f), into(&mut time)),
            }
        };
        assert_eq!(status, expected);
        match next.filter(|_| status == OK) {
            Some(next) => self.known.state = next,
            None => assert!(kind < 2 || (status == OK) == flags.iter().all(|&flag| flag <= 1)),
        }
    }
}
