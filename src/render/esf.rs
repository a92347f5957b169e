//! The edge-spread function as a table, and the pixel's area as a quadrature over it.
//!
//! A straight edge of slope tan β gives at pixel (row y, column x)
//!
//! ```text
//! I = ∫∫ F(d(x + ξ, y + η)) dξ dη over ξ, η in ±1/2,   d = ((e - y) - η) cos β + ξ sin β
//! ```
//!
//! with F over the perpendicular distance d into the light, so that one table serves every slope. The integral is a
//! Gauss-Legendre product whose order follows from the blur; its error stays below 1e-6 of the contrast.

use super::coherence::edge_image;
use super::fresnel::straight_edge_in_band;
use super::settings::{Esf, FresnelEsf, PartiallyCoherentEsf, TableEsf};

/// Knots a unit of σ of the Gaussian's table: cubic Hermite errs by (1/16)⁴/384·max|F⁗| = 2e-8.
const KNOTS_PER_SIGMA: f64 = 16.0;

/// Reach of the Gaussian table in σ: 1 - Φ(5.25) = 8e-8, below the spacing of f32 at 1.
const GAUSSIAN_REACH: f64 = 5.25;

/// Knots a λ/NA of the partially coherent edge, whose finest ripple is λ/2NA: errs by (π/24)⁴/384 = 8e-7.
const KNOTS_PER_AIRY: f64 = 48.0;

/// Reach of the partially coherent edge in focus, λ/NA.
const COHERENT_REACH: f64 = 12.0;

/// Farthest fringe of the Fresnel edge in v; a monochromatic fringe there is .5 % of the light.
const FRESNEL_REACH: f64 = 60.0;

/// Share of the reach over which what is left of ripples and shadow light is led to 1 and 0.
const TAPER: f64 = 0.1;

/// An edge-spread function over u = d/scale, piecewise cubic, 0 in the shadow and 1 in the light.
#[derive(Clone, Debug, PartialEq)]
pub struct EsfTable {
    /// Coefficients c0..c3 of every segment in its own fraction 0..1.
    pub segments: Vec<[f32; 4]>,
    /// u of the first knot is -reach, of the last +reach.
    pub reach: f32,
    /// Segments a unit of u.
    pub per_unit: f32,
    /// Pixels a unit of u in focus (σ for the Gaussian).
    pub scale_px: f64,
    /// Standard deviation of a Gaussian about as sharp, px: what the quadrature over a pixel has to resolve.
    pub blur_px: f64,
    /// Whether extra blur just widens the scale (true for the Gaussian only).
    pub widens: bool,
}

impl EsfTable {
    /// Tabulates a family for pixels of `pixel_mm` on the object.
    pub fn new(esf: &Esf, pixel_mm: f64) -> Self {
        match esf {
            Esf::Gaussian(g) => Self::gaussian(g.sigma_px),
            Esf::PartiallyCoherent(p) => Self::partially_coherent(p, pixel_mm),
            Esf::Fresnel(f) => Self::fresnel(f, pixel_mm),
            Esf::Table(t) => Self::measured(t),
        }
    }

    fn gaussian(sigma_px: f64) -> Self {
        let count = (2.0 * GAUSSIAN_REACH * KNOTS_PER_SIGMA).ceil();
        let step = 2.0 * GAUSSIAN_REACH / count;
        let segments = (0..count as usize)
            .map(|i| {
                let (a, da) = gaussian(-GAUSSIAN_REACH + i as f64 * step);
                let (b, db) = gaussian(-GAUSSIAN_REACH + (i + 1) as f64 * step);
                hermite(a, da * step, b, db * step)
            })
            .collect();
        let (reach, per_unit) = (GAUSSIAN_REACH as f32, (1.0 / step) as f32);
        Self { segments, reach, per_unit, scale_px: sigma_px, blur_px: sigma_px, widens: true }
    }

    fn partially_coherent(p: &PartiallyCoherentEsf, pixel_mm: f64) -> Self {
        let airy_mm = p.wavelength_nm * 1e-6 / p.numerical_aperture;
        let zeta = p.defocus_um * 1e-3 * p.numerical_aperture / airy_mm;
        let reach = COHERENT_REACH * (1.0 + zeta.abs() / 4.0);
        let count = (reach * KNOTS_PER_AIRY).ceil() as usize;
        let values = edge_image(p.coherence_ratio, zeta, reach, count);
        // A 10-90 % width of .36-.66 λ/NA is that of a Gaussian of .14-.26 λ/NA.
        Self::from_values(values, reach, airy_mm / pixel_mm, 0.15 * airy_mm / pixel_mm)
    }

    fn fresnel(f: &FresnelEsf, pixel_mm: f64) -> Self {
        let unit_mm = (f.wavelength_nm * 1e-6 * f.distance_mm / 2.0).sqrt();
        let band = f.bandwidth_nm / f.wavelength_nm;
        // Fringes are damped to 1e-4 where a standard deviation of the band turns their phase by √(2 ln 1e4).
        let damped = if band > 0.0 { (6.5 / band).sqrt() } else { FRESNEL_REACH };
        let reach = damped.clamp(8.0, FRESNEL_REACH);
        // The last fringe is 2/reach long; 24 knots to it.
        let count = (12.0 * reach * reach).ceil() as usize;
        let values = straight_edge_in_band(reach, count, band);
        // As sharp as the fringes, not as the edge: the pixel has to be integrated over them.
        Self::from_values(values, reach, unit_mm / pixel_mm, 0.2 * unit_mm / pixel_mm)
    }

