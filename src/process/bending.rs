//! What bends the axis besides the radial force that sets the size: self weight, tailstock, chuck,
//! and the force in both planes.
//!
//! x is up in the image and y towards the camera; angles in the plane across the spindle are
//! counted from x towards y, the sense in which the spindle turns. Two deflection lines are kept
//! apart: one at rest (weight, tailstock, force) and one that turns with the part (the chuck's
//! eccentricity, the thrust on a bow).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::beam::Supports;
use super::check::Range;
use super::force_components::Components;
use super::line::{Action, PointForce, Span, deflection_line_mm};
use super::material::Material;
use super::section::Section;
use crate::numerics::neighbours::neighbours;
use crate::setting::SettingError;
use crate::shaft::AxisKnot;

/// Acceleration of free fall, m/s² (ISO 80000-3, conventional value).
const GRAVITY_M_PER_S2: f64 = 9.80665;

/// `[process.bending]`: how the axis lies in the machine; by default only the force bends the
/// shaft, while it cuts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BendingSettings {
    /// Whether the shaft sags under its own weight (`process.material.density_kg_per_m3`).
    pub self_weight: bool,
    /// Direction of gravity across the spindle, degrees from x (up in the image) towards y (towards
    /// the camera): 180 is down in the image, 270 away from the camera.
    pub gravity_deg: f64,
    /// Direction from the spindle's axis to the tool, degrees, counted alike. The radial force
    /// points away from it; the tangential one against the motion of the surface there.
    pub tool_deg: f64,
    /// Whether the tailstock's thrust bends further what is bent or bowed
    /// (`process.support.tailstock_thrust_n`).
    pub tailstock_push: bool,
    /// Offset of the tailstock's centre from the spindle's axis along x, µm.
    pub tailstock_x_um: f64,
    /// Offset of the tailstock's centre along y, µm.
    pub tailstock_y_um: f64,
    /// Offset at which the chuck holds the part's axis after every pass, µm; turns with the
    /// spindle, while the other end runs true on its centre.
    pub chuck_eccentricity_um: f64,
    /// Body angle of that offset, degrees.
    pub chuck_eccentricity_deg: f64,
    /// Whether the diameter carries the tangential deflection too (equation 1 of the slender-shaft
    /// paper); its effect is of second order.
    pub tangential_error: bool,
}

impl Default for BendingSettings {
    fn default() -> Self {
        Self {
            self_weight: false,
            gravity_deg: 180.0,
            tool_deg: 0.0,
            tailstock_push: false,
            tailstock_x_um: 0.0,
            tailstock_y_um: 0.0,
            chuck_eccentricity_um: 0.0,
            chuck_eccentricity_deg: 0.0,
            tangential_error: false,
        }
    }
}

impl BendingSettings {
    pub(super) fn validate(&self) -> Result<(), SettingError> {
        let angle = Range::between(-360.0, 360.0);
        angle.check("bending.gravity_deg", self.gravity_deg)?;
        angle.check("bending.tool_deg", self.tool_deg)?;
        angle.check("bending.chuck_eccentricity_deg", self.chuck_eccentricity_deg)?;
        // An offset of more than a millimetre is a mistake in the config, not a misalignment.
        let offset = Range::between(-1e3, 1e3);
        offset.check("bending.tailstock_x_um", self.tailstock_x_um)?;
        offset.check("bending.tailstock_y_um", self.tailstock_y_um)?;
        offset.check("bending.chuck_eccentricity_um", self.chuck_eccentricity_um)
    }

    /// Whether nothing bends the axis once the tool is clear.
    pub(crate) fn is_straight(&self) -> bool {
        let offsets = [self.tailstock_x_um, self.tailstock_y_um, self.chuck_eccentricity_um];
        !self.self_weight && !self.tailstock_push && offsets.iter().all(|o| *o == 0.0)
    }

