//! A finishing cut along lines and arcs: a contour for the control's nose compensation, or the path
//! of the gauge point itself.
//!
//! The part stands roughed inside the bar, or is the bar: the tool comes down beyond the end face,
//! in feed, enters along the first piece or along its normal by more than R, follows the pieces,
//! and leaves radially. In a bore it goes in along the axis instead, inside the drilled hole, and
//! leaves it along Z (`bore`). `nose_words` has what each control is given of the nose,
//! `contour_entry` how a contour is entered and left.

use glam::DVec2;

use super::bore::Bore;
use super::contour_entry::{entry, exit};
use super::dialect::{Dialect, number};
use super::error::NcError;
use super::machine::{Direction, Spindle};
use super::nose_words::{self, NoseRegister};
use super::replay::{self, Convex, Deed, WorkingSpace};
use super::roughing::Roughing;
use super::route::{Route, Workpiece, round3};
use super::settings::NcSettings;
use super::skeleton::{self, Skeleton};
use crate::outline::Piece;
use crate::plan::CuttingData;

/// A finishing cut to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContourProgram<'a> {
    /// The contour, or with no register the path of the gauge point, in the direction of the
    /// outline: a shaft's from chuck to tailstock, a bore's to the chuck; X as a radius.
    pub pieces: &'a [Piece],
    /// The register for G41 or G42; with none the program runs with G40.
    pub register: Option<NoseRegister>,
    /// The nose's outline (X, Z) about the gauge point, mm.
    pub nose: &'a [DVec2],
    /// The bar.
    pub piece: &'a Workpiece,
    /// The bore that is cut in it; none of a shaft.
    pub bore: Option<Bore<'a>>,
    /// The machine.
    pub settings: &'a NcSettings,
    /// Cutting data.
    pub cutting: CuttingData,
    /// What the program does about the nose, for its header.
    pub about: &'a str,
}

/// A program that has passed its replay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WrittenContour {
    /// Its text.
    pub text: String,
    /// Moves of the gauge point in feed, (X radius, Z) from and to, as the text commands them.
    pub moves: Vec<(DVec2, DVec2)>,
}

/// Length of entry and exit, in units of R: controls need more than one.
const ENTRY_RADII: f64 = 2.0;
/// Length by which a piece is begun earlier, in units of R: more than the fillet of R.
const BEFORE_RADII: f64 = 1.5;
/// Height of the tool above its nose in the replay, mm: beyond all dimensions of a lathe.
const FAR_MM: f64 = 1e4;

