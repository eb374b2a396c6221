//! State of an instance beside its simulation, and the saved states that its host holds.

use crate::memory::Owned;
use crate::parameters::Parameters;

/// Where an instance is in its life. The numbers are written into images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated = 1,
    /// Between entering and leaving initialisation.
    Initialization = 2,
    /// FMI 3.0 only.
    Event = 4,
    /// Ready to step.
    Step = 8,
    /// After terminate.
    Terminated = 16,
    /// The simulation has failed: reset, restore a state, or free.
    Faulted = 32,
}

impl Phase {
    /// All phases.
    pub const ALL: [Phase; 6] =
        [Phase::Instantiated, Phase::Initialization, Phase::Event, Phase::Step, Phase::Terminated, Phase::Faulted];

    /// Before the simulation exists.
    pub const SETTING_UP: u32 = Phase::Instantiated as u32 | Phase::Initialization as u32;
    /// While it runs.
    pub const RUNNING: u32 = Phase::Step as u32 | Phase::Event as u32;
    /// Variables may be set; which ones is said by their roles.
    pub const SETTABLE: u32 = Phase::SETTING_UP | Phase::RUNNING;
    /// Once a step was possible, and after the end.
    pub const AFTER_SETTING_UP: u32 = Phase::RUNNING | Phase::Terminated as u32;
    /// From the beginning of initialisation on: FMI 2.0 reads no variable before.
    pub const READABLE_IN_2: u32 = Phase::ANY & !(Phase::Instantiated as u32);
    /// Any.
    pub const ANY: u32 = 63;
}

/// Everything about an instance but the simulation itself: what a saved state holds beside the kernel's
/// image.
#[derive(Clone, Copy)]
pub struct Kept {
    /// Where the instance is in its life.
    pub phase: Phase,
    /// Inputs and parameters.
    pub parameters: Parameters,
    /// Time of tick 0, s.
    pub start_time: f64,
    /// End of the experiment, s; infinite if the host named none.
    pub stop_time: f64,
    /// Where the last communication step ended, s.
    pub time: f64,
    /// FMI 2.0: the last step ended the simulation because of `stop_on_event`.
    pub terminated: bool,
    /// contact.force_mean, N.
    pub force_mean: [f64; 3],
    /// contact.torque_mean, N m.
    pub torque_mean: [f64; 3],
    /// interface.residual, J.
    pub interface_residual: f64,
    /// interface.gap, m.
    pub interface_gap: f64,
    /// Drive prescribed: the host has given a position or velocity other than zero.
    pub driven: bool,
    /// The discrete outputs as the host sees them.
    pub shown: Discrete,
}

/// The outputs that change at events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Discrete {
    /// status: a place in [`crate::table::STATUS`].
    pub status: u32,
    /// Which events have happened: a bit for each, in the order of [`crate::table::EVENTS`].
    pub happened: u32,
}

impl Default for Kept {
    /// Before anything is set.
    fn default() -> Kept {
        Kept {
            phase: Phase::Instantiated,
            parameters: Parameters::default(),
            start_time: 0.0,
            stop_time: f64::INFINITY,
            time: 0.0,
            terminated: false,
            force_mean: [0.0; 3],
            torque_mean: [0.0; 3],
            interface_residual: 0.0,
            interface_gap: 0.0,
            driven: false,
            shown: Discrete::default(),
        }
    }
}

/// A saved state. The kernel's image follows it in the same block.
pub struct Saved {
    next: Option<Owned<Saved>>,
    /// Everything but the simulation.
    pub kept: Kept,
    /// Bytes of the image; 0 if there was no simulation yet.
    pub image: usize,
    /// Whether the image came as bytes from the host; else `save` wrote it.
    pub from_bytes: bool,
}

impl Owned<Saved> {
    /// The kernel's image.
    pub fn image(&self) -> &[u8] {
        let (saved, behind) = self.parts();
        behind.get(..saved.image).unwrap_or(&[])
    }

    /// The kernel's image, to write.
    pub fn image_mut(&mut self) -> &mut [u8] {
        let (saved, behind) = self.parts_mut();
        behind.get_mut(..saved.image).unwrap_or(&mut [])
    }

    /// Bytes there is room for.
    pub fn room(&self) -> usize {
        self.parts().1.len()
    }
}

/// The states of an instance that its host holds; freed with it. The host names a state by its address, which
/// is looked up here and never trusted.
#[derive(Default)]
pub struct States(Option<Owned<Saved>>);

impl States {
    /// The state a host's pointer means, if it is one of this instance.
    pub fn find(&self, wanted: *const Saved) -> Option<&Owned<Saved>> {
        core::iter::successors(self.0.as_ref(), |saved| saved.next.as_ref())
            .find(|saved| saved.pointer().cast_const() == wanted)
    }

    /// As [`States::find`], to change.
    pub fn find_mut(&mut self, wanted: *const Saved) -> Option<&mut Owned<Saved>> {
        let mut at = self.0.as_mut();
        while let Some(saved) = at {
            if saved.pointer().cast_const() == wanted {
                return Some(saved);
            }
            at = saved.next.as_mut();
        }
        None
    }

    /// A new state with room for an image; None if there is no memory.
    pub fn add(&mut self, kept: &Kept, image: usize, from_bytes: bool) -> Option<&mut Owned<Saved>> {
        let mut saved = Owned::new(Saved { next: None, kept: *kept, image, from_bytes }, image)?;
        saved.next = self.0.take();
        Some(self.0.insert(saved))
    }

    /// Frees one state; false if it is none of this instance's.
    pub fn remove(&mut self, wanted: *const Saved) -> bool {
        let mut at = &mut self.0;
        loop {
            match at {
                None => return false,
                Some(saved) if saved.pointer().cast_const() == wanted => {
                    *at = saved.next.take();
                    return true;
                }
                Some(saved) => at = &mut saved.next,
            }
        }
    }
}

impl Drop for States {
    /// One after the other: each would else drop its next from within, as deep as there are states.
    fn drop(&mut self) {
        while let Some(mut first) = self.0.take() {
            self.0 = first.next.take();
        }
    }
}
