//! Contacts of a stack sorted by column: those of a column of free nodes are a slice, the last one found
//! first. That contact leads the column. A fixed node is a column of its own.
//!
//! Method: counting sort that copies the candidates, with the number of its leader as the key of a candidate.
//! Limits: `leaders` is not cleared: an entry may be that of an earlier step, so who reads it compares nodes.
//! Reference: D. E. Knuth, The Art of Computer Programming 3 (1998), 5.2 (distribution counting).

use crate::contact::column::Column;
use crate::memory::arrays::Contacts;
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::memory::records::{Candidate, PlyContact, PlyFriction, Relaxation, Tangential};

/// Candidates of a stack, and their contacts sorted by column.
pub(super) struct SortedContacts<'c> {
    pub candidates: &'c mut [Candidate],
    /// Friction of each candidate; none without friction.
    pub tangential: &'c mut [Tangential],
    contacts: &'c mut [PlyContact],
    friction: &'c mut [PlyFriction],
    /// Candidate that leads the column at each place.
    leaders: &'c mut [u32],
    /// End of the column that each candidate leads.
    ends: &'c mut [u32],
}

/// Contacts of one column, and the friction of each, none without friction. The first one leads the column.
pub(super) struct ColumnContacts<'m> {
    pub contacts: &'m mut [PlyContact],
    pub friction: &'m mut [PlyFriction],
}

impl ColumnContacts<'_> {
    /// Contact that leads the column.
    pub fn leader(&self) -> PlyContact {
        self.contacts.first().copied().unwrap_or_default()
    }

    /// Whether impulses along the surface have changed since the column was solved.
    pub fn is_stale(&self) -> bool {
        self.contacts.first().is_some_and(|leader| leader.stale != 0)
    }

    /// Notes whether they have.
    pub fn set_stale(&mut self, stale: bool) {
        if let Some(leader) = self.contacts.first_mut() {
            leader.stale = u32::from(stale);
        }
    }

    /// Contacts, each with its friction.
    #[inline]
    pub fn each(&self) -> impl Iterator<Item = (&PlyContact, Option<&PlyFriction>)> {
        let mut friction = self.friction.iter();
        self.contacts.iter().map(move |contact| (contact, friction.next()))
    }

    /// [`ColumnContacts::each`], to be changed.
    #[inline]
    pub fn each_mut(&mut self) -> impl Iterator<Item = (&mut PlyContact, Option<&mut PlyFriction>)> {
        let mut friction = self.friction.iter_mut();
        self.contacts.iter_mut().map(move |contact| (contact, friction.next()))
    }
}

