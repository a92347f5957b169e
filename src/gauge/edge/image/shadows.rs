//! Which of several shadows is the part: two wires in one field, the walls of a tube, a pin that a
//! bright line parts.
//!
//! A shadow is a dark area that runs along the field and has both edges in it. Where nothing is
//! stated the largest one is measured, with two exceptions. Strips that a narrow bright line parts
//! (the highlight of a polished pin, the focal line of a glass capillary) are one part and measured
//! from the outermost edge to the outermost edge. Two equal strips with a gap that is neither
//! narrow nor wide may be two parts or the walls of one tube, and nothing in the frame shows which:
//! the frame is refused until it is stated.

use super::connected_components::{Area, Components, Span, largest};
use crate::gauge::edges::ShadowsSeen;
use crate::gauge::limit::limits;
use crate::gauge::settings::Which;
use crate::profile::Reason;

limits! {
    /// Which of several shadows are parts, and which are strips of one.
    ShadowLimits = "shadows";
    /// Shadows kept, the largest ones: a frame with more is no view of a shaft.
    most: usize = 16;
    /// Share of the largest shadow's columns that another one must run along to count as a second
    /// part: half, as of two parts in one field either is seen along most of it.
    along: f64 = 0.5;
    /// Share of the columns that strips must have in common to be walls of one part, which end
    /// together. Tuned: see study limits.
    beside: f64 = 0.8;
    /// Gap between strips over the thicker one up to which they are one part. The highlight of a
    /// polished pin and the focal line of a glass capillary in parallel light take less than a
    /// tenth of the diameter; n = 1.5 focuses a rod's light of numerical aperture 0.1 to 0.1 D.
    narrow: f64 = 0.25;
    /// Gap over the thinner strip up to which a pair may be one tube: its bore over its wall is
    /// 2/(D/d − 1), so that D/d of 5 and more give this or less.
    wide: f64 = 0.5;
    /// Ratio of thicknesses from which on strips count as equal: the walls of one tube are, but for
    /// its eccentricity and the estimate by whole cells. Tuned: see study limits.
    equal: f64 = 0.8;
    /// Share of the thickness of the shadow measured from which on another shadow is reported as
    /// left out: half of it can be the part, hardly a hair or a wire beside it. Tuned: see study
    /// limits.
    as_large: f64 = 0.5;
}

/// One strip: a shadow with its mean position.
#[derive(Clone, Copy, Debug)]
struct Strip {
    area: Area,
    /// Mean first row and the one after the last, px.
    rows_px: (f64, f64),
    /// Columns in which it is there.
    columns: usize,
    /// Whether it is large enough to be a part.
    part: bool,
}

impl Strip {
    fn thickness_px(&self) -> f64 {
        self.rows_px.1 - self.rows_px.0
    }

    fn middle_px(&self) -> f64 {
        0.5 * (self.rows_px.0 + self.rows_px.1)
    }
}

/// The grid that shadows are looked for in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid<'a> {
    pub(crate) values: &'a [f32],
    pub(crate) columns: usize,
    /// Rows of the frame that a cell stands for.
    pub(crate) row_step: usize,
    /// Values below are shadow, counts.
    pub(crate) threshold: f32,
    /// Thickness below which a shadow is no part, px.
    pub(crate) min_diameter_px: f64,
}

/// Buffers of the choice.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shadows {
    components: Components,
    areas: Vec<Area>,
    strips: Vec<Strip>,
    other: Vec<Span>,
    pub(crate) seen: ShadowsSeen,
}

/// Why no shadow was chosen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoShadow {
    pub(crate) reason: Reason,
    /// What was seen; `None` where there is nothing to add to the reason.
    pub(crate) detail: Option<String>,
}

impl From<Reason> for NoShadow {
    fn from(reason: Reason) -> Self {
        Self { reason, detail: None }
    }
}

