//! Parameters of a family of edges from profiles: least squares with a prior, by Gauss and Newton.
//!
//! ```text
//! χ² = Σ w·(o - l₀ - l₁·E(d - s; p))² + Σ ((p - p₀)/σ_p)²
//! ```
//!
//! E over a pixel; place s and levels l₀, l₁ are each profile's own and are eliminated from the
//! normal equations (Schur), so that the cost grows in proportion to the profiles. Derivatives by
//! the parameters are differences over a fifth of their prior's deviation.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3, Vector4};
use rayon::prelude::*;

use super::profile::MasterProfile;
use crate::render::RenderError;
use crate::render::optics::edge_spread::EdgeSpread;

/// Parameters of a family.
pub(super) const PARAMETERS: usize = 4;

/// Most steps, largest step and the step at which the fit ends, in deviations of the prior.
const STEPS: usize = 10;
const LARGEST_STEP: f64 = 1.5;
const SETTLED: f64 = 1e-3;

/// Step of the differences in deviations of the prior.
const DIFFERENCE: f64 = 0.2;

/// Step of the derivative by the place, px.
const PLACE_STEP_PX: f64 = 1e-3;

/// A family of edges.
pub(super) trait Family: Sync {
    /// The edge of a profile's master.
    ///
    /// # Errors
    /// Parameters or a master that are refused.
    fn edge(&self, parameters: &[f64; PARAMETERS], of: &MasterProfile) -> Result<EdgeSpread, RenderError>;

    /// Size of a pixel on the object, µm.
    fn um_per_px(&self) -> f64;
}

/// What is known of the parameters before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) mean: [f64; PARAMETERS],
    pub(super) sd: [f64; PARAMETERS],
    pub(super) least: [f64; PARAMETERS],
    pub(super) most: [f64; PARAMETERS],
}

impl Prior {
    /// Parameters of deviations from the mean, within the limits.
    fn at(&self, deviations: &Vector4<f64>) -> [f64; PARAMETERS] {
        std::array::from_fn(|k| {
            (self.mean[k] + deviations[k] * self.sd[k]).clamp(self.least[k], self.most[k])
        })
    }

    fn deviations(&self, parameters: &[f64; PARAMETERS]) -> Vector4<f64> {
        Vector4::from_fn(|k, _| (parameters[k] - self.mean[k]) / self.sd[k])
    }
}

/// Parameters that were found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub(super) parameters: [f64; PARAMETERS],
    /// Standard uncertainties, multiplied by the root of χ² over its freedom where that exceeds 1.
    pub(super) u: [f64; PARAMETERS],
    pub(super) reduced_chi2: f64,
}

/// Normal equations of one profile: those of the parameters, of its own place and levels, and
/// between them.
struct Normal {
    shared: Matrix4<f64>,
    mixed: Matrix3x4<f64>,
    own: Matrix3<f64>,
    right: Vector4<f64>,
    own_right: Vector3<f64>,
    /// Σ w r².
    square: f64,
}

impl Normal {
    /// What the profile contributes to the parameters, its own unknowns eliminated: matrix, right
    /// side and the rest of Σ w r².
    fn reduced(&self) -> (Matrix4<f64>, Vector4<f64>, f64) {
        let inverse = self.own.try_inverse().unwrap_or_else(Matrix3::zeros);
        let gain = self.mixed.transpose() * inverse;
        (
            self.shared - gain * self.mixed,
            self.right - gain * self.own_right,
            self.square - self.own_right.dot(&(inverse * self.own_right)),
        )
    }

    /// Change of its place, px, for a change of the parameters.
    fn place(&self, change: &Vector4<f64>) -> f64 {
        let inverse = self.own.try_inverse().unwrap_or_else(Matrix3::zeros);
        (inverse * (self.own_right - self.mixed * change))[2]
    }
}

/// Fits a family to profiles.
///
/// # Errors
/// Parameters within the limits of the prior that the family refuses.
pub(super) fn fit(
    family: &dyn Family,
    profiles: &[MasterProfile],
    prior: &Prior,
) -> Result<Fitted, RenderError> {
    let mut at = Vector4::zeros();
    let mut places = vec![0.0; profiles.len()];
    let mut step = 0;
    loop {
        let parameters = prior.at(&at);
        at = prior.deviations(&parameters);
        let normals = profiles
            .par_iter()
            .zip(&places)
            .map(|(profile, place)| normal(family, profile, *place, (&parameters, prior)))
            .collect::<Result<Vec<_>, _>>()?;
        let (mut matrix, mut right, mut square) = (Matrix4::identity(), -at, at.norm_squared());
        for (m, r, rest) in normals.iter().map(Normal::reduced) {
            (matrix, right, square) = (matrix + m, right + r, square + rest);
        }
        let covariance = matrix.try_inverse().unwrap_or_else(Matrix4::identity);
        let mut change = covariance * right;
        if step == STEPS || change.amax() < SETTLED {
            let pixels: usize = profiles.iter().map(|p| p.samples.len()).sum();
            let freedom = pixels.saturating_sub(3 * profiles.len()).max(1) as f64;
            let reduced_chi2 = square / freedom;
            let spread = reduced_chi2.max(1.0).sqrt();
            let u = std::array::from_fn(|k| spread * prior.sd[k] * covariance[(k, k)].max(0.0).sqrt());
            return Ok(Fitted { parameters, u, reduced_chi2 });
        }
        change *= (LARGEST_STEP / change.amax()).min(1.0);
        places.iter_mut().zip(&normals).for_each(|(place, n)| *place += n.place(&change));
        at += change;
        step += 1;
    }
}

