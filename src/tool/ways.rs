//! The four ways to go about a worn nose, each down to the path of the tool point.

use glam::DVec2;

use super::chain::{self, Element};
use super::contact::{self, Contact};
use super::error::{Place, ToolError};
use super::register::Setting;
use crate::nose::ToolGeometry;
use crate::outline::Outline;

/// What a program changes about a worn nose.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Way {
    /// The drawing's contour with G41 or G42 and the register as it is.
    #[default]
    Register,
    /// The drawing's contour with the register radius that leaves least on this part.
    BestRegister,
    /// The contour edited by what is left, with G41 or G42 and the register as it is.
    EditedContour,
    /// The path of the tool point itself, with G40.
    Path,
}

impl Way {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Register, Self::BestRegister, Self::EditedContour, Self::Path];

    /// Its name in files and on the command line.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Register => "register",
            Self::BestRegister => "best_register",
            Self::EditedContour => "edited_contour",
            Self::Path => "path",
        }
    }
}

/// A part and a tool that can cut it.
#[derive(Clone, Debug)]
pub(crate) struct Compensator<'a> {
    /// The part.
    pub outline: &'a Outline,
    /// The nose as the control takes it.
    pub setting: Setting<'a>,
    /// R in the register today, mm.
    pub register_mm: f64,
    /// Registers that the control takes, mm.
    pub register_range_mm: (f64, f64),
    /// Least increment of the register, mm.
    pub increment_mm: f64,
}

/// A way carried out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compensated {
    /// Which.
    pub way: Way,
    /// R in the register while it runs, mm.
    pub register_mm: f64,
    /// What is programmed: a contour for G41 or G42, or with G40 the path of the gauge point.
    pub programmed: Vec<Element>,
    /// The path of the tool point.
    pub path: Vec<Element>,
}

/// Distance of the angles along arcs at which e(a) is taken for the best register, rad: between
/// them a change by 1 % of R·Δa² is far below an increment.
const ANGLE_STEP_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// Angle by which a limit may be passed for rounding, rad.
const ROUNDING_RAD: f64 = 1e-9;

impl Compensator<'_> {
    /// Refuses an outline with a normal that the tool, or the measured part of its nose, does not
    /// reach.
    ///
    /// # Errors
    /// [`ToolError::Angle`] with the first such place.
    pub(crate) fn check(&self, geometry: &ToolGeometry) -> Result<(), ToolError> {
        let limits = [
            (geometry.range_rad(), "its edges leave the nose free"),
            (self.setting.nose.range_rad(), "its nose was measured"),
        ];
        for piece in &self.outline.pieces {
            for (a, at) in [(piece.from_rad, piece.from), (piece.to_rad, piece.to)] {
                for ((low, high), what) in limits {
                    if a < low - ROUNDING_RAD || a > high + ROUNDING_RAD {
                        let (low_deg, high_deg) = (low.to_degrees(), high.to_degrees());
                        let (place, a_deg) = (Place(at), a.to_degrees());
                        return Err(ToolError::Angle { place, a_deg, what, low_deg, high_deg });
                    }
                }
            }
        }
        Ok(())
    }

    /// Angles of the outline's normals: ends and, along arcs, every half degree, rad.
    pub(crate) fn angles(&self) -> Vec<f64> {
        let of = |piece: &crate::outline::Piece| {
            let steps = ((piece.to_rad - piece.from_rad).abs() / ANGLE_STEP_RAD).ceil().max(1.0) as usize;
            let piece = *piece;
            (0..=steps).map(move |k| piece.angle_at(k as f64 / steps as f64))
        };
        self.outline.pieces.iter().flat_map(of).collect()
    }

    /// Carries a way out.
    ///
    /// # Errors
    /// A register beyond the control's range, a concave place that the register's circle or the
    /// nose does not fit into.
    pub(crate) fn carry_out(&self, way: Way) -> Result<Compensated, ToolError> {
        let drawn: Vec<Element> = self
            .outline
            .pieces
            .iter()
            .enumerate()
            .map(|(source, &piece)| Element { piece, source, rolls: false })
            .collect();
        match way {
            Way::Register => self.by_register(way, self.register_mm, drawn),
            Way::BestRegister => {
                let largest = self.largest_register_mm();
                let (low, high) = self.register_range_mm;
                let range = (low, high.min(largest).max(low));
                let best = self.setting.best_radius_mm(&self.angles(), self.register_mm, range);
                self.by_register(way, (best / self.increment_mm).round() * self.increment_mm, drawn)
            }
            Way::EditedContour => {
                self.check_register(self.register_mm)?;
                let path = chain::moved(&drawn, &Contact::Nose(self.setting.nose))?;
                let back = -contact::shift(&self.setting, self.register_mm);
                self.by_register(way, self.register_mm, chain::inside(&path, self.register_mm, back)?)
            }
            Way::Path => {
                let path = chain::moved(&drawn, &Contact::Nose(self.setting.nose))?;
                let gauge = self.setting.gauge_point();
                let programmed = shifted(&path, gauge);
                Ok(Compensated { way, register_mm: self.register_mm, programmed, path })
            }
        }
    }

    /// Largest radius that fits into the outline's concave arcs, mm.
    fn largest_register_mm(&self) -> f64 {
        let concave = self.outline.pieces.iter().filter_map(|p| p.arc).filter(|arc| arc.radius_mm < 0.0);
        concave.map(|arc| -arc.radius_mm).fold(f64::INFINITY, f64::min)
    }

    fn check_register(&self, radius_mm: f64) -> Result<(), ToolError> {
        let (low_mm, high_mm) = self.register_range_mm;
        if (low_mm..=high_mm).contains(&radius_mm) {
            return Ok(());
        }
        let right =
            "State register_mm within it, or drive the nose's own path (--way path), which needs no register";
        Err(ToolError::Register { radius_mm, low_mm, high_mm, right })
    }

    fn by_register(
        &self,
        way: Way,
        register_mm: f64,
        programmed: Vec<Element>,
    ) -> Result<Compensated, ToolError> {
        self.check_register(register_mm)?;
        for element in &programmed {
            let Some(arc) = element.piece.arc.filter(|arc| arc.radius_mm < 0.0) else { continue };
            if -arc.radius_mm < register_mm {
                let why = format!(
                    "a concave arc of {:.4} mm is smaller than the register R = {register_mm:.4} mm, and controls stop with \
                     an alarm; a radius of {register_mm:.4} mm or more, or --way path, would be right",
                    -arc.radius_mm
                );
                return Err(ToolError::Gouge { place: Place(element.piece.from), why });
            }
        }
        let path = chain::moved(&programmed, &Contact::of_register(&self.setting, register_mm))?;
        Ok(Compensated { way, register_mm, programmed, path })
    }
}

fn shifted(path: &[Element], by: DVec2) -> Vec<Element> {
    path.iter().map(|e| Element { piece: e.piece.moved(by), ..*e }).collect()
}
