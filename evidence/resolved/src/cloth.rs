//! One ply of plain weave as curves in space, and the step.
//!
//! Each yarn is a chain of nodes joined by bars, `pieces` of them a spacing, with the axial law, damage and
//! viscosity of the network, equations (M1) to (M5), (M16) and (M17) of docs/model.md. Where yarns touch, a
//! yarn is the quadratic B-spline of its nodes, whose tangent is continuous.
//! Warp i and weft j touch at one pair of points at most, the closest ones, whose arc coordinates are kept
//! and moved along both yarns with one step of Newton's method: no search, and a pair ends where an end of a
//! broken yarn runs through it. The side on which the warp lies is kept too, so that yarns cannot pass
//! through each other.
//! Neighbours of one direction are round tubes of the yarn width: points of their material in the middle of
//! each spacing, paired anew every 16 steps, as long as no yarn of the two is broken. All contacts are linear
//! springs with some damping and Coulomb friction.
//! Leapfrog: positions at t_n, velocities at t_(n-1/2). Springs and bars have a potential; every other
//! impulse is summed for each node, and its work is that impulse times the mean of the velocities before and
//! after, so that the balance of energy tests potentials and closest points.
//! Limits: no bending stiffness, no spreading of fibres, yarns keep their width; a yarn touches its next
//! neighbour, not the next but one; the body does not turn. Contact at a crossing is at one point, between
//! round yarns of half the thickness of the ply.

use crate::body::Body;

/// A ply and its numbers, SI units.
#[derive(Clone, Default)]
pub struct Cloth {
    pub spacing: f64,
    /// Bars in a spacing, at least 3.
    pub pieces: usize,
    /// Yarns along x (warp) and along y (weft) between the clamps.
    pub yarns: [usize; 2],
    /// Modulus times area, N.
    pub stiffness: f64,
    /// kg/m of straight yarn.
    pub line_mass: f64,
    pub critical_stretch: f64,
    pub damage_rate: f64,
    /// Distance of the axes of two yarns where they touch: half the thickness of the ply.
    pub thickness: f64,
    pub width: f64,
    /// Between yarns: coefficient, and the force at a crossing without pressure, N.
    pub friction: f64,
    pub adhesion: f64,
    pub crimped: bool,
    pub pinned: bool,
    /// Without contact of yarns.
    pub bare: bool,
    /// Linear, quadratic and bending viscosity.
    pub viscosity: [f64; 3],
    /// Stiffness of a slack bar over that of a taut one.
    pub slack: f64,
    /// Part of critical damping of contacts.
    pub damping: f64,
    /// Time step over the stable one.
    pub step: f64,
    /// Natural lengths are shorter by this part, for each direction.
    pub pre_strain: [f64; 2],
    pub clamp: End,
}

impl Cloth {
    /// Length of the yarn over that of the cloth, less 1: of a cosine with the thickness as its double
    /// amplitude, to the fourth order of its slope.
    pub fn crimp(&self) -> f64 {
        let slope = std::f64::consts::PI * 0.5 * self.thickness / self.spacing;
        slope * slope / 4.0 - 3.0 * slope.powi(4) / 64.0
    }

    /// Amplitude of nodes whose bars have that crimp. The curve between them is lower: by 8 % with 3 bars a
    /// spacing, by 2 % with 6.
    fn crest(&self) -> f64 {
        let (p, part) = (self.pieces, self.spacing / self.pieces as f64);
        let wave = |k: usize| (std::f64::consts::PI * k as f64 / p as f64).cos();
        let crimp = |a: f64| (0..p).map(|k| part.hypot(a * (wave(k + 1) - wave(k)))).sum::<f64>() / self.spacing - 1.0;
        let (mut low, mut high) = (0.0, self.thickness);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if crimp(middle) < self.crimp() { low = middle } else { high = middle }
        }
        high
    }
}

/// What holds an end of a yarn; forces and velocities point away from the cloth.
#[derive(Clone, Copy, Default, PartialEq)]
#[allow(dead_code)] // The closed forms pull and move ends.
pub enum End {
    #[default]
    Held,
    /// Held up to a force, N.
    Slips(f64),
    Pulled(f64),
    Moves(f64),
}

