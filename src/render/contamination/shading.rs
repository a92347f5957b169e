//! Multiplies shades onto the pixels: row by row, tabulated where a shade is round. The optical
//! depths of clouds are added before a single exponential is evaluated.

use multiversion::multiversion;

use super::mask::{MIST, THRESHOLD};
use super::shapes::{disc, half_plane, into_polygon, line};
use super::tiles::{Band, TILE};

/// Reach of a cloud, standard deviations: at its border it attenuates by less than 1e-5 at τ = 1.
pub(super) const CLOUD_REACH: f64 = 4.8;

/// Entries per pixel of a round shade's table; linear interpolation errs by less than 1e-3 at a
/// sharp border.
const PER_PIXEL: f64 = 8.0;

/// Depth for which five terms of the exponential's series suffice in f32.
const SHALLOW: f64 = 0.125;

/// One object in the beam, in pixels of the full sensor, points as (row, column).
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shade {
    /// Optical depth and standard deviation.
    Cloud { at: [f64; 2], depth: f64, sigma: f64 },
    /// Dark disc with a clear one in its middle.
    Disc { at: [f64; 2], radius: f64, clear: f64, opacity: f64, blur: f64 },
    /// Opaque polygon.
    Polygon { corners: Vec<[f64; 2]>, blur: f64 },
    /// Straight line between two ends.
    Line { from: [f64; 2], to: [f64; 2], width: f64, opacity: f64, blur: f64 },
}

/// Shades prepared for a map.
pub(super) struct Layers<'a> {
    /// Haze over the whole field.
    haze: f32,
    clouds: Vec<Ready<'a>>,
    things: Vec<Ready<'a>>,
}

impl<'a> Layers<'a> {
    /// Shades over a map whose first pixel is `first` on the sensor, in a haze with the
    /// transmission `haze`.
    pub(super) fn new(shades: &'a [(u8, Shade)], haze: f32, first: [usize; 2]) -> Self {
        let first = [first[0] as f64, first[1] as f64];
        let ready = shades.iter().map(|(kind, shade)| Ready::new(*kind, shade, first));
        let (clouds, things) = ready.partition(|r| matches!(r.shade, Shade::Cloud { .. }));
        Self { haze, clouds, things }
    }