impl Shadows {
    /// Writes the span of the part in each of the grid's columns.
    ///
    /// # Errors
    /// Nothing is dark, no shadow has the number wanted, or two shadows may be one part or two.
    pub(crate) fn choose(
        &mut self,
        grid: &Grid<'_>,
        which: Option<Which>,
        spans: &mut Vec<Span>,
    ) -> Result<(), NoShadow> {
        self.components.find(grid.values, grid.columns, grid.threshold, &mut self.areas);
        let main = *largest(&self.areas).ok_or(Reason::NoEdge)?;
        self.seen = ShadowsSeen::one();
        self.find_strips(grid);
        let chosen = match which {
            None => self.unstated(&main)?,
            Some(which) => self.stated(grid, which)?,
        };
        let Some((first, last)) = chosen else {
            self.components.spans(&main, grid.columns, spans);
            return Ok(());
        };
        self.join(grid, (first, last), spans);
        self.describe(first, last);
        Ok(())
    }

    /// Writes the span of the largest area of values below a half in each of the grid's columns;
    /// false without one.
    pub(crate) fn largest(&mut self, values: &[f32], columns: usize, spans: &mut Vec<Span>) -> bool {
        self.components.find(values, columns, 0.5, &mut self.areas);
        let Some(area) = largest(&self.areas) else { return false };
        self.components.spans(area, columns, spans);
        true
    }

    /// The shadows that run along the field with both edges in it, from the top.
    fn find_strips(&mut self, grid: &Grid<'_>) {
        let limits = ShadowLimits::get();
        let last_row = (grid.values.len() / grid.columns) as u32 - 1;
        let inside = |area: &Area| area.rows.0 > 0 && area.rows.1 < last_row;
        self.strips.clear();
        let Some(main) = self.areas.iter().rev().filter(|a| inside(a)).max_by_key(|a| a.cells).copied()
        else {
            return;
        };
        let wide = |area: &Area| f64::from(area.columns.1 - area.columns.0);
        let least = limits.along * wide(&main);
        let continues = |area: &Area| is_continued(&main, area);
        for area in self.areas.iter().filter(|area| inside(area) && wide(area) >= least && !continues(area)) {
            self.components.spans(area, grid.columns, &mut self.other);
            let step = grid.row_step as f64;
            let (mut first, mut last, mut n) = (0.0, 0.0, 0.0);
            for (a, b) in self.other.iter().flatten() {
                (first, last, n) = (first + *a as f64, last + *b as f64 + 1.0, n + 1.0);
            }
            let rows_px = (step * first / n, step * last / n);
            // A speck with arms is no strip: most of the extent of a strip is dark.
            let solid = f64::from(area.cells) >= 0.5 * (last - first) && n >= least;
            if *area == main || solid {
                let part = rows_px.1 - rows_px.0 >= grid.min_diameter_px;
                self.strips.push(Strip { area: *area, rows_px, columns: n as usize, part });
            }
        }
        self.strips.sort_unstable_by_key(|s| (std::cmp::Reverse(s.area.cells), s.area.root));
        self.strips.truncate(limits.most);
        self.strips.sort_unstable_by(|a, b| a.middle_px().total_cmp(&b.middle_px()));
    }

    /// First and last strip of the part where nothing is stated; none where the largest dark area
    /// is no strip.
    fn unstated(&self, main: &Area) -> Result<Option<(usize, usize)>, NoShadow> {
        let Some(at) = self.strips.iter().position(|s| s.area == *main) else { return Ok(None) };
        let (mut first, mut last) = (at, at);
        while first > 0 && is_one_part(&self.strips[first - 1], &self.strips[first]) {
            first -= 1;
        }
        while last + 1 < self.strips.len() && is_one_part(&self.strips[last], &self.strips[last + 1]) {
            last += 1;
        }
        let neighbours = [first.checked_sub(1).map(|k| (k, first)), Some((last, last + 1))];
        for (a, b) in neighbours.into_iter().flatten().filter(|(_, b)| *b < self.strips.len()) {
            if let Some(detail) = doubt(&self.strips[a], &self.strips[b]) {
                return Err(NoShadow { reason: Reason::SeveralShadows, detail: Some(detail) });
            }
        }
        Ok(Some((first, last)))
    }

