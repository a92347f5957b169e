//! Checks the events of a program against the list in [`super`].

use super::bore_space::{BoreSpace, is_out_of_bore};
use super::commanded_scan::CommandedScan;
use super::convex::Convex;
use super::event::{Deed, Event, Point};
use super::finished::FinishedSolid;
use super::interpreter::Control;
use super::run::run;
use super::surface::Surface;
use crate::nc::dialect::Dialect;
use crate::nc::error::NcError;
use crate::nc::machine::{ChangePosition, Travel};
use crate::nc::nose_words::NoseRegister;
use crate::nc::probe::QUALIFIED;
use crate::nc::settings::NcSettings;
use crate::numerics::neighbours::{linear_between, neighbours};

/// Deviation from the commanded diameter allowed for rounding and interpolation between knots, mm
/// of diameter.
const DEPTH_TOLERANCE_MM: f64 = 0.005;
/// Distance below which positions are the same, mm.
const SAME_MM: f64 = 1e-6;
/// Distance of start positions from the corners of solids, mm.
const BESIDE_MM: f64 = 0.05;
/// Lattice of start positions, along Z and along X.
const LATTICE: (usize, usize) = (9, 6);

/// A solid in the machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Solid {
    /// Its name in a refusal.
    pub what: &'static str,
    /// Its outline, from the axis outwards.
    pub shape: Convex,
}

/// The cut that is commanded.
#[derive(Clone, Debug, Default)]
pub(crate) struct CommandedCut {
    /// Commanded diameters, (Z, X), Z ascending; level beyond both ends.
    pub commanded: Vec<(f64, f64)>,
    /// Programmed Z between which the part must be cut.
    pub between: (f64, f64),
    /// The finished solid of a stepped shaft: it stands in place of the commanded diameters.
    pub solid: Option<FinishedSolid>,
}

/// The surroundings in which a program moves.
#[derive(Clone, Debug)]
pub(crate) struct WorkingSpace<'a> {
    /// The control.
    pub dialect: Dialect,
    /// How it reads offsets.
    pub settings: &'a NcSettings,
    /// Solids that must never be touched.
    pub solids: Vec<Solid>,
    /// The part before the pass: touched in feed alone.
    pub stock: Vec<Solid>,
    /// Regions that no rapid may enter: the stock with half the clearance around it.
    pub kept_clear: Vec<Convex>,
    /// Outlines of the tool about the programmed point, (Z, radius).
    pub tool: Vec<Convex>,
    /// What a bore is besides stock; none of a shaft.
    pub bore: Option<BoreSpace>,
    /// Outlines of the probe about its programmed point; none without a probe.
    pub probe: Vec<Convex>,
    /// The surface that the probe touches.
    pub surface: Option<Surface>,
    /// Where the tool is changed.
    pub change: ChangePosition,
    /// The cut that is commanded.
    pub cut: CommandedCut,
    /// Where the tip can travel.
    pub travel: Option<Travel>,
    /// Outlines of the gauge head about the axis at the programmed Z; none where it is parked.
    pub head: Vec<Convex>,
    /// The scan that is commanded.
    pub scan: Option<CommandedScan>,
    /// Radius and tip direction on the page of the tool's offset, where the program does not write
    /// them.
    pub tool_page: Option<NoseRegister>,
    /// Variables left by an earlier run: they must not stop the program.
    pub variables: Vec<(u32, f64)>,
}

/// Replays `text` from every clear start position.
///
/// # Errors
/// [`NcError::Block`] with the first block that is refused.
pub(crate) fn check(text: &str, working_space: &WorkingSpace<'_>) -> Result<usize, NcError> {
    let mut starts: Vec<(Point, bool)> = working_space.starts().into_iter().map(|at| (at, false)).collect();
    if !working_space.probe.is_empty() {
        // the previous program may have left the probe in the carrier
        starts.extend(working_space.starts_of(&working_space.probe).into_iter().map(|at| (at, true)));
    }
    from(text, working_space, &starts)
}

/// Replays `text` from the change position alone: enough where the same text has been replayed from
/// every start position before.
///
/// # Errors
/// As [`check`].
pub(crate) fn check_once(text: &str, working_space: &WorkingSpace<'_>) -> Result<usize, NcError> {
    from(text, working_space, &[(working_space.at_change(), false)])
}

/// Replays `text` from the change position: it must keep clear of everything until it stops with an
/// alarm.
///
/// # Errors
/// As [`check`]; a program that runs to its end.
pub(crate) fn must_alarm(text: &str, working_space: &WorkingSpace<'_>) -> Result<(), NcError> {
    let refused = refusal(text);
    let mut events = run(text, &working_space.control(working_space.at_change())).map_err(&refused)?;
    match events.pop() {
        Some(Event { deed: Deed::Alarm(_), .. }) => working_space.judge(&events).map_err(refused),
        _ => Err(refused((text.lines().count(), "the program ends where it must raise an alarm".into()))),
    }
}

