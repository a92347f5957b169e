//! Triangles to a mesh: corners that are one point are welded.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;

use super::fault::{FaultKind, ModelFault};

/// Corners closer than this share of the body's size are one: sixteen steps of the file's single
/// precision at its largest coordinate, 0.05 µm on 50 mm.
const WELD_SHARE: f64 = 1e-6;
/// A direction along which no two vertices of a regular mesh fall together.
const ALONG: DVec3 = DVec3::new(0.470_9, 0.811_7, 0.345_3);

/// A mesh.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    /// Its vertices, mm.
    pub(super) vertices: Vec<DVec3>,
    /// Its facets: numbers of three vertices, anticlockwise from outside.
    pub(super) facets: Vec<[u32; 3]>,
    /// Largest extent along an axis of the file, mm.
    pub(super) size_mm: f64,
}

impl Mesh {
    /// The corners of triangles welded; triangles that shrink to a line are left out.
    ///
    /// # Errors
    /// No triangle with an area.
    pub(super) fn welded(triangles: &[[DVec3; 3]]) -> Result<Self, ModelFault> {
        let corners = triangles.as_flattened();
        let (low, high) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(*c), h.max(*c)));
        let size_mm = if corners.is_empty() { 0.0 } else { (high - low).max_element() };
        let (vertices, number) = weld(corners, WELD_SHARE * size_mm);
        let facets: Vec<[u32; 3]> = number
            .chunks_exact(3)
            .map(|f| [f[0], f[1], f[2]])
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if facets.is_empty() || size_mm <= 0.0 {
            let why = format!("{} facets, none with an area: a closed body is needed", triangles.len());
            return Err(ModelFault::whole(FaultKind::Empty, why));
        }
        Ok(Self { vertices, facets, size_mm })
    }

    /// Corners of a facet, mm.
    pub(super) fn corners(&self, facet: [u32; 3]) -> [DVec3; 3] {
        facet.map(|i| self.vertices[i as usize])
    }

    /// Twice the area of a facet along its outward normal, mm².
    pub(super) fn double_area(&self, facet: [u32; 3]) -> DVec3 {
        let [a, b, c] = self.corners(facet);
        (b - a).cross(c - a)
    }

    /// Its enclosed volume, mm³; below 0 where all facets look inwards.
    pub(super) fn volume_mm3(&self) -> f64 {
        let from = self.vertices[0];
        let of = |facet: &[u32; 3]| {
            let [a, b, c] = self.corners(*facet);
            (a - from).dot((b - from).cross(c - from)) / 6.0
        };
        self.facets.iter().map(of).sum()
    }

    /// All facets looked at from the other side.
    pub(super) fn turn_inside_out(&mut self) {
        self.facets.iter_mut().for_each(|facet| facet.swap(1, 2));
    }
}

/// The points that differ by more than `tolerance`, and for every corner the number of its point:
/// corners in the order of their projection, each compared with those just before it.
fn weld(corners: &[DVec3], tolerance: f64) -> (Vec<DVec3>, Vec<u32>) {
    let mut order: Vec<(f64, u32)> = corners.iter().map(|c| c.dot(ALONG)).zip(0..).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut points: Vec<DVec3> = Vec::with_capacity(corners.len() / 5);
    let mut number = vec![0; corners.len()];
    for (along, corner) in order {
        let at = corners[corner as usize];
        let near = points.iter().enumerate().rev();
        // the projection of a unit vector shortens: nothing further back can be as close
        let mut near = near.take_while(|(_, p)| along - p.dot(ALONG) <= tolerance);
        let found = near.find(|(_, p)| p.distance_squared(at) <= tolerance * tolerance).map(|(i, _)| i);
        number[corner as usize] = found.unwrap_or(points.len()) as u32;
        if found.is_none() {
            points.push(at);
        }
    }
    (points, number)
}