/// One component of all nodes: position, velocity, velocity before the last kick, and what dissipation took
/// of it.
#[derive(Default)]
pub struct Axis {
    pub at: Vec<f64>,
    pub v: Vec<f64>,
    pub old: Vec<f64>,
    pub lost: Vec<f64>,
}

impl Axis {
    #[inline(always)]
    fn of(&mut self, range: &std::ops::Range<usize>) -> [&mut [f64]; 4] {
        [&mut self.at, &mut self.v, &mut self.old, &mut self.lost].map(|values| &mut values[range.clone()])
    }
}

/// A point of a yarn's curve: its middle node and the weights of three nodes for the place and the tangent.
pub struct Spot {
    pub node: usize,
    pub w: [f64; 3],
    pub d: [f64; 3],
}

impl Spot {
    /// Spot of the yarn that begins at node `first`, at the arc coordinate s in bars.
    #[inline(always)]
    pub fn new(first: usize, s: f64) -> Spot {
        let k = (s + 0.5) as usize;
        let u = s + 0.5 - k as f64;
        let w = [0.5 * (1.0 - u) * (1.0 - u), 0.5 + u * (1.0 - u), 0.5 * u * u];
        Spot { node: first + k, w, d: [u - 1.0, 1.0 - 2.0 * u, u] }
    }
    #[inline(always)]
    pub fn of(&self, values: &[f64], w: &[f64; 3]) -> f64 {
        let three = &values[self.node - 1..self.node + 2];
        w[0] * three[0] + w[1] * three[1] + w[2] * three[2]
    }
    #[inline(always)]
    pub fn add(&self, values: &mut [f64], much: f64) {
        let three = &mut values[self.node - 1..self.node + 2];
        for (value, w) in three.iter_mut().zip(self.w) {
            *value += w * much;
        }
    }
    #[inline(always)]
    pub fn square(&self) -> f64 {
        self.w.iter().map(|w| w * w).sum()
    }
    /// Whether the yarn is whole here.
    #[inline(always)]
    pub fn whole(&self, alpha: &[f64]) -> bool {
        alpha[self.node - 1] > 0.0 && alpha[self.node] > 0.0
    }
}

#[inline(always)]
pub fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

#[inline(always)]
pub fn two<T>(f: impl Fn(usize) -> T) -> [T; 2] {
    [f(0), f(1)]
}

#[inline(always)]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The closest points of a warp and a weft.
#[derive(Clone, Copy, Default)]
pub struct Crossing {
    pub on: bool,
    /// Arc coordinates on both, in bars, and their change in the last step.
    pub s: [f64; 2],
    pub rate: [f64; 2],
    /// m, and the normal force, N.
    pub depth: f64,
    pub force: f64,
}

#[derive(Default)]
pub struct Sim {
    pub cloth: Cloth,
    pub body: Body,
    pub axes: [Axis; 3],
    /// Alpha of the bar after each node; 0: broken.
    pub alpha: Vec<f64>,
    pub crossings: Vec<Crossing>,
    pub ends: Vec<[End; 2]>,
    /// Whether a yarn has a broken bar.
    pub broken: Vec<bool>,
    pub mass: f64,
    pub dt: f64,
    pub steps: u64,
    /// Nodes of a yarn of each direction, and from one yarn to the next.
    pub nodes: [usize; 2],
    pub stride: usize,
    /// Natural lengths of the bars of each direction.
    pub length: [Vec<f64>; 2],
    /// Stiffness of a crossing, of two yarns side by side, and of a node on the body, N/m.
    pub springs: [f64; 3],
    pub book: Book,
    pub side: Vec<crate::contact::Side>,
    pub near: Vec<usize>,
    /// Coefficients of the bars of the yarn at hand, elastic and viscous, and the work of dissipation on each
    /// node.
    scratch: [Vec<f64>; 3],
    work: Vec<f64>,
}

/// What left the balance, J: by damage; what contacts that ended had stored; and what the clamps rubbed away,
/// a share of the dissipation.
#[derive(Default, Clone)]
pub struct Book {
    pub damage: f64,
    pub dropped: f64,
    pub clamps: f64,
}