fn refusal(text: &str) -> impl Fn((usize, String)) -> NcError + '_ {
    |(block, what)| NcError::Block {
        block,
        text: text.lines().nth(block.saturating_sub(1)).unwrap_or_default().trim().to_owned(),
        what,
    }
}

fn from(text: &str, working_space: &WorkingSpace<'_>, starts: &[(Point, bool)]) -> Result<usize, NcError> {
    let refused = refusal(text);
    let mut first: Option<Vec<Event>> = None;
    for &(start, with_probe) in starts {
        let control = Control { with_probe, ..working_space.control(start) };
        let events = run(text, &control).map_err(&refused)?;
        // from where the moves coincide with those from another start, the rest is the same
        let same = first.as_ref().map_or(0, |f| common_end(f, &events));
        working_space.judge(&events[..events.len() - same]).map_err(&refused)?;
        if first.is_none() {
            let last = text.lines().count();
            working_space.covers(&events).map_err(|what| refused((last, what)))?;
            if let Some(scan) = &working_space.scan {
                scan.covered(&events).map_err(&refused)?;
            }
            first = Some(events);
        }
    }
    match first {
        Some(_) => Ok(starts.len()),
        None => Err(NcError::Plan("no start position is clear of what stands around the part".into())),
    }
}

fn common_end(a: &[Event], b: &[Event]) -> usize {
    a.iter().rev().zip(b.iter().rev()).take_while(|(a, b)| a == b).count()
}

