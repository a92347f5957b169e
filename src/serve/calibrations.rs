//! Calibrations that the store has, newest first: made by `calibrate` and uploaded, or of a
//! simulated setup here. Their check pins over time are the gauge's control chart.

use std::time::SystemTime;

use axum::body::Bytes;
use axum::extract::State as Extract;
use axum::http::StatusCode;
use axum::{Extension, Json};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::access::Who;
use super::documents;
use super::files::JobFolder;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::run_config::named_file;
use super::state::Shared;
use super::workshop;
use crate::gauge::Calibration;
use crate::gauge::calibration::{CheckResult, Date};
use crate::source::sha256_hex;
use crate::store::{Entry, EntryKind, Utc};

/// Calibrations of a list at most: two a week for a year.
const LISTED: usize = 100;
/// Largest document, bytes: what a calibration with flat fields has, as it is read elsewhere.
pub(super) const LARGEST_CALIBRATION: usize = 16 << 20;

/// A master pin.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct MasterShown {
    /// Certified diameter, mm.
    diameter_mm: f64,
    /// Expanded uncertainty of its certificate, µm.
    expanded_u_um: f64,
}

/// A check pin that took no part in the fit.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct CheckShown {
    /// Certified diameter, mm.
    certified_mm: f64,
    /// Measured minus certified, µm.
    error_um: f64,
    /// Expanded uncertainty of both together, µm.
    expanded_u_um: f64,
    /// |error| over that (ISO/IEC 17043): accepted up to 1.
    e_n: f64,
    /// Whether the calibration passed.
    accepted: bool,
}

/// A calibration.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct CalibrationShown {
    /// SHA-256 of its document: the key that runs name it by.
    id: String,
    /// When it was stored, ISO 8601.
    utc: String,
    /// What was calibrated.
    optics_id: String,
    /// Day of the calibration; none of a run's own.
    date: Option<String>,
    /// Last day on which it holds.
    expires: Option<String>,
    /// Whether it holds today; unknown without a day.
    holds: Option<bool>,
    /// Scale, µm/px, and its standard uncertainty.
    scale_um_per_px: f64,
    u_scale_um_per_px: f64,
    /// Offset of both edges together, µm, and its standard uncertainty.
    offset_um: f64,
    u_offset_um: f64,
    /// The masters that it was made from.
    masters: Vec<MasterShown>,
    /// Its check pin.
    check: Option<CheckShown>,
}

impl CalibrationShown {
    fn of(id: String, utc: Utc, calibration: &Calibration, today: Date) -> Self {
        let validity = calibration.setup.as_ref().map(|setup| setup.validity);
        let [var_scale, _, var_offset] = calibration.covariance;
        let masters = calibration.masters.iter().map(|master| MasterShown {
            diameter_mm: master.certificate.diameter_mm,
            expanded_u_um: 1e3 * master.certificate.expanded_u_mm,
        });
        Self {
            id,
            utc: utc.to_string(),
            optics_id: calibration.optics_id.clone(),
            date: validity.map(|v| v.date.to_string()),
            expires: validity.map(|v| v.expires().to_string()),
            holds: validity.map(|v| v.date <= today && today <= v.expires()),
            scale_um_per_px: 1e3 * calibration.scale_mm_per_px,
            u_scale_um_per_px: 1e3 * var_scale.max(0.0).sqrt(),
            offset_um: 1e3 * calibration.offset_mm,
            u_offset_um: 1e3 * var_offset.max(0.0).sqrt(),
            masters: masters.collect(),
            check: calibration.setup.as_ref().and_then(|setup| setup.check).map(CheckShown::of),
        }
    }
}

impl CheckShown {
    fn of(check: CheckResult) -> Self {
        Self {
            certified_mm: check.certified_mm,
            error_um: 1e3 * check.error_mm,
            expanded_u_um: 1e3 * check.expanded_u_mm,
            e_n: check.e_n,
            accepted: check.accepted,
        }
    }
}

/// A calibration that cannot be read: of a newer program, or altered.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct UnreadableCalibration {
    /// SHA-256 of its document.
    id: String,
    /// When it was stored, ISO 8601.
    utc: String,
    /// Why it cannot be read.
    unreadable: String,
}

/// A calibration of the list.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub(super) enum ListedCalibration {
    /// One that is read.
    Read(Box<CalibrationShown>),
    /// One that is not.
    Unreadable(UnreadableCalibration),
}

impl ListedCalibration {
    fn of((utc, text): (Utc, String), today: Date) -> Self {
        let id = sha256_hex(&text);
        match Calibration::read(text.as_bytes()) {
            Ok(calibration) => Self::Read(Box::new(CalibrationShown::of(id, utc, &calibration, today))),
            Err(error) => {
                let (utc, unreadable) = (utc.to_string(), error.to_string());
                Self::Unreadable(UnreadableCalibration { id, utc, unreadable })
            }
        }
    }
}