impl SortedContacts<'_> {
    /// Copies the candidates, columns in the order of the candidates that lead them. What plies do to
    /// them is zero.
    pub fn sort(&mut self, network: &Network<'_>) {
        let SortedContacts { candidates, tangential, contacts, friction, leaders, ends } = self;
        // At least 1, so that no division by zero has to be compiled in.
        let (places, nodes_x) = ((leaders.len() as u32).max(1), (network.layout.nodes_x as u32).max(1));
        let place = |candidate: &Candidate| candidate.node % places;
        for (c, candidate) in candidates.iter().enumerate().filter(|(_, candidate)| !candidate.is_fixed()) {
            if let Some(leader) = leaders.get_mut(place(candidate) as usize) {
                *leader = c as u32;
            }
        }
        let leader_of = |c: usize, candidate: &Candidate| {
            if candidate.is_fixed() { Some(c) } else { leader(leaders, place(candidate) as usize) }
        };
        ends.fill(0);
        for (c, candidate) in candidates.iter().enumerate() {
            if let Some(size) = leader_of(c, candidate).and_then(|leader| ends.get_mut(leader)) {
                *size += 1;
            }
        }
        // From sizes to starts, and each moves on to the end as its column fills.
        ends.iter_mut().fold(0, |start, end| start + core::mem::replace(end, start));
        for (c, candidate) in candidates.iter().enumerate().rev() {
            let Some(end) = leader_of(c, candidate).and_then(|leader| ends.get_mut(leader)) else { continue };
            if let Some(contact) = contacts.get_mut(*end as usize) {
                let (number, place, ply) = (c as u32, place(candidate), candidate.node / places);
                let (column, row) = (place % nodes_x, place / nodes_x);
                let Candidate { normal, arm, held_by, free_gap_rate, impulse, .. } = *candidate;
                let own_normal = network.column_axes(column as usize, normal.into());
                let of_column = PlyContact { number, column, row, ply, own_normal, ..PlyContact::default() };
                *contact = PlyContact { normal, arm, held_by, free_gap_rate, impulse, ..of_column };
            }
            if let Some((friction, tangential)) = friction.get_mut(*end as usize).zip(tangential.get(c)) {
                let relaxation = Relaxation { factor: 1.0, increment: [0.0; 2] };
                *friction = PlyFriction { tangential: *tangential, relaxation, ..PlyFriction::default() };
            }
            *end += 1;
        }
    }

    /// Number of the candidates.
    pub fn count(&self) -> usize {
        self.candidates.len()
    }

    /// Calls `visit` with the contacts of each column that has some, in order.
    #[inline]
    pub fn for_each(&mut self, mut visit: impl FnMut(ColumnContacts<'_>)) {
        let SortedContacts { contacts, friction, ends, .. } = self;
        let mut start = 0;
        for end in ends.iter().map(|&end| end as usize) {
            if end > start
                && let Some(contacts) = contacts.get_mut(start..end)
            {
                visit(ColumnContacts { contacts, friction: friction.get_mut(start..end).unwrap_or_default() });
            }
            start = end;
        }
    }

    /// Leaves the contacts out of their columns for which `is_near` does not hold, so that no sweep comes to
    /// them; but one that leads a column in which it holds for another stays. Calls `visit` with what is left
    /// of each column and the number of contacts that it had.
    pub fn retain(&mut self, is_near: impl Fn(&PlyContact) -> bool, mut visit: impl FnMut(ColumnContacts<'_>, usize)) {
        let SortedContacts { contacts, friction, ends, .. } = self;
        let (mut start, mut kept) = (0, 0);
        for end in ends.iter_mut() {
            let all = start..*end as usize;
            start = all.end;
            let (first, is_any_near) = (kept, contacts.get(all.clone()).unwrap_or(&[]).iter().any(&is_near));
            for k in all.clone().filter(|_| is_any_near) {
                let Some(contact) = contacts.get(k).copied() else { break };
                if k > all.start && !is_near(&contact) {
                    continue;
                }
                if let Some(place) = contacts.get_mut(kept) {
                    *place = contact;
                }
                if let Some(of_contact) = friction.get(k).copied()
                    && let Some(place) = friction.get_mut(kept)
                {
                    *place = of_contact;
                }
                kept += 1;
            }
            *end = kept as u32;
            if let Some(contacts) = contacts.get_mut(first..kept).filter(|contacts| !contacts.is_empty()) {
                let friction = friction.get_mut(first..kept).unwrap_or_default();
                visit(ColumnContacts { contacts, friction }, all.len());
            }
        }
    }

    /// Gives the candidates the impulses of their contacts; those that were left out have none.
    pub fn give_impulses(&mut self) {
        let SortedContacts { candidates, tangential, contacts, friction, ends, .. } = self;
        candidates.iter_mut().for_each(|candidate| candidate.impulse = 0.0);
        tangential.iter_mut().for_each(|t| t.impulse = [0.0; 2]);
        let count = ends.last().map_or(0, |&end| end as usize);
        let mut friction = friction.iter();
        for contact in contacts.iter().take(count) {
            let c = contact.number as usize;
            if let Some(candidate) = candidates.get_mut(c) {
                candidate.impulse = contact.impulse;
            }
            if let Some(friction) = friction.next()
                && let Some(t) = tangential.get_mut(c)
            {
                t.impulse = friction.tangential.impulse;
            }
        }
    }
}

impl Contacts<'_> {
    /// So many candidates, and the column of nodes that they are solved with.
    pub(super) fn columns(&mut self, count: usize) -> (SortedContacts<'_>, Column<'_>) {
        let Contacts { candidates, tangential, of_plies, ply_friction, leaders, ends, .. } = self;
        let columns = SortedContacts {
            candidates: candidates.get_mut(..count).unwrap_or_default(),
            tangential: tangential.get_mut(..count).unwrap_or_default(),
            contacts: of_plies.get_mut(..count).unwrap_or_default(),
            friction: ply_friction.get_mut(..count).unwrap_or_default(),
            leaders,
            ends: ends.get_mut(..count).unwrap_or_default(),
        };
        (columns, Column { nodes: self.nodes_of_column, pools: self.pools })
    }

    /// Candidates with a normal impulse among the first `count`, in a column of free nodes: their numbers.
    pub(super) fn with_impulse(
        &self,
        layout: &Layout,
        i: usize,
        row: usize,
        count: usize,
    ) -> impl Iterator<Item = usize> {
        let place = row * layout.nodes_x + i;
        let end = |c: usize| self.ends.get(c).map_or(0, |&end| end as usize);
        let column = leader(self.leaders, place).filter(|&c| c < count).map_or(0..0, |c| start(self.ends, c)..end(c));
        let numbers = self.of_plies.get(column).unwrap_or(&[]).iter().map(|contact| contact.number as usize);
        // An earlier step may have left what is now elsewhere.
        let places = (layout.nodes_x * layout.y.modelled()).max(1);
        numbers.filter(move |&c| {
            let candidate = self.candidates.get(c).filter(|_| c < count);
            candidate.is_some_and(|c| c.node as usize % places == place && c.impulse > 0.0 && !c.is_fixed())
        })
    }
}

/// Candidate that leads the column at a place, as the last sort that had a candidate there left it.
fn leader(leaders: &[u32], place: usize) -> Option<usize> {
    leaders.get(place).map(|&c| c as usize)
}

/// Start of the column that a candidate leads.
fn start(ends: &[u32], leader: usize) -> usize {
    leader.checked_sub(1).and_then(|c| ends.get(c)).map_or(0, |&end| end as usize)
}
