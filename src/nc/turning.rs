//! A turning pass with its correction as a program.

use super::dialect::{Dialect, number};
use super::{NcError, NcSettings, Path};
use crate::plan::PassPlan;

/// Variable that remembers part and pass of the program that ran last: common, kept at power-off on a Fanuc.
const RAN_LAST: u32 = 820;

/// A pass to be written.
#[derive(Clone, Copy, Debug)]
pub struct TurningProgram<'a> {
    /// The pass with the offsets asked for.
    pub plan: &'a PassPlan,
    /// Machine and path.
    pub settings: &'a NcSettings,
    /// Diameter before the pass, mm: what the approach must clear.
    pub before_mm: f64,
    /// Lower and upper limit for the re-measurement, mm, where the part is finished by this pass.
    pub limits_mm: Option<(f64, f64)>,
    /// Why these offsets: written into the header.
    pub reason: &'a str,
}

impl TurningProgram<'_> {
    /// The program's text and the path it cuts.
    ///
    /// # Errors
    /// As [`Path::new`], and a stock or limits that are no numbers.
    pub fn write(&self, dialect: Dialect) -> Result<(String, Path), NcError> {
        let path = Path::new(self.plan, self.settings, dialect)?;
        if !(self.before_mm >= self.plan.nominal_mm && self.before_mm.is_finite()) {
            return Err(NcError::Plan(format!(
                "the diameter before the pass, {} mm, must not be below the nominal {} mm",
                self.before_mm, self.plan.nominal_mm
            )));
        }
        let mut lines = self.header(dialect, &path);
        lines.extend(self.once(dialect));
        lines.extend(self.approach(dialect, &path));
        lines.extend(self.cut(dialect, &path));
        lines.extend(self.after(dialect));
        lines.extend(dialect.end());
        Ok((lines.join("\n") + "\n", path))
    }

    fn header(&self, dialect: Dialect, path: &Path) -> Vec<String> {
        let (plan, s) = (self.plan, self.settings);
        let mut lines = dialect.start(s.program, &format!("PART {} PASS {}", s.part_number, plan.pass));
        let where_mean = if dialect.has_wear_register() { "in the wear register" } else { "in the path" };
        for text in [
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), dialect.as_str()),
            format!("aim {} mm, v {} m/min", number(plan.nominal_mm, 4), plan.cutting.speed_m_per_min),
            format!("{} knots, mean correction {where_mean}", path.knots.len()),
            format!("reason: {}", self.reason),
        ] {
            lines.push(dialect.comment(&text));
        }
        if dialect == Dialect::Gsk {
            lines.push(dialect.comment("not verified on a control: run dry first"));
        }
        lines
    }

    fn identity(&self) -> String {
        let key = f64::from(self.settings.part_number) * 100.0 + f64::from(self.plan.pass % 100);
        number(key, 0)
    }

    /// A program cuts a part's pass once.
    fn once(&self, dialect: Dialect) -> Vec<String> {
        let ran = format!("#{RAN_LAST}");
        dialect.alarm_if(101, (&ran, "EQ", &self.identity()), "PASS WAS CUT ALREADY")
    }

    fn approach(&self, dialect: Dialect, path: &Path) -> Vec<String> {
        let s = self.settings;
        let decimals = dialect.x_decimals();
        let mut lines = Vec::new();
        if dialect.has_wear_register() {
            lines.push(dialect.comment("mean correction, absolute: a second run does not add to it"));
            lines.push(format!("G10 P{} X{}", s.wear_offset, number(path.wear_mm, decimals)));
        }
        lines.extend(dialect.tool(s.tool, s.wear_offset));
        lines.extend(dialect.spindle(self.plan.cutting.speed_m_per_min, s.speed_limit_per_min));
        let (z, x) = path.knots[0];
        lines.push(format!("G00 X{}", number(self.clear_mm(), 3)));
        lines.push(format!("Z{}", number(z, 3)));
        lines.push(format!("X{}", number(x, decimals)));
        lines
    }

    fn clear_mm(&self) -> f64 {
        self.before_mm + self.settings.clearance_mm
    }

    fn cut(&self, dialect: Dialect, path: &Path) -> Vec<String> {
        let decimals = dialect.x_decimals();
        let feed = number(self.plan.cutting.feed_mm_per_rev, 4);
        let block = |(i, &(z, x)): (usize, &(f64, f64))| {
            let (code, feed) = if i == 0 { ("G01 ", format!(" F{feed}")) } else { ("", String::new()) };
            format!("{code}X{} Z{}{feed}", number(x, decimals), number(z, 3))
        };
        let mut lines: Vec<String> = path.knots.iter().skip(1).enumerate().map(block).collect();
        lines.push(format!("G00 X{}", number(self.clear_mm(), 3)));
        lines.push(format!("Z{}", number(path.knots[0].0, 3)));
        lines.push(format!("#{RAN_LAST}={}", self.identity()));
        lines
    }

    fn after(&self, dialect: Dialect) -> Vec<String> {
        let s = self.settings;
        let mut lines = Vec::new();
        if dialect.has_wear_register() {
            lines.push(format!("T{:02}00", s.tool));
            lines.push(format!("G10 P{} X0.", s.wear_offset));
        }
        let (Some(measure), Some((low, high))) = (s.remeasure, self.limits_mm) else {
            return lines;
        };
        lines.push(format!("M{:02}", measure.m_code));
        let smallest = format!("#{}", measure.smallest_variable);
        let largest = format!("#{}", measure.largest_variable);
        lines.extend(dialect.alarm_if(102, (&smallest, "LT", &number(low, 4)), "PART UNDERSIZE"));
        lines.extend(dialect.alarm_if(103, (&largest, "GT", &number(high, 4)), "PART OVERSIZE"));
        lines
    }
}
