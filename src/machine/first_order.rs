//! The first order of the chains: what one unit of each error does, on its own.
//!
//! A body that shifts by δ and turns by ω about its reference displaces a point at the lever r by
//! δ + ω × r. What carries the tool counts as it is, what carries the part with the sign reversed.
//! The neglected terms are products of two angles times a lever.

use nalgebra::Vector3;

use super::chain::Pose;
use super::error_name::{Axis, Component, ErrorName, ErrorValues};
use super::station::Station;
use super::topology::Topology;

/// The pose of a station for one unit of an error: mm/mm and rad/mm of a shift, mm/rad and rad/rad
/// of a turn.
pub(crate) fn contribution(topology: Topology, station: &Station, name: ErrorName) -> Pose {
    let none = Pose { shift_mm: Vector3::zeros(), turn_rad: Vector3::zeros() };
    if name == ErrorName::B0x {
        let along = station.x_lever_mm.map_or(0.0, |_| -station.x_mm);
        return Pose { shift_mm: Vector3::new(0.0, 0.0, along), ..none };
    }
    let (sign, lever) = match (name.axis(), topology) {
        (Axis::X, _) => match station.x_lever_mm {
            Some(lever) => (1.0, lever),
            None => return none,
        },
        (Axis::Z, Topology::TShaped) => (-1.0, station.z_lever_mm + station.point_mm),
        (Axis::Z, Topology::Carriage) => (1.0, station.z_lever_mm),
        (Axis::C, _) => (-1.0, station.point_mm),
    };
    match name.component() {
        Component::Along(k) => Pose { shift_mm: sign * unit(k), ..none },
        Component::About(k) | Component::Orientation(k) => {
            Pose { shift_mm: sign * unit(k).cross(&lever), turn_rad: sign * unit(k) }
        }
    }
}

/// The pose of a station to first order.
pub(crate) fn pose(topology: Topology, station: &Station, values: &ErrorValues) -> Pose {
    let mut sum = Pose { shift_mm: Vector3::zeros(), turn_rad: Vector3::zeros() };
    for name in ErrorName::ALL {
        let one = contribution(topology, station, name);
        sum.shift_mm += values.of(name) * one.shift_mm;
        sum.turn_rad += values.of(name) * one.turn_rad;
    }
    sum
}

fn unit(k: usize) -> Vector3<f64> {
    Vector3::ith(k, 1.0)
}
