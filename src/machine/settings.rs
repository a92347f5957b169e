//! `[machine]`: the chain, its levers and its errors.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error_function::ErrorFunction;
use super::error_name::ErrorName;
use super::error_settings::{ErrorSettings, SlideAngle, SlideLength, SpindleAngle, SpindleLength};
use super::motion::Motion;
use super::stated_error::Domain;
use super::station::Station;
use super::topology::Topology;
use crate::setting::{SettingError, require, within};

/// Longest lever and travel, mm: beyond it the number is not in mm.
const LONGEST_MM: f64 = 10_000.0;
/// Largest orientation error, µrad; as for the other errors.
const LARGEST_URAD: f64 = 1000.0;
/// How far the head's measuring point may lie from where its levers close, mm: more is a slip of
/// sign or of a number.
const CLOSURE_MM: f64 = 1.0;

/// Where the head is fixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum HeadMount {
    /// On the X slide, beside the tool.
    #[default]
    XSlide,
    /// On what carries the X slide: the base of a T-shaped lathe, the carriage (Z slide) of the
    /// other.
    XCarrier,
}

/// A machine: which slide carries which, where the tool and the head stand, its 21 errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineSettings {
    /// Which slide carries which.
    pub chain: Topology,
    /// From the X slide's reference to the tool's tip, [x, y, z], mm: the levers of its angles.
    pub tool_mm: [f64; 3],
    /// From the X slide's reference (with X at 0) to the head's measuring point, which lies on the
    /// axis of rotation while it measures, [x, y, z], mm.
    pub head_mm: [f64; 3],
    /// What carries the head.
    #[serde(default)]
    pub head_on: HeadMount,
    /// From the Z slide's reference, [x, y, z], mm: to the part's origin (on the axis, at the
    /// chuck's face) where the Z slide carries the spindle, to the tool's tip with X at 0 where it
    /// carries the X slide.
    pub carriage_mm: [f64; 3],
    /// Height of the tip above the axis, mm: what an error along Y needs to change a diameter.
    #[serde(default)]
    pub tip_above_axis_mm: f64,
    /// Positions of X from one end of its travel to the other, mm; 0 has the tip on the axis.
    pub x_travel_mm: [f64; 2],
    /// Positions of Z from one end of its travel to the other, mm; 0 has the tip at the chuck's
    /// face.
    pub z_travel_mm: [f64; 2],
    /// Orientation of the spindle's axis about X to the motion of Z, µrad.
    #[serde(default)]
    pub a0c_urad: f64,
    /// Orientation of the spindle's axis about Y to the motion of Z, µrad.
    #[serde(default)]
    pub b0c_urad: f64,
    /// Orientation of the motion of X about Y to being square to Z, µrad.
    #[serde(default)]
    pub b0x_urad: f64,
    /// The errors of motion.
    #[serde(default)]
    pub errors: Errors,
}

/// The errors of motion, by their names of ISO 230-1; those left out are 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Errors {
    /// Positioning of X.
    pub exx: SlideLength,
    /// Straightness of X along Y.
    pub eyx: SlideLength,
    /// Straightness of X along Z.
    pub ezx: SlideLength,
    /// Roll of X.
    pub eax: SlideAngle,
    /// Yaw of X.
    pub ebx: SlideAngle,
    /// Pitch of X.
    pub ecx: SlideAngle,
    /// Straightness of Z along X.
    pub exz: SlideLength,
    /// Straightness of Z along Y.
    pub eyz: SlideLength,
    /// Positioning of Z.
    pub ezz: SlideLength,
    /// Pitch of Z.
    pub eaz: SlideAngle,
    /// Yaw of Z.
    pub ebz: SlideAngle,
    /// Roll of Z.
    pub ecz: SlideAngle,
    /// Radial error motion of C along X.
    pub exc: SpindleLength,
    /// Radial error motion of C along Y.
    pub eyc: SpindleLength,
    /// Axial error motion of C.
    pub ezc: SpindleLength,
    /// Tilt error motion of C about X.
    pub eac: SpindleAngle,
    /// Tilt error motion of C about Y.
    pub ebc: SpindleAngle,
    /// Angular positioning of C.
    pub ecc: SpindleAngle,
}