    /// Direction from the spindle's axis to the tool, (x, y).
    pub(crate) fn towards_tool(&self) -> [f64; 2] {
        direction(self.tool_deg)
    }

    /// The cutting force on the shaft in the image plane and towards the camera, N: the radial part
    /// away from the tool, the tangential one against the surface's motion under it (ISO 3002-4;
    /// the spindle turns from x towards y).
    pub(crate) fn force_n(&self, force: &Components) -> [f64; 2] {
        let [x, y] = self.towards_tool();
        [-force.passive_n * x + force.cutting_n * y, -force.passive_n * y - force.cutting_n * x]
    }

    fn gravity(&self) -> [f64; 2] {
        if self.self_weight { direction(self.gravity_deg) } else { [0.0, 0.0] }
    }
}

fn direction(deg: f64) -> [f64; 2] {
    let (sin, cos) = deg.to_radians().sin_cos();
    [cos, sin]
}

/// Weight of a solid round bar per unit length, N/mm.
pub(crate) fn weight_n_per_mm(diameter_mm: f64, material: &Material) -> f64 {
    let area_mm2 = std::f64::consts::FRAC_PI_4 * diameter_mm * diameter_mm;
    1e-9 * material.density_kg_per_m3 * area_mm2 * GRAVITY_M_PER_S2
}

/// A shaft in its supports: its elements from chuck to tailstock.
#[derive(Clone, Debug)]
pub(crate) struct HeldShaft<'a> {
    /// Length of every element, mm.
    pub element_mm: Vec<f64>,
    /// Machine z of every node, mm: one more than elements.
    pub node_z_mm: Vec<f64>,
    /// Diameter of every element, mm.
    pub diameter_mm: Vec<f64>,
    /// Material.
    pub material: &'a Material,
    /// Supports.
    pub supports: &'a Supports,
    /// Axial thrust of the tailstock, N.
    pub thrust_n: f64,
    /// The `[process.bending]` table.
    pub bending: &'a BendingSettings,
}

/// A cutting force and the place where it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ForceAt {
    /// Machine z of the tool, mm.
    pub z_mm: f64,
    /// Components, N.
    pub force: Components,
}

impl HeldShaft<'_> {
    fn thrust(&self) -> f64 {
        if self.bending.tailstock_push { self.thrust_n } else { 0.0 }
    }

    fn spans(&self, gravity: f64) -> Vec<Span> {
        let span = |(d, length_mm): (&f64, &f64)| Span {
            length_mm: *length_mm,
            section: Section::circular(*d, self.material),
            load_n_per_mm: gravity * weight_n_per_mm(*d, self.material),
        };
        self.diameter_mm.iter().zip(&self.element_mm).map(span).collect()
    }

    /// The axis at every node in the machine's frame, mm along x and y: weight, tailstock and, with
    /// a `force`, the tool. `None` where the thrust buckles the shaft.
    pub(crate) fn still_mm(&self, force: Option<&ForceAt>) -> Option<Vec<AxisKnot>> {
        let pull = force.map_or([0.0; 2], |f| self.bending.force_n(&f.force));
        let offset = [self.bending.tailstock_x_um, self.bending.tailstock_y_um];
        let gravity = self.bending.gravity();
        let plane = |axis: usize| {
            let at = force.map(|f| PointForce { z_mm: f.z_mm, force_n: pull[axis] });
            let action = Action {
                forces: at.into_iter().collect(),
                thrust_n: self.thrust(),
                chuck_mm: 0.0,
                tailstock_mm: 1e-3 * offset[axis],
            };
            self.line(gravity[axis], &action)
        };
        Some(self.knots(&plane(0)?, &plane(1)?))
    }

    /// The axis at every node in the body's frame, mm: the chuck's eccentricity, and the thrust on
    /// a `bow`; the bow itself is not in it.
    pub(crate) fn turning_mm(&self, bow: &[AxisKnot]) -> Option<Vec<AxisKnot>> {
        let held = direction(self.bending.chuck_eccentricity_deg);
        let thrust_n = self.thrust();
        let plane = |axis: usize| {
            let offset = |k: &AxisKnot| if axis == 0 { k.x_mm } else { k.y_mm };
            let action = Action {
                forces: thrust_on_bow(bow, offset, thrust_n),
                thrust_n,
                chuck_mm: 1e-3 * self.bending.chuck_eccentricity_um * held[axis],
                tailstock_mm: 0.0,
            };
            self.line(0.0, &action)
        };
        Some(self.knots(&plane(0)?, &plane(1)?))
    }

    fn line(&self, gravity: f64, action: &Action) -> Option<Vec<f64>> {
        let unmoved = action.chuck_mm == 0.0
            && action.tailstock_mm == 0.0
            && gravity == 0.0
            && action.forces.iter().all(|f| f.force_n == 0.0);
        if unmoved {
            return Some(vec![0.0; self.diameter_mm.len() + 1]);
        }
        deflection_line_mm(&self.spans(gravity), self.supports, action)
    }

    fn knots(&self, x: &[f64], y: &[f64]) -> Vec<AxisKnot> {
        let knot = |(&z_mm, (&x_mm, &y_mm)): (&f64, (&f64, &f64))| AxisKnot { z_mm, x_mm, y_mm };
        self.node_z_mm.iter().zip(x.iter().zip(y)).map(knot).collect()
    }
}

