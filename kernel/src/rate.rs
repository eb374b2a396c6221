//! Rate of strain: yarn that is stiffer and bears more strain the faster it is loaded, by the logarithm of the rate.
//!
//! Method: the rate of a segment is its mean rate since the load began, r = (e - e_0)/t, with the Green-Lagrange strain e, that of
//! the flat sheet e_0, and the time t since the first contact or since motion was given by hand. So it needs no history, and, as
//! the momentary rate is not, it is no matter of the oscillation of the network. With L = ln(r/r_0), held within 0 and ln(r_1/r_0):
//!   S = alpha E e (1 + C_E L), and damage sees the strain e/(1 + C_U L).
//! At a fixed strain the stress falls with the logarithm of the time: yarn relaxes. The strain energy W(e, t) is the integral of S
//! over e; -dW/dt = alpha E C_E (c^2 - a^2)/(2t) is what relaxation takes, with c the strain held within a = e(r_0) and
//! b = e(r_1). It is never negative, so no way of loading gains energy. A segment breaks at a higher strain than damage sees, and
//! what rupture dissipates beyond the law of the reference rate is taken too.
//! Before a pass the logarithms of its rows are found, and what is taken in them; the sweep reads the logarithms.
//! Limits: one event that begins with the first contact. Velocity Verlet; no toe, no pre-tension.
//! Reference: docs/model.md, "Rate of strain".

use crate::direction::Directions;
use crate::lanes::{self, Job, Lane};
use crate::math;
use crate::planes::{self, Axis, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, RATE_PLANES, vertical_axes};
use crate::rows::place_image_column;
use crate::scene::Scene;
use crate::sweep::{Constants, NOTHING, YarnRow};
use crate::symmetry::Line;
use crate::system::System;
use crate::viscosity::{at, put, to_the_right, upwards};
use crate::yarn::{self, Segment};

/// The limit from which the sweep looks for damage lies so much lower than it could: rounding must hide none.
const ROUNDING: f64 = 1e-12;

/// (M19) The law of the segments of one direction at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLaw {
    /// C_E.
    modulus: f64,
    /// C_U.
    stretch: f64,
    /// q of the flat sheet, at most 0.
    rest: f64,
    /// Change of q since then at the reference rate, 2 r_0 t.
    least: f64,
    /// Its inverse; 0 for no dependence on the rate.
    per_least: f64,
    /// r_1/r_0, at least 1.
    ratio: f64,
    /// Its logarithm.
    largest: f64,
}

impl RateLaw {
    /// No dependence on the rate.
    pub const NONE: RateLaw =
        RateLaw { modulus: 0.0, stretch: 0.0, rest: 0.0, least: 1.0, per_least: 0.0, ratio: 1.0, largest: 0.0 };

    /// The law of a scene for segments with this q in the flat sheet, at a time, s, since the load began.
    pub fn of(scene: &Scene, rest: f64, time: f64) -> RateLaw {
        if !scene.depends_on_rate() {
            return RateLaw::NONE;
        }
        let yarn = &scene.yarn;
        let (ratio, least) = (yarn.rate_limit / yarn.rate_reference, 2.0 * yarn.rate_reference * time);
        RateLaw {
            modulus: yarn.rate_modulus,
            stretch: yarn.rate_stretch,
            rest,
            least,
            per_least: 1.0 / least,
            ratio,
            largest: math::ln(ratio),
        }
    }

    /// L, the logarithm of the rate over the reference rate.
    #[inline(always)]
    pub fn logarithm<L: Lane>(&self, q: L) -> L {
        let over = q.sub(L::splat(self.rest)).mul(L::splat(self.per_least));
        let over = over.max(L::splat(1.0)).min(L::splat(self.ratio));
        let mut group = L::ZEROS;
        over.store(&mut group);
        for x in group.as_mut() {
            *x = if *x <= 1.0 {
                0.0
            } else if *x >= self.ratio {
                self.largest
            } else {
                math::ln(*x)
            };
        }
        L::load(&group)
    }

