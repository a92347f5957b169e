//! The measurement: coarse circles, fitted edges, circles and form, millimetres.

use super::result::{Concentricity, EdgeCircle, RingMeasurement};
use glam::DVec2;
use std::f64::consts::TAU;

use super::super::form::{
    Circle, FormError, least_squares_circle, maximum_inscribed_circle, minimum_circumscribed_circle,
};
use super::coarse::{self, Coarse};
use super::edge_fit::{Caliper, EdgeFit};
use super::edge_pixels::{BandLimits, BandOrder, EdgePixel, collect};
use super::error::RingError;
use super::fit::fit_edge;
use super::outline::{Outline, least_ratio_to_stylus};
use super::settings::RingSettings;
use crate::frame::{FrameView, PixelFormat};
use crate::gauge::edge::estimation::light_field::{LightField, Lit};
use crate::gauge::limit::limits;
use crate::numerics::robust::median_of;

limits! {
    /// How uneven light around a ring is corrected.
    RingLightLimits = "ring_light";
    /// Pixels beyond the band that the light's field is estimated from. Tuned: see study limits.
    field_px: f64 = 16.0;
    /// Share of the light's effect on the edge that stays uncertain: the field is a polynomial over
    /// the surroundings, extrapolated across the edge. Tuned: see study limits.
    left: f64 = 0.1;
}

/// Measures the largest ring or disc that lies wholly in the frame.
///
/// # Errors
/// Settings out of range, no contrast, no round part, an edge that cannot be fitted.
pub(crate) fn measure_ring(
    view: &FrameView<'_>,
    settings: &RingSettings,
) -> Result<RingMeasurement, RingError> {
    settings.validate()?;
    let Coarse { outer, inner } = coarse::find(view, settings)?;
    let wall = inner.map_or(outer.radius, |bore| outer.radius - bore.radius);
    let half = settings.half_band_px.min(0.45 * wall);
    let side = |light_outside| Side { view, settings, light_outside, half };
    let mut seen = side(true).light(&outer).unwrap_or_default();
    if let Some(mut inside) = inner.as_ref().and_then(|bore| side(false).light(bore)) {
        // The same light falls on both sides of the wall.
        seen.lit.append(&mut inside.lit);
    }
    let field = LightField::fit(&seen.lit).map(|field| (field, seen.dark));
    let measured = |circle, light_outside| side(light_outside).measure(circle, field.as_ref());
    let outer = measured(outer, true)?;
    let inner = inner.map(|bore| measured(bore, false)).transpose()?;
    let concentricity = inner.as_ref().map(|inner| {
        let distance = DVec2::from(outer.centre_px).distance(DVec2::from(inner.centre_px));
        let px = 2.0 * distance;
        let mm = settings.scale.map(|s| 1e-3 * s.um_per_px * px);
        Concentricity { px, u_px: 2.0 * outer.u_centre_px.hypot(inner.u_centre_px), mm }
    });
    Ok(RingMeasurement { outer, inner, concentricity })
}

/// Pixels of light, and the level of the shadow, counts.
#[derive(Default)]
struct SeenLight {
    lit: Vec<Lit>,
    dark: f64,
}

/// One edge to be measured.
struct Side<'a> {
    view: &'a FrameView<'a>,
    settings: &'a RingSettings,
    light_outside: bool,
    half: f64,
}

