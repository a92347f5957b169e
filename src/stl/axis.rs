//! The axis of a surface of revolution from its normals.
//!
//! All normals of a surface of revolution meet its axis. With the Plücker coordinates (n, p × n) of
//! the normal n at the point p (from a middle of the body), a line along the unit vector d with the
//! moment m meets it where
//!
//! (p × n)·d + n·m = 0,
//!
//! the normals' linear complex (Pottmann, Randrup, Rotational and helical surface approximation for
//! reverse engineering, Computing 60, 1998). The sum of the squares is least, over m and with |d| =
//! 1, for the least eigenvector d of S = A − B·C⁻¹·Bᵀ, where A, B, C are the blocks of the sum of
//! the coordinates' products; then m = −C⁻¹·Bᵀ·d, and the axis passes d × m.
//!
//! Normals of what is not turned (a keyway, an eccentric journal) count less the further they pass
//! the axis: weights of Geman and McClure, whose scale shrinks from the body's size.

use glam::DVec3;
use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen};

use super::fault::{FaultKind, ModelFault};
use super::mesh::Mesh;

/// A straight line through the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// A point of it, mm.
    pub point: DVec3,
    /// Its direction, a unit vector.
    pub direction: DVec3,
}

/// A vertex with the normal of the surface there and the area that it stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    /// The vertex, mm.
    pub(super) at: DVec3,
    /// Unit normal: the facets' normals weighted by their angles at the vertex.
    pub(super) normal: DVec3,
    /// A third of the area of the facets about it, mm².
    pub(super) area_mm2: f64,
}

/// Most vertices that the first axis is found from: it begins the fit to the turns alone.
const MOST_POINTS: usize = 20_000;
/// Steps of the scale, each by this factor: from half of the body's size down to a 1000th.
const STEPS: usize = 24;
const SHRINK: f64 = 0.76;
/// Share of the two larger eigenvalues' sum below which the second shows that another axis fits as
/// well: normals of a ball all meet in one point.
const ANOTHER_AXIS: f64 = 1e-7;

impl Axis {
    /// How far a line passes the axis, mm.
    pub(super) fn passed_by(&self, at: DVec3, along: DVec3) -> f64 {
        let across = self.direction.cross(along);
        let sine = across.length();
        if sine < 1e-9 { 0.0 } else { (at - self.point).dot(across).abs() / sine }
    }

    /// Two unit vectors at right angles to it and to each other.
    pub(super) fn across(&self) -> (DVec3, DVec3) {
        self.direction.any_orthonormal_pair()
    }

    /// (Z along it from its point, distance from it), mm.
    pub(super) fn meridian(&self, at: DVec3) -> (f64, f64) {
        let from = at - self.point;
        let z = from.dot(self.direction);
        (z, (from - z * self.direction).length())
    }
}

/// Every so many of the vertices, by their numbers, that the first axis is found from.
fn step(mesh: &Mesh) -> usize {
    mesh.vertices.len().div_ceil(MOST_POINTS).max(1)
}

/// All vertices with their normals.
pub(super) fn surface_points(mesh: &Mesh) -> Vec<SurfacePoint> {
    points_of_every(mesh, 1)
}

/// All vertices, every `step` of them with its normal.
fn points_of_every(mesh: &Mesh, step: usize) -> Vec<SurfacePoint> {
    let none = |at: &DVec3| SurfacePoint { at: *at, normal: DVec3::ZERO, area_mm2: 0.0 };
    let mut points: Vec<SurfacePoint> = mesh.vertices.iter().map(none).collect();
    let is_chosen = |i: u32| (i as usize).is_multiple_of(step);
    for &facet in mesh.facets.iter().filter(|f| f.iter().any(|i| is_chosen(*i))) {
        let double = mesh.double_area(facet);
        let (corners, normal) = (mesh.corners(facet), double.normalize_or_zero());
        for k in 0..3 {
            let (to, fro) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            let point = &mut points[facet[k] as usize];
            point.normal += normal * to.cross(fro).length().atan2(to.dot(fro));
            point.area_mm2 += double.length() / 6.0;
        }
    }
    points.iter_mut().for_each(|p| p.normal = p.normal.normalize_or_zero());
    points
}

/// The axis that most of the surface turns about.
///
/// # Errors
/// A body that several axes fit.
pub(super) fn of_normals(mesh: &Mesh) -> Result<Axis, ModelFault> {
    let (size_mm, step) = (mesh.size_mm, step(mesh));
    let chosen: Vec<SurfacePoint> = points_of_every(mesh, step).into_iter().step_by(step).collect();
    let area: f64 = chosen.iter().map(|p| p.area_mm2).sum();
    let middle = chosen.iter().map(|p| p.at * p.area_mm2).sum::<DVec3>() / area;
    let weight = |_: &SurfacePoint| 1.0;
    let (mut axis, _) = least(&chosen, middle, &weight)?;
    let mut scale = 0.5 * size_mm;
    let mut second = 0.0;
    for _ in 0..STEPS {
        scale *= SHRINK;
        let weight = |p: &SurfacePoint| {
            let away = axis.passed_by(p.at, p.normal) / scale;
            (1.0 + away * away).powi(-2)
        };
        (axis, second) = least(&chosen, middle, &weight)?;
    }
    if second < ANOTHER_AXIS {
        let why = "the normals fit several axes, as those of a ball do: a turned part has one axis";
        return Err(ModelFault::at(FaultKind::NoAxis, axis.point, why));
    }
    Ok(axis)
}

/// The axis of least squares, and the second eigenvalue as a share of the sum of both others.
fn least(
    points: &[SurfacePoint],
    middle: DVec3,
    weight: &dyn Fn(&SurfacePoint) -> f64,
) -> Result<(Axis, f64), ModelFault> {
    let mut sum = SMatrix::<f64, 6, 6>::zeros();
    for p in points {
        let moment = (p.at - middle).cross(p.normal);
        let row = SVector::<f64, 6>::from([moment.x, moment.y, moment.z, p.normal.x, p.normal.y, p.normal.z]);
        sum += row * row.transpose() * (p.area_mm2 * weight(p));
    }
    let block = |i: usize, j: usize| -> Matrix3<f64> { sum.fixed_view::<3, 3>(i, j).into_owned() };
    let (a, b, c) = (block(0, 0), block(0, 3), block(3, 3));
    let none =
        || ModelFault::at(FaultKind::NoAxis, middle, "the facets lie in one plane: a closed body is needed");
    let inverse = c.try_inverse().ok_or_else(none)?;
    let eigen = SymmetricEigen::new(a - b * inverse * b.transpose());
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
    let vector = |v: nalgebra::Vector3<f64>| DVec3::new(v[0], v[1], v[2]);
    let d: nalgebra::Vector3<f64> = eigen.eigenvectors.column(order[0]).into_owned();
    let m = -(inverse * b.transpose() * d);
    let direction = vector(d).try_normalize().ok_or_else(none)?;
    let share = eigen.eigenvalues[order[1]] / a.trace().max(f64::MIN_POSITIVE);
    Ok((Axis { point: middle + direction.cross(vector(m)), direction }, share))
}
