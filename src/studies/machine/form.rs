//! The form of the part that a machine turns, and what a probe on it indicates of that:
//! straightness of a generatrix, cylindricity, flatness of a face on a spiral.
//!
//! The tool stands still while the part turns: the place at angle θ of the part passes it at the
//! spindle angle −θ, and the other side of the axis at 180° − θ.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::config::MachineStudyConfig;
use super::prepared::Prepared;
use super::spiral::{Spiral, SpiralPoint};
use crate::gauge::form::{
    FormError, least_squares_cylinder, least_squares_line, least_squares_plane, minimum_zone_cylinder,
    minimum_zone_line, minimum_zone_plane,
};
use crate::machine::response::{Side, cut_mm, probe_mm};
use crate::machine::{Chain, Conditions, Pose};

/// Angles of a section: lobes up to 35 a turn are seen.
const ANGLES: u32 = 72;
/// Most sections of the cylinder: more change nothing that errors over a travel have.
const SECTIONS: usize = 51;

/// A deviation of form, µm: what it is, and what a probe on the machine would indicate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FormRow {
    /// Which form.
    pub form: &'static str,
    /// Number of points.
    pub points: usize,
    /// Peak to valley about the least-squares feature.
    pub least_squares_um: f64,
    /// Minimum zone.
    pub minimum_zone_um: f64,
    /// Minimum zone of what a probe on the tool's side indicates.
    pub probe_um: f64,
    /// The same on the opposite side; none where X does not reach it.
    pub opposite_um: Option<f64>,
}

/// Which surface is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Look {
    /// As it is.
    True,
    /// As a probe on a side indicates it.
    Probe(Side),
}

/// The forms of a part; of a face where X reaches the middle.
///
/// # Errors
/// A form that its points do not determine.
pub(crate) fn forms(machine: &Prepared, config: &MachineStudyConfig) -> Result<Vec<FormRow>, FormError> {
    let turned = Turned { machine, config };
    let spiral = config.spiral(machine).points();
    let mut rows = vec![
        turned.row("straightness of a generatrix", &|look| turned.generatrix(look))?,
        turned.row("cylindricity", &|look| turned.cylinder(look))?,
    ];
    // A slide that does not reach the middle turns no face.
    if spiral.first().is_some_and(|first| machine.settings.x_travel_mm[0] <= first.radius_mm) {
        rows.push(turned.row("flatness of a face, on the spiral", &|look| turned.face(&spiral, look))?);
    }
    Ok(rows)
}

/// Peak to valley about the least-squares feature, minimum zone (mm), number of points.
type Zones = (f64, f64, usize);

/// A machine and what is turned on it.
struct Turned<'a> {
    machine: &'a Prepared,
    config: &'a MachineStudyConfig,
}

impl Turned<'_> {
    fn row(
        &self,
        form: &'static str,
        of: &dyn Fn(Look) -> Result<Zones, FormError>,
    ) -> Result<FormRow, FormError> {
        let (least_squares, minimum, points) = of(Look::True)?;
        let reaches = self.machine.settings.x_travel_mm[0] <= -self.reach_mm();
        let opposite = reaches.then(|| of(Look::Probe(Side::Opposite))).transpose()?;
        Ok(FormRow {
            form,
            points,
            least_squares_um: 1e3 * least_squares,
            minimum_zone_um: 1e3 * minimum,
            probe_um: 1e3 * of(Look::Probe(Side::Tool))?.1,
            opposite_um: opposite.map(|zones| 1e3 * zones.1),
        })
    }

    /// Largest radius that the opposite side must reach, mm.
    fn reach_mm(&self) -> f64 {
        self.config.part.radius_mm().max(self.config.spiral(self.machine).radius_mm)
    }

    /// The pose of the tool at a position of both slides while a place at an angle passes it.
    fn pose(&self, x_mm: f64, z_mm: f64, angle_rad: f64) -> Pose {
        let passing = if x_mm < 0.0 { 0.5 * TAU - angle_rad } else { -angle_rad };
        let state = Conditions { c_deg: passing.to_degrees(), ..self.machine.state };
        let values = self.machine.motion.values(x_mm, z_mm, &state);
        Chain { topology: self.machine.settings.chain, values }.pose(&self.machine.settings.tool(x_mm, z_mm))
    }

    /// The radius' deviation at a place, mm.
    fn radial(&self, z_mm: f64, angle_rad: f64, look: Look) -> f64 {
        let (part, tip) = (self.config.part.part(), self.machine.settings.tip_above_axis_mm);
        let radius = self.config.part.radius_mm();
        let cut = cut_mm(&part, tip, &self.pose(radius, z_mm, angle_rad));
        let own = match look {
            Look::True => 0.0,
            Look::Probe(side) => {
                let x_mm = if side == Side::Tool { radius } else { -radius };
                probe_mm(&part, tip, side, &self.pose(x_mm, z_mm, angle_rad))
            }
        };
        0.5 * (cut + own)
    }

    /// The height of a face at a place, mm.
    fn axial(&self, z_mm: f64, at: &SpiralPoint, look: Look) -> f64 {
        let cut = self.pose(at.radius_mm, z_mm, at.angle_rad).shift_mm.z;
        match look {
            Look::True => cut,
            Look::Probe(Side::Tool) => cut - self.pose(at.radius_mm, z_mm, at.angle_rad).shift_mm.z,
            Look::Probe(Side::Opposite) => cut - self.pose(-at.radius_mm, z_mm, at.angle_rad).shift_mm.z,
        }
    }

    fn generatrix(&self, look: Look) -> Result<Zones, FormError> {
        let points: Vec<DVec2> =
            self.machine.z_mm.iter().map(|z| DVec2::new(*z, self.radial(*z, 0.0, look))).collect();
        let least = least_squares_line(&points)?.peak_to_valley();
        Ok((least, minimum_zone_line(&points)?.peak_to_valley(), points.len()))
    }

    fn cylinder(&self, look: Look) -> Result<Zones, FormError> {
        let radius = self.config.part.radius_mm();
        let skip = self.machine.z_mm.len().div_ceil(SECTIONS);
        let mut points = Vec::new();
        for z in self.machine.z_mm.iter().step_by(skip) {
            for k in 0..ANGLES {
                let angle = TAU * f64::from(k) / f64::from(ANGLES);
                let r = radius + self.radial(*z, angle, look);
                points.push(DVec3::new(r * angle.cos(), r * angle.sin(), *z));
            }
        }
        let least = least_squares_cylinder(&points)?.cyl_t;
        Ok((least, minimum_zone_cylinder(&points)?.width, points.len()))
    }

    fn face(&self, spiral: &[SpiralPoint], look: Look) -> Result<Zones, FormError> {
        let z = self.config.spiral(self.machine).z_mm;
        let points: Vec<DVec3> = spiral.iter().map(|at| at.place(self.axial(z, at, look))).collect();
        let least = least_squares_plane(&points)?.peak_to_valley();
        Ok((least, minimum_zone_plane(&points)?.peak_to_valley(), points.len()))
    }
}

impl MachineStudyConfig {
    /// The spiral on the face.
    pub(super) fn spiral(&self, machine: &Prepared) -> Spiral {
        let settings = self.spiral;
        let radius_mm = settings.radius_mm.unwrap_or(self.part.radius_mm());
        Spiral {
            radius_mm,
            z_mm: settings.z_mm.unwrap_or(machine.settings.z_travel_mm[1]),
            pitch_mm: settings.pitch_mm(radius_mm),
            points_per_turn: settings.points_per_turn,
        }
    }
}