    /// Stiffness over that at the reference rate, at this logarithm.
    #[inline(always)]
    pub fn stiffening<L: Lane>(&self, logarithm: L) -> L {
        L::splat(self.modulus).mul(logarithm).add(L::splat(1.0))
    }

    /// The q that damage sees, at this logarithm.
    pub fn seen(&self, q: f64, logarithm: f64) -> f64 {
        q / (1.0 + self.stretch * logarithm)
    }

    /// The q that damage sees.
    pub fn seen_at(&self, q: f64) -> f64 {
        self.seen(q, self.logarithm(q))
    }

    /// A q below which damage sees none beyond this critical one.
    pub fn limit(&self, critical: f64) -> f64 {
        let limit = critical * (1.0 + self.stretch * self.logarithm(critical));
        if limit > critical { limit * (1.0 - ROUNDING) } else { critical }
    }

    /// Strain energy W, the integral of stress over strain. `stiffness`: half of alpha E.
    pub fn stored(&self, stiffness: f64, q: f64) -> f64 {
        let base = yarn::strain_energy(stiffness, q);
        if self.modulus == 0.0 || q <= 0.0 {
            return base;
        }
        // x = q - q_0 from where the yarn is taut and faster than the reference rate, up to the present or to the highest rate.
        let first = math::max(self.least, -self.rest);
        let last = math::min(q - self.rest, self.least * self.ratio);
        let integral = |x: f64| {
            let logarithm = math::ln(x * self.per_least);
            0.5 * x * x * (logarithm - 0.5) + self.rest * x * (logarithm - 1.0)
        };
        let growing = if last > first { integral(last) - integral(first) } else { 0.0 };
        let [_, held] = self.range();
        let beyond = if q > held { 0.5 * self.largest * (q * q - held * held) } else { 0.0 };
        base + 0.5 * stiffness * self.modulus * (growing + beyond)
    }

    /// What relaxation takes while the logarithm of the time grows by 1, in units of [`RateLaw::stored`].
    #[inline(always)]
    pub fn relaxing<L: Lane>(&self, stiffness: L, q: L) -> L {
        let [first, last] = self.range();
        let held = q.max(L::splat(first)).min(L::splat(last));
        stiffness.mul(held.mul(held).sub(L::splat(first * first))).mul(L::splat(0.25 * self.modulus))
    }

    /// q of taut yarn at the reference rate and at the highest.
    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [math::max(self.rest + self.least, 0.0), math::max(self.rest + self.least * self.ratio, 0.0)]
    }

    /// What rupture dissipates at q beyond what it would at the strain that damage sees, over the latter.
    fn excess(&self, q: f64, seen: f64) -> f64 {
        self.stored(1.0, q) / yarn::strain_energy(1.0, seen) - 1.0
    }
}

/// What a sweep needs of the law at its time.
#[derive(Clone, Copy)]
pub struct Rates {
    /// Along x and along y.
    pub laws: [RateLaw; 2],
    /// q of horizontal and vertical segments from which damage is looked for.
    pub limits: [f64; 2],
}

impl Rates {
    /// Of a system at t_n.
    pub(crate) fn of(system: &System<'_>) -> Rates {
        let laws = [Axis::Horizontal, Axis::Vertical].map(|axis| system.rate_law(axis));
        let [h, v] = [&system.directions.horizontal, &system.directions.vertical].map(|direction| direction.critical);
        Rates { laws, limits: [laws[0].limit(h), laws[1].limit(v)] }
    }

    /// The law of one direction.
    pub fn along(&self, axis: Axis) -> &RateLaw {
        match axis {
            Axis::Horizontal => &self.laws[0],
            Axis::Vertical => &self.laws[1],
        }
    }
}