    /// First and last strip of the part stated; none without any strip.
    fn stated(&self, grid: &Grid<'_>, which: Which) -> Result<Option<(usize, usize)>, NoShadow> {
        let parts = || self.strips.iter().enumerate().filter(|(_, s)| s.part);
        let one = |found: Option<usize>| found.map(|k| Some((k, k))).ok_or(Reason::NoEdge.into());
        match which {
            _ if self.strips.is_empty() => Ok(None),
            Which::Largest => {
                one(self.strips.iter().enumerate().rev().max_by_key(|(_, s)| s.area.cells).map(|(k, _)| k))
            }
            Which::NearestCentre => {
                let centre = 0.5 * (grid.values.len() / grid.columns * grid.row_step) as f64;
                let off = |s: &Strip| (s.middle_px() - centre).abs();
                one(parts().min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map(|(k, _)| k))
            }
            Which::Outermost => match (parts().next(), parts().next_back()) {
                (Some((first, _)), Some((last, _))) => Ok(Some((first, last))),
                _ => Err(Reason::NoEdge.into()),
            },
            Which::Number(number) => {
                let wanted = usize::from(number).checked_sub(1);
                match wanted.and_then(|n| parts().nth(n)) {
                    Some((k, _)) => Ok(Some((k, k))),
                    None => Err(NoShadow {
                        reason: Reason::NoEdge,
                        detail: Some(format!(
                            "there is no shadow {number}: {} of {} px or more lie in the field, counted from the top; give --which one of them, or a smaller --min-diameter-px",
                            parts().count(),
                            grid.min_diameter_px
                        )),
                    }),
                }
            }
        }
    }

    /// Writes the spans from the first strip's upper to the last one's lower edge, where both are
    /// there.
    fn join(&mut self, grid: &Grid<'_>, (first, last): (usize, usize), spans: &mut Vec<Span>) {
        self.components.spans(&self.strips[first].area, grid.columns, spans);
        if last > first {
            self.components.spans(&self.strips[last].area, grid.columns, &mut self.other);
            for (span, other) in spans.iter_mut().zip(&self.other) {
                *span = span.zip(*other).map(|(a, b)| (a.0.min(b.0), a.1.max(b.1)));
            }
        }
    }

    /// Records light that the thinned image did not show.
    pub(crate) fn add_light_inside(&mut self, light_px: f64) {
        if light_px > 0.0 && self.seen.joined < 2 {
            self.seen.joined = 2;
            self.seen.light_inside_px = light_px;
        }
    }

    fn describe(&mut self, first: usize, last: usize) {
        let limits = ShadowLimits::get();
        let strips = &self.strips;
        let number = |to: usize| strips[..to].iter().filter(|s| s.part).count() as u16;
        // From +0: an empty sum of floats is −0.
        let light = strips[first..=last].windows(2).fold(0.0, |sum, pair| sum + gap_px(&pair[0], &pair[1]));
        let thickness_px = strips[last].rows_px.1 - strips[first].rows_px.0;
        let left_out = strips
            .iter()
            .enumerate()
            .filter(|(k, s)| !(first..=last).contains(k) && s.part)
            .map(|(_, s)| s)
            .filter(|s| s.thickness_px() >= limits.as_large * thickness_px)
            .max_by(|a, b| a.thickness_px().total_cmp(&b.thickness_px()));
        self.seen = ShadowsSeen {
            seen: number(strips.len()).max(1),
            measured: number(first) + 1,
            joined: (last - first + 1) as u16,
            light_inside_px: light,
            left_out_px: left_out.map_or(0.0, Strip::thickness_px),
            left_out_row_px: left_out.map_or(0.0, Strip::middle_px),
        };
    }
}

/// Whether an area is the same part beyond an interruption along the field: in other columns, and
/// in at least half of the rows.
fn is_continued(main: &Area, area: &Area) -> bool {
    let common = |a: (u32, u32), b: (u32, u32)| a.1.min(b.1).saturating_sub(a.0.max(b.0));
    let rows = |a: &Area| (a.rows.0, a.rows.1 + 1);
    let least_high = (main.rows.1 - main.rows.0).min(area.rows.1 - area.rows.0) + 1;
    common(main.columns, area.columns) == 0 && 2 * common(rows(main), rows(area)) >= least_high
}

/// Light between two strips, the upper one first, px.
fn gap_px(upper: &Strip, lower: &Strip) -> f64 {
    lower.rows_px.0 - upper.rows_px.1
}

/// The thinner and the thicker of two strips, px, where they run beside each other.
fn beside(upper: &Strip, lower: &Strip) -> Option<(f64, f64)> {
    let from = upper.area.columns.0.max(lower.area.columns.0);
    let to = upper.area.columns.1.min(lower.area.columns.1);
    let common = f64::from(to.saturating_sub(from));
    let (a, b) = (upper.thickness_px(), lower.thickness_px());
    (common >= ShadowLimits::get().beside * upper.columns.max(lower.columns) as f64)
        .then_some((a.min(b), a.max(b)))
}

