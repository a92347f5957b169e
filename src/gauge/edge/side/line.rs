//! The edges of one side: every column fitted, then tested by residual and neighbours.

use super::buffers::{FitBuffers, SideBuffers};
use super::levels::SideLevels;
use super::model::EdgeModel;
use super::scan::ScanWindows;
use super::tables::{TableCache, TableKey, TableLimits};
use crate::gauge::edge::estimation::blur::{BlurEstimate, BlurLimits};
use crate::gauge::edge::estimation::blur_track::{BlurTrack, Change, Placed, TrackView};
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::censored_fit::side_fit::{self, ClippedStart};
use crate::gauge::edge::estimation::column_fit::{ColumnJob, score_columns};
use crate::gauge::edge::estimation::model_bias::{Expected, ExpectedTest};
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::rejection::{neighbour_test, residual_test};
use crate::gauge::edges::{Edge, RESIDUAL_BLOCK};
use crate::gauge::settings::{Blur, GaugeSettings, Levels, Rejection};
use crate::numerics::distributions::{chi2_ratio_limit, upper_normal_quantile};

/// What a side's edges are fitted by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineFit<'a> {
    pub(crate) settings: &'a GaugeSettings,
    pub(crate) noise: &'a NoiseModel,
    /// Where the side's grey values are clipped.
    pub(crate) ends: Option<Ends>,
    /// What the calibration's masters left of the edge model at this side.
    pub(crate) expected: Option<&'a Expected>,
    /// Whether columns are readings one after the other.
    pub(crate) level_lines: bool,
    /// Whether the edges are also to show a change of the blur.
    pub(crate) follows_blur: bool,
}

/// What the fit of a side works on, and where its edges are written.
pub(crate) struct LineWork<'a> {
    pub(crate) side: &'a mut SideBuffers,
    pub(crate) model: &'a mut EdgeModel,
    pub(crate) tables: &'a mut TableCache,
    pub(crate) edges: &'a mut Vec<Edge>,
    /// Standard uncertainty by a systematic residual of the edge model, px, one for every block of
    /// columns.
    pub(crate) model_uncertainty_px: &'a mut Vec<f32>,
}

/// What the fit of a side states beside its edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeLine {
    /// Median residual.
    pub(crate) reduced_chi2: f64,
    /// Largest step between neighbouring edges, px; infinite with gaps.
    pub(crate) jump: f64,
    /// Standard uncertainty of an edge by what is clipped of its shape, px.
    pub(crate) clipped_px: f64,
    /// What the edges show of the blur.
    pub(crate) shown: BlurTrack,
}

/// Columns fitted, not yet tested.
struct Fitted {
    /// Degrees of freedom to test residuals with.
    freedom: f64,
    /// Standard uncertainty left of an expected systematic residual, px.
    left_px: f64,
    clipped_px: f64,
    shown: BlurTrack,
    /// Whether the edges have rings.
    is_ringed: bool,
}

/// One side at its fit.
struct SideFit<'a> {
    by: &'a LineFit<'a>,
    scan: &'a ScanWindows,
    tables: &'a mut TableCache,
    buffers: &'a mut FitBuffers,
}

/// Fits all columns of a side, then tests residuals and neighbours. Clipped levels and their blur
/// are fitted along with the edges and replace those given.
pub(crate) fn edge_line(by: &LineFit<'_>, work: LineWork<'_>) -> EdgeLine {
    let LineWork { side, model, tables, edges: line, model_uncertainty_px: stated } = work;
    let SideBuffers { scan, levels, fit: buffers, rows, .. } = side;
    let columns = scan.windows.centre.len();
    buffers.outliers.reserve(columns);
    stated.reserve(columns.div_ceil(RESIDUAL_BLOCK).saturating_sub(stated.len()));
    line.clear();
    let mut fit = SideFit { by, scan: &*scan, tables, buffers: &mut *buffers };
    let fitted = match by.ends {
        Some(ends) => fit.clipped(ends, model, levels, line),
        None => fit.columns(model, levels, line),
    };
    let reduced_chi2 = by.reject(&fitted, buffers, line, stated);
    let jump = neighbour_test::largest_jump(line);
    if jump.is_finite() {
        rows.clear();
        rows.extend(line.iter().map(|edge| Ok((edge.row_px + 0.5) as i32)));
    }
    EdgeLine { reduced_chi2, jump, clipped_px: fitted.clipped_px, shown: fitted.shown }
}

