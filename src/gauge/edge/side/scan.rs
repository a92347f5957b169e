//! Scan windows of one side: the grey values from shadow to light around the edge of each column,
//! its slope, and the light beyond.

use crate::gauge::edge::estimation::level_gradient::LevelGradient;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::scan_windows::{Side, Windows, slopes};
use crate::gauge::edge::image::window_layout::window_width;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edges::Edge;
use crate::profile::Reason;

/// The windows of one side, and what lies beside them.
#[derive(Clone, Debug)]
pub(crate) struct ScanWindows {
    pub(crate) windows: Windows,
    /// Slope of the edge, rows per column.
    pub(crate) slope: Vec<f32>,
    pub(crate) gradient: LevelGradient,
    /// Blur for which the windows were laid out, px.
    pub(crate) laid_out: f64,
}

/// How a side's windows are laid out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout<'a> {
    pub(crate) shape: &'a EdgeSpreadFunction,
    /// Blur, px.
    pub(crate) sigma: f64,
    pub(crate) centring: Centring<'a>,
}

/// How well the centres of windows are known.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Centring<'a> {
    /// Roughly: windows are centred by their light, which gives the slopes; the steepest is left
    /// out. `level_lines`: neighbours are readings, which have no slope.
    ByLight { max_slope: f64, level_lines: bool },
    /// As the last frame's edges, with their slopes.
    Followed { slope: &'a [f32] },
}

impl ScanWindows {
    pub(crate) fn new(side: Side) -> Self {
        Self {
            windows: Windows::new(side),
            slope: Vec::new(),
            gradient: LevelGradient::default(),
            laid_out: 1.0,
        }
    }

    /// Reads all windows around `centres`.
    pub(crate) fn read<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        centres: &[CoarseEdge],
        layout: &Layout<'_>,
    ) {
        self.windows.centre.clear();
        self.windows.centre.extend_from_slice(centres);
        self.windows.centred = matches!(layout.centring, Centring::Followed { .. });
        self.laid_out = layout.sigma;
        self.read_width(plane, layout.shape, window_width(layout.shape, layout.sigma));
        match layout.centring {
            Centring::Followed { slope } => {
                self.slope.clear();
                self.slope.extend_from_slice(slope);
            }
            Centring::ByLight { max_slope, level_lines } => self.find_slopes(max_slope, level_lines),
        }
    }

    /// Slopes of windows just centred; those of steeper edges are left out.
    fn find_slopes(&mut self, max_slope: f64, level_lines: bool) {
        slopes(&self.windows, &mut self.slope);
        if level_lines {
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
    pub(crate) fn recentre<T: Sample>(
        &mut self,
        plane: &Plane<'_, T>,
        shape: &EdgeSpreadFunction,
        line: &[Edge],
    ) {
        for (centre, edge) in self.windows.centre.iter_mut().zip(line).filter(|(_, e)| e.is_usable()) {
            *centre = Ok((edge.row_px + 0.5).floor() as i32);
        }
        self.windows.centred = true;
        self.read_width(plane, shape, self.windows.width);
    }

    /// Reads windows of a width around their centres, and the light beyond them.
    fn read_width<T: Sample>(&mut self, plane: &Plane<'_, T>, shape: &EdgeSpreadFunction, width: usize) {
        self.windows.prepare(shape, self.laid_out, width, plane.columns);
        self.windows.read(plane);
        // Rings are no light that falls off.
        if shape.is_ringed() {
            self.gradient.clear();
        } else {
            self.gradient.read(plane, &self.windows);
        }
    }
}
