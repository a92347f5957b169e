//! Shadow of a half plane in collimated light without a lens: Fresnel diffraction.
//!
//! ```text
//! I(v) = ½ [(½ + C(v))² + (½ + S(v))²],   v = x √(2/(λ ℓ)),   C + iS = ∫₀^v exp(iπt²/2) dt
//! ```
//!
//! with x into the light, ℓ the distance from edge to sensor (M. Born, E. Wolf, Principles of Optics, 8.7.3). A finite
//! bandwidth averages I over λ and damps the fringes from v² ≈ λ/Δλ on.

use super::esf::gauss_legendre;

/// Nodes a step of the integration; with steps of at most a quarter turn of phase the error stays below 1e-10.
const NODES: usize = 8;

/// Wavelengths over ±2.5 standard deviations of the band.
const WAVELENGTHS: usize = 41;

/// FWHM of a Gaussian in standard deviations.
const FWHM: f64 = 2.354_820_045;

/// C(v) and S(v) at v = 0, step, 2·step, …
fn fresnel_integrals(step: f64, count: usize) -> Vec<(f64, f64)> {
    let nodes = gauss_legendre(NODES);
    let (mut c, mut s) = (0.0, 0.0);
    let mut out = vec![(0.0, 0.0)];
    for i in 0..count {
        for (x, w) in &nodes {
            let t = (i as f64 + 0.5 * (1.0 + x)) * step;
            let (sin, cos) = (std::f64::consts::FRAC_PI_2 * t * t).sin_cos();
            c += 0.5 * step * w * cos;
            s += 0.5 * step * w * sin;
        }
        out.push((c, s));
    }
    out
}

/// Intensity over v = -reach ..= reach at `2·count + 1` equal steps, monochromatic.
pub fn straight_edge(reach: f64, count: usize) -> Vec<f64> {
    let integrals = fresnel_integrals(reach / count as f64, count);
    let light = |c: f64, s: f64| 0.5 * ((0.5 + c).powi(2) + (0.5 + s).powi(2));
    let shadow = integrals.iter().rev().map(|&(c, s)| light(-c, -s));
    shadow.chain(integrals.iter().skip(1).map(|&(c, s)| light(c, s))).collect()
}

/// As [`straight_edge`] for a Gaussian band of relative full width at half maximum `band`.
pub fn straight_edge_in_band(reach: f64, count: usize, band: f64) -> Vec<f64> {
    if band == 0.0 {
        return straight_edge(reach, count);
    }
    let wider = 1.0 + 1.3 * band;
    let fine_reach = reach * wider;
    let fine_count = (count as f64 * wider).ceil() as usize * 2;
    let fine = straight_edge(fine_reach, fine_count);
    let at = |v: f64| {
        let place = (v + fine_reach) / fine_reach * fine_count as f64;
        cubic(&fine, place)
    };
    let draws: Vec<(f64, f64)> = (0..WAVELENGTHS)
        .map(|i| {
            let z = 5.0 * (i as f64 / (WAVELENGTHS - 1) as f64 - 0.5);
            ((1.0 + z * band / FWHM).max(0.05).sqrt().recip(), (-0.5 * z * z).exp())
        })
        .collect();
    let total: f64 = draws.iter().map(|d| d.1).sum();
    (0..=2 * count)
        .map(|i| reach * (i as f64 / count as f64 - 1.0))
        .map(|v| draws.iter().map(|(stretch, w)| w * at(v * stretch)).sum::<f64>() / total)
        .collect()
}

/// Catmull-Rom interpolation between samples; the ends are held.
fn cubic(samples: &[f64], place: f64) -> f64 {
    let last = samples.len() as i64 - 1;
    let i = (place.floor() as i64).clamp(0, last);
    let t = place - i as f64;
    let [a, b, c, d] = [-1, 0, 1, 2].map(|k| samples[(i + k).clamp(0, last) as usize]);
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}
