//! Rows of nodes in memory: chunks of planes of eight numbers each, and access to them.
//!
//! The hot arrays are interleaved in chunks of eight columns: row j is a sequence of chunks, and a chunk of
//! the hot rows is eight planes [ux uy uz vx vy vz kh kv] of eight numbers each, one cache line a plane. Rows
//! are padded with zeros to whole chunks on every target alike, so sizes agree everywhere and one pointer a
//! row reaches all planes.

/// Columns in a chunk.
pub const CHUNK: usize = 8;
/// Planes of the hot rows: displacement (3), velocity (3), stiffness of the horizontal and vertical segment.
pub const HOT_PLANES: usize = 8;
/// Planes of the history rows: largest q beyond the critical one of the horizontal and vertical segment. Of a
/// segment without damage it is 0, or its own critical q where strength is drawn.
pub const HISTORY_PLANES: usize = 2;
/// Planes of the constant rows of stochastic yarn: undamaged stiffness (2) and damage rate (2).
pub const YARN_PLANES: usize = 4;
/// Planes of the rows of drawn strength: critical stretch of the horizontal and vertical segment.
pub const STRENGTH_PLANES: usize = 2;
/// Planes of the slack balance: accumulated energy error and correcting stress of the horizontal and vertical
/// segment (`sweep/slack.rs`).
pub const ENERGY_ERROR_PLANES: usize = 4;
/// Planes of the theta rule's rows: guess of the displacement, velocity after contact, acceleration at the
/// step's start and at the guess (3 each).
pub const ITERATE_PLANES: usize = 12;
// First planes of the theta rule's rows, three each.
/// Guess of the displacement at the step's end.
pub const GUESS: usize = 0;
/// Velocity after the impulses, without the forces.
pub const VELOCITY_AFTER_IMPULSES: usize = 3;
/// Acceleration at the step's start.
pub const START_ACCELERATION: usize = 6;
/// Acceleration at the guess.
pub const GUESS_ACCELERATION: usize = 9;
/// Planes of the row that carries vertical forces upwards.
pub const CARRY_PLANES: usize = 3;
/// Planes of the rows of what viscosity keeps of the last step: twice the strain of the horizontal and
/// vertical segment, the viscous part of their stress, and the moments of the yarns along x and along y at
/// the node.
pub const PAST_PLANES: usize = 6;
/// First plane of those viscous stresses.
pub const VISCOUS_STRESS: usize = 2;
/// First plane of the moments.
pub const MOMENT: usize = 4;
/// Eight columns of P planes.
pub type Chunk<const P: usize> = [[f64; CHUNK]; P];

/// Plane of the displacement along z in the hot rows, and of the velocity along z.
pub const Z: usize = 2;
/// See [`Z`].
pub const SPEED_Z: usize = 5;
/// First plane of the stiffnesses in the hot rows.
pub const STIFFNESS: usize = 6;
/// Planes of displacement and velocity along x, before those along y and z.
pub const X: usize = 0;
/// See [`X`].
pub const SPEED_X: usize = 3;

/// Displacement of a node in its chunk of the hot rows, spacings.
#[inline(always)]
pub fn displacement([x, y, z, ..]: &Chunk<HOT_PLANES>, lane: usize) -> [f64; 3] {
    [x[lane], y[lane], z[lane]]
}

/// Velocity of a node in its chunk of the hot rows, spacings a step.
#[inline(always)]
pub fn velocity([_, _, _, x, y, z, ..]: &Chunk<HOT_PLANES>, lane: usize) -> [f64; 3] {
    [x[lane], y[lane], z[lane]]
}

/// Sets displacement, spacings, and velocity, spacings a step, of a node in its chunk of the hot rows.
#[inline(always)]
pub fn set_motion(chunk: &mut Chunk<HOT_PLANES>, lane: usize, u: [f64; 3], v: [f64; 3]) {
    for k in 0..3 {
        (chunk[X + k][lane], chunk[SPEED_X + k][lane]) = (u[k], v[k]);
    }
}

/// A velocity below this, in h/dt, counts as rest: 2^-256, some 1e-73 m/s. Ahead of a wave velocities fall
/// off faster than exponentially, and without a least one nearly every force there would be a subnormal
/// number, which processors are slow with. Sums of numbers above it are multiples of 2^-308, so no product of
/// three of them is subnormal.
pub const AT_REST: f64 = f64::from_bits((1023 - 256) << 52);

/// Direction of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// To the right-hand neighbour, along x.
    Horizontal = 0,
    /// To the neighbour above, along y.
    Vertical = 1,
}

impl Axis {
    /// The direction across this one.
    pub fn other(self) -> Axis {
        match self {
            Axis::Horizontal => Axis::Vertical,
            Axis::Vertical => Axis::Horizontal,
        }
    }

    /// A vector of the sheet in the axes of a segment of this direction, the rest direction first, or back.
    pub fn segment_axes(self, vector: [f64; 3]) -> [f64; 3] {
        match self {
            Axis::Horizontal => vector,
            Axis::Vertical => vertical_axes(vector),
        }
    }
}

/// A vector of the sheet in the axes of a vertical segment, the rest direction first, or back.
#[inline(always)]
pub fn vertical_axes<L>([x, y, z]: [L; 3]) -> [L; 3] {
    [y, x, z]
}

/// One number of a chunked row: plane and column. None outside the row.
#[inline(always)]
pub fn get<const P: usize>(row: &[Chunk<P>], plane: usize, column: usize) -> Option<f64> {
    row.get(column / CHUNK)?.get(plane).map(|numbers| numbers[column % CHUNK])
}

/// Sets one number of a chunked row; a place outside of it is left out.
#[inline(always)]
pub fn set<const P: usize>(row: &mut [Chunk<P>], plane: usize, column: usize, value: f64) {
    if let Some(numbers) = row.get_mut(column / CHUNK).and_then(|chunk| chunk.get_mut(plane)) {
        numbers[column % CHUNK] = value;
    }
}

/// Row j of a block of chunked rows; empty outside the block.
#[inline(always)]
pub fn row<const P: usize>(block: &[Chunk<P>], chunks: usize, j: usize) -> &[Chunk<P>] {
    block.get(j * chunks..(j + 1) * chunks).unwrap_or(&[])
}

/// Row j of a block of chunked rows, to be changed.
#[inline(always)]
pub fn row_mut<const P: usize>(block: &mut [Chunk<P>], chunks: usize, j: usize) -> &mut [Chunk<P>] {
    block.get_mut(j * chunks..(j + 1) * chunks).unwrap_or(&mut [])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_chunked_row() {
        let mut block = [[[0.0; CHUNK]; 2]; 6];
        // Three rows of two chunks: the number says its row, plane and column.
        for (j, plane, column) in (0..3).flat_map(|j| (0..2).flat_map(move |p| (0..16).map(move |i| (j, p, i)))) {
            let number = (100 * j + 20 * plane + column) as f64;
            set(row_mut(&mut block, 2, j), plane, column, number);
            assert_eq!(block[2 * j + column / 8][plane][column % 8], number);
            assert_eq!(get(row(&block, 2, j), plane, column), Some(number));
        }
        assert!(row(&block, 2, 3).is_empty() && row_mut(&mut block, 2, 3).is_empty());
        assert_eq!((get(row(&block, 2, 0), 2, 0), get(row(&block, 2, 0), 0, 16)), (None, None));
    }
}