impl Side<'_> {
    fn error(&self, why: impl Into<String>) -> RingError {
        RingError::Edge { edge: if self.light_outside { "outer" } else { "inner" }, why: why.into() }
    }

    fn measure(&self, coarse: Circle, field: Option<&(LightField, f64)>) -> Result<EdgeCircle, RingError> {
        let limits = RingLightLimits::get();
        let mut calipers = self.settings.calipers;
        while calipers > 64 && coarse.radius * TAU / (calipers as f64) < 2.0 {
            calipers /= 2;
        }
        let least_variance = if self.view.format() == PixelFormat::F32 { 1e-6 } else { 1.0 / 12.0 };
        let (mut circle, mut last, mut ends) = (coarse, None, None);
        let mut raw = None;
        for _ in 0..3 {
            let order = BandOrder {
                circle,
                light_outside: self.light_outside,
                half: self.half,
                sectors: calipers,
                bright_on_dark: self.settings.bright_on_dark,
            };
            let mut band = collect(self.view, &order);
            if let (Some((field, dark)), None) = (field, &ends) {
                raw = Some(band.clone());
                band.level(field, *dark);
            }
            let fitted = |ends| fit_edge(&band, least_variance, self.settings.outlier_sigmas, ends);
            let mut fit = fitted(ends);
            if last.is_none() {
                let flank = fit.as_ref().map_or(f64::INFINITY, |fit| fit.noise);
                ends = band.ends(flank, self.view.format() != PixelFormat::F32);
                if ends.is_some() {
                    band = collect(self.view, &order);
                    raw = None;
                    fit = fit_edge(&band, least_variance, self.settings.outlier_sigmas, ends);
                }
            }
            let fit = fit.map_err(|why| self.error(why))?;
            let points = self.points(&circle, &fit, true);
            if (points.len() as f64) < self.settings.min_fill * calipers as f64 {
                let why = format!("only {} of {calipers} calipers are good", points.len());
                return Err(self.error(why));
            }
            let ls = least_squares_circle(&points).map_err(|e| self.error(e.to_string()))?;
            last = Some((circle, fit, points, ls.clone()));
            let moved =
                ls.fit.circle.centre.distance(circle.centre) + (ls.fit.circle.radius - circle.radius).abs();
            circle = ls.fit.circle;
            // A centre off by e tilts the edge within a caliper by e/R: nothing at this size.
            if moved < 0.05 {
                break;
            }
        }
        let (followed, fit, points, ls) = last.ok_or_else(|| self.error("not measured"))?;
        let mut fit = fit;
        if let Some(Ok(plain)) = raw.map(|b| fit_edge(&b, least_variance, self.settings.outlier_sigmas, None))
        {
            fit.u_mean = fit.u_mean.hypot(limits.left * (fit.mean_shift() - plain.mean_shift()));
        }
        self.assemble(&followed, &fit, &points, ls.fit.circle)
    }

    /// The light beyond the band of the edge.
    fn light(&self, circle: &Circle) -> Option<SeenLight> {
        let band_limits = BandLimits::get();
        let order = BandOrder {
            circle: *circle,
            light_outside: self.light_outside,
            half: self.half + RingLightLimits::get().field_px,
            sectors: 1,
            bright_on_dark: self.settings.bright_on_dark,
        };
        let mut band = collect(self.view, &order);
        let pixels = band.sectors.pop()?;
        let in_shadow = |p: &&EdgePixel| (-self.half..-band_limits.flat * self.half).contains(&p.distance);
        let dark = median_of(pixels.iter().filter(in_shadow).map(|p| p.value).collect());
        let lit = pixels.iter().filter(|p| p.distance > self.half);
        let lit = lit
            .map(|p| {
                let at = band.place(p);
                Lit { x: at.x, y: at.y, contrast: p.value - dark }
            })
            .collect();
        Some(SeenLight { lit, dark })
    }

    /// Edge points of the calipers, px.
    fn points(&self, circle: &Circle, fit: &EdgeFit, only_good: bool) -> Vec<DVec2> {
        let outward = if self.light_outside { 1.0 } else { -1.0 };
        let n = fit.calipers.len() as f64;
        fit.calipers
            .iter()
            .enumerate()
            .filter(|(_, c)| c.good || !only_good)
            .map(|(k, c)| {
                let direction = DVec2::from_angle(TAU * (k as f64 + 0.5) / n);
                circle.centre + direction * (circle.radius + outward * c.shift)
            })
            .collect()
    }

    fn assemble(
        &self,
        followed: &Circle,
        fit: &EdgeFit,
        points: &[DVec2],
        circle: Circle,
    ) -> Result<EdgeCircle, RingError> {
        // The blurred edge of a disc stands nearer to its centre, whether the disc is the shadow or
        // the bore's light.
        let curvature = (fit.sigma * fit.sigma + 1.0 / 12.0) / (2.0 * circle.radius);
        let form = |e: FormError| self.error(e.to_string());
        let around = minimum_circumscribed_circle(points).map_err(form)?.circle.diameter();
        let within = maximum_inscribed_circle(points).map_err(form)?.circle.diameter();
        let good: Vec<&Caliper> = fit.calipers.iter().filter(|c| c.good).collect();
        let mean_square = good.iter().map(|c| c.u_shift * c.u_shift).sum::<f64>() / good.len() as f64;
        let diameter_px = 2.0 * (circle.radius + curvature);
        let u_diameter_px = 2.0 * fit.u_mean.hypot(self.u_form_sampling(points, &circle, fit.calipers.len()));
        let outline = Outline::new(self.light_outside, followed, fit, curvature);
        let roundness_px = outline.roundness_px(self.settings.roundness_cutoff_upr).map_err(form)?;
        let stylus_radius_px = self
            .settings
            .stylus_radius_px
            .unwrap_or_else(|| circle.diameter() / least_ratio_to_stylus(self.settings.roundness_cutoff_upr));
        let stylus_diameter_px = outline.felt_diameter_px(stylus_radius_px).map_err(form)?;
        Ok(EdgeCircle {
            centre_px: circle.centre.to_array(),
            diameter_px,
            u_diameter_px,
            u_centre_px: (2.0 * mean_square / good.len() as f64).sqrt(),
            roundness_px,
            circumscribed_px: around + 2.0 * curvature,
            inscribed_px: within + 2.0 * curvature,
            stylus_diameter_px,
            stylus_radius_px,
            sigma_px: fit.sigma,
            levels: [fit.levels.0, fit.levels.1],
            reduced_chi2: median_of(good.iter().map(|c| c.reduced_chi2).collect()),
            calipers: fit.calipers.len(),
            refused: fit.calipers.len() - good.len(),
            outline,
            mm: self.settings.scale.map(|s| {
                s.millimetres(
                    self.light_outside,
                    [diameter_px, stylus_diameter_px],
                    u_diameter_px,
                    roundness_px,
                )
            }),
        })
    }

    /// Standard uncertainty of the mean radius by what the refused calipers would have shown, px:
    /// the good ones are a sample of n_good out of n of a form of standard deviation s that
    /// neighbours share over half a wave at the roundness' cutoff, u² = s²·(n/2k_c)/n_good·(1 −
    /// n_good/n).
    fn u_form_sampling(&self, points: &[DVec2], circle: &Circle, calipers: usize) -> f64 {
        let (good, all) = (points.len() as f64, calipers as f64);
        let variance = points.iter().map(|p| circle.deviation(*p).powi(2)).sum::<f64>() / good;
        let alike = (all / (2.0 * self.settings.roundness_cutoff_upr)).max(1.0);
        (variance * alike / good * (1.0 - good / all)).max(0.0).sqrt()
    }
}

