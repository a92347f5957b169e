//! How far an edge is displaced when it is no longer the one that is fitted: out of focus, or
//! smeared.
//!
//! Place, blur and levels of the edge in focus are fitted to the changed edge by least squares
//! weighted with the pixels' variance (Gauss and Newton), as the gauge fits them; what remains is
//! the displacement into the light, which makes a shadow wider by it at either edge, the blur's
//! factor, and the residual.

use nalgebra::{Matrix4, Vector4};

use super::bound::GreyLevels;
use super::edge::{OpticalEdge, PER_PX, PixelEdge};

/// Samples from one used to the next: eight places of an edge within a pixel.
const STRIDE: usize = PER_PX / 8;
/// Pixels at either end of the window that are left out, so that a displaced model covers it.
const END_PX: f64 = 1.0;
/// Most steps: a step halves the distance at least, and 40 halvings reach 1e-12.
const MOST_STEPS: usize = 40;
/// Step of place (px) and blur (relative) below which the fit has converged.
const CONVERGED: f64 = 1e-8;
/// Relative step of the blur's derivative.
const BLUR_STEP: f64 = 1e-3;
/// Largest change of the blur in a step, relative.
const LARGEST_STEP: f64 = 0.3;

/// A fitted edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Displacement {
    /// Displacement into the light, px.
    pub(super) into_light_px: f64,
    /// Blur over that of the model.
    pub(super) blur_factor: f64,
    /// Rms residual as a share of the contrast, where the edge changes by a hundredth or more.
    pub(super) residual_rel: f64,
}

/// Fits `model` to `seen`; `None` where the fit does not converge.
pub(super) fn displacement(
    model: &OpticalEdge,
    seen: &PixelEdge,
    half_px: usize,
    levels: &GreyLevels,
) -> Option<Displacement> {
    let (mut place, mut factor) = (0.0, 1.0);
    for _ in 0..MOST_STEPS {
        let edge = model.over_pixels(half_px, factor, 0.0);
        let wider = model.over_pixels(half_px, factor * (1.0 + BLUR_STEP), 0.0);
        let fit = Fit { edge: &edge, wider: &wider, seen, levels };
        let step = fit.step(place)?;
        let by_blur = step[1].clamp(-LARGEST_STEP, LARGEST_STEP);
        place += step[0].clamp(-1.0, 1.0);
        factor *= 1.0 + by_blur;
        if step[0].abs() < CONVERGED && step[1].abs() < CONVERGED {
            let residual_rel = fit.residual_rel(place);
            return Some(Displacement { into_light_px: place, blur_factor: factor, residual_rel });
        }
    }
    None
}

struct Fit<'a> {
    edge: &'a PixelEdge,
    wider: &'a PixelEdge,
    seen: &'a PixelEdge,
    levels: &'a GreyLevels,
}

impl Fit<'_> {
    /// Samples that take part.
    fn samples(&self) -> impl Iterator<Item = usize> + '_ {
        let within = move |i: &usize| {
            let d = self.seen.distance_px(*i);
            d.abs() <= -self.seen.distance_px(0) - END_PX
        };
        (0..self.seen.samples()).step_by(STRIDE).filter(within)
    }

    /// Derivatives of a sample by place, blur (relative), dark and light, in units of the contrast,
    /// and its weight.
    fn row(&self, sample: usize, place: f64) -> (Vector4<f64>, f64) {
        let (light, slope) = self.edge.at(self.seen.distance_px(sample) - place);
        let (wider, _) = self.wider.at(self.seen.distance_px(sample) - place);
        let by = Vector4::new(-slope, (wider - light) / BLUR_STEP, 1.0 - light, light);
        let level = self.levels.dark + self.levels.contrast() * self.seen.value(sample);
        (by, self.levels.variance(level).recip())
    }

    /// Levels are linear: with the model a + c·E about E they are found in each step anew.
    fn step(&self, place: f64) -> Option<Vector4<f64>> {
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for i in self.samples() {
            let (by, weight) = self.row(i, place);
            let residual = self.seen.value(i) - by[3];
            normal += weight * by * by.transpose();
            right += weight * residual * by;
        }
        normal.try_inverse().map(|inverse| inverse * right)
    }

    /// Rms of what place, blur and levels leave.
    fn residual_rel(&self, place: f64) -> f64 {
        let Some(step) = self.step(place) else { return f64::NAN };
        let (mut sum, mut count) = (0.0, 0.0);
        for i in self.samples() {
            let (by, _) = self.row(i, place);
            let light = self.seen.value(i);
            if (0.01..=0.99).contains(&light) {
                sum += (light - by[3] - step.dot(&by)).powi(2);
                count += 1.0;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::settings::{Camera, Esf, GaussianEsf, Optics, SetupSettings};
    use crate::studies::head::edge::EdgeOptics;

    const HALF_PX: usize = 30;

    fn gaussian(sigma_px: f64, defocus_na: f64) -> EdgeOptics {
        let optics = Optics { esf: Esf::Gaussian(GaussianEsf { sigma_px }), defocus_na, ..Optics::default() };
        EdgeOptics { optics, pixel_mm: 0.01, radius_mm: 5.0 }
    }

    fn levels() -> GreyLevels {
        GreyLevels::of(&SetupSettings { camera: Camera::default(), ..SetupSettings::default() })
    }

    /// A Gaussian out of focus is a wider Gaussian: √(σ² + (y·NA/2)²), not displaced.
    #[test]
    fn a_gaussian_out_of_focus_is_wider_and_stays() {
        let optics = gaussian(1.5, 0.05);
        let (model, y_mm) = (optics.at(0.0).unwrap(), 1.2);
        let seen = optics.at(y_mm).unwrap().over_pixels(HALF_PX, 1.0, 0.0);
        let found = displacement(&model, &seen, HALF_PX, &levels()).unwrap();
        let wanted = (1.5_f64.powi(2) + (0.5 * y_mm * 0.05 / 0.01).powi(2)).sqrt() / 1.5;
        assert!((found.blur_factor - wanted).abs() < 1e-4, "{found:?} {wanted}");
        assert!(found.into_light_px.abs() < 1e-5 && found.residual_rel < 1e-4, "{found:?}");
    }

    /// An edge that was moved is found where it was moved to.
    #[test]
    fn a_moved_edge_is_found() {
        let optics = gaussian(0.9, 0.0);
        let model = optics.at(0.0).unwrap();
        let seen = PixelEdge::of(HALF_PX, 0.0, |d| model.light(d - 0.37));
        let found = displacement(&model, &seen, HALF_PX, &levels()).unwrap();
        assert!((found.into_light_px - 0.37).abs() < 1e-5, "{found:?}");
        assert!((found.blur_factor - 1.0).abs() < 1e-4, "{found:?}");
    }

    /// A long path is no Gaussian: it leaves a residual, which a short one does not.
    #[test]
    fn a_long_smear_leaves_a_residual() {
        let optics = gaussian(1.0, 0.0);
        let model = optics.at(0.0).unwrap();
        let residual = |smear_px: f64| {
            let seen = model.over_pixels(HALF_PX, 1.0, smear_px);
            displacement(&model, &seen, HALF_PX, &levels()).unwrap().residual_rel
        };
        assert!(residual(0.5) < 1e-3 && residual(15.0) > 0.01, "{} {}", residual(0.5), residual(15.0));
    }
}
