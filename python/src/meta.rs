//! What is known of a frame besides its pixels.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use shadowgauge::frame::FrameMeta;

use crate::errors::raise;

/// Keys of a frame's metadata, as in `frames.csv`.
const KEYS: &str = "frame_id, t_ns, z_mm, angle_deg, sweep_deg, exposure_us";

/// The metadata of a frame by its keys; those left out are 0.
///
/// # Errors
/// `FrameError` for a key that is none, or a value of another type.
pub(crate) fn of_dict(given: Option<&Bound<'_, PyDict>>) -> PyResult<FrameMeta> {
    let mut meta = FrameMeta::default();
    let Some(given) = given else { return Ok(meta) };
    for (key, value) in given.iter() {
        let key: String = key.extract()?;
        let wrong =
            |_| raise(given.py(), "FrameError", format!("{key} = {value} of a frame is no number for it"));
        match key.as_str() {
            "frame_id" => meta.frame_id = value.extract().map_err(wrong)?,
            "t_ns" => meta.t_ns = value.extract().map_err(wrong)?,
            "z_mm" => meta.z_mm = value.extract().map_err(wrong)?,
            "angle_deg" => meta.angle_deg = value.extract().map_err(wrong)?,
            "sweep_deg" => meta.sweep_deg = value.extract().map_err(wrong)?,
            "exposure_us" => meta.exposure_us = value.extract().map_err(wrong)?,
            other => {
                return Err(raise(
                    given.py(),
                    "FrameError",
                    format!("a frame has no {other:?}; it has {KEYS}"),
                ));
            }
        }
    }
    Ok(meta)
}

/// The metadata of a frame as keywords.
pub(crate) fn to_dict<'py>(py: Python<'py>, meta: &FrameMeta) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("frame_id", meta.frame_id)?;
    dict.set_item("t_ns", meta.t_ns)?;
    dict.set_item("z_mm", meta.z_mm)?;
    dict.set_item("angle_deg", meta.angle_deg)?;
    dict.set_item("sweep_deg", meta.sweep_deg)?;
    dict.set_item("exposure_us", meta.exposure_us)?;
    Ok(dict)
}
