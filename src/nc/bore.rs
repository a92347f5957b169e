//! A finishing cut in a bore: its places, and what stands around a boring bar.
//!
//! ```text
//!    chuck |############## material ##############| end face
//!          |------ drilled hole, hole_mm ---------|
//!          |     <- - - - rapid, clear_mm - - - - - - - - x  rapid along X before it
//!          |- - - - - - - - axis - - - - - - - - -|
//! ```
//!
//! Solids are in (Z, distance from the axis) on both sides of the axis: the bar reaches beyond it.
//! From every clear place the way out is along Z, towards the tailstock. The drilled hole bounds
//! the rapids; the bar keeps off the finished bore in feed as well. Where the part's outer diameter
//! is not stated all room beside the hole is material.

use glam::DVec2;

use super::error::NcError;
use super::machine::{BoringBar, ChangePosition, Tailstock};
use super::replay::{BoreSpace, CommandedCut, Convex, Solid, WorkingSpace};
use super::route::Route;
use super::settings::NcSettings;
use super::skeleton::Skeleton;
use super::surroundings::PARKED_HEAD;
use crate::outline::Outline;

/// A length beyond all dimensions of a lathe, mm.
const FAR_MM: f64 = 1e4;
/// Distance between the change position and everything that stands around the part, mm of diameter
/// or of Z: as for shafts.
const ROOM_AT_CHANGE_MM: f64 = 20.0;
/// Largest sagitta of the chords that stand for a finished arc, mm: as close as a bar may pass.
const SAGITTA_MM: f64 = 1e-3;

/// What is bored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bore<'a> {
    /// Diameter of the drilled hole, mm.
    pub hole_mm: f64,
    /// Outer diameter of the part, mm; none where it is not stated.
    pub outer_mm: Option<f64>,
    /// The finished bore.
    pub outline: &'a Outline,
}

/// The data that the bar and its room need.
///
/// # Errors
/// Data that are not stated, in words.
fn bar_of(settings: &NcSettings) -> Result<BoringBar, NcError> {
    if settings.tailstock != Some(Tailstock::Absent) {
        return Err(NcError::Plan(
            "a bore is entered from the tailstock's side: the machine's data must state tailstock = \"none\""
                .into(),
        ));
    }
    settings.boring_bar.ok_or_else(|| {
        NcError::Plan(
            "the machine's data lack boring_bar (diameter_mm, tip_mm, reach_mm): what goes into the bore with the nose"
                .into(),
        )
    })
}

