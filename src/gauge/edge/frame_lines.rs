//! Fourth stage of a frame: the edge lines of both sides, and the blur that they are fitted by.

use super::both_sides::both;
use super::frame_survey::FrameSurvey;
use super::rounded_frame::FittedSide;
use super::side::blur::{BlurInputs, learnt_shape};
use super::side::buffers::SideBuffers;
use super::side::line::{EdgeLine, LineFit, LineWork, edge_line, follow_blur};
use super::side::model::EdgeModel;
use super::side::tables::TableCache;
use super::stream_settings::StreamSettings;
use crate::gauge::edge::estimation::blur_track::{BlurTrackLimits, Change};
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::rejection::departures::AxisScratch;
use crate::gauge::edge::rejection::one_sided::refuse_one_sided;
use crate::gauge::edges::{Edge, FrameEdges, FrameFigures, ShadowsSeen};
use crate::gauge::limit::limits;
use crate::gauge::settings::{EsfModel, Rejection};

limits! {
    /// How often the lines of a frame are fitted.
    FrameLineLimits = "frame_lines";
    /// Times that the edge-spread function is estimated from the edges found, and they are fitted
    /// with it: each round places the samples of the next one better. Tuned: see study limits.
    estimates_of_shape: usize = 3;
}

/// What the edges of a frame are fitted by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameFit<'a> {
    pub(crate) settings: &'a StreamSettings,
    pub(crate) survey: FrameSurvey,
    /// Other shadows of the frame.
    pub(crate) shadows: ShadowsSeen,
    /// Whether the edges are also to show a change of the blur.
    pub(crate) follows_blur: bool,
}

/// What the fit works in.
pub(crate) struct FitWork<'a> {
    pub(crate) sides: &'a mut [SideBuffers; 2],
    pub(crate) axis: &'a mut AxisScratch,
    /// Tables kept from frame to frame.
    pub(crate) tables: &'a mut [TableCache; 2],
}

/// The edge lines of a frame, beside the edges themselves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeLines {
    sides: [EdgeLine; 2],
    /// Share of the columns refused for a departure of one side from the other.
    one_sided: f64,
}

/// Edge lines, and the edge models that they were fitted by.
#[derive(Debug)]
pub(crate) struct FittedLines {
    pub(crate) models: [EdgeModel; 2],
    pub(crate) lines: EdgeLines,
}

impl EdgeLines {
    /// Whether neither line has a gap.
    pub(crate) fn is_unbroken(&self) -> bool {
        self.one_sided == 0.0 && self.sides.iter().all(|side| side.jump.is_finite())
    }

    /// Whether neither line has a gap or a larger step than `jump_px`.
    pub(crate) fn are_contours(&self, jump_px: f64) -> bool {
        self.is_unbroken() && self.sides.iter().all(|side| side.jump <= jump_px)
    }

    /// Columns with both edges.
    pub(crate) fn valid(&self, out: &FrameEdges) -> usize {
        if self.is_unbroken() { out.columns() } else { out.valid() }
    }

    /// Median residual of the side where it is larger.
    pub(crate) fn reduced_chi2(&self) -> f64 {
        self.sides[0].reduced_chi2.max(self.sides[1].reduced_chi2)
    }
}

