//! A touch probe in the tool carrier, and its cycle in a program.
//!
//! The programmed point of the probe is the lowest point of its ball in X and the middle of the
//! ball in Z. A cycle comes down from the clear diameter in a move that ends at the touch (`G31`,
//! `G38.2`), keeps the position of the touch in a macro variable, retracts radially and moves along
//! the part at the clear diameter. Before the touch it moves in its measuring feed, so that an
//! obstacle triggers the probe. Spindle and coolant stand still, the feed is per minute.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::probe_settings::{FAR_MM, NcProbe};
use super::replay::{Convex, Surface};
use super::route::round3;
use super::skeleton::Skeleton;

/// Number of the paper's places: x = 1/6 … 1 from the free end, as shares of the length.
const PLACES: u32 = 6;
/// Most places that fit into the variables and labels of a program.
const MOST_PLACES: usize = 12;
/// First variables of the results before and after the cut.
pub(super) const BEFORE: u32 = 841;
pub(super) const AFTER: u32 = 861;
/// Variables with the results of a qualification: correction, effective diameter of the ball,
/// standard deviation of a touch, run-out of the reference (mm), and the number of the probe's
/// tool.
pub(super) const CORRECTION: u32 = 880;
pub(super) const BALL: u32 = 881;
pub(super) const DEVIATION: u32 = 882;
pub(super) const RUN_OUT: u32 = 883;
pub(super) const QUALIFIED: u32 = 884;
/// Labels of the alarms: result out of range before and after, undersize, oversize.
const LABEL_BEFORE: u32 = 110;
const LABEL_AFTER: u32 = 130;
const LABEL_UNDER: u32 = 150;
const LABEL_OVER: u32 = 170;
/// Tangents that circumscribe the ball, over its lower half.
const BALL_TANGENTS: u32 = 13;

impl NcProbe {
    /// Variable of the touch.
    pub(super) fn variable(&self, dialect: Dialect) -> u32 {
        match dialect {
            Dialect::Linuxcnc => 5061,
            Dialect::Fanuc | Dialect::Gsk | Dialect::Sinumerik => self.skip_variable.unwrap_or(5061),
        }
    }

    /// Outlines of ball, stem and body about the programmed point.
    pub(super) fn outlines(&self) -> Vec<Convex> {
        let r = 0.5 * self.ball_mm;
        let step = std::f64::consts::PI / f64::from(BALL_TANGENTS - 1);
        let out = r / (0.5 * step).cos();
        let corner = |i: u32| {
            let (sin, cos) = (std::f64::consts::PI + (f64::from(i) + 0.5) * step).sin_cos();
            (out * cos, r + out * sin)
        };
        let mut ball: Vec<(f64, f64)> = (0..BALL_TANGENTS - 1).map(corner).collect();
        ball.extend([(-r, r), (r, r), (-r, self.ball_mm), (r, self.ball_mm)]);
        let column = |width: f64, from: f64| {
            let half = 0.5 * width;
            Convex::hull(vec![(-half, from), (half, from), (half, FAR_MM), (-half, FAR_MM)])
        };
        vec![Convex::hull(ball), column(self.stem_mm, r), column(self.body_mm, self.stylus_mm)]
    }
}

/// A cycle along the part: expected diameter and variables of the results.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle<'a> {
    /// Places, Z falling, mm.
    pub(super) places: &'a [f64],
    /// Diameter that the touches are expected at, mm.
    pub(super) expected_mm: f64,
    /// First variable of the results.
    pub(super) variable: u32,
}

/// A number as it follows a variable in an expression.
pub(super) fn signed(value: f64) -> String {
    // a correction of zero is subtracted like any other
    let sign = if value > 0.0 { '+' } else { '-' };
    format!("{sign}{}", number(value.abs(), 5))
}

