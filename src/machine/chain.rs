//! The exact kinematic chains: where a tool, a probe or a head stands relative to the part.
//!
//! Every slide is a rigid body with a reference point: an error shifts the body and turns it about
//! that point. Turns compose as R = Rz(c)·Ry(b)·Rx(a); ISO 230-1 leaves the order open, and another
//! one differs by products of two angles times the lever (5 nm at 50 µrad and 2 m). With E the
//! error of a body, T a shift, w the Z slide's lever, t the X slide's, p the point:
//!
//! ```text
//! t_shaped   part   T(ez)·R(Z)·T(w)·O(A0C, B0C)·T(ec)·R(C)
//!            tool   T(w + p − t + x·(d − i) + ex)·R(X)·T(t)
//! carriage   part   O(A0C, B0C)·T(ec)·R(C)
//!            tool   T(p − w + ez)·R(Z)·T(w − t + x·(d − i) + ex)·R(X)·T(t)
//! ```
//!
//! d is the direction of the X slide's motion, i turned by B0X about Y: an orientation turns the
//! motion, not the body. Of the spindle the error motion counts, not the rotation itself, so that
//! the result stands in directions of the machine.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::error_name::{Axis, ErrorName, ErrorValues};
use super::station::Station;
use super::topology::Topology;

/// A displacement and a turn relative to where both should be, in the part's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Displacement of the point, mm.
    pub shift_mm: Vector3<f64>,
    /// Rotation vector: turns about X, Y, Z, rad.
    pub turn_rad: Vector3<f64>,
}

/// A chain with the values of its errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    /// How the slides stand on each other.
    pub topology: Topology,
    /// The errors' values, mm and rad.
    pub values: ErrorValues,
}

/// A frame: where its origin lies and how it is turned.
struct Frame {
    origin: Vector3<f64>,
    rotation: Rotation3<f64>,
}

impl Chain {
    /// The pose of what stands at a station, relative to the part; exact.
    pub(crate) fn pose(&self, station: &Station) -> Pose {
        let (part, tool) = match self.topology {
            Topology::TShaped => self.t_shaped(station),
            Topology::Carriage => self.carriage(station),
        };
        let back = part.rotation.inverse();
        Pose {
            shift_mm: back * (tool.origin - part.origin) - station.point_mm,
            turn_rad: rotation_vector(&(back * tool.rotation)),
        }
    }

    /// Frames of the part and of the point's body, from the Z slide's reference.
    fn t_shaped(&self, station: &Station) -> (Frame, Frame) {
        let (z_shift, z_turn) = self.body(Axis::Z);
        let spindle = self.spindle();
        let part = Frame {
            origin: z_shift + z_turn * (station.z_lever_mm + spindle.origin),
            rotation: z_turn * spindle.rotation,
        };
        let x = self.on_x_slide(station);
        let tool = Frame { origin: station.z_lever_mm + station.point_mm + x.origin, rotation: x.rotation };
        (part, tool)
    }

    /// Frames of the part and of the point's body, from the part's origin.
    fn carriage(&self, station: &Station) -> (Frame, Frame) {
        let (z_shift, z_turn) = self.body(Axis::Z);
        let x = self.on_x_slide(station);
        let tool = Frame {
            origin: station.point_mm - station.z_lever_mm
                + z_shift
                + z_turn * (station.z_lever_mm + x.origin),
            rotation: z_turn * x.rotation,
        };
        (self.spindle(), tool)
    }

    /// Shift and turn of a slide's body.
    fn body(&self, axis: Axis) -> (Vector3<f64>, Rotation3<f64>) {
        (Vector3::from(self.values.along(axis)), turned(self.values.about(axis)))
    }

    /// The spindle's frame, from the part's origin.
    fn spindle(&self) -> Frame {
        let orientation = turned([self.values.of(ErrorName::A0c), self.values.of(ErrorName::B0c), 0.0]);
        let (shift, turn) = self.body(Axis::C);
        Frame { origin: orientation * shift, rotation: orientation * turn }
    }

    /// What the X slide does to a point: its displacement and its turn.
    fn on_x_slide(&self, station: &Station) -> Frame {
        let Some(lever) = station.x_lever_mm else {
            return Frame { origin: Vector3::zeros(), rotation: Rotation3::identity() };
        };
        let (shift, turn) = self.body(Axis::X);
        let (sin, cos) = self.values.of(ErrorName::B0x).sin_cos();
        let along = station.x_mm * Vector3::new(cos - 1.0, 0.0, -sin);
        Frame { origin: along + shift + turn * lever - lever, rotation: turn }
    }
}

/// Rz(c)·Ry(b)·Rx(a), multiplied out.
fn turned(angles: [f64; 3]) -> Rotation3<f64> {
    let [(sa, ca), (sb, cb), (sc, cc)] = angles.map(sin_cos);
    Rotation3::from_matrix_unchecked(Matrix3::new(
        cc * cb,
        cc * sb * sa - sc * ca,
        cc * sb * ca + sc * sa,
        sc * cb,
        sc * sb * sa + cc * ca,
        sc * sb * ca - cc * sa,
        -sb,
        cb * sa,
        cb * ca,
    ))
}

/// Sine and cosine; of the angles of machines by their series, whose next terms stay below 3e-18
/// at 10 mrad: half the time of a map goes into twelve of them a point otherwise.
fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() > 0.01 {
        return angle.sin_cos();
    }
    let square = angle * angle;
    let sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0));
    (sine, 1.0 - 0.5 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0)))
}

/// The rotation vector of a small turn: the skew part of its matrix is sin α/α times the vector.
/// (An arc cosine of the trace would lose angles below 1e-8 rad.)
fn rotation_vector(turn: &Rotation3<f64>) -> Vector3<f64> {
    let m = turn.matrix();
    let skew = 0.5 * Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let sine = skew.norm();
    if sine < 1e-6 { skew } else { skew * (sine.min(1.0).asin() / sine) }
}
