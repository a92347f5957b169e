//! Lays shades over the pixels: row by row, tabulated where a shade is round.

use super::map::{Thing, TransmissionMap};
use super::shapes::{disc, half_plane, into_polygon, line};

/// Reach of a cloud, standard deviations: its edge takes away less than 1e-5 at τ = 1.
pub(super) const CLOUD_REACH: f64 = 4.8;

/// Entries of a round shade's table a pixel; linear between them, which errs by less than 1e-3 at a sharp border.
const PER_PIXEL: f64 = 8.0;

/// Depth for which five terms of the exponential's series do in f32.
const SHALLOW: f64 = 0.125;

/// One thing in the beam, in pixels of the full sensor, points as (row, column).
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shade {
    /// Optical depth and standard deviation.
    Cloud { at: [f64; 2], depth: f64, sigma: f64 },
    /// Dark disc with a clear one in its middle.
    Disc { at: [f64; 2], radius: f64, clear: f64, opacity: f64, blur: f64 },
    /// Opaque polygon.
    Polygon { corners: Vec<[f64; 2]>, blur: f64 },
    /// From one end to the other.
    Line { from: [f64; 2], to: [f64; 2], width: f64, opacity: f64, blur: f64 },
}

/// Lays all shades over a map whose first pixel is `first` on the sensor.
pub(super) fn lay_all(shades: &[(u8, Shade)], first: [usize; 2], map: &mut TransmissionMap) {
    let first = [first[0] as f64, first[1] as f64];
    let things: Vec<Ready<'_>> = shades.iter().map(|(kind, shade)| Ready::new(*kind, shade, first)).collect();
    map.lay(&things);
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
    /// Smallest and largest row and column it touches.
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

impl Thing for Ready<'_> {
    fn kind(&self) -> u8 {
        self.kind
    }

    fn rows(&self) -> std::ops::Range<i64> {
        self.rows.clone()
    }

    fn columns(&self) -> std::ops::Range<i64> {
        self.columns.clone()
    }

    fn fill(&self, row: i64, column: i64, out: &mut [f32]) {
        let (y, x) = (row as f64 + self.first[0], column as f64 + self.first[1]);
        match self.shade {
            Shade::Cloud { at, depth, sigma } => {
                let start = (column - self.columns.start) as usize;
                let here = depth * (-0.5 * ((y - at[0]) / sigma).powi(2)).exp();
                attenuate(here, &self.table[start..start + out.len()], out);
            }
            Shade::Disc { at, .. } => {
                let across2 = (y - at[0]).powi(2) as f32;
                let from = (x - at[1]) as f32;
                for (i, f) in out.iter_mut().enumerate() {
                    let along = from + i as f32;
                    let place = (across2 + along * along).sqrt() * PER_PIXEL as f32;
                    let k = (place as usize).min(self.table.len() - 2);
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

/// exp(-depth·g) by five terms at a depth halved until it is shallow, then squared as often.
fn attenuate(depth: f64, gaussian: &[f32], out: &mut [f32]) {
    let halvings = (depth / SHALLOW).log2().ceil().clamp(0.0, 20.0) as i32;
    let scale = (-depth * 0.5f64.powi(halvings)) as f32;
    for (f, g) in out.iter_mut().zip(gaussian) {
        let t = scale * g;
        *f = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * (1.0 / 24.0 + t / 120.0))));
    }
    for _ in 0..halvings {
        for f in out.iter_mut() {
            *f *= *f;
        }
    }
}
