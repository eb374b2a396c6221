//! The one hot pass: damage, kick and drift of every node, row by row, in place. Knows nothing of contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in h/dt. For a
//! segment with relative displacement d of its ends, d_a along its rest direction, q = U^2 - 1 = d_a (d_a + 2) + d_b^2 + d_c^2
//! (the components in the order x, y, z behind the axial one), and its force adds kk max(q, 0) (e_a + d) to the velocity of
//! its first node, where kk = alpha E A_0 dt^2 / (2 m h). No root and no division below the critical stretch.
//! Each segment is computed once: the horizontal force is carried along the row, the vertical one to the row above.
//! Order of one node's sum: (right - left) + (up - down), exactly mirror-symmetric.
//! Limits: dt <= 0.5 dt_crit (see `scene.rs`). A non-finite q is reported, never swallowed.
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::layout::{HISTORY_PLANES, HOT_PLANES, PAD, YARN_PLANES};
use crate::yarn::DamageLaw;

/// What one pass met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Segments whose alpha became 0.
    pub newly_failed: u64,
    /// A non-finite q was met: the state is lost.
    pub non_finite: bool,
}

/// Where a row's segments find their constants.
#[derive(Clone, Copy)]
pub enum YarnRow<'a> {
    /// All alike.
    Uniform {
        /// Undamaged stiffness kk.
        stiffness: f64,
        /// Damage rate.
        damage_rate: f64,
    },
    /// [kh, kv, lambda_h, lambda_v] planes of the row.
    Stochastic(&'a [f64]),
}

/// Direction of a segment.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// To the right-hand neighbour, along x.
    Horizontal = 0,
    /// To the neighbour above, along y.
    Vertical = 1,
}

impl YarnRow<'_> {
    /// Undamaged stiffness and damage rate of the segment that starts at column i; zero stiffness where none exists.
    pub fn constants(&self, axis: Axis, i: usize) -> (f64, f64) {
        match self {
            YarnRow::Uniform { stiffness, damage_rate } => (*stiffness, *damage_rate),
            YarnRow::Stochastic(planes) => {
                let stride = planes.len() / YARN_PLANES;
                let at = axis as usize * stride + PAD + i;
                let get = |k: usize| planes.get(k).copied().unwrap_or(0.0);
                (get(at), get(at + 2 * stride))
            }
        }
    }
}

/// Constants of the pass.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// Nodes along x.
    pub nodes_x: usize,
    /// Numbers in a plane.
    pub stride: usize,
    /// Damage law.
    pub law: &'a DamageLaw,
    /// q at the critical stretch.
    pub critical: f64,
}

/// q = U^2 - 1 of a horizontal segment from the relative displacement of its ends.
#[inline(always)]
pub fn excess_horizontal(d: [f64; 3]) -> f64 {
    d[0] * (d[0] + 2.0) + d[1] * d[1] + d[2] * d[2]
}

/// q = U^2 - 1 of a vertical segment.
#[inline(always)]
pub fn excess_vertical(d: [f64; 3]) -> f64 {
    d[1] * (d[1] + 2.0) + d[0] * d[0] + d[2] * d[2]
}

/// Force of a horizontal segment on its first node, as a change of velocity.
#[inline(always)]
pub fn pull_horizontal(stiffness: f64, q: f64, d: [f64; 3]) -> [f64; 3] {
    let s = stiffness * tension(q);
    [s * (d[0] + 1.0), s * d[1], s * d[2]]
}

/// Force of a vertical segment on its first node.
#[inline(always)]
pub fn pull_vertical(stiffness: f64, q: f64, d: [f64; 3]) -> [f64; 3] {
    let s = stiffness * tension(q);
    [s * d[0], s * (d[1] + 1.0), s * d[2]]
}

/// max(q, 0) without a branch; 0 for NaN, as the vector instruction gives it.
#[inline(always)]
fn tension(q: f64) -> f64 {
    if q > 0.0 { q } else { 0.0 }
}

/// !(q < limit), so that NaN counts as not below and reaches the cold path at no cost.
#[inline(always)]
#[allow(clippy::neg_cmp_op_on_partial_ord)]
fn not_below(q: f64, limit: f64) -> bool {
    !(q < limit)
}

/// Sum of a node's four forces, in the order that everything keeps.
#[inline(always)]
pub fn node_sum(right: f64, left: f64, up: f64, down: f64) -> f64 {
    (right - left) + (up - down)
}

