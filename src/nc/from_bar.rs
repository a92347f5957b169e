//! A whole part from the bar: roughing and a finishing cut in one program, replayed on the bar
//! itself.
//!
//! Besides the replay among the solids the bar is cut move by move: no rapid may touch what stands
//! at that moment, no cut along Z may take more than the depth stated, and what is left at the end
//! is returned, to be compared with the part.

use glam::DVec2;

use super::contour_program::ContourProgram;
use super::dialect::Dialect;
use super::error::NcError;
use super::replay::{self, Convex, Deed, TurnedStock};
use super::roughing::{ALONG, Roughing};

/// A program from the bar that has passed its replay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FromBar {
    /// Its text.
    pub text: String,
    /// Its moves in order.
    pub moves: Vec<ToolMove>,
    /// What it leaves of the bar, of the region in which it was replayed.
    pub left: TurnedStock,
}

/// A move of the gauge point, (X radius, Z), mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolMove {
    /// Where it begins.
    pub from: DVec2,
    /// Where it ends.
    pub to: DVec2,
    /// Whether it is a rapid.
    pub rapid: bool,
    /// Whether it belongs to the roughing.
    pub roughing: bool,
}

/// Step of the bar's places along Z, mm: an error of the place of a wall that no picture shows.
const STEP_MM: f64 = 0.02;
/// Share of the depth stated by which a cut along Z may be deeper: rounding of its levels, and the
/// chord of the nose beside a level.
const DEEPER: f64 = 0.02;

impl ContourProgram<'_> {
    /// The program of the whole part in this bar, replayed from every start position and on the
    /// bar.
    ///
    /// # Errors
    /// As [`ContourProgram::write`]; a rapid that touches the bar as it stands, a cut that is too
    /// deep.
    pub(crate) fn write_from_bar(
        &self,
        dialect: Dialect,
        roughing: &Roughing<'_>,
    ) -> Result<FromBar, NcError> {
        let (text, skeleton) = self.text(dialect, Some(roughing))?;
        let space = self.working_space(&skeleton)?;
        replay::check(&text, &space)?;
        let start = replay::Point { x: skeleton.route.change.x_mm, z: skeleton.route.change.z_mm };
        let refused = |block: usize, what: String| NcError::Block {
            block,
            text: text.lines().nth(block.saturating_sub(1)).unwrap_or_default().trim().to_owned(),
            what,
        };
        let events =
            replay::run(&text, &space.control(start)).map_err(|(block, what)| refused(block, what))?;
        let along = dialect.comment(ALONG);
        let levels_end = text.lines().position(|line| line == along).unwrap_or(0);
        let rough_end = self.head(&skeleton, Some(roughing)).len() + self.roughing(&skeleton, roughing).len();
        let from = self.pieces.first().map_or(0.0, |p| p.from.y.min(p.to.y));
        let mut left =
            TurnedStock::bar((from.min(0.0), self.piece.length_mm), 0.5 * self.piece.before_mm, STEP_MM);
        let cutter = Convex::hull(roughing.edges.iter().map(|p| (p.y, p.x)).collect());
        let mut moves = Vec::new();
        let plane = |p: replay::Point| DVec2::new(0.5 * p.x, p.z);
        for event in &events {
            let Deed::Move { from, to, rapid } = event.deed else { continue };
            if rapid {
                if let Some((depth, z)) = left.touched(&cutter, from, to) {
                    let what =
                        format!("a rapid passes {depth:.3} mm inside of the bar as it stands, at Z {z:.2}");
                    return Err(refused(event.block, what));
                }
            } else {
                let deepest = left.cut(&cutter, from, to);
                let is_level = event.block <= levels_end && from.x == to.x;
                if let Some((depth, z)) =
                    deepest.filter(|(d, _)| is_level && *d > roughing.depth_mm * (1.0 + DEEPER))
                {
                    let what =
                        format!("a cut along Z is {depth:.3} mm deep at Z {z:.2}, not {}", roughing.depth_mm);
                    return Err(refused(event.block, what));
                }
            }
            let roughing = event.block <= rough_end;
            moves.push(ToolMove { from: plane(from), to: plane(to), rapid, roughing });
        }
        Ok(FromBar { text, moves, left })
    }
}
