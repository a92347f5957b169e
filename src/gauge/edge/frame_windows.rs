//! Second and third stage of a frame: scan windows around both edges, and what they state of
//! levels, noise and blur.
//!
//! The width of the windows follows from the blur, which they alone show: they are laid out for a
//! rough one and, where that was another than they show, once more.

use super::both_sides::both;
use super::frame_survey::FrameSurvey;
use super::locate::PartLocation;
use super::refusals::explain::{self, no_levels};
use super::rings::{self, RingedSide};
use super::side::blur::{BlurInputs, rough_blur};
use super::side::buffers::SideBuffers;
use super::side::model::EdgeModel;
use super::side::scan::{Centring, Layout};
use super::side::survey::{SurveyRequest, survey};
use super::stream_settings::StreamSettings;
use crate::gauge::edge::estimation::blur::BlurEstimate;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::side_survey::SideSurvey;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::stuck_rows;
use crate::gauge::edge::image::window_layout::window_width;
use crate::gauge::edges::{Edge, FrameEdges, FrameRefused};
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// Windows that a stuck row crosses.
    FrameWindowLimits = "frame_windows";
    /// Blur, px, with which windows are laid out anew where a stuck row crosses those of a wider
    /// first guess: that of a telecentric lens in focus.
    usual_sigma_px: f64 = 1.0;
    /// Share of a side's windows that a stuck row may cross: beyond a half the rest is no view of
    /// the part.
    most_crossed: f64 = 0.5;
}

/// A frame in which the part has been located.
#[derive(Debug)]
pub(crate) struct LocatedFrame<'a, T> {
    pub(crate) plane: &'a Plane<'a, T>,
    pub(crate) location: &'a PartLocation,
    pub(crate) settings: &'a StreamSettings,
}

/// Windows that suit the blur of their frame.
#[derive(Debug)]
pub(crate) struct SuitedWindows {
    pub(crate) survey: FrameSurvey,
    /// The edge model of either side.
    pub(crate) models: [EdgeModel; 2],
}

type Sides = [SideBuffers; 2];

