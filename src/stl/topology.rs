//! Whether a mesh bounds one body: every edge belongs to two facets that pass it in opposite
//! directions, and all facets hang together.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;

use super::fault::{FaultKind, ModelFault};
use super::mesh::Mesh;

/// An edge of a facet: its vertices in rising order, whether the facet passes it so, the facet.
type Edge = (u32, u32, bool, u32);

/// Refuses a mesh that bounds no single body; facets that all look inwards are turned.
///
/// # Errors
/// The middle of an edge that is open, that several facets share or at which the outside changes
/// sides; a facet of the smaller of two bodies.
pub(super) fn checked(mesh: &mut Mesh) -> Result<(), ModelFault> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * mesh.facets.len());
    for (facet, [a, b, c]) in mesh.facets.iter().zip(0..).map(|(f, i)| (i, *f)) {
        edges.extend([(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q), p < q, facet)));
    }
    edges.par_sort_unstable();
    let mut shells = Shells::new(mesh.facets.len());
    let mut first: Option<(FaultKind, &[Edge])> = None;
    for shared in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match shared {
            [a, b] if a.2 != b.2 => shells.join(a.3, b.3),
            // an open edge explains what stands beside it
            [_] if first.is_none_or(|(kind, _)| kind != FaultKind::Open) => {
                first = Some((FaultKind::Open, shared));
            }
            [a, b] if first.is_none() && a.2 == b.2 => first = Some((FaultKind::Orientation, shared)),
            [_, _, _, ..] if first.is_none() => first = Some((FaultKind::NonManifold, shared)),
            _ => {}
        }
    }
    if let Some((kind, shared)) = first {
        return Err(at_edge(mesh, kind, shared));
    }
    one_body(mesh, &mut shells)?;
    if mesh.volume_mm3() < 0.0 {
        mesh.turn_inside_out();
    }
    Ok(())
}

fn at_edge(mesh: &Mesh, kind: FaultKind, shared: &[Edge]) -> ModelFault {
    let (a, b) = (mesh.vertices[shared[0].0 as usize], mesh.vertices[shared[0].1 as usize]);
    let why = match kind {
        FaultKind::Open => "the surface is open at an edge: a closed body is needed; repair the model and export it again".to_owned(),
        FaultKind::Orientation => {
            "the outside of two neighbouring facets lies on opposite sides: one of them is turned; export the model again".to_owned()
        }
        _ => format!("{} facets share one edge, a body has two: surfaces that touch or lie in one another; unite them", shared.len()),
    };
    ModelFault::at(kind, 0.5 * (a + b), why)
}

fn one_body(mesh: &Mesh, shells: &mut Shells) -> Result<(), ModelFault> {
    let mut facets = vec![0_usize; mesh.facets.len()];
    (0..mesh.facets.len() as u32).for_each(|f| facets[shells.root(f) as usize] += 1);
    let mut sizes: Vec<(usize, usize)> =
        facets.iter().enumerate().filter(|(_, n)| **n > 0).map(|(i, n)| (*n, i)).collect();
    sizes.sort_unstable();
    let [(least, smallest), _, ..] = sizes[..] else { return Ok(()) };
    let corners = mesh.corners(mesh.facets[smallest]);
    let at = corners.iter().sum::<DVec3>() / 3.0;
    let why = format!(
        "{} bodies or cavities that do not hang together, this one of {least} facets: save one solid without cavities",
        sizes.len()
    );
    Err(ModelFault::at(FaultKind::SeveralBodies, at, why))
}

/// Facets that hang together, as a forest with halved paths.
struct Shells {
    parent: Vec<u32>,
}

impl Shells {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
