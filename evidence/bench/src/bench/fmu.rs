//! What the FMU costs beyond the stepping: doStep, get, and its states; FMI 2.0 and 3.0 through their own
//! functions.
//!
//! Method: a sheet of 5 x 5 nodes that nothing touches and one internal step a call, so that next to nothing
//! is stepped; the kernel's own time for the same step is taken off. States are those of the default scene,
//! 350 x 350 nodes.
#![allow(unsafe_code)] // The functions under test are C functions.

use super::Bench;
use crate::Result;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::report::{least, median};
use fabric_fmu::calls::Handle;
use fabric_fmu::instance::Instance;
use fabric_fmu::log::{Log, Logger, Status};
use fabric_fmu::starts::TIME_STEP;
use fabric_fmu::{Input, Output, fmi2, fmi3, table};
use std::ptr;

/// An instance that has begun: of a small sheet, or of the default scene.
fn begun(small: bool, prescribed: bool) -> Result<Box<Instance>> {
    let mut instance = Box::new(Instance::new(Log::new(Logger::Two(None), ptr::null_mut(), c"bench", false)));
    let mut set = |name: &str, element: usize, value: f64| {
        let variable = table::variable(name).ok_or_else(|| format!("the FMU has no {name}"))?;
        instance.set(variable, element, value);
        Result::Ok(())
    };
    if small {
        set("sheet.nodes_x", 0, 5.0)?;
        set("sheet.nodes_y", 0, 5.0)?;
    }
    set("drive", 0, f64::from(u8::from(prescribed)))?;
    [0.0, 0.0, 1.0].into_iter().enumerate().try_for_each(|(k, v)| set("projectile.start.velocity", k, v))?;
    instance.enter_initialization();
    ok(instance.exit_initialization(), "exitInitialization")?;
    Ok(instance)
}

fn ok(status: Status, what: &str) -> Result<()> {
    if status == Status::Ok { Ok(()) } else { Err(format!("{what}: {status:?}").into()) }
}

/// doStep of one internal step, the `number`th, by either version.
fn step(instance: &mut Instance, two: bool, number: u64) -> Status {
    let (t, h) = (number as f64 * TIME_STEP, TIME_STEP);
    let (mut event, mut terminate, mut early, mut last) = (0, 0, 0, 0.0);
    // SAFETY: the instance and what is written live through the call, and nothing else refers to them.
    unsafe {
        let handle = Handle::given(instance);
        if two {
            return fmi2::fmi2DoStep(handle, t, h, 1);
        }
        let [event, terminate, early] = [&mut event, &mut terminate, &mut early].map(|flag| Output::given(flag));
        fmi3::fmi3DoStep(handle, t, h, 1, event, terminate, early, Output::given(&mut last))
    }
}

/// Reads the mean force: one call, three numbers.
fn force(instance: &mut Instance, two: bool, first: u32) -> (Status, [f64; 3]) {
    let references = [first, first + 1, first + 2];
    let mut force = [0.0; 3];
    // SAFETY: as above; arrays are as long as said.
    let status = unsafe {
        let (handle, from, to) =
            (Handle::given(instance), Input::given(references.as_ptr()), Output::given(force.as_mut_ptr()));
        if two { fmi2::fmi2GetReal(handle, from, 3, to) } else { fmi3::fmi3GetFloat64(handle, from, 1, to, 3) }
    };
    (status, force)
}

/// Calls of one round.
const CALLS: u64 = 2000;

/// doStep and get.
pub fn calls(bench: &mut Bench) -> Result<()> {
    let first = table::variable("contact.force_mean").ok_or("the FMU has no force")?.reference;
    for (version, two) in [("FMI 2.0", true), ("FMI 3.0", false)] {
        for (drive, prescribed) in [("free", false), ("prescribed", true)] {
            let (mut steps, mut gets) = (Vec::new(), Vec::new());
            for _ in 0..bench.effort.rounds {
                let mut instance = begun(true, prescribed)?;
                let scene = *instance.kept.parameters.scene();
                let mut buffers = Buffers::of(&scene)?;
                let mut sim = buffers.sim(&scene)?;
                let clock = Clock::start();
                for _ in 0..CALLS {
                    sim.advance(1)?;
                }
                let alone = clock.seconds();
                let clock = Clock::start();
                for number in 0..CALLS {
                    ok(step(&mut instance, two, number), "doStep")?;
                }
                steps.push(1e6 * (clock.seconds() - alone) / CALLS as f64);
                let clock = Clock::start();
                for _ in 0..CALLS {
                    let (status, force) = force(&mut instance, two, first);
                    ok(status, "get")?;
                    std::hint::black_box(force);
                }
                gets.push(1e6 * clock.seconds() / CALLS as f64);
            }
            let report = &mut bench.report;
            report.figure("fmu", format!("{version}, {drive}: doStep beyond stepping"), median(&steps), "us");
            report.figure("fmu", format!("{version}, {drive}: get of a force"), median(&gets), "us");
        }
    }
    Ok(())
}

/// States of the default scene: in memory, and as bytes with a checksum. (FMI 3.0 goes through the same
/// functions.)
pub fn states(bench: &mut Bench) -> Result<()> {
    let mut instance = begun(false, false)?;
    for number in 0..20 {
        ok(step(&mut instance, true, number), "doStep")?;
    }
    let mut times = [const { Vec::new() }; 4];
    let (mut state, mut size) = (ptr::null_mut(), 0);
    for _ in 0..bench.effort.rounds {
        let mut copy = ptr::null_mut();
        // SAFETY: the instance lives and nothing else refers to it; states are its own; the array is as long
        // as said.
        unsafe {
            let mut fmu = || Handle::given(ptr::from_mut(&mut *instance));
            let clock = Clock::start();
            ok(fmi2::fmi2GetFMUstate(fmu(), Output::given(&mut state)), "GetFMUstate")?;
            times[0].push(1e3 * clock.seconds());
            let clock = Clock::start();
            ok(fmi2::fmi2SetFMUstate(fmu(), state), "SetFMUstate")?;
            times[1].push(1e3 * clock.seconds());
            ok(fmi2::fmi2SerializedFMUstateSize(fmu(), state, Output::given(&mut size)), "SerializedFMUstateSize")?;
            let mut bytes = vec![0_u8; size];
            let to = Output::given(bytes.as_mut_ptr());
            let clock = Clock::start();
            ok(fmi2::fmi2SerializeFMUstate(fmu(), state, to, size), "SerializeFMUstate")?;
            times[2].push(1e3 * clock.seconds());
            let from = Input::given(bytes.as_ptr());
            let clock = Clock::start();
            ok(fmi2::fmi2DeSerializeFMUstate(fmu(), from, size, Output::given(&mut copy)), "DeSerializeFMUstate")?;
            times[3].push(1e3 * clock.seconds());
            ok(fmi2::fmi2FreeFMUstate(fmu(), Output::given(&mut copy)), "FreeFMUstate")?;
        }
    }
    // SAFETY: as above.
    let freed = unsafe { fmi2::fmi2FreeFMUstate(Handle::given(&mut *instance), Output::given(&mut state)) };
    ok(freed, "FreeFMUstate")?;
    for (name, times) in ["get", "set", "serialise", "deserialise"].into_iter().zip(&times) {
        bench.report.figure("states", format!("state, 350 x 350: {name}"), least(times), "ms");
    }
    bench.report.figure("states", "state, 350 x 350: size", size as f64 / 1e6, "MB");
    Ok(())
}
