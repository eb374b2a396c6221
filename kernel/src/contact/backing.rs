//! The rigid case behind a node that the projectile presses on it.
//!
//! Method: beside each candidate whose node may be pressed on the case in this step, the place of the case
//! that the node then meets is a candidate that is held. The node moves along the body's normal n. With its
//! height g above the case, the case's outward normal c and n.c < 0 it meets the case when n.v has grown by
//! (g/dt + c.v)/(-n.c). So body, node and case are solved together, and the case takes what the node does
//! not. A node that slides towards the body would push it back there; the case only stops it. A prescribed
//! body passes through such nodes, as through fixed ones.
//! Limits: the case takes its impulse along n, and with the body's friction, as a support does. Nodes that
//! slide get into it in second order.
//! Reference: docs/model.md, "Curved sheets and rings".

use crate::body::pose::Vector;
use crate::body::projectile::Twist;
use crate::contact::candidate::Holder;
use crate::ground::math;
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::records::Candidate;
use crate::sheet::casing::Cylinder;
use crate::sheet::ring;

/// Adds after the completed candidates the places of the case that back them; of a prescribed body, takes
/// those out that such a place stops. Returns how many candidates there are now.
pub(crate) fn back_by_case(network: &Network<'_>, contacts: &mut Contacts<'_>, body: &Twist, count: usize) -> usize {
    let Some(case) = network.directions.case() else { return count };
    let is_free = network.scene.is_free();
    let (mut c, mut nodes, mut all) = (0, count, count);
    while c < nodes {
        let candidate = contacts.candidates.get(c);
        let Some(held) = candidate.and_then(|candidate| place_of_case(network, case, candidate)) else {
            c += 1;
            continue;
        };
        if is_free {
            let Some(slot) = contacts.candidates.get_mut(all) else { break };
            *slot = held;
            if let Some(&friction) = contacts.tangential.get(c)
                && let Some(place) = contacts.tangential.get_mut(all)
            {
                *place = friction;
            }
            (c, all) = (c + 1, all + 1);
        } else if held.gap_rate(body) < 0.0 {
            (nodes, all) = (nodes - 1, all - 1);
            contacts.swap(c, nodes);
        } else {
            c += 1;
        }
    }
    all
}

/// The place of the case that a free node meets within a spacing, if it moves along the normal of this
/// candidate.
fn place_of_case(network: &Network<'_>, case: &Cylinder, candidate: &Candidate) -> Option<Candidate> {
    if candidate.is_fixed() {
        return None;
    }
    let (i, j) = network.layout.column_and_row(candidate.node as usize);
    let x = Vector::from(network.rest(i, j)) + Vector::from(candidate.displacement);
    let from_axis = ring::from_axis(&x);
    if candidate.normal.dot(&from_axis) >= 0.0 {
        return None;
    }
    let outwards = from_axis * (1.0 / math::length(from_axis.into()));
    let against = -candidate.normal.dot(&outwards);
    // A push of a spacing inwards, -1, leaves a node lower than that a room of one less its height: (M24).
    let height = 1.0 - case.room(x.into(), [outwards.x, outwards.z], -1.0);
    let left = math::max(height + outwards.dot(&Vector::from(network.node(i, j).1)), 0.0);
    let free_gap_rate = math::max(candidate.free_gap_rate + left / against * network.model.unit_speed, 0.0);
    let held = Candidate { held_by: Holder::Case as u32, free_gap_rate, ..*candidate };
    (height < 1.0 && left < against).then_some(held)
}
