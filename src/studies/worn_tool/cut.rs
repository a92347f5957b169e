//! A workpiece by one program: the way, what it takes from the measured nose, and the surface that
//! the true nose leaves by it.

use glam::DVec2;
use serde::Serialize;

use super::error::WornToolError;
use super::noses::{Noses, PaperRadii};
use super::workpieces::{Edit, Workpiece};
use crate::job::CuttingTruth;
use crate::outline::{Outline, Side};
use crate::process::NosePath;
use crate::tool::{Compensated, Compensator, Setting, Stated, Way};

/// What a program does about the nose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Tried {
    /// Nothing: the drawing with the radius R0 of the new nose in the register.
    RegisterR0,
    /// The drawing with the paper's R1 in the register, from its own measurement.
    RegisterR1,
    /// The paper's edit of the drawing by d = R1 − r, R1 in the register; in a batch by dx.
    PaperEdit,
    /// The drawing with the register that leaves least.
    BestRegister,
    /// The contour edited by e(a).
    EditedContour,
    /// The path of the measured nose.
    Path,
}

impl Tried {
    /// All of them; the first is the state before compensation.
    pub(crate) const ALL: [Self; 6] = [
        Self::RegisterR0,
        Self::RegisterR1,
        Self::PaperEdit,
        Self::BestRegister,
        Self::EditedContour,
        Self::Path,
    ];

    /// In words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::RegisterR0 => "before: register R0",
            Self::RegisterR1 => "register R1 (paper)",
            Self::PaperEdit => "edited by d (paper)",
            Self::BestRegister => "best register",
            Self::EditedContour => "contour edited by e(a)",
            Self::Path => "path of the nose",
        }
    }

    fn is_of_paper(self) -> bool {
        matches!(self, Self::RegisterR1 | Self::PaperEdit)
    }

    /// The way of [`crate::tool`] that it takes.
    pub(super) fn way(self) -> Way {
        match self {
            Self::RegisterR0 | Self::RegisterR1 | Self::PaperEdit => Way::Register,
            Self::BestRegister => Way::BestRegister,
            Self::EditedContour => Way::EditedContour,
            Self::Path => Way::Path,
        }
    }
}

/// Registers that controls take, and their increment, mm.
const REGISTERS_MM: (f64, f64) = (0.001, 9.999);
const INCREMENT_MM: f64 = 1e-4;
/// Pieces of the longest outline: a shoulder, a cylinder, a cone, their ends.
const MOST_PIECES: usize = 8;

/// A workpiece and a program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut<'a> {
    pub(super) noses: &'a Noses,
    pub(super) workpiece: Workpiece,
    pub(super) program: Tried,
    pub(super) cone_deg: [f64; 2],
}

impl Cut<'_> {
    pub(super) fn cone_rad(&self) -> f64 {
        self.workpiece.cone_rad(self.cone_deg)
    }

    /// Nose radius in the register as it is set, mm; none of the ways that choose or need none, and
    /// where the paper's mode has none.
    pub(super) fn register_mm(&self) -> Option<f64> {
        match self.program {
            Tried::RegisterR0 | Tried::EditedContour => Some(self.noses.nominal_mm),
            Tried::RegisterR1 | Tried::PaperEdit => {
                self.noses.paper.as_ref().ok().map(PaperRadii::set_radius_mm)
            }
            Tried::BestRegister | Tried::Path => None,
        }
    }

    /// What the paper changes in the drawing.
    pub(super) fn edit(&self) -> Result<Edit, WornToolError> {
        if !self.program.is_of_paper() {
            return Ok(Edit::default());
        }
        let paper = self.noses.paper.as_ref().map_err(|why| WornToolError::Paper(why.clone()))?;
        if self.program == Tried::RegisterR1 {
            return Ok(Edit::default());
        }
        let d = paper.set_radius_mm() - paper.radius_mm;
        Ok(match self.workpiece {
            Workpiece::LengthBehindCone | Workpiece::LargeDiameter => {
                Edit { cone_dz: d / self.cone_rad().sin(), ..Edit::default() }
            }
            Workpiece::ArcRadius => Edit { arc: d, ..Edit::default() },
            Workpiece::BatchDiameter => Edit { cylinder_dx: paper.gaps_mm[0], ..Edit::default() },
        })
    }

    /// Extents with which the tool was set: those of the new nose in a batch, else by touching.
    pub(super) fn stated(&self) -> Stated {
        let new = (self.workpiece == Workpiece::BatchDiameter).then_some(self.noses.nominal_mm);
        Stated { x_mm: new, z_mm: new, u_mm: 0.0 }
    }

    /// The error of the size on the surface itself where the slides stand off by `slides` along
    /// each piece, µm.
    pub(super) fn error_um(&self, slides: &dyn Fn(usize) -> DVec2) -> Result<f64, WornToolError> {
        self.workpiece.error_um(&self.path(slides)?, self.cone_rad())
    }

    /// Nose radius in the register while the program runs, mm; none of a path without one, and of a
    /// program that is refused.
    pub(super) fn register_used_mm(&self) -> Option<f64> {
        let (done, _) = self.carried_out().ok()?;
        (self.program != Tried::Path).then_some(done.register_mm)
    }

    /// The way as carried out for the measured nose, and the step from its tool point to that of
    /// the true nose.
    fn carried_out(&self) -> Result<(Compensated, DVec2), WornToolError> {
        let Noses { geometry, known, real, .. } = self.noses;
        let corners = self.workpiece.corners(self.cone_rad(), &self.edit()?);
        let outline = Outline::from_corners(&corners, Side::External)?;
        let stated = self.stated();
        let compensator = Compensator {
            outline: &outline,
            setting: Setting::new(known, geometry, &stated)?,
            register_mm: self.register_mm().unwrap_or(self.noses.nominal_mm),
            register_range_mm: REGISTERS_MM,
            increment_mm: INCREMENT_MM,
        };
        compensator.check(geometry)?;
        let done = compensator.carry_out(self.program.way())?;
        let by = compensator.setting.to_tool_point_of(&Setting::new(real, geometry, &stated)?);
        Ok((done, by))
    }

    /// What really cuts: the true nose, its slides off by `slides` along each piece.
    pub(super) fn truth(&self, slides: &dyn Fn(usize) -> DVec2) -> CuttingTruth {
        CuttingTruth { nose: self.noses.real.clone(), slides_mm: (0..MOST_PIECES).map(slides).collect() }
    }

    /// The true nose on the path of the program.
    fn path(&self, slides: &dyn Fn(usize) -> DVec2) -> Result<NosePath, WornToolError> {
        let (done, by) = self.carried_out()?;
        Ok(self.truth(slides).path(&done.path, by))
    }
}
