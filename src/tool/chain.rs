//! Moved pieces joined to a path: trimmed where the outline is concave, led round or extended where
//! it is convex.

use glam::DVec2;

use super::contact::Contact;
use super::error::{Place, ToolError};
use crate::outline::{Piece, meetings};

/// A piece of a path and the piece of the outline that it belongs to; the way about a corner
/// belongs to the piece before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Element {
    /// The piece.
    pub piece: Piece,
    /// Number of the outline's piece, from 0.
    pub source: usize,
}

/// What happens at a convex corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corner {
    /// The tool rolls about it.
    Roll,
    /// Both pieces are extended until they intersect.
    Extend,
}

/// How a run is joined to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joint {
    Smooth,
    Trimmed,
    Extended,
}

struct Run {
    joint: Joint,
    elements: Vec<Element>,
    /// Where it begins on the outline.
    place: DVec2,
}

/// Turn below which two pieces are tangent, rad: 10 nm on 10 mm.
const TANGENT_RAD: f64 = 1e-6;
/// Share of a length by which an intersection may lie beyond an end, for rounding.
const BEYOND: f64 = 1e-7;
/// Length below which a trimmed piece is none, mm.
const NO_LENGTH_MM: f64 = 1e-7;

/// The outline moved by what touches it, as one chain.
///
/// # Errors
/// A place where the moved pieces do not meet: what touches does not fit in.
pub(super) fn moved(
    outline: &[Element],
    contact: &Contact<'_>,
    corner: Corner,
) -> Result<Vec<Element>, ToolError> {
    let mut path: Vec<Element> = Vec::new();
    for run in runs(outline, contact, corner) {
        match run.joint {
            _ if path.is_empty() => path = run.elements,
            Joint::Smooth => path.extend(run.elements),
            Joint::Trimmed => path = trimmed(path, &run)?,
            Joint::Extended => path = trimmed(path.clone(), &run).or_else(|_| extended(path, &run))?,
        }
    }
    Ok(path)
}

fn runs(outline: &[Element], contact: &Contact<'_>, corner: Corner) -> Vec<Run> {
    let mut runs = Vec::new();
    // what a piece that vanished leaves behind: the next joint is trimmed
    let mut lost = false;
    for (i, element) in outline.iter().enumerate() {
        let before = i.checked_sub(1).map(|k| &outline[k].piece);
        let turn = before.map_or(0.0, |b| element.piece.from_rad - b.to_rad);
        let joint = match corner {
            Corner::Extend if turn.abs() > TANGENT_RAD => Joint::Extended,
            Corner::Roll if turn < -TANGENT_RAD => Joint::Trimmed,
            _ => Joint::Smooth,
        };
        if let Some(before) = before.filter(|_| turn > TANGENT_RAD && corner == Corner::Roll) {
            let way = contact.about(before.to, before.to_rad, element.piece.from_rad);
            let source = outline[i - 1].source;
            push(&mut runs, way, (Joint::Smooth, &mut lost), (source, before.to));
        }
        let pieces = contact.moved(&element.piece);
        push(&mut runs, pieces, (joint, &mut lost), (element.source, element.piece.from));
    }
    runs
}

fn push(
    runs: &mut Vec<Run>,
    pieces: Vec<Vec<Piece>>,
    (first, lost): (Joint, &mut bool),
    (source, place): (usize, DVec2),
) {
    for (k, run) in pieces.into_iter().enumerate() {
        let joint = if k > 0 || *lost { Joint::Trimmed } else { first };
        // where the curve turned back nothing is left to join to: the next run is trimmed
        *lost = run.is_empty() && (k > 0 || *lost);
        if !run.is_empty() {
            let elements = run.into_iter().map(|piece| Element { piece, source }).collect();
            runs.push(Run { joint, elements, place });
        }
    }
}

/// The path up to its intersection with a run, and the run from there on.
fn trimmed(mut path: Vec<Element>, run: &Run) -> Result<Vec<Element>, ToolError> {
    let next = &run.elements;
    for sum in 0..path.len() + next.len() - 1 {
        for ahead in 0..=sum.min(next.len() - 1) {
            let Some(i) = (path.len() - 1).checked_sub(sum - ahead) else { continue };
            let (a, b) = (path[i].piece, next[ahead].piece);
            let on = |p: &Piece, at: DVec2| (-BEYOND..=1.0 + BEYOND).contains(&p.share_of(at));
            let found = meetings(&a, &b).into_iter().filter(|m| on(&a, *m) && on(&b, *m));
            let Some(at) = found.min_by(|m, n| a.share_of(*m).total_cmp(&a.share_of(*n))) else { continue };
            path.truncate(i + 1);
            cut(&mut path, at, next, ahead);
            return Ok(path);
        }
    }
    let why = "the nose does not fit in here at all: a narrower nose, a smaller register R, or a wider groove and a larger \
               radius at this place would be right"
        .to_owned();
    Err(ToolError::Gouge { place: Place(run.place), why })
}

/// Ends the path's last piece, and begins the run's piece number `ahead`, at a point.
fn cut(path: &mut Vec<Element>, at: DVec2, next: &[Element], ahead: usize) {
    if let Some(last) = path.pop() {
        let piece = Piece { to: at, ..last.piece.between(0.0, last.piece.share_of(at)) };
        path.extend((piece.length_mm() > NO_LENGTH_MM).then_some(Element { piece, ..last }));
    }
    let first = next[ahead];
    let piece = Piece { from: at, ..first.piece.between(first.piece.share_of(at), 1.0) };
    path.extend((piece.length_mm() > NO_LENGTH_MM).then_some(Element { piece, ..first }));
    path.extend(&next[ahead + 1..]);
}

/// The path and the run, both extended to where their carriers intersect next to the
/// corner.
fn extended(mut path: Vec<Element>, run: &Run) -> Result<Vec<Element>, ToolError> {
    let Some((a, b)) = path.last().map(|last| (last.piece, run.elements[0].piece)) else {
        return Ok(run.elements.clone());
    };
    let near = |m: &DVec2| m.distance(a.to) + m.distance(b.from);
    match meetings(&a, &b).into_iter().min_by(|m, n| near(m).total_cmp(&near(n))) {
        Some(at) => {
            cut(&mut path, at, &run.elements, 0);
            Ok(path)
        }
        None => {
            let why = "the edited contour has no corner here: --way path drives the nose round it".to_owned();
            Err(ToolError::Gouge { place: Place(run.place), why })
        }
    }
}
