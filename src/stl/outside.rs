//! The outside of a profile: what turning from a bar can cut.
//!
//! From the least to the largest Z along the outside. What the profile does beyond them is a bore
//! or a recess in an end face: it is left out, and the end face goes on to the axis.

use glam::DVec2;

use super::meridian::Profile;
use super::turns::Node;

/// A bore or a recess in an end face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Recess {
    /// Z of the end face, mm from the end at the chuck.
    pub z_mm: f64,
    /// Its diameter in the end face, mm.
    pub diameter_mm: f64,
    /// Its depth, mm; the part's length of a through bore.
    pub depth_mm: f64,
}

/// The outside in the direction of an outline.
#[derive(Clone, Debug)]
pub(super) struct Outside {
    /// Points (X, Z), X the radius, Z from the end at the chuck, mm.
    pub(super) points: Vec<DVec2>,
    /// Bores and recesses.
    pub(super) recesses: Vec<Recess>,
    /// Z along the model's axis of the end at the chuck, mm.
    pub(super) zero_z: f64,
    /// Whether Z runs against the model's axis.
    pub(super) is_turned_round: bool,
}

/// Distance in Z of turns that lie in one end face, mm: a tenth of a control's increment.
const SAME_MM: f64 = 1e-4;

/// Share of the length by which the middle of the material must lie beyond that of the part for its
/// half to count as the heavier one: a plain bar stays as it points.
const EVEN_SHARE: f64 = 1e-6;

/// The outside of a profile; its heavier half comes to the chuck, or with `turn_round` the other.
pub(super) fn of(profile: &Profile, turn_round: bool) -> Outside {
    let nodes = if profile.is_loop { unrolled(&profile.nodes) } else { profile.nodes.clone() };
    let ends = |f: fn(f64, f64) -> f64, start: f64| nodes.iter().map(|n| n.z).fold(start, f);
    let (low, high) = (ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
    let is_at = |n: &Node, z: f64| (n.z - z).abs() < SAME_MM;
    let first = nodes.iter().position(|n| is_at(n, low)).unwrap_or(0);
    let last = nodes.iter().rposition(|n| is_at(n, high)).unwrap_or(nodes.len().saturating_sub(1));
    let middle = 0.5 * (low + high) + EVEN_SHARE * (high - low);
    let is_turned_round = turn_round != (balance(&nodes[first..=last.max(first)]) > middle);
    let zero_z = if is_turned_round { high } else { low };
    let along = |z: f64| if is_turned_round { zero_z - z } else { z - zero_z };
    let mut points: Vec<DVec2> =
        nodes[first..=last.max(first)].iter().map(|n| DVec2::new(n.r, along(n.z))).collect();
    let recess = |inner: &[Node], face: &Node, through: bool| {
        let depth = inner.iter().map(|n| (n.z - face.z).abs()).fold(0.0, f64::max);
        Recess {
            z_mm: along(face.z),
            diameter_mm: 2.0 * face.r,
            depth_mm: if through { high - low } else { depth },
        }
    };
    let mut recesses = Vec::new();
    if nodes[first].r > 0.0 {
        recesses.push(recess(&nodes[..first], &nodes[first], profile.is_loop));
        points.insert(0, DVec2::new(0.0, along(nodes[first].z)));
    }
    if nodes[last].r > 0.0 {
        recesses.push(recess(&nodes[last + 1..], &nodes[last], profile.is_loop));
        points.push(DVec2::new(0.0, along(nodes[last].z)));
    }
    if is_turned_round {
        points.reverse();
    }
    Outside { points, recesses, zero_z, is_turned_round }
}

/// A loop from its innermost place at the least Z, along its outside first.
fn unrolled(nodes: &[Node]) -> Vec<Node> {
    let n = nodes.len();
    let least = |a: &usize, b: &usize| {
        let (a, b) = (&nodes[*a], &nodes[*b]);
        if (a.z - b.z).abs() < SAME_MM { a.r.total_cmp(&b.r) } else { a.z.total_cmp(&b.z) }
    };
    let start = (0..n).min_by(least).unwrap_or(0);
    let ahead: Vec<Node> = (0..n).map(|k| nodes[(start + k) % n]).collect();
    let back: Vec<Node> = (0..n).map(|k| nodes[(start + n - k) % n]).collect();
    // the way to the largest Z that lies further out on the whole is the outside
    let height = |way: &[Node]| {
        let top = (0..n).max_by(|a, b| way[*a].z.total_cmp(&way[*b].z)).unwrap_or(0);
        way[..=top].iter().map(|node| node.r).fold(0.0, f64::max)
    };
    if height(&ahead) >= height(&back) { ahead } else { back }
}

/// Z of the middle of the material inside of the outside, by frustums.
fn balance(nodes: &[Node]) -> f64 {
    let (mut volume, mut moment) = (0.0, 0.0);
    for pair in nodes.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let part = (b.z - a.z) * (a.r * a.r + a.r * b.r + b.r * b.r) / 3.0;
        volume += part;
        moment += part * 0.5 * (a.z + b.z);
    }
    if volume == 0.0 { 0.0 } else { moment / volume }
}
