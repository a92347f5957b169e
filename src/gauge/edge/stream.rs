//! The edge finder: from a frame to both edges of every column.
//!
//! A frame passes through its stages once: `locate` (or the last frame's edges where a stream goes
//! on) → `frame_windows` (scan windows, and what they state of levels, noise and blur) →
//! `frame_lines` (maximum likelihood by tabulated scoring, residual and neighbourhood tests) →
//! `acceptance`. What a stream carries from frame to frame is its track: where the edges were,
//! their models, and tables. Every carried thing is checked on the new frame (the blur follows it),
//! and a frame that does not bear it out is measured anew from the search on.

use super::acceptance;
use super::frame_lines::{EdgeLines, FitWork, FittedLines, FrameFit};
use super::frame_survey::FrameSurvey;
use super::frame_windows::{LocatedFrame, SuitedWindows};
use super::locate::{PartLocation, locate};
use super::model::systematic_residual::SystematicResidual;
use super::side::buffers::SideBuffers;
use super::side::model::EdgeModel;
use super::side::scan::{Centring, Layout};
use super::side::tables::TableCache;
use super::stream_settings::{ColumnKind, StreamSettings};
use crate::frame::FrameView;
use crate::gauge::edge::estimation::model_bias::{ResidualAccumulator, SideView};
use crate::gauge::edge::image::part_localisation::PartSearch;
use crate::gauge::edge::image::plane::{Plane, Sample, with_plane};
use crate::gauge::edge::image::scan_windows::Side;
use crate::gauge::edge::rejection::departures::AxisScratch;
use crate::gauge::edge::wire::frame;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::{Blur, EsfModel, GaugeSettings, Noise};

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
    /// Frames after which the part is searched anew, in case another has come in: a search costs
    /// more than a followed frame, and a 256th of it little.
    search_every: u32 = 256;
}

/// Finds edges in the frames of one area camera, of sixteen columns or more.
#[derive(Clone, Debug)]
pub(crate) struct AreaStream {
    settings: StreamSettings,
    work: Workspace,
    track: Track,
}

/// Buffers: the next frame takes over their memory, and of their content nothing. Until then they
/// hold the stages of the frame measured last, for [`AreaStream::accumulate`].
#[derive(Clone, Debug)]
struct Workspace {
    search: PartSearch,
    sides: [SideBuffers; 2],
    axis: AxisScratch,
}

/// What the frames measured leave to the next one.
#[derive(Clone, Debug)]
struct Track {
    /// Tables of either side, for blurs near those of the frames before.
    tables: [TableCache; 2],
    /// Slopes of the edges of either side, as the last search found them.
    slopes: [Vec<f32>; 2],
    last: Option<LastFrame>,
}

/// The frame before, where it was measured.
#[derive(Clone, Debug)]
struct LastFrame {
    /// Where its edges were.
    location: PartLocation,
    /// The edge models of its sides.
    models: [EdgeModel; 2],
    /// Whether either side was clipped.
    clipped: [bool; 2],
    /// Columns with both edges.
    valid: usize,
    /// Median residual of the last search, so that a slow loss of focus is noticed.
    reduced_chi2: f64,
    /// Frames followed since the part was searched.
    frames: u32,
}

/// A frame measured, beside its edges.
struct MeasuredFrame {
    fitted: FittedLines,
    clipped: [bool; 2],
}

impl Workspace {
    fn new() -> Self {
        Self {
            search: PartSearch::default(),
            sides: [SideBuffers::new(Side::Top), SideBuffers::new(Side::Bottom)],
            axis: AxisScratch::default(),
        }
    }
}

impl Track {
    fn new() -> Self {
        Self { tables: [TableCache::new(), TableCache::new()], slopes: [Vec::new(), Vec::new()], last: None }
    }
}

impl AreaStream {
    /// A stream without any frame.
    pub(crate) fn new(settings: GaugeSettings) -> Self {
        Self { settings: StreamSettings::new(settings), work: Workspace::new(), track: Track::new() }
    }

    /// Expects of every edge what a calibration's masters left of the edge model.
    #[must_use]
    pub(crate) fn with_systematic_residual(mut self, reduced_chi2: Option<&SystematicResidual>) -> Self {
        self.settings.expect(reduced_chi2);
        self
    }

    /// Leaves a frame to the thread that it is given to: where whole frames are shared out,
    /// splitting them only costs.
    #[must_use]
    pub(crate) fn unsplit(mut self) -> Self {
        self.settings.splits = false;
        self
    }