/// Finds the logarithms of rows [first, end), all that may move, and what the rate takes of each in this pass.
pub(crate) fn find_rates(system: &mut System<'_>, [first, end]: [usize; 2]) {
    let (layout, chunks) = (system.layout, system.layout.chunks);
    let rates = Rates::of(system);
    // The growth of ln t; none before the load has begun.
    let passed = if system.state.loaded > 0 { system.model.pass_dt / system.load_time() } else { 0.0 };
    let squares = [Axis::Horizontal, Axis::Vertical].map(|axis| {
        let length = system.directions.along(axis).rest.length;
        length * length
    });
    for j in first..end {
        let ends = system.ends_of_segments(j);
        let System { directions, blocks, instructions, .. } = &mut *system;
        if layout.x.mirrored {
            place_image_column(planes::row_mut(blocks.hot, chunks, j), layout.x);
        }
        let constants = if layout.stochastic {
            Constants::Stochastic(planes::row(blocks.yarn, chunks, j))
        } else {
            Constants::Uniform(directions)
        };
        let yarn = YarnRow { constants, strength: planes::row(blocks.strength, chunks, j), logarithms: &[] };
        let (row, above) = (planes::row(blocks.hot, chunks, j), planes::row(blocks.hot, chunks, j + 1));
        let history = planes::row(blocks.history, chunks, j);
        let found = planes::row_mut(blocks.logarithms, chunks, j);
        let line = layout.x;
        let [relaxing, broken] = lanes::dispatch(
            *instructions,
            RowJob { directions, rates: &rates, row, above, history, yarn: &yarn, ends, line, found },
        );
        let taken = [0, 1].map(|k| (relaxing[k] * passed + broken[k]) * squares[k]);
        if let Some(slot) = blocks.taken.get_mut(j) {
            *slot = taken[0] * layout.y.node_weight(j) + taken[1] * layout.y.segment_weight(j);
        }
    }
}

/// The logarithms of the segments that start in a row. Gives of horizontal and of vertical segments what relaxation takes by the
/// growth of ln t, and what rupture does.
struct RowJob<'a> {
    directions: &'a Directions,
    rates: &'a Rates,
    row: &'a [Chunk<HOT_PLANES>],
    /// The row above; empty for the top row.
    above: &'a [Chunk<HOT_PLANES>],
    history: &'a [Chunk<HISTORY_PLANES>],
    yarn: &'a YarnRow<'a>,
    /// Horizontal and vertical segments start before these columns.
    ends: [usize; 2],
    line: Line,
    found: &'a mut [Chunk<RATE_PLANES>],
}

impl Job for RowJob<'_> {
    type Output = [[f64; 2]; 2];

    #[inline(always)]
    fn run<L: Lane>(self) -> [[f64; 2]; 2] {
        let RowJob { directions, rates, row, above, history, yarn, ends, line, found } = self;
        let (rest_h, rest_v) = (&directions.horizontal.rest, &directions.vertical.rest);
        let [law_h, law_v] = &rates.laws;
        let mut cold = Cold { directions, rates, yarn, ends, line, broken: [0.0; 2] };
        let mut relaxing = [[0.0; CHUNK]; 2];
        for (c, ((chunk, history), found)) in row.iter().zip(history).zip(found).enumerate() {
            let next = row.get(c + 1).unwrap_or(&NOTHING);
            let above = above.get(c).unwrap_or(&NOTHING);
            for g in 0..CHUNK / L::WIDTH {
                let column = c * CHUNK + g * L::WIDTH;
                let q_h = rest_h.twice_strain(to_the_right(chunk, next, 0, g));
                let q_v = rest_v.twice_strain(vertical_axes(upwards(chunk, above, 0, g)));
                for (k, q, law) in [(0, q_h, law_h), (1, q_v, law_v)] {
                    let logarithm = law.logarithm(q);
                    put(found, k, g, logarithm);
                    let sum: L = at(&relaxing, k, g);
                    put(&mut relaxing, k, g, sum.add(law.relaxing(at(chunk, 6 + k, g), q)));
                    let largest: L = at(history, k, g);
                    if q.any_not_below(L::splat(rates.limits[k])) && q.any_above(largest) {
                        cold.rupture(k, column, q, logarithm, largest);
                    }
                }
            }
        }
        let mut relaxing = relaxing.map(|columns| columns.iter().sum::<f64>());
        if line.mirrored {
            // All columns but the last are there twice.
            let (across, up) = (ends[0].saturating_sub(1), ends[1].saturating_sub(1));
            let d_h = difference(row, across, row, across + 1);
            let d_v = difference(row, up, above, up);
            let last = [
                (2.0 - line.segment_weight(across)) * last_relaxing(law_h, row, 6, across, rest_h.twice_strain(d_h)),
                (2.0 - line.node_weight(up))
                    * last_relaxing(law_v, row, 7, up, rest_v.twice_strain(vertical_axes(d_v))),
            ];
            relaxing = [2.0 * relaxing[0] - last[0], 2.0 * relaxing[1] - last[1]];
        }
        [relaxing, cold.broken]
    }
}

