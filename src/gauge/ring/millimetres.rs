//! Rings in millimetres: by a bare scale, or by a calibration with its lens, conditions and every
//! source's share.
//!
//! ```text
//! D = s·(1 + t·y)·d' ± o
//! d'  diameter of the least-squares circle through the outline as a perfect lens shows it
//! ```
//!
//! with + for an outline, − for a bore, o the offset of both edges together. u_common follows by
//! the derivatives of D by the calibration's six parameters, those by the lens numerically.

use super::result::{Concentricity, EdgeCircle, EdgeMillimetres, RingMeasurement};
use glam::DVec2;

use super::super::form::{FormError, least_squares_circle};
use super::error::RingError;
use super::outline::{Outline, PointOrigin, roundness_of};
use super::settings::RingScale;
use crate::gauge::calibration::gauge_calibration::Calibration;
use crate::gauge::calibration::{Conditions, LensModel, PARAMETERS};
use crate::gauge::limit::limits;
use crate::gauge::uncertainty::budget::{Budget, Texts, add_conditions, common};
use crate::setting::SettingError;

limits! {
    /// How a ring's diameter is derived by the lens.
    RingMillimetreLimits = "ring_millimetres";
    /// Step of the numerical derivative by a coefficient of the lens: its square, 1e-10, is what is
    /// left out, and rounding of 1e-16 over it 1e-11.
    step: f64 = 1e-5;
}

impl RingScale {
    /// Diameters (of the edge, and as traced by the stylus), u and roundness in mm.
    pub(super) fn millimetres(
        &self,
        outer: bool,
        diameters_px: [f64; 2],
        u_px: f64,
        roundness_px: f64,
    ) -> EdgeMillimetres {
        let mm = 1e-3 * self.um_per_px;
        let side = if outer { 2.0 } else { -2.0 };
        let [corrected, felt] = diameters_px.map(|d| d + side * self.edge_offset_px);
        let u_common_mm = (corrected * 1e-3 * self.u_um_per_px).hypot(2.0 * mm * self.u_edge_offset_px);
        EdgeMillimetres {
            diameter_mm: mm * corrected,
            u_diameter_mm: u_common_mm.hypot(mm * u_px),
            u_common_mm,
            stylus_diameter_mm: mm * felt,
            roundness_mm: mm * roundness_px,
        }
    }
}

/// A calibration and the conditions it is used under.
struct Mapping<'a> {
    calibration: &'a Calibration,
    conditions: &'a Conditions,
    cutoff_upr: f64,
}

impl RingMeasurement {
    /// Gives every length in mm at 20 °C by a calibration: scale, edge offset, distortion,
    /// keystone, telecentricity.
    ///
    /// # Errors
    /// Where the corrected outline gives no circle.
    pub(crate) fn calibrate(
        &mut self,
        calibration: &Calibration,
        conditions: &Conditions,
        cutoff_upr: f64,
    ) -> Result<(), RingError> {
        if conditions.limb.is_some() {
            let right =
                "is the limb of a shaft seen from the side; an edge of a ring or disc is thin: leave it out";
            return Err(SettingError::at("conditions.limb", right).into());
        }
        let mapping = Mapping { calibration, conditions, cutoff_upr };
        let centre = |edge: &mut EdgeCircle, name| {
            let (mm, centre) =
                mapping.edge(edge).map_err(|e| RingError::Edge { edge: name, why: e.to_string() })?;
            edge.mm = Some(mm);
            Ok::<DVec2, RingError>(centre)
        };
        let outer = centre(&mut self.outer, "outer")?;
        let Some(inner) = &mut self.inner else { return Ok(()) };
        let apart = centre(inner, "inner")?.distance(outer);
        let scale = mapping.mm_per_px() * conditions.to_reference();
        self.concentricity = self.concentricity.map(|c| Concentricity { mm: Some(2.0 * scale * apart), ..c });
        Ok(())
    }
}

