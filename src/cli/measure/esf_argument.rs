//! `--esf` of `measure` and `calibrate`: the edge-spread function by its name or from a file.

use std::path::Path;

use crate::cli::failure::Failure;
use crate::cli::optics::NominalOptics;
use crate::gauge::{EdgeTable, EsfModel};
use crate::job::sampled_edge;
use crate::render::optics::edge_spread::MeasuredEdge;

/// Whether a model is in µm and needs a scale.
pub(crate) fn needs_scale(text: &str) -> bool {
    matches!(Path::new(text).extension().and_then(|e| e.to_str()), Some("csv" | "json"))
}

/// The model of `gaussian`, `learnt`, a table of distances in µm (.csv or .json, as `optics esf`
/// prints them), or the `[optics]` of a config.
///
/// # Errors
/// Exit 2 for an unknown name, a file in µm without a scale, or one that is not an edge; 3 for one
/// that cannot be read.
pub(crate) fn esf_model(text: &str, um_per_px: Option<f64>) -> Result<EsfModel, Failure> {
    match text {
        "gaussian" => return Ok(EsfModel::Gaussian {}),
        "learnt" => return Ok(EsfModel::Learnt {}),
        _ => {}
    }
    let path = Path::new(text);
    let named = |e: &dyn std::fmt::Display| format!("--esf {text}: {e}");
    let scale = || {
        um_per_px.ok_or_else(|| {
            Failure::refuse(named(&"its distances are in µm: give --calibration or --um-per-px"))
        })
    };
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => measured(&bytes_of(path, text)?, scale()?).map_err(|e| Failure::refuse(named(&e))),
        Some("json") => {
            let table: EdgeTable = of_json(&text_of(path, text)?).map_err(|e| Failure::refuse(named(&e)))?;
            let lines = table.distance_um.iter().zip(&table.light);
            let csv = lines.fold(String::new(), |all, (d, l)| all + &format!("{d},{l}\n"));
            measured(csv.as_bytes(), scale()?).map_err(|e| Failure::refuse(named(&e)))
        }
        Some("toml") => of_config(path, um_per_px),
        _ => Err(Failure::refuse(named(
            &"right would be gaussian, learnt, a table distance_um,light (.csv or .json, as `optics esf` prints it) or a .toml config with [optics.esf]",
        ))),
    }
}

fn bytes_of(path: &Path, name: &str) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|e| Failure::fail(format!("--esf {name}: {e}")))
}

fn text_of(path: &Path, name: &str) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|e| Failure::fail(format!("--esf {name}: {e}")))
}

/// The arrays `distance_um` and `light` of a JSON object, whatever else it holds.
fn of_json(text: &str) -> Result<EdgeTable, String> {
    #[derive(serde::Deserialize)]
    struct Arrays {
        distance_um: Vec<f64>,
        light: Vec<f64>,
    }
    let Arrays { distance_um, light } = serde_json::from_str(text).map_err(|e| e.to_string())?;
    if distance_um.len() != light.len() {
        let (n, m) = (distance_um.len(), light.len());
        return Err(format!(
            "{n} distances and {m} values of light; must be as many of the one as of the other"
        ));
    }
    Ok(EdgeTable { distance_um, light })
}

fn measured(bytes: &[u8], um_per_px: f64) -> Result<EsfModel, String> {
    let edge = MeasuredEdge::read(bytes, false).map_err(|e| e.to_string())?;
    let spread = edge.edge_spread().map_err(|e| e.to_string())?;
    let (from, to) = spread.range_um();
    Ok(sampled_edge(from / um_per_px, to / um_per_px, |d_px| spread.value(d_px * um_per_px)))
}

/// The model of a config's optics, in focus on the finished part, at the given scale or the
/// config's own.
fn of_config(path: &Path, um_per_px: Option<f64>) -> Result<EsfModel, Failure> {
    let nominal = NominalOptics::load(path)?;
    let edge = nominal.edge(nominal.radius_mm, 0.0)?;
    let um_per_px = um_per_px.unwrap_or(1e3 * nominal.pixel_mm);
    Ok(edge.model(um_per_px))
}
