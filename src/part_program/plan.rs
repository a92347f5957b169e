//! The program of a part: outline, rough and finishing path, text, replay.

use glam::DVec2;

use super::error::PartProgramError;
use super::left::{self, LeftPlace};
use super::placement::Placed;
use crate::nc::{
    ContourProgram, Dialect, Direction, FromBar, NcSettings, NoseRegister, Roughing, ToolMove, Workpiece,
};
use crate::nose::{Feed, NoseProfile, Support, ToolGeometry};
use crate::outline::{Outline, Piece, Side};
use crate::plan::CuttingData;
use crate::setting::{SettingError, positive, within};
use crate::tool::{
    Compensated, Compensator, LargestLeft, LeftOut, Reachable, Setting, Tool, ToolError, ToolFile, Way,
    measured, remainders,
};

/// Depths of the cuts, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cuts {
    /// Depth of a rough cut a_p, on the radius and along Z.
    pub depth_mm: f64,
    /// What roughing leaves for the finishing cut, along the normal.
    pub allowance_mm: f64,
    /// How far the bar stands beyond the part's end face.
    pub facing_mm: f64,
}

/// A part to be turned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPlan<'a> {
    /// Its outside, Z from its end at the chuck.
    pub outline: &'a Outline,
    /// Z of that end in the machine, mm.
    pub from_z_mm: f64,
    /// Diameter of the bar, mm.
    pub stock_mm: f64,
    /// The tool.
    pub tool: &'a ToolFile,
    /// Its nose as measured; none where it is taken for round, of its nominal radius.
    pub nose: Option<&'a NoseProfile>,
    /// What the finishing cut does about the nose.
    pub way: Way,
    /// The machine.
    pub machine: &'a NcSettings,
    /// Cutting data of roughing and finishing.
    pub cutting: CuttingData,
    /// Depths of the cuts.
    pub cuts: Cuts,
}

/// A program that has passed its replays.
#[derive(Clone, Debug)]
pub(crate) struct PartProgram {
    /// Its text.
    pub text: String,
    /// The part in the machine.
    pub placed: Placed,
    /// What the tool can cut of it.
    pub reachable: Reachable,
    /// Its moves.
    pub moves: Vec<ToolMove>,
    /// Places (Z, radius) of what it leaves of the bar, mm.
    pub left_mm: Vec<(f64, f64)>,
    /// Where material stays.
    pub places: Vec<LeftPlace>,
    /// The largest remainder on what the tool can cut, by the program's own moves.
    pub largest: Option<LargestLeft>,
}

/// Directions of a nose that is taken for round, degrees apart.
const ROUND_STEP_DEG: f64 = 1.0;