impl Skeleton<'_> {
    /// Whether the program touches the part with the probe.
    pub(super) fn probes(&self) -> bool {
        self.measures_first || self.probes_after().is_some()
    }

    /// Alarms where the correction is taken from a qualification of this probe and there is none,
    /// or where it departs from the probe's stated correction.
    pub(super) fn qualified(&self) -> Vec<String> {
        let Some(probe) = self.settings.probe.filter(|p| p.stored_correction && self.probes()) else {
            return Vec::new();
        };
        let d = self.dialect;
        let (limit, stored) = (number(self.settings.correction_limit_mm, 4), format!("#{QUALIFIED}"));
        let tool = format!("{}.", probe.tool);
        let mut lines = d.alarm_if(108, (&stored, "NE", &tool), "PROBE IS NOT QUALIFIED");
        let off = format!("ABS[#{CORRECTION}{}]", signed(-probe.correction_mm));
        lines.extend(d.alarm_if(109, (&off, "GT", &limit), "CORRECTION OUT OF RANGE"));
        lines
    }

    /// The spindle turned to its angle, or to the opposite one, and held; nothing where the control
    /// has no such code.
    pub(super) fn hold_spindle(&self, opposite: bool) -> Vec<String> {
        let orientation = self.settings.spindle_orientation;
        orientation.map(|o| self.dialect.orient(o, opposite)).into_iter().collect()
    }

    /// The spindle let go; the codes that start or stop it do so by themselves on most controls.
    pub(super) fn release_spindle(&self) -> Vec<String> {
        let release = self.settings.spindle_orientation.and_then(|o| o.release_m_code);
        release.map(|code| format!("M{code:02}")).into_iter().collect()
    }

    /// The probe where the part is probed after this program's cut.
    pub(super) fn probes_after(&self) -> Option<(NcProbe, (f64, f64))> {
        self.settings.probe.zip(self.limits_mm)
    }

    /// Places that the probe touches, Z falling, mm: those of the part, else the paper's six, the
    /// one at the chuck moved to where ball and body are clear of the uncut length and of the space
    /// behind Z 0.
    ///
    /// # Errors
    /// Where a listed place cannot be touched, or too many or too few are listed.
    pub(super) fn places(&self, probe: &NcProbe) -> Result<Vec<f64>, NcError> {
        let (length, ball) = (self.piece.length_mm, 0.5 * probe.ball_mm);
        let body = if self.settings.chuck.is_none() { 0.5 * probe.body_mm } else { 0.0 };
        // over an uncut collar the ball would touch the collar
        let least = (self.route.full_from_mm + ball).max(body);
        let mut places: Vec<f64> = match &self.piece.probe_z_mm[..] {
            [] => (1..=PLACES)
                .map(|i| round3((length * (1.0 - f64::from(i) / f64::from(PLACES))).max(least)))
                .collect(),
            listed => listed.iter().rev().map(|z| round3(*z)).collect(),
        };
        places.dedup();
        if !(2..=MOST_PLACES).contains(&places.len()) {
            return Err(NcError::Plan(format!(
                "{} places are probed (part.station_z_mm); a program holds 2 to {MOST_PLACES}",
                places.len()
            )));
        }
        if let Some(z) = places.iter().find(|z| **z < least - 1e-9 || **z > length - ball) {
            return Err(NcError::Plan(format!(
                "the probe cannot touch at Z {z} mm (part.station_z_mm): its ball and body are clear from Z {least} mm \
                 (what stays uncut; the room behind Z 0 where nc.chuck is not stated) to {} mm",
                length - ball
            )));
        }
        Ok(places)
    }

    /// To the change position, the probe, along the places, and back to the change position.
    pub(super) fn cycle(&self, probe: &NcProbe, cycle: Cycle<'_>) -> Vec<String> {
        let (d, route) = (self.dialect, &self.route);
        let mut lines = d.to_change(route.change);
        lines.push(d.spindle_off().to_owned());
        lines.extend(d.tool(probe.tool, probe.tool));
        lines.extend(self.hold_spindle(false));
        lines.push(d.feed_per_minute().to_owned());
        let target = number(cycle.expected_mm - 2.0 * probe.reach_mm, 3);
        let limit = number(self.settings.correction_limit_mm, 4);
        let label = if cycle.variable == BEFORE { LABEL_BEFORE } else { LABEL_AFTER };
        for ((i, z), n) in cycle.places.iter().enumerate().zip(0_u32..) {
            match i {
                0 => lines.extend(d.approach(route.change, *z, route.clear_mm)),
                _ => lines.push(format!("G00 Z{}", number(*z, 3))),
            }
            let variable = format!("#{}", cycle.variable + n);
            lines.push(format!("{} X{target} F{}", d.probing_move(), number(probe.feed_mm_per_min, 1)));
            lines.push(format!("{variable}={}", self.touched(probe)));
            lines.push(format!("G00 X{}", number(route.clear_mm, 3)));
            let off = format!("ABS[{variable}-{}]", number(cycle.expected_mm, 4));
            lines.extend(d.alarm_if(label + n, (&off, "GT", &limit), "PROBE RESULT OUT OF RANGE"));
        }
        lines.extend(d.to_change(route.change));
        lines.extend(self.release_spindle());
        lines.push(d.feed_per_revolution().to_owned());
        lines
    }

    /// X of the touch as a diameter, as an expression.
    pub(super) fn read(&self, probe: &NcProbe) -> String {
        let variable = probe.variable(self.dialect);
        match self.dialect {
            // its #5061 is a radius, even under G7
            Dialect::Linuxcnc => format!("2.*#{variable}"),
            Dialect::Fanuc | Dialect::Gsk | Dialect::Sinumerik => format!("#{variable}"),
        }
    }

    /// The diameter of the touch, as an expression.
    fn touched(&self, probe: &NcProbe) -> String {
        let read = self.read(probe);
        if probe.stored_correction {
            return format!("[{read}-#{CORRECTION}]");
        }
        format!("[{read}{}]", signed(-probe.correction_mm))
    }

    /// Limits that a probed diameter must keep so that conformity is proven: the tolerance reduced
    /// by U at both ends.
    ///
    /// # Errors
    /// Where U takes up the whole tolerance.
    pub(super) fn proven_limits(probe: &NcProbe, limits: (f64, f64)) -> Result<(f64, f64), NcError> {
        let (low, high) = (limits.0 + probe.expanded_u_mm, limits.1 - probe.expanded_u_mm);
        if low < high {
            return Ok((low, high));
        }
        Err(NcError::Plan(format!(
            "nc.probe.expanded_u_mm = {} leaves nothing of the tolerance of {} to {} mm: no result could prove conformity",
            probe.expanded_u_mm, limits.0, limits.1
        )))
    }

    /// Probes the part after the cut; then its alarms at the change position, where a tolerance is
    /// given.
    ///
    /// # Errors
    /// Places or limits that cannot be.
    pub(super) fn probe_again(
        &self,
        probe: &NcProbe,
        nominal_mm: f64,
        limits: Option<(f64, f64)>,
    ) -> Result<Vec<String>, NcError> {
        let places = self.places(probe)?;
        let mut lines =
            self.cycle(probe, Cycle { places: &places, expected_mm: nominal_mm, variable: AFTER });
        let Some(limits) = limits else { return Ok(lines) };
        let (low, high) = Self::proven_limits(probe, limits)?;
        for n in (0_u32..).take(places.len()) {
            let found = format!("#{}", AFTER + n);
            let d = self.dialect;
            lines.extend(d.alarm_if(LABEL_UNDER + n, (&found, "LT", &number(low, 4)), "PART UNDERSIZE"));
            lines.extend(d.alarm_if(LABEL_OVER + n, (&found, "GT", &number(high, 4)), "PART OVERSIZE"));
        }
        Ok(lines)
    }

    /// The surface that a probe touches in a replay, where the part before and after the cut is
    /// nominal.
    pub(super) fn surface(&self, nominal_mm: f64) -> Option<Surface> {
        self.settings.probe?;
        // after the correction the part has its target diameter, or that in the middle of its
        // tolerance
        let after = self.limits_mm.map_or(nominal_mm, |(low, high)| 0.5 * (low + high));
        let [before, after] = [self.piece.before_mm, after].map(|d| vec![(0.0, d)]);
        Some(Surface { before, after, ..Surface::default() })
    }
}
