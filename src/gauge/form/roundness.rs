//! Roundness parameters after ISO 12181-1 and straightness parameters after ISO 12780-1.

use glam::DVec2;

use super::certificate::Certificate;
use super::circle::Circle;
use super::circumscribed_circle::minimum_circumscribed_circle;
use super::error::FormError;
use super::inscribed_circle::maximum_inscribed_circle;
use super::least_squares_circle::least_squares_circle;
use super::line::{Line, least_squares_line, minimum_zone_line};
use super::minimum_zone_circle::minimum_zone_circle;

/// Reference circle of a roundness.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reference {
    /// Least squares, LSCI.
    #[default]
    LeastSquares,
    /// Minimum zone, MZCI.
    MinimumZone,
    /// Maximum inscribed, MICI.
    MaximumInscribed,
    /// Minimum circumscribed, MCCI.
    MinimumCircumscribed,
}

/// Roundness of a section, in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Roundness {
    /// The reference circle.
    pub circle: Circle,
    /// Peak to valley, RONt.
    pub ron_t: f64,
    /// Peak to reference, RONp; defined for the least-squares circle only.
    pub ron_p: Option<f64>,
    /// Reference to valley, RONv; defined for the least-squares circle only.
    pub ron_v: Option<f64>,
    /// Root mean square, RONq; defined for the least-squares circle only.
    pub ron_q: Option<f64>,
    /// Proof that the reference circle is the best.
    pub certificate: Certificate,
}

/// Roundness of a section's points about a reference circle. Filter the profile first (ISO
/// 12181-2).
///
/// # Errors
/// As the reference circle's own.
pub(crate) fn roundness(points: &[DVec2], reference: Reference) -> Result<Roundness, FormError> {
    let fit = match reference {
        Reference::LeastSquares => {
            let ls = least_squares_circle(points)?;
            return Ok(Roundness {
                circle: ls.fit.circle,
                ron_t: ls.fit.peak_to_valley(),
                ron_p: Some(ls.fit.outer_radius - ls.fit.circle.radius),
                ron_v: Some(ls.fit.circle.radius - ls.fit.inner_radius),
                ron_q: Some(ls.rms),
                certificate: ls.fit.certificate,
            });
        }
        Reference::MinimumZone => minimum_zone_circle(points)?,
        Reference::MaximumInscribed => maximum_inscribed_circle(points)?,
        Reference::MinimumCircumscribed => minimum_circumscribed_circle(points)?,
    };
    let ron_t = fit.peak_to_valley();
    Ok(Roundness {
        circle: fit.circle,
        ron_t,
        ron_p: None,
        ron_v: None,
        ron_q: None,
        certificate: fit.certificate,
    })
}

/// Reference line of a straightness.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StraightnessReference {
    /// Least squares, LSLI.
    #[default]
    LeastSquares,
    /// Minimum zone, MZLI.
    MinimumZone,
}

/// Straightness of a profile, in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Straightness {
    /// The reference line.
    pub line: Line,
    /// Peak to valley, STRt.
    pub str_t: f64,
    /// Peak to reference, STRp; defined for the least-squares line only.
    pub str_p: Option<f64>,
    /// Reference to valley, STRv; defined for the least-squares line only.
    pub str_v: Option<f64>,
    /// Root mean square, STRq; defined for the least-squares line only.
    pub str_q: Option<f64>,
    /// Proof that the reference line is the best.
    pub certificate: Certificate,
}

/// Straightness of a profile (z, height), heights positive out of the material. Filter the profile
/// first (ISO 12780-2).
///
/// # Errors
/// As the reference line's own.
pub(crate) fn straightness(
    points: &[DVec2],
    reference: StraightnessReference,
) -> Result<Straightness, FormError> {
    let (fit, least_squares) = match reference {
        StraightnessReference::LeastSquares => (least_squares_line(points)?, true),
        StraightnessReference::MinimumZone => (minimum_zone_line(points)?, false),
    };
    let mean_square =
        points.iter().map(|p| fit.line.deviation(*p).powi(2)).sum::<f64>() / points.len() as f64;
    Ok(Straightness {
        line: fit.line,
        str_t: fit.peak_to_valley(),
        str_p: least_squares.then_some(fit.highest),
        str_v: least_squares.then_some(-fit.lowest),
        str_q: least_squares.then_some(mean_square.sqrt()),
        certificate: fit.certificate,
    })
}
