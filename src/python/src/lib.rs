//! The native part of the Python package `edgegait`: packs, items of datasets, and the command.
//!
//! The Python modules in `edgegait/` define the public names. A process may fork between two calls:
//! locks are held only together with the interpreter's lock, and threads are started again.

mod attend;
mod command;
mod errors;
mod items;
mod pack;

use pyo3::prelude::*;

/// The native part of the package `edgegait`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::command::{check_contract, command, main};
    #[pymodule_export]
    use crate::errors::Error;
    #[pymodule_export]
    use crate::items::{PyItems, design_text, png};
    #[pymodule_export]
    use crate::pack::PyPack;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        edgegait::encode::read_population_code();
        Ok(())
    }
}
