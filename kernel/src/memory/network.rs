//! The network of yarns that is stepped, and the access to its nodes and segments; `fill.rs` fills its
//! arrays.

use crate::body::pose::Vector;
use crate::ground::lanes::InstructionSet;
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, STIFFNESS};
use crate::memory::arrays::Arrays;
use crate::memory::layout::Layout;
use crate::memory::model::Model;
use crate::memory::state::Sums;
use crate::scene::features::Feature;
use crate::scene::parts::Scene;
use crate::sheet::clamp::Clamps;
use crate::sheet::columns::{self, Net, PLACE, PLACE_Z};
use crate::sheet::direction::{Direction, Directions, PlyDirections};
use crate::sheet::energy_error::{self, EnergyError, GIVEN};
use crate::sheet::ghosts;
use crate::sheet::neighbours::NOTHING;
use crate::sheet::places::rest_offset;
use crate::sheet::ring;
use crate::sheet::weave;
use crate::yarn::law::{self, DamageLaw, Rest, RestLanes};
use crate::yarn::rate::RateLaw;

/// Network of nodes and segments: scene, sizes, constants, and the arrays of all nodes and segments.
pub(crate) struct Network<'a> {
    pub scene: Scene,
    pub layout: Layout,
    pub model: Model,
    pub directions: Directions,
    pub clamps: Clamps,
    pub arrays: Arrays<'a>,
    /// Awake rows of a single sheet: rows [first, end) that may hold a node that is not exactly at rest in
    /// its place.
    pub awake: [usize; 2],
    pub skip_rest: bool,
    /// Whether rows are fetched from memory ahead of their turn; changes the speed, not the bits.
    pub fetches: bool,
    /// Steps that are taken in one block where they can be, 1 for none; changes the speed, not the bits.
    pub block_steps: usize,
    pub instructions: InstructionSet,
}

impl<'a> Network<'a> {
    /// No nodes and no memory: a place for those of a scene.
    pub const NOTHING: Network<'a> = Network {
        scene: Scene::sheet_3in_sphere(),
        layout: Layout::NOTHING,
        model: Model::NOTHING,
        directions: Directions::NOTHING,
        clamps: Clamps::NOTHING,
        arrays: Arrays::nothing(),
        awake: [0, 0],
        skip_rest: true,
        fetches: false,
        block_steps: 1,
        instructions: InstructionSet::Scalar,
    };
}

/// One segment as the read-outs see it.
#[derive(Clone, Copy)]
pub(crate) struct SegmentView {
    /// Direction.
    pub axis: Axis,
    /// Ply.
    pub ply: usize,
    /// State at rest in the flat sheet.
    pub rest: Rest,
    /// Rest vector of a horizontal segment of a curved sheet along x and z.
    pub chord: Option<[f64; 2]>,
    /// Segments of the fabric in series and yarns in parallel that it stands for: 1 and 1 without grading.
    pub bar: [f64; 2],
    /// Stiffness kk with the stored damage.
    pub stiffness: f64,
    /// kk without damage.
    pub undamaged: f64,
    /// Damage rate.
    pub damage_rate: f64,
    /// Critical stretch.
    pub critical_stretch: f64,
    /// Largest q beyond critical stored so far.
    pub history: f64,
    /// Energy error and correcting stress, if it has them (`sheet/energy_error.rs`).
    pub energy_error: Option<[f64; 2]>,
    /// Relative displacement of its ends at t_n.
    pub d: [f64; 3],
    /// Change of `d` in the last step.
    pub w: [f64; 3],
    /// Relative displacement of its ends at t_{n-1}.
    pub d_before: [f64; 3],
}

impl SegmentView {
    /// Constants at rest.
    fn lanes(&self) -> RestLanes<f64> {
        let lanes = self.rest.lanes();
        self.chord.map_or(lanes, |chord| lanes.rotated(chord))
    }

    /// Twice the strain, q, at t_n.
    pub fn twice_strain(&self) -> f64 {
        self.twice_strain_of(self.d)
    }

    /// Twice the strain at t_{n-1}.
    pub fn twice_strain_before(&self) -> f64 {
        self.twice_strain_of(self.d_before)
    }

    /// Twice the strain with this relative displacement of the ends.
    fn twice_strain_of(&self, d: [f64; 3]) -> f64 {
        self.lanes().twice_strain(self.axis.segment_axes(d))
    }

