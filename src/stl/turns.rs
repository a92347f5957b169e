//! Every vertex to its turn, or the place that is not turned.
//!
//! A vertex belongs to a closed turn, lies on the axis (a pole), or inside of a flat end face. What
//! is left over is not turned: strays of a keyway, a flat, an eccentric journal, a polygon's
//! corners, a turn with a gap.

use glam::DVec3;

use super::axis::{Axis, surface_points};
use super::fault::{FaultKind, ModelFault};
use super::mesh::Mesh;
use super::rings::{FEWEST, GAP_SHARE, Ring, clusters, turned};

/// A turn, or a point on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Along the axis from its point, mm.
    pub(super) z: f64,
    /// From the axis, mm; 0 of a pole.
    pub(super) r: f64,
    /// Number of its vertices.
    pub(super) count: usize,
    /// A vertex of it, in the axes of the model, mm.
    pub(super) at: DVec3,
}

impl Node {
    pub(super) fn is_pole(&self) -> bool {
        self.r == 0.0
    }
}

/// The turns of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    /// Turns and poles.
    pub(super) nodes: Vec<Node>,
    /// The node of every vertex; none inside of a flat face.
    pub(super) of_vertex: Vec<Option<u32>>,
    /// Z of every vertex along the axis from its point, mm.
    pub(super) z_of_vertex: Vec<f64>,
    /// Difference in Z of the vertices of a facet that lies across the axis, mm.
    pub(super) flat_mm: f64,
    /// Largest distance of a vertex from its turn, mm.
    pub(super) scatter_mm: f64,
}

impl Turns {
    /// Takes in a cluster that is a turn or a pole; whether it is one.
    fn takes(&mut self, ring: &Ring, mesh: &Mesh, gap_mm: f64) -> bool {
        let pole = ring.r <= gap_mm;
        if !(pole || ring.is_closed() && ring.scatter <= 2.0 * gap_mm) {
            return false;
        }
        let number = self.nodes.len() as u32;
        ring.members.iter().for_each(|t| self.of_vertex[t.vertex as usize] = Some(number));
        let at = mesh.vertices[ring.members[0].vertex as usize];
        let r = if pole { 0.0 } else { ring.r };
        self.nodes.push(Node { z: ring.z, r, count: ring.members.len(), at });
        self.scatter_mm = self.scatter_mm.max(ring.scatter);
        true
    }

    /// Whether a facet lies across the axis.
    pub(super) fn is_flat(&self, facet: [u32; 3]) -> bool {
        let [a, b, c] = facet.map(|i| self.z_of_vertex[i as usize]);
        a.max(b).max(c) - a.min(b).min(c) <= self.flat_mm
    }
}

/// Largest distance of a chord's middle from its circle, mm: coarse settings of exporters keep to
/// 0.1 or 0.2 mm; flats that stand further off are meant.
const MOST_SAGITTA_MM: f64 = 0.25;
/// Distance by which a normal passes the axis, as a share of the radius, from which the surface is
/// called off the axis: the facets of an eccentric journal stay below it.
const OFF_AXIS_SHARE: f64 = 0.02;
/// Difference in Z of the vertices of one facet across the axis, in units of the largest distance
/// of a vertex from its turn: the first facets of a finely divided fillet beside a face differ by
/// more.
const FLAT_FACTOR: f64 = 4.0;
/// The same of a file without any, as a share of the body's size: a step of single precision.
const LEAST_FLAT_SHARE: f64 = 1.2e-7;
/// Widest gap of the corners of a polygon, in units of the mean one.
const POLYGON_GAP: f64 = 1.5;

/// The turns of a mesh about its axis.
///
/// # Errors
/// The first place, in this order: vertices off every turn, polygons, gaps, chords too long.
pub(super) fn of(mesh: &Mesh, axis: &Axis) -> Result<Turns, ModelFault> {
    let gap_mm = GAP_SHARE * mesh.size_mm;
    let seen = turned(mesh, axis, 0..mesh.vertices.len() as u32);
    let mut turns = Turns {
        nodes: Vec::new(),
        of_vertex: vec![None; mesh.vertices.len()],
        z_of_vertex: seen.iter().map(|t| t.z).collect(),
        flat_mm: 0.0,
        scatter_mm: 0.0,
    };
    let rings = clusters(seen, gap_mm);
    let others: Vec<&Ring> = rings.iter().filter(|ring| !turns.takes(ring, mesh, gap_mm)).collect();
    turns.flat_mm = (FLAT_FACTOR * turns.scatter_mm).max(LEAST_FLAT_SHARE * mesh.size_mm);
    let flat = inside_flats(mesh, &turns);
    let is_flat = |ring: &&Ring| ring.members.iter().all(|t| flat[t.vertex as usize]);
    let others: Vec<&Ring> = others.into_iter().filter(|ring| !is_flat(ring)).collect();
    if let Some(fault) = not_turned(mesh, axis, &others, &flat) {
        return Err(fault);
    }
    match rings.iter().filter(|r| r.is_closed()).find(|r| r.sagitta_mm() > MOST_SAGITTA_MM) {
        Some(ring) => Err(too_long_a_chord(axis, ring)),
        None => Ok(turns),
    }
}

