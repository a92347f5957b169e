//! A program that qualifies the probe on a reference diameter, and stores the results in macro
//! variables.
//!
//! The reference (a ring, disc or cylinder whose outer diameter is certified) stands in the part's
//! place. It is touched n times at one place, from above, as every part is; where the control can
//! hold the spindle, n times more with the spindle turned by 180°, so that the run-out of the
//! reference cancels in the mean.
//!
//! ```text
//! #880  mean of X of the touches, less the diameter: correction of a probed X
//!       (setting, pre-travel and delay)
//! #881  ball + #880: effective diameter of the ball, pre-travel included
//! #882  sqrt(sum of (touch - mean of its side)^2 / freedom): standard deviation of one touch
//! #883  half the difference of both sides' means: indicated run-out of the reference; 0 from one
//!       side alone
//! #884  number of the probe's tool, written last; programs with `stored_correction` check it
//! ```
//!
//! The touches stand in #885-#893 and #894-#902. #884 is cleared first, so that a program that
//! stops with an alarm leaves no qualification: a touch farther than `correction_limit_mm` from the
//! position expected from the probe's data, or 2 x #882 above the stated U.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::probe::{BALL, CORRECTION, DEVIATION, QUALIFIED, RUN_OUT, signed};
use super::probe_settings::{NcProbe, ProbeReference};
use super::replay::{self, CommandedCut, Surface, WorkingSpace};
use super::route::Workpiece;
use super::settings::NcSettings;
use super::skeleton::{self, Skeleton};
use super::turning::Written;
use crate::plan::CuttingData;

/// First variables of the touches at the angle and at the opposite one.
const TOUCHES: [u32; 2] = [885, 894];
/// Labels of the alarms.
const LABELS: [u32; 2] = [110, 130];
const LABEL_SCATTER: u32 = 105;
/// Title of the program.
const TITLE: &str = "PROBE QUALIFICATION";

/// A qualification of the machine's probe.
#[derive(Clone, Debug)]
pub(crate) struct Qualification<'a> {
    settings: &'a NcSettings,
    piece: Workpiece,
    probe: NcProbe,
    reference: ProbeReference,
}

/// Where a qualification touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Qualified {
    /// Z of the touches, mm.
    pub z_mm: f64,
    /// Touches altogether.
    pub touches: u32,
}

impl<'a> Qualification<'a> {
    /// The qualification of the probe in `settings`.
    ///
    /// # Errors
    /// Without the data of a probe or of its reference, or where they are out of range.
    pub(crate) fn new(settings: &'a NcSettings) -> Result<Self, NcError> {
        settings.validate()?;
        let Some((probe, reference)) = settings.probe.and_then(|p| Some((p, p.reference?))) else {
            return Err(NcError::Plan(
                "a qualification needs the probe and its reference: nc.probe, nc.probe.reference (diameter_mm, length_mm)"
                    .into(),
            ));
        };
        let d = reference.diameter_mm;
        Ok(Self { settings, piece: Workpiece::new(reference.length_mm, d, d), probe, reference })
    }

