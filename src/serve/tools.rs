//! Tools: an insert in its holder, and what was measured of it, image by image.

use axum::body::Bytes;
use axum::extract::{Path, Query, State as Extract};
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use axum::{Extension, Json};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::{IntoParams, ToSchema};

use super::access::Who;
use super::documents::{self, Document};
use super::files::{self, JobFolder};
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use super::workshop;
use crate::gauge::flank::FlankSide;
use crate::store::{EntryKind, Utc};
use crate::tool::{ToolFile, read_nose};

/// Tools of a list at most.
const LISTED: usize = 1000;
/// Readings of a tool that are kept in its document; the audit has those before.
const MOST_READINGS: usize = 100;
/// Largest image, bytes: 3072 × 2048 px of 16 bits are 12 MiB.
pub(super) const LARGEST_IMAGE: usize = 32 << 20;
/// Values of a reading that are kept in the document; the whole of it is a file.
const KEPT: [&str; 17] = [
    "mean_radius_mm",
    "u_mean_radius_mm",
    "angle_deg",
    "u_angle_deg",
    "sigma_px",
    "reference",
    "flags",
    "vbb_um",
    "u_vbb_um",
    "vbb_max_um",
    "u_vbb_max_um",
    "vc_um",
    "vn_um",
    "verdict",
    "reason",
    "confidence",
    "wear",
];

/// What an image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ImageKind {
    /// The nose, back-lit.
    Nose,
    /// The same nose when it was new.
    Baseline,
    /// The flank, front-lit.
    Flank,
}

/// What was measured in an image.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub(super) struct ToolReading {
    /// What it shows.
    pub kind: ImageKind,
    /// When it was measured, ISO 8601.
    pub utc: String,
    /// Scale, µm per px.
    pub um_per_px: f64,
    /// SHA-256 of the image.
    pub image: String,
    /// SHA-256 of the whole reading, as `tool nose` or `tool flank` has it.
    pub document: String,
    /// SHA-256 of the picture with what was found drawn over it.
    pub overlay: Option<String>,
    /// Its main values, with their standard uncertainty (`u_…`) and flags.
    #[schema(value_type = Object)]
    pub values: serde_json::Map<String, Value>,
}

/// A tool.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Insert {
    /// Its name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Its angles, nose and tip direction as TOML (`schema tool`).
    pub tool: String,
    /// Its nose as measured, where there is no image: the JSON of `tool nose --out`.
    #[serde(default)]
    pub nose: Option<String>,
    /// What was measured here, the newest last.
    #[serde(default)]
    #[schema(read_only)]
    pub readings: Vec<ToolReading>,
}

impl Document for Insert {
    const KIND: EntryKind = EntryKind::Insert;
    const WORD: &'static str = "tool";

    fn name(&self) -> &str {
        &self.name
    }
}

impl Insert {
    fn check(&self) -> Result<(), Problem> {
        let file: ToolFile =
            toml::from_str(&self.tool).map_err(|e| Problem::refused(format!("tool: {e}")))?;
        let geometry = file.geometry().map_err(|e| Problem::refused(format!("tool: {e}")))?;
        if let Some(nose) = &self.nose {
            read_nose(nose, None, file.image, &geometry)
                .map_err(|e| Problem::refused(format!("nose: {e}")))?;
        }
        Ok(())
    }

    fn newest(&self, kind: ImageKind) -> Option<&ToolReading> {
        self.readings.iter().rev().find(|reading| reading.kind == kind)
    }

    /// The document of its nose: of the newest image, else the one that was given.
    pub(super) fn nose_document(&self, state: &Shared) -> Result<Option<Vec<u8>>, Problem> {
        match self.newest(ImageKind::Nose) {
            Some(reading) => files::get(state, &reading.document).map(Some),
            None => Ok(self.nose.clone().map(String::into_bytes)),
        }
    }
}

