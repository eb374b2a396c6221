//! Memory for simulations, on the host's heap.

use crate::Result;
use fabric_kernel::{CacheLine, Error, Layout, Scene, Sim};

/// The memory of one simulation.
pub struct Buffers {
    lines: Vec<CacheLine>,
}

impl Buffers {
    /// Just enough memory for `scene`, which is checked.
    ///
    /// # Errors
    /// A scene that is refused, or more memory than there is; the text says how much it takes.
    pub fn of(scene: &Scene) -> Result<Buffers> {
        Buffers::within(scene, installed())
    }

    /// Says at once what [`Buffers::of`] and [`Buffers::sim`] would refuse ([`Scene::check_start`]), without
    /// the memory itself.
    ///
    /// # Errors
    /// As theirs.
    pub fn check(scene: &Scene) -> Result<()> {
        reserve(scene, installed())?;
        Ok(scene.check_start()?)
    }

    /// Buffers on a machine of so many bytes.
    fn within(scene: &Scene, memory: Option<u64>) -> Result<Buffers> {
        let (mut lines, count) = reserve(scene, memory)?;
        lines.resize(count, CacheLine::ZERO);
        Ok(Buffers { lines })
    }

    /// A simulation of `scene` in this memory.
    ///
    /// # Errors
    /// A scene that is refused.
    pub fn sim(&mut self, scene: &Scene) -> std::result::Result<Sim<'_>, Error> {
        Sim::new(scene, &mut self.lines)
    }

    /// The memory itself.
    pub fn into_lines(self) -> Vec<CacheLine> {
        self.lines
    }
}

/// Bytes of memory that the machine has, where the system tells it.
fn installed() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemTotal:"))?;
    Some(1024 * line.split_whitespace().nth(1)?.parse::<u64>().ok()?)
}

/// Room for the lines of a scene on a machine of so many bytes, and how many there are. Nothing is written:
/// it takes no time.
fn reserve(scene: &Scene, memory: Option<u64>) -> Result<(Vec<CacheLine>, usize)> {
    let (layout, mut lines) = (Layout::of(scene)?, Vec::new());
    // A system may promise what it does not have, and end the program when it is used.
    let more = memory.is_some_and(|bytes| layout.bytes() as u64 > bytes);
    if more || lines.try_reserve_exact(layout.lines()).is_err() {
        let (gigabytes, [nx, ny]) = (1e-9 * layout.bytes() as f64, [layout.nodes_x, layout.nodes_y]);
        let text = format!("{nx} x {ny} nodes take {gigabytes:.1} GB of memory, more than this machine gives");
        return Err(text.into());
    }
    Ok((lines, layout.lines()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error with the number, no abort. (What the allocator says is tried in tests/python/test_inputs.py.)
    #[test]
    fn a_sheet_larger_than_memory_is_an_error_that_says_how_much_it_takes() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (65_000, 65_000);
        let bytes = Layout::of(&scene).unwrap().bytes();
        let text = Buffers::within(&scene, Some(bytes as u64 - 1)).err().expect("no memory").to_string();
        let number = format!("{:.1} GB", 1e-9 * bytes as f64);
        assert_eq!(text, format!("65000 x 65000 nodes take {number} of memory, more than this machine gives"));
    }
}
