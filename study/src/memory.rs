//! Memory for simulations, on the host's heap.

use fabric::{Error, Layout, Memory, Scene, Sim};

/// The memory of one simulation.
pub struct Buffers {
    reals: Vec<f64>,
    words: Vec<u32>,
}

impl Buffers {
    /// Just enough memory for `scene`, which is checked.
    pub fn of(scene: &Scene) -> Result<Buffers, Error> {
        let layout = Layout::of(scene)?;
        Ok(Buffers { reals: vec![0.0; layout.reals()], words: vec![0; layout.words()] })
    }

    /// A simulation of `scene` in this memory.
    pub fn sim(&mut self, scene: &Scene) -> Result<Sim<'_>, Error> {
        Sim::new(scene, Memory { reals: &mut self.reals, words: &mut self.words })
    }
}
