//! One side of the shadow in one frame: windows, levels, blur, edges. Both sides are worked on at
//! the same time.

use super::estimation::censored_fit::side_fit::{self, ClippedStart};
use super::estimation::side_survey::{GreyScaleLimits, SideSurvey};
use super::image::window_layout::{half, window_width};
use super::model::systematic_residual::SystematicResidual;
use super::rejection::neighbour_test;
use super::side_parts::{ColumnKind, SideFigures, TableLimits, Workspace};
use crate::gauge::edge::estimation::blur::{self, BlurContext, BlurEstimate, BlurLimits};
use crate::gauge::edge::estimation::blur_track::{BlurTrack, Change, Placed, TrackView};
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::column_fit::{ColumnJob, score_columns};
use crate::gauge::edge::estimation::grey_ends::{self, Elsewhere};
use crate::gauge::edge::estimation::level_gradient::LevelGradient;
use crate::gauge::edge::estimation::levels::LevelCurve;
use crate::gauge::edge::estimation::model_bias::{Expected, ResidualAccumulator, SideView};
use crate::gauge::edge::estimation::noise::{NoiseModel, Spread};
use crate::gauge::edge::estimation::scoring_table::{ScoringTableLimits, Table, Tabulation};
use crate::gauge::edge::estimation::slanted_edge::{self, EsfSamples};
use crate::gauge::edge::estimation::soft_knee;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::scan_windows::{LevelSums, Side, Windows, slopes};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::rejection::residual_test;
use crate::gauge::edges::{Edge, RESIDUAL_BLOCK};
use crate::gauge::limit::limits;
use crate::gauge::settings::{Blur, GaugeSettings, Levels, Rejection};
use crate::numerics::distributions::{chi2_ratio_limit, upper_normal_quantile};
use crate::profile::Reason;

limits! {
    /// What one side of the silhouette samples, and which blurs are the same.
    SideLimits = "side";
    /// Differences looked at per level for the noise: its variance is then known to 3 %.
    noise_samples: usize = 4096;
    /// Relative difference of blurs that share a table: weights that are off by so little cost
    /// nothing in u (it is stationary in them) and move no edge, whose score is odd about it.
    same_blur: f64 = 0.004;
    /// The same under rings, where blur scales the pattern and moves an edge by 12 px of itself:
    /// 0.001 px.
    same_rings: f64 = 1e-4;
}

/// Track, settings and memory of one side.
#[derive(Clone, Debug)]
pub(crate) struct SideState {
    pub(crate) windows: Windows,
    pub(crate) slope: Vec<f32>,
    pub(crate) dark: LevelCurve,
    pub(crate) light: LevelCurve,
    pub(crate) blur: BlurEstimate,
    /// How the blur goes on from frame to frame.
    pub(crate) track: BlurTrack,
    gradient: LevelGradient,
    /// What the calibration's masters left of the edge model.
    expected: Option<Expected>,
    /// The edge-spread function fitted.
    pub(crate) shape: EdgeSpreadFunction,
    pub(crate) figures: SideFigures,
    pub(crate) kind: ColumnKind,
    work: Workspace,
}

impl SideState {
    pub(crate) fn new(side: Side) -> Self {
        Self {
            windows: Windows::new(side),
            slope: Vec::new(),
            dark: LevelCurve::default(),
            light: LevelCurve::default(),
            blur: BlurEstimate::uniform(1.0),
            track: BlurTrack::default(),
            gradient: LevelGradient::default(),
            expected: None,
            shape: EdgeSpreadFunction::Gaussian,
            figures: SideFigures::default(),
            kind: ColumnKind::default(),
            work: Workspace::default(),
        }
    }

    pub(crate) fn forget(&mut self) {
        self.work.tables.clear();
    }

    /// Takes another edge-spread function.
    pub(crate) fn set_shape(&mut self, shape: EdgeSpreadFunction) {
        if self.shape != shape {
            self.shape = shape;
            self.work.tables.clear();
        }
    }

    /// Expects what a calibration's masters left of the edge model at this side (0 above, 1 below).
    pub(crate) fn expect(&mut self, reduced_chi2: Option<&SystematicResidual>, side: usize) {
        self.expected = reduced_chi2.map(|m| Expected::new(m, side));
    }

