//! The search for slack segments, which get a toe (`toe.rs`).

use crate::ground::lanes::{self, Job, Lane};
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES, MARK_PLANES, vertical_axes};
use crate::memory::rows::place_image_column;
use crate::memory::system::System;
use crate::sheet::direction::Along;
use crate::sheet::grading::NetRow;
use crate::yarn::law::Rest;

/// Marks the segments that are slack at t_n and were at t_{n-1}.
pub(crate) fn mark_slack(system: &mut System<'_>) {
    (0..system.layout.plies).for_each(|ply| mark_slack_rows(system, system.rows_to_step(ply)));
}

fn mark_slack_rows(system: &mut System<'_>, [first, end]: [usize; 2]) {
    let (chunks, line) = (system.layout.chunks, system.layout.x);
    if line.is_mirrored() {
        (first..end).for_each(|j| place_image_column(planes::row_mut(system.arrays.hot, chunks, j), line));
    }
    if system.layout.y.is_mirrored() {
        system.place_image_row();
    }
    for j in first..end {
        let mut from = 0;
        while let Some(found) = next_slack(system, j, from) {
            from = found + 1;
            for i in found * CHUNK..from * CHUNK {
                mark_if_slack(system, Axis::Horizontal, i, j);
                mark_if_slack(system, Axis::Vertical, i, j);
            }
        }
    }
}

/// The next chunk of row j, from one on, with a segment that is slack at t_n and has no mark.
fn next_slack(system: &System<'_>, j: usize, from: usize) -> Option<usize> {
    let chunks = system.layout.chunks;
    let Along { horizontal, vertical, .. } = system.directions_of_row(j);
    let (row, above) = (planes::row(system.arrays.hot, chunks, j), planes::row(system.arrays.hot, chunks, j + 1));
    lanes::dispatch(
        system.instructions,
        NextSlack {
            row,
            above,
            marks: planes::row(system.arrays.marks, chunks, j),
            rests: [&horizontal.rest, &vertical.rest],
            net: system.net().row(j),
            from,
        },
    )
}

fn mark_if_slack(system: &mut System<'_>, axis: Axis, i: usize, j: usize) {
    let Some(segment) = system.segment(axis, i, j).filter(|s| s.alpha_when_marked().is_none() && s.is_slack()) else {
        return;
    };
    let alpha = system.law_of(&segment).alpha(segment.damage_rate, segment.history);
    let row = planes::row_mut(system.arrays.marks, system.layout.chunks, j);
    if let Some(slot) = planes::get_mut(row, axis as usize, i) {
        *slot = alpha - 1.0;
    }
}

/// The search of [`next_slack`] as a job for the lanes. Most segments have their mark or are taut.
struct NextSlack<'a> {
    row: &'a [Chunk<HOT_PLANES>],
    above: &'a [Chunk<HOT_PLANES>],
    marks: &'a [Chunk<MARK_PLANES>],
    rests: [&'a Rest; 2],
    net: NetRow<'a>,
    from: usize,
}

impl Job for NextSlack<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        let one = L::splat(1.0);
        let [horizontal, vertical] = self.rests;
        let rest_v = self.net.upwards(vertical);
        for (c, (chunk, [mark_h, mark_v])) in self.row.iter().zip(self.marks).enumerate().skip(self.from) {
            let behind = displacement::<L>(self.row.get(c + 1), 0);
            for g in 0..CHUNK / L::WIDTH {
                let here = displacement::<L>(Some(chunk), g);
                let next = if g + 1 < CHUNK / L::WIDTH { displacement(Some(chunk), g + 1) } else { behind };
                let d = [
                    here[0].right_of(next[0]).sub(here[0]),
                    here[1].right_of(next[1]).sub(here[1]),
                    here[2].right_of(next[2]).sub(here[2]),
                ];
                let rest_h = self.net.along(c, g, horizontal);
                // A mark is 1 or at most 0: U^2 is below it where a segment is slack that has none.
                if L::load(&L::groups(mark_h)[g]).any_above(rest_h.twice_strain(d).add(one)) {
                    return Some(c);
                }
                let Some(over) = self.above.get(c) else { continue };
                let over = displacement::<L>(Some(over), g);
                let d = [over[0].sub(here[0]), over[1].sub(here[1]), over[2].sub(here[2])];
                if L::load(&L::groups(mark_v)[g]).any_above(rest_v.twice_strain(vertical_axes(d)).add(one)) {
                    return Some(c);
                }
            }
        }
        None
    }
}

/// Displacement of a lane group of nodes, zero where there is none.
#[inline(always)]
fn displacement<L: Lane>(chunk: Option<&Chunk<HOT_PLANES>>, g: usize) -> [L; 3] {
    match chunk {
        Some([x, y, z, ..]) => [L::load(&L::groups(x)[g]), L::load(&L::groups(y)[g]), L::load(&L::groups(z)[g])],
        None => [L::splat(0.0); 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{sheet, sim};
    use crate::yarn::toe::MARK_INTERVAL;

    /// Just after the search every segment that is slack has its mark, whatever its natural length; so do some that are not.
    #[test]
    fn every_slack_segment_is_found() {
        for (crimp, pre_strain, spacing_y) in
            [([0.0; 2], [0.0; 2], 0.0), ([0.004, 0.0], [0.0, 0.004], 9e-4), ([0.0, 0.01], [0.003, 0.0], 6e-4)]
        {
            let mut scene = sheet(37, 35);
            scene.slack_toe = 0.02;
            (scene.sheet.crimp, scene.sheet.pre_strain, scene.sheet.spacing_y) = (crimp, pre_strain, spacing_y);
            (scene.yarn.stochastic, scene.projectile.velocity) = (false, [0.0, 0.0, 150.0]);
            let mut sim = sim(&scene);
            while sim.counters().failed_segments == 0 {
                sim.advance(MARK_INTERVAL).unwrap();
            }
            for _ in 0..4 {
                sim.advance(MARK_INTERVAL).unwrap();
                let (mut slack, mut taut) = (0, 0);
                for (i, j) in sim.system.nodes() {
                    for axis in [Axis::Horizontal, Axis::Vertical] {
                        let Some(segment) = sim.system.segment(axis, i, j) else { continue };
                        let marked = segment.alpha_when_marked().is_some();
                        assert!(marked || !segment.is_slack(), "{i} {j}");
                        slack += usize::from(marked);
                        taut += usize::from(!marked);
                    }
                }
                assert!(slack > 10 && taut > 50, "{slack} {taut}");
            }
        }
    }
}