impl Pass<'_> {
    /// Steps one row. `row`: its hot planes; `history`: its history planes; `above`: at least the displacement planes of
    /// the row above (zeros for the top row); `carry`: three planes with the vertical forces from the row below, replaced
    /// by those to the row above. `top`: there is no row above. Returns what was met; `range` receives the least and
    /// greatest y displacement.
    #[allow(clippy::too_many_arguments)] // One hot loop over separate slices: the compiler must see that they do not alias.
    pub fn row(
        &self,
        row: &mut [f64],
        history: &mut [f64],
        above: &[f64],
        carry: &mut [f64],
        yarn: YarnRow<'_>,
        top: bool,
        range: &mut [f64; 2],
    ) -> Report {
        let mut report = Report::default();
        let Some(mut planes) = Planes::of(row, history, above, carry, self.nodes_x, self.stride) else {
            debug_assert!(false, "row slices have the layout's lengths");
            return Report { newly_failed: 0, non_finite: true };
        };
        let n = self.nodes_x;
        let Planes { u, v, stiffness, history, above, carry } = &mut planes;
        let [ux, uy, uz] = u;
        let [vx, vy, vz] = v;
        let [kh, kv] = stiffness;
        let [history_h, history_v] = history;
        let [ax, ay, az] = above;
        let [cx, cy, cz] = carry;
        let mut here = [ux[0], uy[0], uz[0]];
        let mut left = [0.0; 3];
        let (mut low, mut high) = (0.0, 0.0);
        for i in 0..n {
            let right = [ux[i + 1], uy[i + 1], uz[i + 1]];
            let d = [right[0] - here[0], right[1] - here[1], right[2] - here[2]];
            let q = excess_horizontal(d);
            if not_below(q, self.critical) && i + 1 < n {
                let constants = yarn.constants(Axis::Horizontal, i);
                report.add(damage(self.law, self.critical, q, constants, &mut history_h[i], &mut kh[i]));
            }
            let h = pull_horizontal(kh[i], q, d);

            let d = [ax[i] - here[0], ay[i] - here[1], az[i] - here[2]];
            let q = excess_vertical(d);
            if not_below(q, self.critical) && !top {
                let constants = yarn.constants(Axis::Vertical, i);
                report.add(damage(self.law, self.critical, q, constants, &mut history_v[i], &mut kv[i]));
            }
            let w = pull_vertical(kv[i], q, d);

            vx[i] += node_sum(h[0], left[0], w[0], cx[i]);
            vy[i] += node_sum(h[1], left[1], w[1], cy[i]);
            vz[i] += node_sum(h[2], left[2], w[2], cz[i]);
            ux[i] = here[0] + vx[i];
            let y = here[1] + vy[i];
            uy[i] = y;
            uz[i] = here[2] + vz[i];
            low = if y < low { y } else { low };
            high = if y > high { y } else { high };
            cx[i] = w[0];
            cy[i] = w[1];
            cz[i] = w[2];
            left = h;
            here = right;
        }
        *range = [low, high];
        report
    }
}

impl Report {
    fn add(&mut self, other: Report) {
        self.newly_failed += other.newly_failed;
        self.non_finite |= other.non_finite;
    }

    /// Both reports together.
    pub fn merged(mut self, other: Report) -> Report {
        self.add(other);
        self
    }
}

/// The cold path: a segment at or beyond the critical stretch, or one with a non-finite q. Only a new maximum of q changes
/// anything: alpha is a function of the largest q, so the exponential runs only then.
#[cold]
#[inline(never)]
fn damage(
    law: &DamageLaw,
    critical: f64,
    q: f64,
    (undamaged, damage_rate): (f64, f64),
    history: &mut f64,
    stiffness: &mut f64,
) -> Report {
    if !q.is_finite() {
        return Report { newly_failed: 0, non_finite: true };
    }
    if !(q > critical && q > *history) {
        return Report::default();
    }
    let failed_before = *stiffness == 0.0;
    *history = q;
    *stiffness = law.alpha(damage_rate, q) * undamaged;
    Report { newly_failed: u64::from(*stiffness == 0.0 && !failed_before), non_finite: false }
}

/// The planes of one row, each cut to what the loop touches.
struct Planes<'a> {
    u: [&'a mut [f64]; 3],
    v: [&'a mut [f64]; 3],
    stiffness: [&'a mut [f64]; 2],
    history: [&'a mut [f64]; 2],
    above: [&'a [f64]; 3],
    carry: [&'a mut [f64]; 3],
}

impl<'a> Planes<'a> {
    fn of(
        row: &'a mut [f64],
        history: &'a mut [f64],
        above: &'a [f64],
        carry: &'a mut [f64],
        nodes: usize,
        stride: usize,
    ) -> Option<Planes<'a>> {
        let [ux, uy, uz, vx, vy, vz, kh, kv] = split_planes::<HOT_PLANES>(row, stride)?;
        let [history_h, history_v] = split_planes::<HISTORY_PLANES>(history, stride)?;
        let [cx, cy, cz] = split_planes::<3>(carry, stride)?;
        let above = |plane: usize| above.get(plane * stride + PAD..plane * stride + PAD + nodes);
        Some(Planes {
            // One value more: the right-hand neighbour of the last node is a zero of the padding.
            u: [cut(ux, nodes + 1)?, cut(uy, nodes + 1)?, cut(uz, nodes + 1)?],
            v: [cut(vx, nodes)?, cut(vy, nodes)?, cut(vz, nodes)?],
            stiffness: [cut(kh, nodes)?, cut(kv, nodes)?],
            history: [cut(history_h, nodes)?, cut(history_v, nodes)?],
            above: [above(0)?, above(1)?, above(2)?],
            carry: [cut(cx, nodes)?, cut(cy, nodes)?, cut(cz, nodes)?],
        })
    }
}

/// The values of a plane behind its leading zeros.
fn cut(plane: &mut [f64], length: usize) -> Option<&mut [f64]> {
    plane.get_mut(PAD..PAD + length)
}

/// A row cut into its planes.
pub fn split_planes<const N: usize>(row: &mut [f64], stride: usize) -> Option<[&mut [f64]; N]> {
    let mut planes = row.chunks_exact_mut(stride);
    let mut out: [&mut [f64]; N] = core::array::from_fn(|_| &mut [] as &mut [f64]);
    for plane in out.iter_mut() {
        *plane = planes.next()?;
    }
    Some(out)
}
