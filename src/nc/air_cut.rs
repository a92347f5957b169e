//! The first run of a program on a machine: the same moves, raised above the stock.
//!
//! In: the pass that will be cut. Out: a program that makes its moves, tool call, spindle and
//! feeds, with every diameter raised so far that the tool stays half the clearance above the stock.
//! It shows whether zero point, tool offset, directions and feeds are what the program takes them
//! for, before any of it meets material. In its replay the stock is a solid like the chuck: a feed
//! that touches it is refused as a rapid is.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::path::Path;
use super::replay;
use super::turning::{TurningProgram, Written, points};
use crate::plan::PassPlan;

/// Number of an air cut in the variable with the pass that ran last: no pass has it, so that the
/// pass itself is not refused as cut already.
const PASS_OF_AIR: u32 = 0;

/// An air cut of a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AirCut<'a> {
    /// The pass that is cut afterwards.
    pub of: TurningProgram<'a>,
}

impl AirCut<'_> {
    /// The program's text and its raised path, replayed from every start position.
    ///
    /// # Errors
    /// As [`TurningProgram::write`].
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<Path>, NcError> {
        let program = &self.of;
        let (piece, settings) = (program.piece, program.settings);
        let least_mm = program.plan.commanded_mm().fold(f64::INFINITY, f64::min);
        let lowest_mm = piece.largest_mm() + 0.5 * settings.clearance_mm;
        let raised_by_mm = lowest_mm - least_mm;
        let plan = PassPlan {
            pass: PASS_OF_AIR,
            nominal_mm: program.plan.nominal_mm + raised_by_mm,
            ..program.plan.clone()
        };
        let raised = TurningProgram { plan: &plan, limits_mm: None, ..*program };
        let (path, skeleton) = raised.prepare(dialect, program.plan.nominal_mm)?;
        let mut lines = skeleton.head_of_air(
            &format!("PART {} AIR CUT OF PASS {}", settings.part_number, program.plan.pass),
            &[
                format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), dialect.as_str()),
                format!("cuts nothing: every diameter is raised by {} mm", number(raised_by_mm, 3)),
                format!("the tool stays {} mm above the stock", number(0.25 * settings.clearance_mm, 3)),
                "watch: zero point, tool offset, directions, feeds, clearances".to_owned(),
                format!("reason: {}", program.reason),
            ],
            lowest_mm,
        );
        lines.extend(skeleton.approach());
        lines.extend(skeleton.cut(&points(&skeleton, &path)));
        lines.extend(skeleton.after(plan.nominal_mm)?);
        let text = lines.join("\n") + "\n";
        let mut space = raised.working_space_of(&skeleton);
        space.solids.extend(space.stock.iter().cloned());
        replay::check(&text, &space)?;
        let uncut = format!(
            "air cut: nothing is cut, the tool stays {} mm clear of the stock",
            0.25 * settings.clearance_mm
        );
        Ok(Written { text, cut: path, uncut })
    }
}