impl RingMeasurement {
    /// Flat keys for machine reading: `outer_diameter_px`, `u_outer_diameter_mm`,
    /// `roundness_inner_px`, `concentricity_px`, …; quantities not measured are absent.
    pub fn to_json(&self) -> serde_json::Value {
        let mut map = serde_json::Map::new();
        let mut put = |key: String, value: f64| map.insert(key, value.into());
        for (name, edge) in [("outer", Some(&self.outer)), ("inner", self.inner.as_ref())] {
            let Some(edge) = edge else { continue };
            put(format!("{name}_diameter_px"), edge.diameter_px);
            put(format!("u_{name}_diameter_px"), edge.u_diameter_px);
            put(format!("roundness_{name}_px"), edge.roundness_px);
            put(format!("{name}_centre_column_px"), edge.centre_px[0]);
            put(format!("{name}_centre_row_px"), edge.centre_px[1]);
            put(format!("{name}_stylus_diameter_px"), edge.stylus_diameter_px);
            put(format!("{name}_calipers_refused"), edge.refused as f64);
            if let Some(mm) = edge.mm {
                put(format!("{name}_diameter_mm"), mm.diameter_mm);
                put(format!("u_{name}_diameter_mm"), mm.u_diameter_mm);
                put(format!("{name}_stylus_diameter_mm"), mm.stylus_diameter_mm);
                put(format!("roundness_{name}_mm"), mm.roundness_mm);
            }
        }
        if let Some(c) = self.concentricity {
            put("concentricity_px".to_owned(), c.px);
            put("u_concentricity_px".to_owned(), c.u_px);
            if let Some(mm) = c.mm {
                put("concentricity_mm".to_owned(), mm);
            }
        }
        map.into()
    }
}
