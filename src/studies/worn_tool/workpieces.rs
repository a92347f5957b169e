//! The four workpieces: outlines, and the size that the paper measures of each.
//!
//! The paper gives the diameter of the fourth and the length behind the cone of the first. Other
//! lengths are ours; errors depend on the angles alone.

use glam::DVec2;
use nalgebra::SVector;
use serde::Serialize;

use super::error::WornToolError;
use crate::gauge::form::least_squares_circle;
use crate::numerics::normal_equations::NormalEquations;
use crate::process::NosePath;
use crate::shaft::ContourPoint;

/// One of the four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Workpiece {
    /// 1: a cone with a cylinder of length 10 behind it, and its shoulder.
    LengthBehindCone,
    /// 2: a cone that ends at its large diameter.
    LargeDiameter,
    /// 3: a convex arc between a cylinder and a face.
    ArcRadius,
    /// 4: a cylinder of a batch, cut in the offsets of the new insert.
    BatchDiameter,
}

/// What the paper's edit changes in the drawing, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Edit {
    /// Cones are moved towards the chuck.
    pub(super) cone_dz: f64,
    /// Arcs are made larger.
    pub(super) arc: f64,
    /// Cylinders are made smaller on the radius.
    pub(super) cylinder_dx: f64,
}

/// Diameters of the shoulder behind, the large and the small end, mm; the batch has the large one.
pub(super) const SHOULDER_MM: f64 = 40.0;
pub(super) const LARGE_MM: f64 = 30.0;
pub(super) const SMALL_MM: f64 = 20.0;
/// Length of the cylinder behind the cone and Z of its shoulder, mm.
pub(super) const BEHIND_MM: f64 = 10.0;
pub(super) const SHOULDER_Z_MM: f64 = 10.0;
/// Radius of the arc, which the paper does not give, Z of its face and the face's inner diameter,
/// mm.
pub(super) const ARC_MM: f64 = 5.0;
pub(super) const FACE_Z_MM: f64 = 20.0;
const INNER_MM: f64 = 10.0;
/// Length of other cylinders, mm.
const CYLINDER_MM: f64 = 8.0;
/// Places of a line or an arc.
const PLACES: usize = 81;

impl Workpiece {
    /// All of them, as the paper counts.
    pub(crate) const ALL: [Self; 4] =
        [Self::LengthBehindCone, Self::LargeDiameter, Self::ArcRadius, Self::BatchDiameter];

    /// Its number in the paper.
    pub(crate) fn number(self) -> usize {
        1 + self as usize
    }

