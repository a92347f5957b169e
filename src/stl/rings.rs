//! Vertices that are one turn about the axis: equal Z and equal radius.
//!
//! Vertices of a model of a turned part lie on its surface (the facets between them do not), at
//! equal angles or not, turn by turn. A turn is a cluster in (Z, radius) without gaps wider than a
//! tolerance.

use std::f64::consts::TAU;

use rayon::slice::ParallelSliceMut;

use super::axis::Axis;
use super::mesh::Mesh;

/// Fewest vertices of a turn: a polygon of fewer sides is taken for one that is meant. Twelve
/// chords stand 3.4 % of the radius inside of their circle.
pub(super) const FEWEST: usize = 12;

/// Share of the body's size by which vertices of one turn may differ in Z and radius: the sixth
/// digit of an ASCII file, 0.5 µm on 50 mm; single precision has a hundredth of it.
pub(super) const GAP_SHARE: f64 = 1e-5;

/// A vertex as the axis sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    /// Number of the vertex.
    pub(super) vertex: u32,
    /// Along the axis, mm.
    pub(super) z: f64,
    /// From the axis, mm.
    pub(super) r: f64,
    /// About the axis, rad.
    pub(super) angle: f64,
}

/// A cluster of vertices.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    /// Its vertices by their angle.
    pub(super) members: Vec<Turned>,
    /// Mean Z, mm.
    pub(super) z: f64,
    /// Mean radius, mm.
    pub(super) r: f64,
    /// Largest distance of a vertex from both means, mm.
    pub(super) scatter: f64,
    /// Widest gap between neighbours, rad.
    pub(super) gap: f64,
    /// Angle of the gap's middle, rad.
    pub(super) gap_at: f64,
}

impl Ring {
    fn of(mut members: Vec<Turned>) -> Self {
        members.sort_unstable_by(|a, b| a.angle.total_cmp(&b.angle).then(a.vertex.cmp(&b.vertex)));
        let n = members.len() as f64;
        let z = members.iter().map(|t| t.z).sum::<f64>() / n;
        let r = members.iter().map(|t| t.r).sum::<f64>() / n;
        let scatter = members.iter().map(|t| (t.z - z).abs().max((t.r - r).abs())).fold(0.0, f64::max);
        let mut gap = (0.0, 0.0);
        for (i, t) in members.iter().enumerate() {
            let next = members.get(i + 1).map_or(members[0].angle + TAU, |t| t.angle);
            if next - t.angle > gap.0 {
                gap = (next - t.angle, 0.5 * (next + t.angle));
            }
        }
        Self { members, z, r, scatter, gap: gap.0, gap_at: gap.1 }
    }

    /// Whether its vertices go round without a gap that one of them would be missing in: chords may
    /// differ in length, as where facets of two surfaces share a turn.
    pub(super) fn is_closed(&self) -> bool {
        self.members.len() >= FEWEST && self.gap < 2.0 * TAU / FEWEST as f64
    }

    /// How far the middle of its widest chord lies inside of its circle, mm.
    pub(super) fn sagitta_mm(&self) -> f64 {
        self.r * (1.0 - (0.5 * self.gap).cos())
    }
}

/// Vertices of a mesh as an axis sees them.
pub(super) fn turned(mesh: &Mesh, axis: &Axis, vertices: impl IntoIterator<Item = u32>) -> Vec<Turned> {
    let (e1, e2) = axis.across();
    let of = |vertex: u32| {
        let from = mesh.vertices[vertex as usize] - axis.point;
        let (x, y) = (from.dot(e1), from.dot(e2));
        Turned { vertex, z: from.dot(axis.direction), r: x.hypot(y), angle: y.atan2(x) }
    };
    vertices.into_iter().map(of).collect()
}

/// The clusters of vertices without gaps wider than `gap_mm` in Z or in radius; vertices on the
/// axis make clusters of their own.
pub(super) fn clusters(turned: Vec<Turned>, gap_mm: f64) -> Vec<Ring> {
    let mut open = vec![(turned, true, false)];
    let mut rings = Vec::new();
    while let Some((mut group, along, settled)) = open.pop() {
        let key = |t: &Turned| if along { t.z } else { t.r };
        group.par_sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.vertex.cmp(&b.vertex)));
        let parts: Vec<&[Turned]> = group.chunk_by(|a, b| key(b) - key(a) <= gap_mm).collect();
        if parts.len() > 1 {
            open.extend(parts.into_iter().map(|part| (part.to_vec(), !along, false)));
        } else if settled {
            rings.push(Ring::of(group));
        } else {
            open.push((group, !along, true));
        }
    }
    rings.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.r.total_cmp(&b.r)));
    rings
}
