//! The gauge: checked settings, and the edges of single frames.

use pyo3::prelude::*;
use shadowgauge::gauge as library;

use crate::array::Array;
use crate::calibration::Calibration;
use crate::edges::Edges;
use crate::errors::{from_json, raise};

/// The gauge by its settings, the keys of `[gauge]` in a config; checked once.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Gauge {
    pub(crate) inner: library::Gauge,
}

#[pymethods]
impl Gauge {
    /// A gauge of settings in JSON; with a calibration, one that expects what its masters left.
    #[new]
    #[pyo3(signature = (settings_json="{}", calibration=None))]
    fn new(
        py: Python<'_>,
        settings_json: &str,
        calibration: Option<PyRef<'_, Calibration>>,
    ) -> PyResult<Self> {
        let settings = from_json(py, "gauge", settings_json)?;
        let calibration = calibration.as_ref().map(|calibration| &calibration.inner);
        let made = library::Gauge::calibrated(settings, calibration);
        Ok(Self { inner: made.map_err(|error| raise(py, "SettingError", error))? })
    }

    /// Edges of one frame by itself.
    #[pyo3(signature = (frame, bits=None, full_scale=None))]
    fn edges(&self, frame: &Bound<'_, PyAny>, bits: Option<u8>, full_scale: Option<f32>) -> PyResult<Edges> {
        let array = Array::read(frame, bits, full_scale)?;
        let view = array.view();
        let found = frame.py().detach(|| self.inner.edges(&view));
        Ok(Edges { inner: found.map_err(|error| raise(frame.py(), "FrameRefused", error))? })
    }
}
