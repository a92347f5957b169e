//! Rendered frames of a config's shaft with their truth, and images decoded.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use shadowgauge::cell::{drawn_scene, scan_request};
use shadowgauge::config;
use shadowgauge::frame::{Frame, FrameMeta, Pixels};
use shadowgauge::job::Job;
use shadowgauge::plan::ScanPlan;
use shadowgauge::render::{BackendChoice, FrameRequest, Renderer};
use shadowgauge::{render, source, truth};

use crate::column::Values;
use crate::errors::{raise, refused_config};
use crate::meta;
use crate::table::to_numpy;

/// A frame as Python takes it: NumPy array, bits of its grey values or None, metadata.
type PyFrame<'py> = (Bound<'py, PyAny>, Option<u8>, Bound<'py, PyDict>);

/// A frame's pixels as a NumPy array of its own.
fn to_array<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyAny>> {
    let view = frame.view();
    let (dtype, bytes) = match view.pixels() {
        Pixels::U8(pixels) => ("=u1", PyBytes::new(py, pixels)),
        Pixels::U16(pixels) => ("=u2", bytes_of(py, pixels.iter().flat_map(|p| p.to_ne_bytes()))),
        Pixels::F32(pixels) => ("=f4", bytes_of(py, pixels.iter().flat_map(|p| p.to_ne_bytes()))),
    };
    let numpy = py.import("numpy").map_err(|_| {
        raise(
            py,
            "MissingPackage",
            "frames come as NumPy arrays, and this Python has no NumPy: pip install numpy",
        )
    })?;
    numpy.call_method1("frombuffer", (bytes, dtype))?.call_method1("reshape", (view.rows(), view.columns()))
}

fn bytes_of<'py>(py: Python<'py>, bytes: impl Iterator<Item = u8>) -> Bound<'py, PyBytes> {
    PyBytes::new(py, &bytes.collect::<Vec<u8>>())
}

fn to_frame<'py>(py: Python<'py>, frame: &Frame) -> PyResult<PyFrame<'py>> {
    let bits = frame.view().format().full_scale().map(|_| frame.view().format().bit_depth());
    Ok((to_array(py, frame)?, bits, meta::to_dict(py, &frame.meta)?))
}

/// Decodes an image of any format that the program reads: pixels, bits, metadata.
#[pyfunction]
#[pyo3(signature = (data, bits=None))]
pub(crate) fn decode<'py>(py: Python<'py>, data: &[u8], bits: Option<u8>) -> PyResult<PyFrame<'py>> {
    let decoded = py.detach(|| source::decode(data, bits, FrameMeta::default()));
    to_frame(py, &decoded.map_err(|error| raise(py, "FrameError", error))?)
}

/// A backend by its name on the command line.
pub(crate) fn backend(py: Python<'_>, name: &str) -> PyResult<BackendChoice> {
    match name {
        "auto" => Ok(BackendChoice::Auto),
        "vulkan" => Ok(BackendChoice::Vulkan),
        "gl" => Ok(BackendChoice::Gl),
        "cpu" => Ok(BackendChoice::Cpu),
        other => {
            let text = format!("backend = {other:?}: must be 'auto', 'vulkan', 'gl' or 'cpu'");
            Err(raise(py, "SettingError", text))
        }
    }
}

/// The config of a path, or of a text whose files lie in `folder`.
pub(crate) fn read_job(py: Python<'_>, text: Option<&str>, path: &Path, for_scene: bool) -> PyResult<Job> {
    let read = match text {
        Some(text) => config::load_text(text, "config", path),
        None if for_scene => config::load_scene(path),
        None => config::load(path),
    };
    read.map_err(|error| refused_config(py, &error))
}

/// The drawn shaft of a config under its camera.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Scene {
    scene: render::Scene,
    job: Job,
    plan: ScanPlan,
    renderer: Renderer,
    /// Memory of a spent frame.
    spare: Mutex<Option<Frame>>,
}

impl Scene {
    fn request(&self, index: usize, noise: bool) -> FrameRequest {
        FrameRequest { noise, ..scan_request(&self.job, &self.plan, index) }
    }
}

#[pymethods]
impl Scene {
    /// Of a config file, or of a text of one.
    #[new]
    #[pyo3(signature = (path, text=None, seed=None, backend="cpu"))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        text: Option<&str>,
        seed: Option<u64>,
        backend: &str,
    ) -> PyResult<Self> {
        let mut job = read_job(py, text, &path, true)?;
        job.seed = seed.unwrap_or(job.seed);
        let failed = |error: render::RenderError| raise(py, "Error", error);
        let scene = drawn_scene(&job).map_err(failed)?;
        let renderer = Renderer::new(self::backend(py, backend)?).map_err(failed)?;
        let plan = job.loop_job().scan_plan();
        Ok(Self { scene, job, plan, renderer, spare: Mutex::new(None) })
    }

    /// Frames of one scan; more begin it anew.
    fn __len__(&self) -> usize {
        self.plan.frames()
    }

    /// Pixel size on the object by the data sheets, µm.
    #[getter]
    fn nominal_um_per_px(&self) -> f64 {
        1e3 * self.job.nominal_mm_per_px()
    }

    /// True pixel size on the object, µm, as a calibration would find it.
    #[getter]
    fn true_um_per_px(&self) -> f64 {
        1e3 * self.scene.setup().pixel_mm
    }

    /// Frame `index` of the scan: pixels, bits, metadata.
    #[pyo3(signature = (index, noise=true))]
    fn frame<'py>(&self, py: Python<'py>, index: usize, noise: bool) -> PyResult<PyFrame<'py>> {
        let request = self.request(index, noise);
        let frame = py.detach(|| {
            let spare = self.spare.lock().ok().and_then(|mut spare| spare.take());
            self.renderer.render(&self.scene, &request, spare)
        });
        let frame = frame.map_err(|error| raise(py, "Error", error))?;
        let given = to_frame(py, &frame)?;
        if let Ok(mut spare) = self.spare.lock() {
            *spare = Some(frame);
        }
        Ok(given)
    }

    /// True rows of both edges of every column of a frame, px.
    fn true_edges<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let edges = truth::true_edges(&self.scene, &self.request(index, false));
        let edges = edges.map_err(|error| raise(py, "Error", error))?;
        let top = Values::Double(edges.iter().map(|edge| edge.top_px).collect());
        let bottom = Values::Double(edges.iter().map(|edge| edge.bottom_px).collect());
        Ok((to_numpy(py, &top)?, to_numpy(py, &bottom)?))
    }
}
