//! Contacts: of warp and weft, of yarns side by side, and with the body.

use crate::cloth::{Crossing, Sim, Spot, dot, three, two};

/// A point of one yarn, in the middle of a spacing, and one of the next yarn. Both are of the yarns' material
/// between two searches.
#[derive(Clone, Copy)]
pub struct Side {
    first: [usize; 2],
    s: [f64; 2],
}

/// Where two yarns touch, how deep, and the normal that pushes the first one away.
struct Touch {
    spots: [Spot; 2],
    depth: f64,
    normal: [f64; 3],
    shift: [f64; 2],
}

const BEND: [f64; 3] = [1.0, -2.0, 1.0];
/// Most that an arc coordinate moves in a step, bars.
const MOST: f64 = 0.25;

impl Sim {
    #[inline(always)]
    fn of(&self, spot: &Spot, w: &[f64; 3]) -> [f64; 3] {
        three(|a| spot.of(&self.axes[a].at, w))
    }

    /// The closest points of crossing c, from the arc coordinates s on; None where a yarn ends or is broken,
    /// and where they have parted.
    #[inline(always)]
    fn closest(&self, c: usize, s: [f64; 2]) -> Option<Touch> {
        let yarns = self.cloth.yarns;
        let (warp, weft) = (c / yarns[1], c % yarns[1]);
        let inside = |way: usize| s[way] >= 1.0 && s[way] <= (self.nodes[way] - 2) as f64;
        if !inside(0) || !inside(1) {
            return None;
        }
        let spots = [Spot::new(warp * self.stride, s[0]), Spot::new((yarns[0] + weft) * self.stride, s[1])];
        if !spots[0].whole(&self.alpha) || !spots[1].whole(&self.alpha) {
            return None;
        }
        if self.cloth.pinned {
            return Some(Touch { spots, depth: 0.0, normal: [0.0; 3], shift: [0.0; 2] });
        }
        let [place, other] = two(|k| self.of(&spots[k], &spots[k].w));
        let [p, r] = two(|k| self.of(&spots[k], &spots[k].d));
        let [bend_p, bend_r] = two(|k| self.of(&spots[k], &BEND));
        let mut d = three(|a| place[a] - other[a]);
        // Newton's method for the smallest distance, with a Hessian that stays positive.
        let (pp, pr, rr) = (dot(p, p), dot(p, r), dot(r, r));
        let (a, b) = ((pp + dot(d, bend_p)).max(0.3 * pp), (rr - dot(d, bend_r)).max(0.3 * rr));
        let (dp, dr) = (dot(d, p), dot(d, r));
        let det = (a * b - pr * pr).max(0.02 * a * b);
        let shift = [(dr * pr - dp * b) / det, (dr * a - dp * pr) / det].map(|x| x.clamp(-MOST, MOST));
        for k in 0..3 {
            d[k] += shift[0] * p[k] - shift[1] * r[k];
        }
        let up = if (warp + weft) % 2 == 0 { 1.0 } else { -1.0 };
        let across = [p[1] * r[2] - p[2] * r[1], p[2] * r[0] - p[0] * r[2], p[0] * r[1] - p[1] * r[0]];
        let distance = dot(d, d).sqrt();
        let side = if up * dot(d, across) < 0.0 { -1.0 } else { 1.0 };
        // Only the loose end of a broken yarn moves so fast, or around the other yarn.
        if shift.iter().any(|x| x.abs() == MOST) || side < 0.0 && distance > 0.3 * self.cloth.thickness {
            return None;
        }
        let normal = if distance > 1e-3 * self.cloth.thickness {
            d.map(|x| side * x / distance)
        } else {
            across.map(|x| up * x / dot(across, across).sqrt())
        };
        Some(Touch { spots, depth: self.cloth.thickness - side * distance, normal, shift })
    }

