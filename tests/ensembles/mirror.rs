//! Keeps a run mirror-symmetric about x = 0 and y = 0: every few steps the quadrant at -x, -y is copied onto the other three
//! in a snapshot image, which is then loaded. Legal only for uniform yarn and a hit in the middle.

use fabric::Sim;
use fabric::snapshot::Hash;

/// Steps between two mirrorings: rounding has no time to grow.
const INTERVAL: u64 = 16;
/// Words of an image before the body's position; its orientation has 4 words more, then comes its velocity.
const POSITION: usize = 5;
const VELOCITY: usize = POSITION + 3 + 4;

/// Like [`Sim::advance_until`].
pub fn advance_until(sim: &mut Sim<'_>, mask: u32, steps: u64) {
    let mut image = vec![0; sim.snapshot_bytes()];
    while sim.step_count() < steps && sim.outcomes().mask & mask == 0 {
        sim.advance(INTERVAL).expect("no failure");
        sim.save(&mut image).expect("sound");
        let mut words: Vec<u64> = image.as_chunks::<8>().0.iter().map(|chunk| u64::from_le_bytes(*chunk)).collect();
        mirror(&mut words, sim.layout().nodes_x, sim.layout().nodes_y, sim.layout().segments());
        for (chunk, word) in image.as_chunks_mut::<8>().0.iter_mut().zip(words) {
            *chunk = word.to_le_bytes();
        }
        sim.load(&image).expect("a sound image");
    }
}

fn mirror(words: &mut [u64], nx: usize, ny: usize, segments: usize) {
    for sideways in [POSITION, POSITION + 1, VELOCITY, VELOCITY + 1] {
        words[sideways] = 0;
    }
    // Where each node's words begin: displacement, velocity, then the histories of the segments that start there.
    let mut at = words.len() - 1 - (nx * ny).div_ceil(32) - segments - 6 * nx * ny;
    let mut places = Vec::with_capacity(nx * ny);
    for k in 0..nx * ny {
        places.push(at);
        at += 6 + usize::from(k % nx + 1 < nx) + usize::from(k / nx + 1 < ny);
    }
    for j in 0..ny {
        for i in 0..nx {
            let (flip_x, flip_y) = (2 * i >= nx, 2 * j >= ny);
            let (mi, mj) = (if flip_x { nx - 1 - i } else { i }, if flip_y { ny - 1 - j } else { j });
            let (to, from) = (places[j * nx + i], places[mj * nx + mi]);
            let middle = [2 * i + 1 == nx, 2 * j + 1 == ny, false];
            for (axis, flip) in [flip_x, flip_y, false].into_iter().enumerate() {
                for word in [axis, 3 + axis] {
                    let value = f64::from_bits(words[from + word]);
                    // Nodes on a mirror line stay on it.
                    let value = if middle[axis] { 0.0 } else { value };
                    words[to + word] = if flip { -value } else { value }.to_bits();
                }
            }
            // The horizontal segment from column i to i + 1 mirrors the one from nx - 2 - i.
            let mut slot = to + 6;
            if i + 1 < nx {
                let column = if 2 * i + 1 >= nx { nx - 2 - i } else { i };
                words[slot] = words[places[mj * nx + column] + 6];
                slot += 1;
            }
            if j + 1 < ny {
                let row = if 2 * j + 1 >= ny { ny - 2 - j } else { j };
                words[slot] = words[places[row * nx + mi] + 6 + usize::from(mi + 1 < nx)];
            }
        }
    }
    let (checksum, body) = words.split_last_mut().expect("not empty");
    let mut hash = Hash::default();
    body.iter().for_each(|&word| hash.word(word));
    *checksum = hash.value();
}