impl Errors {
    /// All, in the order of [`ErrorName::ALL`].
    fn all(&self) -> [&dyn ErrorSettings; 18] {
        [
            &self.exx, &self.eyx, &self.ezx, &self.eax, &self.ebx, &self.ecx, &self.exz, &self.eyz,
            &self.ezz, &self.eaz, &self.ebz, &self.ecz, &self.exc, &self.eyc, &self.ezc, &self.eac,
            &self.ebc, &self.ecc,
        ]
    }

    /// All, to put the columns of files in place.
    pub(crate) fn all_mut(&mut self) -> [&mut dyn ErrorSettings; 18] {
        [
            &mut self.exx,
            &mut self.eyx,
            &mut self.ezx,
            &mut self.eax,
            &mut self.ebx,
            &mut self.ecx,
            &mut self.exz,
            &mut self.eyz,
            &mut self.ezz,
            &mut self.eaz,
            &mut self.ebz,
            &mut self.ecz,
            &mut self.exc,
            &mut self.eyc,
            &mut self.ezc,
            &mut self.eac,
            &mut self.ebc,
            &mut self.ecc,
        ]
    }
}

/// The key of an error in a config.
pub(crate) fn key_of(name: ErrorName) -> String {
    format!("machine.errors.{}", name.code().to_lowercase())
}

impl MachineSettings {
    /// The errors as functions.
    ///
    /// # Errors
    /// The first value that cannot be right: travels of no length, levers and errors in another
    /// unit, tables out of order or beyond the travel.
    pub(crate) fn motion(&self) -> Result<Motion, SettingError> {
        travel("machine.x_travel_mm", self.x_travel_mm)?;
        travel("machine.z_travel_mm", self.z_travel_mm)?;
        lever("machine.tool_mm", self.tool_mm)?;
        lever("machine.head_mm", self.head_mm)?;
        lever("machine.carriage_mm", self.carriage_mm)?;
        let right = "between -10 and 10 mm";
        within("machine.tip_above_axis_mm", self.tip_above_axis_mm, -10.0, 10.0, right)?;
        for (name, value) in [("b0x", self.b0x_urad), ("a0c", self.a0c_urad), ("b0c", self.b0c_urad)] {
            let right =
                "within ±1000 µrad; more is a thousand times what a machine has: is the number in nrad?";
            within(&format!("machine.{name}_urad"), value, -LARGEST_URAD, LARGEST_URAD, right)?;
        }
        self.head_closes()?;
        let [x, z] = [self.x_travel_mm, self.z_travel_mm].map(|[from, to]| Domain::Travel(from, to));
        let mut functions: [ErrorFunction; 18] = std::array::from_fn(|_| ErrorFunction::default());
        for (k, settings) in self.errors.all().into_iter().enumerate() {
            let domain = [x, z, Domain::Turn][k / 6];
            functions[k] = settings.stated().function(&key_of(ErrorName::ALL[k]), domain)?;
        }
        Ok(Motion {
            functions,
            orientations_rad: [self.b0x_urad, self.a0c_urad, self.b0c_urad].map(|urad| 1e-6 * urad),
        })
    }

    /// The head's measuring point lies on the axis of rotation: the numbers that follow from it are
    /// checked.
    fn head_closes(&self) -> Result<(), SettingError> {
        let height = self.tool_mm[1] - self.tip_above_axis_mm;
        let right = format!(
            "within 1 mm of {height}, the height of the axis by machine.tool_mm[1] and tip_above_axis_mm: the head measures on the axis"
        );
        require(
            (self.head_mm[1] - height).abs() <= CLOSURE_MM,
            "machine.head_mm[1]",
            self.head_mm[1],
            &right,
        )?;
        match self.head_on {
            HeadMount::XSlide => {
                let at = self.head_x_mm();
                let [from, to] = self.x_travel_mm;
                let right = format!(
                    "such that the head reaches the axis: with X at machine.tool_mm[0] - machine.head_mm[0] = {at} mm it leaves the travel from {from} to {to} mm"
                );
                require((from..=to).contains(&at), "machine.head_mm[0]", self.head_mm[0], &right)
            }
            HeadMount::XCarrier => {
                let right = format!(
                    "within 1 mm of machine.tool_mm[0] = {}: a head that does not ride on X measures where the tip stands with X at 0",
                    self.tool_mm[0]
                );
                let off = self.head_mm[0] - self.tool_mm[0];
                require(off.abs() <= CLOSURE_MM, "machine.head_mm[0]", self.head_mm[0], &right)
            }
        }
    }