    /// Two points of yarns side by side, and how far the second must move along its yarn to be the closest
    /// one.
    fn beside(&self, side: &Side) -> Touch {
        let spots = two(|k| Spot::new(side.first[k], side.s[k]));
        let [place, other] = two(|k| self.of(&spots[k], &spots[k].w));
        let r = self.of(&spots[1], &spots[1].d);
        let d = three(|a| place[a] - other[a]);
        let shift = (dot(d, r) / dot(r, r)).clamp(-MOST, MOST);
        let distance = dot(d, d).sqrt().max(1e-12);
        Touch { spots, depth: self.cloth.width - distance, normal: d.map(|x| x / distance), shift: [0.0, shift] }
    }

    /// Kicks two yarns that touch: spring, damping and friction. Gives the normal force.
    #[inline(always)]
    fn kick(&mut self, touch: &Touch, spring: f64, adhesion: f64) -> f64 {
        let [a, b] = &touch.spots;
        let n = touch.normal;
        let relative = three(|k| a.of(&self.axes[k].v, &a.w) - b.of(&self.axes[k].v, &b.w));
        let mass = self.mass / (a.square() + b.square());
        let (elastic, normal) = (spring * touch.depth.max(0.0), dot(relative, n));
        let force = (elastic - self.cloth.damping * 2.0 * (spring * mass).sqrt() * normal).max(0.0);
        let force = if touch.depth > 0.0 { force } else { 0.0 };
        let slip = three(|k| relative[k] - normal * n[k]);
        let speed = dot(slip, slip).sqrt();
        let rub = ((adhesion + self.cloth.friction * force) * self.dt).min(mass * speed);
        let along = if speed > 0.0 { rub / speed } else { 0.0 };
        let part = 1.0 / self.mass;
        for k in 0..3 {
            let lost = (force - elastic) * self.dt * n[k] - along * slip[k];
            let all = elastic * self.dt * n[k] + lost;
            for (spot, sign) in [(a, part), (b, -part)] {
                spot.add(&mut self.axes[k].v, sign * all);
                spot.add(&mut self.axes[k].lost, sign * lost);
            }
        }
        force
    }

    /// Ends the motion of two points of yarns relative to each other.
    fn tie(&mut self, [a, b]: &[Spot; 2]) {
        let part = 1.0 / (a.square() + b.square());
        for axis in &mut self.axes {
            let lost = part * (b.of(&axis.v, &b.w) - a.of(&axis.v, &a.w));
            for (spot, sign) in [(a, 1.0), (b, -1.0)] {
                spot.add(&mut axis.v, sign * lost);
                spot.add(&mut axis.lost, sign * lost);
            }
        }
    }

    #[inline(never)]
    pub fn push_crossings(&mut self) {
        let thickness = self.cloth.thickness;
        for c in 0..self.crossings.len() {
            if !self.crossings[c].on {
                continue;
            }
            let Crossing { s, rate, .. } = self.crossings[c];
            let ahead = [s[0] + rate[0], s[1] + rate[1]];
            let Some(touch) = self.closest(c, ahead) else {
                let depth = self.crossings[c].depth;
                self.book.dropped += 0.5 * self.springs[0] * depth * depth;
                self.crossings[c] = Crossing { on: false, depth: 0.0, force: 0.0, ..self.crossings[c] };
                continue;
            };
            if self.cloth.pinned {
                self.tie(&touch.spots);
                continue;
            }
            let moved = two(|k| ahead[k] + touch.shift[k]);
            let touches = touch.depth > -0.01 * thickness;
            let force = if touches { self.kick(&touch, self.springs[0], self.cloth.adhesion) } else { 0.0 };
            let crossing = &mut self.crossings[c];
            crossing.rate = two(|k| (moved[k] - s[k]).clamp(-MOST, MOST));
            crossing.s = moved;
            (crossing.depth, crossing.force) = (touch.depth.max(0.0), force);
        }
    }

    pub fn push_sides(&mut self) {
        for k in 0..self.side.len() {
            let touch = self.beside(&self.side[k]);
            if touch.depth > 0.0 {
                self.kick(&touch, self.springs[1], 0.0);
            }
        }
    }