/// Whether the light between two strips is a line on one part.
fn is_one_part(upper: &Strip, lower: &Strip) -> bool {
    let limits = ShadowLimits::get();
    let gap = gap_px(upper, lower);
    beside(upper, lower).is_some_and(|(thin, thick)| gap <= limits.narrow * thick && gap <= thin)
}

/// Ambiguous strips: equally thick, and closer than two parts usually lie.
fn doubt(upper: &Strip, lower: &Strip) -> Option<String> {
    let limits = ShadowLimits::get();
    let gap = gap_px(upper, lower);
    let (thin, thick) = beside(upper, lower).filter(|_| upper.part && lower.part)?;
    (thin >= limits.equal * thick && gap <= limits.wide * thin).then(|| {
        format!(
            "two shadows {:.0} and {:.0} px thick with {gap:.0} px of light between them may be the walls of one tube or two parts: \
             state it with --which outermost (one part from the first edge to the last) or largest, nearest-centre or 1, 2 ... \
             (one of them, counted from the top)",
            upper.thickness_px(),
            lower.thickness_px()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips `(first row, one after the last)` over a grid of 200 rows x 64 columns.
    fn chosen(strips: &[(usize, usize)], which: Option<Which>) -> Result<(Span, ShadowsSeen), NoShadow> {
        let columns = 64;
        let dark = |row: usize| strips.iter().any(|s| (s.0..s.1).contains(&row));
        let values: Vec<f32> =
            (0..200 * columns).map(|k| if dark(k / columns) { 0.0 } else { 1.0 }).collect();
        let grid = Grid { values: &values, columns, row_step: 1, threshold: 0.5, min_diameter_px: 24.0 };
        let (mut shadows, mut spans) = (Shadows::default(), Vec::new());
        shadows.choose(&grid, which, &mut spans)?;
        Ok((spans[30], shadows.seen))
    }

    #[test]
    fn a_bright_line_parts_no_pin_and_a_wide_gap_two_wires() {
        let pin = chosen(&[(20, 98), (103, 180)], None).unwrap();
        assert_eq!(pin.0, Some((20, 179)));
        assert_eq!((pin.1.joined, pin.1.light_inside_px, pin.1.left_out_px), (2, 5.0, 0.0));
        let wires = chosen(&[(20, 60), (95, 136)], None).unwrap();
        assert_eq!(wires.0, Some((95, 135)));
        assert_eq!((wires.1.seen, wires.1.measured, wires.1.left_out_px), (2, 2, 40.0));
        // A capillary's focal line and both lines of its bore.
        let capillary = chosen(&[(20, 50), (54, 90), (95, 131), (135, 165)], None).unwrap();
        assert_eq!((capillary.0, capillary.1.joined), (Some((20, 164)), 4));
    }

    #[test]
    fn a_tube_is_refused_until_it_is_stated() {
        let tube = [(20, 85), (115, 180)];
        let refused = chosen(&tube, None).unwrap_err();
        assert!(refused.reason == Reason::SeveralShadows && refused.detail.unwrap().contains("outermost"));
        assert_eq!(chosen(&tube, Some(Which::Outermost)).unwrap().0, Some((20, 179)));
        assert_eq!(chosen(&tube, Some(Which::Number(1))).unwrap().0, Some((20, 84)));
        assert_eq!(chosen(&tube, Some(Which::Number(2))).unwrap().0, Some((115, 179)));
        assert_eq!(chosen(&tube, Some(Which::NearestCentre)).unwrap().0, Some((20, 84)));
        assert!(
            chosen(&tube, Some(Which::Number(3)))
                .unwrap_err()
                .detail
                .unwrap()
                .contains(": 2 of 24 px or more lie")
        );
    }

    #[test]
    fn a_thin_strip_beside_a_thick_part_is_neither_joined_nor_as_large() {
        let shaft = chosen(&[(10, 14), (30, 180)], None).unwrap();
        assert_eq!((shaft.0, shaft.1.seen, shaft.1.left_out_px), (Some((30, 179)), 1, 0.0));
    }
}