    /// Adds what the frame's edges leave of the model to `residuals`; clipped light adds nothing.
    pub(crate) fn accumulate(&self, residuals: &mut ResidualAccumulator, side: usize, line: &[Edge]) {
        if self.figures.survey.ends.is_none() {
            let (windows, shape, slope) = (&self.windows, &self.shape, &self.slope[..]);
            let view = SideView { windows, shape, dark: &self.dark, light: &self.light, slope };
            residuals.add(side, &view, line, |column| self.sigma_at(column));
        }
    }

    /// Width of the windows for a blur.
    pub(crate) fn window_width(&self, sigma: f64) -> usize {
        window_width(&self.shape, sigma)
    }

    /// How far the geometric edge may lie from where a learnt edge-spread function puts it, px.
    pub(crate) fn position_ambiguity(&self) -> f64 {
        self.shape.position_ambiguity(self.blur.mean())
    }

    /// Estimates the edge-spread function from the positions in `line`; false where the frame does
    /// not determine it.
    pub(crate) fn learn(&mut self, line: &[Edge]) -> bool {
        let residuals = EsfSamples {
            windows: &self.windows,
            dark: &self.dark,
            light: &self.light,
            slope: &self.slope,
            sigma: self.blur.mean(),
        };
        let Some(table) = slanted_edge::learn(&residuals, line) else { return false };
        self.set_shape(EdgeSpreadFunction::Table(std::sync::Arc::new(table)));
        true
    }