    pub fn push_body(&mut self) {
        let off = 0.5 * self.cloth.thickness;
        let (spring, mass) = (self.springs[2], self.mass);
        for &node in &self.near {
            let p = three(|a| self.axes[a].at[node] - self.body.at[a]);
            let Some((depth, n)) = self.body.depth(p, off) else { continue };
            let relative = three(|a| self.axes[a].v[node] - self.body.v[a]);
            let (elastic, normal) = (spring * depth, dot(relative, n));
            let force = (elastic - self.cloth.damping * 2.0 * (spring * mass).sqrt() * normal).max(0.0);
            let slip = three(|a| relative[a] - normal * n[a]);
            let speed = dot(slip, slip).sqrt();
            let rub = (self.body.friction * force * self.dt).min(mass * speed);
            let along = if speed > 0.0 { rub / speed } else { 0.0 };
            for a in 0..3 {
                let lost = (force - elastic) * self.dt * n[a] - along * slip[a];
                let all = elastic * self.dt * n[a] + lost;
                self.axes[a].v[node] += all / mass;
                self.axes[a].lost[node] += lost / mass;
                self.body.v[a] -= all / self.body.mass;
                self.body.lost[a] -= lost / self.body.mass;
            }
        }
    }

    /// Nodes near the body, and pairs of yarns side by side, whose second points move to the closest ones. A
    /// new pair must not touch yet, and broken yarns have none. What this changes of the energy is booked.
    #[inline(never)]
    pub fn search(&mut self) {
        let margin = 0.5 * self.cloth.spacing;
        let (mut near, mut sides) = (std::mem::take(&mut self.near), Vec::with_capacity(self.side.len()));
        let mut known = self.side.iter().peekable();
        let p = self.cloth.pieces;
        near.clear();
        for yarn in 0..self.ends.len() {
            let (way, first, n) = self.yarn(yarn);
            near.extend(
                (first + 1..first + n - 1)
                    .filter(|&node| self.body.near(three(|a| self.axes[a].at[node] - self.body.at[a]), margin)),
            );
            let last = yarn + 1 == self.ends.len() || yarn + 1 == self.cloth.yarns[0];
            if self.cloth.bare || last || self.broken[yarn] || self.broken[yarn + 1] {
                while known.next_if(|side| side.first[0] == first).is_some() {}
                continue;
            }
            let across = &self.axes[1 - way].at;
            let reach = self.cloth.width + 0.2 * self.cloth.spacing;
            for station in 1..(n - 1) / p - 1 {
                let s = (station * p) as f64 + 0.5 * p as f64;
                let (k, next) = (s as usize, first + self.stride);
                let old = known.next_if(|side| side.first[0] == first && side.s[0] == s);
                if across[next + k] - across[first + k] > reach {
                    continue;
                }
                let mut side = old.copied().unwrap_or(Side { first: [first, next], s: [s, s] });
                for _ in 0..if old.is_some() { 1 } else { 8 } {
                    side.s[1] = (side.s[1] + self.beside(&side).shift[1]).clamp(p as f64, (n - 1 - p) as f64);
                }
                if old.is_some() || self.beside(&side).depth <= 0.0 {
                    sides.push(side);
                }
            }
        }
        let before = self.stored_beside();
        (self.near, self.side) = (near, sides);
        self.book.dropped += before - self.stored_beside();
    }

    fn stored_beside(&self) -> f64 {
        self.side.iter().map(|side| 0.5 * self.springs[1] * self.beside(side).depth.max(0.0).powi(2)).sum()
    }

    /// Energy of all springs of contacts, J.
    pub fn stored(&self) -> f64 {
        let crossings: f64 = (0..self.crossings.len())
            .filter(|&c| self.crossings[c].on && !self.cloth.bare)
            .filter_map(|c| self.closest(c, self.crossings[c].s))
            .map(|touch| 0.5 * self.springs[0] * touch.depth.max(0.0).powi(2))
            .sum();
        let off = 0.5 * self.cloth.thickness;
        let body: f64 = self
            .near
            .iter()
            .filter_map(|&node| self.body.depth(three(|a| self.axes[a].at[node] - self.body.at[a]), off))
            .map(|(depth, _)| 0.5 * self.springs[2] * depth * depth)
            .sum();
        crossings + body + self.stored_beside()
    }
}
