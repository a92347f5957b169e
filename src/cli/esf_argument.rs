//! `measure --esf`: the edge-spread function by its name or from a file.

use std::path::Path;

use super::Failure;
use crate::config;
use crate::gauge::{EsfModel, EsfSamples};
use crate::render::esf::{EsfTable, Extent};
use crate::render::esf_families::MeasuredEdge;

/// Steps of the table handed to the gauge, px.
const STEP_PX: f64 = 0.05;
/// Farthest distance of its samples, px.
const REACH_PX: f64 = 60.0;
/// Distance from which ripples fade out, px: windows are 72 px long.
const FADE_PX: f64 = 44.0;

/// The model of `gaussian`, `learnt`, a CSV file `d_um,intensity`, or the `[optics]` of a config.
///
/// # Errors
/// Exit 2 for a name that is none, a file without a scale to read it by, or one that is no edge; 3 for one that cannot be read.
pub fn esf_model(text: &str, um_per_px: Option<f64>) -> Result<EsfModel, Failure> {
    match text {
        "gaussian" => return Ok(EsfModel::Gaussian {}),
        "learnt" => return Ok(EsfModel::Learnt {}),
        _ => {}
    }
    let path = Path::new(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => measured(path, um_per_px),
        Some("toml") => of_config(path, um_per_px),
        _ => Err(Failure::refuse(format!(
            "--esf {text}: right would be gaussian, learnt, a .csv file d_um,intensity or a .toml config with [optics.esf]"
        ))),
    }
}

fn measured(path: &Path, um_per_px: Option<f64>) -> Result<EsfModel, Failure> {
    let named = |e: &dyn std::fmt::Display| format!("--esf {}: {e}", path.display());
    let um_per_px = um_per_px.ok_or_else(|| {
        Failure::refuse(named(&"its distances are in µm: give --calibration or --um-per-px"))
    })?;
    let file = std::fs::File::open(path).map_err(|e| Failure::fail(named(&e)))?;
    let edge = MeasuredEdge::read(file, false).map_err(|e| Failure::refuse(named(&e)))?;
    let spread = edge.edge_spread().map_err(|e| Failure::refuse(named(&e)))?;
    let (from, to) = spread.range_um();
    Ok(sampled(from / um_per_px, to / um_per_px, |d_px| spread.value(d_px * um_per_px)))
}

/// The family that a config renders with, in focus, at the scale given or the config's own.
fn of_config(path: &Path, um_per_px: Option<f64>) -> Result<EsfModel, Failure> {
    let job = config::load(path).map_err(Failure::refused)?;
    let own_um = job.camera.pixel_um / job.optics.magnification;
    let pixel_mm = 1e-3 * um_per_px.unwrap_or(own_um);
    let radius_mm = 0.5 * job.part.stock_diameter_mm;
    let extent = Extent { pixel_mm, depth_mm: 0.0, radius_mm: (radius_mm, radius_mm) };
    let table = EsfTable::new(&job.optics.esf, &job.optics, &extent).map_err(Failure::refuse)?;
    let at = table.place(0.0, radius_mm, 0.0);
    let reach = f64::from(table.reach) * table.scale_px;
    Ok(sampled(-reach, reach, |d_px| table.light(&at, d_px)))
}

/// 1 up to [`FADE_PX`] into the light, 0 from [`REACH_PX`] on.
fn fade(d_px: f64) -> f64 {
    let t = ((d_px - FADE_PX) / (REACH_PX - FADE_PX)).clamp(0.0, 1.0);
    0.5 + 0.5 * (std::f64::consts::PI * t).cos()
}

/// Samples over the range, widened by a pixel so that the ends are flat. Ripples that reach farther than a table may (a laser's) fade out
/// from where no window reads them.
fn sampled(from_px: f64, to_px: f64, light: impl Fn(f64) -> f64) -> EsfModel {
    let end = |d: f64| ((d.abs() + 1.0).min(REACH_PX) / STEP_PX).ceil() as i32;
    let distance_px: Vec<f64> = (-end(from_px)..=end(to_px)).map(|k| STEP_PX * f64::from(k)).collect();
    let light = distance_px.iter().map(|d| 1.0 + (light(*d) - 1.0) * fade(*d)).collect();
    EsfModel::Table(EsfSamples { distance_px, light })
}
