//! The edge finder: from a frame to both edges of every column.
//!
//! Coarse search, or the last frame's edges where a stream goes on → windows → levels, noise and
//! blur from the frame → maximum likelihood by tabulated scoring → residual and neighbourhood
//! tests. What a stream carries from frame to frame is where the edges were, the blur and the
//! tables; every carried thing is checked on the new frame (the blur follows it), and a frame that
//! does not bear it out is measured anew from the coarse search.

use super::acceptance;
use super::both_sides::both;
use super::estimation::side_survey::GreyScaleLimits;
use super::frame_survey::{FrameSurvey, Last};
use super::model::systematic_residual::SystematicResidual;
use super::refusals::explain::{self, no_levels, refused};
use super::rings;
use super::rounded_frame::Rounding;
use super::side::SideState;
use crate::frame::FrameView;
use crate::gauge::edge::estimation::blur::BlurEstimate;
use crate::gauge::edge::estimation::blur_track::{BlurTrack, Change, MOST_REFITS};
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::model_bias::ResidualAccumulator;
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::image::grey_step::grey_step;
use crate::gauge::edge::image::part_localisation::Coarse;
use crate::gauge::edge::image::plane::{Plane, Sample, with_plane};
use crate::gauge::edge::image::repeated::repeated_lines;
use crate::gauge::edge::image::scan_windows::Side;
use crate::gauge::edge::image::stuck_rows;
use crate::gauge::edge::image::window_layout::WIDEST_PX;
use crate::gauge::edge::model::edge_spread::{EdgeSpreadFunction, TabulatedEsf};
use crate::gauge::edge::rejection::departures::AxisScratch;
use crate::gauge::edge::rejection::one_sided::refuse_one_sided;
use crate::gauge::edge::wire::frame;
use crate::gauge::edges::{Edge, FrameEdges, FrameFigures, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::{Blur, EsfModel, GaugeSettings, Noise, Polarity, Rejection};
use crate::profile::Reason;

limits! {
    /// When a stream follows its last frame.
    StreamLimits = "stream";
    /// Columns below which a frame is readings of a line camera: of fewer, no level is pooled, and
    /// none shows a station or a stretch by itself. Levels from 16 columns are known to a quarter
    /// of one column's.
    least_columns: usize = 16;
    /// Share of the columns of the last frame that a followed frame must keep: fewer, and the part
    /// has moved or is another. Tuned: see study limits.
    least_followed: f64 = 0.98;
    /// χ² ratio over that of the last full search, above which a followed frame's blur is doubted:
    /// five standard deviations, since of 512 columns with twenty degrees of freedom each the best
    /// fitting fifth is known to 2 %.
    most_chi2: f64 = 1.1;
    /// Times that the edge-spread function is estimated from the edges found, and they are fitted
    /// with it: each round places the samples of the next one better. Tuned: see study limits.
    lessons: usize = 3;
    /// Blur, px, with which windows are laid out anew where a stuck row crosses those of a wider
    /// first guess: that of a telecentric lens in focus.
    usual_sigma_px: f64 = 1.0;
    /// Share of a side's windows that a stuck row may cross: beyond a half the rest is no view of
    /// the part.
    most_crossed: f64 = 0.5;
    /// Frames after which the part is searched anew, in case another has come in: a search costs
    /// more than a followed frame, and a 256th of it little. Tuned: see study limits.
    search_every: u32 = 256;
}

/// Finds edges in the frames of one area camera, of sixteen columns or more; keeps tables and
/// buffers between them.
#[derive(Clone, Debug)]
pub(crate) struct AreaStream {
    pub(crate) settings: GaugeSettings,
    /// The edge-spread function of the settings.
    shape: EdgeSpreadFunction,
    pub(crate) sides: [SideState; 2],
    /// Where the edges are looked for.
    coarse: Coarse,
    axis: AxisScratch,
    one_sided: f64,
    /// Rows of the frame looked at.
    rows: usize,
    /// Whether both sides may be worked on at once.
    splits: bool,
    /// Step of the grey scale, counts, as the last search found it.
    step: f64,
    last: Option<Last>,
}

impl AreaStream {
    /// A stream without any frame.
    pub(crate) fn new(settings: GaugeSettings) -> Self {
        let shape = match &settings.esf {
            EsfModel::Table(samples) => {
                let table = TabulatedEsf::new(samples.reach_px(), |d| samples.at(d));
                EdgeSpreadFunction::Table(std::sync::Arc::new(table))
            }
            EsfModel::Gaussian {} | EsfModel::Learnt {} | EsfModel::Optics {} => EdgeSpreadFunction::Gaussian,
        };
        Self {
            shape,
            settings,
            sides: [SideState::new(Side::Top), SideState::new(Side::Bottom)],
            coarse: Coarse::default(),
            axis: AxisScratch::default(),
            one_sided: 0.0,
            rows: 0,
            splits: true,
            step: 0.0,
            last: None,
        }
    }

    /// Expects of every edge what a calibration's masters left of the edge model.
    #[must_use]
    pub(crate) fn with_systematic_residual(mut self, reduced_chi2: Option<&SystematicResidual>) -> Self {
        for (index, side) in self.sides.iter_mut().enumerate() {
            side.expect(reduced_chi2, index);
        }
        self
    }

    /// Leaves a frame to the thread that it is given to: where whole frames are shared out,
    /// splitting them only costs.
    #[must_use]
    pub(crate) fn unsplit(self) -> Self {
        Self { splits: false, ..self }
    }

    /// The settings it measures by.
    pub(crate) fn settings(&self) -> &GaugeSettings {
        &self.settings
    }

    /// Adds what the edges of the frame just measured leave of the edge model.
    pub(crate) fn accumulate(&self, residuals: &mut ResidualAccumulator, measured: &FrameEdges) {
        for ((index, side), line) in self.sides.iter().enumerate().zip([&measured.top, &measured.bottom]) {
            side.accumulate(residuals, index, line);
        }
    }

    /// Discards the state kept from earlier frames.
    pub(crate) fn restart(&mut self) {
        self.last = None;
        self.sides.iter_mut().for_each(SideState::forget);
    }

    /// Measures a frame into `out`.
    ///
    /// # Errors
    /// Refuses frames that show no part with two edges: black, white, noise, too small, not finite.
    pub(crate) fn measure(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        acceptance::check(view)?;
        let sign = if self.settings.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 };
        let scale =
            GreyScaleLimits { floor: if view.format().full_scale().is_some() { 1.0 / 12.0 } else { 0.0 } };
        with_plane!(view, sign, plane => self.measure_plane(&plane, scale, out))
    }

    fn measure_plane<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        out: &mut FrameEdges,
    ) -> Result<(), FrameRefused> {
        self.rows = plane.rows;
        let last = self.last.take();
        if let Some(last) = last
            && self.follow(plane, GreyScaleLimits::of_step(self.step), last, out)
        {
            return Ok(());
        }
        if self.search(plane, scale, out)? {
            self.update_track(out, (plane.rows, plane.columns), 0);
        }
        Ok(())
    }

    /// Measures around the last frame's edges, beginning with its blur; false where the frame does
    /// not bear them out.
    fn follow<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        last: Last,
        out: &mut FrameEdges,
    ) -> bool {
        let limits = StreamLimits::get();
        if last.size != (plane.rows, plane.columns) || last.frames + 1 >= limits.search_every {
            return false;
        }
        let sigma = self.sides.iter().map(|s| s.blur.mean()).fold(0.0, f64::max);
        let Ok(survey) = self.read_windows(plane, scale, sigma, None) else { return false };
        let follows = matches!(self.settings.blur, Blur::Estimated {});
        self.sides.iter_mut().for_each(|side| side.track.begin(follows));
        if !(self.fit(&survey, out, true) && self.follow_blur(&survey, out)) {
            return false;
        }
        let valid = self.valid(out) as f64;
        let reduced_chi2 = self.reduced_chi2();
        if valid < limits.least_followed * last.valid as f64
            || reduced_chi2 > limits.most_chi2 * last.reduced_chi2.max(1.0)
        {
            return false;
        }
        if self.accept_frame(out).is_err() {
            return false;
        }
        self.update_track(out, last.size, last.frames + 1);
        // The reference stays that of the search, so that a slow loss of focus is noticed.
        if let Some(kept) = &mut self.last {
            kept.reduced_chi2 = last.reduced_chi2;
        }
        true
    }

    /// Gives the edges just fitted the frame's own blur; false where it is not near the last
    /// frame's.
    fn follow_blur(&mut self, survey: &FrameSurvey, out: &mut FrameEdges) -> bool {
        for _ in 0..=MOST_REFITS {
            let [top, bottom] = &mut self.sides;
            let changes = [
                top.follow_blur(&survey.noise, &mut out.top),
                bottom.follow_blur(&survey.noise, &mut out.bottom),
            ];
            if changes.contains(&Change::Lost) {
                return false;
            }
            if !changes.contains(&Change::Refit) {
                out.figures.sigma_px = [self.sides[0].blur.mean(), self.sides[1].blur.mean()];
                return true;
            }
            self.fit(survey, out, false);
        }
        false
    }

    /// Remembers where the edges are.
    fn update_track(&mut self, out: &FrameEdges, size: (usize, usize), frames: u32) {
        let valid = self.valid(out);
        let unbroken = self.is_unbroken();
        let Coarse { top, bottom, .. } = &mut self.coarse;
        for ((centres, line), side) in
            [(top, &out.top), (bottom, &out.bottom)].into_iter().zip(&mut self.sides)
        {
            if unbroken {
                std::mem::swap(centres, &mut side.figures.rows);
                continue;
            }
            let mut nearest = Err(Reason::NoEdge);
            for (centre, edge) in centres.iter_mut().zip(line) {
                if edge.is_usable() {
                    nearest = Ok((edge.row_px + 0.5) as i32);
                    *centre = nearest;
                } else if edge.reason() == Some(Reason::Steep) {
                    *centre = Err(Reason::Steep);
                } else if centre.is_ok() && nearest.is_ok() {
                    *centre = nearest;
                }
            }
        }
        self.last = Some(Last { size, valid, reduced_chi2: self.reduced_chi2(), frames });
    }

    /// Whether neither line has a gap.
    fn is_unbroken(&self) -> bool {
        self.one_sided == 0.0 && self.sides.iter().all(|side| side.figures.jump.is_finite())
    }

    /// Columns with both edges.
    fn valid(&self, out: &FrameEdges) -> usize {
        if self.is_unbroken() { out.columns() } else { out.valid() }
    }

    fn reduced_chi2(&self) -> f64 {
        self.sides[0].figures.reduced_chi2.max(self.sides[1].figures.reduced_chi2)
    }

    /// Measures from the coarse search on; false for a wire, which is searched in every frame.
    fn search<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        out: &mut FrameEdges,
    ) -> Result<bool, FrameRefused> {
        let limits = StreamLimits::get();
        let found = self.coarse.find_part(plane, &self.settings);
        found.map_err(|none| explain::no_shadow(plane, &self.settings, none))?;
        if let Some(lines) = repeated_lines(plane) {
            return Err(refused(Reason::Repeated, lines.to_string()));
        }
        self.step = grey_step(plane, [&self.coarse.top, &self.coarse.bottom], scale.floor > 0.0);
        let scale = GreyScaleLimits::of_step(self.step);
        if self.coarse.median_width().is_some_and(|width| width < WIDEST_PX) {
            self.one_sided = 0.0;
            let how = (&self.shape, &self.settings, scale);
            return frame::measure(plane, &self.coarse, how, out).map(|()| false);
        }
        self.axis.reserve(plane.columns);
        for side in &mut self.sides {
            side.set_shape(self.shape.clone());
            side.track = BlurTrack::default();
        }
        let given = self.settings.blur.given_px();
        let own = given.or(self.shape.own_sigma());
        let mut sigma = own.map_or_else(|| self.rough_blur(plane), Ok)?;
        let mut survey = self.read_windows(plane, scale, sigma, Some(self.settings.max_slope))?;
        let clear = self.leave_out_stuck(plane, scale, survey);
        survey = match clear {
            // A stuck row within the wide windows of the first guess may have made that guess:
            // narrow ones may be clear of it.
            Err(_) if given.is_none() && sigma > limits.usual_sigma_px => {
                sigma = limits.usual_sigma_px;
                let survey = self.read_windows(plane, scale, sigma, Some(self.settings.max_slope))?;
                self.leave_out_stuck(plane, scale, survey)?
            }
            clear => clear?,
        };
        self.pool(&survey)?;
        if given.is_none() {
            self.refine_blur(&survey, sigma);
            let largest = self.sides.iter().map(|s| s.blur.mean()).fold(0.0, f64::max);
            let rings = rings::differ(&self.shape, sigma, largest);
            if rings || self.sides[0].window_width(largest) != self.sides[0].windows.width {
                sigma = largest;
                survey = self.read_windows(plane, scale, sigma, Some(self.settings.max_slope))?;
                survey = self.leave_out_stuck(plane, scale, survey)?;
                self.pool(&survey)?;
                if rings {
                    self.refine_blur(&survey, sigma);
                }
            }
        } else {
            self.sides.iter_mut().for_each(|s| s.blur = BlurEstimate::uniform(sigma));
        }
        self.fit(&survey, out, false);
        if given.is_none() && self.settle_blur(&survey, out) {
            self.fit(&survey, out, false);
        }
        if survey.is_noisy(self.sides[0].windows.width) {
            survey = self.recentre(plane, scale, out)?;
            self.fit(&survey, out, true);
        }
        if self.settings.esf == (EsfModel::Learnt {}) {
            self.learn(&survey, out);
        }
        self.accept_frame(out).map(|()| true)
    }

    /// Leaves out the windows that a stuck row of the sensor crosses; refuses the frame where those
    /// are most of a side's.
    fn leave_out_stuck<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        survey: FrameSurvey,
    ) -> Result<FrameSurvey, FrameRefused> {
        let limits = StreamLimits::get();
        let contrast = rings::stuck_contrast(&self.shape, (survey.light - survey.dark) as f32);
        let mut any = false;
        for side in self.sides.iter_mut().filter(|side| !side.kind.copies) {
            let Some(stuck) = stuck_rows::leave_out(plane, &mut side.windows, contrast) else { continue };
            if stuck.share > limits.most_crossed {
                return Err(explain::stuck_row(stuck.row, plane.sign * stuck.level, side.windows.width / 2));
            }
            any = true;
            side.survey(scale, matches!(self.settings.noise, Noise::Estimated {}));
        }
        if any { self.survey(scale) } else { Ok(survey) }
    }

    /// Learns each side's edge-spread function and fits again; a side that does not determine it
    /// keeps the Gaussian.
    fn learn(&mut self, survey: &FrameSurvey, out: &mut FrameEdges) {
        let limits = StreamLimits::get();
        for _ in 0..limits.lessons {
            let [top, bottom] = &mut self.sides;
            let clipped = survey.ends.map(|ends| ends.is_some());
            let learnt = (!clipped[0] && top.learn(&out.top), !clipped[1] && bottom.learn(&out.bottom));
            if learnt == (false, false) {
                return;
            }
            self.fit(survey, out, false);
        }
    }

    fn rough_blur<T: Sample>(&mut self, plane: &Plane<'_, T>) -> Result<f64, FrameRefused> {
        let mut first = None;
        for widest in [4.0, 2.0, 0.8] {
            let (mut sum, mut count, mut all_alone) = (0.0, 0.0, true);
            for (side, centres) in self.sides.iter_mut().zip([&self.coarse.top, &self.coarse.bottom]) {
                if let Some((sigma, alone)) = side.rough_blur(plane, centres, widest) {
                    (sum, count) = (sum + sigma, count + 1.0);
                    all_alone &= alone;
                }
            }
            if count > 0.0 && all_alone {
                return Ok(sum / count);
            }
            first = first.or((count > 0.0).then_some(sum / count));
        }
        if let Some(sigma) = first {
            return Ok(sigma);
        }
        let needed = self.sides[0].window_width(0.8) / 2;
        Err(explain::too_near(needed, self.coarse.nearest_to_border(plane.rows)))
    }

    /// Reads all windows, then the noise. `centring`: the edges are only roughly known, and this is
    /// the steepest slope.
    fn read_windows<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        sigma: f64,
        centring: Option<f64>,
    ) -> Result<FrameSurvey, FrameRefused> {
        let estimate = matches!(self.settings.noise, Noise::Estimated {});
        let read_windows = |side: &mut SideState, centres| {
            side.read_windows(plane, centres, sigma, centring);
            side.survey(scale, estimate);
        };
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        let (upper, lower) = (&self.coarse.top, &self.coarse.bottom);
        both(splits, || read_windows(top, upper), || read_windows(bottom, lower));
        let survey = self.survey(scale)?;
        rings::check(plane, &self.sides).map(|()| survey)
    }

    /// Reads all windows anew around the edges found.
    fn recentre<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        scale: GreyScaleLimits,
        found: &FrameEdges,
    ) -> Result<FrameSurvey, FrameRefused> {
        let estimate = matches!(self.settings.noise, Noise::Estimated {});
        let read_windows = |side: &mut SideState, line: &[Edge]| {
            side.recentre(plane, line);
            side.survey(scale, estimate);
        };
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        both(splits, || read_windows(top, &found.top), || read_windows(bottom, &found.bottom));
        self.survey(scale)
    }

    fn survey(&mut self, scale: GreyScaleLimits) -> Result<FrameSurvey, FrameRefused> {
        let ends = self.sides.each_ref().map(|side| side.figures.survey.ends);
        self.sides[0].figures.survey.share_ends(ends[1]);
        self.sides[1].figures.survey.share_ends(ends[0]);
        let [top, bottom] = [&self.sides[0].figures.survey, &self.sides[1].figures.survey];
        let count = top.levels.count + bottom.levels.count;
        if top.levels.count.min(bottom.levels.count) == 0.0 && self.is_cut_off() {
            let rows = self.rows;
            return Err(explain::too_near(
                self.sides[0].windows.width / 2,
                self.coarse.nearest_to_border(rows),
            ));
        }
        if count == 0.0 {
            return Err(no_levels());
        }
        let dark = (top.levels.dark + bottom.levels.dark) / count;
        let light = (top.levels.light + bottom.levels.light) / count;
        let noise = self.noise(dark, light, scale.floor(light - dark)).ok_or_else(no_levels)?;
        let snr = (light - dark) / noise.variance(0.5 * (dark + light)).sqrt();
        if !(snr >= self.settings.min_snr) {
            return Err(explain::too_faint((dark, light), snr, self.settings.min_snr));
        }
        let sign = if self.settings.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 };
        let given = NoiseModel::given(self.settings.noise, sign, 0.0);
        let rounding = Rounding::of(&self.sides, given, (dark, light), scale.step());
        Ok(FrameSurvey { noise, dark, light, ends: [top.ends, bottom.ends], rounding })
    }

    /// Whether most columns of a side have no window because it would reach beyond the field.
    fn is_cut_off(&self) -> bool {
        self.sides.iter().any(|side| {
            let cut = side.windows.centre.iter().filter(|c| **c == Err(Reason::Border)).count();
            2 * cut > side.windows.centre.len()
        })
    }

    fn noise(&self, dark: f64, light: f64, floor: f64) -> Option<NoiseModel> {
        let sign = if self.settings.polarity == Polarity::DarkOnBright { 1.0 } else { -1.0 };
        if let Some(given) = NoiseModel::given(self.settings.noise, sign, floor) {
            return Some(given);
        }
        self.sides[0].figures.survey.noise_with(&self.sides[1].figures.survey, (dark, light), floor)
    }

    /// Pools the levels of both sides.
    fn pool(&mut self, survey: &FrameSurvey) -> Result<(), FrameRefused> {
        let pool =
            |side: &mut SideState, levels| side.pool_levels(&survey.noise, survey.dark, survey.light, levels);
        let levels = self.settings.levels;
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        let (a, b) = both(splits, || pool(top, levels), || pool(bottom, levels));
        if a && b { Ok(()) } else { Err(no_levels()) }
    }

    fn refine_blur(&mut self, survey: &FrameSurvey, sigma: f64) {
        let refine = |side: &mut SideState, ends: Option<Ends>| match ends {
            Some(_) => side.blur = BlurEstimate::uniform(sigma),
            None => side.refine_blur(&survey.noise, sigma),
        };
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        both(splits, || refine(top, survey.ends[0]), || refine(bottom, survey.ends[1]));
    }

    /// Takes the blur of both sides anew without what was refused; false where that changes
    /// nothing.
    fn settle_blur(&mut self, survey: &FrameSurvey, out: &FrameEdges) -> bool {
        if self.settings.rejection == Rejection::Off {
            return false;
        }
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        let settle = |side: &mut SideState, ends: Option<Ends>, line: &[Edge]| {
            ends.is_none() && side.settle_blur(&survey.noise, line)
        };
        let (a, b) = both(
            splits,
            || settle(top, survey.ends[0], &out.top),
            || settle(bottom, survey.ends[1], &out.bottom),
        );
        a || b
    }

    /// Fits both sides, their levels pooled before where `pool`; false without levels.
    fn fit(&mut self, survey: &FrameSurvey, out: &mut FrameEdges, pool: bool) -> bool {
        let settings = &self.settings;
        let fit = |side: &mut SideState, ends, line: &mut Vec<Edge>| {
            let there = !pool || side.pool_levels(&survey.noise, survey.dark, survey.light, settings.levels);
            if there {
                side.fit(settings, &survey.noise, ends, line);
            }
            there
        };
        let splits = self.splits;
        let [top, bottom] = &mut self.sides;
        let (upper, lower) = (&mut out.top, &mut out.bottom);
        let (a, b) = both(splits, || fit(top, survey.ends[0], upper), || fit(bottom, survey.ends[1], lower));
        if !(a && b) {
            return false;
        }
        for (length, side) in out.shared_length.iter_mut().zip(&self.sides) {
            *length = side.dark.length.min(side.light.length);
        }
        for (stated, side) in out.model_uncertainty_px.iter_mut().zip(&self.sides) {
            stated.clone_from(&side.figures.model_uncertainty_px);
        }
        out.clipped_px = [self.sides[0].figures.clipped_px, self.sides[1].figures.clipped_px];
        if self.settings.rejection == Rejection::Full {
            self.one_sided = refuse_one_sided(&mut out.top, &mut out.bottom, &mut self.axis);
        }
        out.figures = self.figures(survey);
        survey.rounding.state(&self.sides, survey.ends.map(|ends| ends.is_some_and(Ends::is_high)), out);
        true
    }

    /// Whether the frame as a whole is plausible.
    fn accept_frame(&self, out: &FrameEdges) -> Result<(), FrameRefused> {
        let jump_px = acceptance::jump_px(&self.settings);
        let contours = self.is_unbroken() && self.sides.iter().all(|side| side.figures.jump <= jump_px);
        acceptance::accept(out, &self.settings, self.valid(out), contours)
    }

    fn figures(&self, survey: &FrameSurvey) -> FrameFigures {
        let [top, bottom] = &self.sides;
        let dark = 0.5 * (top.dark.mean + bottom.dark.mean);
        let light = 0.5 * (top.light.mean + bottom.light.mean);
        let mid = survey.noise.variance(0.5 * (dark + light)).sqrt();
        FrameFigures {
            sigma_px: [top.blur.mean(), bottom.blur.mean()],
            position_ambiguity_px: match self.settings.esf {
                EsfModel::Learnt {} => [top.position_ambiguity(), bottom.position_ambiguity()],
                _ => [0.0; 2],
            },
            dark: [top.dark.mean, bottom.dark.mean],
            light: [top.light.mean, bottom.light.mean],
            noise: [survey.noise.variance(dark).sqrt(), survey.noise.variance(light).sqrt()],
            snr: (light - dark) / mid,
            reduced_chi2: self.reduced_chi2(),
            quantised: survey.rounding.step > 0.0,
            rounding_px: [0.0; 2],
            shadows: self.coarse.shadows.seen,
        }
    }
}
