//! The macro program of paper 000: the finishing pass cuts a cone that is the inverse of the fitted
//! error.
//!
//! ```text
//! #804 = #802/6 + #803    (9)      #810 = #800 − #804    (7)
//! #805 = #802   + #803   (10)      #811 = #801 − #805    (8)
//! ```
//!
//! #800, #801: diameters at the first (x = 1/6) and the last (x = 1) probed place, x from the free
//! end as a share of the length; #802 = b, #803 = a. The paper prints 7 and 8 before 9 and 10,
//! which they need, and writes the results back into #800 and #801, so that every run of the
//! program would compensate again: here the order is 9, 10, 7, 8, the results go into #810
//! and #811, and #820 with the part's and pass's number ensures that the correction is used only
//! once. Before the cut the corrections are checked against a limit; after it the part is measured
//! again.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::line::LineFit;
use super::machine::Direction;
use super::replay;
use super::route::{Workpiece, round3};
use super::settings::NcSettings;
use super::skeleton::{self, Skeleton};
use super::turning::Written;
use crate::plan::CuttingData;

/// First probed place as a share of the length: the paper's first point.
const X_START: f64 = 1.0 / 6.0;
/// Decimals of b and a in a program: six significant digits in the paper.
const COEFFICIENT_DECIMALS: usize = 6;

/// A finishing pass by macro variables.
#[derive(Clone, Debug)]
pub(crate) struct MacroProgram<'a> {
    /// #802 and #803, in `unit_mm`.
    pub line: LineFit,
    /// Unit of b and a, mm: .01 fits the paper's experiment.
    pub unit_mm: f64,
    /// #800 and #801: diameters to be cut at start and end, mm.
    pub diameter_mm: (f64, f64),
    /// The part before the pass; its free end lies at Z = length.
    pub piece: Workpiece,
    /// Number of the pass.
    pub pass: u32,
    /// Feed and speed.
    pub cutting: CuttingData,
    /// Lower and upper limit of the re-measurement, mm.
    pub limits_mm: Option<(f64, f64)>,
    /// Machine.
    pub settings: &'a NcSettings,
}

