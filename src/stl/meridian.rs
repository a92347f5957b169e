//! Turns in their order along the surface: the profile in the plane of the axis.
//!
//! A facet that is not flat across the axis spans two turns; all facets of two turns go round once,
//! so that as many of them have two vertices on a turn as it has vertices. A flat face goes from an
//! outer turn to the next one inside of it, or to the axis. So every turn has two neighbours, and
//! the profile is a chain from the axis to the axis, or a loop where the part has a bore.

use std::collections::BTreeMap;

use glam::DVec3;

use super::axis::Axis;
use super::fault::{FaultKind, ModelFault};
use super::mesh::Mesh;
use super::turns::{Node, Turns};

/// A profile.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    /// Its nodes in order, Z of the first below that of the last; of a loop the first is not
    /// repeated.
    pub(super) nodes: Vec<Node>,
    /// Whether it closes without touching the axis.
    pub(super) is_loop: bool,
}

/// Pairs of nodes with the number of facets on either.
type Strips = BTreeMap<(u32, u32), (usize, usize)>;

/// The profile of a mesh of turns.
///
/// # Errors
/// The place where facets span other than two turns or do not go round, where surfaces meet in
/// more than one profile, or where the profile crosses itself.
pub(super) fn profile(mesh: &Mesh, axis: &Axis, turns: &Turns) -> Result<Profile, ModelFault> {
    let mut links = strips(mesh, turns)?;
    links.extend(flats(mesh, axis, turns)?);
    let chain = chained(turns, &links)?;
    let profile = oriented(turns, &chain);
    crossing(&profile)?;
    Ok(profile)
}

fn middle(mesh: &Mesh, facet: [u32; 3]) -> DVec3 {
    mesh.corners(facet).iter().sum::<DVec3>() / 3.0
}

/// The pairs of turns that facets span.
fn strips(mesh: &Mesh, turns: &Turns) -> Result<Vec<(u32, u32)>, ModelFault> {
    let mut strips = Strips::new();
    for &facet in &mesh.facets {
        if turns.is_flat(facet) {
            continue;
        }
        let off = || {
            let why = "a facet does not run from one turn to the next: no surface of revolution here";
            ModelFault::at(FaultKind::OffAxis, middle(mesh, facet), why)
        };
        let [Some(a), Some(b), Some(c)] = facet.map(|i| turns.of_vertex[i as usize]) else {
            return Err(off());
        };
        let (twice, once) = match (a == b, b == c, c == a) {
            (true, false, false) => (a, c),
            (false, true, false) => (b, a),
            (false, false, true) => (c, b),
            _ => return Err(off()),
        };
        let strip = strips.entry((twice.min(once), twice.max(once))).or_default();
        if twice < once { strip.0 += 1 } else { strip.1 += 1 }
    }
    for ((a, b), (on_a, on_b)) in &strips {
        for (node, count) in [(a, on_a), (b, on_b)] {
            let node = &turns.nodes[*node as usize];
            if !node.is_pole() && *count != node.count {
                let why = format!(
                    "{count} facets begin on a turn of {} vertices of Ø{:.3} mm: the surface does not go round",
                    node.count,
                    2.0 * node.r
                );
                return Err(ModelFault::at(FaultKind::OffAxis, node.at, why));
            }
        }
    }
    Ok(strips.into_keys().collect())
}

/// The pairs of turns that bound flat faces; the axis is a node of its own that is made here: a
/// pair of a turn with itself.
fn flats(mesh: &Mesh, axis: &Axis, turns: &Turns) -> Result<Vec<(u32, u32)>, ModelFault> {
    let mut flat: Vec<(f64, [u32; 3])> = mesh
        .facets
        .iter()
        .filter(|f| turns.is_flat(**f))
        .map(|f| (turns.z_of_vertex[f[0] as usize], *f))
        .collect();
    flat.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut planes: Vec<Vec<[u32; 3]>> = Vec::new();
    for plane in flat.chunk_by(|a, b| b.0 - a.0 <= turns.flat_mm) {
        let up = |f: &[u32; 3]| mesh.double_area(*f).dot(axis.direction) > 0.0;
        let facets = plane.iter().map(|(_, f)| *f);
        let (high, low): (Vec<[u32; 3]>, Vec<[u32; 3]>) = facets.partition(up);
        planes.extend([high, low].into_iter().filter(|p| !p.is_empty()));
    }
    let mut links = Vec::new();
    for facets in &planes {
        let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        for [a, b, c] in facets {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *edges.entry((*p.min(q), *p.max(q))).or_default() += 1;
            }
        }
        let mut bounds: BTreeMap<u32, usize> = BTreeMap::new();
        for (p, q) in edges.iter().filter(|(_, n)| **n == 1).map(|(edge, _)| edge) {
            let of = |i: &u32| turns.of_vertex[*i as usize];
            match (of(p), of(q)) {
                (Some(a), Some(b)) if a == b => *bounds.entry(a).or_default() += 1,
                _ => {
                    let at = 0.5 * (mesh.vertices[*p as usize] + mesh.vertices[*q as usize]);
                    let why =
                        "the edge of a flat face does not run along a turn: no surface of revolution here";
                    return Err(ModelFault::at(FaultKind::OffAxis, at, why));
                }
            }
        }
        let mut rims: Vec<u32> = bounds.into_keys().collect();
        rims.sort_by(|a, b| turns.nodes[*b as usize].r.total_cmp(&turns.nodes[*a as usize].r));
        links.extend(rims.chunks(2).map(|pair| (pair[0], *pair.get(1).unwrap_or(&pair[0]))));
    }
    Ok(links)
}