impl Bore<'_> {
    fn end_mm(&self) -> f64 {
        self.outline.z_mm().1
    }

    fn outside_mm(&self) -> f64 {
        self.outer_mm.map_or(FAR_MM, |d| 0.5 * d)
    }

    /// Places of a program; `nose` is the nose's outline about the gauge point, `radius_mm` that of
    /// the control's register, `entry` where the first feed along the contour begins.
    ///
    /// # Errors
    /// A hole too narrow for the clearance, a change position beside the part, data that are
    /// missing.
    pub(super) fn route(
        &self,
        settings: &NcSettings,
        (nose, radius_mm): (&[DVec2], f64),
        entry: DVec2,
    ) -> Result<Route, NcError> {
        let bar = bar_of(settings)?;
        let top = nose.iter().map(|p| p.x).fold(0.0, f64::max);
        let clear_mm = self.hole_mm - settings.clearance_mm - 2.0 * top;
        if clear_mm <= 0.0 || 0.5 * settings.clearance_mm <= radius_mm {
            return Err(NcError::Plan(format!(
                "a drilled hole of {} mm with clearance_mm = {}: the tool's point must pass inside of it on a positive \
                 diameter, {clear_mm:.3} mm here, and the compensation ends on half the clearance, more than R = {radius_mm}; \
                 state hole_diameter_mm, or another clearance_mm",
                self.hole_mm, settings.clearance_mm
            )));
        }
        let change = settings.change_position.unwrap_or_else(|| self.assumed_change(settings));
        let least = self.end_mm() + bar.front_mm + settings.clearance_mm;
        if change.z_mm < least {
            return Err(NcError::Plan(format!(
                "change_position.z_mm = {}: must be {least} mm or more, where the bar stands before the bore",
                change.z_mm
            )));
        }
        let z = super::route::round3(entry.y);
        let nose_mm = settings.nose_radius_mm.unwrap_or_default();
        Ok(Route { change, clear_mm, z_first: z, z_last: z, nose_mm, full_from_mm: 0.0 })
    }

    fn assumed_change(&self, settings: &NcSettings) -> ChangePosition {
        let chuck = settings.chuck.map_or(0.0, |c| c.jaws_diameter_mm.unwrap_or(0.0).max(c.diameter_mm));
        let part = self.outer_mm.unwrap_or(2.0 * self.outline.largest_radius_mm());
        let reach = settings.boring_bar.map_or(0.0, |bar| bar.front_mm);
        ChangePosition {
            x_mm: (chuck.max(part) + ROOM_AT_CHANGE_MM).ceil(),
            z_mm: (self.end_mm() + reach + 2.0 * ROOM_AT_CHANGE_MM).ceil(),
        }
    }

    /// What the bar is in a program's head.
    pub(super) fn words(&self, settings: &NcSettings) -> Vec<String> {
        let bar = settings.boring_bar.map(|bar| {
            format!(
                "boring bar of {} mm, its axis {} mm beside the point, {} mm long",
                bar.diameter_mm, bar.tip_mm, bar.reach_mm
            )
        });
        let hole = format!("finishing cut in a hole of {} mm, roughed to the contour", self.hole_mm);
        [hole].into_iter().chain(bar).collect()
    }

    /// The solids, the drilled part and the bar for a replay of a program.
    ///
    /// # Errors
    /// Data that are not stated.
    pub(super) fn working_space<'s>(
        &self,
        skeleton: &Skeleton<'s>,
        nose: &[DVec2],
    ) -> Result<WorkingSpace<'s>, NcError> {
        let settings = skeleton.settings;
        let bar = bar_of(settings)?;
        let mut solids = skeleton.chuck();
        solids.extend(self.rests(settings));
        if let Some(h) = settings.gauge_head {
            let shape = Convex::cylinder(h.from_z_mm, h.to_z_mm, h.diameter_mm);
            solids.push(Solid { what: PARKED_HEAD, shape });
        }
        let mut space = skeleton.working_space(vec![(0.0, -FAR_MM)]);
        space.solids = both_sides(solids);
        space.stock = both_sides(self.drilled(0.0));
        space.kept_clear = both_sides(self.drilled(0.25 * settings.clearance_mm))
            .into_iter()
            .map(|solid| solid.shape)
            .collect();
        space.tool = tool(&bar, nose);
        let finished = self.finished().into_iter().flat_map(|shape| [shape.mirrored(), shape]);
        space.bore = Some(BoreSpace { finished: finished.collect() });
        // how deep it cuts is judged by what it leaves of the outline, not by stations
        space.cut = CommandedCut { commanded: vec![(0.0, -FAR_MM)], between: (0.0, 0.0), solid: None };
        Ok(space)
    }

    /// The part around the drilled hole with `clear_mm` of radius around its material, on one side
    /// of the axis; towards the end face the tool feeds in from outside.
    fn drilled(&self, clear_mm: f64) -> Vec<Solid> {
        let (from, end) = (-clear_mm, self.end_mm());
        let (inside, outside) = (0.5 * self.hole_mm - clear_mm, self.outside_mm() + clear_mm);
        let ring = |from: f64, to: f64, inside: f64| {
            Convex::hull(vec![(from, inside), (to, inside), (to, outside), (from, outside)])
        };
        let mut solids = vec![Solid { what: "stock around the hole", shape: ring(from, end, inside) }];
        if let Some(bottom) = self.bottom_mm() {
            solids.push(Solid { what: "bottom of the hole", shape: ring(from, bottom + clear_mm, 0.0) });
        }
        solids
    }

    /// Z of the bottom of a blind hole, mm; none of a through one.
    fn bottom_mm(&self) -> Option<f64> {
        let last = self.outline.pieces.last()?;
        (last.to.x < 0.5 * self.hole_mm).then_some(self.outline.z_mm().0)
    }

    /// The material around the finished bore in convex parts, on one side of the axis.
    fn finished(&self) -> Vec<Convex> {
        let outside = self.outside_mm();
        let of =
            |a: DVec2, b: DVec2| Convex::hull(vec![(a.y, a.x), (b.y, b.x), (b.y, outside), (a.y, outside)]);
        let points = self.outline.pieces.iter().flat_map(|piece| {
            let points = piece.points(SAGITTA_MM);
            points.windows(2).map(|w| (w[0], w[1])).collect::<Vec<_>>()
        });
        let mut parts: Vec<Convex> = points.filter(|(a, b)| a.y != b.y).map(|(a, b)| of(a, b)).collect();
        let (from, hole) = (self.outline.z_mm().0, 0.5 * self.hole_mm);
        let inside = if self.bottom_mm().is_some() { 0.0 } else { hole };
        parts.push(of(DVec2::new(inside, 0.0), DVec2::new(inside, from)));
        parts
    }

    /// Steady rests around the part, where its outside is known; else all of it is material.
    fn rests(&self, settings: &NcSettings) -> Vec<Solid> {
        let Some(outer_mm) = self.outer_mm else { return Vec::new() };
        let ring = |o: &super::machine::Obstacle| {
            let (inside, outside) = (0.5 * outer_mm, 0.5 * o.diameter_mm);
            let (from, to) = (o.from_z_mm, o.to_z_mm);
            let shape = Convex::hull(vec![(from, inside), (to, inside), (to, outside), (from, outside)]);
            Solid { what: "steady rest", shape }
        };
        settings.steady_rests.iter().flatten().map(ring).collect()
    }
}

/// Solids with their counterparts beyond the axis.
fn both_sides(solids: Vec<Solid>) -> Vec<Solid> {
    let other = |s: Solid| [Solid { what: s.what, shape: s.shape.mirrored() }, s];
    solids.into_iter().flat_map(other).collect()
}

/// Nose with the head that carries it, bar, and what holds the bar, about the programmed point.
fn tool(bar: &BoringBar, nose: &[DVec2]) -> Vec<Convex> {
    let tip: Vec<(f64, f64)> = nose.iter().map(|p| (p.y, p.x)).collect();
    let ((left, _), (right, _)) = Convex::hull(tip.clone()).bounds();
    let (axis, half) = (-bar.tip_mm, 0.5 * bar.diameter_mm);
    let box_of = |from: f64, to: f64, low: f64, high: f64| {
        Convex::hull(vec![(from, low), (to, low), (to, high), (from, high)])
    };
    let head = tip.into_iter().chain([(left, axis), (right, axis)]).collect();
    vec![
        Convex::hull(head),
        box_of(left.min(-bar.front_mm), bar.reach_mm, axis - half, axis + half),
        box_of(bar.reach_mm, FAR_MM, -FAR_MM, FAR_MM),
    ]
}
