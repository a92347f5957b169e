//! What a frame measures.

use pyo3::prelude::*;
use shadowgauge::measurement as library;

use crate::errors::raise;

/// What a frame measures: its largest diameter and its mean diameter with their standard
/// uncertainties (k = 1), or why it has none. `to_json` has every key of `shadowgauge measure
/// --json`.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Measurement {
    pub(crate) inner: library::Measurement,
}

#[pymethods]
impl Measurement {
    /// The frame's name.
    #[getter]
    fn frame(&self) -> &str {
        &self.inner.frame
    }

    /// The frame's number.
    #[getter]
    fn frame_id(&self) -> u64 {
        self.inner.frame_id
    }

    /// Columns.
    #[getter]
    fn columns(&self) -> usize {
        self.inner.columns
    }

    /// Columns with both edges.
    #[getter]
    fn valid(&self) -> usize {
        self.inner.valid
    }

    /// Largest diameter, px; None where there is none.
    #[getter]
    fn max_diameter_px(&self) -> Option<f64> {
        self.inner.largest.map(|largest| largest.diameter_px)
    }

    /// Largest diameter at 20 °C, mm; None without a calibration or a diameter.
    #[getter]
    fn max_diameter_mm(&self) -> Option<f64> {
        self.inner.diameter.map(|largest| largest.diameter.d_mm)
    }

    /// Its standard uncertainty, mm.
    #[getter]
    fn u_max_mm(&self) -> Option<f64> {
        self.inner.diameter.map(|largest| largest.u_mm)
    }

    /// Its expanded uncertainty U = k·u, mm.
    #[getter]
    fn expanded_u_max_mm(&self) -> Option<f64> {
        self.inner.diameter.map(|largest| largest.expanded_u_mm)
    }

    /// Mean diameter of the frame at 20 °C, mm.
    #[getter]
    fn mean_diameter_mm(&self) -> Option<f64> {
        self.inner.mean.map(|mean| mean.d_mm)
    }

    /// Its standard uncertainty, mm.
    #[getter]
    fn u_mean_diameter_mm(&self) -> Option<f64> {
        self.inner.mean.map(|mean| mean.u_mm())
    }

    /// Why the frame has no diameter; None where it has one.
    #[getter]
    fn refusal(&self) -> Option<&str> {
        self.inner.refusal.as_ref().map(|refusal| refusal.why.as_str())
    }

    /// The word for it, as in `flags`; None where it has a diameter.
    #[getter]
    fn reason(&self) -> Option<&'static str> {
        self.inner.refusal.as_ref().map(|refusal| refusal.reason.as_str())
    }

    /// An element of `frames` of the command line's document, as JSON.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.inner).map_err(|error| raise(py, "Error", error))
    }

    fn __repr__(&self) -> String {
        match (self.inner.diameter, self.inner.largest, &self.inner.refusal) {
            (_, _, Some(refusal)) => format!("Measurement({}: {})", self.inner.frame, refusal.why),
            (Some(d), _, _) => {
                format!("Measurement({}: {:.5} mm, u {:.5} mm)", self.inner.frame, d.diameter.d_mm, d.u_mm)
            }
            (None, Some(d), _) => format!("Measurement({}: {:.4} px)", self.inner.frame, d.diameter_px),
            _ => format!("Measurement({})", self.inner.frame),
        }
    }
}