impl PartPlan<'_> {
    /// Writes the program.
    ///
    /// # Errors
    /// Values out of range, a tool for bores, a part in the grip, a path that gouges, a program
    /// that collides.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<PartProgram, PartProgramError> {
        self.check()?;
        let geometry = self.tool.geometry()?;
        let round = round(&geometry)?;
        let nose = self.nose.unwrap_or(&round);
        let placed = Placed::new(self.outline, self.from_z_mm, self.machine.least_z_mm)?;
        let reachable = Reachable::of(&placed.free, &geometry);
        let compensator = self.compensator(&reachable.outline, nose, (&geometry, dialect))?;
        compensator.check(&geometry)?;
        let tool = Tool::new(nose);
        let (done, _) = measured(&compensator, &tool, self.way)?;
        let gauge = compensator.setting.gauge_point();
        let boundary = self.boundary(&reachable.outline, nose, (&geometry, dialect), gauge)?;
        let written =
            self.program((&placed, &done), &boundary, (&compensator.setting, &geometry, dialect))?;
        let own = |m: &ToolMove| (!m.rapid && !m.roughing).then_some((m.from - gauge, m.to - gauge));
        let moves: Vec<(DVec2, DVec2)> = written.moves.iter().filter_map(own).collect();
        let largest = LargestLeft::of(&remainders(&reachable.outline, &done.path, &moves, &tool));
        let places = left::places(&placed.drawn, &written.left, &reachable.left_out, placed.gripped_to_mm)?;
        Ok(PartProgram {
            left_mm: written.left.places().collect(),
            text: written.text,
            moves: written.moves,
            placed,
            reachable,
            places,
            largest,
        })
    }

    fn check(&self) -> Result<(), SettingError> {
        let Cuts { depth_mm, allowance_mm, facing_mm } = self.cuts;
        within("depth", depth_mm, 0.05, 20.0, "a depth of cut of 0.05 to 20 mm of radius")?;
        within("allowance", allowance_mm, 0.01, 2.0, "an allowance of 0.01 to 2 mm")?;
        within("facing", facing_mm, 0.0, 50.0, "a length of 0 to 50 mm")?;
        within("from-z", self.from_z_mm, 0.0, 1e4, "a Z of 0 to 10000 mm")?;
        positive("speed", self.cutting.speed_m_per_min)?;
        positive("feed", self.cutting.feed_mm_per_rev)?;
        match (self.tool.side, self.tool.feed) {
            (Side::External, Feed::TowardsChuck) => Ok(()),
            (Side::Internal, _) => {
                Err(SettingError::of("side", "internal", "\"external\": a bar is turned from outside"))
            }
            (_, Feed::TowardsTailstock) => {
                let right = "\"towards_chuck\": the part is roughed from its end face";
                Err(SettingError::of("feed", "towards_tailstock", right))
            }
        }
    }

    fn compensator<'s>(
        &self,
        outline: &'s Outline,
        nose: &'s NoseProfile,
        (geometry, dialect): (&ToolGeometry, Dialect),
    ) -> Result<Compensator<'s>, ToolError> {
        Ok(Compensator {
            outline,
            setting: Setting::new(nose, geometry, &self.tool.stated())?,
            register_mm: self.tool.register_mm.unwrap_or(geometry.nose_radius_mm),
            register_range_mm: dialect.nose_register_mm(),
            increment_mm: 10f64.powi(-(dialect.x_decimals() as i32)),
        })
    }

    /// The path of the gauge point that leaves the allowance: that of a nose which is larger by it.
    fn boundary(
        &self,
        outline: &Outline,
        nose: &NoseProfile,
        tool: (&ToolGeometry, Dialect),
        gauge: DVec2,
    ) -> Result<Vec<Piece>, PartProgramError> {
        let larger = |(a_rad, h): (f64, f64)| Support { a_rad, h_mm: h + self.cuts.allowance_mm, u_mm: 1e-3 };
        let supports: Vec<Support> =
            nose.supports(ROUND_STEP_DEG.to_radians()).into_iter().map(larger).collect();
        let larger = NoseProfile::new(&supports, None, 0.0).map_err(no_nose)?;
        let path = self.compensator(outline, &larger, tool)?.carry_out(Way::Path)?.path;
        Ok(path.iter().map(|e| e.piece.moved(gauge)).collect())
    }

    fn program(
        &self,
        (placed, done): (&Placed, &Compensated),
        boundary: &[Piece],
        (setting, geometry, dialect): (&Setting<'_>, &ToolGeometry, Dialect),
    ) -> Result<FromBar, PartProgramError> {
        let gauge = setting.gauge_point();
        let nose: Vec<DVec2> = setting.nose.outline().into_iter().map(|p| p - gauge).collect();
        let edges = self.edges(setting, geometry);
        let pieces: Vec<Piece> = done.programmed.iter().map(|e| e.piece).collect();
        let register =
            (done.way != Way::Path).then_some(NoseRegister { radius_mm: done.register_mm, tip: setting.tip });
        let bar_end_mm = placed.drawn.z_mm().1 + self.cuts.facing_mm;
        let about = format!("finishing by {}", done.way.as_str().replace('_', " "));
        let program = ContourProgram {
            pieces: &pieces,
            register,
            nose: &nose,
            piece: &Workpiece {
                direction: Direction::TowardsChuck,
                ..Workpiece::new(bar_end_mm, self.stock_mm, self.stock_mm)
            },
            bore: None,
            settings: self.machine,
            cutting: self.cutting,
            about: &about,
        };
        let roughing = Roughing {
            boundary,
            bar_mm: 0.5 * self.stock_mm,
            facing_mm: (self.cuts.facing_mm - self.cuts.allowance_mm).max(0.0),
            depth_mm: self.cuts.depth_mm,
            feed_mm_per_rev: self.cutting.feed_mm_per_rev,
            edges: &edges,
        };
        Ok(program.write_from_bar(dialect, &roughing)?)
    }
}

impl PartPlan<'_> {
    /// The nose with both edges, straight on from where it touches the steepest surfaces that they
    /// clear, about the gauge point. They are longer than any bar is deep: how much of an edge is
    /// there to cut is the setter's.
    fn edges(&self, setting: &Setting<'_>, geometry: &ToolGeometry) -> Vec<DVec2> {
        let (low, high) = geometry.range_rad();
        let along = |a_rad: f64| 2.0 * self.stock_mm * DVec2::from_angle(a_rad).perp();
        // what touches is −q(a) of the nose
        let ends = [along(low) - setting.nose.contact(low), -along(high) - setting.nose.contact(high)];
        let gauge = setting.gauge_point();
        setting.nose.outline().into_iter().chain(ends).map(|p| p - gauge).collect()
    }
}

impl PartProgram {
    /// What the tool leaves out, with why.
    pub(crate) fn left_out(&self) -> &[LeftOut] {
        &self.reachable.left_out
    }
}

fn no_nose(cause: crate::nose::NoseError) -> PartProgramError {
    ToolError::Profile { image: "nominal nose".to_owned(), cause }.into()
}

/// A round nose of the nominal radius over the normals that the tool can cut, about its centre.
fn round(geometry: &ToolGeometry) -> Result<NoseProfile, PartProgramError> {
    let (low, high) = geometry.range_rad();
    // where X and Z are touched as well: a nominal nose is round there too
    let (low, high) = (low.min(0.0), high.max(std::f64::consts::FRAC_PI_2));
    let steps = ((high - low).to_degrees() / ROUND_STEP_DEG).ceil().max(2.0) as usize;
    let support = |k: usize| Support {
        a_rad: low + (high - low) * k as f64 / steps as f64,
        h_mm: geometry.nose_radius_mm,
        u_mm: 0.0,
    };
    NoseProfile::new(&(0..=steps).map(support).collect::<Vec<_>>(), None, 0.0).map_err(no_nose)
}