    /// What is measured of it.
    pub(crate) fn size(self) -> &'static str {
        match self {
            Self::LengthBehindCone => "length of the cylinder behind the cone",
            Self::LargeDiameter => "large diameter of the cone",
            Self::ArcRadius => "radius of the arc",
            Self::BatchDiameter => "diameter of the cylinder, in a batch",
        }
    }

    /// Half angle of its cone, rad; 0 without one.
    pub(super) fn cone_rad(self, cone_deg: [f64; 2]) -> f64 {
        match self {
            Self::LengthBehindCone => cone_deg[0].to_radians(),
            Self::LargeDiameter => cone_deg[1].to_radians(),
            Self::ArcRadius | Self::BatchDiameter => 0.0,
        }
    }

    /// Its corners, from the chuck.
    pub(super) fn corners(self, cone_rad: f64, edit: &Edit) -> Vec<ContourPoint> {
        let corner =
            |z_mm: f64, diameter_mm: f64| ContourPoint { z_mm, diameter_mm, chamfer_mm: 0.0, radius_mm: 0.0 };
        let length = 0.5 * (LARGE_MM - SMALL_MM) / cone_rad.tan();
        match self {
            Self::LengthBehindCone => {
                let from = SHOULDER_Z_MM + BEHIND_MM - edit.cone_dz;
                vec![
                    corner(0.0, SHOULDER_MM),
                    corner(SHOULDER_Z_MM, SHOULDER_MM),
                    corner(SHOULDER_Z_MM, LARGE_MM),
                    corner(from, LARGE_MM),
                    corner(from + length, SMALL_MM),
                    corner(from + length + CYLINDER_MM, SMALL_MM),
                ]
            }
            Self::LargeDiameter => {
                // the line still begins at Z 0
                let large = LARGE_MM - 2.0 * edit.cone_dz * cone_rad.tan();
                let to = length - edit.cone_dz;
                vec![corner(0.0, large), corner(to, SMALL_MM), corner(to + CYLINDER_MM, SMALL_MM)]
            }
            Self::ArcRadius => vec![
                corner(0.0, LARGE_MM),
                ContourPoint { radius_mm: ARC_MM + edit.arc, ..corner(FACE_Z_MM, LARGE_MM) },
                corner(FACE_Z_MM, INNER_MM),
                corner(FACE_Z_MM + CYLINDER_MM, INNER_MM),
            ],
            Self::BatchDiameter => {
                let d = LARGE_MM - 2.0 * edit.cylinder_dx;
                vec![corner(0.0, d), corner(BATCH_LENGTH_MM, d)]
            }
        }
    }

    /// The error of its size on the surface that a nose left, µm.
    pub(super) fn error_um(self, path: &NosePath, cone_rad: f64) -> Result<f64, WornToolError> {
        let none = |what| WornToolError::Surface { workpiece: self.number(), what };
        let length = 0.5 * (LARGE_MM - SMALL_MM) / cone_rad.tan();
        // a tenth of the cone off both ends: beyond the fillet of the largest nose
        let cone = |from: f64| line(path, from + 0.1 * length, from + 0.8 * length);
        match self {
            Self::LengthBehindCone => {
                let from = SHOULDER_Z_MM + BEHIND_MM;
                let cone = cone(from).ok_or(none("no cone"))?;
                let cylinder = line(path, from - 5.0, from - 1.0).ok_or(none("no cylinder"))?;
                let shoulder = shoulder_z(path).ok_or(none("no shoulder"))?;
                let corner = (cylinder.0 - cone.0) / (cone.1 - cylinder.1);
                Ok(1e3 * (corner - shoulder - BEHIND_MM))
            }
            Self::LargeDiameter => {
                let cone = cone(0.0).ok_or(none("no cone"))?;
                Ok(1e3 * (2.0 * cone.0 - LARGE_MM))
            }
            Self::ArcRadius => arc_error_um(path).ok_or(none("no arc")),
            Self::BatchDiameter => {
                let radius = path.radius_mm(0.5 * BATCH_LENGTH_MM).ok_or(none("no cylinder"))?;
                Ok(1e3 * (2.0 * radius - LARGE_MM))
            }
        }
    }
}

/// Length of the fourth, mm.
pub(super) const BATCH_LENGTH_MM: f64 = 12.0;

/// Radius at Z 0 and slope of the least-squares line between two Z.
fn line(path: &NosePath, from: f64, to: f64) -> Option<(f64, f64)> {
    let mut sums = NormalEquations::<2>::new();
    for k in 0..PLACES {
        let z = from + (to - from) * k as f64 / (PLACES - 1) as f64;
        sums.add(SVector::from([1.0, z]), path.radius_mm(z)?, 1.0);
    }
    sums.by_inverse().map(|v| (v[0], v[1]))
}

/// Z at which the surface passes half of the shoulder's height, mm.
fn shoulder_z(path: &NosePath) -> Option<f64> {
    let half = 0.25 * (SHOULDER_MM + LARGE_MM);
    let (mut behind, mut before) = (SHOULDER_Z_MM - 0.5, SHOULDER_Z_MM + 0.5);
    if path.radius_mm(behind)? <= half || path.radius_mm(before)? >= half {
        return None;
    }
    // halved to 1e-12 mm
    for _ in 0..40 {
        let middle = 0.5 * (behind + before);
        if path.radius_mm(middle)? > half { behind = middle } else { before = middle }
    }
    Some(0.5 * (behind + before))
}

/// Error of the radius of the least-squares circle through the arc's surface from 3° to 87°, µm.
fn arc_error_um(path: &NosePath) -> Option<f64> {
    let centre = FACE_Z_MM - ARC_MM;
    let place = |k: usize| {
        let a = (3.0 + 84.0 * k as f64 / (PLACES - 1) as f64).to_radians();
        let z = centre + ARC_MM * a.sin();
        path.radius_mm(z).map(|x| DVec2::new(x, z))
    };
    let points: Option<Vec<DVec2>> = (0..PLACES).map(place).collect();
    let fit = least_squares_circle(&points?).ok()?.fit;
    Some(1e3 * (fit.circle.radius - ARC_MM))
}