/// Normal equations of a profile about the parameters and its place.
fn normal(
    family: &dyn Family,
    profile: &MasterProfile,
    place_px: f64,
    (parameters, prior): (&[f64; PARAMETERS], &Prior),
) -> Result<Normal, RenderError> {
    let um_per_px = family.um_per_px();
    let own = family.edge(parameters, profile)?;
    let mut others = Vec::with_capacity(PARAMETERS);
    for k in 0..PARAMETERS {
        // Away from the limit that is nearer.
        let up = parameters[k] + DIFFERENCE * prior.sd[k] <= prior.most[k];
        let step = if up { DIFFERENCE } else { -DIFFERENCE };
        let mut moved = *parameters;
        moved[k] += step * prior.sd[k];
        others.push((family.edge(&moved, profile)?, step));
    }
    let light = |edge: &EdgeSpread, d_px: f64| edge.over_pixel(d_px * um_per_px, um_per_px, 0.0);
    let mut n = Normal {
        shared: Matrix4::zeros(),
        mixed: Matrix3x4::zeros(),
        own: Matrix3::zeros(),
        right: Vector4::zeros(),
        own_right: Vector3::zeros(),
        square: 0.0,
    };
    for sample in &profile.samples {
        let d = sample.d_px - place_px;
        let e = light(&own, d);
        let ahead = light(&own, d + PLACE_STEP_PX) - light(&own, d - PLACE_STEP_PX);
        let by_own = Vector3::new(1.0, e, -ahead / (2.0 * PLACE_STEP_PX));
        let by = Vector4::from_fn(|k, _| (light(&others[k].0, d) - e) / others[k].1);
        let (w, r) = (sample.weight, sample.light - e);
        n.shared += by * by.transpose() * w;
        n.mixed += by_own * by.transpose() * w;
        n.own += by_own * by_own.transpose() * w;
        n.right += by * (w * r);
        n.own_right += by_own * (w * r);
        n.square += w * r * r;
    }
    Ok(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::optics::edge_spread::GaussianBlur;
    use crate::studies::limb_fit::profile::ProfileSample;

    /// Gaussian edges whose blur grows with depth by an aperture: as much as a closed form allows.
    /// The last parameter is the plane of focus, the third does nothing.
    struct Blurred;

    impl Family for Blurred {
        fn edge(&self, p: &[f64; PARAMETERS], of: &MasterProfile) -> Result<EdgeSpread, RenderError> {
            let blur = GaussianBlur {
                lens_sigma_um: p[1],
                defocus_mm: of.y_mm + p[3],
                effective_na: p[0],
                motion_um: 0.0,
            };
            blur.edge_spread()
        }

        fn um_per_px(&self) -> f64 {
            10.0
        }
    }

    fn profile(truth: &[f64; PARAMETERS], y_mm: f64) -> MasterProfile {
        let mut of = MasterProfile { diameter_mm: 5.0, y_mm, samples: Vec::new() };
        let edge = Blurred.edge(truth, &of).unwrap();
        // 0.13 px out of place, dark by 0.01 and too light by 2 %.
        of.samples = (-100..=100)
            .map(|i| f64::from(i) / 10.0)
            .map(|d| {
                let light = 0.01 + 1.02 * edge.over_pixel(10.0 * (d - 0.13), 10.0, 0.0);
                ProfileSample { d_px: d, light, weight: 1e8 }
            })
            .collect();
        of
    }

    #[test]
    fn parameters_are_found_whatever_place_and_levels_of_each_edge() {
        let truth = [0.02, 14.0, 0.5, 0.4];
        let prior = Prior {
            mean: [0.018, 12.0, 0.0, 0.0],
            sd: [0.004, 4.0, 1.0, 1.0],
            least: [1e-3, 1.0, f64::NEG_INFINITY, f64::NEG_INFINITY],
            most: [0.1, 100.0, f64::INFINITY, f64::INFINITY],
        };
        let profiles: Vec<MasterProfile> = [-2.0, 0.5, 2.5].map(|y| profile(&truth, y)).to_vec();
        let found = fit(&Blurred, &profiles, &prior).unwrap();
        for k in [0, 1, 3] {
            let off = (found.parameters[k] - truth[k]).abs() / prior.sd[k];
            assert!(off < 2e-3, "{k}: {:?}", found.parameters);
        }
        // What no profile shows stays as it was known.
        assert!(found.parameters[2].abs() < 1e-6 && (found.u[2] - 1.0).abs() < 1e-6, "{:?}", found.u);
        assert!(found.u[0] < 0.01 * prior.sd[0] && found.reduced_chi2 < 0.1, "{found:?}");
    }
}