impl<T: Sample> LocatedFrame<'_, T> {
    /// Scan windows of a search: as wide as the blur needs that they show, or that is given, and
    /// without those that a stuck row crosses.
    ///
    /// # Errors
    /// Refuses edges near the border or without levels, faint frames, clipped rings, stuck rows.
    pub(crate) fn suited_windows(&self, sides: &mut Sides) -> Result<SuitedWindows, FrameRefused> {
        let shape = &self.settings.shape;
        let given = self.settings.gauge.blur.given_px();
        let own = given.or(shape.own_sigma());
        let rough = own.map_or_else(|| self.rough_blur(sides), Ok)?;
        let (sigma, survey) = self.first_windows(rough, sides)?;
        self.pool(&survey, sides)?;
        let uniform = |sigma| [0, 1].map(|_| EdgeModel::uniform(shape, sigma));
        if given.is_some() {
            return Ok(SuitedWindows { survey, models: uniform(sigma) });
        }
        let models = self.refined(&survey, sigma, sides);
        let largest = models.iter().map(|model| model.blur.mean()).fold(0.0, f64::max);
        let rings = rings::differ(shape, sigma, largest);
        if !rings && window_width(shape, largest) == sides[0].scan.windows.width {
            return Ok(SuitedWindows { survey, models });
        }
        let survey = self.clear_windows(largest, sides)?;
        self.pool(&survey, sides)?;
        let models = if rings { self.refined(&survey, largest, sides) } else { models };
        Ok(SuitedWindows { survey, models })
    }

    /// Windows for a rough blur, and the blur that they were laid out for.
    fn first_windows(&self, rough: f64, sides: &mut Sides) -> Result<(f64, FrameSurvey), FrameRefused> {
        let usual = FrameWindowLimits::get().usual_sigma_px;
        let survey = self.windows_for(rough, sides)?;
        match self.leave_out_stuck(survey, sides) {
            // A stuck row within the wide windows of a rough blur may have made that blur: narrow
            // ones may be clear of it.
            Err(_) if self.settings.gauge.blur.given_px().is_none() && rough > usual => {
                Ok((usual, self.clear_windows(usual, sides)?))
            }
            clear => clear.map(|survey| (rough, survey)),
        }
    }

    /// Windows for a blur, without those that a stuck row crosses.
    fn clear_windows(&self, sigma: f64, sides: &mut Sides) -> Result<FrameSurvey, FrameRefused> {
        let survey = self.windows_for(sigma, sides)?;
        self.leave_out_stuck(survey, sides)
    }

    /// Windows for a blur, centred by their light.
    fn windows_for(&self, sigma: f64, sides: &mut Sides) -> Result<FrameSurvey, FrameRefused> {
        let (max_slope, level_lines) = (self.settings.gauge.max_slope, self.settings.columns.level_lines);
        let centring = Centring::ByLight { max_slope, level_lines };
        let layout = Layout { shape: &self.settings.shape, sigma, centring };
        self.scan([layout; 2], sides)
    }

    /// Scan windows laid out for the edges located, and their survey.
    ///
    /// # Errors
    /// Refuses edges near the border or without levels, faint frames, clipped rings.
    pub(crate) fn scan(
        &self,
        layouts: [Layout<'_>; 2],
        sides: &mut Sides,
    ) -> Result<FrameSurvey, FrameRefused> {
        let read = |side: &mut SideBuffers, centres: &[CoarseEdge], layout: &Layout<'_>| {
            side.scan.read(self.plane, centres, layout);
            self.survey_side(side)
        };
        let [top, bottom] = &mut *sides;
        let (upper, lower) = (&self.location.top, &self.location.bottom);
        let (a, b) =
            both(self.settings.splits, || read(top, upper, &layouts[0]), || read(bottom, lower, &layouts[1]));
        let survey = self.survey([a, b], sides)?;
        let [top, bottom] = &*sides;
        let ends = survey.ends();
        rings::check(self.plane, [ringed(top, &layouts[0], ends[0]), ringed(bottom, &layouts[1], ends[1])])?;
        Ok(survey)
    }

    /// Windows read anew around the edges found, and their survey.
    ///
    /// # Errors
    /// As [`LocatedFrame::scan`].
    pub(crate) fn recentre(
        &self,
        models: &[EdgeModel; 2],
        found: &FrameEdges,
        sides: &mut Sides,
    ) -> Result<FrameSurvey, FrameRefused> {
        let read = |side: &mut SideBuffers, model: &EdgeModel, line: &[Edge]| {
            side.scan.recentre(self.plane, &model.shape, line);
            self.survey_side(side)
        };
        let [top, bottom] = &mut *sides;
        let (a, b) = both(
            self.settings.splits,
            || read(top, &models[0], &found.top),
            || read(bottom, &models[1], &found.bottom),
        );
        self.survey([a, b], sides)
    }

    fn survey_side(&self, side: &mut SideBuffers) -> SideSurvey {
        let request = SurveyRequest {
            scale: self.location.scale,
            estimates_noise: self.settings.estimates_noise(),
            copies: self.settings.columns.copies,
            turned: self.settings.sign() < 0.0,
        };
        survey(&mut side.scan, request, &mut side.survey)
    }

    /// The survey of the frame from those of its sides.
    fn survey(&self, of_sides: [SideSurvey; 2], sides: &Sides) -> Result<FrameSurvey, FrameRefused> {
        if of_sides.iter().any(|side| side.levels.count == 0.0) && is_cut_off(sides) {
            return Err(self.too_near(sides[0].scan.windows.width));
        }
        FrameSurvey::of(of_sides, self.settings, self.location.scale)
    }

    fn too_near(&self, width: usize) -> FrameRefused {
        explain::too_near(width / 2, self.location.nearest_to_border(self.plane.rows))
    }

    /// Leaves out the windows that a stuck row of the sensor crosses; refuses the frame where those
    /// are most of a side's.
    fn leave_out_stuck(&self, survey: FrameSurvey, sides: &mut Sides) -> Result<FrameSurvey, FrameRefused> {
        if self.settings.columns.copies {
            return Ok(survey);
        }
        let plane = self.plane;
        let contrast = rings::stuck_contrast(&self.settings.shape, (survey.light - survey.dark) as f32);
        let (mut of_sides, mut any) = (survey.sides, false);
        for (side, of_side) in sides.iter_mut().zip(&mut of_sides) {
            let windows = &mut side.scan.windows;
            let Some(stuck) = stuck_rows::leave_out(plane, windows, contrast) else { continue };
            if stuck.share > FrameWindowLimits::get().most_crossed {
                return Err(explain::stuck_row(stuck.row, plane.sign * stuck.level, windows.width / 2));
            }
            any = true;
            *of_side = self.survey_side(side);
        }
        if any { self.survey(of_sides, sides) } else { Ok(survey) }
    }

    /// A first blur from windows of three widths, of which the widest are clear of other edges.
    fn rough_blur(&self, sides: &mut Sides) -> Result<f64, FrameRefused> {
        let mut first = None;
        for widest in [4.0, 2.0, 0.8] {
            let (mut sum, mut count, mut all_alone) = (0.0, 0.0, true);
            for (side, centres) in sides.iter_mut().zip([&self.location.top, &self.location.bottom]) {
                let SideBuffers { scan, survey, .. } = side;
                if let Some((sigma, alone)) =
                    rough_blur(self.plane, centres, widest, &mut scan.windows, survey)
                {
                    (sum, count) = (sum + sigma, count + 1.0);
                    all_alone &= alone;
                }
            }
            if count > 0.0 && all_alone {
                return Ok(sum / count);
            }
            first = first.or((count > 0.0).then_some(sum / count));
        }
        first.ok_or_else(|| self.too_near(window_width(&self.settings.shape, 0.8)))
    }

    /// Pools the levels of both sides.
    fn pool(&self, survey: &FrameSurvey, sides: &mut Sides) -> Result<(), FrameRefused> {
        let by = survey.pooling(&self.settings.shape, self.settings.gauge.levels);
        let pool = |side: &mut SideBuffers| side.levels.pool(&side.scan, &by, &mut side.pool);
        let [top, bottom] = sides;
        let (a, b) = both(self.settings.splits, || pool(top), || pool(bottom));
        if a && b { Ok(()) } else { Err(no_levels()) }
    }

    /// The blur of both sides from a start, px, on; of a clipped side it is fitted with the edges.
    fn refined(&self, survey: &FrameSurvey, start: f64, sides: &mut Sides) -> [EdgeModel; 2] {
        let shape = &self.settings.shape;
        let refine = |side: &mut SideBuffers, of_side: &SideSurvey| {
            if of_side.ends.is_some() {
                return BlurEstimate::uniform(start);
            }
            let (inputs, scratch) = BlurInputs::of(side, &survey.noise, self.settings.columns.level_lines);
            inputs.refined(shape, start, None, scratch)
        };
        let [top, bottom] = sides;
        let [upper, lower] = &survey.sides;
        let (a, b) = both(self.settings.splits, || refine(top, upper), || refine(bottom, lower));
        [a, b].map(|blur| EdgeModel { shape: shape.clone(), blur })
    }
}

fn ringed<'a>(side: &'a SideBuffers, layout: &Layout<'_>, ends: Option<Ends>) -> RingedSide<'a> {
    RingedSide { windows: &side.scan.windows, is_ringed: layout.shape.is_ringed(), ends }
}

/// Whether most columns of a side have no window because it would reach beyond the field.
fn is_cut_off(sides: &Sides) -> bool {
    sides.iter().any(|side| {
        let centres = &side.scan.windows.centre;
        let cut = centres.iter().filter(|c| **c == Err(Reason::Border)).count();
        2 * cut > centres.len()
    })
}