impl Sim {
    pub fn new(mut cloth: Cloth, body: Body) -> Sim {
        let (n, p) = (cloth.yarns, cloth.pieces);
        let nodes = [p * (n[1] + 1) + 1, p * (n[0] + 1) + 1];
        let stride = nodes[0].max(nodes[1]) + 2;
        let total = (n[0] + n[1]) * stride;
        let h = cloth.spacing;
        let crest = if cloth.crimped { cloth.crest() } else { 0.0 };
        if cloth.crimped {
            // The curve at a crest lies at 3/4 + cos/4 of its node.
            cloth.thickness = 2.0 * crest * (0.75 + 0.25 * (std::f64::consts::PI / p as f64).cos());
        }
        let mut axes: [Axis; 3] = Default::default();
        for axis in &mut axes {
            let zeros = || vec![0.0; total];
            *axis = Axis { at: zeros(), v: zeros(), old: zeros(), lost: zeros() };
        }
        for yarn in 0..n[0] + n[1] {
            let way = usize::from(yarn >= n[0]);
            let number = yarn - way * n[0];
            let sign = if (number + way) % 2 == 1 { -1.0 } else { 1.0 };
            for k in 0..nodes[way] {
                let node = yarn * stride + k;
                axes[way].at[node] = (k as f64 / p as f64 - 0.5 * (n[1 - way] + 1) as f64) * h;
                axes[1 - way].at[node] = ((number + 1) as f64 - 0.5 * (n[way] + 1) as f64) * h;
                axes[2].at[node] = sign * crest * (std::f64::consts::PI * (k as f64 / p as f64 - 1.0)).cos();
            }
        }
        let of = |way: usize| -> Vec<f64> {
            let first = way * n[0] * stride;
            (first..first + nodes[way] - 1)
                .map(|k| {
                    axes.iter().map(|a| (a.at[k + 1] - a.at[k]).powi(2)).sum::<f64>().sqrt()
                        * (1.0 - cloth.pre_strain[way])
                })
                .collect()
        };
        let length = [of(0), of(1)];
        let mean = length.iter().flatten().sum::<f64>() / (length[0].len() + length[1].len()) as f64;
        let mass = cloth.line_mass * mean;
        let unit = cloth.stiffness / h;
        let springs = [unit, 0.2 * unit, 3.0 * unit / p as f64];
        // Bars at the critical stretch, with the springs that a node can have at once.
        let bar = cloth.stiffness / mean * (1.5 * cloth.critical_stretch.powi(2) - 0.5);
        let dt = cloth.step * 2.0 / ((4.0 * bar + 1.5 * springs[0] + springs[1] + springs[2]) / mass).sqrt();
        let crossings = (0..n[0] * n[1])
            .map(|c| Crossing {
                on: !cloth.bare,
                s: [(p * (c % n[1] + 1)) as f64, (p * (c / n[1] + 1)) as f64],
                ..Crossing::default()
            })
            .collect();
        let scratch = std::array::from_fn(|_| vec![0.0; stride + 1]);
        let (ends, broken) = (vec![[cloth.clamp; 2]; n[0] + n[1]], vec![false; n[0] + n[1]]);
        let (alpha, work) = (vec![1.0; total], vec![0.0; total]);
        let sim = Sim { cloth, body, axes, alpha, crossings, ends, broken, mass, dt, nodes, stride, ..Sim::default() };
        Sim { length, springs, scratch, work, ..sim }
    }

    /// Direction, first node and nodes of a yarn.
    pub fn yarn(&self, yarn: usize) -> (usize, usize, usize) {
        let way = usize::from(yarn >= self.cloth.yarns[0]);
        (way, yarn * self.stride, self.nodes[way])
    }

    pub fn time(&self) -> f64 {
        self.steps as f64 * self.dt
    }

    pub fn step(&mut self) {
        for yarn in 0..self.ends.len() {
            self.bars(yarn);
        }
        self.body.drift(self.dt);
        if self.steps.is_multiple_of(16) {
            self.search();
        }
        self.push_body();
        self.push_sides();
        if !self.cloth.bare {
            self.push_crossings();
        }
        for yarn in 0..self.ends.len() {
            self.clamp(yarn);
        }
        self.steps += 1;
    }