    /// Work over 1/4 l^2 that its stress at t_n, with this stiffness, does more in the last step than that at
    /// t_{n-1}.
    pub fn growth_of_work(&self, stiffness: f64) -> f64 {
        let (q, rest) = (self.twice_strain(), self.lanes());
        let ends = [rest.end_to_end(self.axis.segment_axes(self.d)), self.axis.segment_axes(self.w)];
        let mut now = law::stress(stiffness, q);
        let mut before = law::stress(self.stiffness, self.twice_strain_before());
        if let Some([energy, given]) = self.energy_error {
            before += given;
            now += EnergyError { energy, given }.next(&rest, [self.stiffness, stiffness], q, ends).given;
        }
        let [r, r_before] = energy_error::growths(&rest, ends);
        now * r - before * r_before
    }
}

impl Network<'_> {
    /// Rest place of a node in spacings h.
    pub fn rest(&self, i: usize, j: usize) -> [f64; 3] {
        let Arrays { columns, lines, .. } = &self.arrays;
        let (ply, row) = self.layout.ply_and_row(j);
        let z = ply as f64 * self.model.pitch;
        if let (Some(x), Some(y)) = (planes::get(columns, PLACE, i), planes::get(lines, PLACE, j)) {
            return [x, y, z];
        }
        let y = rest_offset(row, self.scene.sheet.nodes_y) * self.directions.front.vertical.rest.spacing;
        let line = self.layout.columns_of(columns, ply);
        if let (Some(x), Some(z)) = (planes::get(line, PLACE, i), planes::get(line, PLACE_Z, i)) {
            return [x, y, z];
        }
        [rest_offset(i, self.scene.sheet.nodes_x), y, z]
    }

    /// Distance of a node from the sheet at rest, across it, spacings: along z, or of a curved sheet away
    /// from its axis, with its sign.
    pub fn deflection(&self, i: usize, j: usize) -> f64 {
        let ([u, _, w], _) = self.node(i, j);
        let Some(hoop) = ring::Hoop::of(&self.scene) else { return w };
        let ([x, _, z], radius) = (self.rest(i, j), hoop.radius * self.directions_of_row(j).radius_ratio);
        // |r + d| - R without rounding at rest.
        (u * (2.0 * x + u) + w * (2.0 * z + w)) / (math::length([x + u, 0.0, z + w]) + radius)
    }

    /// Normal of a column of a curved sheet at rest, along x and z; None of a flat sheet.
    #[inline]
    pub fn normal(&self, i: usize) -> Option<[f64; 2]> {
        let hoop = self.net(0).hoop();
        Some([planes::get(hoop, columns::NORMAL_X, i)?, planes::get(hoop, columns::NORMAL_Z, i)?])
    }

    /// A vector in the axes of its column, of which the last one is across the sheet; of a flat sheet as it
    /// is.
    #[inline]
    pub fn column_axes(&self, i: usize, v: [f64; 3]) -> [f64; 3] {
        self.normal(i).map_or(v, |normal| ring::column_axes(v, normal))
    }

    /// Lines of constants of a ply.
    pub fn net(&self, ply: usize) -> Net<'_> {
        Net { columns: self.layout.columns_of(self.arrays.columns, ply), lines: self.arrays.lines }
    }

    /// Multiplicity of node (i, j): nodes of the whole fabric that it stands for, by symmetry and by mass.
    pub fn share(&self, i: usize, j: usize) -> f64 {
        self.layout.node_weight(i, j) * self.net(0).share(i, j)
    }

    /// Constants of the segments that start in row j.
    pub fn directions_of_row(&self, j: usize) -> PlyDirections<'_> {
        self.directions.of_ply(self.layout.ply_and_row(j).0)
    }

    /// Constants of the segments along an axis that start in row j.
    pub fn direction(&self, axis: Axis, j: usize) -> &Direction {
        self.directions_of_row(j).along(axis)
    }

    /// Constants of a segment's direction.
    pub fn direction_of(&self, segment: &SegmentView) -> &Direction {
        self.directions.of_ply(segment.ply).along(segment.axis)
    }

    /// Mass of a node of a ply over that of a node of the front fabric.
    pub fn mass_share(&self, ply: usize) -> f64 {
        if self.directions.is_back(ply) { self.model.back_share } else { 1.0 }
    }

    /// [`Network::mass_share`] of the ply of row j.
    pub fn mass_share_of_row(&self, j: usize) -> f64 {
        self.mass_share(self.layout.ply_and_row(j).0)
    }

    /// Position at t_n in the sheet's frame, m.
    pub fn position(&self, i: usize, j: usize) -> Vector {
        let (u, _) = self.node(i, j);
        let (rest, h) = (self.rest(i, j), self.scene.sheet.spacing);
        Vector::new((rest[0] + u[0]) * h, (rest[1] + u[1]) * h, (rest[2] + u[2]) * h)
    }

    /// Displacement (spacings) and velocity (spacings per step) of a node.
    /// Beyond a mirror plane, that of the image.
    #[inline]
    pub fn node(&self, i: usize, j: usize) -> ([f64; 3], [f64; 3]) {
        let ((i, is_mirrored_x), (j, is_mirrored_y)) = (self.layout.x.node(i), self.layout.y.node(j));
        let chunk = planes::row(self.arrays.rows.hot, self.layout.chunks, j).get(i / CHUNK).unwrap_or(&NOTHING);
        let at = |plane: usize, is_mirrored: bool| {
            let value = chunk[plane][i % CHUNK];
            if is_mirrored { -value } else { value }
        };
        let [x, y] = [is_mirrored_x, is_mirrored_y];
        ([at(0, x), at(1, y), at(2, false)], [at(3, x), at(4, y), at(5, false)])
    }

    pub fn set_node(&mut self, i: usize, j: usize, u: [f64; 3], v: [f64; 3]) {
        let row = planes::row_mut(self.arrays.rows.hot, self.layout.chunks, j);
        if let Some(chunk) = row.get_mut(i / CHUNK) {
            planes::set_motion(chunk, i % CHUNK, u, v);
        }
    }

    pub fn is_fixed(&self, i: usize, j: usize) -> bool {
        self.arrays.rows.is_fixed(&self.layout, &self.clamps, [i, j])
    }

    /// Whether a clamp has let go of a node for good.
    pub fn have_clamps_let_go(&self) -> bool {
        self.clamps.have_let_go(self.arrays.rows.clamps)
    }

    /// Whether a clamp that may slip holds a node.
    pub fn is_held_by_clamp(&self, i: usize, j: usize) -> bool {
        self.arrays.rows.is_clamped([i, j]) && self.is_fixed(i, j)
    }

    /// Which attachment a held node belongs to.
    pub fn attachment_of(&self, i: usize, j: usize) -> usize {
        let side = usize::from(self.arrays.rows.runs.get(j).is_some_and(|run| i as u32 >= run[1]));
        let (_, row) = self.layout.ply_and_row(j);
        weave::attachment_of(self.scene.attachment.kind, self.layout.y.nodes, self.layout.upper, row, side)
    }

    /// The segment that starts at node (i, j), if there is one.
    pub fn segment(&self, axis: Axis, i: usize, j: usize) -> Option<SegmentView> {
        let chunks = self.layout.chunks;
        let (i2, j2, exists) = match axis {
            Axis::Horizontal => (i + 1, j, i < self.layout.x.segments() && j < self.layout.nodes_y),
            Axis::Vertical => (i, j + 1, i < self.layout.nodes_x && self.layout.has_verticals(j)),
        };
        if !exists {
            return None;
        }
        let ((u1, v1), (u2, v2)) = (self.node(i, j), self.node(i2, j2));
        let d = [u2[0] - u1[0], u2[1] - u1[1], u2[2] - u1[2]];
        let dv = [v2[0] - v1[0], v2[1] - v1[1], v2[2] - v1[2]];
        let (ply, _) = self.layout.ply_and_row(j);
        let direction = self.directions.of_ply(ply).along(axis);
        let ratio = if axis == Axis::Horizontal { self.directions.radius_ratio(ply) } else { 1.0 };
        let bar = self.net(ply).bar(axis, i, j).or((ratio != 1.0).then_some([ratio, 1.0]));
        let yarn = planes::row(self.arrays.rows.yarn, chunks, j);
        let drawn = |plane: usize| planes::get(yarn, axis as usize + plane, i).unwrap_or(0.0);
        let stochastic = self.layout.has_constants();
        let strength = planes::row(self.arrays.rows.strength, chunks, j);
        Some(SegmentView {
            axis,
            ply,
            rest: bar.map_or(direction.rest, |[segments, _]| direction.rest.in_series(segments)),
            chord: self.chord(axis, i, ply),
            bar: bar.unwrap_or([1.0; 2]),
            stiffness: planes::get(planes::row(self.arrays.rows.hot, chunks, j), STIFFNESS + axis as usize, i)?,
            undamaged: if stochastic { drawn(0) } else { direction.stiffness },
            damage_rate: if stochastic { drawn(2) } else { direction.damage_rate },
            critical_stretch: planes::get(strength, axis as usize, i).unwrap_or(direction.law.critical_stretch),
            history: planes::get(planes::row(self.arrays.rows.history, chunks, j), axis as usize, i)?,
            energy_error: self.energy_error(axis, i, j),
            w: dv,
            d,
            // The theta rule's state is synchronous: its audit looks at t_n alone.
            d_before: if self.layout.has(Feature::Theta) { d } else { [d[0] - dv[0], d[1] - dv[1], d[2] - dv[2]] },
        })
    }

    /// Rest vector along x and z of a horizontal segment of a curved sheet.
    fn chord(&self, axis: Axis, i: usize, ply: usize) -> Option<[f64; 2]> {
        let hoop = if axis == Axis::Horizontal { self.net(ply).hoop() } else { return None };
        Some([planes::get(hoop, columns::CHORD, i)?, planes::get(hoop, columns::CHORD_Z, i)?])
    }

    /// Energy error of the segment from node (i, j), and its correcting stress in the last step; None where
    /// none of its kind has been slack.
    pub fn energy_error(&self, axis: Axis, i: usize, j: usize) -> Option<[f64; 2]> {
        let row = planes::row(self.arrays.rows.energy_error, self.layout.chunks, j);
        let at = |plane: usize| planes::get(row, plane + axis as usize, i).unwrap_or(0.0);
        self.arrays
            .rows
            .been_slack
            .get(j)
            .is_some_and(|bits| bits & energy_error::bit(axis) != 0)
            .then(|| [at(0), at(GIVEN)])
    }

    /// The damage law of a segment. Whether a strain is damaging follows from its direction's, too: the
    /// history of drawn strength begins at the segment's own critical q.
    pub fn law_of(&self, segment: &SegmentView) -> DamageLaw {
        self.direction_of(segment).law.at(segment.critical_stretch)
    }

    /// Time since the load began, s, after `loaded` steps of it; a step at least.
    pub fn load_time(&self, loaded: u64) -> f64 {
        loaded.max(1) as f64 * self.model.limits.dt
    }

    /// Dependence of the segments of a direction on the rate of strain at t_n, after `loaded` steps of load.
    pub fn rate_law(&self, axis: Axis, loaded: u64) -> RateLaw {
        self.direction(axis, 0).rate.at(self.load_time(loaded))
    }

    /// Dependence of the segments of a direction on the rate of strain at t_{n-1}.
    pub fn rate_law_before(&self, axis: Axis, loaded: u64) -> RateLaw {
        self.rate_law(axis, loaded.saturating_sub(1))
    }

    /// Stiffness kk of a segment at t_n, with damage up to t_n and rate, after `loaded` steps of load; it is
    /// not committed.
    pub fn stiffness_now(&self, segment: &SegmentView, loaded: u64) -> f64 {
        let q = segment.twice_strain();
        let (seen, stiffening) = if self.layout.has(Feature::Rate) {
            let rate = self.rate_law(segment.axis, loaded);
            (rate.seen_at(q), rate.stiffening(q))
        } else {
            (q, 1.0)
        };
        let stiffness = if self.direction_of(segment).law.is_damaging(seen, segment.history) {
            self.law_of(segment).alpha(segment.damage_rate, seen) * segment.undamaged
        } else {
            segment.stiffness
        };
        stiffness * stiffening
    }

    /// Sets the flag of a node or of a piece; without room for flags it does nothing.
    pub(crate) fn set_flag(&mut self, k: usize) {
        if let Some(flags) = self.arrays.flags.get_mut(k / 32) {
            *flags |= 1 << (k % 32);
        }
    }

    /// Whether a node or a piece is flagged.
    pub(crate) fn has_flag(&self, k: usize) -> bool {
        self.arrays.flags.get(k / 32).is_some_and(|flags| flags >> (k % 32) & 1 == 1)
    }

    /// Horizontal and vertical segments of row j start before these columns.
    pub fn ends_of_segments(&self, j: usize) -> [usize; 2] {
        [self.layout.x.segments(), if self.layout.has_verticals(j) { self.layout.nodes_x } else { 0 }]
    }

    /// Puts the ghost row beyond the plane y = 0 in its place.
    pub fn place_ghost_row(&mut self) {
        ghosts::place_ghost_row(self.arrays.rows.hot, self.layout.chunks, self.layout.y);
    }

    /// Adds to the sums of its support the impulse of the projectile on the fixed node (i, j), in units of m
    /// h/dt with the mass of a node of the front fabric.
    pub fn load_support(&self, sums: &mut Sums, i: usize, j: usize, impulse: &Vector) {
        if !self.layout.supports {
            return;
        }
        let (kind, symmetry) = (self.scene.attachment.kind, self.scene.symmetry);
        let at = self.attachment_of(i, j);
        let pull = impulse * (self.share(i, j) * symmetry.share());
        sums.add_to_support(kind, at, &pull, symmetry);
    }

    /// Awake rows of a ply and their neighbours.
    pub fn rows_to_step(&self, ply: usize) -> [usize; 2] {
        rows_to_step(self.layout.rows_of(ply), self.awake_of(ply), self.steps_all())
    }

    /// Whether every row is stepped: where there is pre-tension the supports feel rows at rest, too.
    pub fn steps_all(&self) -> bool {
        !self.skip_rest || self.directions.are_tense()
    }

    /// Rows [first, end) of a ply that may hold a node that is not exactly at rest in its place.
    pub fn awake_of(&self, ply: usize) -> [usize; 2] {
        if !self.layout.is_stack() {
            return self.awake;
        }
        self.arrays.awake.get(ply).map_or([0, 0], |rows| rows.map(|row| row as usize))
    }

    /// Sets the awake rows of a ply.
    pub fn set_awake(&mut self, ply: usize, rows: [usize; 2]) {
        if !self.layout.is_stack() {
            self.awake = rows;
        } else if let Some(place) = self.arrays.awake.get_mut(ply) {
            *place = rows.map(|row| row as u32);
        }
    }

    /// Notes that row j holds a moving node.
    pub fn wake(&mut self, j: usize) {
        let (ply, _) = self.layout.ply_and_row(j);
        let [first, end] = self.awake_of(ply);
        self.set_awake(ply, if first == end { [j, j + 1] } else { [first.min(j), end.max(j + 1)] });
    }

    /// Velocity of a node in this step before any impulse, spacings a step.
    pub fn free_velocity(&self, i: usize, j: usize) -> Vector {
        if self.layout.has(Feature::Theta) {
            return self.velocity_with_forces(self.scene.integrator.theta, i, j);
        }
        Vector::from(self.node(i, j).1)
    }

    /// v_n + g of a node. A fixed one stays where it is, whatever pulls at it.
    pub fn velocity_with_forces(&self, theta: f64, i: usize, j: usize) -> Vector {
        if self.is_fixed(i, j) {
            return Vector::zeros();
        }
        let (_, v) = self.node(i, j);
        let iterate = planes::row(self.arrays.rows.iterate, self.layout.chunks, j);
        let g = [0, 1, 2].map(|axis| {
            let at = |plane: usize| planes::get(iterate, plane, i).unwrap_or(0.0);
            mean_acceleration(theta, at(planes::START_ACCELERATION + axis), at(planes::GUESS_ACCELERATION + axis))
        });
        Vector::from(v) + Vector::from(g)
    }

    /// Velocity of a node at t_{n-1/2}, m/s.
    pub fn velocity(&self, i: usize, j: usize) -> Vector {
        let (_, v) = self.node(i, j);
        Vector::from(v) * self.model.unit_speed
    }

    /// All nodes, row by row.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (nx, ny) = (self.layout.nodes_x, self.layout.nodes_y);
        (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j)))
    }
}

/// Rows to step of a ply with these rows, of which some are awake: those and their neighbours, or all.
pub(crate) fn rows_to_step([low, high]: [usize; 2], [first, end]: [usize; 2], all: bool) -> [usize; 2] {
    if all {
        [low, high]
    } else if first == end {
        [low, low]
    } else {
        [first.saturating_sub(1).max(low), (end + 1).min(high)]
    }
}

/// (M10) g: what the forces add to the mean velocity of the step, theta [(1 - theta) a_n + theta a^K].
pub(crate) fn mean_acceleration(theta: f64, at_start: f64, at_guess: f64) -> f64 {
    theta * ((1.0 - theta) * at_start + theta * at_guess)
}
