//! The file of a measured nose: images with, among other figures, the support of the nose's hull.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use serde::Deserialize;

use super::error::ToolError;
use super::settings::ImageAxes;
use crate::nose::{NoseProfile, Support, ToolGeometry};

/// The document; keys that are not read here are left alone.
#[derive(Debug, Deserialize)]
struct Document {
    images: Vec<Image>,
}

#[derive(Debug, Deserialize)]
struct Image {
    image: String,
    #[serde(default)]
    mean_radius_mm: Option<f64>,
    #[serde(default)]
    support: Vec<Row>,
    #[serde(default)]
    support_covariance_um2: Option<Vec<Vec<f64>>>,
    #[serde(default)]
    u_common_um: f64,
    #[serde(default)]
    flags: Vec<String>,
}

/// Reach of the nose in a direction of the image.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Row {
    direction_deg: f64,
    h_um: f64,
    u_um: f64,
}

/// A nose as measured, in the machine's axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredNose {
    /// Name of its image.
    pub image: String,
    /// Its profile.
    pub profile: NoseProfile,
    /// Mean radius of its sectors, mm, where the file has one.
    pub mean_radius_mm: Option<f64>,
    /// What the measurement flagged.
    pub flags: Vec<String>,
}

/// Reads the nose of an image, or of the only one that has its support.
///
/// # Errors
/// Text that is no such document, no image or several of that name, support values that are no
/// nose.
pub(crate) fn read_nose(
    text: &str,
    wanted: Option<&str>,
    axes: ImageAxes,
    geometry: &ToolGeometry,
) -> Result<MeasuredNose, ToolError> {
    let document: Document = serde_json::from_str(text).map_err(|e| {
        ToolError::Nose(format!("is no document whose `images` have their `support` (docs/tool.md): {e}"))
    })?;
    let names: Vec<&str> = document.images.iter().map(|i| i.image.as_str()).collect();
    let fits = |i: &&Image| wanted.map_or(!i.support.is_empty(), |name| i.image == name);
    let found: Vec<&Image> = document.images.iter().filter(fits).collect();
    let image = match found[..] {
        [image] => image,
        _ => {
            let which = wanted.map_or("with their `support`".to_owned(), |name| format!("named {name:?}"));
            return Err(ToolError::Nose(format!(
                "{} images are {which}, one is needed (--image NAME); the file has {}",
                found.len(),
                if names.is_empty() { "none".to_owned() } else { names.join(", ") }
            )));
        }
    };
    Ok(MeasuredNose {
        image: image.image.clone(),
        profile: profile(image, axes, geometry)?,
        mean_radius_mm: image.mean_radius_mm,
        flags: image.flags.clone(),
    })
}

fn profile(image: &Image, axes: ImageAxes, geometry: &ToolGeometry) -> Result<NoseProfile, ToolError> {
    let n = image.support.len();
    let (low, high) = geometry.range_rad();
    let mut order: Vec<(f64, usize)> = image
        .support
        .iter()
        .map(|row| normal_of(row.direction_deg, axes, 0.5 * (low + high)))
        .zip(0..)
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let supports: Vec<Support> = order
        .iter()
        .map(|&(a_rad, i)| {
            let row = image.support[i];
            Support { a_rad, h_mm: 1e-3 * row.h_um, u_mm: 1e-3 * row.u_um }
        })
        .collect();
    let covariance = image.support_covariance_um2.as_ref().map(|rows| {
        let square = rows.len() == n && rows.iter().all(|row| row.len() == n);
        let at = |i: usize, j: usize| 1e-6 * rows[order[i].1][order[j].1];
        // a matrix of another size is refused with the profile
        if square { DMatrix::from_fn(n, n, at) } else { DMatrix::zeros(0, 0) }
    });
    NoseProfile::new(&supports, covariance, 1e-3 * image.u_common_um)
        .map_err(|cause| ToolError::Profile { image: image.image.clone(), cause })
}

/// Angle of the normal of a surface that the nose touches where it points in a direction of the
/// image, rad, within half a turn of `middle`.
fn normal_of(direction_deg: f64, axes: ImageAxes, middle: f64) -> f64 {
    let share = |axis_deg: f64| (direction_deg - axis_deg).to_radians().cos();
    let a = (-share(axes.plus_z_deg)).atan2(-share(axes.plus_x_deg));
    a - TAU * ((a - middle) / TAU).round()
}
