//! Calibrations: pixels to millimetres.

use pyo3::prelude::*;
use shadowgauge::gauge as library;
use shadowgauge::gauge::{MasterCertificate, MasterMeasurement};

use crate::column::Values;
use crate::edges::Edges;
use crate::errors::raise;
use crate::table::Table;

/// Pixels to millimetres at 20 °C, with the uncertainties of both.
///
/// From a scale alone, a calibration file, or frames of master pins.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Calibration {
    pub(crate) inner: library::Calibration,
}

#[pymethods]
impl Calibration {
    /// A bare scale in µm per pixel, without offset and uncertainty, as `measure --um-per-px`.
    #[staticmethod]
    fn from_scale(py: Python<'_>, um_per_px: f64) -> PyResult<Self> {
        if !(um_per_px > 0.0 && um_per_px <= 1e6) {
            let text = format!("um_per_px = {um_per_px}: must be above 0, at most 1e6");
            return Err(raise(py, "SettingError", text));
        }
        Ok(Self { inner: library::Calibration::from_scale(um_per_px) })
    }

    /// Reads a calibration from the JSON of a file that `shadowgauge calibrate` writes.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let read = library::Calibration::read(text.as_bytes());
        Ok(Self { inner: read.map_err(|error| raise(py, "CalibrationError", error))? })
    }

    /// Fits scale and offset to master pins: a list of `(diameter_mm, expanded_u_mm, edges)`, edges
    /// being a list of the `Edges` of the pin's frames; k = 2.
    #[staticmethod]
    fn fit(py: Python<'_>, masters: Vec<(f64, f64, Vec<PyRef<'_, Edges>>)>) -> PyResult<Self> {
        let master =
            |(diameter_mm, expanded_u_mm, edges): &(f64, f64, Vec<PyRef<'_, Edges>>)| MasterMeasurement {
                certificate: MasterCertificate {
                    diameter_mm: *diameter_mm,
                    expanded_u_mm: *expanded_u_mm,
                    coverage_factor: 2.0,
                },
                frames: edges.iter().map(|edges| edges.inner.clone()).collect(),
            };
        let masters: Vec<MasterMeasurement> = masters.iter().map(master).collect();
        let fitted = py.detach(|| library::Calibration::fit(&masters));
        Ok(Self { inner: fitted.map_err(|error| raise(py, "CalibrationError", error))? })
    }

    /// Its file, as JSON.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string_pretty(&self.inner).map_err(|error| raise(py, "CalibrationError", error))
    }

    /// Scale, µm per pixel on the object.
    #[getter]
    fn scale_um_per_px(&self) -> f64 {
        1e3 * self.inner.scale_mm_per_px
    }

    /// What both edges together add to every width, µm.
    #[getter]
    fn offset_um(&self) -> f64 {
        1e3 * self.inner.offset_mm
    }

    /// The optics that it belongs to; empty where none is named.
    #[getter]
    fn optics_id(&self) -> &str {
        &self.inner.optics_id
    }

    /// The diameter of every column in millimetres: `column`, `d_mm`, `u_random_mm`, `u_common_mm`,
    /// `flag`; NaN in a gap.
    fn diameters(&self, edges: PyRef<'_, Edges>) -> Table {
        let diameters = self.inner.diameters(&edges.inner);
        let value = |of: fn(shadowgauge::profile::Diameter) -> f64| {
            let columns = diameters.columns.iter();
            Values::Double(columns.map(|column| column.reading.value().map_or(f64::NAN, of)).collect())
        };
        Table::new(vec![
            ("column", Values::Int((0..diameters.columns.len() as i64).collect())),
            ("d_mm", value(|d| d.d_mm)),
            ("u_random_mm", value(|d| d.u_random_mm)),
            ("u_common_mm", value(|d| d.u_common_mm)),
            ("flag", Values::Text(edges.flags())),
        ])
    }

    fn __repr__(&self) -> String {
        format!("Calibration({:.5} µm/px, offset {:.3} µm)", self.scale_um_per_px(), self.offset_um())
    }
}