impl FrameFit<'_> {
    /// Edge lines of a search: fitted, and fitted anew where the blur was that of columns that are
    /// refused.
    pub(crate) fn settled_lines(
        &self,
        mut models: [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> FittedLines {
        let lines = self.edge_lines(&mut models, work, out);
        let changed =
            self.settings.gauge.blur.given_px().is_none() && self.settle_blur(&mut models, work, out);
        let lines = if changed { self.edge_lines(&mut models, work, out) } else { lines };
        FittedLines { models, lines }
    }

    /// Edge lines of a followed frame: the levels pooled, the edges fitted by the last frame's blur
    /// and given their own; `None` where that is not near.
    pub(crate) fn followed_lines(
        &self,
        mut models: [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> Option<FittedLines> {
        let mut lines = self.pooled_lines(&mut models, work, out)?;
        for _ in 0..=BlurTrackLimits::get().most_refits {
            let changes = self.follow_blur(&lines, &mut models, work, out);
            if changes.contains(&Change::Lost) {
                return None;
            }
            if !changes.contains(&Change::Refit) {
                out.figures.sigma_px = [models[0].blur.mean(), models[1].blur.mean()];
                return Some(FittedLines { models, lines });
            }
            lines = self.edge_lines(&mut models, work, out);
        }
        None
    }

    /// Edge lines by the edge-spread functions that the frame itself shows, of the sides that
    /// determine one.
    pub(crate) fn learnt_lines(
        &self,
        mut fitted: FittedLines,
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> FittedLines {
        for _ in 0..FrameLineLimits::get().estimates_of_shape {
            let FittedLines { models, lines } = &mut fitted;
            let clipped = self.survey.ends().map(|ends| ends.is_some());
            let shape_of = |k: usize, line: &[Edge]| {
                if clipped[k] { None } else { learnt_shape(&work.sides[k], models[k].blur.mean(), line) }
            };
            let shapes = [shape_of(0, &out.top), shape_of(1, &out.bottom)];
            if shapes.iter().all(Option::is_none) {
                break;
            }
            for ((model, tables), shape) in models.iter_mut().zip(work.tables.iter_mut()).zip(shapes) {
                if let Some(shape) = shape {
                    tables.keep_for(&shape);
                    model.shape = shape;
                }
            }
            *lines = self.edge_lines(models, work, out);
        }
        fitted
    }

    /// Pools the levels and fits both sides; `None` without levels.
    pub(crate) fn pooled_lines(
        &self,
        models: &mut [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> Option<EdgeLines> {
        let levels = self.settings.gauge.levels;
        let (top, bottom) = self.both_sides(models, work, out, |by, work| {
            let (side, pooling) = (&mut *work.side, self.survey.pooling(&work.model.shape, levels));
            let pooled = side.levels.pool(&side.scan, &pooling, &mut side.pool);
            pooled.then(|| edge_line(by, work))
        });
        Some(self.joined([top?, bottom?], models, work, out))
    }

    /// Fits both sides by the levels pooled before.
    fn edge_lines(
        &self,
        models: &mut [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> EdgeLines {
        let (top, bottom) = self.both_sides(models, work, out, edge_line);
        self.joined([top, bottom], models, work, out)
    }

    /// Works on both sides, at once where there are threads.
    fn both_sides<R: Send>(
        &self,
        models: &mut [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
        each: impl Fn(&LineFit<'_>, LineWork<'_>) -> R + Sync,
    ) -> (R, R) {
        let ([upper, lower], [above, below]) = (&mut *work.sides, models);
        let [upper_tables, lower_tables] = &mut *work.tables;
        let [upper_stated, lower_stated] = &mut out.model_uncertainty_px;
        let top = LineWork {
            side: upper,
            model: above,
            tables: upper_tables,
            edges: &mut out.top,
            model_uncertainty_px: upper_stated,
        };
        let bottom = LineWork {
            side: lower,
            model: below,
            tables: lower_tables,
            edges: &mut out.bottom,
            model_uncertainty_px: lower_stated,
        };
        let [by_top, by_bottom] = [0, 1].map(|side| self.line_fit(side));
        both(self.settings.splits, || each(&by_top, top), || each(&by_bottom, bottom))
    }

    /// What a side's edges are fitted by; 0 above, 1 below.
    fn line_fit(&self, side: usize) -> LineFit<'_> {
        LineFit {
            settings: &self.settings.gauge,
            noise: &self.survey.noise,
            ends: self.survey.sides[side].ends,
            expected: self.settings.expected[side].as_ref(),
            level_lines: self.settings.columns.level_lines,
            follows_blur: self.follows_blur,
        }
    }

    /// Both lines together: what they have in common, and departures of one from the other.
    fn joined(
        &self,
        sides: [EdgeLine; 2],
        models: &[EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> EdgeLines {
        for (length, side) in out.shared_length.iter_mut().zip(work.sides.iter()) {
            *length = side.levels.dark.length.min(side.levels.light.length);
        }
        out.clipped_px = sides.map(|side| side.clipped_px);
        let one_sided = match self.settings.gauge.rejection {
            Rejection::Full => refuse_one_sided(&mut out.top, &mut out.bottom, work.axis),
            Rejection::Off | Rejection::ByEdge => 0.0,
        };
        let lines = EdgeLines { sides, one_sided };
        let fitted = [0, 1].map(|k| FittedSide {
            side: work.sides[k].scan.windows.side,
            levels: &work.sides[k].levels,
            model: &models[k],
            clipped: self.survey.sides[k].ends.is_some_and(Ends::is_high),
        });
        out.figures = self.figures(&lines, &fitted);
        self.survey.rounding.state(&fitted, out);
        lines
    }

    fn figures(&self, lines: &EdgeLines, fitted: &[FittedSide<'_>; 2]) -> FrameFigures {
        let [top, bottom] = fitted.each_ref().map(|side| side.levels);
        let dark = 0.5 * (top.dark.mean + bottom.dark.mean);
        let light = 0.5 * (top.light.mean + bottom.light.mean);
        let noise = &self.survey.noise;
        let mid = noise.variance(0.5 * (dark + light)).sqrt();
        FrameFigures {
            sigma_px: fitted.each_ref().map(|side| side.model.blur.mean()),
            position_ambiguity_px: match self.settings.gauge.esf {
                EsfModel::Learnt {} => fitted.each_ref().map(|side| side.model.position_ambiguity()),
                _ => [0.0; 2],
            },
            dark: [top.dark.mean, bottom.dark.mean],
            light: [top.light.mean, bottom.light.mean],
            noise: [noise.variance(dark).sqrt(), noise.variance(light).sqrt()],
            snr: (light - dark) / mid,
            reduced_chi2: lines.reduced_chi2(),
            quantised: self.survey.rounding.step > 0.0,
            rounding_px: [0.0; 2],
            shadows: self.shadows,
        }
    }

    /// Takes the blur of both sides anew without what was refused; false where that changes
    /// nothing.
    fn settle_blur(&self, models: &mut [EdgeModel; 2], work: &mut FitWork<'_>, out: &FrameEdges) -> bool {
        if self.settings.gauge.rejection == Rejection::Off {
            return false;
        }
        let settled = |k: usize, side: &mut SideBuffers, model: &EdgeModel, line: &[Edge]| {
            if self.survey.sides[k].ends.is_some() {
                return None;
            }
            let level_lines = self.settings.columns.level_lines;
            let (inputs, scratch) = BlurInputs::of(side, &self.survey.noise, level_lines);
            inputs.settled(model, line, scratch)
        };
        let [top, bottom] = &mut *work.sides;
        let [above, below] = &*models;
        let (a, b) = both(
            self.settings.splits,
            || settled(0, top, above, &out.top),
            || settled(1, bottom, below, &out.bottom),
        );
        let changed = a.is_some() || b.is_some();
        for (model, blur) in models.iter_mut().zip([a, b]) {
            model.blur = blur.unwrap_or(model.blur);
        }
        changed
    }

    /// Gives the edges just fitted the frame's own blur.
    fn follow_blur(
        &self,
        lines: &EdgeLines,
        models: &mut [EdgeModel; 2],
        work: &mut FitWork<'_>,
        out: &mut FrameEdges,
    ) -> [Change; 2] {
        let ([upper, lower], [above, below]) = (&*work.sides, models);
        let [upper_tables, lower_tables] = &mut *work.tables;
        let [top, bottom] = &lines.sides;
        [
            follow_blur(&self.line_fit(0), top, (upper, upper_tables), above, &mut out.top),
            follow_blur(&self.line_fit(1), bottom, (lower, lower_tables), below, &mut out.bottom),
        ]
    }
}
