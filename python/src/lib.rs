//! The native half of the Python package `shadowgauge`: the library's gauge, streams, calibrations,
//! rendered frames and closed loop as classes, and the program's command line.
//!
//! In: arrays of any `__array_interface__`, settings and configs as JSON and TOML. Out: classes whose
//! numbers the Python half (`python/shadowgauge/`) gives out as NumPy arrays and Arrow tables. What
//! measures, renders or cuts runs without the interpreter's lock. One more class is a file here, a
//! line below, and its stub in `python/shadowgauge/_shadowgauge.pyi`.
//!
//! `array` reads arrays, `meta` what is known of a frame; `calibration`, `gauge` (with `edges` and
//! `measurement`), `stream`, `scene` and `run` are the classes, `controller` a controller in Python
//! behind the protocol of programs; `table`, of `column`s, and `arrow_c` are tables, `errors` the exceptions.

mod array;
mod arrow_c;
mod calibration;
mod column;
mod command_line;
mod controller;
mod edges;
mod errors;
mod gauge;
mod measurement;
mod meta;
mod run;
mod scene;
mod stream;
mod table;

use pyo3::prelude::*;

/// The native half; the package `shadowgauge` is what users import.
#[pymodule]
fn _shadowgauge(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<calibration::Calibration>()?;
    module.add_class::<edges::Edges>()?;
    module.add_class::<gauge::Gauge>()?;
    module.add_class::<measurement::Measurement>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<stream::Stream>()?;
    module.add_class::<table::Table>()?;
    module.add_function(wrap_pyfunction!(command_line::command_line, module)?)?;
    module.add_function(wrap_pyfunction!(scene::decode, module)?)?;
    Ok(())
}
