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

use super::settings::Esf;

/// Knots a unit of the table's scale (σ for the Gaussian): cubic Hermite errs by (1/16)⁴/384·max|F''''| = 2e-8.
const KNOTS_PER_UNIT: f64 = 16.0;

/// Reach of the Gaussian table in σ: 1 - Φ(5.25) = 8e-8, below the spacing of f32 at 1.
const GAUSSIAN_REACH: f64 = 5.25;

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
    /// Whether extra blur just widens the scale (true for the Gaussian only).
    pub widens: bool,
}

impl EsfTable {
    /// Tabulates a family.
    pub fn new(esf: &Esf) -> Self {
        match esf {
            Esf::Gaussian(g) => Self::tabulate(GAUSSIAN_REACH, g.sigma_px, true, gaussian),
        }
    }

    /// Tabulates a function that gives F and dF/du.
    fn tabulate(reach: f64, scale_px: f64, widens: bool, f: impl Fn(f64) -> (f64, f64)) -> Self {
        let count = (2.0 * reach * KNOTS_PER_UNIT).ceil();
        let step = 2.0 * reach / count;
        let segments = (0..count as usize)
            .map(|i| {
                let (a, da) = f(-reach + i as f64 * step);
                let (b, db) = f(-reach + (i + 1) as f64 * step);
                hermite(a, da * step, b, db * step)
            })
            .collect();
        Self { segments, reach: reach as f32, per_unit: (1.0 / step) as f32, scale_px, widens }
    }

    /// Pixels from the edge, across it, beyond which light and shadow are flat at blur `scale_px`.
    pub fn reach_px(&self, scale_px: f64) -> f64 {
        f64::from(self.reach) * scale_px
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

/// Nodes for edges as sharp as `scale_px` and slopes up to `max_sin` = max |sin β|.
pub fn pixel_quadrature(scale_px: f64, max_sin: f64) -> Vec<Node> {
    let down = gauss_legendre(order(0.5 / scale_px));
    let along = gauss_legendre(order(0.5 * max_sin / scale_px));
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
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
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
