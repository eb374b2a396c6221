//! What the FMU costs beyond the stepping: doStep, get, and its states; FMI 2.0 and 3.0 through their own functions.
//!
//! Method: a sheet of 5 x 5 nodes that nothing touches and one internal step a call, so that next to nothing is stepped; the
//! kernel's own time for the same step is taken off. States are those of the default scene, 350 x 350 nodes.
#![allow(unsafe_code)] // The functions under test are C functions.

use super::rows::Report;
use super::sheets::Effort;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report as statistics};
use fabric_fmu::calls::{Handle, Text};
use fabric_fmu::instance::Instance;
use fabric_fmu::kept::Saved;
use fabric_fmu::log::Status;
use fabric_fmu::starts::TIME_STEP;
use fabric_fmu::table;
use fabric_fmu::{Input, Output, fmi2, fmi3};
use std::ffi::{CString, c_void};
use std::ptr;

/// The two versions of the interface.
#[derive(Clone, Copy, PartialEq)]
enum Version {
    Two,
    Three,
}

impl Version {
    fn name(self) -> &'static str {
        match self {
            Version::Two => "FMI 2.0",
            Version::Three => "FMI 3.0",
        }
    }
}

/// An instance, freed when dropped.
struct Fmu {
    version: Version,
    place: *mut Instance,
}

/// A host's pointer to an instance.
///
/// # Safety
/// As of [`Handle::given`].
unsafe fn at(instance: *mut Instance) -> Handle {
    // SAFETY: the caller's promise.
    unsafe { Handle::given(instance) }
}

/// A host's pointer to what is read.
///
/// # Safety
/// As of [`Input::given`].
unsafe fn from<T>(start: *const T) -> Input<T> {
    // SAFETY: the caller's promise.
    unsafe { Input::given(start) }
}

/// A host's pointer to what is written.
///
/// # Safety
/// As of [`Output::given`].
unsafe fn to<T>(start: *mut T) -> Output<T> {
    // SAFETY: the caller's promise.
    unsafe { Output::given(start) }
}

fn reference(name: &str) -> u32 {
    table::variable(name).map_or(u32::MAX, |variable| variable.reference)
}

fn ok(status: Status, what: &str) -> Result<()> {
    if status == Status::Ok { Ok(()) } else { Err(format!("{what}: {status:?}").into()) }
}

