//! Messages to the host's logger, in both versions. Text only: no number with a fraction is ever formatted.

use crate::table::LOG_CATEGORIES;
use core::ffi::{CStr, c_char, c_int, c_void};

/// Status that a call returns; the same numbers in FMI 2.0 and 3.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, but the numbers may mislead.
    Warning = 1,
    /// Not done, nothing changed; the host may try again with other input.
    Discard = 2,
    /// Refused, or failed.
    Error = 3,
    /// There is no memory for an instance; never returned by a call of one.
    Fatal = 4,
}

/// Kind of a message. The numbers are places in [`LOG_CATEGORIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Something happened.
    Event = 0,
    /// See [`Status::Discard`].
    Discard = 1,
    /// See [`Status::Error`].
    Error = 2,
    /// See [`Status::Fatal`].
    Fatal = 3,
    /// A piece of a capsule.
    Capsule = 4,
    /// See [`Status::Warning`].
    Warning = 5,
}

/// Place of "logAll" in [`LOG_CATEGORIES`].
const ALL: usize = 6;

/// Logger of FMI 2.0: environment, instance name, status, category, format, arguments. A C host vouches for
/// its logger; a Rust host can only give one that is safe with any arguments.
pub type Logger2 = extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);
/// Logger of FMI 3.0: environment, status, category, message. As [`Logger2`].
pub type Logger3 = extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// The host's logger.
#[derive(Clone, Copy)]
pub enum Logger {
    /// FMI 2.0.
    Two(Option<Logger2>),
    /// FMI 3.0.
    Three(Option<Logger3>),
    /// FMI 3.0 without C: instance name, status, category, message.
    Component(fn(&str, Status, &str, &str)),
}

/// One line. What does not fit is cut.
pub type Line = heapless::String<240>;

/// A line of this text.
pub fn line(text: core::fmt::Arguments<'_>) -> Line {
    let mut line = Line::new();
    let _ = core::fmt::Write::write_fmt(&mut line, text);
    line
}

/// Where messages go and which are wanted.
#[derive(Clone)]
pub struct Log {
    logger: Logger,
    environment: *mut c_void,
    /// Instance name, with its terminating zero.
    name: heapless::Vec<u8, 128>,
    /// By [`Category`].
    wanted: [bool; 6],
}

impl Log {
    /// A log for an instance. Refusals, errors and a capsule are always wanted, events only if the host
    /// switched logging on, and warnings, which cost a pass over the sheet.
    pub fn new(logger: Logger, environment: *mut c_void, name: &CStr, logging_on: bool) -> Log {
        let mut copy: heapless::Vec<u8, 128> = name.to_bytes().iter().copied().take(127).collect();
        // There is room: 127 bytes at most were taken.
        let _ = copy.push(0);
        Log { logger, environment, name: copy, wanted: [logging_on, true, true, true, true, logging_on] }
    }

    /// Switches categories on or off; none named means all. False if a name is unknown, then nothing changed.
    pub fn switch<'a>(&mut self, on: bool, names: impl Iterator<Item = Option<&'a CStr>>) -> bool {
        let mut chosen = [false; 6];
        let mut any = false;
        for name in names {
            any = true;
            let known = |name: &CStr| LOG_CATEGORIES.iter().position(|(known, _)| known.as_bytes() == name.to_bytes());
            match name.and_then(known) {
                Some(ALL) => chosen = [true; 6],
                Some(place) => chosen.iter_mut().skip(place).take(1).for_each(|chosen| *chosen = true),
                None => return false,
            }
        }
        for (wanted, chosen) in self.wanted.iter_mut().zip(chosen) {
            if chosen || !any {
                *wanted = on;
            }
        }
        true
    }

    /// Whether the host wants messages of a category.
    pub fn wants(&self, category: Category) -> bool {
        self.wanted.get(category as usize).copied().unwrap_or(false)
    }

    /// Tells the host.
    pub fn say(&self, category: Category, text: &str) {
        let (name, status) = match category {
            Category::Event => (c"logEvents", Status::Ok),
            Category::Discard => (c"logStatusDiscard", Status::Discard),
            Category::Error => (c"logStatusError", Status::Error),
            Category::Fatal => (c"logStatusFatal", Status::Fatal),
            Category::Capsule => (c"logCapsule", Status::Ok),
            Category::Warning => (c"logStatusWarning", Status::Warning),
        };
        if !self.wants(category) {
            return;
        }
        let mut line: heapless::Vec<u8, 256> = text.bytes().filter(|&byte| byte != 0).take(255).collect();
        // There is room: 255 bytes at most were taken.
        let _ = line.push(0);
        let (environment, number, message) = (self.environment, status as c_int, line.as_ptr().cast::<c_char>());
        // All texts end with a zero and outlive the call.
        match self.logger {
            Logger::Two(Some(logger)) => {
                logger(environment, self.name.as_ptr().cast(), number, name.as_ptr(), c"%s".as_ptr(), message)
            }
            Logger::Three(Some(logger)) => logger(environment, number, name.as_ptr(), message),
            Logger::Component(logger) => {
                // A name that is cut within a letter ends before it.
                let shown = self.name.split_last().and_then(|(_, shown)| shown.utf8_chunks().next());
                logger(shown.map_or("", |shown| shown.valid()), status, name.to_str().unwrap_or(""), text)
            }
            Logger::Two(None) | Logger::Three(None) => {}
        }
    }
}
