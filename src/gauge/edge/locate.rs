//! First stage of a frame: where the part is, and the step of the grey scale around its edges.

use super::estimation::side_survey::GreyScaleLimits;
use super::refusals::explain::{self, refused};
use crate::gauge::edge::image::grey_step::grey_step;
use crate::gauge::edge::image::part_localisation::{CoarseEdge, PartSearch};
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::repeated::repeated_lines;
use crate::gauge::edge::image::window_layout::WIDEST_PX;
use crate::gauge::edges::{Edge, FrameRefused, ShadowsSeen};
use crate::gauge::settings::GaugeSettings;
use crate::profile::Reason;

/// Where the part is: whole-pixel edges, from a search or from the frame before.
#[derive(Clone, Debug)]
pub(crate) struct PartLocation {
    /// Rows and columns of the frame.
    pub(crate) size: (usize, usize),
    /// First shadow row of each column.
    pub(crate) top: Vec<CoarseEdge>,
    /// Last shadow row of each column.
    pub(crate) bottom: Vec<CoarseEdge>,
    /// Median width of the columns with both edges, px, as the search found it.
    pub(crate) width_px: Option<f64>,
    /// Other shadows of the frame.
    pub(crate) shadows: ShadowsSeen,
    /// The grey scale, by its step around the edges.
    pub(crate) scale: GreyScaleLimits,
}

/// Finds the part in a frame; `quantised`: grey values are whole counts.
///
/// # Errors
/// Refuses frames that show no part, or the same line again and again.
pub(crate) fn locate<T: Sample>(
    plane: &Plane<'_, T>,
    settings: &GaugeSettings,
    quantised: bool,
    search: &mut PartSearch,
) -> Result<PartLocation, FrameRefused> {
    let found = search.find_part(plane, settings);
    found.map_err(|none| explain::no_shadow(plane, settings, none))?;
    if let Some(lines) = repeated_lines(plane) {
        return Err(refused(Reason::Repeated, lines.to_string()));
    }
    let step = grey_step(plane, [&search.top, &search.bottom], quantised);
    let width_px = search.median_width();
    let (top, bottom) = search.take_lines();
    let (shadows, scale) = (search.shadows.seen, GreyScaleLimits::of_step(step));
    Ok(PartLocation { size: (plane.rows, plane.columns), top, bottom, width_px, shadows, scale })
}

impl PartLocation {
    /// Whether both edges are fitted together.
    pub(crate) fn is_wire(&self) -> bool {
        self.width_px.is_some_and(|width| width < WIDEST_PX)
    }

    /// Median distance of the edges from the border of a field of so many rows, px, at the side
    /// where it is smaller.
    pub(crate) fn nearest_to_border(&self, rows: usize) -> Option<f64> {
        let median = |line: &[CoarseEdge], distance: &dyn Fn(i32) -> i32| {
            let mut all: Vec<i32> = line.iter().flatten().map(|row| distance(*row)).collect();
            all.sort_unstable();
            all.get(all.len() / 2).map(|px| f64::from(*px))
        };
        let above = median(&self.top, &|row| row)?;
        let below = median(&self.bottom, &|row| rows as i32 - 1 - row)?;
        Some(above.min(below))
    }

    /// Moves on to the edges of a frame that was measured; columns without one take the row of the
    /// nearest before them.
    pub(crate) fn move_to(&mut self, top: &[Edge], bottom: &[Edge]) {
        for (centres, line) in [(&mut self.top, top), (&mut self.bottom, bottom)] {
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
    }

    /// Moves on to the rows of edges without a gap; gives the rows before in their place.
    pub(crate) fn swap_rows(&mut self, top: &mut Vec<CoarseEdge>, bottom: &mut Vec<CoarseEdge>) {
        std::mem::swap(&mut self.top, top);
        std::mem::swap(&mut self.bottom, bottom);
    }
}