impl Fmu {
    /// A running instance; `nodes` per side, or the default scene.
    fn new(version: Version, nodes: Option<i32>, prescribed: bool) -> Result<Fmu> {
        let token = CString::new(fabric_fmu::token::text(
            fabric_fmu::starts::NAME,
            fabric_fmu::parameters::Parameters::default(),
        ))?;
        let name = c"bench";
        // SAFETY: texts end with a zero and live through the call; the callbacks are five null pointers, as the struct has.
        let place = unsafe {
            match version {
                Version::Two => {
                    let none: [*const c_void; 5] = [ptr::null(); 5];
                    let callbacks = none.as_ptr().cast();
                    fmi2::fmi2Instantiate(
                        Text::given(name.as_ptr()),
                        1,
                        Text::given(token.as_ptr()),
                        ptr::null(),
                        from(callbacks),
                        0,
                        0,
                    )
                }
                Version::Three => fmi3::fmi3InstantiateCoSimulation(
                    Text::given(name.as_ptr()),
                    Text::given(token.as_ptr()),
                    ptr::null(),
                    0,
                    0,
                    0,
                    0,
                    ptr::null(),
                    0,
                    ptr::null_mut(),
                    None,
                    ptr::null(),
                ),
            }
        };
        if place.is_null() {
            return Err("the FMU cannot be instantiated".into());
        }
        let fmu = Fmu { version, place };
        let mut integers = Vec::new();
        if let Some(nodes) = nodes {
            integers.extend([("sheet.nodes_x", nodes), ("sheet.nodes_y", nodes)]);
        }
        let (references, values): (Vec<u32>, Vec<i32>) = integers.iter().map(|&(name, n)| (reference(name), n)).unzip();
        let (drive, driven) = (reference("drive"), i32::from(prescribed));
        let velocity: Vec<u32> = (0..3).map(|k| reference("projectile.start.velocity") + k).collect();
        let slow = [0.0, 0.0, 1.0];
        let count = references.len();
        // SAFETY: the instance lives; arrays are as long as said.
        unsafe {
            match version {
                Version::Two => {
                    ok(
                        fmi2::fmi2SetInteger(at(place), from(references.as_ptr()), count, from(values.as_ptr())),
                        "SetInteger",
                    )?;
                    ok(fmi2::fmi2SetInteger(at(place), from(&drive), 1, from(&driven)), "SetInteger")?;
                    ok(fmi2::fmi2SetReal(at(place), from(velocity.as_ptr()), 3, from(slow.as_ptr())), "SetReal")?;
                    ok(fmi2::fmi2SetupExperiment(at(place), 0, 0.0, 0.0, 0, 0.0), "SetupExperiment")?;
                    ok(fmi2::fmi2EnterInitializationMode(at(place)), "EnterInitializationMode")?;
                    ok(fmi2::fmi2ExitInitializationMode(at(place)), "ExitInitializationMode")?;
                }
                Version::Three => {
                    let wide = i64::from(driven);
                    ok(
                        fmi3::fmi3SetInt32(at(place), from(references.as_ptr()), count, from(values.as_ptr()), count),
                        "SetInt32",
                    )?;
                    ok(fmi3::fmi3SetInt64(at(place), from(&drive), 1, from(&wide), 1), "SetInt64")?;
                    ok(
                        fmi3::fmi3SetFloat64(at(place), from(velocity.as_ptr()), 1, from(slow.as_ptr()), 3),
                        "SetFloat64",
                    )?;
                    ok(fmi3::fmi3EnterInitializationMode(at(place), 0, 0.0, 0.0, 0, 0.0), "EnterInitializationMode")?;
                    ok(fmi3::fmi3ExitInitializationMode(at(place)), "ExitInitializationMode")?;
                }
            }
        }
        Ok(fmu)
    }

    /// doStep of one internal step, the `number`th.
    fn step(&self, number: u64) -> Status {
        let (t, h) = (number as f64 * TIME_STEP, TIME_STEP);
        let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, 0.0);
        // SAFETY: the instance lives.
        unsafe {
            match self.version {
                Version::Two => fmi2::fmi2DoStep(at(self.place), t, h, 1),
                Version::Three => fmi3::fmi3DoStep(
                    at(self.place),
                    t,
                    h,
                    1,
                    to(&mut event),
                    to(&mut terminate),
                    to(&mut early),
                    to(&mut last),
                ),
            }
        }
    }

    /// Reads the mean force: one call, three numbers.
    fn force(&self) -> (Status, [f64; 3]) {
        let first = reference("contact.force_mean");
        let references = [first, first + 1, first + 2];
        let mut force = [0.0; 3];
        // SAFETY: the instance lives; arrays are as long as said.
        let status = unsafe {
            match self.version {
                Version::Two => fmi2::fmi2GetReal(at(self.place), from(references.as_ptr()), 3, to(force.as_mut_ptr())),
                Version::Three => {
                    fmi3::fmi3GetFloat64(at(self.place), from(references.as_ptr()), 1, to(force.as_mut_ptr()), 3)
                }
            }
        };
        (status, force)
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: made by `new`, freed once. Both versions free alike.
        unsafe { fmi2::fmi2FreeInstance(at(self.place)) }
    }
}

/// Calls of one round.
const CALLS: u64 = 2000;