    /// Books the last kick, moves the nodes of a yarn, and kicks them with its bars.
    #[inline(never)]
    fn bars(&mut self, yarn: usize) {
        let (way, first, n) = self.yarn(yarn);
        let (c, dt, kick) = (&self.cloth, self.dt, self.dt / self.mass);
        let range = first..first + n;
        let work = &mut self.work[range.clone()];
        for axis in &mut self.axes {
            let [at, v, old, lost] = axis.of(&range);
            for k in 0..n {
                work[k] += lost[k] * (old[k] + v[k]);
                lost[k] = 0.0;
                old[k] = v[k];
                at[k] += dt * v[k];
            }
        }
        let [x, y, z] = [0, 1, 2].map(|a| &self.axes[a].at[range.clone()]);
        let [u, v, w] = [0, 1, 2].map(|a| &self.axes[a].old[range.clone()]);
        let alpha = &mut self.alpha[range.clone()];
        let length = &self.length[way][..n - 1];
        let speed = (c.stiffness / c.line_mass).sqrt();
        let (linear, quadratic) = (c.viscosity[0] * c.line_mass * speed, c.viscosity[1] * c.line_mass);
        let critical = c.critical_stretch * c.critical_stretch - 1.0;
        let [elastic, viscous, moment] = &mut self.scratch;
        // Bar k stands at k + 1, with a zero before and after.
        let (te, tg) = (&mut elastic[..n + 1], &mut viscous[..n + 1]);
        let mut over = 0_u32;
        for k in 0..n - 1 {
            let (dx, dy, dz) = (x[k + 1] - x[k], y[k + 1] - y[k], z[k + 1] - z[k]);
            let (ex, ey, ez) = (u[k + 1] - u[k], v[k + 1] - v[k], w[k + 1] - w[k]);
            let one = 1.0 / length[k];
            let q = (dx * dx + dy * dy + dz * dz) * one * one - 1.0;
            let rate = (dx * ex + dy * ey + dz * ez) * one * one;
            let a = alpha[k];
            let pull = a * 0.5 * c.stiffness * one * q * if q > 0.0 { 1.0 } else { c.slack };
            let drag = a * (linear * rate + if rate > 0.0 { quadratic * length[k] * rate * rate } else { 0.0 });
            te[k + 1] = pull;
            // A bar never pushes with its viscosity, and a slack one has none.
            tg[k + 1] = if q > 0.0 { if drag < -pull { -pull } else { drag } } else { 0.0 };
            over += u32::from(a * (q - critical) > 0.0);
        }
        (te[0], tg[0], te[n], tg[n]) = (0.0, 0.0, 0.0, 0.0);
        if over > 0 {
            for k in 0..n - 1 {
                let (dx, dy, dz) = (x[k + 1] - x[k], y[k + 1] - y[k], z[k + 1] - z[k]);
                let q = (dx * dx + dy * dy + dz * dz) / (length[k] * length[k]) - 1.0;
                let mut left = (-c.damage_rate * ((1.0 + q).sqrt() - c.critical_stretch)).exp();
                if alpha[k] > 0.0 && q > critical && left < alpha[k] {
                    left = if left <= 0.01 { 0.0 } else { left };
                    // What was stored at the middle of the last drift.
                    let rate = dx * (u[k + 1] - u[k]) + dy * (v[k + 1] - v[k]) + dz * (w[k + 1] - w[k]);
                    let middle = q - dt * rate / (length[k] * length[k]);
                    self.book.damage += (alpha[k] - left) * 0.125 * c.stiffness * length[k] * middle * middle;
                    (te[k + 1], tg[k + 1]) = (te[k + 1] * left / alpha[k], tg[k + 1] * left / alpha[k]);
                    alpha[k] = left;
                    if left == 0.0 {
                        self.broken[yarn] = true;
                    }
                }
            }
        }
        let stiff = c.viscosity[2] * c.line_mass * speed;
        let m = &mut moment[..n];
        for axis in &mut self.axes {
            let [at, v, old, lost] = axis.of(&range);
            (m[0], m[n - 1]) = (0.0, 0.0);
            for k in 1..n - 1 {
                m[k] = stiff * alpha[k - 1] * alpha[k] * (old[k - 1] - 2.0 * old[k] + old[k + 1]);
            }
            for k in 1..n - 1 {
                let (before, after) = (at[k] - at[k - 1], at[k + 1] - at[k]);
                let drag = kick * (tg[k + 1] * after - tg[k] * before + 2.0 * m[k] - m[k - 1] - m[k + 1]);
                v[k] += kick * (te[k + 1] * after - te[k] * before) + drag;
                lost[k] += drag;
            }
            for (k, one, sign) in [(0, 1, 1.0), (n - 1, n - 2, -1.0)] {
                let span = sign * (at[k.max(one)] - at[k.min(one)]);
                let bar = k.max(one);
                let drag = kick * (tg[bar] * span - m[one]);
                v[k] += kick * te[bar] * span + drag;
                lost[k] += drag;
            }
        }
    }