impl LineFit<'_> {
    /// The fit of no column.
    fn nothing_yet(&self, model: &EdgeModel) -> Fitted {
        let shown = BlurTrack::begin(self.follows_blur);
        Fitted { freedom: 1.0, left_px: 0.0, clipped_px: 0.0, shown, is_ringed: model.shape.is_ringed() }
    }

    /// Tests residuals and neighbours, and states what the edge model leaves; gives the median
    /// residual.
    fn reject(
        &self,
        fitted: &Fitted,
        buffers: &mut FitBuffers,
        line: &mut [Edge],
        stated: &mut Vec<f32>,
    ) -> f64 {
        let (settings, freedom) = (self.settings, fitted.freedom);
        let z = upper_normal_quantile(settings.residual_false_alarm);
        let mut reduced_chi2 = residual_test::reduced_chi2(line, freedom, &mut buffers.floats);
        let scale = if reduced_chi2 > 1.2 { reduced_chi2 } else { 1.0 };
        if settings.rejection != Rejection::Off {
            residual_test::refuse_residuals(line, (chi2_ratio_limit(freedom, z) * scale) as f32);
        }
        // Readings one after the other: neighbours of an area camera differ by noise and form
        // alone.
        let is_readings = self.level_lines && fitted.is_ringed;
        if is_readings && reduced_chi2 < residual_test::ResidualLimits::get().most_noise {
            residual_test::take_noise_back(line, reduced_chi2);
            reduced_chi2 = 1.0;
        }
        residual_test::add_model_uncertainty(line, freedom, fitted.left_px, stated);
        if scale > 1.0 {
            for edge in line.iter_mut() {
                edge.u_own_px *= (scale as f32).sqrt();
            }
        }
        if settings.rejection == Rejection::Off {
            return reduced_chi2;
        }
        residual_test::reject_uncertain(line);
        neighbour_test::refuse_outliers(line, settings.outlier_px, &mut buffers.outliers);
        reduced_chi2
    }
}

impl SideFit<'_> {
    /// Fits a side whose light or shadow is clipped, with its levels and its blur.
    fn clipped(
        &mut self,
        ends: Ends,
        model: &mut EdgeModel,
        levels: &mut SideLevels,
        line: &mut Vec<Edge>,
    ) -> Fitted {
        let (noise, scan) = (self.by.noise, self.scan);
        let start = ClippedStart {
            shape: &model.shape,
            levels: [&levels.dark, &levels.light],
            sigma: model.blur.mean(),
            sigma_is_given: matches!(self.by.settings.blur, Blur::Given { .. }),
            variance: [noise.variance(levels.dark.mean), noise.variance(levels.light.mean)],
            floor: noise.floor(),
            ends,
        };
        let fitted = Fitted { freedom: 4.0, ..self.by.nothing_yet(model) };
        let Some(side) = side_fit::fit_side(&scan.windows, &scan.slope, &start, line) else { return fitted };
        model.blur = BlurEstimate::uniform(side.sigma);
        // Blur and shape are shared by all columns.
        let length = line.len() as f32;
        for (curve, level) in [&mut levels.dark, &mut levels.light].into_iter().zip(side.levels) {
            curve.mean = level.iter().map(|l| f64::from(*l)).sum::<f64>() / level.len().max(1) as f64;
            curve.level = level;
            curve.length = length;
        }
        if !ends.high.is_finite() {
            let kappa = noise.kappa(levels.dark.mean, levels.light.mean);
            let width = scan.windows.width;
            let table = self.tables.find(TableKey { sigma: side.sigma, kappa, width, free_levels: false });
            scan.gradient.state(line, &scan.windows, (&levels.dark, &levels.light), (noise, table));
        }
        Fitted { freedom: side.freedom, clipped_px: side.u_px, ..fitted }
    }

    /// Fits every column by itself.
    fn columns(&mut self, model: &EdgeModel, levels: &SideLevels, line: &mut Vec<Edge>) -> Fitted {
        let (noise, settings, scan) = (self.by.noise, self.by.settings, self.scan);
        let (windows, SideLevels { dark, light }) = (&scan.windows, levels);
        let (columns, width) = (windows.centre.len(), windows.width);
        let kappa = noise.kappa(dark.mean, light.mean);
        let free_levels = matches!(settings.levels, Levels::PerColumn {});
        let (shadow, contrast) = own_shadow(scan, levels, &mut self.buffers.floats);
        let normalised = &mut self.buffers.normalised;
        normalised.resize(width, 0.0);
        let mut expected = self.by.expected.map(Expected::test);
        let level_slope = BlurLimits::get().level_slope;
        let is_level = scan.slope.iter().all(|slope| slope.abs() < level_slope);
        let mut from = 0;
        let mut fitted = self.by.nothing_yet(model);
        while from < columns {
            let sigma = model.sigma_at(scan, from);
            let to = if is_level {
                model.blur.end_of_run(from, columns)
            } else {
                end_of_sloped_run(model, scan, from, sigma)
            };
            let table = self.tables.find(TableKey { sigma, kappa, width, free_levels });
            fitted.freedom = f64::from(table.freedom);
            let job = ColumnJob {
                windows,
                dark,
                light,
                noise,
                table,
                blur_shift: (sigma - table.sigma) as f32,
                min_snr: settings.min_snr as f32,
                reject: settings.rejection != Rejection::Off,
                shadow,
                contrast,
            };
            score_columns(&job, from..to, normalised, line);
            fitted.shown.add(&job, from..to, Placed { line, slope: &scan.slope });
            if let Some(expected) = &mut expected {
                expected.judge(&job, from..to, normalised, line);
            }
            from = to;
            if from >= columns {
                scan.gradient.state(line, windows, (dark, light), (noise, table));
            }
        }
        fitted.left_px = expected.as_ref().map_or(0.0, ExpectedTest::left_px);
        fitted
    }
}

