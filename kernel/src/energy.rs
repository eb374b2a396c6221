//! The ledger: energies and momentum, computed only when asked for.
//!
//! Method: second-order audit of the staggered scheme. Kinetic energy from the stored half-step velocities, strain and
//! dissipated energy as means of the states at t_{n-1} and t_n. Dissipation is a state function of alpha, so nothing is
//! accumulated but contact loss, work and impulses. Integer-time kinetic energy would carry a first-order bias in contact.
//! Limits: second order in dt; a slackened sheet gains energy at the stiffness jump at U = 1 (docs/model.md).
//! Reference: docs/model.md, "Audit".

use crate::error::Failure;
use crate::layout;
use crate::pose::Vector;
use crate::scene::Drive;
use crate::sim::Sim;
use crate::sweep::{self, Axis};
use crate::yarn::Segment;

/// Energies, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Kinetic energy of the projectile (0 if its mass is unknown).
    pub projectile_kinetic: f64,
    /// Kinetic energy of the fabric.
    pub fabric_kinetic: f64,
    /// Strain energy of the yarns.
    pub strain: f64,
    /// Energy dissipated by rupture.
    pub dissipated: f64,
    /// Kinetic energy lost in impacts of nodes on the projectile.
    pub contact_loss: f64,
    /// Work of the projectile on the fabric: the energy absorbed.
    pub contact_work: f64,
    /// Work of the external load on the projectile.
    pub external_work: f64,
    /// Change of the audited energy when the step was halved, of second order in dt; 0 if it was not.
    pub halving: f64,
    /// What the balance does not close by; should be small against the kinetic energy at impact.
    pub residual: f64,
}

/// One segment as the read-outs see it.
#[derive(Clone, Copy)]
pub(crate) struct SegmentView {
    /// Direction.
    pub axis: Axis,
    /// Stiffness kk with the stored damage.
    pub stiffness: f64,
    /// kk without damage.
    pub undamaged: f64,
    /// Damage rate.
    pub damage_rate: f64,
    /// Largest q beyond critical stored so far.
    pub history: f64,
    /// The toe's mark (`toe.rs`).
    pub mark: f64,
    /// Relative displacement of its ends at t_n.
    pub d: [f64; 3],
    /// Relative displacement of its ends at t_{n-1}.
    pub d_before: [f64; 3],
}

impl SegmentView {
    fn excess(&self, d: [f64; 3]) -> f64 {
        match self.axis {
            Axis::Horizontal => sweep::excess_horizontal(d),
            Axis::Vertical => sweep::excess_vertical(d),
        }
    }

    /// U^2 - 1 at t_n.
    pub fn excess_now(&self) -> f64 {
        self.excess(self.d)
    }

    /// Whether its ends are nearer than at rest at t_n and were at t_{n-1}.
    pub fn is_slack(&self) -> bool {
        self.excess_now() < 0.0 && self.excess(self.d_before) < 0.0
    }
}

