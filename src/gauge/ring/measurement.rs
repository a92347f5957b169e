//! The measurement: coarse circles, fitted edges, circles and form, millimetres.

use glam::DVec2;
use std::f64::consts::TAU;

use super::super::form::{
    Circle, Cutoff, FormError, Reference, gaussian_closed, least_squares_circle, maximum_inscribed_circle,
    minimum_circumscribed_circle, roundness,
};
use super::coarse::{self, Coarse};
use super::edge_pixels::{BandOrder, collect};
use super::fit::{EdgeFit, fit_edge};
use super::{RingError, RingScale, RingSettings};
use crate::frame::{FrameView, PixelFormat};

/// One edge of a ring, in pixels unless named otherwise.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EdgeCircle {
    /// Centre: x the column, y the row, px.
    pub centre_px: [f64; 2],
    /// Least-squares diameter of the 50 % edge, curvature bias corrected, px.
    pub diameter_px: f64,
    /// Its standard uncertainty from noise, levels, blur and the form that refused calipers hide, px.
    pub u_diameter_px: f64,
    /// Standard uncertainty of either coordinate of the centre, px.
    pub u_centre_px: f64,
    /// Roundness RONt about the least-squares circle after the Gaussian filter, px.
    pub roundness_px: f64,
    /// Diameter of the minimum circumscribed circle of the good calipers, px.
    pub circumscribed_px: f64,
    /// Diameter of the maximum inscribed circle of the good calipers, px.
    pub inscribed_px: f64,
    /// Least-squares diameter that a stylus of the given radius would feel, burrs included, px.
    pub stylus_diameter_px: Option<f64>,
    /// Blur of the edge, px.
    pub sigma_px: f64,
    /// Shadow and light, counts; the light's level is extrapolated where it is clipped.
    pub levels: [f64; 2],
    /// Median χ² per degree of freedom of the good calipers.
    pub reduced_chi2: f64,
    /// Calipers.
    pub calipers: usize,
    /// Calipers that dirt, burrs or a poor fit made useless; they are not in the circle.
    pub refused: usize,
    /// The same in millimetres, where a scale was given.
    pub mm: Option<EdgeMillimetres>,
}

/// An edge in millimetres, edge offset applied.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct EdgeMillimetres {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Its standard uncertainty: random part, scale and edge offset together, mm.
    pub u_diameter_mm: f64,
    /// The part of it that all parts measured at this scale share, mm.
    pub u_common_mm: f64,
    /// Roundness, mm.
    pub roundness_mm: f64,
}

/// Coaxiality of bore and outline.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Concentricity {
    /// Diameter of the zone around the outline's centre that holds the bore's centre (ISO 1101): twice their distance, px.
    pub px: f64,
    /// Its standard uncertainty, px.
    pub u_px: f64,
    /// The same in mm, where a scale was given.
    pub mm: Option<f64>,
}

/// A ring or disc seen end-on.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RingMeasurement {
    /// Outline.
    pub outer: EdgeCircle,
    /// Bore; `None` for a disc.
    pub inner: Option<EdgeCircle>,
    /// Of bore and outline; `None` for a disc.
    pub concentricity: Option<Concentricity>,
}