/// The number of a calibration that was stored.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Stored {
    id: String,
}

/// A setup to simulate.
#[derive(Clone, Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SimulatedSetup {
    /// A calibration's file with `[simulate]`, as TOML; it names no files.
    config: String,
}

/// Calibrations, the newest first (100 at most); `unreadable` has why one cannot be read.
#[utoipa::path(get, path = "/api/calibrations", responses((status = 200, body = Vec<ListedCalibration>), (status = 404, body = Words)))]
pub(super) async fn list(Extract(state): Extract<Shared>) -> Result<Json<Vec<ListedCalibration>>, Problem> {
    off_thread(move || {
        let today = Date::of(SystemTime::now());
        let all = documents::newest(&state, EntryKind::Calibration, LISTED)?;
        Ok(Json(all.into_iter().map(|stored| ListedCalibration::of(stored, today)).collect()))
    })
    .await
}

/// Stores a calibration: the JSON that `calibrate --out` wrote (16 MiB at most).
#[utoipa::path(post, path = "/api/calibrations", request_body(content = String, content_type = "application/json"), responses((status = 201, body = Stored), (status = 413), (status = 422, body = Words)))]
pub(super) async fn add(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    body: Bytes,
) -> Result<(StatusCode, Json<Stored>), Problem> {
    off_thread(move || stored(&state, &who, &body)).await
}

fn stored(state: &Shared, who: &Who, document: &[u8]) -> Result<(StatusCode, Json<Stored>), Problem> {
    Calibration::read(document)
        .map_err(|e| Problem::refused(format!("no calibration as `calibrate --out` writes it: {e}")))?;
    let text = String::from_utf8(document.to_vec()).map_err(Problem::refused)?;
    let entry = Entry { kind: EntryKind::Calibration, key: sha256_hex(&text), document: text };
    let id = entry.key.clone();
    documents::put(state, who, &entry)?;
    Ok((StatusCode::CREATED, Json(Stored { id })))
}

/// Calibrates a simulated setup and stores the calibration, unless its check pin refuses it.
#[utoipa::path(post, path = "/api/calibrations/simulated", request_body = SimulatedSetup, responses((status = 201, body = Stored), (status = 422, body = Words), (status = 503, body = Words)))]
pub(super) async fn simulated(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(setup): Json<SimulatedSetup>,
) -> Result<(StatusCode, Json<Stored>), Problem> {
    check(&setup.config)?;
    let _places = state.workshop.place().await?;
    let kept = state.clone();
    let folder = off_thread(move || {
        let folder = JobFolder::new(&kept)?;
        folder.write("setup.toml", setup.config.as_bytes())?;
        Ok(folder)
    })
    .await?;
    // the CPU path: a driver's memory is not that of a job
    let arguments = ["calibrate", "setup.toml", "--out", "calibration.json", "--backend", "cpu"];
    let ended = workshop::run(folder.path(), &arguments).await?;
    off_thread(move || match folder.read("calibration.json") {
        Some(document) => stored(&state, &who, &document),
        None => Err(Problem::refused(ended.words)),
    })
    .await
}

/// A config of a page names no files, and its pins are rendered.
fn check(config: &str) -> Result<(), Problem> {
    let table: toml::Table = config.parse().map_err(Problem::refused)?;
    if let Some(key) = named_file(&table, "") {
        let words =
            format!("{key} names a file: a config from a page names none; use `shadowgauge calibrate`");
        return Err(Problem::refused(words));
    }
    if table.get("simulate").is_some_and(toml::Value::is_table) {
        return Ok(());
    }
    let words = "[simulate] is missing: pins before a camera are recorded by `shadowgauge calibrate`, whose file is uploaded here";
    Err(Problem::refused(words))
}

#[cfg(test)]
mod tests {
    use super::ListedCalibration;
    use crate::gauge::calibration::Date;
    use crate::store::Utc;

    #[test]
    fn a_stored_calibration_that_cannot_be_read_is_listed_with_why() {
        let today: Date = "2026-12-02".parse().unwrap();
        for (document, why) in [("{\"version\": 999}", "version 999"), ("no JSON", "not a calibration")] {
            let listed = ListedCalibration::of((Utc(0), document.to_owned()), today);
            let shown = serde_json::to_value(listed).unwrap();
            assert!(shown["unreadable"].as_str().unwrap().contains(why), "{shown}");
            assert_eq!(
                (shown["id"].as_str().map(str::len), shown["scale_um_per_px"].is_null()),
                (Some(64), true)
            );
        }
    }
}