impl Sim<'_> {
    /// The energies, with a full pass over the sheet. Commits nothing.
    pub fn energy(&self) -> Result<Energy, Failure> {
        self.sound()?;
        let sums = &self.state.sums;
        let prescribed = self.scene.drive == Drive::Prescribed;
        let (fabric_kinetic, strain, dissipated) = self.fabric_energy();
        let projectile_kinetic = self.state.body.kinetic_energy(&self.model.inertia);
        let held = fabric_kinetic + strain + dissipated + sums.loss;
        let residual = if prescribed {
            held - sums.work - sums.first_energy - sums.halving_energy
        } else {
            held + projectile_kinetic - sums.external_work - sums.first_energy - sums.halving_energy
        };
        Ok(Energy {
            projectile_kinetic,
            fabric_kinetic,
            strain,
            dissipated,
            contact_loss: sums.loss,
            contact_work: sums.work,
            external_work: sums.external_work,
            halving: sums.halving_energy,
            residual,
        })
    }

    /// Linear momentum that the balance of fabric, projectile, supports and loads does not close by, N s, host's axes.
    /// Meaningful with `track_support` (or without fixed nodes). Commits nothing.
    pub fn momentum_residual(&self) -> Result<[f64; 3], Failure> {
        self.sound()?;
        let sums = &self.state.sums;
        let mut balance = self.momentum() - sums.first_momentum - sums.external_impulse;
        if self.scene.drive == Drive::Prescribed {
            // The body's reaction is the load the fabric received.
            balance += sums.impulse;
        }
        for support in &sums.support {
            balance += support * self.model.unit_impulse;
        }
        Ok(self.model.pose.vector_out(balance.into()))
    }

    /// Starts the audit from the present state.
    pub(crate) fn start_audit(&mut self) {
        let (kinetic, strain, dissipated) = self.fabric_energy();
        let mut energy = kinetic + strain + dissipated;
        if self.scene.drive == Drive::Free {
            energy += self.state.body.kinetic_energy(&self.model.inertia);
        }
        self.state.sums.first_energy = energy;
        self.state.sums.first_momentum = self.momentum();
    }

    /// Momentum of the fabric, and of the projectile where it is free, N s, sheet's frame.
    fn momentum(&self) -> Vector {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let mut total = Vector::zeros();
        for j in 0..ny {
            let row = layout::row(self.blocks.hot, chunks, j);
            let weighted = |plane: usize, i: usize| Some(layout::get(row, plane, i)? * self.layout.node_weight(i, j));
            let sum = |plane: usize| -> f64 { (0..nx).filter_map(|i| weighted(plane, i)).sum() };
            total += Vector::new(sum(3), sum(4), sum(5));
        }
        let mut momentum = total.component_mul(&self.scene.symmetry.force_mask()) * self.model.unit_impulse;
        if self.scene.drive == Drive::Free {
            momentum += self.state.body.velocity * self.model.inertia.mass;
        }
        momentum
    }

    /// Kinetic, strain and dissipated energy of the fabric, J. Summed row by row, rows in order.
    fn fabric_energy(&self) -> (f64, f64, f64) {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (mut kinetic, mut strain, mut dissipated) = (0.0, 0.0, 0.0);
        for j in 0..ny {
            let row = layout::row(self.blocks.hot, chunks, j);
            let mut sum = 0.0;
            for plane in 3..6 {
                let weighted = |i: usize| {
                    let v = layout::get(row, plane, i)?;
                    Some(v * v * self.layout.node_weight(i, j))
                };
                sum += (0..nx).filter_map(weighted).sum::<f64>();
            }
            kinetic += sum;
        }
        for j in 0..ny {
            let (mut row_strain, mut row_dissipated) = (0.0, 0.0);
            for i in 0..nx {
                for axis in [Axis::Horizontal, Axis::Vertical] {
                    if let Some(segment) = self.segment(axis, i, j) {
                        let (stored, lost) = self.segment_energy(&segment);
                        let weight = self.layout.segment_weight(axis, i, j);
                        row_strain += weight * stored;
                        row_dissipated += weight * lost;
                    }
                }
            }
            strain += row_strain;
            dissipated += row_dissipated;
        }
        let unit = self.model.unit_energy;
        (0.5 * unit * kinetic, unit * strain, dissipated * self.model.segment_volume)
    }

    /// Strain energy in units of m (h/dt)^2 and dissipated energy density, J/m^3, as means over t_{n-1} and t_n.
    fn segment_energy(&self, segment: &SegmentView) -> (f64, f64) {
        let (before, now) = (segment.excess(segment.d_before), segment.excess_now());
        let (law, critical, toe) = (&self.model.law, self.model.critical, &self.model.toe);
        let marked = segment.alpha_when_marked();
        let stored = |stiffness: f64, q: f64| {
            let without_toe = if q > 0.0 { 0.25 * stiffness * q * q } else { 0.0 };
            if marked.is_some() && q > 0.0 { without_toe * toe.stored_share(0.5 * q) } else { without_toe }
        };
        let fresh = now > critical && now > segment.history;
        if segment.history == 0.0 && !fresh {
            let stiffness = segment.stiffness;
            return (0.5 * (stored(stiffness, before) + stored(stiffness, now)), 0.0);
        }
        let material =
            Segment { modulus: segment.undamaged * self.model.modulus_per_stiffness, damage_rate: segment.damage_rate };
        let alpha_before = law.alpha(segment.damage_rate, segment.history);
        let alpha_now = if fresh { law.alpha(segment.damage_rate, now) } else { alpha_before };
        let stored_before = stored(segment.stiffness, before);
        let stored_now = stored(alpha_now * segment.undamaged, now);
        let dissipated = |alpha: f64| {
            let saved = marked.map_or(0.0, |first| toe.saved(material.modulus, first - alpha));
            law.dissipated(&material, alpha) - saved
        };
        let lost = dissipated(alpha_before) + dissipated(alpha_now);
        (0.5 * (stored_before + stored_now), 0.5 * lost)
    }
}
