//! Many frames of one camera.

use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use shadowgauge::gauge as instrument;
use shadowgauge::measurement as library;

use crate::array::Array;
use crate::calibration::Calibration;
use crate::column::Values;
use crate::edges::Edges;
use crate::errors::{from_json, raise};
use crate::gauge::Gauge;
use crate::measurement::Measurement;
use crate::meta;
use crate::table::Table;

/// What a frame leaves in a stream's table.
struct Row {
    frame_id: i64,
    t_ns: i64,
    z_mm: f64,
    angle_deg: f64,
    max_diameter_mm: f64,
    u_max_mm: f64,
    mean_diameter_mm: f64,
    u_mean_diameter_mm: f64,
    flag: &'static str,
}

/// What a stream has: its frames' edges and its series until it is finished.
struct State {
    inner: Option<library::Stream>,
    rows: Vec<Row>,
    keeps_rows: bool,
}

/// Measures the frames of one camera one after another: tables, tracking and buffers are kept.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Stream {
    state: Mutex<State>,
}

impl Stream {
    pub(crate) fn of(
        py: Python<'_>,
        gauge: &Gauge,
        calibration: Option<&Calibration>,
        settings: library::MeasureSettings,
    ) -> PyResult<Self> {
        let made = match calibration {
            Some(calibration) => library::Stream::calibrated(&gauge.inner, &calibration.inner, settings),
            None => library::Stream::in_pixels(&gauge.inner, settings),
        };
        let inner = Some(made.map_err(|error| raise(py, "SettingError", error))?);
        Ok(Self { state: Mutex::new(State { inner, rows: Vec::new(), keeps_rows: true }) })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn is_finished(py: Python<'_>) -> PyErr {
    raise(py, "Error", "the stream is finished: begin another one")
}

#[pymethods]
impl Stream {
    /// A stream in millimetres, or without a calibration in pixels; settings in JSON, the options of
    /// `measure`.
    #[new]
    #[pyo3(signature = (gauge, calibration=None, settings_json="{}", keep_rows=true))]
    fn new(
        py: Python<'_>,
        gauge: PyRef<'_, Gauge>,
        calibration: Option<PyRef<'_, Calibration>>,
        settings_json: &str,
        keep_rows: bool,
    ) -> PyResult<Self> {
        let settings = from_json(py, "measure", settings_json)?;
        let stream = Self::of(py, &gauge, calibration.as_deref(), settings)?;
        stream.lock().keeps_rows = keep_rows;
        Ok(stream)
    }

    /// Measures a frame: its diameters, or its refusal. It counts in the series either way.
    #[pyo3(signature = (frame, meta=None, name=None, bits=None, full_scale=None))]
    pub(crate) fn push(
        &self,
        frame: &Bound<'_, PyAny>,
        meta: Option<&Bound<'_, PyDict>>,
        name: Option<&str>,
        bits: Option<u8>,
        full_scale: Option<f32>,
    ) -> PyResult<Measurement> {
        let py = frame.py();
        let array = Array::read(frame, bits, full_scale)?;
        let (view, meta) = (array.view(), meta::of_dict(meta)?);
        let pushed = py.detach(|| {
            let mut state = self.lock();
            let stream = state.inner.as_mut()?;
            let result = match name {
                Some(name) => stream.push_named(name, &meta, &view),
                None => stream.push(&meta, &view),
            };
            let refused = result.err().filter(library::MeasureError::is_of_settings);
            let measurement = stream.measurement().clone();
            if state.keeps_rows {
                state.rows.push(row(&meta, &measurement));
            }
            Some(refused.map_or(Ok(measurement), Err))
        });
        match pushed {
            Some(Ok(inner)) => Ok(Measurement { inner }),
            Some(Err(error)) => Err(raise(py, "SettingError", error)),
            None => Err(is_finished(py)),
        }
    }

    /// A frame that its source could not deliver: a gap of the series, with the reason.
    fn push_unreadable(&self, py: Python<'_>, name: &str, why: String) -> PyResult<Measurement> {
        let mut state = self.lock();
        let Some(stream) = state.inner.as_mut() else { return Err(is_finished(py)) };
        let inner = stream.push_unreadable(name, why).clone();
        if state.keeps_rows {
            state.rows.push(row(&shadowgauge::frame::FrameMeta::default(), &inner));
        }
        Ok(Measurement { inner })
    }

    /// The edges of the frame pushed last; None where it was refused.
    fn edges(&self) -> Option<Edges> {
        let state = self.lock();
        let edges: Option<&instrument::FrameEdges> = state.inner.as_ref().and_then(library::Stream::edges);
        edges.map(|edges| Edges { inner: edges.clone() })
    }

    /// A row a frame so far.
    fn table(&self) -> Table {
        let state = self.lock();
        let double = |of: fn(&Row) -> f64| Values::Double(state.rows.iter().map(of).collect());
        let int = |of: fn(&Row) -> i64| Values::Int(state.rows.iter().map(of).collect());
        Table::new(vec![
            ("frame_id", int(|r| r.frame_id)),
            ("t_ns", int(|r| r.t_ns)),
            ("z_mm", double(|r| r.z_mm)),
            ("angle_deg", double(|r| r.angle_deg)),
            ("max_diameter_mm", double(|r| r.max_diameter_mm)),
            ("u_max_mm", double(|r| r.u_max_mm)),
            ("mean_diameter_mm", double(|r| r.mean_diameter_mm)),
            ("u_mean_diameter_mm", double(|r| r.u_mean_diameter_mm)),
            ("flag", Values::Text(state.rows.iter().map(|r| r.flag.to_owned()).collect())),
        ])
    }

    /// Ends the stream: the results over all frames as JSON (statistics, turn, warnings).
    fn finish(&self, py: Python<'_>) -> PyResult<String> {
        let stream = self.lock().inner.take().ok_or_else(|| is_finished(py))?;
        let series = py.detach(|| stream.finish()).map_err(|error| raise(py, "Error", error))?;
        serde_json::to_string(&series).map_err(|error| raise(py, "Error", error))
    }
}

fn row(meta: &shadowgauge::frame::FrameMeta, m: &library::Measurement) -> Row {
    Row {
        frame_id: meta.frame_id.cast_signed(),
        t_ns: meta.t_ns.cast_signed(),
        z_mm: meta.z_mm,
        angle_deg: meta.angle_deg,
        max_diameter_mm: m.diameter.map_or(f64::NAN, |largest| largest.diameter.d_mm),
        u_max_mm: m.diameter.map_or(f64::NAN, |largest| largest.u_mm),
        mean_diameter_mm: m.mean.map_or(f64::NAN, |mean| mean.d_mm),
        u_mean_diameter_mm: m.mean.map_or(f64::NAN, |mean| mean.u_mm()),
        flag: m.refusal.as_ref().map_or("", |refusal| refusal.reason.as_str()),
    }
}