/// What relaxation takes of the segment that starts in this column.
fn last_relaxing(law: &RateLaw, row: &[Chunk<HOT_PLANES>], plane: usize, column: usize, q: f64) -> f64 {
    law.relaxing(planes::get(row, plane, column).unwrap_or(0.0), q)
}

/// Displacement of node `j` of row `to` relative to node `i` of row `from`.
fn difference(from: &[Chunk<HOT_PLANES>], i: usize, to: &[Chunk<HOT_PLANES>], j: usize) -> [f64; 3] {
    [0, 1, 2].map(|plane| planes::get(to, plane, j).unwrap_or(0.0) - planes::get(from, plane, i).unwrap_or(0.0))
}

/// What only segments need that break further.
struct Cold<'a> {
    directions: &'a Directions,
    rates: &'a Rates,
    yarn: &'a YarnRow<'a>,
    ends: [usize; 2],
    line: Line,
    /// Energy so far, of horizontal and of vertical segments.
    broken: [f64; 2],
}

impl Cold<'_> {
    /// A lane group in which some segment may break further in this pass: what that dissipates beyond the law of the reference
    /// rate, which the balance counts (`energy.rs`).
    #[cold]
    #[inline(never)]
    fn rupture<L: Lane>(&mut self, k: usize, column: usize, q: L, logarithm: L, largest: L) {
        let axis = if k == 0 { Axis::Horizontal } else { Axis::Vertical };
        let (law, rate) = (&self.directions.along(axis).law, self.rates.along(axis));
        let (mut qs, mut logarithms, mut histories) = (L::ZEROS, L::ZEROS, L::ZEROS);
        q.store(&mut qs);
        logarithm.store(&mut logarithms);
        largest.store(&mut histories);
        let lanes = qs.as_ref().iter().zip(logarithms.as_ref()).zip(histories.as_ref());
        for (lane, ((&q, &logarithm), &history)) in lanes.enumerate() {
            let i = column + lane;
            let seen = rate.seen(q, logarithm);
            if i >= self.ends[k] || !law.is_damaging(seen, history) {
                continue;
            }
            let (undamaged, damage_rate) = self.yarn.constants(axis, i);
            let law = law.at(self.yarn.critical_stretch(law, axis, i));
            let weight = if k == 0 { self.line.segment_weight(i) } else { self.line.node_weight(i) };
            // Twice the stiffness stands for the modulus: energies are then those of `RateLaw::stored`.
            let material = Segment { modulus: 2.0 * undamaged, damage_rate };
            let dissipated = |q: f64| law.dissipated(&material, law.alpha(damage_rate, q));
            self.broken[k] += weight * rate.excess(q, seen) * (dissipated(seen) - dissipated(history));
        }
    }
}
