//! The blur of one side: a rough one from wide windows, refined over the columns, taken anew
//! without what was refused, or learnt with the whole edge-spread function.

use super::buffers::SideBuffers;
use super::levels::SideLevels;
use super::model::EdgeModel;
use super::scan::ScanWindows;
use super::survey::SurveyBuffers;
use super::tables::TableLimits;
use crate::gauge::edge::estimation::blur::{self, BlurContext, BlurEstimate, BlurScratch};
use crate::gauge::edge::estimation::noise::NoiseModel;
use crate::gauge::edge::estimation::slanted_edge::{self, EsfSamples};
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edge::image::window_layout::window_width;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edges::Edge;

/// A first blur from windows wide enough for `widest` px on a few columns, and whether these see
/// one edge alone; `None` where they do not fit the field.
pub(crate) fn rough_blur<T: Sample>(
    plane: &Plane<'_, T>,
    centres: &[CoarseEdge],
    widest: f64,
    windows: &mut Windows,
    buffers: &mut SurveyBuffers,
) -> Option<(f64, bool)> {
    windows.centre.clear();
    windows.centre.extend(blur::samples(centres.len()).map(|column| centres[column]));
    windows.centred = false;
    let gaussian = EdgeSpreadFunction::Gaussian;
    windows.prepare(&gaussian, widest, window_width(&gaussian, widest), windows.centre.len());
    for (place, column) in blur::samples(centres.len()).enumerate() {
        windows.read_one(plane, column, place);
    }
    let alone = blur::sees_one_edge(windows);
    blur::rough(windows, &mut buffers.floats).map(|sigma| (sigma, alone))
}

/// A side whose blur is estimated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlurInputs<'a> {
    pub(crate) scan: &'a ScanWindows,
    pub(crate) levels: &'a SideLevels,
    pub(crate) noise: &'a NoiseModel,
    /// Whether columns are readings one after the other: no course along the field.
    pub(crate) level_lines: bool,
}

impl<'a> BlurInputs<'a> {
    /// The inputs from a side's buffers, and the memory to work in.
    pub(crate) fn of(
        side: &'a mut SideBuffers,
        noise: &'a NoiseModel,
        level_lines: bool,
    ) -> (Self, &'a mut BlurScratch) {
        (Self { scan: &side.scan, levels: &side.levels, noise, level_lines }, &mut side.blur)
    }

    /// The blur from `start`, px, on; without the columns that are refused in `line`.
    pub(crate) fn refined(
        &self,
        shape: &EdgeSpreadFunction,
        start: f64,
        line: Option<&[Edge]>,
        scratch: &mut BlurScratch,
    ) -> BlurEstimate {
        let (dark, light) = (self.levels.dark.mean, self.levels.light.mean);
        let noise = self.noise;
        let context = BlurContext {
            windows: &self.scan.windows,
            shape,
            dark: &self.levels.dark,
            light: &self.levels.light,
            slope: &self.scan.slope,
            line,
            level_lines: self.level_lines,
            kappa: noise.kappa(dark, light),
            relative_variance: noise.variance(0.5 * (dark + light)) / (light - dark).powi(2),
        };
        blur::refine(&context, start, scratch)
    }

    /// The blur of the columns that were not refused: what shades an edge is blurred otherwise.
    /// `None` where it does not change.
    pub(crate) fn settled(
        &self,
        model: &EdgeModel,
        line: &[Edge],
        scratch: &mut BlurScratch,
    ) -> Option<BlurEstimate> {
        let windows = &self.scan.windows;
        let looked_for = windows.centre.iter().zip(line).filter(|(centre, _)| centre.is_ok());
        let refused = looked_for.filter(|(_, edge)| !edge.is_usable()).count();
        if refused <= line.len() / 100 {
            return None;
        }
        let settled = self.refined(&model.shape, model.blur.mean(), Some(line), scratch);
        let same_blur = TableLimits::get().same_blur;
        let differs = |(one, other): (&f64, &f64)| (one / other).ln().abs() > same_blur;
        let changed = settled.sigma.iter().zip(&model.blur.sigma).any(differs);
        let fits = model.window_width(settled.mean()) <= windows.width;
        (changed && fits).then_some(settled)
    }
}

/// The edge-spread function that the positions in `line` show; `None` where the frame does not
/// determine it.
pub(crate) fn learnt_shape(side: &SideBuffers, sigma: f64, line: &[Edge]) -> Option<EdgeSpreadFunction> {
    let samples = EsfSamples {
        windows: &side.scan.windows,
        dark: &side.levels.dark,
        light: &side.levels.light,
        slope: &side.scan.slope,
        sigma,
    };
    slanted_edge::learn(&samples, line).map(|table| EdgeSpreadFunction::Table(std::sync::Arc::new(table)))
}
