//! The macro program of paper 000: the finishing pass cuts a cone that is the inverse of the fitted error.
//!
//! ```text
//! #804 = #802/6 + #803    (9)      #810 = #800 − #804    (7)
//! #805 = #802   + #803   (10)      #811 = #801 − #805    (8)
//! ```
//!
//! #800, #801: diameters at the start (x = 1/6) and the end (x = 1) of what was probed, x from the free end as a share
//! of the length; #802 = b, #803 = a. The paper prints 7 and 8 before 9 and 10, which they need, and writes the results
//! back into #800 and #801, so that every run of the program would compensate again: here the order is 9, 10, 7, 8, the
//! results go into #810 and #811, and #820 with the part's and pass's number lets the correction be used once. Before
//! the cut the corrections are checked against a limit; after it the part is measured again.

use super::dialect::{Dialect, number};
use super::{LineFit, NcError, NcSettings};
use crate::plan::CuttingData;

/// Start of what was probed, as a share of the length: the paper's first point.
const X_START: f64 = 1.0 / 6.0;
/// Decimals of b and a in a program: six significant digits in the paper.
const COEFFICIENT_DECIMALS: usize = 6;

/// A finishing pass by macro variables.
#[derive(Clone, Copy, Debug)]
pub struct MacroProgram<'a> {
    /// #802 and #803, in `unit_mm`.
    pub line: LineFit,
    /// Unit of b and a, mm: .01 fits the paper's experiment.
    pub unit_mm: f64,
    /// #800 and #801: diameters to be cut at start and end, mm.
    pub diameter_mm: (f64, f64),
    /// Length of the part, mm; its free end lies at Z = length.
    pub length_mm: f64,
    /// Diameter before the pass, mm.
    pub before_mm: f64,
    /// Number of the pass.
    pub pass: u32,
    /// Feed and speed.
    pub cutting: CuttingData,
    /// Lower and upper limit of the re-measurement, mm.
    pub limits_mm: Option<(f64, f64)>,
    /// Machine.
    pub settings: &'a NcSettings,
}

/// What the variables hold when the program has run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MacroValues {
    /// #804, in the unit of the fit.
    pub v804: f64,
    /// #805, in the unit of the fit.
    pub v805: f64,
    /// #810: diameter at the start, mm.
    pub v810: f64,
    /// #811: diameter at the end, mm.
    pub v811: f64,
    /// #812: diameter of the cone at the free end, mm.
    pub v812: f64,
}