/// Whether all facets about a vertex lie in one plane across the axis.
fn inside_flats(mesh: &Mesh, turns: &Turns) -> Vec<bool> {
    let mut flat = vec![true; mesh.vertices.len()];
    for facet in mesh.facets.iter().filter(|f| !turns.is_flat(**f)) {
        facet.iter().for_each(|i| flat[*i as usize] = false);
    }
    flat
}

/// The place at which the axis sees an angle of a ring, in the axes of the model.
fn place(axis: &Axis, ring: &Ring, angle: f64) -> DVec3 {
    let (e1, e2) = axis.across();
    axis.point + ring.z * axis.direction + ring.r * (angle.cos() * e1 + angle.sin() * e2)
}

fn not_turned(mesh: &Mesh, axis: &Axis, others: &[&Ring], flat: &[bool]) -> Option<ModelFault> {
    if others.is_empty() {
        return None;
    }
    let points = surface_points(mesh);
    let (round, stray): (Vec<&Ring>, Vec<&Ring>) =
        others.iter().partition(|r| r.is_closed() || is_polygon(r));
    let away = |vertex: u32| axis.passed_by(mesh.vertices[vertex as usize], points[vertex as usize].normal);
    let single = stray.iter().filter(|r| r.members.len() < FEWEST).flat_map(|r| &r.members);
    let worst = single
        .filter(|t| !flat[t.vertex as usize])
        .max_by(|a, b| away(a.vertex).total_cmp(&away(b.vertex)).then(b.vertex.cmp(&a.vertex)));
    if let Some(t) = worst {
        let at = mesh.vertices[t.vertex as usize];
        return Some(stray_fault(at, (t.z, t.r), away(t.vertex)));
    }
    if let Some(ring) = stray.iter().max_by(|a, b| a.gap.total_cmp(&b.gap)) {
        let why = format!(
            "the turn of Ø{:.3} mm has no vertex over {:.1}°: a keyway, a flat or a hole, which turning leaves out",
            2.0 * ring.r,
            ring.gap.to_degrees()
        );
        return Some(ModelFault::at(FaultKind::OffAxis, place(axis, ring, ring.gap_at), why));
    }
    let ring = round.iter().max_by(|a, b| a.scatter.total_cmp(&b.scatter))?;
    let at = mesh.vertices[ring.members[0].vertex as usize];
    let n = ring.members.len();
    Some(if n < FEWEST {
        let why = format!(
            "a turn of Ø{:.3} mm has {n} vertices: a polygon of {n} sides, or a mesh too coarse; a turned part needs {FEWEST} or more",
            2.0 * ring.r
        );
        ModelFault::at(FaultKind::FewVertices, at, why)
    } else {
        let why = format!(
            "the vertices of a turn of Ø{:.3} mm scatter by {:.4} mm: eccentric or not round, or the file has too few digits",
            2.0 * ring.r,
            ring.scatter
        );
        ModelFault::at(FaultKind::Scatter, at, why)
    })
}

/// Whether a few vertices stand evenly about the axis.
fn is_polygon(ring: &Ring) -> bool {
    let n = ring.members.len();
    (3..FEWEST).contains(&n) && ring.gap < POLYGON_GAP * std::f64::consts::TAU / n as f64
}

fn stray_fault(at: DVec3, (z, r): (f64, f64), away_mm: f64) -> ModelFault {
    if away_mm > OFF_AXIS_SHARE * r {
        let why = format!(
            "the surface's normal passes the axis by {away_mm:.3} mm: no surface of revolution (a keyway, a flat, a cross \
             hole, a thread); turning makes none, take it out of the model"
        );
        return ModelFault::at(FaultKind::OffAxis, at, why);
    }
    let why = format!(
        "the vertex at Ø{:.4} mm, {z:.3} mm along the axis from its middle, belongs to no turn of {FEWEST} vertices of one \
         radius: eccentric or not round here, or a mesh that does not go round turn by turn",
        2.0 * r
    );
    ModelFault::at(FaultKind::Scatter, at, why)
}

fn too_long_a_chord(axis: &Axis, ring: &Ring) -> ModelFault {
    let why = format!(
        "the chords of a turn of Ø{:.3} mm stand {:.3} mm inside of their circle, {MOST_SAGITTA_MM} mm are taken for the \
         facets of a round part: export the model finer, or it has flats",
        2.0 * ring.r,
        ring.sagitta_mm()
    );
    ModelFault::at(FaultKind::Sagitta, place(axis, ring, ring.gap_at), why)
}