/// doStep and get.
pub fn calls(effort: Effort, progress: &Progress, report: &mut Report) -> Result<()> {
    for version in [Version::Two, Version::Three] {
        for (drive, prescribed) in [("free", false), ("prescribed", true)] {
            let (mut steps, mut gets) = (Vec::new(), Vec::new());
            for _ in 0..effort.rounds {
                let fmu = Fmu::new(version, Some(5), prescribed)?;
                // SAFETY: the instance lives; nothing else refers to it meanwhile.
                let scene = unsafe { *(*fmu.place).kept.parameters.scene() };
                let mut buffers = Buffers::of(&scene)?;
                let mut sim = buffers.sim(&scene)?;
                let clock = Clock::start();
                for _ in 0..CALLS {
                    sim.advance(1)?;
                }
                let alone = clock.seconds();
                let clock = Clock::start();
                for number in 0..CALLS {
                    ok(fmu.step(number), "doStep")?;
                }
                steps.push(1e6 * (clock.seconds() - alone) / CALLS as f64);
                let clock = Clock::start();
                for _ in 0..CALLS {
                    let (status, force) = fmu.force();
                    ok(status, "get")?;
                    std::hint::black_box(force);
                }
                gets.push(1e6 * clock.seconds() / CALLS as f64);
                progress.add(1, || format!("fmu {drive}"));
            }
            let name = version.name();
            report.figure("fmu", format!("{name}, {drive}: doStep beyond stepping"), statistics::median(&steps), "us");
            report.figure("fmu", format!("{name}, {drive}: get of a force"), statistics::median(&gets), "us");
        }
    }
    Ok(())
}

/// States of the default scene: in memory, and as bytes with a checksum. (FMI 3.0 goes through the same functions.)
pub fn states(effort: Effort, progress: &Progress, report: &mut Report) -> Result<()> {
    let fmu = Fmu::new(Version::Two, None, false)?;
    for number in 0..20 {
        ok(fmu.step(number), "doStep")?;
    }
    let mut times = [const { Vec::new() }; 4];
    let mut state: *mut Saved = ptr::null_mut();
    let mut size = 0;
    for _ in 0..effort.rounds {
        let mut copy: *mut Saved = ptr::null_mut();
        // SAFETY: the instance lives; states are its own; the array is as long as said.
        unsafe {
            let clock = Clock::start();
            ok(fmi2::fmi2GetFMUstate(at(fmu.place), to(&mut state)), "GetFMUstate")?;
            times[0].push(1e3 * clock.seconds());
            let clock = Clock::start();
            ok(fmi2::fmi2SetFMUstate(at(fmu.place), state), "SetFMUstate")?;
            times[1].push(1e3 * clock.seconds());
            ok(fmi2::fmi2SerializedFMUstateSize(at(fmu.place), state, to(&mut size)), "SerializedFMUstateSize")?;
            let mut bytes = vec![0_u8; size];
            let clock = Clock::start();
            ok(fmi2::fmi2SerializeFMUstate(at(fmu.place), state, to(bytes.as_mut_ptr()), size), "SerializeFMUstate")?;
            times[2].push(1e3 * clock.seconds());
            let clock = Clock::start();
            ok(
                fmi2::fmi2DeSerializeFMUstate(at(fmu.place), from(bytes.as_ptr()), size, to(&mut copy)),
                "DeSerializeFMUstate",
            )?;
            times[3].push(1e3 * clock.seconds());
            ok(fmi2::fmi2FreeFMUstate(at(fmu.place), to(&mut copy)), "FreeFMUstate")?;
        }
        progress.add(1, || "fmu states".to_string());
    }
    // SAFETY: as above.
    unsafe { ok(fmi2::fmi2FreeFMUstate(at(fmu.place), to(&mut state)), "FreeFMUstate")? };
    for (name, times) in ["get", "set", "serialise", "deserialise"].into_iter().zip(&times) {
        report.figure("states", format!("state, 350 x 350: {name}"), statistics::least(times), "ms");
    }
    report.figure("states", "state, 350 x 350: size", size as f64 / 1e6, "MB");
    Ok(())
}