impl Mapping<'_> {
    fn lens(&self) -> Option<&LensModel> {
        self.calibration.setup.as_ref().map(|b| &b.lens)
    }

    fn mm_per_px(&self) -> f64 {
        let t = self.lens().map_or(0.0, |l| l.telecentricity_per_mm);
        self.calibration.scale_mm_per_px * (1.0 + t * self.conditions.axis_y_mm)
    }

    /// The edge in mm, and its centre as a perfect lens shows it, px.
    fn edge(&self, edge: &EdgeCircle) -> Result<(EdgeMillimetres, DVec2), FormError> {
        let outline = &edge.outline;
        let side = if outline.outer { 1.0 } else { -1.0 };
        let seen = ideal_circle(outline, None)?;
        let ideal = ideal_circle(outline, self.lens())?;
        // The lens adds the same amount to each of the diameters.
        let [d, felt] = [edge.diameter_px, edge.stylus_diameter_px].map(|d| d + 2.0 * (ideal.1 - seen.1));
        let mm = self.mm_per_px();
        let at_t = |d: f64| mm * d + side * self.calibration.offset_mm;
        let to_20 = self.conditions.to_reference();
        let u_common_mm = self.u_common_mm(outline, d, at_t(d))?;
        let roundness_px = roundness_of(&ideal_radii(outline, self.lens(), ideal.0), self.cutoff_upr)?;
        let figures = EdgeMillimetres {
            diameter_mm: at_t(d) * to_20,
            u_diameter_mm: u_common_mm.hypot(mm * edge.u_diameter_px),
            u_common_mm,
            stylus_diameter_mm: at_t(felt) * to_20,
            roundness_mm: mm * roundness_px,
        };
        Ok((figures, ideal.0))
    }

    /// Standard uncertainty shared by all parts, mm, of an ideal diameter d, px, and the diameter
    /// at its temperature, mm.
    fn u_common_mm(&self, outline: &Outline, d: f64, at_t: f64) -> Result<f64, FormError> {
        let side = if outline.outer { 1.0 } else { -1.0 };
        let mut budget = Budget { diameter_mm: at_t, contributions: Vec::new() };
        add_conditions(&mut budget, self.calibration, self.conditions, at_t, Texts::LeftOut);
        let Some(setup) = &self.calibration.setup else {
            let [vs, c, vo] = self.calibration.covariance;
            let variance = (d * d * vs + 2.0 * side * d * c + vo).max(0.0);
            return Ok(budget.u_common_mm().hypot(variance.sqrt()));
        };
        let by = self.by_parameters(&setup.lens, outline, d, side)?;
        setup.parts.iter().for_each(|part| budget.push(common(part, &by, Texts::LeftOut)));
        Ok(budget.u_common_mm())
    }

    /// Derivatives of D by s, o, a, q, g, t.
    fn by_parameters(
        &self,
        lens: &LensModel,
        outline: &Outline,
        d: f64,
        side: f64,
    ) -> Result<[f64; PARAMETERS], FormError> {
        let limits = RingMillimetreLimits::get();
        let y = self.conditions.axis_y_mm;
        let moved = [
            LensModel { radial: lens.radial + limits.step, ..*lens },
            LensModel { keystone_across: lens.keystone_across + limits.step, ..*lens },
            LensModel { keystone_along: lens.keystone_along + limits.step, ..*lens },
        ];
        let here = ideal_circle(outline, Some(lens))?.1;
        let mut by = [(1.0 + lens.telecentricity_per_mm * y) * d, side, 0.0, 0.0, 0.0, 0.0];
        for (by, moved) in by[2..5].iter_mut().zip(&moved) {
            *by = self.mm_per_px() * 2.0 * (ideal_circle(outline, Some(moved))?.1 - here) / limits.step;
        }
        by[5] = self.calibration.scale_mm_per_px * y * d;
        Ok(by)
    }
}

fn ideal_point(lens: Option<&LensModel>, point_px: [f64; 2]) -> DVec2 {
    lens.map_or(point_px, |l| l.ideal_point(point_px)).into()
}

/// Centre and radius of the least-squares circle of the trusted points as a perfect lens would show
/// them, px.
fn ideal_circle(outline: &Outline, lens: Option<&LensModel>) -> Result<(DVec2, f64), FormError> {
    let points: Vec<DVec2> = (0..outline.points.len())
        .filter(|k| outline.points[*k].origin == PointOrigin::Fitted)
        .map(|k| ideal_point(lens, outline.point_px(k)))
        .collect();
    let circle = least_squares_circle(&points)?.fit.circle;
    Ok((circle.centre, circle.radius))
}

/// Radii of the trusted outline about a centre as a perfect lens would show them, px.
fn ideal_radii(outline: &Outline, lens: Option<&LensModel>, centre: DVec2) -> Vec<f64> {
    let mut trusted = outline.clone();
    trusted.points.iter_mut().zip(outline.trusted_radii()).for_each(|(p, r)| p.radius_px = r);
    (0..trusted.points.len()).map(|k| ideal_point(lens, trusted.point_px(k)).distance(centre)).collect()
}
