//! Candidates of a stack sorted by column, as compressed rows: those of a column of free nodes are a slice of
//! `members`, the last one found first. That candidate leads the column. A fixed node is a column of its own.
//!
//! Method: counting sort, with the number of its leader as the key of a candidate.
//! Limits: `leaders` is not cleared: an entry may be that of an earlier step, so who reads it compares nodes.
//! Reference: D. E. Knuth, The Art of Computer Programming 3 (1998), 5.2 (distribution counting).

use crate::memory::arrays::Arrays;
use crate::memory::records::Candidate;
use crate::memory::system::System;
use core::ops::Range;

/// Sorts the first `count` candidates by column, columns in the order of the candidates that lead them.
pub(super) fn sort(system: &mut System<'_>, count: usize) {
    let Arrays { leaders, members, ends, candidates, .. } = &mut system.arrays;
    let (Some(ends), Some(candidates)) = (ends.get_mut(..count), candidates.get(..count)) else { return };
    // At least 1, so that no division by zero has to be compiled in.
    let places = (leaders.len() as u32).max(1);
    let place = |candidate: &Candidate| candidate.node % places;
    for (c, candidate) in candidates.iter().enumerate().filter(|(_, candidate)| !candidate.is_fixed()) {
        if let Some(leader) = leaders.get_mut(place(candidate) as usize) {
            *leader = c as u32;
        }
    }
    let leader_of =
        |c: usize, of: &Candidate| if of.is_fixed() { Some(c) } else { leader(leaders, place(of) as usize) };
    ends.fill(0);
    for (c, candidate) in candidates.iter().enumerate() {
        if let Some(size) = leader_of(c, candidate).and_then(|leader| ends.get_mut(leader)) {
            *size += 1;
        }
    }
    // From sizes to starts, and each moves on to the end as its column fills.
    ends.iter_mut().fold(0, |start, end| start + core::mem::replace(end, start));
    for (c, candidate) in candidates.iter().enumerate().rev() {
        if let Some(end) = leader_of(c, candidate).and_then(|leader| ends.get_mut(leader))
            && let Some(member) = members.get_mut(*end as usize)
        {
            *member = c as u32;
            *end += 1;
        }
    }
}

/// Candidate that leads the column at a place, as the last sort that had a candidate there left it.
pub(super) fn leader(leaders: &[u32], place: usize) -> Option<usize> {
    leaders.get(place).map(|&c| c as usize)
}

/// Column that a candidate leads, as a range of `members`; empty if it leads none.
pub(super) fn column(ends: &[u32], leader: usize) -> Range<usize> {
    let end = |c: usize| ends.get(c).map_or(0, |&end| end as usize);
    leader.checked_sub(1).map_or(0, end)..end(leader)
}