    /// The settings it measures by.
    pub(crate) fn settings(&self) -> &GaugeSettings {
        &self.settings.gauge
    }

    /// A stream like this one with other settings, and without any frame.
    pub(crate) fn with_settings(&self, gauge: GaugeSettings, columns: ColumnKind) -> Self {
        let mut stream = self.clone();
        (stream.settings.gauge, stream.settings.columns) = (gauge, columns);
        stream.restart();
        stream
    }

    /// Takes another noise for the next frames, whose columns are of this kind.
    pub(crate) fn set_noise(&mut self, noise: Noise, columns: ColumnKind) {
        (self.settings.gauge.noise, self.settings.columns) = (noise, columns);
    }

    /// Adds what the edges of the frame just measured leave of the edge model; clipped light adds
    /// nothing.
    pub(crate) fn accumulate(&self, residuals: &mut ResidualAccumulator, measured: &FrameEdges) {
        let Some(last) = &self.track.last else { return };
        for (index, line) in [&measured.top, &measured.bottom].into_iter().enumerate() {
            if last.clipped[index] {
                continue;
            }
            let (SideBuffers { scan, levels, .. }, model) = (&self.work.sides[index], &last.models[index]);
            let view = SideView {
                windows: &scan.windows,
                shape: &model.shape,
                dark: &levels.dark,
                light: &levels.light,
                slope: &scan.slope,
            };
            residuals.add(index, &view, line, |column| model.sigma_at(scan, column));
        }
    }

    /// Discards the state kept from earlier frames.
    pub(crate) fn restart(&mut self) {
        self.track.last = None;
        self.track.tables.iter_mut().for_each(TableCache::clear);
    }

    /// Measures a frame into `out`.
    ///
    /// # Errors
    /// Refuses frames that show no part with two edges: black, white, noise, too small, not finite.
    pub(crate) fn measure(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        acceptance::check(view)?;
        let quantised = view.format().full_scale().is_some();
        with_plane!(view, self.settings.sign(), plane => self.measure_plane(&plane, quantised, out))
    }

    /// Follows the last frame where this one bears it out, and searches the part otherwise.
    fn measure_plane<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        quantised: bool,
        out: &mut FrameEdges,
    ) -> Result<(), FrameRefused> {
        self.track.tables.iter_mut().for_each(|tables| tables.limit(plane.rows * plane.columns));
        if let Some(last) = self.track.last.take() {
            if let Some(followed) = self.follow(plane, &last, out) {
                let (frames, reduced_chi2) = (last.frames + 1, last.reduced_chi2);
                let next = self.left_by(followed, last.location, out);
                self.track.last = Some(LastFrame { frames, reduced_chi2, ..next });
                return Ok(());
            }
            self.work.search.reuse(last.location.top, last.location.bottom);
        }
        let location = locate(plane, &self.settings.gauge, quantised, &mut self.work.search)?;
        if location.is_wire() {
            // Searched in every frame.
            let (shape, settings) = (&self.settings.shape, &self.settings.gauge);
            let measured = frame::measure(plane, &location, (shape, settings), out);
            self.work.search.reuse(location.top, location.bottom);
            return measured;
        }
        let measured = self.measure_part(plane, &location, out)?;
        self.track.last = Some(self.left_by(measured, location, out));
        Ok(())
    }

    /// Measures around the last frame's edges, beginning with its edge models; `None` where the
    /// frame does not bear them out.
    fn follow<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        last: &LastFrame,
        out: &mut FrameEdges,
    ) -> Option<MeasuredFrame> {
        if last.location.size != (plane.rows, plane.columns)
            || last.frames + 1 >= StreamLimits::get().search_every
        {
            return None;
        }
        let Self { settings, work, track } = self;
        let frame = LocatedFrame { plane, location: &last.location, settings };
        let survey = frame.scan(last.layouts(&track.slopes), &mut work.sides).ok()?;
        let follows_blur = matches!(settings.gauge.blur, Blur::Estimated {});
        let fit = FrameFit { settings, survey, shadows: last.location.shadows, follows_blur };
        let fitted = fit.followed_lines(last.models.clone(), &mut work.fit(&mut track.tables), out)?;
        let borne_out = last.is_borne_out_by(&fitted.lines, out);
        let accepted = borne_out && accept(&settings.gauge, &fitted.lines, out).is_ok();
        accepted.then(|| MeasuredFrame::of(fitted, &survey))
    }

    /// Measures from the windows on, around the edges that the search located.
    fn measure_part<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        location: &PartLocation,
        out: &mut FrameEdges,
    ) -> Result<MeasuredFrame, FrameRefused> {
        let Self { settings, work, track } = self;
        work.axis.reserve(plane.columns);
        track.tables.iter_mut().for_each(|tables| tables.keep_for(&settings.shape));
        let frame = LocatedFrame { plane, location, settings };
        let SuitedWindows { survey, models } = frame.suited_windows(&mut work.sides)?;
        let mut fit = FrameFit { settings, survey, shadows: location.shadows, follows_blur: false };
        let work = &mut work.fit(&mut track.tables);
        let mut fitted = fit.settled_lines(models, work, out);
        // Windows that noise centred are read anew around the edges found, once.
        if survey.is_noisy(work.sides[0].scan.windows.width) {
            fit.survey = frame.recentre(&fitted.models, out, work.sides)?;
            fitted.lines = fit.pooled_lines(&mut fitted.models, work, out).unwrap_or(fitted.lines);
        }
        if settings.gauge.esf == (EsfModel::Learnt {}) {
            fitted = fit.learnt_lines(fitted, work, out);
        }
        accept(&settings.gauge, &fitted.lines, out)?;
        for (kept, side) in track.slopes.iter_mut().zip(work.sides.iter()) {
            kept.clone_from(&side.scan.slope);
        }
        Ok(MeasuredFrame::of(fitted, &fit.survey))
    }

    /// What a frame measured leaves to the next one: it is looked for where this one's edges are.
    fn left_by(
        &mut self,
        measured: MeasuredFrame,
        mut location: PartLocation,
        out: &FrameEdges,
    ) -> LastFrame {
        let MeasuredFrame { fitted: FittedLines { models, lines }, clipped } = measured;
        if lines.is_unbroken() {
            let [top, bottom] = &mut self.work.sides;
            location.swap_rows(&mut top.rows, &mut bottom.rows);
        } else {
            location.move_to(&out.top, &out.bottom);
        }
        let (valid, reduced_chi2) = (lines.valid(out), lines.reduced_chi2());
        LastFrame { location, models, clipped, valid, reduced_chi2, frames: 0 }
    }
}