    /// A first blur from wide windows on a few columns, and whether these see one edge alone;
    /// `None` where they do not fit the field.
    pub(crate) fn rough_blur<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        centres: &[CoarseEdge],
        widest: f64,
    ) -> Option<(f64, bool)> {
        let windows = &mut self.windows;
        windows.centre.clear();
        windows.centre.extend(blur::samples(centres.len()).map(|column| centres[column]));
        windows.centred = false;
        let gaussian = EdgeSpreadFunction::Gaussian;
        windows.prepare(&gaussian, widest, window_width(&gaussian, widest), windows.centre.len());
        for (place, column) in blur::samples(centres.len()).enumerate() {
            windows.read_one(plane, column, place);
        }
        let alone = blur::sees_one_edge(windows);
        blur::rough(windows, &mut self.work.floats).map(|sigma| (sigma, alone))
    }

    /// Reads all windows around `centres`; where they are only near, centres them and finds the
    /// slopes.
    pub(crate) fn read_windows<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        centres: &[CoarseEdge],
        sigma: f64,
        centring: Option<f64>,
    ) {
        let table_limits = TableLimits::get();
        self.windows.centre.clear();
        self.windows.centre.extend_from_slice(centres);
        self.windows.centred = centring.is_none();
        self.work.laid_out = sigma;
        self.work.most_table_bytes =
            (plane.rows * plane.columns).clamp(table_limits.least_bytes, table_limits.most_bytes);
        self.work.outliers.reserve(plane.columns);
        self.figures.model_uncertainty_px.reserve(
            plane.columns.div_ceil(RESIDUAL_BLOCK).saturating_sub(self.figures.model_uncertainty_px.len()),
        );
        self.read_width(plane, window_width(&self.shape, sigma));
        let Some(max_slope) = centring else { return };
        slopes(&self.windows, &mut self.slope);
        if self.kind.level_lines {
            self.slope.fill(0.0);
        }
        for (centre, slope) in self.windows.centre.iter_mut().zip(&self.slope) {
            if centre.is_ok() && !(f64::from(slope.abs()) <= max_slope) {
                *centre = Err(Reason::Steep);
            }
        }
    }

    /// Reads the windows anew around the edges in `line`. Where windows were centred by the area of
    /// their light, a pixel of noise far out moved the window that it lies in, so that the flat
    /// ends, chosen after a look at them, are no fair sample of the levels. A fitted edge owes
    /// nothing to the flat ends: centred on it they are.
    pub(crate) fn recentre<T: Sample>(&mut self, plane: &Plane<'_, T>, line: &[Edge]) {
        for (centre, edge) in self.windows.centre.iter_mut().zip(line).filter(|(_, e)| e.is_usable()) {
            *centre = Ok((edge.row_px + 0.5).floor() as i32);
        }
        self.windows.centred = true;
        self.read_width(plane, self.windows.width);
    }

    /// Reads windows of a width around their centres, and the light beyond them.
    fn read_width<T: Sample>(&mut self, plane: &Plane<'_, T>, width: usize) {
        self.windows.prepare(&self.shape, self.work.laid_out, width, plane.columns);
        self.windows.read(plane);
        // Rings are no light that falls off.
        if self.shape.is_ringed() {
            self.gradient.clear();
        } else {
            self.gradient.read(plane, &self.windows);
        }
    }

    /// What the windows state of levels and noise before the other side is known.
    pub(crate) fn survey(&mut self, scale: GreyScaleLimits, estimate_noise: bool) {
        let levels = self.windows.level_sums();
        let mut spread = [Spread::default(); 2];
        let least = scale.least((levels.light - levels.dark) / levels.count.max(1.0));
        if estimate_noise && levels.count > 0.0 {
            spread = [false, true].map(|in_light| self.spread(in_light, least));
        }
        let ends = if levels.count > 0.0 && !self.kind.copies {
            self.ends(scale, levels, spread, least)
        } else {
            None
        };
        // Clipped light states nothing of how it falls off; a clipped shadow leaves it as it is.
        if ends.is_none_or(|ends| !self.gradient.is_clipped(ends.low, ends.high)) {
            self.gradient.level(&mut self.windows, ends.map_or(f32::NEG_INFINITY, |ends| ends.low as f32));
        }
        match ends {
            // What is clipped does not scatter as it would.
            Some(Ends { high, .. }) if high.is_finite() => spread[1] = Spread::default(),
            Some(_) => spread[0] = Spread::default(),
            None => {}
        }
        self.figures.survey = SideSurvey { levels, ends, spread };
    }

    fn spread(&mut self, in_light: bool, least: f32) -> Spread {
        self.collect_differences(in_light);
        Spread::of(&self.work.differences, least)
    }

    /// Where the grey values of the side are clipped.
    fn ends(
        &mut self,
        scale: GreyScaleLimits,
        levels: LevelSums,
        spread: [Spread; 2],
        least: f32,
    ) -> Option<Ends> {
        use grey_ends::Level::{Dark, Light};
        let clear = |level, pool: &mut Vec<f32>| !grey_ends::may_end(&self.windows, level, pool);
        let mut floats = std::mem::take(&mut self.work.floats);
        // Compressed light scatters less than the dark; a glance, for most frames.
        let bends = matches!(spread.map(Spread::variance), [Some(dark), Some(light)] if light < dark);
        if clear(Light, &mut floats) & clear(Dark, &mut floats) && !bends {
            self.work.floats = floats;
            return None;
        }
        let noise = [false, true].map(|in_light| {
            let known = spread[usize::from(in_light)].variance();
            known.or_else(|| self.spread(in_light, least).variance()).map_or(f64::NAN, f64::sqrt)
        });
        let mean = [levels.dark, levels.light].map(|sum| sum / levels.count);
        let elsewhere = Elsewhere { noise, levels: mean, step: scale.step(), turned: self.kind.turned };
        let mut squares = std::mem::take(&mut self.work.differences);
        let mut find =
            |level| grey_ends::find_end(&self.windows, level, &elsewhere, (&mut floats, &mut squares));
        let (low, high) = (find(Dark), find(Light));
        let knee = soft_knee::find(&self.windows, high.map(|(end, _)| end), &elsewhere, &mut squares);
        (self.work.floats, self.work.differences) = (floats, squares);
        Ends::of(low, knee.or(high))
    }

    /// Differences of neighbouring columns' flat pixels, thinned to about half of
    /// `side.noise_samples`.
    fn collect_differences(&mut self, in_light: bool) {
        let (windows, out) = (&self.windows, &mut self.work.differences);
        let (columns, flat, width) = (windows.centre.len(), windows.flat, windows.width);
        let first = if in_light { width - 1 - flat } else { 0 };
        let step = (columns * flat).div_ceil(SideLimits::get().noise_samples / 2).max(2);
        out.resize(columns.div_ceil(step) * flat, 0.0);
        let mut places = out.chunks_exact_mut(flat);
        let mut taken = 0;
        for column in (0..columns.saturating_sub(1)).step_by(step) {
            if windows.centre[column].is_err() || windows.centre[column + 1].is_err() {
                continue;
            }
            let (a, b) = windows.pixels[column * width..(column + 2) * width].split_at(width);
            let Some(place) = places.next() else { break };
            for ((difference, a), b) in place.iter_mut().zip(&a[first..]).zip(&b[first..]) {
                *difference = a - b;
            }
            taken += flat;
        }
        out.truncate(taken);
    }

    /// Pools the levels along the shaft; false without a column.
    pub(crate) fn pool_levels(&mut self, noise: &NoiseModel, dark: f64, light: f64, levels: Levels) -> bool {
        let knots = match levels {
            Levels::Pooled { max_knots } => max_knots,
            Levels::PerColumn {} => 33,
        };
        let sd = |level: f64| (noise.variance(level) / self.windows.flat as f64).sqrt() as f32;
        let pooled = self.work.pool.pool(&self.windows.dark, sd(dark), knots, &mut self.dark)
            && self.work.pool.pool(&self.windows.light, sd(light), knots, &mut self.light);
        if pooled && self.shape != EdgeSpreadFunction::Gaussian {
            self.take_tails_off();
        }
        pooled
    }

    /// The flat ends of the windows still see a little of a long-tailed edge.
    fn take_tails_off(&mut self) {
        let windows = &self.windows;
        let (e_dark, e_light) =
            self.shape.flat_ends(self.work.laid_out, windows.width, windows.flat, half(windows.width));
        let span = (e_light - e_dark) as f32;
        for (dark, light) in self.dark.level.iter_mut().zip(&mut self.light.level) {
            let contrast = (*light - *dark) / span;
            *dark -= contrast * e_dark as f32;
            *light = *dark + contrast;
        }
        let contrast = (self.light.mean - self.dark.mean) / f64::from(span);
        self.dark.mean -= contrast * e_dark;
        self.light.mean = self.dark.mean + contrast;
    }

    /// Refines the blur from `start`, px.
    pub(crate) fn refine_blur(&mut self, noise: &NoiseModel, start: f64) {
        self.blur = self.refined_blur(noise, start, None);
    }

    /// Takes the blur anew from the columns that were not refused: what shades an edge is blurred
    /// otherwise. False where it does not change.
    pub(crate) fn settle_blur(&mut self, noise: &NoiseModel, line: &[Edge]) -> bool {
        let limits = SideLimits::get();
        let looked_for = self.windows.centre.iter().zip(line).filter(|(centre, _)| centre.is_ok());
        let refused = looked_for.filter(|(_, edge)| !edge.is_usable()).count();
        if refused <= line.len() / 100 {
            return false;
        }
        let settled = self.refined_blur(noise, self.blur.mean(), Some(line));
        let differs = |(one, other): (&f64, &f64)| (one / other).ln().abs() > limits.same_blur;
        let changed = settled.sigma.iter().zip(&self.blur.sigma).any(differs);
        let fits = self.window_width(settled.mean()) <= self.windows.width;
        if changed && fits {
            self.blur = settled;
        }
        changed && fits
    }

    /// Gives the edges in `line`, just fitted, the frame's own blur.
    pub(crate) fn follow_blur(&mut self, noise: &NoiseModel, line: &mut [Edge]) -> Change {
        let (dark, light) = (self.dark.mean, self.light.mean);
        let relative = noise.variance(0.5 * (dark + light)) / (light - dark).powi(2)
            * self.figures.reduced_chi2.max(1.0);
        let index = self.table(self.blur.mean(), noise.kappa(dark, light), false);
        let (windows, table) = (&self.windows, &self.work.tables[index]);
        let is_ringed = self.shape.is_ringed();
        let view = TrackView { windows, table, level_lines: self.kind.level_lines, is_ringed };
        let change = self.track.follow(&mut self.blur, relative, &view, line);
        self.blur.limit(self.shape.least_sigma());
        change
    }

    fn refined_blur(&mut self, noise: &NoiseModel, start: f64, line: Option<&[Edge]>) -> BlurEstimate {
        let (dark, light) = (self.dark.mean, self.light.mean);
        let context = BlurContext {
            windows: &self.windows,
            shape: &self.shape,
            dark: &self.dark,
            light: &self.light,
            slope: &self.slope,
            line,
            level_lines: self.kind.level_lines,
            kappa: noise.kappa(dark, light),
            relative_variance: noise.variance(0.5 * (dark + light)) / (light - dark).powi(2),
        };
        blur::refine(&context, start, &mut self.work.blur_scratch)
    }

    /// Index of the table for a blur and noise slope, built where it is missing.
    fn table(&mut self, sigma: f64, kappa: f64, free_levels: bool) -> usize {
        let limits = SideLimits::get();
        let width = self.windows.width;
        let same = if self.shape.is_ringed() { limits.same_rings } else { limits.same_blur };
        let near = |t: &Table| {
            t.width == width && (t.sigma / sigma).ln().abs() < same && (t.kappa - kappa).abs() < 0.08
        };
        if let Some(found) = self.work.tables.iter().position(near) {
            return found;
        }
        let per_px = ScoringTableLimits::get().fine;
        let table = Table::new(&self.shape, Tabulation { sigma, kappa, width, free_levels, per_px });
        let held: usize = self.work.tables.iter().map(Table::bytes).sum();
        if held + table.bytes() > self.work.most_table_bytes {
            self.work.tables.clear();
        }
        self.work.tables.push(table);
        self.work.tables.len() - 1
    }

    /// Fits all columns into `line`, then tests residuals and neighbours.
    pub(crate) fn fit(
        &mut self,
        settings: &GaugeSettings,
        noise: &NoiseModel,
        ends: Option<Ends>,
        line: &mut Vec<Edge>,
    ) {
        line.clear();
        self.track.start();
        self.figures.clipped_px = 0.0;
        let freedom = match ends {
            Some(ends) => self.fit_clipped(settings, noise, ends, line),
            None => self.fit_columns(settings, noise, line),
        };
        self.reject(settings, freedom, line);
        self.figures.jump = neighbour_test::largest_jump(line);
        if self.figures.jump.is_finite() {
            self.figures.rows.clear();
            self.figures.rows.extend(line.iter().map(|edge| Ok((edge.row_px + 0.5) as i32)));
        }
    }

    /// Fits a side whose light or shadow is clipped; gives the degrees of freedom to test residuals
    /// with.
    fn fit_clipped(
        &mut self,
        settings: &GaugeSettings,
        noise: &NoiseModel,
        ends: Ends,
        line: &mut Vec<Edge>,
    ) -> f64 {
        self.expected.iter_mut().for_each(Expected::start);
        let start = ClippedStart {
            shape: &self.shape,
            levels: [&self.dark, &self.light],
            sigma: self.blur.mean(),
            sigma_is_given: matches!(settings.blur, Blur::Given { .. }),
            variance: [noise.variance(self.dark.mean), noise.variance(self.light.mean)],
            floor: noise.floor(),
            ends,
        };
        let Some(side) = side_fit::fit_side(&self.windows, &self.slope, &start, line) else { return 4.0 };
        self.blur = BlurEstimate::uniform(side.sigma);
        // Blur and shape are shared by all columns.
        let length = line.len() as f32;
        for (curve, level) in [&mut self.dark, &mut self.light].into_iter().zip(side.levels) {
            curve.mean = level.iter().map(|l| f64::from(*l)).sum::<f64>() / level.len().max(1) as f64;
            curve.level = level;
            curve.length = length;
        }
        self.figures.clipped_px = side.u_px;
        if !ends.high.is_finite() {
            let index = self.table(side.sigma, noise.kappa(self.dark.mean, self.light.mean), false);
            self.gradient.state(
                line,
                &self.windows,
                (&self.dark, &self.light),
                (noise, &self.work.tables[index]),
            );
        }
        side.freedom
    }

    fn fit_columns(&mut self, settings: &GaugeSettings, noise: &NoiseModel, line: &mut Vec<Edge>) -> f64 {
        let columns = self.windows.centre.len();
        let kappa = noise.kappa(self.dark.mean, self.light.mean);
        let free = matches!(settings.levels, Levels::PerColumn {});
        let mut normalised = std::mem::take(&mut self.work.normalised);
        normalised.resize(self.windows.width, 0.0);
        let (shadow, contrast) = self.own_shadow();
        let (mut from, mut freedom) = (0, 1.0);
        let mut expected = self.expected.take();
        expected.iter_mut().for_each(Expected::start);
        while from < columns {
            let sigma = self.sigma_at(from);
            let to = self.end_of_run(from, sigma);
            let index = self.table(sigma, kappa, free);
            let table = &self.work.tables[index];
            freedom = f64::from(table.freedom);
            let job = ColumnJob {
                windows: &self.windows,
                dark: &self.dark,
                light: &self.light,
                noise,
                table,
                blur_shift: (sigma - table.sigma) as f32,
                min_snr: settings.min_snr as f32,
                reject: settings.rejection != Rejection::Off,
                shadow,
                contrast,
            };
            score_columns(&job, from..to, &mut normalised, line);
            self.track.add(&job, from..to, Placed { line, slope: &self.slope }, &mut normalised);
            if let Some(expected) = &mut expected {
                expected.judge(&job, from..to, &mut normalised, line);
            }
            from = to;
            if from >= columns {
                let levels = (&self.dark, &self.light);
                self.gradient.state(line, &self.windows, levels, (noise, table));
            }
        }
        self.expected = expected;
        self.work.normalised = normalised;
        freedom
    }

    /// Level of the shadow that a quarter of the columns stays below, and the contrast to the mean
    /// light.
    fn own_shadow(&mut self) -> (f32, f32) {
        self.work.floats.clear();
        let step = self.windows.dark.len().div_ceil(256).max(1);
        self.work.floats.extend(self.windows.dark.iter().step_by(step).filter(|d| d.is_finite()));
        if self.work.floats.is_empty() {
            return (f32::NEG_INFINITY, f32::INFINITY);
        }
        let quarter = self.work.floats.len() / 4;
        let shadow = *self.work.floats.select_nth_unstable_by(quarter, f32::total_cmp).1;
        (shadow, self.light.mean as f32 - shadow)
    }

    fn sigma_at(&self, column: usize) -> f64 {
        let block = BlurEstimate::block(column, self.windows.centre.len());
        blur::at_slope(self.blur.sigma[block], self.slope[column])
    }

    /// End of the columns from `from` on that share a blur.
    fn end_of_run(&self, from: usize, sigma: f64) -> usize {
        let limits = SideLimits::get();
        let columns = self.windows.centre.len();
        let level_slope = BlurLimits::get().level_slope;
        let level = |slope: &f32| slope.abs() < level_slope;
        if self.slope.iter().all(level) {
            return self.blur.end_of_run(from, columns);
        }
        (from + 1..columns)
            .find(|c| (self.sigma_at(*c) - sigma).abs() >= limits.same_blur * sigma)
            .unwrap_or(columns)
    }

    fn reject(&mut self, settings: &GaugeSettings, freedom: f64, line: &mut [Edge]) {
        let z = upper_normal_quantile(settings.residual_false_alarm);
        self.figures.reduced_chi2 = residual_test::reduced_chi2(line, freedom, &mut self.work.floats);
        let scale = if self.figures.reduced_chi2 > 1.2 { self.figures.reduced_chi2 } else { 1.0 };
        if settings.rejection != Rejection::Off {
            residual_test::refuse_residuals(line, (chi2_ratio_limit(freedom, z) * scale) as f32);
        }
        // Readings one after the other: neighbours of an area camera differ by noise and form
        // alone.
        let is_readings = self.kind.level_lines && self.shape.is_ringed();
        if is_readings && self.figures.reduced_chi2 < residual_test::ResidualLimits::get().most_noise {
            residual_test::take_noise_back(line, self.figures.reduced_chi2);
            self.figures.reduced_chi2 = 1.0;
        }
        let left_px = self.expected.as_ref().map_or(0.0, Expected::left_px);
        residual_test::add_model_uncertainty(line, freedom, left_px, &mut self.figures.model_uncertainty_px);
        if scale > 1.0 {
            for edge in line.iter_mut() {
                edge.u_own_px *= (scale as f32).sqrt();
            }
        }
        if settings.rejection == Rejection::Off {
            return;
        }
        residual_test::reject_uncertain(line);
        neighbour_test::refuse_outliers(line, settings.outlier_px, &mut self.work.outliers);
    }
}