/// Axial compression of a bowed bar acts like a load of −P·w₀″ on a straight one; a bow of straight
/// pieces has its curvature at its knots: −P times the change of slope, straight beyond the ends
/// (Timoshenko and Gere, 1.12).
fn thrust_on_bow(bow: &[AxisKnot], offset: impl Fn(&AxisKnot) -> f64, thrust_n: f64) -> Vec<PointForce> {
    if thrust_n == 0.0 || bow.len() < 2 {
        return Vec::new();
    }
    let slopes: Vec<f64> = bow
        .windows(2)
        .map(|k| {
            if k[1].z_mm > k[0].z_mm {
                (offset(&k[1]) - offset(&k[0])) / (k[1].z_mm - k[0].z_mm)
            } else {
                0.0
            }
        })
        .collect();
    let slope = |i: Option<usize>| i.and_then(|i| slopes.get(i)).copied().unwrap_or(0.0);
    bow.iter()
        .enumerate()
        .map(|(i, k)| PointForce {
            z_mm: k.z_mm,
            force_n: -thrust_n * (slope(Some(i)) - slope(i.checked_sub(1))),
        })
        .collect()
}

/// The sum of two lines of an axis at the z values of both; an empty line is straight.
pub(crate) fn sum_of_lines(a: &[AxisKnot], b: &[AxisKnot]) -> Vec<AxisKnot> {
    if a.is_empty() || b.is_empty() {
        return [a, b].concat();
    }
    let mut places: Vec<f64> = a.iter().chain(b).map(|k| k.z_mm).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let sum = |z_mm: f64| {
        let ([ax, ay], [bx, by]) = (axis_at(a, z_mm), axis_at(b, z_mm));
        AxisKnot { z_mm, x_mm: ax + bx, y_mm: ay + by }
    };
    places.into_iter().map(sum).collect()
}

/// A line at z, mm along x and y: linear between its knots, constant beyond; zero without knots.
pub(crate) fn axis_at(knots: &[AxisKnot], z_mm: f64) -> [f64; 2] {
    match neighbours(knots, |k| k.z_mm <= z_mm) {
        (Some(a), Some(b)) => {
            let share = (z_mm - a.z_mm) / (b.z_mm - a.z_mm);
            [a.x_mm + share * (b.x_mm - a.x_mm), a.y_mm + share * (b.y_mm - a.y_mm)]
        }
        (Some(k), None) | (None, Some(k)) => [k.x_mm, k.y_mm],
        (None, None) => [0.0; 2],
    }
}