    #[inline(never)]
    fn clamp(&mut self, yarn: usize) {
        let (way, first, n) = self.yarn(yarn);
        let kick = self.dt / self.mass;
        for side in 0..2 {
            let (node, out) = if side == 0 { (first, -1.0) } else { (first + n - 1, 1.0) };
            let mut next = [0.0; 3];
            let along = &self.axes[way];
            match self.ends[yarn][side] {
                End::Held => {}
                End::Moves(velocity) => next[way] = out * velocity,
                End::Pulled(force) => next[way] = along.v[node] + out * kick * force,
                End::Slips(force) => {
                    let most = kick * force;
                    next[way] = along.v[node] - along.v[node].clamp(-most, most);
                    self.book.clamps += 0.5 * self.mass * (along.v[node] - next[way]) * (along.old[node] + next[way]);
                }
            }
            for (axis, next) in self.axes.iter_mut().zip(next) {
                axis.lost[node] += next - axis.v[node];
                axis.v[node] = next;
            }
        }
    }

    /// Strain energy of all bars.
    pub fn strain(&self) -> f64 {
        let mut sum = 0.0;
        for yarn in 0..self.ends.len() {
            let (way, first, n) = self.yarn(yarn);
            for k in 0..n - 1 {
                let q = self.q(first + k, self.length[way][k]);
                let stiffness = self.cloth.stiffness * if q > 0.0 { 1.0 } else { self.cloth.slack };
                sum += self.alpha[first + k] * 0.125 * stiffness * self.length[way][k] * q * q;
            }
        }
        sum
    }

    fn q(&self, node: usize, length: f64) -> f64 {
        self.axes.iter().map(|a| (a.at[node + 1] - a.at[node]).powi(2)).sum::<f64>() / (length * length) - 1.0
    }

    /// Tension of bar k of a yarn, N.
    #[cfg(test)]
    pub fn tension(&self, yarn: usize, k: usize) -> f64 {
        let (way, first, _) = self.yarn(yarn);
        let q = self.q(first + k, self.length[way][k]);
        if q > 0.0 { self.alpha[first + k] * self.cloth.stiffness * 0.5 * q * (1.0 + q).sqrt() } else { 0.0 }
    }

    /// Kinetic energy of the yarns at t_n, and what dissipation has taken till then.
    pub fn kinetic(&self) -> (f64, f64) {
        let (mut sum, mut half) = (0.0, 0.0);
        for axis in &self.axes {
            for k in 0..axis.v.len() {
                sum += axis.v[k] * axis.v[k] + axis.old[k] * axis.old[k];
                half += axis.lost[k] * (axis.old[k] + axis.v[k]);
            }
        }
        (0.25 * self.mass * sum, -0.5 * self.mass * (self.work.iter().sum::<f64>() + 0.5 * half))
    }

    /// All energy, with what was dissipated, J.
    pub fn energy(&self) -> f64 {
        let (kinetic, taken) = self.kinetic();
        kinetic + taken + self.strain() + self.stored() + self.body.energy() + self.book.damage + self.book.dropped
    }
}
