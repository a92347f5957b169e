//! CPU twin of `shaders/shadowgraph.wgsl`, the functions of one pixel: same names, same order, same
//! arithmetic in f32. [`super::cpu`] iterates over the pixels of a frame.

use super::column_edges::{Edge, PROFILE};
use super::job::Job;
use super::noise::{DENOMINATOR, NUMERATOR};
use super::params::Params;

/// Row of the sensor that a row of the frame shows: a second window may follow the first.
#[inline(always)]
pub(super) fn sensor_row(params: &Params, row: u32) -> u32 {
    params.place.row0 + row + if row >= params.place.split { params.place.skip } else { 0 }
}

/// Keys of a sensor row from those of the frame; one of them differs in every row.
#[inline(always)]
pub(crate) fn row_key(key: [u32; 2], row: u32) -> [u32; 2] {
    let mut x = row ^ key[0];
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    [x ^ (x >> 16), x.wrapping_add(key[1])]
}

/// 32 random bits of a pixel.
#[inline(always)]
pub(crate) fn hash(key: [u32; 2], column: u32) -> u32 {
    let mut x = column.wrapping_mul(0x9e37_79b9) ^ key[0];
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = x.wrapping_add(key[1]);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A standard normal deviate from 32 bits: the sum of two 16-bit numbers is triangular and is
/// mapped to normal by P/Q.
#[inline(always)]
pub(crate) fn standard_normal(bits: u32) -> f32 {
    let [p0, p1, p2, p3, p4] = NUMERATOR;
    let [q1, q2, q3] = DENOMINATOR;
    let v = (bits >> 16) as i32 + (bits & 0xffff) as i32 - 65535;
    let x = v as f32 * 1.525_878_9e-5;
    let u = 1.0 - x.abs();
    let p = p0 + u * (p1 + u * (p2 + u * (p3 + u * p4)));
    let q = 1.0 + u * (q1 + u * (q2 + u * q3));
    x * (p / q)
}

/// The larger value; `f32::max` handles NaN, which costs three instructions.
#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Coefficients of counts = k0 + k1 z + k2 z² + k3 z³ about a mean grey value.
#[inline(always)]
pub(crate) fn noise_polynomial(params: &Params, mean: f32) -> [f32; 4] {
    let electrons = most((mean - params.signal.black) * params.signal.electrons_per_count, 0.0);
    let variance = most(params.signal.read_variance + electrons, 1e-6);
    let inverse = 1.0 / variance;
    let sd = params.signal.noise * variance.sqrt() * params.counts_per_electron;
    let ratio = electrons * inverse;
    let kurtosis = ratio * inverse;
    let skew2 = ratio * kurtosis;
    let k2 = params.signal.noise * params.counts_per_electron * 0.166_666_67 * ratio;
    let k1 = sd * (1.0 - kurtosis * 0.125 + skew2 * 0.138_888_9);
    let k3 = sd * (kurtosis * 0.041_666_668 - skew2 * 0.055_555_556);
    [mean - k2, k1, k2, k3]
}

#[inline(always)]
pub(super) fn sample(k: [f32; 4], z: f32) -> f32 {
    k[0] + z * (k[1] + z * (k[2] + z * k[3]))
}

/// Adds the sensor's fixed pattern to a mean grey value: gain, offset and hot pixels, the same in
/// every frame.
#[inline(always)]
pub(super) fn fixed_pattern(params: &Params, mean: f32, key: [u32; 2], column: u32) -> f32 {
    let a = hash(key, column);
    let b = hash([key[1], key[0]], column);
    let response = params.pixels.prnu * (mean - params.signal.black) * standard_normal(a);
    let dark = params.pixels.dsnu * standard_normal(b);
    let hot = if a.wrapping_add(b).wrapping_mul(0x9e37_79b9) < params.pixels.hot_share {
        params.pixels.hot
    } else {
        0.0
    };
    response + dark + hot
}

/// Counts as bits: rounded half to even by adding 1.5·2²³, then clamped as integers.
#[inline(always)]
fn quantise(params: &Params, counts: f32) -> u32 {
    ((counts.min(params.pixels.ceiling) + 12_582_912.0).to_bits() as i32)
        .wrapping_sub(0x4b40_0000)
        .clamp(0, params.pixels.most) as u32
}

/// Share of the light at u, by one tabulated edge-spread function.
#[inline(always)]
fn edge_spread(params: &Params, esf: &[[f32; 4]], u: f32, table: u32) -> f32 {
    let place = ((u + params.edge.reach) * params.edge.per_unit).max(0.0).min(params.edge.segments as f32);
    let segment = (place as u32).min(params.edge.segments - 1);
    let t = place - segment as f32;
    let c = esf[(table * params.edge.segments + segment) as usize];
    c[0] + t * (c[1] + t * (c[2] + t * c[3]))
}

/// Share of the light on a pixel past an edge that is not straight: read from the edge's own
/// profile down the column, stored after the tables, four rows per vector.
#[inline(always)]
fn profile(job: &Job<'_>, edge: &Edge, row: i32) -> f32 {
    let i = row - edge.whole;
    if i < 0 || i >= edge.blend as i32 {
        return f32::from(u8::from((i < 0) == (edge.across < 0.0)));
    }
    let at = ((edge.table & !PROFILE) as usize + i as usize) - 4 * job.esf.segments.len();
    job.profiles[at >> 2][at & 3]
}

/// Share of the light on a pixel past one edge, integrated over the pixel's area.
#[inline(always)]
pub(crate) fn transmitted(job: &Job<'_>, edge: &Edge, row: i32) -> f32 {
    if edge.table >= PROFILE {
        return profile(job, edge, row);
    }
    let centre = ((row - edge.whole) as f32 - edge.part) * edge.across;
    let mut sum = 0.0;
    for node in &job.quadrature {
        let u = (centre + node.down * edge.across) + node.along * edge.along;
        let mut light = edge_spread(&job.params, &job.esf.segments, u, edge.table);
        if job.stacked {
            light += edge.blend * (edge_spread(&job.params, &job.esf.segments, u, edge.table + 1) - light);
        }
        sum += node.weight * light;
    }
    sum
}

/// Light over the field: vignetting times the backlight's gradient, 1 on the axis.
#[inline(always)]
pub(super) fn field_light(params: &Params, row: u32, column: u32) -> f32 {
    let u = (column as f32 - params.field.axis[0]) * params.field.half_diagonals;
    let v = (row as f32 - params.field.axis[1]) * params.field.half_diagonals;
    let r2 = u * u + v * v;
    let lens = 1.0 - r2 * (params.field.polynomial[0] + r2 * params.field.polynomial[1]);
    lens * (1.0 + params.field.polynomial[2] * u + params.field.polynomial[3] * v - params.field.sag * r2)
}

/// Counts of a pixel whose light is known, with the sensor's noise and pattern.
pub(crate) fn counts_of(params: &Params, light: f32, row: u32, column: u32) -> f32 {
    let mean = params.signal.shadow + params.signal.contrast * light;
    let z = standard_normal(hash(row_key(params.keys.noise, row), column));
    let counts = sample(noise_polynomial(params, mean), z);
    if params.pixels.pattern == 0 {
        return counts;
    }
    counts + fixed_pattern(params, mean, row_key(params.keys.pattern, row), column)
}

/// Conversion of counts to pixels of a container.
pub(crate) trait Pixel: Copy + Send + Sync + Default {
    /// One pixel from unquantised counts.
    fn from_counts(params: &Params, counts: f32) -> Self;
}

impl Pixel for u8 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        quantise(params, counts) as u8
    }
}

impl Pixel for u16 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        quantise(params, counts) as u16
    }
}

impl Pixel for f32 {
    #[inline(always)]
    fn from_counts(params: &Params, counts: f32) -> Self {
        counts.min(params.pixels.ceiling)
    }
}