/// Level of the shadow that a quarter of the columns stays below, and the contrast to the mean
/// light.
fn own_shadow(scan: &ScanWindows, levels: &SideLevels, floats: &mut Vec<f32>) -> (f32, f32) {
    let dark = &scan.windows.dark;
    floats.clear();
    let step = dark.len().div_ceil(256).max(1);
    floats.extend(dark.iter().step_by(step).filter(|d| d.is_finite()));
    if floats.is_empty() {
        return (f32::NEG_INFINITY, f32::INFINITY);
    }
    let quarter = floats.len() / 4;
    let shadow = *floats.select_nth_unstable_by(quarter, f32::total_cmp).1;
    (shadow, levels.light.mean as f32 - shadow)
}

/// End of the columns from `from` on that share a blur along the column, on an edge with a slope.
fn end_of_sloped_run(model: &EdgeModel, scan: &ScanWindows, from: usize, sigma: f64) -> usize {
    let (columns, same_blur) = (scan.windows.centre.len(), TableLimits::get().same_blur);
    (from + 1..columns)
        .find(|c| (model.sigma_at(scan, *c) - sigma).abs() >= same_blur * sigma)
        .unwrap_or(columns)
}

/// Gives the edges just fitted the frame's own blur: moves them by its change, or states that they
/// are to be fitted anew.
pub(crate) fn follow_blur(
    by: &LineFit<'_>,
    line: &EdgeLine,
    (side, tables): (&SideBuffers, &mut TableCache),
    model: &mut EdgeModel,
    edges: &mut [Edge],
) -> Change {
    let (dark, light) = (side.levels.dark.mean, side.levels.light.mean);
    let relative =
        by.noise.variance(0.5 * (dark + light)) / (light - dark).powi(2) * line.reduced_chi2.max(1.0);
    let (windows, kappa) = (&side.scan.windows, by.noise.kappa(dark, light));
    let (sigma, width) = (model.blur.mean(), windows.width);
    let table = tables.find(TableKey { sigma, kappa, width, free_levels: false });
    let is_ringed = model.shape.is_ringed();
    let view = TrackView { windows, table, level_lines: by.level_lines, is_ringed };
    let change = line.shown.follow(&mut model.blur, relative, &view, edges);
    model.blur.limit(model.shape.least_sigma());
    change
}
