//! Products: an outline with its cutting data, or a model (STL) with its card.

use axum::body::Bytes;
use axum::extract::{Path, State as Extract};
use axum::http::StatusCode;
use axum::{Extension, Json};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::access::Who;
use super::documents::{self, Document};
use super::files;
use super::off_thread::off_thread;
use super::problem::{Problem, Words};
use super::state::Shared;
use crate::outline::Outline;
use crate::stl::{ReadSettings, TOLERANCE_MM, Unit, read_part};
use crate::store::EntryKind;
use crate::tool::OutlineFile;

/// Products of a list at most.
const LISTED: usize = 1000;
/// Largest model, bytes: 300 000 facets.
pub(super) const LARGEST_MODEL: usize = 16 << 20;
/// Largest sagitta of a drawn arc, mm.
pub(super) const SAGITTA_MM: f64 = 0.005;

/// What a model does not hold.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Card {
    /// Unit of its coordinates: mm, cm, m or inch.
    pub unit: String,
    /// Diameter of the bar, mm.
    pub stock_mm: f64,
    /// Z of the part's end at the chuck, mm from the face that clamps the bar.
    pub from_z_mm: f64,
}

/// A product: `outline`, or `card` and then its model.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Product {
    /// Its name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Outline and cutting data as TOML (`schema outline`).
    #[serde(default)]
    pub outline: Option<String>,
    /// The card of a model.
    #[serde(default)]
    pub card: Option<Card>,
    /// SHA-256 of the model, once it was uploaded.
    #[serde(default)]
    #[schema(read_only)]
    pub model: Option<String>,
}

/// The outline of a product, as finished.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Contour {
    /// Places from the chuck on: Z in mm, distance from the axis in mm; arcs within 5 µm.
    pub points_mm: Vec<[f64; 2]>,
}

impl Document for Product {
    const KIND: EntryKind = EntryKind::Product;
    const WORD: &'static str = "product";

    fn name(&self) -> &str {
        &self.name
    }
}

impl Card {
    fn settings(&self) -> Result<ReadSettings, Problem> {
        let unit: Unit = self.unit.parse().map_err(|e| Problem::refused(format!("card.unit: {e}")))?;
        let is_length = |mm: f64| mm.is_finite() && mm > 0.0;
        if !is_length(self.stock_mm) || !self.from_z_mm.is_finite() || self.from_z_mm < 0.0 {
            return Err(Problem::refused("card: stock_mm above 0 and from_z_mm of 0 or more are needed"));
        }
        Ok(ReadSettings { unit, stock_mm: self.stock_mm, tolerance_mm: TOLERANCE_MM, turn_round: false })
    }
}

impl Product {
    fn check(&self) -> Result<(), Problem> {
        match (&self.outline, &self.card) {
            (Some(text), None) => outline(text).map(|_| ()),
            (None, Some(card)) => card.settings().map(|_| ()),
            _ => Err(Problem::refused("either outline (TOML) or card (of a model) is needed")),
        }
    }

    /// Its outline, from the chuck on.
    pub(super) fn contour(&self, state: &Shared) -> Result<Contour, Problem> {
        let outline = match (&self.outline, &self.card, &self.model) {
            (Some(text), _, _) => outline(text)?,
            (None, Some(card), Some(model)) => read_model(card, &files::get(state, model)?)?,
            _ => return Err(Problem::absent(format!("{}: its model was not uploaded yet", self.name))),
        };
        let points_mm = outline.pieces.iter().flat_map(|p| p.points(SAGITTA_MM)).map(|p| [p.y, p.x]);
        Ok(Contour { points_mm: points_mm.collect() })
    }
}

fn outline(text: &str) -> Result<Outline, Problem> {
    let file: OutlineFile = toml::from_str(text).map_err(|e| Problem::refused(format!("outline: {e}")))?;
    file.outline().map_err(|e| Problem::refused(format!("outline: {e}")))
}

fn read_model(card: &Card, bytes: &[u8]) -> Result<Outline, Problem> {
    let part = read_part(bytes, &card.settings()?);
    part.map(|part| part.outline).map_err(|fault| Problem::refused(format!("the model: {fault}")))
}

/// All products, by name.
#[utoipa::path(get, path = "/api/products", responses((status = 200, body = Vec<Product>), (status = 404, body = Words)))]
pub(super) async fn list(Extract(state): Extract<Shared>) -> Result<Json<Vec<Product>>, Problem> {
    off_thread(move || Ok(Json(documents::list(&state, (0, LISTED))?.1))).await
}

/// Adds a product; of a model its card, and the model by `PUT …/model`.
#[utoipa::path(post, path = "/api/products", request_body = Product, responses((status = 201), (status = 409, body = Words), (status = 422, body = Words)))]
pub(super) async fn add(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Json(product): Json<Product>,
) -> Result<StatusCode, Problem> {
    off_thread(move || {
        product.check()?;
        let product = Product { model: None, ..product };
        documents::add(&state, &who, &product).map(|()| StatusCode::CREATED)
    })
    .await
}

/// Uploads the model of a product (STL, 16 MiB at most): stored when it is a turned part of its
/// bar.
#[utoipa::path(put, path = "/api/products/{name}/model", request_body(content = Vec<u8>, content_type = "application/octet-stream"), responses((status = 204), (status = 404, body = Words), (status = 413), (status = 422, body = Words)))]
pub(super) async fn model(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
    bytes: Bytes,
) -> Result<StatusCode, Problem> {
    let place = state.workshop.place().await?;
    let stored = off_thread(move || {
        let product: Product = documents::get(&state, &name)?;
        let card = product.card.as_ref();
        let card = card.ok_or_else(|| Problem::refused(format!("{name} has an outline and no model")))?;
        read_model(card, &bytes)?;
        let model = Some(files::put(&state, &bytes)?);
        documents::update(&state, &who, &name, |product: &mut Product| product.model = model)
            .map(|()| StatusCode::NO_CONTENT)
    });
    let stored = stored.await;
    drop(place);
    stored
}

/// The outline of a product.
#[utoipa::path(get, path = "/api/products/{name}/contour", responses((status = 200, body = Contour), (status = 404, body = Words), (status = 422, body = Words)))]
pub(super) async fn contour(
    Extract(state): Extract<Shared>,
    Path(name): Path<String>,
) -> Result<Json<Contour>, Problem> {
    off_thread(move || documents::get::<Product>(&state, &name)?.contour(&state).map(Json)).await
}

/// A product.
#[utoipa::path(get, path = "/api/products/{name}", responses((status = 200, body = Product), (status = 404, body = Words)))]
pub(super) async fn show(
    Extract(state): Extract<Shared>,
    Path(name): Path<String>,
) -> Result<Json<Product>, Problem> {
    off_thread(move || documents::get(&state, &name).map(Json)).await
}

/// Takes a product out; programs that were made stay.
#[utoipa::path(delete, path = "/api/products/{name}", responses((status = 204), (status = 404, body = Words)))]
pub(super) async fn remove(
    Extract(state): Extract<Shared>,
    Extension(who): Extension<Who>,
    Path(name): Path<String>,
) -> Result<StatusCode, Problem> {
    off_thread(move || documents::remove::<Product>(&state, &who, &name).map(|()| StatusCode::NO_CONTENT))
        .await
}
