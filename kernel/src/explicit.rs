//! The explicit step: velocity Verlet in sweep form with impulse contact.
//!
//! Method: nodes near the projectile are noted, every row is swept (damage, kick, drift), the touched nodes are corrected by
//! contact impulses, the body moves. Positions live at t_n, velocities at t_{n-1/2}; they are never synchronised.
//! Limits: dt <= 0.5 dt_crit; a projectile slower than one node spacing in a step.
//! Reference: docs/model.md, "The step"; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::blocks::{Blocks, in_runs};
use crate::contact::{self, Candidate, Passage, Search, Solved};
use crate::error::Failure;
use crate::layout::{self, CARRY_PLANES, CHUNK};
use crate::math;
use crate::outcome::TEST_INTERVAL;
use crate::path;
use crate::pose::Vector;
use crate::projectile::{self, Body};
use crate::rows::{Rows, Terms};
use crate::scene::{Drive, Integrator, Scene, Symmetry};
use crate::sim::Sim;
use crate::state::Sums;
use crate::sweep::Report;
use crate::toe::MARK_INTERVAL;
use crate::weave;

/// What lies under the projectile at t_n.
#[derive(Clone, Copy)]
pub(crate) struct Gathered {
    /// Candidates noted.
    count: usize,
    /// Deepest penetration of any, m; 0 if none is inside.
    deepest: f64,
}