/// All tools, by name.
#[utoipa::path(get, path = "/api/tools", responses((status = 200, body = Vec<Insert>), (status = 404, body = Words)))]
pub(super) async fn list(Extract(state): Extract<Shared>) -> Result<Json<Vec<Insert>>, Problem> {
    off_thread(move || Ok(Json(documents::list(&state, (0, LISTED))?.1))).await
}

/// Adds a tool.
#[utoipa::path(post, path = "/api/tools", request_body = Insert, responses((status = 201), (status = 409, body = Words), (status = 422, body = Words)))]
pub(super) async fn add(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(insert): Json<Insert>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        insert.check()?;
        let insert = Insert { readings: Vec::new(), ..insert };
        documents::add(&state, &who, &insert).map(|()| StatusCode::CREATED)
    })
    .await
}

/// A tool.
#[utoipa::path(get, path = "/api/tools/{name}", responses((status = 200, body = Insert), (status = 404, body = Words)))]
pub(super) async fn show(
    Extract(state): Extract<Shared>,
    Path(name): Path<String>,
) -> Result<Json<Insert>, Problem> {
    off_thread(move || documents::get(&state, &name).map(Json)).await
}

/// Takes a tool out; programs that were made stay.
#[utoipa::path(delete, path = "/api/tools/{name}", responses((status = 204), (status = 404, body = Words)))]
pub(super) async fn remove(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
) -> Result<StatusCode, Problem> {
    off_thread(move || documents::remove::<Insert>(&state, &who, &name).map(|()| StatusCode::NO_CONTENT))
        .await
}

/// What is stated of an image.
#[derive(Clone, Debug, Deserialize, IntoParams)]
pub(super) struct OfImage {
    /// What it shows: nose, baseline or flank.
    #[param(inline)]
    kind: ImageKind,
    /// Scale, µm per px.
    um_per_px: f64,
    /// At which side of its cutting edge a flank lies in its image, where two borders could be it:
    /// any, below, right, above or left.
    #[serde(default)]
    #[param(inline)]
    flank_side: FlankSide,
}

/// Measures an image of a tool (32 MiB at most) and keeps the reading.
#[utoipa::path(post, path = "/api/tools/{name}/images", params(OfImage), request_body(content = Vec<u8>, content_type = "application/octet-stream"), responses((status = 201, body = ToolReading), (status = 404, body = Words), (status = 413), (status = 422, body = Words)))]
pub(super) async fn image(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
    Query(of): Query<OfImage>,
    bytes: Bytes,
) -> Result<(StatusCode, Json<ToolReading>), Problem> {
    if !(of.um_per_px.is_finite() && of.um_per_px > 0.0) {
        return Err(Problem::refused("um_per_px: a scale above 0 is needed, for instance 2.415"));
    }
    let places = state.workshop.place().await?;
    let (kept, of_tool, given) = (state.clone(), name.clone(), bytes.clone());
    let folder = off_thread(move || {
        let insert: Insert = documents::get(&kept, &of_tool)?;
        let folder = JobFolder::new(&kept)?;
        folder.write("image", &given)?;
        folder.write("tool.toml", insert.tool.as_bytes())?;
        if let Some(baseline) = insert.newest(ImageKind::Baseline).filter(|_| of.kind == ImageKind::Nose) {
            folder.write("baseline.json", &files::get(&kept, &baseline.document)?)?;
        }
        Ok(folder)
    })
    .await?;
    let scale = of.um_per_px.to_string();
    let has_baseline = folder.path().join("baseline.json").is_file();
    workshop::run(folder.path(), &arguments(&of, &scale, has_baseline)).await?;
    let reading = off_thread(move || stored(&state, (&who, &name), &of, (&folder, &bytes))).await?;
    drop(places);
    Ok((StatusCode::CREATED, Json(reading)))
}