/// The nodes one after the other; a pair of a turn with itself ends on the axis.
fn chained(turns: &Turns, links: &[(u32, u32)]) -> Result<Vec<Option<u32>>, ModelFault> {
    let mut next: Vec<Vec<Option<u32>>> = vec![Vec::new(); turns.nodes.len()];
    for &(a, b) in links {
        if a == b {
            next[a as usize].push(None);
        } else {
            next[a as usize].push(Some(b));
            next[b as usize].push(Some(a));
        }
    }
    for (node, neighbours) in turns.nodes.iter().zip(&next) {
        // a turn inside of a flat face, and the middle of one, bound nothing
        let right = if node.is_pole() { 1 } else { 2 };
        if !neighbours.is_empty() && neighbours.len() != right {
            let why = format!(
                "{} surfaces meet in a turn of Ø{:.3} mm, a profile has two: surfaces touch or cross here",
                neighbours.len(),
                2.0 * node.r
            );
            return Err(ModelFault::at(FaultKind::SelfCrossing, node.at, why));
        }
    }
    let start = next
        .iter()
        .position(|n| n.contains(&None))
        .or_else(|| turns.nodes.iter().zip(&next).position(|(node, n)| node.is_pole() && !n.is_empty()));
    Ok(walked(&next, start))
}

/// From an end on the axis, or round a loop, to the other end; `None` is the axis.
fn walked(next: &[Vec<Option<u32>>], start: Option<usize>) -> Vec<Option<u32>> {
    let first = start.or_else(|| next.iter().position(|n| n.len() == 2));
    let Some(first) = first else { return Vec::new() };
    let mut chain = Vec::new();
    let mut before = None;
    if next[first].contains(&None) {
        chain.push(None);
    } else {
        before = next[first].get(1).copied().flatten();
    }
    let mut now = Some(first as u32);
    while let Some(node) = now {
        if chain.first() == Some(&Some(node)) {
            break;
        }
        chain.push(Some(node));
        let neighbours = &next[node as usize];
        let onward = if neighbours.first() == Some(&before) { neighbours.get(1) } else { neighbours.first() };
        let Some(onward) = onward.copied() else { break };
        before = now;
        now = onward;
        if now.is_none() {
            chain.push(None);
        }
    }
    chain
}

/// The chain from the low to the high end, poles in place of its ends on the axis.
fn oriented(turns: &Turns, chain: &[Option<u32>]) -> Profile {
    let node = |i: &Option<u32>| i.map(|i| turns.nodes[i as usize]);
    let mut nodes: Vec<Node> = chain.iter().filter_map(node).collect();
    let on_axis = |n: &Node| Node { r: 0.0, count: 1, ..*n };
    if chain.first() == Some(&None) {
        nodes.insert(0, on_axis(&nodes[0]));
    }
    if chain.len() > 1 && chain.last() == Some(&None) {
        nodes.push(on_axis(&nodes[nodes.len() - 1]));
    }
    let is_loop = !nodes.first().is_some_and(Node::is_pole);
    if nodes.last().zip(nodes.first()).is_some_and(|(last, first)| last.z < first.z) {
        nodes.reverse();
    }
    Profile { nodes, is_loop }
}

/// Refuses a profile of which two lines cross.
fn crossing(profile: &Profile) -> Result<(), ModelFault> {
    let n = profile.nodes.len();
    let count = if profile.is_loop { n } else { n.saturating_sub(1) };
    let line = |i: usize| (&profile.nodes[i], &profile.nodes[(i + 1) % n]);
    // lines by their least Z: only those that overlap in Z are compared
    let mut order: Vec<usize> = (0..count).collect();
    let span = |i: usize| {
        let (a, b) = line(i);
        (a.z.min(b.z), a.z.max(b.z))
    };
    order.sort_by(|i, j| span(*i).0.total_cmp(&span(*j).0));
    for (k, &i) in order.iter().enumerate() {
        for &j in order[k + 1..].iter().take_while(|j| span(**j).0 <= span(i).1) {
            let (a, b) = (i.min(j), i.max(j));
            let next_to = b - a <= 1 || profile.is_loop && b - a == count - 1;
            if !next_to && cross(line(i), line(j)) {
                let why =
                    "the profile crosses itself: surfaces run through one another; unite them in the model";
                return Err(ModelFault::at(FaultKind::SelfCrossing, line(j).0.at, why));
            }
        }
    }
    Ok(())
}

fn cross((a, b): (&Node, &Node), (c, d): (&Node, &Node)) -> bool {
    let side = |p: &Node, q: &Node, x: &Node| (q.z - p.z) * (x.r - p.r) - (q.r - p.r) * (x.z - p.z);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