impl WorkingSpace<'_> {
    /// State of the control when the program starts at `start`.
    pub(crate) fn control(&self, start: Point) -> Control<'_> {
        Control {
            dialect: self.dialect,
            settings: self.settings,
            start,
            reference: Point { x: self.change.x_mm, z: self.change.z_mm },
            variables: self.variables.clone(),
            with_probe: false,
            surface: self.surface.clone(),
            tool_page: self.tool_page,
        }
    }

    /// The same working space without the results of a qualification.
    #[must_use]
    pub(in crate::nc) fn unqualified(mut self) -> Self {
        self.variables.retain(|(variable, _)| *variable != QUALIFIED);
        self.variables.push((QUALIFIED, 0.0));
        self
    }

    fn at_change(&self) -> Point {
        Point { x: self.change.x_mm, z: self.change.z_mm }
    }

    /// Start positions that are clear of every solid: a lattice over the space between chuck and
    /// change position, and places just beside the corners of the solids.
    pub(crate) fn starts(&self) -> Vec<Point> {
        self.starts_of(&self.tool)
    }

    fn starts_of(&self, tool: &[Convex]) -> Vec<Point> {
        let end = self.change.z_mm.max(self.cut.between.1);
        let mut places = vec![self.at_change()];
        for i in 0..LATTICE.0 {
            for j in 0..LATTICE.1 {
                let (z, x) = (i as f64 / (LATTICE.0 - 1) as f64, j as f64 / (LATTICE.1 - 1) as f64);
                places.push(Point { x: 1.5 * x * self.change.x_mm, z: 1.25 * z * end });
            }
        }
        let ((left, bottom), (right, top)) = tool.first().map_or(((0.0, 0.0), (0.0, 0.0)), Convex::bounds);
        for solid in self.solids.iter().chain(&self.stock) {
            for &(z, r) in solid.shape.points().iter().filter(|p| p.0.abs() < 1e3 && p.1 < 1e3) {
                let x = 2.0 * (r - bottom + BESIDE_MM);
                places.push(Point { x, z });
                if self.bore.is_some() {
                    places.push(Point { x: 2.0 * (r - top - BESIDE_MM), z });
                }
                places.push(Point { x: 2.0 * (r - bottom), z: z - right - BESIDE_MM });
                places.push(Point { x: 2.0 * (r - bottom), z: z - left + BESIDE_MM });
            }
        }
        // the reference point lies at the end of the travel
        let most = if self.dialect.changes_at_reference() { self.change.x_mm } else { f64::INFINITY };
        let reachable = |p: &Point| (0.0..=most).contains(&p.x) && self.travel.is_none_or(|t| within(&t, *p));
        places.retain(|p| reachable(p) && self.is_clear(tool, *p));
        places
    }

    fn is_clear(&self, tool: &[Convex], at: Point) -> bool {
        let by = (at.z, 0.5 * at.x);
        let free = |shape: &Convex| !tool.iter().any(|t| t.moved(by).meets(shape));
        let head_is_clear = self.head_touches(at.z, at.z).is_none();
        head_is_clear && self.solids.iter().chain(&self.stock).all(|s| free(&s.shape))
    }

    /// What the gauge head touches on the way of the carriage from one Z to another; it does not
    /// move along X.
    fn head_touches(&self, from_z: f64, to_z: f64) -> Option<&'static str> {
        let swept: Vec<Convex> = self.head.iter().map(|h| h.swept((from_z, 0.0), (to_z, 0.0))).collect();
        let meets = |shape: &Convex| swept.iter().any(|h| h.meets(shape));
        let solids = || self.solids.iter().chain(&self.stock);
        let touched = solids().find(|s| meets(&s.shape)).map(|s| s.what);
        touched.or_else(|| self.kept_clear.iter().any(meets).then_some("clearance of the stock"))
    }

    fn judge_head(&self, from: Point, to: Point) -> Result<(), String> {
        match self.head_touches(from.z, to.z) {
            None => Ok(()),
            Some(what) => Err(format!("the gauge head touches the {what} {}", way(from, to))),
        }
    }

    fn judge(&self, events: &[Event]) -> Result<(), (usize, String)> {
        // after a touch the ball overlaps the part by its pre-travel: retracting straight out is
        // allowed
        let mut touched = false;
        for event in events {
            let after_touch = std::mem::replace(&mut touched, matches!(event.deed, Deed::Probe { .. }));
            let judged = match &event.deed {
                Deed::Move { from, to, rapid: true } if after_touch && is_outwards(*from, *to) => {
                    self.judge_way(&self.probe, *from, *to, "in rapid").map(drop)
                }
                Deed::Move { from, to, rapid } => {
                    let tool = if event.with_probe { &self.probe } else { &self.tool };
                    self.judge_head(*from, *to).and_then(|()| self.judge_move(tool, *from, *to, *rapid))
                }
                Deed::Probe { from, target, .. } => self.judge_probing(*from, *target),
                Deed::ToolChange(at) => self.only_at_change("the tool is changed", *at),
                Deed::Measure(at) => self.only_at_change("the part is measured", *at),
                Deed::Trigger(_) if self.scan.is_some() => Ok(()),
                Deed::Trigger(_) => Err("the gauge head is triggered in a program that scans nothing".into()),
                Deed::Alarm(text) => Err(format!("the replay ends with the alarm {text}")),
            };
            judged.map_err(|what| (event.block, what))?;
        }
        Ok(())
    }

    fn only_at_change(&self, what: &str, at: Point) -> Result<(), String> {
        let c = self.change;
        if (at.x - c.x_mm).abs() < SAME_MM && (at.z - c.z_mm).abs() < SAME_MM {
            return Ok(());
        }
        Err(format!(
            "{what} at X {:.3} Z {:.3}, not at the change position X {:.3} Z {:.3}",
            at.x, at.z, c.x_mm, c.z_mm
        ))
    }

    /// A probing move keeps clear of everything but the part, even where no touch ends it.
    fn judge_probing(&self, from: Point, target: Point) -> Result<(), String> {
        if !self.is_clear(&self.probe, from) {
            let way = way(from, target);
            return Err(format!("a probing move begins where the probe touches something, {way}"));
        }
        self.judge_way(&self.probe, from, target, "in a probing move").map(drop)
    }

    fn inside_travel(&self, to: Point, way: &str) -> Result<(), String> {
        if let Some(travel) = self.travel.filter(|t| !within(t, to)) {
            return Err(format!(
                "it leaves the travel (X {} to {}, Z {} to {}) {way}",
                travel.x_mm.0, travel.x_mm.1, travel.z_mm.0, travel.z_mm.1
            ));
        }
        Ok(())
    }

    /// The region that the tool sweeps on its way, which must be clear of every solid and inside
    /// the travel.
    fn judge_way(&self, tool: &[Convex], from: Point, to: Point, how: &str) -> Result<Vec<Convex>, String> {
        let way = way(from, to);
        self.inside_travel(to, &way)?;
        let (a, b) = ((from.z, 0.5 * from.x), (to.z, 0.5 * to.x));
        let swept: Vec<Convex> = tool.iter().map(|t| t.swept(a, b)).collect();
        match self.solids.iter().find(|s| swept.iter().any(|t| t.meets(&s.shape))) {
            Some(solid) => Err(format!("{how} the tool touches the {} {way}", solid.what)),
            None => Ok(swept),
        }
    }

    fn judge_move(&self, tool: &[Convex], from: Point, to: Point, rapid: bool) -> Result<(), String> {
        let way = way(from, to);
        let both = (from.x - to.x).abs() > SAME_MM && (from.z - to.z).abs() > SAME_MM;
        if rapid && both && from.x.min(to.x) < self.change.x_mm {
            return Err(format!("X and Z move in rapid together below the change position, {way}"));
        }
        let swept = self.judge_way(tool, from, to, if rapid { "in rapid" } else { "in feed" })?;
        let touches = |shape: &Convex| swept.iter().any(|s| s.meets(shape));
        if !rapid {
            if let Some(bore) = &self.bore {
                bore.bar_is_free(&swept[1..]).map_err(|what| format!("{what} {way}"))?;
            }
            return self.not_too_deep(from, to);
        }
        if let Some(solid) = self.stock.iter().find(|s| touches(&s.shape)) {
            return Err(format!("in rapid the tool touches the {} {way}", solid.what));
        }
        // a start beside the stock may lie within the clearance: leaving it is allowed
        let leaves = if self.bore.is_some() { is_out_of_bore(from, to) } else { is_outwards(from, to) };
        if !leaves && self.kept_clear.iter().any(touches) {
            return Err(format!("in rapid the tool comes closer to the stock than half the clearance {way}"));
        }
        Ok(())
    }

    /// Z of the knots of the commanded diameter and of the move, between `a` and `b`.
    fn bends(&self, a: f64, b: f64) -> Vec<f64> {
        let (low, high) = (a.min(b), a.max(b));
        let first = self.cut.commanded.partition_point(|p| p.0 < low);
        let inside = self.cut.commanded[first..].iter().map(|p| p.0).take_while(|z| *z <= high);
        [low, high].into_iter().chain(inside).collect()
    }

    fn commanded_at(&self, z: f64) -> f64 {
        linear_between(neighbours(&self.cut.commanded, |p| p.0 < z), z, |p| *p).unwrap_or(f64::INFINITY)
    }

    fn tolerance_mm(&self) -> f64 {
        DEPTH_TOLERANCE_MM + self.settings.knot_tolerance_mm
    }

    fn not_too_deep(&self, from: Point, to: Point) -> Result<(), String> {
        if let Some(solid) = &self.cut.solid {
            return solid.not_too_deep(from, to, 0.5 * self.tolerance_mm());
        }
        for z in self.bends(from.z, to.z) {
            let (x, wanted) = (lowest_at(from, to, z), self.commanded_at(z));
            if x < wanted - self.tolerance_mm() {
                return Err(format!("at Z {z:.3} it cuts to X {x:.4}, below the commanded {wanted:.4}"));
            }
        }
        Ok(())
    }

    /// Whether feeds at the commanded diameter cover the part.
    fn covers(&self, events: &[Event]) -> Result<(), String> {
        if let Some(solid) = &self.cut.solid {
            let feed = |event: &Event| match &event.deed {
                Deed::Move { from, to, rapid: false } => Some((*from, *to)),
                _ => None,
            };
            let feeds: Vec<(Point, Point)> = events.iter().filter_map(feed).collect();
            return solid.covered(&feeds, self.cut.between, 0.5 * self.tolerance_mm());
        }
        let mut cut: Vec<(f64, f64)> = Vec::new();
        for event in events {
            let Deed::Move { from, to, rapid: false } = &event.deed else { continue };
            let on_size = |z: &f64| lowest_at(*from, *to, *z) <= self.commanded_at(*z) + self.tolerance_mm();
            if self.bends(from.z, to.z).iter().all(on_size) {
                cut.push((from.z.min(to.z), from.z.max(to.z)));
            }
        }
        cut.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (begin, end) = self.cut.between;
        let mut reached = begin;
        for (from, to) in cut {
            if from > reached + SAME_MM {
                break;
            }
            reached = reached.max(to);
        }
        if reached + SAME_MM >= end {
            return Ok(());
        }
        Err(format!("the part is not cut to size from Z {reached:.3} on, its end face lies at Z {end:.3}"))
    }
}

fn way(from: Point, to: Point) -> String {
    format!("from X {:.3} Z {:.3} to X {:.3} Z {:.3}", from.x, from.z, to.x, to.z)
}

fn is_outwards(from: Point, to: Point) -> bool {
    (from.z - to.z).abs() <= SAME_MM && to.x > from.x
}

/// The smaller X of a move at `z`.
fn lowest_at(from: Point, to: Point, z: f64) -> f64 {
    if (to.z - from.z).abs() < SAME_MM {
        return from.x.min(to.x);
    }
    let share = ((z - from.z) / (to.z - from.z)).clamp(0.0, 1.0);
    from.x + (to.x - from.x) * share
}

fn within(travel: &Travel, at: Point) -> bool {
    let inside = |(least, most): (f64, f64), v: f64| (least - SAME_MM..=most + SAME_MM).contains(&v);
    inside(travel.x_mm, at.x) && inside(travel.z_mm, at.z)
}