/// Measures the largest ring or disc that lies wholly in the frame.
///
/// # Errors
/// Settings out of range, no contrast, no round part, an edge that cannot be fitted.
pub fn measure_ring(view: &FrameView<'_>, settings: &RingSettings) -> Result<RingMeasurement, RingError> {
    settings.validate()?;
    let Coarse { outer, inner } = coarse::find(view, settings)?;
    let wall = inner.map_or(outer.radius, |bore| outer.radius - bore.radius);
    let half = settings.half_band_px.min(0.45 * wall);
    let measured = |circle, light_outside| Side { view, settings, light_outside, half }.measure(circle);
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

    fn measure(&self, coarse: Circle) -> Result<EdgeCircle, RingError> {
        let mut calipers = self.settings.calipers;
        while calipers > 64 && coarse.radius * TAU / (calipers as f64) < 2.0 {
            calipers /= 2;
        }
        let least_variance = if self.view.format() == PixelFormat::F32 { 1e-6 } else { 1.0 / 12.0 };
        let (mut circle, mut last) = (coarse, None);
        for _ in 0..3 {
            let order = BandOrder {
                circle,
                light_outside: self.light_outside,
                half: self.half,
                sectors: calipers,
                bright_on_dark: self.settings.bright_on_dark,
            };
            let fit = fit_edge(&collect(self.view, &order), least_variance, self.settings.outlier_sigmas)
                .map_err(|why| self.error(why))?;
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
        self.assemble(&followed, &fit, &points, ls.fit.circle)
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
        // The blurred edge of a disc stands nearer to its centre, whether the disc is the shadow or the bore's light.
        let curvature = (fit.sigma * fit.sigma + 1.0 / 12.0) / (2.0 * circle.radius);
        let form = |r: Result<_, FormError>| r.map_err(|e| self.error(e.to_string()));
        let around = form(minimum_circumscribed_circle(points))?.circle.diameter();
        let within = form(maximum_inscribed_circle(points))?.circle.diameter();
        let good: Vec<&super::fit::Caliper> = fit.calipers.iter().filter(|c| c.good).collect();
        let mean_square = good.iter().map(|c| c.u_shift * c.u_shift).sum::<f64>() / good.len() as f64;
        let diameter_px = 2.0 * (circle.radius + curvature);
        let u_diameter_px = 2.0 * fit.u_mean.hypot(self.u_form_sampling(points, &circle, fit.calipers.len()));
        let roundness_px = self.roundness(followed, fit)?;
        Ok(EdgeCircle {
            centre_px: circle.centre.to_array(),
            diameter_px,
            u_diameter_px,
            u_centre_px: (2.0 * mean_square / good.len() as f64).sqrt(),
            roundness_px,
            circumscribed_px: around + 2.0 * curvature,
            inscribed_px: within + 2.0 * curvature,
            stylus_diameter_px: self.stylus_diameter(followed, fit)?.map(|d| d + 2.0 * curvature),
            sigma_px: fit.sigma,
            levels: [fit.levels.0, fit.levels.1],
            reduced_chi2: coarse::median(good.iter().map(|c| c.reduced_chi2).collect()),
            calipers: fit.calipers.len(),
            refused: fit.calipers.len() - good.len(),
            mm: self.settings.scale.map(|s| self.millimetres(&s, diameter_px, u_diameter_px, roundness_px)),
        })
    }

    /// Standard uncertainty of the mean radius by what the refused calipers would have shown, px: the good ones are a sample
    /// of n_good out of n of a form of standard deviation s that neighbours share over half a wave at the roundness' cutoff,
    /// u² = s²·(n/2k_c)/n_good·(1 − n_good/n).
    fn u_form_sampling(&self, points: &[DVec2], circle: &Circle, calipers: usize) -> f64 {
        let (good, all) = (points.len() as f64, calipers as f64);
        let variance = points.iter().map(|p| circle.deviation(*p).powi(2)).sum::<f64>() / good;
        let alike = (all / (2.0 * self.settings.roundness_cutoff_upr)).max(1.0);
        (variance * alike / good * (1.0 - good / all)).max(0.0).sqrt()
    }

    fn millimetres(
        &self,
        scale: &RingScale,
        diameter_px: f64,
        u_px: f64,
        roundness_px: f64,
    ) -> EdgeMillimetres {
        let mm = 1e-3 * scale.um_per_px;
        let side = if self.light_outside { 2.0 } else { -2.0 };
        let corrected = diameter_px + side * scale.edge_offset_px;
        let u_common_mm = (corrected * 1e-3 * scale.u_um_per_px).hypot(2.0 * mm * scale.u_edge_offset_px);
        EdgeMillimetres {
            diameter_mm: mm * corrected,
            u_diameter_mm: u_common_mm.hypot(mm * u_px),
            u_common_mm,
            roundness_mm: mm * roundness_px,
        }
    }

    /// RONt of the filtered profile of the good calipers.
    fn roundness(&self, followed: &Circle, fit: &EdgeFit) -> Result<f64, RingError> {
        let form = |e: FormError| self.error(e.to_string());
        let shifts = bridged(&fit.calipers.iter().map(|c| c.good.then_some(c.shift)).collect::<Vec<_>>());
        let outward = if self.light_outside { 1.0 } else { -1.0 };
        let profile: Vec<f64> = shifts.iter().map(|s| followed.radius + outward * s).collect();
        let cutoff = Cutoff::upr(self.settings.roundness_cutoff_upr).map_err(form)?;
        Ok(roundness(&closed(&gaussian_closed(&profile, cutoff)), Reference::LeastSquares)
            .map_err(form)?
            .ron_t)
    }

    /// Diameter of the profile as a ball feels it.
    fn stylus_diameter(&self, followed: &Circle, fit: &EdgeFit) -> Result<Option<f64>, RingError> {
        let Some(tip) = self.settings.stylus_radius_px else { return Ok(None) };
        let outward = if self.light_outside { 1.0 } else { -1.0 };
        // A ball against a convex outline parts from it as 1/tip + 1/R, in a bore as 1/tip − 1/R.
        let curvature = 1.0 / tip + outward / followed.radius;
        if curvature <= 0.0 {
            return Err(self.error(format!("a stylus of radius {tip} px does not fit the bore")));
        }
        let shifts = bridged(&fit.calipers.iter().map(|c| c.fitted.then_some(c.shift)).collect::<Vec<_>>());
        let arc = TAU * followed.radius / shifts.len() as f64;
        let felt: Vec<f64> = mechanical_closing(&shifts, arc, curvature)
            .iter()
            .map(|s| followed.radius + outward * s)
            .collect();
        let ls = least_squares_circle(&closed(&felt)).map_err(|e| self.error(e.to_string()))?;
        Ok(Some(ls.fit.circle.diameter()))
    }
}

/// Points of a closed profile of radii.
fn closed(radii: &[f64]) -> Vec<DVec2> {
    let n = radii.len() as f64;
    radii.iter().enumerate().map(|(k, r)| DVec2::from_angle(TAU * (k as f64 + 0.5) / n) * *r).collect()
}

/// Straight lines over the gaps of a closed profile.
fn bridged(shifts: &[Option<f64>]) -> Vec<f64> {
    let n = shifts.len();
    let nearest = |k: usize, step: usize| {
        (0..n).map(|j| (j, (k + j * step) % n)).find_map(|(j, at)| shifts[at].map(|s| (j as f64, s)))
    };
    (0..n)
        .map(|k| {
            let (ahead, after) = nearest(k, 1).unwrap_or_default();
            let (behind, before) = nearest(k, n - 1).unwrap_or_default();
            if ahead + behind > 0.0 { (before * ahead + after * behind) / (ahead + behind) } else { after }
        })
        .collect()
}

/// Morphological closing of a closed profile by a ball (ISO 16610-41), heights positive out of the material: the ball's
/// centre rides on the highest contact, then its lower side is what is felt. A parabola of the given curvature stands for
/// the ball, right to (contact distance/radius)² of the height.
fn mechanical_closing(heights: &[f64], arc: f64, curvature: f64) -> Vec<f64> {
    let n = heights.len();
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let reach = (((2.0 * (high - low) / curvature).sqrt() / arc).ceil() as usize).min(n / 2 - 1);
    let ball: Vec<f64> = (0..=reach).map(|j| 0.5 * curvature * (j as f64 * arc).powi(2)).collect();
    let pass = |from: &[f64], sign: f64| -> Vec<f64> {
        (0..n)
            .map(|k| {
                (0..=reach).fold(f64::NEG_INFINITY, |best, j| {
                    let (a, b) = (sign * from[(k + j) % n], sign * from[(k + n - j) % n]);
                    best.max(a.max(b) - ball[j])
                }) * sign
            })
            .collect()
    };
    pass(&pass(heights, 1.0), -1.0)
}

impl RingMeasurement {
    /// Flat keys for machines: `outer_diameter_px`, `u_outer_diameter_mm`, `roundness_inner_px`, `concentricity_px`, …; what
    /// was not measured is absent.
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
            if let Some(felt) = edge.stylus_diameter_px {
                put(format!("{name}_stylus_diameter_px"), felt);
            }
            put(format!("{name}_calipers_refused"), edge.refused as f64);
            if let Some(mm) = edge.mm {
                put(format!("{name}_diameter_mm"), mm.diameter_mm);
                put(format!("u_{name}_diameter_mm"), mm.u_diameter_mm);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_rides_on_peaks_and_leaves_what_a_ball_can_follow() {
        let (n, arc, radius) = (1000, 1.0, 50.0);
        let smooth: Vec<f64> = (0..n).map(|k| (TAU * k as f64 / n as f64 * 3.0).cos()).collect();
        for (a, b) in smooth.iter().zip(mechanical_closing(&smooth, arc, 1.0 / radius)) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        let mut spike = vec![0.0; n];
        spike[500] = 0.5;
        let felt = mechanical_closing(&spike, arc, 1.0 / radius);
        assert_eq!((felt[500], felt[600]), (0.5, 0.0));
        // Beside a spike of height p the ball hangs on it: felt is at most p − s²/2r, and nowhere below the profile.
        assert!(felt[503] > 0.0 && felt.iter().zip(&spike).all(|(f, s)| f >= s));
        let mut groove = vec![0.0; n];
        groove[500] = -0.5;
        let felt = mechanical_closing(&groove, arc, 1.0 / radius);
        assert!(felt[500] > -0.011 - 1e-12, "a ball of 50 sinks 1/(2·50) into a gap of ±1: {}", felt[500]);
    }
}
