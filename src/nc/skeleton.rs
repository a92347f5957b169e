//! The parts common to all programs, around the cut: head, guard, change position, tool, spindle,
//! approach, retract, end.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::machine::{Spindle, WearX};
use super::route::{Route, Workpiece};
use super::settings::NcSettings;
use super::sinumerik::RAN_LAST;
use crate::plan::CuttingData;

/// A program without its cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skeleton<'a> {
    pub(super) dialect: Dialect,
    pub(super) settings: &'a NcSettings,
    pub(super) piece: &'a Workpiece,
    pub(super) route: Route,
    pub(super) cutting: CuttingData,
    pub(super) pass: u32,
    /// Value of the wear register while the tool cuts, mm of diameter; 0 without a register.
    pub(super) wear_mm: f64,
    pub(super) limits_mm: Option<(f64, f64)>,
    /// Whether the program begins by probing the part.
    pub(super) measures_first: bool,
}

impl Skeleton<'_> {
    /// Part and pass as one number.
    pub(super) fn identity(&self) -> String {
        number(f64::from(self.settings.part_number) * 100.0 + f64::from(self.pass % 100), 0)
    }

    /// Guards at the start: a program cuts a part's pass only once, and only with a qualified probe
    /// where it takes the probe's correction from the qualification.
    pub(super) fn once(&self, text: &str) -> Vec<String> {
        let mut lines = self.dialect.alarm_if(101, (&format!("#{RAN_LAST}"), "EQ", &self.identity()), text);
        lines.extend(self.qualified());
        lines
    }

    fn register(&self) -> Option<WearX> {
        let taken = self.settings.wear_x.unwrap_or(WearX::Diameter);
        self.settings.uses_wear_register(self.dialect).then_some(taken)
    }

    /// Number of the offset that the T word calls.
    fn offset(&self) -> u32 {
        if self.register().is_some() { self.settings.wear_offset } else { self.settings.tool }
    }

    /// To the change position, tool, spindle, and down to the clear diameter above the first point
    /// of the cut.
    pub(super) fn approach(&self) -> Vec<String> {
        let (d, s, route) = (self.dialect, self.settings, &self.route);
        let mut lines = d.to_change(route.change);
        if let Some(taken) = self.register() {
            let value = number(self.wear_mm / taken.diameter_per_unit(), d.x_decimals());
            lines.push(d.comment("mean correction, absolute: a second run does not add to it"));
            lines.push(format!("G10 P{} X{value}", s.wear_offset));
        }
        lines.extend(d.tool(s.tool, self.offset()));
        let sense = s.spindle.unwrap_or(Spindle::M03);
        lines.extend(d.spindle(self.cutting.speed_m_per_min, s.speed_limit_per_min, sense));
        lines.extend(d.approach(route.change, route.z_first, route.clear_mm));
        lines
    }

    /// Blocks of a cut through `points` (X as it stands in the program, Z), entered and left
    /// radially in feed.
    pub(super) fn cut(&self, points: &[(String, f64)]) -> Vec<String> {
        let (d, feed) = (self.dialect, number(self.cutting.feed_mm_per_rev, 4));
        let mut lines = Vec::with_capacity(points.len() + 1);
        for (i, (x, z)) in points.iter().enumerate() {
            lines.push(match i {
                0 => format!("G01 {} F{feed}", d.axis('X', x)),
                _ => format!("{} {}", d.axis('X', x), d.axis('Z', &number(*z, 4))),
            });
        }
        lines.push(d.axis('X', &number(self.route.clear_mm, 3)));
        lines
    }

    /// The blocks after the cut: measuring, where requested, and the end.
    ///
    /// # Errors
    /// Places that the probe cannot touch, a tolerance that U takes up.
    pub(super) fn after(&self, nominal_mm: f64) -> Result<Vec<String>, NcError> {
        let mut lines = self.after_cut();
        if let Some((probe, limits)) = self.probes_after() {
            lines.extend(self.probe_again(&probe, nominal_mm, Some(limits))?);
        }
        lines.extend(self.dialect.end());
        Ok(lines)
    }

    /// Back to the change position; there the offset is cancelled and, on request, the part
    /// measured.
    pub(super) fn after_cut(&self) -> Vec<String> {
        let (d, s) = (self.dialect, self.settings);
        let mut lines = d.to_change(self.route.change);
        lines.extend(d.assign(RAN_LAST, &self.identity()));
        if self.register().is_some() {
            lines.push(format!("T{:02}00", s.tool));
            lines.push(format!("G10 P{} X0.", s.wear_offset));
        }
        if let (Some(measure), Some((low, high))) = (s.remeasure, self.limits_mm) {
            lines.push(format!("M{:02}", measure.m_code));
            let smallest = format!("#{}", measure.smallest_variable);
            let largest = format!("#{}", measure.largest_variable);
            lines.extend(d.alarm_if(106, (&smallest, "LT", &number(low, 4)), "PART UNDERSIZE"));
            lines.extend(d.alarm_if(107, (&largest, "GT", &number(high, 4)), "PART OVERSIZE"));
        }
        lines
    }
}

/// Checks that are common to all programs, before a line is written.
pub(super) fn check(
    settings: &NcSettings,
    piece: &Workpiece,
    nominal_mm: f64,
    dialect: Dialect,
) -> Result<Route, NcError> {
    check_settings(settings, dialect)?;
    piece.check(nominal_mm)?;
    Route::new(piece, settings)
}

/// Checks of the machine's data alone.
pub(super) fn check_settings(settings: &NcSettings, dialect: Dialect) -> Result<(), NcError> {
    settings.validate()?;
    settings.check_stated(dialect)?;
    if settings.probe.is_some() {
        dialect.check_macros()?;
    }
    Ok(())
}
