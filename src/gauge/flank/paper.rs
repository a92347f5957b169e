//! Flank wear by the way of paper 004, for comparison: threshold and morphology make the bright
//! land one region, Canny finds its borders, a straight line S is fitted to the upper one, and the
//! distances D_i of the lower one from S are averaged. It is made for bright lands alone.

use glam::DVec2;
use image::{GrayImage, Luma};
use imageproc::contrast::{ThresholdType, otsu_level, threshold};
use imageproc::distance_transform::Norm;
use imageproc::edges::canny;
use imageproc::morphology::{close, open};

use super::error::FlankError;
use super::located::{KnownEdge, Located, locate};
use super::raster::Raster;
use super::settings::FlankSide;
use crate::frame::FrameView;
use crate::gauge::limit::limits;

limits! {
    /// How the paper's way finds a land; the paper states none of these.
    PaperFlankLimits = "paper_flank";
    /// Radius of closing, rows of the strip: streaks of a land are some micrometres apart.
    close_rows: usize = 4;
    /// Radius of opening, rows: sparkles of a ground flank are facets of 5 µm.
    open_rows: usize = 2;
    /// Lower threshold of Canny's hysteresis on the region's image, in Sobel's units: a third of
    /// the upper one (J. Canny, 1986: two to three times less).
    canny_low: f64 = 50.0;
    /// Upper threshold: a border between 0 and 255 has 400 after the detector's Gaussian.
    canny_high: f64 = 150.0;
    /// Depth below the reference within which a land begins, µm. Tuned: see tests of flanks.
    begins_um: f64 = 30.0;
    /// Least share of the columns that must show a land. Tuned: see tests of flanks.
    least_share: f64 = 0.1;
}

/// Mean and largest distance, µm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaperFlank {
    /// Mean of D_i.
    pub vb_um: f64,
    /// Largest of D_i.
    pub vb_max_um: f64,
    /// Length of the columns that show a land, µm.
    pub worn_length_um: f64,
    /// Line and border in the image, a pair a column with a land: (column, row), px.
    pub places: Vec<[DVec2; 2]>,
}

/// Measures a flank by the paper's way.
///
/// # Errors
/// No flank, or two borders that could be its edge; no bright region below the edge.
pub(crate) fn measure_paper_flank(
    view: &FrameView<'_>,
    um_per_px: f64,
    side: FlankSide,
) -> Result<PaperFlank, FlankError> {
    let limits = PaperFlankLimits::get();
    let flank = locate(&Raster::of(view)?, um_per_px, KnownEdge { side, shape: None })?;
    flank.certain()?;
    let edges = borders(&flank);
    let row_um = flank.frame.row_um();
    let begins = flank.frame.above + (limits.begins_um / row_um) as usize;
    let pairs: Vec<(usize, usize, usize)> = (0..flank.strip.columns)
        .filter_map(|column| {
            let mut on = (0..flank.strip.rows).filter(|r| edges.get_pixel(column as u32, *r as u32).0[0] > 0);
            let first = on.find(|r| *r + flank.frame.above / 2 > flank.frame.above)?;
            let last = on.find(|r| *r > first + 2)?;
            (first <= begins).then_some((column, first, last))
        })
        .collect();
    if (pairs.len() as f64) < limits.least_share * flank.strip.columns as f64 {
        let why = format!("a bright land stands below {} of {} columns", pairs.len(), flank.strip.columns);
        return Err(FlankError::NoFlank { why });
    }
    let (a, b) = straight(&pairs);
    let distances: Vec<f64> =
        pairs.iter().map(|(c, _, last)| (*last as f64 - a - b * *c as f64).max(0.0) * row_um).collect();
    let places = pairs.iter().zip(&distances).map(|((c, _, _), d)| {
        let line_um = flank.frame.depth_um(0) + (a + b * *c as f64) * row_um;
        [line_um, line_um + d].map(|depth| flank.frame.place(*c as f64, depth))
    });
    Ok(PaperFlank {
        vb_um: distances.iter().sum::<f64>() / distances.len() as f64,
        vb_max_um: distances.iter().copied().fold(0.0, f64::max),
        worn_length_um: pairs.len() as f64 * flank.frame.column_um(),
        places: places.collect(),
    })
}

/// Canny's edges of the bright regions after closing and opening.
fn borders(flank: &Located) -> GrayImage {
    let limits = PaperFlankLimits::get();
    let (low, high) = (flank.strip.quantile(0.01, 3), flank.strip.quantile(0.99, 3));
    let grey = |v: f32| (255.0 * (v - low) / (high - low).max(1e-6)).clamp(0.0, 255.0) as u8;
    let image = GrayImage::from_fn(flank.strip.columns as u32, flank.strip.rows as u32, |c, r| {
        Luma([grey(flank.strip.at(r as usize, c as usize))])
    });
    let bright = threshold(&image, otsu_level(&image), ThresholdType::Binary);
    let closed = close(&bright, Norm::LInf, limits.close_rows.min(255) as u8);
    let region = open(&closed, Norm::LInf, limits.open_rows.min(255) as u8);
    let low = limits.canny_low.min(limits.canny_high);
    canny(&region, low as f32, limits.canny_high as f32)
}

/// Least-squares line through the upper border: row at column 0, rows a column.
fn straight(pairs: &[(usize, usize, usize)]) -> (f64, f64) {
    let n = pairs.len() as f64;
    let (mut x, mut y) = (0.0, 0.0);
    pairs.iter().for_each(|p| {
        x += p.0 as f64 / n;
        y += p.1 as f64 / n;
    });
    let (mut xx, mut xy) = (0.0, 0.0);
    pairs.iter().for_each(|p| {
        xx += (p.0 as f64 - x).powi(2);
        xy += (p.0 as f64 - x) * (p.1 as f64 - y);
    });
    let b = if xx > 0.0 { xy / xx } else { 0.0 };
    (y - b * x, b)
}