impl MacroProgram<'_> {
    /// Equations 9, 10, 7, 8, in this order.
    pub fn values(&self) -> MacroValues {
        let v804 = self.line.b * X_START + self.line.a;
        let v805 = self.line.b + self.line.a;
        let (start, end) = self.diameter_mm;
        let v810 = start - v804 * self.unit_mm;
        let v811 = end - v805 * self.unit_mm;
        let v812 = v810 - (v811 - v810) * X_START / (1.0 - X_START);
        MacroValues { v804, v805, v810, v811, v812 }
    }

    /// The program's text.
    ///
    /// # Errors
    /// Settings out of range, or a cone beyond the correction limit.
    pub fn write(&self, dialect: Dialect) -> Result<String, NcError> {
        self.settings.validate()?;
        self.check()?;
        let s = self.settings;
        let mut lines = dialect.start(s.program, &format!("PART {} PASS {} LINE", s.part_number, self.pass));
        lines.push(dialect.comment("error line B X + A from the semi-finished part, unit of B and A:"));
        lines.push(dialect.comment(&format!("{} mm", number(self.unit_mm, 6))));
        lines.extend(self.variables(dialect));
        lines.extend(self.guards(dialect));
        lines.extend(self.cut(dialect));
        if let (Some(measure), Some((low, high))) = (s.remeasure, self.limits_mm) {
            lines.push(format!("M{:02}", measure.m_code));
            let smallest = format!("#{}", measure.smallest_variable);
            let largest = format!("#{}", measure.largest_variable);
            lines.extend(dialect.alarm_if(106, (&smallest, "LT", &number(low, 4)), "PART UNDERSIZE"));
            lines.extend(dialect.alarm_if(107, (&largest, "GT", &number(high, 4)), "PART OVERSIZE"));
        }
        lines.extend(dialect.end());
        Ok(lines.join("\n") + "\n")
    }

    fn check(&self) -> Result<(), NcError> {
        let v = self.values();
        let numbers = [v.v810, v.v811, v.v812, self.length_mm, self.before_mm, self.unit_mm];
        if numbers.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            return Err(NcError::Plan("diameters, length and unit must be positive".into()));
        }
        let limit = self.settings.correction_limit_mm;
        let (start, end) = self.diameter_mm;
        for (z_mm, x_mm, nominal) in [
            (self.length_mm, v.v812, start),
            (self.length_mm * (1.0 - X_START), v.v810, start),
            (0.0, v.v811, end),
        ] {
            let (low_mm, high_mm) = (nominal - limit, nominal + limit);
            if !(low_mm..=high_mm).contains(&x_mm) {
                return Err(NcError::Range { x_mm, z_mm, low_mm, high_mm });
            }
        }
        Ok(())
    }

    fn variables(&self, dialect: Dialect) -> Vec<String> {
        let coefficient = |value| number(value, COEFFICIENT_DECIMALS);
        let (start, end) = self.diameter_mm;
        let unit = number(self.unit_mm, 6);
        let mut lines = vec![
            format!("#800={}", number(start, 5)),
            format!("#801={}", number(end, 5)),
            format!("#802={}", coefficient(self.line.b)),
            format!("#803={}", coefficient(self.line.a)),
            "#804=[#802*1./6.+#803]".to_owned(),
            "#805=[#802+#803]".to_owned(),
        ];
        lines.push(format!("#810=[#800-#804*{unit}]"));
        lines.push(format!("#811=[#801-#805*{unit}]"));
        lines.push(dialect.comment("the cone at the free end, x = 0"));
        lines.push("#812=[#810-[#811-#810]/5.]".to_owned());
        lines
    }

    fn identity(&self) -> String {
        number(f64::from(self.settings.part_number) * 100.0 + f64::from(self.pass % 100), 0)
    }

    fn guards(&self, dialect: Dialect) -> Vec<String> {
        let limit = number(self.settings.correction_limit_mm, 4);
        let mut lines = dialect.alarm_if(101, ("#820", "EQ", &self.identity()), "OFFSET WAS USED ALREADY");
        for (label, difference) in [(102, "ABS[#800-#810]"), (103, "ABS[#801-#811]"), (104, "ABS[#800-#812]")]
        {
            lines.extend(dialect.alarm_if(label, (difference, "GT", &limit), "CORRECTION OUT OF RANGE"));
        }
        lines
    }

    fn cut(&self, dialect: Dialect) -> Vec<String> {
        let s = self.settings;
        let clear = number(self.before_mm + s.clearance_mm, 3);
        let mut lines = dialect.tool(s.tool, s.tool);
        lines.extend(dialect.spindle(self.cutting.speed_m_per_min, s.speed_limit_per_min));
        lines.push(format!("G00 X{clear}"));
        lines.push(format!("Z{}", number(self.length_mm + s.lead_in_mm, 3)));
        lines.push("X#812".to_owned());
        lines.push(format!(
            "G01 Z{} F{}",
            number(self.length_mm, 3),
            number(self.cutting.feed_mm_per_rev, 4)
        ));
        lines.push(format!("X#810 Z{}", number(self.length_mm * (1.0 - X_START), 4)));
        // the last point of the part lies at the chuck: the cone ends clear of it, on the same line
        let share = (self.length_mm - s.least_z_mm) / self.length_mm;
        let rest = number((share - X_START) / (1.0 - X_START), 9);
        lines.push(format!("#813=[#810+[#811-#810]*{rest}]"));
        lines.push(format!("X#813 Z{}", number(s.least_z_mm, 3)));
        lines.push(format!("G00 X{clear}"));
        lines.push(format!("Z{}", number(self.length_mm + s.lead_in_mm, 3)));
        lines.push(format!("#820={}", self.identity()));
        lines
    }
}