impl Workspace {
    /// What the fit works in.
    fn fit<'a>(&'a mut self, tables: &'a mut [TableCache; 2]) -> FitWork<'a> {
        FitWork { sides: &mut self.sides, axis: &mut self.axis, tables }
    }
}

impl LastFrame {
    /// Windows around its edges, as wide as the larger blur of its sides needs.
    fn layouts<'a>(&'a self, slopes: &'a [Vec<f32>; 2]) -> [Layout<'a>; 2] {
        let sigma = self.models.iter().map(|model| model.blur.mean()).fold(0.0, f64::max);
        [0, 1].map(|k| {
            let centring = Centring::Followed { slope: &slopes[k] };
            Layout { shape: &self.models[k].shape, sigma, centring }
        })
    }

    /// Whether the lines of the next frame are those of the same part in the same focus.
    fn is_borne_out_by(&self, lines: &EdgeLines, out: &FrameEdges) -> bool {
        let most_chi2 = StreamLimits::get().most_chi2 * self.reduced_chi2.max(1.0);
        keeps_its_columns([lines.valid(out), self.valid]) && !(lines.reduced_chi2() > most_chi2)
    }
}

/// Whether so many columns with both edges, now and before, are those of one part.
fn keeps_its_columns([now, before]: [usize; 2]) -> bool {
    now as f64 >= StreamLimits::get().least_followed * before as f64
}

impl MeasuredFrame {
    fn of(fitted: FittedLines, survey: &FrameSurvey) -> Self {
        Self { fitted, clipped: survey.ends().map(|ends| ends.is_some()) }
    }
}

/// Last stage: whether the frame as a whole is plausible.
fn accept(settings: &GaugeSettings, lines: &EdgeLines, out: &FrameEdges) -> Result<(), FrameRefused> {
    let contours = lines.are_contours(acceptance::jump_px(settings));
    acceptance::accept(out, settings, lines.valid(out), contours)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hot pixels take an edge from up to two columns in a hundred, and not from the same ones in
    /// the next frame; a shoulder or the end of the part takes more.
    #[test]
    fn a_part_that_keeps_98_columns_in_a_hundred_is_the_same() {
        assert!(keeps_its_columns([504, 512]) && keeps_its_columns([512, 504]));
        assert!(!keeps_its_columns([496, 512]));
    }
}