    /// Position of X with the head on the axis, mm; a head that does not ride on X has none.
    fn head_x_mm(&self) -> f64 {
        match self.head_on {
            HeadMount::XSlide => self.tool_mm[0] - self.head_mm[0],
            HeadMount::XCarrier => 0.0,
        }
    }

    /// The tool at a position of both slides, mm.
    pub(crate) fn tool(&self, x_mm: f64, z_mm: f64) -> Station {
        let carriage = Vector3::from(self.carriage_mm);
        let point_mm = Vector3::new(x_mm, 0.0, z_mm);
        let z_lever_mm = match self.chain {
            Topology::TShaped => carriage,
            Topology::Carriage => carriage + Vector3::new(x_mm, 0.0, 0.0),
        };
        Station { point_mm, x_mm, z_mm, x_lever_mm: Some(Vector3::from(self.tool_mm)), z_lever_mm }
    }

    /// What stands on the X slide at a lever from its reference, mm, with its point at x and z of
    /// the part: both slides stand off the tool's positions by the difference of the levers.
    pub(crate) fn on_x_slide(&self, lever_mm: [f64; 3], x_mm: f64, z_mm: f64) -> Station {
        let [tool, lever, carriage] = [self.tool_mm, lever_mm, self.carriage_mm].map(Vector3::from);
        let beside = lever - tool;
        let z_lever_mm = match self.chain {
            Topology::TShaped => carriage,
            Topology::Carriage => carriage + Vector3::new(x_mm, beside.y, beside.z),
        };
        Station {
            point_mm: Vector3::new(x_mm, 0.0, z_mm),
            x_mm: x_mm - beside.x,
            z_mm: z_mm - beside.z,
            x_lever_mm: Some(lever),
            z_lever_mm,
        }
    }

    /// The head on the axis with the Z slide at a position, mm: the point that it measures lies off
    /// the tool's by the difference of their levers along z.
    pub(crate) fn head(&self, z_mm: f64) -> Station {
        let [tool, head, carriage] = [self.tool_mm, self.head_mm, self.carriage_mm].map(Vector3::from);
        let beside = head - tool;
        let x_mm = self.head_x_mm();
        let z_lever_mm = match self.chain {
            Topology::TShaped => carriage,
            Topology::Carriage => carriage + Vector3::new(0.0, beside.y, beside.z),
        };
        Station {
            point_mm: Vector3::new(0.0, 0.0, z_mm + beside.z),
            x_mm,
            z_mm,
            x_lever_mm: (self.head_on == HeadMount::XSlide).then_some(head),
            z_lever_mm,
        }
    }

    /// From the tool's point to the head's along z, mm.
    pub(crate) fn head_beside_tool_mm(&self) -> f64 {
        self.head_mm[2] - self.tool_mm[2]
    }
}

fn travel(key: &str, [from, to]: [f64; 2]) -> Result<(), SettingError> {
    let right = "two positions in mm, the first below the second, within ±10000 mm";
    let holds = from < to && [from, to].iter().all(|v| v.abs() <= LONGEST_MM);
    require(holds, key, format!("[{from}, {to}]"), right)
}

fn lever(key: &str, values: [f64; 3]) -> Result<(), SettingError> {
    for (k, value) in values.into_iter().enumerate() {
        let right = "within ±10000 mm: is the number in µm?";
        within(&format!("{key}[{k}]"), value, -LONGEST_MM, LONGEST_MM, right)?;
    }
    Ok(())
}