    /// Multiplies a band by all factors.
    pub(super) fn shade(&self, band: &mut Band<'_>) {
        lay_band(self, band);
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"), dispatcher = "direct")]
fn lay_band(layers: &Layers<'_>, band: &mut Band<'_>) {
    let columns = band.columns;
    let rows = band.first..band.first + (band.values.len() / columns) as i64;
    if layers.haze < 1.0 {
        haze(layers.haze, band);
    }
    let mut factors = vec![0.0f32; columns];
    if layers.clouds.iter().any(|c| c.rows.start < rows.end && c.rows.end > rows.start) {
        rows.clone().for_each(|row| mist(&layers.clouds, row, band, &mut factors));
    }
    for thing in &layers.things {
        let (from, to) = (thing.columns.start.max(0), thing.columns.end.min(columns as i64));
        if from >= to {
            continue;
        }
        let factors = &mut factors[..(to - from) as usize];
        for row in thing.rows.start.max(rows.start)..thing.rows.end.min(rows.end) {
            thing.fill(row, from, factors);
            let at = (row - rows.start) as usize * columns + from as usize;
            multiply(band, at, factors, thing.kind);
            touch(band.touched, from as usize, factors);
        }
    }
}

#[inline(always)]
fn haze(factor: f32, band: &mut Band<'_>) {
    band.values.iter_mut().for_each(|v| *v *= factor);
    if let Some(mask) = band.mask.as_mut().filter(|_| (factor - 1.0).abs() > THRESHOLD) {
        mask.iter_mut().for_each(|m| *m |= MIST);
    }
    band.touched.fill(true);
}

/// Dims a row by all clouds over it; every cloud marks the pixels that it changes by itself.
#[inline(always)]
fn mist(clouds: &[Ready<'_>], row: i64, band: &mut Band<'_>, depths: &mut [f32]) {
    let at = (row - band.first) as usize * band.columns;
    let mut deepest = 0.0;
    depths.fill(0.0);
    for cloud in clouds.iter().filter(|c| c.rows.contains(&row)) {
        let (from, to) = (cloud.columns.start.max(0), cloud.columns.end.min(band.columns as i64));
        let Shade::Cloud { at: middle, depth, sigma } = cloud.shade else { continue };
        if from >= to {
            continue;
        }
        let here = depth * (-0.5 * ((row as f64 + cloud.first[0] - middle[0]) / sigma).powi(2)).exp();
        deepest += here;
        let here = here as f32;
        let (start, range) = ((from - cloud.columns.start) as usize, from as usize..to as usize);
        let table = &cloud.table[start..start + range.len()];
        for (d, g) in depths[range.clone()].iter_mut().zip(table) {
            *d += here * g;
        }
        if let Some(mask) = &mut band.mask {
            for (m, g) in mask[at + range.start..at + range.end].iter_mut().zip(table) {
                *m |= if here * g > VISIBLE_DEPTH { cloud.kind } else { 0 };
            }
        }
        band.touched[range.start / TILE..range.end.div_ceil(TILE)].fill(true);
    }
    if deepest > 0.0 {
        attenuate(deepest, depths, &mut band.values[at..at + band.columns]);
    }
}

/// Optical depth that attenuates by the mask's threshold: -ln(1 - 0.005).
const VISIBLE_DEPTH: f32 = 0.005_012_542;

#[inline(always)]
fn multiply(band: &mut Band<'_>, at: usize, factors: &[f32], kind: u8) {
    let range = at..at + factors.len();
    for (v, f) in band.values[range.clone()].iter_mut().zip(factors) {
        *v *= f;
    }
    if let Some(mask) = &mut band.mask {
        for (m, f) in mask[range].iter_mut().zip(factors) {
            *m |= if (f - 1.0).abs() > THRESHOLD { kind } else { 0 };
        }
    }
}

/// Marks the tiles in which a factor is not 1.
#[inline(always)]
fn touch(touched: &mut [bool], from: usize, factors: &[f32]) {
    let mut column = from;
    let mut rest = factors;
    while !rest.is_empty() {
        let (here, after) = rest.split_at((TILE - column % TILE).min(rest.len()));
        touched[column / TILE] |= here.iter().any(|f| *f != 1.0);
        column += here.len();
        rest = after;
    }
}

/// A shade with its extent on the map and its tables.
struct Ready<'a> {
    shade: &'a Shade,
    kind: u8,
    first: [f64; 2],
    rows: std::ops::Range<i64>,
    columns: std::ops::Range<i64>,
    /// Clouds: Gaussian over the columns. Discs: factor over the radius.
    table: Vec<f32>,
}

impl<'a> Ready<'a> {
    fn new(kind: u8, shade: &'a Shade, first: [f64; 2]) -> Self {
        let ([low_row, low_column], [high_row, high_column]) = shade.extent();
        let span =
            |low: f64, high: f64, first: f64| (low - first).floor() as i64..(high - first).ceil() as i64 + 1;
        let (rows, columns) = (span(low_row, high_row, first[0]), span(low_column, high_column, first[1]));
        let table = match shade {
            Shade::Cloud { at, sigma, .. } => columns
                .clone()
                .map(|c| (-0.5 * ((c as f64 + first[1] - at[1]) / sigma).powi(2)).exp() as f32)
                .collect(),
            Shade::Disc { radius, clear, opacity, blur, .. } => {
                let factor = |r: f64| 1.0 - opacity * (disc(r, *radius, *blur) - disc(r, *clear, *blur));
                let count = ((radius + blur) * PER_PIXEL).ceil() as usize + 2;
                (0..count).map(|i| factor(i as f64 / PER_PIXEL) as f32).collect()
            }
            Shade::Polygon { .. } | Shade::Line { .. } => Vec::new(),
        };
        Self { shade, kind, first, rows, columns, table }
    }
}

impl Shade {
    /// Smallest and largest row and column that it affects.
    fn extent(&self) -> ([f64; 2], [f64; 2]) {
        let around =
            |at: &[f64; 2], reach: f64| ([at[0] - reach, at[1] - reach], [at[0] + reach, at[1] + reach]);
        match self {
            Self::Cloud { at, sigma, .. } => around(at, CLOUD_REACH * sigma),
            Self::Disc { at, radius, blur, .. } => around(at, radius + blur),
            Self::Polygon { corners, blur } => hull(corners, *blur),
            Self::Line { from, to, width, blur, .. } => hull(&[*from, *to], 0.5 * width + blur),
        }
    }
}

fn hull(points: &[[f64; 2]], margin: f64) -> ([f64; 2], [f64; 2]) {
    let least = |axis: usize| points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - margin;
    let most = |axis: usize| points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + margin;
    ([least(0), least(1)], [most(0), most(1)])
}

impl Ready<'_> {
    /// Factors of a row's pixels from `column` on, all within its extent and the map; a cloud's
    /// come from [`mist`].
    #[inline(always)]
    fn fill(&self, row: i64, column: i64, out: &mut [f32]) {
        let (y, x) = (row as f64 + self.first[0], column as f64 + self.first[1]);
        match self.shade {
            Shade::Cloud { .. } => out.fill(1.0),
            Shade::Disc { at, .. } => {
                let across2 = (y - at[0]).powi(2) as f32;
                let from = (x - at[1]) as f32;
                for (i, f) in out.iter_mut().enumerate() {
                    let along = from + i as f32;
                    let place = (across2 + along * along).sqrt() * PER_PIXEL as f32;
                    let k = (place as i32 as usize).min(self.table.len() - 2);
                    let t = (place - k as f32).min(1.0);
                    *f = self.table[k] + t * (self.table[k + 1] - self.table[k]);
                }
            }
            Shade::Polygon { corners, blur } => {
                for (i, f) in out.iter_mut().enumerate() {
                    *f = (1.0 - half_plane(into_polygon([y, x + i as f64], corners), *blur)) as f32;
                }
            }
            Shade::Line { from, to, width, opacity, blur } => {
                let length = (to[0] - from[0]).hypot(to[1] - from[1]).max(f64::MIN_POSITIVE);
                let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
                for (i, f) in out.iter_mut().enumerate() {
                    let p = [y - from[0], x + i as f64 - from[1]];
                    let shade = line(p[0] * along[1] - p[1] * along[0], *width, *blur);
                    let s = p[0] * along[0] + p[1] * along[1];
                    let ends =
                        if shade == 0.0 { 0.0 } else { half_plane(s, *blur) * half_plane(length - s, *blur) };
                    *f = (1.0 - opacity * shade * ends) as f32;
                }
            }
        }
    }
}

/// Multiplies by exp(-depth), every depth at most `deepest`: the depth is halved until five terms
/// suffice, then the result is squared as often.
#[inline(always)]
fn attenuate(deepest: f64, depths: &mut [f32], out: &mut [f32]) {
    let halvings = (deepest / SHALLOW).log2().ceil().clamp(0.0, 20.0) as i32;
    let scale = -(0.5f64.powi(halvings)) as f32;
    for f in &mut *depths {
        let t = scale * *f;
        *f = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * (1.0 / 24.0 + t * (1.0 / 120.0)))));
    }
    for _ in 0..halvings {
        for f in &mut *depths {
            *f *= *f;
        }
    }
    for (v, f) in out.iter_mut().zip(depths) {
        *v *= *f;
    }
}
