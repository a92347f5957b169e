//! What a frame shows of an edge: grey values of all columns over their distance from a smooth
//! line through the edge, in bins.

use crate::frame::FrameView;
use crate::gauge::{Edge, FrameEdges};

/// Rows either side of the edge that are taken: λ/NA is 1 to 3 px, and rings fade within five.
const HALF_PX: f64 = 14.0;

/// Bins a pixel: within one, the light over the steepest edge bends by less than 1e-4.
const BINS_A_PX: f64 = 16.0;

/// Fewest columns of an edge.
const LEAST_COLUMNS: usize = 32;

/// An edge of a master.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MasterProfile {
    /// Diameter of the master, mm.
    pub(super) diameter_mm: f64,
    /// Distance of its axis towards the camera from the plane of the others, mm.
    pub(super) y_mm: f64,
    pub(super) samples: Vec<ProfileSample>,
}

/// The mean of a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProfileSample {
    /// Distance of the pixels' centres into the light, px.
    pub(super) d_px: f64,
    /// Their light, 0 in the shadow and 1 in the bright field.
    pub(super) light: f64,
    /// One over its variance.
    pub(super) weight: f64,
}

/// Both edges of a frame, without those that are refused in most columns.
pub(super) fn profiles(
    view: &FrameView<'_>,
    edges: &FrameEdges,
    (diameter_mm, y_mm): (f64, f64),
) -> Vec<MasterProfile> {
    [(&edges.top, -1.0), (&edges.bottom, 1.0)]
        .into_iter()
        .enumerate()
        .filter_map(|(side, (line, sign))| {
            let [c0, c1, c2] = parabola(line)?;
            let at = |column: usize| {
                let x = abscissa(column, line.len());
                c0 + x * (c1 + x * c2)
            };
            let samples = binned(view, &at, sign, &Levels::of(edges, side));
            (!samples.is_empty()).then_some(MasterProfile { diameter_mm, y_mm, samples })
        })
        .collect()
}

/// Levels of one side.
struct Levels {
    dark: f64,
    contrast: f64,
    /// Variances in the dark and in the light, counts².
    variance: [f64; 2],
}

impl Levels {
    fn of(edges: &FrameEdges, side: usize) -> Self {
        let figures = &edges.figures;
        let (dark, light) = (figures.dark[side], figures.light[side]);
        // Rounding to whole counts is noise beside whatever the frame has of its own.
        let variance = figures.noise.map(|n| n * n + 1.0 / 12.0);
        Self { dark, contrast: light - dark, variance }
    }

    /// Variance of a pixel's share of the light.
    fn variance_at(&self, light: f64) -> f64 {
        let [dark, bright] = self.variance;
        (dark + (bright - dark) * light.clamp(0.0, 1.0)) / (self.contrast * self.contrast)
    }
}

/// Sums of a bin: distance, light, pixels.
type Bin = (f64, f64, f64);

fn binned(
    view: &FrameView<'_>,
    line: &dyn Fn(usize) -> f64,
    sign: f64,
    levels: &Levels,
) -> Vec<ProfileSample> {
    let mut bins: Vec<Bin> = vec![(0.0, 0.0, 0.0); (2.0 * HALF_PX * BINS_A_PX) as usize];
    for column in 0..view.columns() {
        let edge = line(column);
        let first = (edge - HALF_PX).ceil().max(0.0) as usize;
        let last = ((edge + HALF_PX).floor().max(0.0) as usize).min(view.rows().saturating_sub(1));
        for row in first..=last {
            let Some(counts) = view.get(row, column) else { continue };
            let d = sign * (row as f64 - edge);
            let Some(bin) = bins.get_mut(((d + HALF_PX) * BINS_A_PX) as usize) else { continue };
            let light = (f64::from(counts) - levels.dark) / levels.contrast;
            *bin = (bin.0 + d, bin.1 + light, bin.2 + 1.0);
        }
    }
    let filled = bins.into_iter().filter(|bin| bin.2 > 0.0);
    filled
        .map(|(d, light, n)| {
            let light = light / n;
            ProfileSample { d_px: d / n, light, weight: n / levels.variance_at(light) }
        })
        .collect()
}

/// A column from −1 to 1 over the frame.
fn abscissa(column: usize, columns: usize) -> f64 {
    2.0 * column as f64 / (columns.max(2) - 1) as f64 - 1.0
}

/// The parabola through an edge's usable columns by least squares: a straight pin, through a lens
/// that bends it a little.
fn parabola(line: &[Edge]) -> Option<[f64; 3]> {
    let usable = line.iter().enumerate().filter(|(_, e)| e.is_usable() && e.row_px.is_finite());
    let points: Vec<(f64, f64)> =
        usable.map(|(column, e)| (abscissa(column, line.len()), e.row_px)).collect();
    if points.len() < LEAST_COLUMNS.max(line.len() / 2) {
        return None;
    }
    let (mut normal, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for (x, row) in points {
        let by = nalgebra::Vector3::new(1.0, x, x * x);
        normal += by * by.transpose();
        right += by * row;
    }
    let c = normal.try_inverse()? * right;
    Some([c[0], c[1], c[2]])
}