    /// The program's text, replayed from every start position with a probe as stated, once with
    /// run-out of the reference, and with a touch missing or out of range, at which it must raise
    /// its alarm.
    ///
    /// # Errors
    /// Machine data that are missing, a place that cannot be touched, a block that collides.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<Qualified>, NcError> {
        let skeleton = self.skeleton(dialect)?;
        self.reaches()?;
        let text = self.text(&skeleton);
        let limit = self.settings.correction_limit_mm;
        replay::check(&text, &self.working_space_of(&skeleton, Surface::default()))?;
        let eccentric = Surface { run_out_mm: 0.5 * limit, ..Surface::default() };
        replay::check_once(&text, &self.working_space_of(&skeleton, eccentric))?;
        for off in [2.0 * limit, -(2.0 * self.probe.reach_mm + 1.0)] {
            let surface =
                Surface { before: vec![(0.0, self.reference.diameter_mm + off)], ..Surface::default() };
            replay::must_alarm(&text, &self.working_space_of(&skeleton, surface))?;
        }
        let z_mm = self.reference.z_mm();
        let touches = self.reference.touches * self.sides();
        let uncut =
            format!("qualifies the probe: {touches} touches of the reference at Z {z_mm} mm, nothing is cut");
        Ok(Written { text, cut: Qualified { z_mm, touches }, uncut })
    }

    /// The working space for a replay. `surface` is what the probe touches; an empty `before`
    /// stands for the reference.
    ///
    /// # Errors
    /// As [`Self::write`], but for the replay.
    #[cfg(test)]
    pub(crate) fn working_space(
        &self,
        dialect: Dialect,
        surface: Surface,
    ) -> Result<WorkingSpace<'_>, NcError> {
        let skeleton = self.skeleton(dialect)?;
        Ok(self.working_space_of(&skeleton, surface))
    }

    fn skeleton(&self, dialect: Dialect) -> Result<Skeleton<'_>, NcError> {
        let route = skeleton::check(self.settings, &self.piece, self.reference.diameter_mm, dialect)?;
        Ok(Skeleton {
            dialect,
            settings: self.settings,
            piece: &self.piece,
            route,
            // nothing is cut
            cutting: CuttingData { speed_m_per_min: 1.0, feed_mm_per_rev: 0.1 },
            pass: 0,
            wear_mm: 0.0,
            limits_mm: None,
            measures_first: true,
        })
    }

    fn sides(&self) -> u32 {
        if self.settings.spindle_orientation.is_some() { 2 } else { 1 }
    }

    /// Whether ball and body are clear of the ends of the reference, and of the space behind Z 0
    /// where the chuck is not stated.
    fn reaches(&self) -> Result<(), NcError> {
        let (z, ball) = (self.reference.z_mm(), 0.5 * self.probe.ball_mm);
        let body = if self.settings.chuck.is_none() { 0.5 * self.probe.body_mm } else { 0.0 };
        let (least, most) = (ball.max(body), self.reference.length_mm - ball);
        if (least..=most).contains(&z) {
            return Ok(());
        }
        Err(NcError::Plan(format!(
            "the probe cannot touch the reference at Z {z} mm (nc.probe.reference.z_mm): its ball and body are clear from Z {least} \
             mm (the room behind Z 0 where nc.chuck is not stated) to {most} mm"
        )))
    }

    fn working_space_of<'s>(&self, skeleton: &Skeleton<'s>, surface: Surface) -> WorkingSpace<'s> {
        let mut working_space = skeleton.working_space(vec![(0.0, self.reference.diameter_mm)]);
        // nothing is cut: any feed other than the probe's is a fault, and no length must be covered
        working_space.cut = CommandedCut::default();
        let before = match &surface.before[..] {
            [] => vec![(0.0, self.reference.diameter_mm)],
            given => given.to_vec(),
        };
        working_space.surface = Some(Surface { before, ..surface });
        working_space
    }

    fn text(&self, skeleton: &Skeleton<'_>) -> String {
        let (d, route) = (skeleton.dialect, &skeleton.route);
        let mut lines = self.head(skeleton);
        lines.push(format!("#{QUALIFIED}=0."));
        lines.extend(d.to_change(route.change));
        lines.push(d.spindle_off().to_owned());
        lines.extend(d.tool(self.probe.tool, self.probe.tool));
        lines.push(d.feed_per_minute().to_owned());
        for side in 0..self.sides() as usize {
            lines.extend(skeleton.hold_spindle(side == 1));
            if side == 0 {
                lines.extend(d.approach(route.change, self.reference.z_mm(), route.clear_mm));
            }
            lines.extend(self.touches(skeleton, side));
        }
        lines.extend(d.to_change(route.change));
        lines.extend(skeleton.release_spindle());
        lines.push(d.feed_per_revolution().to_owned());
        lines.extend(self.results(d));
        lines.extend(d.end());
        lines.join("\n") + "\n"
    }

    fn head(&self, skeleton: &Skeleton<'_>) -> Vec<String> {
        let reference = format!(
            "reference: diameter {} from Z 0 to {}, touched at Z {}",
            number(self.reference.diameter_mm, 4),
            number(self.reference.length_mm, 3),
            number(self.reference.z_mm(), 3)
        );
        let run_out = match self.sides() {
            2 => "from both sides: run-out of the reference cancels",
            _ => "from one side: the reference must run true, its run-out is in the correction",
        };
        let about = [
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), skeleton.dialect.as_str()),
            reference,
            format!("{} touches an angle, {run_out}", self.reference.touches),
            format!(
                "{CORRECTION} correction, {BALL} ball as it acts, {DEVIATION} deviation, {RUN_OUT} run-out"
            ),
            format!("{QUALIFIED} the tool of the probe once all is done"),
        ];
        skeleton.head_of_probe(TITLE, &about)
    }

    fn touches(&self, skeleton: &Skeleton<'_>, side: usize) -> Vec<String> {
        let (d, probe) = (skeleton.dialect, &self.probe);
        let target = number(self.reference.diameter_mm - 2.0 * probe.reach_mm, 3);
        let limit = number(self.settings.correction_limit_mm, 4);
        let expected = number(self.reference.diameter_mm + probe.correction_mm, 5);
        let mut lines = Vec::new();
        for (variable, label) in self.variables(side).zip(LABELS[side]..) {
            let variable = format!("#{variable}");
            lines.push(format!("{} X{target} F{}", d.probing_move(), number(probe.feed_mm_per_min, 1)));
            lines.push(format!("{variable}=[{}]", skeleton.read(probe)));
            lines.push(format!("G00 X{}", number(skeleton.route.clear_mm, 3)));
            let off = format!("ABS[{variable}-{expected}]");
            lines.extend(d.alarm_if(label, (&off, "GT", &limit), "PROBE RESULT OUT OF RANGE"));
        }
        lines
    }

    fn variables(&self, side: usize) -> std::ops::Range<u32> {
        TOUCHES[side]..TOUCHES[side] + self.reference.touches
    }

    /// Means, scatter and run-out from the touches.
    fn results(&self, d: Dialect) -> Vec<String> {
        let n = number(f64::from(self.reference.touches), 0);
        let diameter = number(self.reference.diameter_mm, 5);
        let mut lines = vec![d.comment("means of the sides less the reference"), "#903=0.".to_owned()];
        let mut means = Vec::new();
        for side in 0..self.sides() as usize {
            let mean = format!("#{}", 904 + side);
            lines.push(format!("{mean}=0."));
            lines.extend(self.variables(side).map(|v| format!("{mean}=[{mean}+#{v}-{diameter}]")));
            lines.push(format!("{mean}=[{mean}/{n}]"));
            let off = |v: u32| format!("[#{v}-{diameter}-{mean}]");
            lines.extend(self.variables(side).map(|v| format!("#903=[#903+{0}*{0}]", off(v))));
            means.push(mean);
        }
        let freedom = number(f64::from(self.sides() * (self.reference.touches - 1)), 0);
        lines.push(d.comment("standard deviation of a touch"));
        lines.push(format!("#{DEVIATION}=SQRT[#903/{freedom}]"));
        let limit = number(self.probe.expanded_u_mm, 5);
        let twice = format!("2.*#{DEVIATION}");
        lines.extend(d.alarm_if(LABEL_SCATTER, (&twice, "GT", &limit), "PROBE SCATTERS BEYOND U"));
        let (mean, run_out) = match &means[..] {
            [one, other] => (format!("[[{one}+{other}]/2.]"), format!("ABS[[{one}-{other}]/2.]")),
            _ => ("#904".to_owned(), "0.".to_owned()),
        };
        lines.push(d.comment("correction, ball as it acts, run-out, tool"));
        lines.push(format!("#{CORRECTION}={mean}"));
        lines.push(format!("#{BALL}=[#{CORRECTION}{}]", signed(self.probe.ball_mm)));
        lines.push(format!("#{RUN_OUT}={run_out}"));
        lines.push(format!("#{QUALIFIED}={}.", self.probe.tool));
        lines
    }
}