/// Values of the variables at the end of the program.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct MacroValues {
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
    pub(crate) fn values(&self) -> MacroValues {
        let v804 = self.line.b * X_START + self.line.a;
        let v805 = self.line.b + self.line.a;
        let (start, end) = self.diameter_mm;
        let v810 = start - v804 * self.unit_mm;
        let v811 = end - v805 * self.unit_mm;
        let v812 = v810 - (v811 - v810) * X_START / (1.0 - X_START);
        MacroValues { v804, v805, v810, v811, v812 }
    }

    /// Commanded diameter at `z`: the inverse of the error line, mm.
    pub(super) fn cone_mm(&self, z: f64) -> f64 {
        let x = (self.piece.length_mm - z) / self.piece.length_mm;
        let v = self.values();
        v.v812 + (v.v811 - v.v812) * x
    }

    /// The program's text, replayed from every start position.
    ///
    /// # Errors
    /// Settings out of range, a cone beyond the correction limit, machine data that are missing, a
    /// block that collides.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<MacroValues>, NcError> {
        let (s, v) = (self.settings, self.values());
        dialect.check_macros()?;
        s.validate()?;
        let nominal = self.diameter_mm.0.max(self.diameter_mm.1);
        let route = skeleton::check(s, &self.piece, nominal, dialect)?;
        let skeleton = Skeleton {
            dialect,
            settings: s,
            piece: &self.piece,
            route,
            cutting: self.cutting,
            pass: self.pass,
            wear_mm: 0.0,
            limits_mm: self.limits_mm,
            measures_first: false,
        };
        self.check(&skeleton)?;
        let mut lines = self.head(&skeleton);
        lines.extend(self.variables(dialect));
        lines.extend(self.guards(&skeleton));
        lines.extend(self.far_end(&skeleton));
        lines.extend(skeleton.approach());
        lines.extend(skeleton.cut(&self.points(&skeleton)));
        lines.extend(skeleton.after(nominal)?);
        let text = lines.join("\n") + "\n";
        let ends = [0.0, self.piece.length_mm].map(|z| (z, self.cone_mm(z)));
        let mut working_space = skeleton.working_space(ends.to_vec());
        working_space.surface = skeleton.surface(nominal);
        replay::check(&text, &working_space)?;
        Ok(Written { text, cut: v, uncut: skeleton.uncut() })
    }

    fn head(&self, skeleton: &Skeleton<'_>) -> Vec<String> {
        let (v, cutting) = (self.values(), self.cutting);
        let about = [
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), skeleton.dialect.as_str()),
            format!(
                "aim {} to {} mm from {} mm, v {} m/min, f {} mm/rev",
                number(self.diameter_mm.0, 4),
                number(self.diameter_mm.1, 4),
                number(self.piece.before_mm, 4),
                cutting.speed_m_per_min,
                cutting.feed_mm_per_rev
            ),
            "error line B X + A from the semi-finished part, in the path".to_owned(),
            format!("unit of B and A: {} mm", number(self.unit_mm, 6)),
        ];
        let title = format!("PART {} PASS {} LINE", self.settings.part_number, self.pass);
        skeleton.head(&title, &about, v.v811.min(v.v812))
    }

    pub(super) fn check(&self, skeleton: &Skeleton<'_>) -> Result<(), NcError> {
        if Self::z_at_chuck(skeleton) >= self.piece.length_mm * (1.0 - X_START) {
            return Err(NcError::Plan(format!(
                "the cut would end at Z {} mm, before the first point of the line: lower nc.least_z_mm",
                Self::z_at_chuck(skeleton)
            )));
        }
        let v = self.values();
        let numbers = [v.v810, v.v811, v.v812, self.piece.length_mm, self.piece.before_mm, self.unit_mm];
        if numbers.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            return Err(NcError::Plan("diameters, length and unit must be positive".into()));
        }
        let limit = self.settings.correction_limit_mm;
        let (start, end) = self.diameter_mm;
        let length = self.piece.length_mm;
        for (z_mm, x_mm, nominal) in
            [(length, v.v812, start), (length * (1.0 - X_START), v.v810, start), (0.0, v.v811, end)]
        {
            let (low_mm, high_mm) = (nominal - limit, nominal + limit);
            if !(low_mm..=high_mm).contains(&x_mm) {
                return Err(NcError::Range { x_mm, z_mm, low_mm, high_mm });
            }
        }
        Ok(())
    }

    fn variables(&self, dialect: Dialect) -> Vec<String> {
        let coefficient = |value| number(value, COEFFICIENT_DECIMALS);
        let mut lines = self.diameters();
        lines.push(format!("#802={}", coefficient(self.line.b)));
        lines.push(format!("#803={}", coefficient(self.line.a)));
        lines.extend(self.equations(dialect));
        lines
    }

    /// #800 and #801.
    pub(super) fn diameters(&self) -> Vec<String> {
        let (start, end) = self.diameter_mm;
        vec![format!("#800={}", number(start, 5)), format!("#801={}", number(end, 5))]
    }

    /// Equations 9, 10, 7, 8 of #802 and #803, and the cone's end.
    pub(super) fn equations(&self, dialect: Dialect) -> Vec<String> {
        let unit = number(self.unit_mm, 6);
        vec![
            "#804=[#802*1./6.+#803]".to_owned(),
            "#805=[#802+#803]".to_owned(),
            format!("#810=[#800-#804*{unit}]"),
            format!("#811=[#801-#805*{unit}]"),
            dialect.comment("the cone at the free end, x = 0"),
            "#812=[#810-[#811-#810]/5.]".to_owned(),
        ]
    }

    fn guards(&self, skeleton: &Skeleton<'_>) -> Vec<String> {
        let mut lines = skeleton.once("OFFSET WAS USED ALREADY");
        lines.extend(self.limits(skeleton.dialect));
        lines
    }

    /// Alarms where the cone departs too far from the target diameters.
    pub(super) fn limits(&self, dialect: Dialect) -> Vec<String> {
        let limit = number(self.settings.correction_limit_mm, 4);
        let mut lines = Vec::new();
        for (label, difference) in [(102, "ABS[#800-#810]"), (103, "ABS[#801-#811]"), (104, "ABS[#800-#812]")]
        {
            let condition = (difference, "GT", limit.as_str());
            lines.extend(dialect.alarm_if(label, condition, "CORRECTION OUT OF RANGE"));
        }
        lines
    }

    /// Z of the cut's end at the chuck.
    fn z_at_chuck(skeleton: &Skeleton<'_>) -> f64 {
        skeleton.route.z_first.min(skeleton.route.z_last)
    }

    /// The last point of the part lies at the chuck: the cut ends clear of it, on the line of the
    /// cone.
    pub(super) fn far_end(&self, skeleton: &Skeleton<'_>) -> Vec<String> {
        let length = self.piece.length_mm;
        let share = (length - Self::z_at_chuck(skeleton)) / length;
        let rest = number((share - X_START) / (1.0 - X_START), 9);
        vec![skeleton.dialect.comment("the cone at the chuck"), format!("#813=[#810+[#811-#810]*{rest}]")]
    }

    /// From the free end to the chuck, level in the air beyond the end face; or in the opposite
    /// direction.
    pub(super) fn points(&self, skeleton: &Skeleton<'_>) -> Vec<(String, f64)> {
        let (length, route) = (self.piece.length_mm, &skeleton.route);
        let sixth = round3(length * (1.0 - X_START));
        let beyond = route.z_first.max(route.z_last);
        let mut points = vec![
            ("#812".to_owned(), beyond),
            ("#812".to_owned(), round3(length)),
            ("#810".to_owned(), sixth),
            ("#813".to_owned(), Self::z_at_chuck(skeleton)),
        ];
        if self.piece.direction == Direction::TowardsTailstock {
            points.reverse();
        }
        points
    }
}