    fn measured(t: &TableEsf) -> Self {
        let reach = t.distance_px.iter().fold(0.0, |r: f64, d| r.max(d.abs()));
        let gaps = || t.distance_px.windows(2).map(|w| w[1] - w[0]);
        let spacing = gaps().fold(f64::INFINITY, f64::min);
        let count = (4.0 * reach / spacing).ceil().clamp(64.0, 16384.0) as usize;
        let values = (0..=2 * count).map(|i| t.at(reach * (i as f64 / count as f64 - 1.0))).collect();
        let rises = t.light.windows(2).map(|w| w[1] - w[0]);
        let steepest = gaps().zip(rises).map(|(d, l)| l / d).fold(0.0, f64::max);
        Self::from_values(values, reach, 1.0, 1.0 / (steepest * (2.0 * std::f64::consts::PI).sqrt()))
    }

    /// A table through equidistant values over ±reach, slopes by central differences of fourth order.
    fn from_values(mut values: Vec<f64>, reach: f64, scale_px: f64, blur_px: f64) -> Self {
        taper_ends(&mut values);
        let at = |i: i64| values[i.clamp(0, values.len() as i64 - 1) as usize];
        let slope = |i: i64| (8.0 * (at(i + 1) - at(i - 1)) - (at(i + 2) - at(i - 2))) / 12.0;
        let segments: Vec<_> =
            (0..values.len() as i64 - 1).map(|i| hermite(at(i), slope(i), at(i + 1), slope(i + 1))).collect();
        let per_unit = (segments.len() as f64 / (2.0 * reach)) as f32;
        Self { segments, reach: reach as f32, per_unit, scale_px, blur_px, widens: false }
    }

    /// The tabulated function at a distance into the light, px, in f64: for figures and tests.
    pub fn at_px(&self, distance_px: f64) -> f64 {
        let place = ((distance_px / self.scale_px + f64::from(self.reach)) * f64::from(self.per_unit))
            .clamp(0.0, self.segments.len() as f64);
        let segment = (place as usize).min(self.segments.len() - 1);
        let t = place - segment as f64;
        self.segments[segment].iter().rev().fold(0.0, |sum, &c| sum * t + f64::from(c))
    }
}

/// Leads both ends smoothly to 0 and 1, so that the flat fields join the table.
fn taper_ends(values: &mut [f64]) {
    let n = values.len();
    let width = (0.5 * TAPER * n as f64).max(1.0);
    let keep = |t: f64| if t < 1.0 { t * t * (3.0 - 2.0 * t) } else { 1.0 };
    for (i, value) in values.iter_mut().enumerate() {
        *value *= keep(i as f64 / width);
        *value = 1.0 - (1.0 - *value) * keep((n - 1 - i) as f64 / width);
    }
}

/// Φ(u) and φ(u); the reference takes another route to Φ (libm's erf).
fn gaussian(u: f64) -> (f64, f64) {
    let density = (-0.5 * u * u).exp() / (2.0 * std::f64::consts::PI).sqrt();
    (statrs::function::erf::erfc(-u / std::f64::consts::SQRT_2) * 0.5, density)
}

fn hermite(a: f64, da: f64, b: f64, db: f64) -> [f32; 4] {
    let c2 = 3.0 * (b - a) - 2.0 * da - db;
    let c3 = 2.0 * (a - b) + da + db;
    [a as f32, da as f32, c2 as f32, c3 as f32]
}

/// One node of the quadrature over a pixel: offsets from its centre and weight.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Node {
    /// Along the row, px.
    pub along: f32,
    /// Down the column, px.
    pub down: f32,
    /// Weight; all weights add up to one.
    pub weight: f32,
    /// Fills up 16 bytes.
    pub padding: f32,
}

/// Nodes for edges as sharp as a Gaussian of `blur_px` and slopes up to `max_sin` = max |sin β|.
pub fn pixel_quadrature(blur_px: f64, max_sin: f64) -> Vec<Node> {
    let down = gauss_legendre(order(0.5 / blur_px));
    let along = gauss_legendre(order(0.5 * max_sin / blur_px));
    let node = |(x, wx): &(f64, f64), (y, wy): &(f64, f64)| Node {
        along: (0.5 * x) as f32,
        down: (0.5 * y) as f32,
        weight: (0.25 * wx * wy) as f32,
        padding: 0.0,
    };
    along.iter().flat_map(|a| down.iter().map(move |d| node(a, d))).collect()
}

/// Order of the rule over a half width `a` in units of the blur; limits from the error term
/// `2^2n (n!)^4 / ((2n+1) (2n)!^3) a^2n F^(2n)` at 1e-6.
fn order(a: f64) -> usize {
    match a {
        a if a <= 0.004 => 1,
        a if a <= 0.15 => 2,
        a if a <= 0.45 => 3,
        a if a <= 0.9 => 4,
        _ => 8,
    }
}

/// Nodes and weights on -1..1, by Newton's method on the Legendre recurrence.
pub(super) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        (now, n as f64 * (x * now - before) / (x * x - 1.0))
    };
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..50 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let slope = legendre(x).1;
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}
