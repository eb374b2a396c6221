//! The Python module `fabric_kernel._kernel`: scenes and simulations of the kernel.
//! `python/fabric_kernel/_kernel.pyi` has its types and documentation, docs/python.md shows how it is used.
//!
//! What computes releases the interpreter and runs with the kernel's rounding mode, whatever other modules
//! have set, so the bits are those of Rust.

mod errors;
mod fabrics;
mod fibrils;
mod parameters;
mod replay;
mod scene;
mod simulation;

use pyo3::prelude::*;

#[pymodule]
mod _kernel {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::errors::{Failed, Refused};
    #[pymodule_export]
    use crate::fabrics::fabrics;
    #[pymodule_export]
    use crate::fibrils::{yarn_of_fibrils, yarns_of_fibrils};
    #[pymodule_export]
    use crate::parameters::parameters;
    #[pymodule_export]
    use crate::replay::replay;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::simulation::Simulation;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("VERSION", fabric_kernel::VERSION)?;
        module.add("PRESETS", fabric_scene::PRESETS.map(|(name, _)| name))
    }
}