impl ContourProgram<'_> {
    /// The program's text and its moves, replayed from every start position.
    ///
    /// # Errors
    /// Machine data that are missing, a register that the control cannot be given, a block that
    /// collides or that the control would stop at.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<WrittenContour, NcError> {
        let (text, skeleton) = self.text(dialect, None)?;
        self.replayed(text, &skeleton)
    }

    /// The text alone, and what it moves among; with a roughing it begins at the bar.
    pub(super) fn text(
        &self,
        dialect: Dialect,
        roughing: Option<&Roughing<'_>>,
    ) -> Result<(String, Skeleton<'_>), NcError> {
        let cut = self.in_order();
        let (Some(first), Some(last)) = (cut.first(), cut.last()) else {
            return Err(NcError::Plan("a path without a piece".into()));
        };
        let skeleton = self.skeleton(dialect, entry(first, self.lead_mm(), self.before_mm()).from)?;
        let mut lines = self.head(&skeleton, roughing);
        lines.extend(roughing.iter().flat_map(|r| self.roughing(&skeleton, r)));
        lines.extend(self.approach(&skeleton, roughing.is_some()));
        lines.extend(self.blocks(&skeleton, &cut));
        lines.extend(self.leave(last, &skeleton));
        lines.extend(self.retracted(&skeleton));
        lines.extend(dialect.end());
        Ok((lines.join("\n") + "\n", skeleton))
    }

    /// The pieces in the order of cutting.
    fn in_order(&self) -> Vec<Piece> {
        let reversed =
            |p: &Piece| Piece { from: p.to, to: p.from, from_rad: p.to_rad, to_rad: p.from_rad, ..*p };
        // an outline runs to the tailstock along a shaft and to the chuck in a bore
        if (self.piece.direction == Direction::TowardsChuck) == self.bore.is_some() {
            self.pieces.to_vec()
        } else {
            self.pieces.iter().rev().map(reversed).collect()
        }
    }

    /// Whether the tool runs on the right of the contour.
    fn is_on_the_right(&self) -> bool {
        (self.piece.direction == Direction::TowardsChuck) != self.bore.is_some()
    }

    fn radius_mm(&self) -> f64 {
        self.register.map_or(0.0, |r| r.radius_mm)
    }

    fn lead_mm(&self) -> f64 {
        self.settings.lead_in_mm.max(ENTRY_RADII * self.radius_mm())
    }

    /// Length by which a piece that is entered along its normal is begun before its first point: a
    /// control may leave the fillet of R between the entry and the first piece.
    fn before_mm(&self) -> f64 {
        BEFORE_RADII * self.radius_mm()
    }

    fn skeleton(&self, dialect: Dialect, entry: DVec2) -> Result<Skeleton<'_>, NcError> {
        let route = match &self.bore {
            Some(bore) => {
                skeleton::check_settings(self.settings, dialect)?;
                bore.route(self.settings, (self.nose, self.radius_mm()), entry)?
            }
            None => {
                let largest = self.pieces.iter().map(|p| 2.0 * p.from.x.max(p.to.x)).fold(0.0, f64::max);
                let nominal = largest.min(self.piece.before_mm);
                let route = skeleton::check(self.settings, self.piece, nominal, dialect)?;
                Route { z_first: round3(entry.y), ..route }
            }
        };
        Ok(Skeleton {
            dialect,
            settings: self.settings,
            piece: self.piece,
            route,
            cutting: self.cutting,
            pass: 1,
            wear_mm: 0.0,
            limits_mm: None,
            measures_first: false,
        })
    }

    pub(super) fn head(&self, skeleton: &Skeleton<'_>, roughing: Option<&Roughing<'_>>) -> Vec<String> {
        let s = self.settings;
        let program = format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), skeleton.dialect.as_str());
        let mut texts = vec![program, self.about.to_owned()];
        match &self.bore {
            Some(bore) => texts.extend(bore.words(s)),
            None => texts.push(match roughing {
                None => {
                    format!(
                        "finishing cut in a bar of {} mm, roughed to the contour",
                        number(self.piece.before_mm, 3)
                    )
                }
                Some(roughing) => roughing.about(self.piece),
            }),
        }
        texts.extend([
            "X is a diameter, Z 0 the face that clamps the part".to_owned(),
            format!("tool {}, set in X and Z at its tip direction", s.tool),
        ]);
        let on_page = nose_words::on_tool_page(skeleton.dialect, self.register);
        let words = |r| nose_words::tool_page_words(skeleton.dialect, s.tool, r);
        texts.extend(on_page.into_iter().flat_map(words));
        texts.extend(skeleton.change_position(self.bore.is_some()));
        let smallest = self.end_diameter_mm();
        texts.extend(skeleton.assumed(smallest, true));
        skeleton.framed(&format!("CONTOUR OF PART {}", s.part_number), texts)
    }

    /// Diameter at the end face, mm.
    fn end_diameter_mm(&self) -> f64 {
        let end = self.pieces.last().map_or(0.0, |p| p.from.x.max(p.to.x));
        2.0 * end
    }

    /// Tool and spindle at the change position.
    fn started(&self, d: Dialect) -> Vec<String> {
        let s = self.settings;
        let mut lines = d.tool(s.tool, s.tool);
        let sense = s.spindle.unwrap_or(Spindle::M03);
        lines.extend(d.spindle(self.cutting.speed_m_per_min, s.speed_limit_per_min, sense));
        lines
    }

    /// Facing and roughing with the same tool, without compensation. The register is written before
    /// the first call of the tool, with which a control takes it in.
    pub(super) fn roughing(&self, skeleton: &Skeleton<'_>, roughing: &Roughing<'_>) -> Vec<String> {
        let (d, route) = (skeleton.dialect, &skeleton.route);
        let first_mm = round3(self.piece.length_mm + self.lead_mm());
        let mut lines = self.retracted(skeleton);
        lines.extend(self.register_words(d));
        lines.extend(self.started(d));
        lines.extend(d.approach(route.change, first_mm, route.clear_mm));
        lines.extend(roughing.blocks(d, route.clear_mm, first_mm));
        lines.push(d.comment("finishing"));
        lines
    }

    /// Blocks that write the nose's register.
    fn register_words(&self, d: Dialect) -> Vec<String> {
        self.register.iter().flat_map(|r| nose_words::writing(d, self.settings.tool, *r)).collect()
    }

    fn approach(&self, skeleton: &Skeleton<'_>, is_roughed: bool) -> Vec<String> {
        let (d, route) = (skeleton.dialect, &skeleton.route);
        let mut lines = self.retracted(skeleton);
        if !is_roughed {
            lines.extend(self.register_words(d));
        }
        lines.extend(self.started(d));
        lines.extend(match self.bore {
            Some(_) => d.approach_into_bore(route.change, route.z_first, route.clear_mm),
            None => d.approach(route.change, route.z_first, route.clear_mm),
        });
        lines
    }

    fn retracted(&self, skeleton: &Skeleton<'_>) -> Vec<String> {
        let (d, change) = (skeleton.dialect, skeleton.route.change);
        if self.bore.is_some() { d.to_change_out_of_bore(change) } else { d.to_change(change) }
    }

    /// The entry and the pieces, as far as increments resolve them.
    fn blocks(&self, skeleton: &Skeleton<'_>, cut: &[Piece]) -> Vec<String> {
        let d = skeleton.dialect;
        let feed = number(self.cutting.feed_mm_per_rev, 4);
        let at = entry(&cut[0], self.lead_mm(), self.before_mm());
        let x = d.axis('X', &number(2.0 * at.from.x, d.x_decimals()));
        let mut lines = vec![format!("G01 {x} F{feed}")];
        lines.push(self.position(&self.compensation(d), at.to, skeleton));
        let (mut code, mut stands) = ("", self.position("", at.to, skeleton));
        let to = self.position("", cut[0].from, skeleton);
        if to != stands {
            lines.push(to.clone());
            (code, stands) = ("G01", to);
        }
        for piece in cut {
            let to = self.position("", piece.to, skeleton);
            if to == stands {
                continue;
            }
            let (this, radius) = self.code(piece, d);
            let word = if this == code { String::new() } else { format!("{this} ") };
            lines.push(word + &to + &radius);
            (code, stands) = (this, to);
        }
        lines
    }

    /// Away from the last piece, where the compensation ends, and out to the clear diameter.
    fn leave(&self, last: &Piece, skeleton: &Skeleton<'_>) -> Vec<String> {
        let clear = skeleton.dialect.axis('X', &number(skeleton.route.clear_mm, 3));
        let along_z = exit(last, self.lead_mm()).map(|at| self.position("", at, skeleton));
        let mut lines: Vec<String> = along_z.into_iter().chain([clear]).collect();
        lines[0] = format!("{}G01 {}", if self.register.is_some() { "G40 " } else { "" }, lines[0]);
        lines
    }

    /// Code and R of a piece: a line where the sagitta is below half an increment.
    fn code(&self, piece: &Piece, d: Dialect) -> (&'static str, String) {
        let Some(arc) = piece.arc else { return ("G01", String::new()) };
        let (half, radius) = (0.5 * piece.from.distance(piece.to), arc.radius_mm.abs());
        let sagitta = radius - (radius * radius - half * half).max(0.0).sqrt();
        if sagitta < 0.5 * 10f64.powi(-(d.x_decimals() as i32)) {
            return ("G01", String::new());
        }
        // seen with Z to the right and X up, a falling angle of the normal is anticlockwise
        let code = if piece.to_rad < piece.from_rad { "G03" } else { "G02" };
        (code, nose_words::arc_radius(d, radius))
    }

    fn position(&self, before: &str, at: DVec2, skeleton: &Skeleton<'_>) -> String {
        let d = skeleton.dialect;
        let word = |letter: char, value: f64| d.axis(letter, &number(value, d.x_decimals()));
        format!("{before}{} {}", word('X', 2.0 * at.x), word('Z', at.y))
    }

    /// Words that start the compensation with the entry.
    fn compensation(&self, d: Dialect) -> String {
        self.register.map_or_else(String::new, |r| nose_words::start(d, self.is_on_the_right(), r))
    }

    fn replayed(&self, text: String, skeleton: &Skeleton<'_>) -> Result<WrittenContour, NcError> {
        let space = self.working_space(skeleton)?;
        replay::check(&text, &space)?;
        let start = replay::Point { x: skeleton.route.change.x_mm, z: skeleton.route.change.z_mm };
        let events = replay::run(&text, &space.control(start)).map_err(|(block, what)| NcError::Block {
            block,
            text: String::new(),
            what,
        })?;
        let at = |p: replay::Point| DVec2::new(0.5 * p.x, p.z);
        let feed = |deed: &Deed| match deed {
            Deed::Move { from, to, rapid: false } => Some((at(*from), at(*to))),
            _ => None,
        };
        let moves = events.iter().filter_map(|event| feed(&event.deed)).collect();
        Ok(WrittenContour { text, moves })
    }

    pub(super) fn working_space<'s>(&self, skeleton: &Skeleton<'s>) -> Result<WorkingSpace<'s>, NcError> {
        let mut space = match &self.bore {
            Some(bore) => bore.working_space(skeleton, self.nose)?,
            None => self.around_a_shaft(skeleton),
        };
        space.tool_page = nose_words::on_tool_page(skeleton.dialect, self.register);
        Ok(space)
    }

    /// The text without its replay.
    #[cfg(test)]
    pub(crate) fn unproven(&self, dialect: Dialect) -> Result<String, NcError> {
        Ok(self.text(dialect, None)?.0)
    }

    /// Replays another text among the surroundings of this program.
    #[cfg(test)]
    pub(crate) fn replay_of(&self, text: &str, dialect: Dialect) -> Result<usize, NcError> {
        let (_, skeleton) = self.text(dialect, None)?;
        replay::check(text, &self.working_space(&skeleton)?)
    }

    /// The machine around a shaft, with the measured nose below everything above it.
    fn around_a_shaft<'s>(&self, skeleton: &Skeleton<'s>) -> WorkingSpace<'s> {
        let mut space = skeleton.working_space(vec![(0.0, self.end_diameter_mm())]);
        // how deep it cuts is judged by what it leaves of the outline, not by stations
        space.cut =
            replay::CommandedCut { commanded: vec![(0.0, -FAR_MM)], between: (0.0, 0.0), solid: None };
        let tip: Vec<(f64, f64)> = self.nose.iter().map(|p| (p.y, p.x)).collect();
        let above = |z: f64| (z, FAR_MM);
        let ((left, _), (right, _)) = Convex::hull(tip.clone()).bounds();
        space.tool[0] = Convex::hull(tip.into_iter().chain([above(left), above(right)]).collect());
        space
    }
}
