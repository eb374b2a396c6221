//! The mechanical system that is stepped: network, contacts, projectile and scalar state. Functions on the
//! floors above step it and read it out.

use crate::body::projectile::Body;
use crate::body::shape::{Form, Solid};
use crate::ground::error::Failure;
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::state::State;

/// Constants, state and memory of the sheet and the projectile. Functions that need some of its parts take
/// just these.
pub(crate) struct System<'a> {
    pub network: Network<'a>,
    pub contacts: Contacts<'a>,
    pub solid: Solid,
    pub state: State,
    pub failed_segments: u64,
    pub failure: Option<Failure>,
}

impl<'a> System<'a> {
    /// No sheet and no memory: a place for a simulation.
    pub const NOTHING: System<'a> = System {
        network: Network::NOTHING,
        contacts: Contacts::nothing(),
        solid: Solid { form: Form::Sphere { radius: 0.0 }, half_thickness: 0.0 },
        state: State::at_start(Body::AT_REST),
        failed_segments: 0,
        failure: None,
    };
}

impl System<'_> {
    /// Latched failure as an error, so that every call after it says the same.
    pub fn sound(&self) -> Result<(), Failure> {
        self.failure.map_or(Ok(()), Err)
    }

    /// Result of a step, whose failure is latched.
    pub fn latch<T>(&mut self, result: Result<T, Failure>) -> Result<T, Failure> {
        result.inspect_err(|failure| self.failure = Some(*failure))
    }

    /// Sheet flat, at rest and whole.
    pub fn clear_state(&mut self) {
        self.network.clear();
        self.rebuild_derived();
    }

    /// Everything that follows from displacements, velocities and histories: stiffness planes, failed
    /// segments, row ranges, awake rows. Clears a failure.
    pub fn rebuild_derived(&mut self) {
        self.refill(|_, _| true);
    }

    /// [`System::rebuild_derived`], with every row filled anew before what follows from it, while it is at
    /// hand. `fill` returns whether a history of the row has changed; if not, its stiffnesses are still
    /// right.
    pub fn refill(&mut self, fill: impl FnMut(&mut Network<'_>, usize) -> bool) {
        self.failure = None;
        self.network.refill(fill);
        self.failed_segments = self.network.count_failed([0, self.network.layout.nodes_y]);
    }
}