/// The command that measures an image.
fn arguments<'a>(of: &OfImage, scale: &'a str, has_baseline: bool) -> Vec<&'a str> {
    let shared = ["--um-per-px", scale, "--json", "--overlay", "overlay.png"];
    if of.kind == ImageKind::Flank {
        return [&["tool", "flank", "image", "--flank-side", of.flank_side.word()][..], &shared].concat();
    }
    let nose = ["tool", "nose", "image", "--tool", "tool.toml"];
    let baseline: &[&str] = if has_baseline { &["--baseline", "baseline.json"] } else { &[] };
    [&nose[..], &shared, baseline].concat()
}

/// Keeps a reading with its files.
fn stored(
    state: &Shared,
    (who, name): (&Who, &str),
    of: &OfImage,
    (folder, image): (&JobFolder, &[u8]),
) -> Result<ToolReading, Problem> {
    let text = folder.read("stdout").unwrap_or_default();
    let document: Value = serde_json::from_slice(&text).map_err(Problem::failed)?;
    let values = document["images"][0].as_object();
    let values = values.ok_or_else(|| Problem::failed("the reading has no image"))?;
    let values = values.iter().filter(|(key, _)| KEPT.contains(&key.as_str()));
    let reading = ToolReading {
        kind: of.kind,
        utc: Utc::now().to_string(),
        um_per_px: of.um_per_px,
        image: files::put(state, image)?,
        document: files::put(state, &text)?,
        overlay: folder.read("overlay.png").map(|png| files::put(state, &png)).transpose()?,
        values: values.map(|(key, value)| (key.clone(), value.clone())).collect(),
    };
    let added = reading.clone();
    documents::update(state, who, name, |insert: &mut Insert| {
        insert.readings.push(added);
        let before = insert.readings.len().saturating_sub(MOST_READINGS);
        insert.readings.drain(..before);
    })?;
    Ok(reading)
}

/// Which reading.
#[derive(Clone, Debug, Deserialize, IntoParams)]
pub(super) struct OfReading {
    /// Its number, from 0; the newest where none is given.
    reading: Option<usize>,
}

/// An image with what was found drawn over it.
#[utoipa::path(get, path = "/api/tools/{name}/overlay", params(OfReading), responses((status = 200, body = Vec<u8>, content_type = "image/png"), (status = 404, body = Words)))]
pub(super) async fn overlay(
    Extract(state): Extract<Shared>,
    Path(name): Path<String>,
    Query(of): Query<OfReading>,
) -> Result<impl IntoResponse, Problem> {
    let png = off_thread(move || {
        let insert: Insert = documents::get(&state, &name)?;
        let reading = match of.reading {
            Some(k) => insert.readings.get(k),
            None => insert.readings.last(),
        };
        let overlay = reading.and_then(|reading| reading.overlay.as_deref());
        files::get(&state, overlay.ok_or_else(|| Problem::absent(format!("{name} has no such image")))?)
    })
    .await?;
    Ok(([(header::CONTENT_TYPE, "image/png")], png))
}

#[cfg(test)]
mod tests {
    use axum::extract::Query;
    use axum::http::Uri;

    use super::{OfImage, arguments};

    fn of(query: &str) -> Result<String, String> {
        let uri: Uri = format!("/images?{query}").parse().unwrap();
        let Query(of) = Query::<OfImage>::try_from_uri(&uri).map_err(|e| e.to_string())?;
        Ok(arguments(&of, "2.4", false).join(" "))
    }

    #[test]
    fn a_flank_is_measured_at_the_side_of_its_edge_that_is_stated() {
        let stated = of("kind=flank&um_per_px=2.4&flank_side=above").unwrap();
        assert!(stated.starts_with("tool flank image --flank-side above --um-per-px 2.4 "), "{stated}");
        assert!(of("kind=flank&um_per_px=2.4").unwrap().contains("--flank-side any"));
        assert!(of("kind=flank&um_per_px=2.4&flank_side=up").is_err());
        // a nose has none
        assert!(!of("kind=nose&um_per_px=2.4&flank_side=above").unwrap().contains("--flank-side"));
    }
}