impl Sim<'_> {
    /// One step. A projectile that is too fast and too many candidates are found before anything is changed.
    pub(crate) fn step_once(&mut self) -> Result<(), Failure> {
        let failed_before = self.failed_segments;
        if self.state.halved {
            self.pass(0.5)?;
        }
        self.pass(1.0)?;
        self.end_step(failed_before)
    }

    /// What follows the last pass of a step.
    pub(crate) fn end_step(&mut self, failed_before: u64) -> Result<(), Failure> {
        if self.layout.halving && !self.state.halved && self.failed_segments > failed_before {
            self.halve_step()?;
        }
        self.state.step += 1;
        if self.layout.toe && self.failed_segments > 0 && self.state.step.is_multiple_of(MARK_INTERVAL) {
            self.mark_slack();
        }
        self.close_window();
        if self.state.step.is_multiple_of(TEST_INTERVAL) {
            self.test_outcomes();
        }
        Ok(())
    }

    /// One pass of the scheme, to the part `end` of the step.
    fn pass(&mut self, end: f64) -> Result<(), Failure> {
        let at_start = self.state.body;
        let target = self.prescribe_rates(end);
        let found = self.refuse_too_fast().and_then(|()| self.gather());
        let gathered = found.inspect_err(|_| self.state.body = at_start)?;
        match self.scene.integrator {
            Integrator::Verlet => {
                let report = self.sweep();
                self.touch(report, gathered.count, &at_start)?;
            }
            #[cfg(feature = "implicit")]
            Integrator::Theta(rule) => self.iterate(rule, gathered.count, &at_start)?,
            // Refused by the scene's check in a build without it.
            #[cfg(not(feature = "implicit"))]
            Integrator::Theta(_) => return Err(Failure::NotConverged),
        }
        self.end_pass(&gathered, target)
    }

    /// The body moves; high-water marks.
    fn end_pass(
        &mut self,
        gathered: &Gathered,
        target: Option<(Vector, nalgebra::Quaternion<f64>)>,
    ) -> Result<(), Failure> {
        self.move_body(target);
        let (sums, deepest) = (&mut self.state.sums, gathered.deepest);
        sums.worst_penetration = if deepest > sums.worst_penetration { deepest } else { sums.worst_penetration };
        sums.most_candidates = sums.most_candidates.max(gathered.count as u64);
        self.refuse_lost_body()
    }

    /// A body that is nowhere, or whose books do not fit into numbers, is told of before anyone reads it.
    fn refuse_lost_body(&self) -> Result<(), Failure> {
        let (body, sums) = (&self.state.body, &self.state.sums);
        let vectors = [
            &body.position,
            &body.velocity,
            &body.angular_velocity,
            &sums.impulse,
            &sums.angular_impulse,
            &sums.external_impulse,
        ];
        let finite = vectors.iter().all(|vector| vector.iter().all(|x| x.is_finite()))
            && body.orientation.coords.iter().all(|x| x.is_finite())
            && [sums.work, sums.loss, sums.external_work, sums.halving_energy].iter().all(|x| x.is_finite());
        let (v, w) = (body.velocity, body.angular_velocity);
        let lost = self.model.loses_body(math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
        if finite && !lost { Ok(()) } else { Err(Failure::NonFinite) }
    }

    /// For bands, before the sweep: the candidates of the next pass, or why there can be none. The state stays as it is.
    pub(crate) fn look_ahead(&mut self, end: f64) -> Result<Gathered, Failure> {
        let at_start = self.state.body;
        self.prescribe_rates(end);
        let found = self.refuse_too_fast().and_then(|()| self.gather());
        self.state.body = at_start;
        found
    }

    /// For bands, behind the sweep: the rest of the pass.
    pub(crate) fn close_pass(&mut self, end: f64, gathered: &Gathered, report: Report) -> Result<(), Failure> {
        let at_start = self.state.body;
        let target = self.prescribe_rates(end);
        self.touch(report, gathered.count, &at_start)?;
        self.end_pass(gathered, target)
    }

    /// Books on its support a kick, of the yarns or of the projectile, that the fixed node (i, j) does not take, in units of a pass.
    pub(crate) fn pull_fixed(&mut self, i: usize, j: usize, kick: &Vector) {
        if !self.scene.track_support {
            return;
        }
        let (kind, symmetry) = (self.scene.attachment.kind, self.scene.symmetry);
        let side = usize::from(self.blocks.runs.get(j).is_some_and(|run| i as u32 >= run[1]));
        let at = weave::attachment_of(kind, self.scene.sheet.nodes_y, j, side);
        let pull = kick * (self.layout.node_weight(i, j) * symmetry.share());
        self.state.sums.pull_support(kind, at, &pull, symmetry);
    }

    /// (M9) Goes over to two passes a step. The stored velocities belong to t_n - dt/2 and the halves need them at t_n - dt/4:
    /// a quarter of a kick, not only another unit. Contact needs nothing: its next impulse covers what is missing.
    fn halve_step(&mut self) -> Result<(), Failure> {
        let before = self.energy().map_or(0.0, |energy| energy.residual);
        let quarter = 0.25 * self.model.limits.dt;
        let body = self.state.body;
        self.load_body(quarter);
        self.book_load(quarter, &body);
        for j in 0..self.layout.nodes_y {
            for i in 0..self.layout.nodes_x {
                let a = self.acceleration(i, j);
                if self.is_fixed(i, j) {
                    self.pull_fixed(i, j, &(Vector::from(a) * 0.25));
                } else {
                    let (u, v) = self.node(i, j);
                    self.set_node(i, j, u, [0, 1, 2].map(|k| 0.5 * (v[k] + 0.25 * a[k])));
                }
            }
        }
        // Impulses on the supports are summed in units of a pass.
        self.state.sums.support.iter_mut().for_each(|support| *support *= 0.5);
        self.state.halved = true;
        self.take_halves(true);
        let after = self.energy().map_or(before, |energy| energy.residual);
        self.state.sums.halving_energy += after - before;
        self.refuse_lost_body()
    }

    /// Stiffnesses and units of passes over half steps, or whole ones; does nothing if they are that already.
    pub(crate) fn take_halves(&mut self, halves: bool) {
        if halves == (self.model.pass_dt < self.model.limits.dt) {
            return;
        }
        self.model.take_halves(halves);
        let factor = if halves { 0.25 } else { 4.0 };
        for chunk in self.blocks.hot.iter_mut() {
            chunk[6..].iter_mut().flatten().for_each(|stiffness| *stiffness *= factor);
        }
        for chunk in self.blocks.yarn.iter_mut() {
            chunk[..2].iter_mut().flatten().for_each(|stiffness| *stiffness *= factor);
        }
    }

    /// What the sweep leaves to do: failures, loads and contact.
    fn touch(&mut self, report: Report, count: usize, before: &Body) -> Result<(), Failure> {
        if report.non_finite {
            return Err(Failure::NonFinite);
        }
        if self.scene.symmetry == Symmetry::default() {
            self.failed_segments += report.newly_failed;
        } else if report.newly_failed > 0 {
            self.failed_segments = self.count_failed();
        }
        self.load_body(self.model.pass_dt);
        if count > 0 {
            self.complete_approach(count);
            let kept = self.let_pass(count);
            let (solved, _) = self.solve_contact(kept, count);
            self.take_solved(&solved);
            self.book_contact(count, before);
        } else {
            self.state.sums.contacts = 0;
        }
        self.book_load(self.model.pass_dt, before);
        Ok(())
    }

    /// A prescribed body on a path: sets its rates for this pass and returns its pose at the pass's end. Behind a path it
    /// coasts with the rates the path ended with.
    fn prescribe_rates(&mut self, end_of_pass: f64) -> Option<(Vector, nalgebra::Quaternion<f64>)> {
        let state = &mut self.state;
        let track = &state.track;
        let end = track.first + track.steps;
        if track.steps == 0 || state.step >= end {
            if track.steps > 0 && state.step == end {
                state.body.velocity = track.end.velocity;
                state.body.angular_velocity = track.end.angular_velocity;
            }
            return None;
        }
        let dt = self.model.pass_dt;
        let elapsed = (state.step - track.first) as f64 + end_of_pass;
        let (position, orientation) = track.pose(elapsed, self.model.limits.dt);
        state.body.velocity = (position - state.body.position) / dt;
        state.body.angular_velocity = path::cayley_rate(&state.body.orientation, &orientation, dt);
        Some((position, orientation))
    }

    fn refuse_too_fast(&self) -> Result<(), Failure> {
        let body = &self.state.body;
        let (v, w) = (body.velocity, body.angular_velocity);
        let (speed, rate) = (math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
        if !(speed.is_finite() && rate.is_finite()) {
            return Err(Failure::NonFinite);
        }
        if self.model.too_fast(speed, rate) { Err(Failure::TooFast) } else { Ok(()) }
    }

    /// Copies the nodes closer than h to the projectile. A prescribed body and a fixed node cannot give way to each other: such
    /// nodes are no candidates, and their depth is noted alone.
    fn gather(&mut self) -> Result<Gathered, Failure> {
        let h = self.scene.sheet.spacing;
        let search = Search::new(&self.model.solid, &self.state.body, h, self.instructions);
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (unit_speed, dt, layout) = (self.model.unit_speed, self.model.pass_dt, &self.layout);
        let (nodes_x, nodes_y) = (self.scene.sheet.nodes_x, self.scene.sheet.nodes_y);
        let free_body = self.scene.drive == Drive::Free;
        let Blocks { hot, ranges, candidates, candidate_nodes, runs, .. } = &mut self.blocks;
        let mut slots = candidates.iter_mut().zip(candidate_nodes.iter_mut());
        let mut count = 0;
        let mut deepest = 0.0;
        for j in 0..ny {
            let y0 = weave::rest_offset(j, nodes_y);
            let [low, high] = ranges.get(j).copied().unwrap_or([0.0; 2]);
            if !search.meets_row((y0 + low) * h, (y0 + high) * h) {
                continue;
            }
            let run = runs.get(j).copied().unwrap_or([0; 4]);
            let row = layout::row(hot, chunks, j);
            let first = [weave::rest_offset(0, nodes_x), y0];
            let mut from = 0;
            while let Some(near) = search.next_near(row, from, first, h) {
                from = near + 1;
                let Some(chunk) = row.get(near) else { break };
                #[allow(clippy::needless_range_loop)] // The lane is a place in several planes.
                for lane in 0..CHUNK {
                    let i = near * CHUNK + lane;
                    let u = [chunk[0][lane], chunk[1][lane], chunk[2][lane]];
                    let x = Vector::new((weave::rest_offset(i, nodes_x) + u[0]) * h, (y0 + u[1]) * h, u[2] * h);
                    let Some((gap, normal, arm)) = search.candidate(&x) else { continue };
                    if i >= nx {
                        continue;
                    }
                    deepest = if -gap > deepest { -gap } else { deepest };
                    let fixed = in_runs(&run, i);
                    if fixed && !free_body {
                        continue;
                    }
                    let Some((slot, node)) = slots.next() else { return Err(Failure::ContactCapacity) };
                    let v = Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]);
                    let weight = layout.node_weight(i, j);
                    let candidate = Candidate {
                        displacement: u,
                        normal,
                        arm,
                        weight: if fixed { -weight } else { weight },
                        speed_before: normal.dot(&v) * unit_speed,
                        approach: if gap > 0.0 { gap } else { 0.0 } / dt,
                        effective_mass: 0.0,
                        impulse: 0.0,
                    };
                    candidate.write(slot);
                    *node = (j * nx + i) as u32;
                    count += 1;
                }
            }
        }
        Ok(Gathered { count, deepest })
    }

    /// The hot pass over all rows that are awake or next to one, with fixed nodes put back and their pull booked.
    fn sweep(&mut self) -> Report {
        let [first, end] = self.rows_to_step();
        self.place_images_above(end);
        let terms = self.terms();
        let (chunks, scene, sums) = (self.layout.chunks, &self.scene, &mut self.state.sums);
        let Blocks { hot, history, yarn, marks, carry, kept, ranges, runs, .. } = &mut self.blocks;
        carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
        let (swept, rest) = hot.split_at_mut_checked(end * chunks).unwrap_or((&mut [], &mut []));
        let rows = Rows {
            first,
            hot: swept.get_mut(first * chunks..).unwrap_or(&mut []),
            above: layout::row(rest, chunks, 0),
            history: history.get_mut(first * chunks..end * chunks).unwrap_or(&mut []),
            yarn: yarn.get(first * chunks..).unwrap_or(&[]),
            // No mark before the first failure.
            marks: marks.get(first * chunks..).filter(|_| self.failed_segments > 0).unwrap_or(&[]),
            ranges: ranges.get_mut(first..end).unwrap_or(&mut []),
            runs: runs.get(first..end).unwrap_or(&[]),
            carry,
            kept,
        };
        let report = rows.sweep(&terms, |j, pulls| {
            if scene.track_support {
                book_pulls(sums, scene, j, &pulls);
            }
        });
        self.awake = [first, end];
        report
    }

    /// The row of images above a sweep that reaches the plane.
    pub(crate) fn place_images_above(&mut self, end: usize) {
        if self.layout.y.mirrored && end == self.layout.nodes_y {
            self.place_image_row();
        }
    }

    /// The constants of a sweep.
    pub(crate) fn terms(&self) -> Terms {
        Terms {
            layout: self.layout,
            law: self.model.law,
            critical: self.model.critical,
            toe: self.model.toe,
            stiffness: self.model.mean_stiffness,
            damage_rate: self.model.mean_damage_rate,
            instructions: self.instructions,
        }
    }

    /// Awake rows and their neighbours.
    pub(crate) fn rows_to_step(&self) -> [usize; 2] {
        let ny = self.layout.nodes_y;
        let [first, end] = self.awake;
        if !self.skip_rest {
            [0, ny]
        } else if first == end {
            [0, 0]
        } else {
            [first.saturating_sub(1), (end + 1).min(ny)]
        }
    }

    /// The external load on the body during dt.
    pub(crate) fn load_body(&mut self, dt: f64) {
        let (force, torque) = (self.state.force, self.state.torque);
        if self.scene.drive == Drive::Free {
            let body = &mut self.state.body;
            body.velocity += force * (dt * self.model.inertia.inverse_mass);
            if self.model.solid.feels_torque() {
                let twist = projectile::into_body(&body.orientation, &(torque * dt));
                body.angular_velocity += twist.component_mul(&self.model.inertia.inverse_moments);
            }
        }
    }

    /// The external load's work and impulse during dt.
    pub(crate) fn book_load(&mut self, dt: f64, before: &Body) {
        let (force, torque) = (self.state.force, self.state.torque);
        if self.scene.drive == Drive::Free {
            let mean = (before.velocity + self.state.body.velocity) * 0.5;
            let mut work = force.dot(&mean) * dt;
            if self.model.solid.feels_torque() {
                let spin = (before.angular_velocity + self.state.body.angular_velocity) * 0.5;
                work += projectile::into_body(&before.orientation, &torque).dot(&spin) * dt;
            }
            self.state.sums.external_work += work;
            self.state.sums.external_impulse += force * dt;
        }
    }

    /// Adds the speed that the sweep left to every candidate's phi/dt.
    fn complete_approach(&mut self, count: usize) {
        // At least 1, so that no division by zero has to be compiled in.
        let nx = self.layout.nodes_x.max(1);
        for c in 0..count {
            let Some(node) = self.blocks.candidate_nodes.get(c).map(|&k| k as usize) else { break };
            let (_, v) = self.node(node % nx, node / nx);
            let Some(slot) = self.blocks.candidates.get_mut(c) else { break };
            let mut candidate = Candidate::read(slot);
            candidate.approach += candidate.normal.dot(&Vector::from(v)) * self.model.unit_speed;
            candidate.write(slot);
        }
    }

    /// Puts behind the others the candidates that get past an edge of the body, if both go on freely: the plane that a gap is
    /// linearised to goes on beyond the edge, and would press nodes that the body never meets. Returns how many are left.
    pub(crate) fn let_pass(&mut self, count: usize) -> usize {
        if !self.model.solid.feels_torque() {
            // A sphere has no edge.
            return count;
        }
        let body = &self.state.body;
        let passage = Passage::new(&self.model.solid, body, self.model.pass_dt);
        let (mut c, mut kept) = (0, count);
        while c < kept {
            let pressed = (self.blocks.candidates.get(c).map(Candidate::read))
                .is_some_and(|candidate| candidate.gap_rate(&body.velocity, &body.angular_velocity) < 0.0);
            let [x, y] = if pressed { self.free_way(c) } else { [Vector::zeros(); 2] };
            if pressed && passage.is_past_an_edge(&x, &y) {
                kept -= 1;
                self.blocks.swap_candidates(c, kept);
            } else {
                c += 1;
            }
        }
        kept
    }

    /// Where a candidate's node is at the pass's start and, without an impulse, at its end, m.
    fn free_way(&self, c: usize) -> [Vector; 2] {
        let nx = self.layout.nodes_x.max(1);
        let (Some(slot), Some(&node)) = (self.blocks.candidates.get(c), self.blocks.candidate_nodes.get(c)) else {
            return [Vector::zeros(); 2];
        };
        let (i, j) = (node as usize % nx, node as usize / nx);
        let ([x, y], [ux, uy, uz]) = (self.rest(i, j), Candidate::read(slot).displacement);
        let (from, way) = (Vector::new(x + ux, y + uy, uz), self.free_velocity(i, j));
        [from * self.scene.sheet.spacing, (from + way) * self.scene.sheet.spacing]
    }

    /// Velocity of a node in this pass before any impulse, spacings a pass.
    fn free_velocity(&self, i: usize, j: usize) -> Vector {
        match self.scene.integrator {
            #[cfg(feature = "implicit")]
            Integrator::Theta(rule) => self.velocity_with_forces(rule, i, j),
            _ => Vector::from(self.node(i, j).1),
        }
    }

    /// The impulses of the candidates, whose approach is known: of the first `kept`, and of those behind them that the body
    /// meets after all, because impulses have changed its rates. Returns how many there are now.
    pub(crate) fn solve_contact(&mut self, mut kept: usize, count: usize) -> (Solved, usize) {
        for _ in 0..2 {
            let solved = self.solve_first(kept);
            if kept == count {
                return (solved, kept);
            }
            let body = Body { velocity: solved.velocity, angular_velocity: solved.angular_velocity, ..self.state.body };
            let passage = Passage::new(&self.model.solid, &body, self.model.pass_dt);
            let alone = kept;
            for c in alone..count {
                let [_, y] = self.free_way(c);
                if passage.ends_inside(&y) {
                    self.blocks.swap_candidates(c, kept);
                    kept += 1;
                }
            }
            if kept == alone {
                return (solved, kept);
            }
        }
        // Enough of it: all of them, as if there were no edge.
        (self.solve_first(count), count)
    }

    /// The impulses of the first `count` candidates.
    fn solve_first(&mut self, count: usize) -> Solved {
        let slots = self.blocks.candidates.get_mut(..count).unwrap_or(&mut []);
        contact::solve(slots, &self.state.body, &self.model.inertia, self.model.node_mass, self.scene.symmetry)
    }

    /// The body's rates after contact, and what the solve took.
    pub(crate) fn take_solved(&mut self, solved: &Solved) {
        self.state.body.velocity = solved.velocity;
        self.state.body.angular_velocity = solved.angular_velocity;
        if solved.sweeps as u64 > self.state.sums.most_sweeps {
            self.state.sums.most_sweeps = solved.sweeps as u64;
        }
        self.state.sums.unconverged += u64::from(!solved.converged);
    }

    /// Moves the touched nodes and books impulse, angular impulse, work and loss. What a fixed node takes goes to its support,
    /// and the work done there, which moves nothing, is lost. Work is impulse times the mean of the rates
    /// before and after, for a free and a prescribed body alike: the two then agree to second order.
    pub(crate) fn book_contact(&mut self, count: usize, before: &Body) {
        let nx = self.layout.nodes_x.max(1);
        let body = self.state.body;
        let mean_velocity = (before.velocity + body.velocity) * 0.5;
        let mean_rate = (before.angular_velocity + body.angular_velocity) * 0.5;
        let mut impulse_sum = Vector::zeros();
        let mut arm_sum = Vector::zeros();
        let (mut work, mut loss, mut touched) = (0.0, 0.0, 0);
        for c in 0..count {
            let (Some(slot), Some(&node)) = (self.blocks.candidates.get(c), self.blocks.candidate_nodes.get(c)) else {
                break;
            };
            let candidate = Candidate::read(slot);
            if candidate.impulse <= 0.0 {
                continue;
            }
            let (impulse, normal) = (candidate.impulse, candidate.normal);
            let (i, j) = (node as usize % nx, node as usize / nx);
            let (reached, free) = self.node(i, j);
            let kick = normal * (impulse / self.model.unit_impulse);
            if let Some(flags) = self.blocks.flags.get_mut(node as usize / 32) {
                *flags |= 1 << (node % 32);
            }
            let body_speed = normal.dot(&mean_velocity) + candidate.arm.dot(&mean_rate);
            // What all images of the node give; without mirror planes it is the node's own.
            let given = impulse * candidate.images();
            impulse_sum -= normal * given;
            arm_sum -= candidate.arm * given;
            work += given * body_speed;
            touched += 1;
            if candidate.is_fixed() {
                self.pull_fixed(i, j, &kick);
                loss += given * body_speed;
                continue;
            }
            let v = [free[0] + kick.x, free[1] + kick.y, free[2] + kick.z];
            let from = candidate.displacement;
            // The theta rule has put the node in its place already.
            let u = if self.layout.implicit { reached } else { [from[0] + v[0], from[1] + v[1], from[2] + v[2]] };
            self.set_node(i, j, u, v);
            self.widen(j, u[1]);
            // From t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse alone.
            let speed_after = if self.layout.implicit {
                candidate.speed_before + normal.dot(&kick) * self.model.unit_speed
            } else {
                normal.dot(&Vector::from(v)) * self.model.unit_speed
            };
            loss -= given * (0.5 * (candidate.speed_before + speed_after) - body_speed);
        }
        self.state.sums.contacts = touched;
        if touched == 0 {
            return;
        }
        impulse_sum.component_mul_assign(&self.scene.symmetry.force_mask());
        arm_sum.component_mul_assign(&self.scene.symmetry.torque_mask());
        if self.state.watch.first.is_none() {
            let energy = before.kinetic_energy(&self.model.inertia);
            self.state.watch.touch(self.state.step, before, energy);
        }
        let sums = &mut self.state.sums;
        sums.impulses += touched;
        sums.impulse += impulse_sum;
        sums.window += impulse_sum;
        if self.model.solid.feels_torque() {
            sums.angular_impulse += projectile::out_of_body(&before.orientation, &arm_sum);
        }
        sums.work += work;
        sums.loss += loss;
    }

    /// Notes that a row holds a moving node with this y displacement.
    fn widen(&mut self, j: usize, y: f64) {
        let [first, end] = self.awake;
        self.awake = if first == end { [j, j + 1] } else { [first.min(j), end.max(j + 1)] };
        if let Some([low, high]) = self.blocks.ranges.get_mut(j) {
            *low = if y < *low { y } else { *low };
            *high = if y > *high { y } else { *high };
        }
    }

    fn move_body(&mut self, target: Option<(Vector, nalgebra::Quaternion<f64>)>) {
        let dt = self.model.pass_dt;
        let state = &mut self.state;
        match (self.scene.drive, target) {
            (Drive::Free, _) => state.body.drift(&self.model.solid, &self.model.inertia, self.scene.rotation_rule, dt),
            (Drive::Prescribed, Some((position, orientation))) => {
                state.body.position = position;
                state.body.orientation = orientation;
            }
            (Drive::Prescribed, None) => {
                state.body.position += state.body.velocity * dt;
                if self.model.solid.feels_torque() {
                    let w = state.body.angular_velocity;
                    state.body.orientation = projectile::cayley_turn(&state.body.orientation, &w, dt);
                }
            }
        }
    }

    /// At the end of a force window: keeps the largest mean force.
    fn close_window(&mut self) {
        if !self.state.step.is_multiple_of(self.model.window_steps) {
            return;
        }
        let sums = &mut self.state.sums;
        let w = sums.window;
        let mean = math::length([w.x, w.y, w.z]) / (self.model.window_steps as f64 * self.model.limits.dt);
        sums.force_peak = if mean > sums.force_peak { mean } else { sums.force_peak };
        sums.window = Vector::zeros();
    }
}

/// Books the pulls of the sheet on the two runs of fixed nodes of row j, in units of m h/dt.
pub(crate) fn book_pulls(sums: &mut Sums, scene: &Scene, j: usize, pulls: &[Vector; 2]) {
    let (kind, symmetry) = (scene.attachment.kind, scene.symmetry);
    for (side, pull) in pulls.iter().enumerate() {
        let at = weave::attachment_of(kind, scene.sheet.nodes_y, j, side);
        sums.pull_support(kind, at, &(pull * symmetry.share()), symmetry);
    }
}
