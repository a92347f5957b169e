//! Moved pieces joined to a path, trimmed where the outline is concave and led round where it is
//! convex, and the contour inside of a path.

use glam::DVec2;

use super::contact::Contact;
use super::error::{Place, ToolError};
use crate::outline::{Arc, Piece, meetings};

/// A piece of a path and the piece of the outline that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Element {
    /// The piece.
    pub piece: Piece,
    /// Number of the outline's piece, from 0; the one before a corner where it rolls about it.
    pub source: usize,
    /// Whether it rolls about a convex corner.
    pub rolls: bool,
}

/// How a run is joined to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joint {
    Smooth,
    Trimmed,
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
/// A place where the moved pieces do not meet: the nose does not fit in.
pub(super) fn moved(outline: &[Element], contact: &Contact<'_>) -> Result<Vec<Element>, ToolError> {
    let mut path: Vec<Element> = Vec::new();
    let mut lost = None;
    for run in runs(outline, contact) {
        match run.joint {
            _ if path.is_empty() => path = run.elements,
            Joint::Smooth => path.extend(run.elements),
            // a run that meets nothing vanishes: the tool touches before and behind it at once
            Joint::Trimmed => lost = trimmed(&mut path, &run).is_none().then_some(run.place),
        }
    }
    match lost {
        None => Ok(path),
        Some(at) => {
            let why = "the nose does not fit in here at all: a narrower nose, a smaller register R, or a wider groove and \
                       a larger radius at this place would be right"
                .to_owned();
            Err(ToolError::Gouge { place: Place(at), why })
        }
    }
}

fn runs(outline: &[Element], contact: &Contact<'_>) -> Vec<Run> {
    let mut runs = Vec::new();
    // what a piece that vanished leaves behind: the next joint is trimmed
    let mut lost = false;
    for (i, element) in outline.iter().enumerate() {
        let before = i.checked_sub(1).map(|k| &outline[k].piece);
        let turn = before.map_or(0.0, |b| element.piece.from_rad - b.to_rad);
        let joint = if turn < -TANGENT_RAD { Joint::Trimmed } else { Joint::Smooth };
        if let Some(before) = before.filter(|_| turn > TANGENT_RAD) {
            let way = contact.about(before.to, before.to_rad, element.piece.from_rad);
            let corner = Element { source: outline[i - 1].source, rolls: true, ..*element };
            push(&mut runs, way, (Joint::Smooth, &mut lost), (corner, before.to));
        }
        let pieces = contact.moved(&element.piece);
        push(&mut runs, pieces, (joint, &mut lost), (*element, element.piece.from));
    }
    runs
}

fn push(
    runs: &mut Vec<Run>,
    pieces: Vec<Vec<Piece>>,
    (first, lost): (Joint, &mut bool),
    (of, place): (Element, DVec2),
) {
    for (k, run) in pieces.into_iter().enumerate() {
        let joint = if k > 0 || *lost { Joint::Trimmed } else { first };
        // where the curve turned back nothing is left to join to: the next run is trimmed
        *lost = run.is_empty() && (k > 0 || *lost);
        if !run.is_empty() {
            let elements = run.into_iter().map(|piece| Element { piece, ..of });
            match runs.last_mut().filter(|_| joint == Joint::Smooth) {
                Some(open) => open.elements.extend(elements),
                None => runs.push(Run { joint, elements: elements.collect(), place }),
            }
        }
    }
}

/// Cuts a path at its intersection with a run and goes on with it from there; `None`, and an
/// unchanged path, where they do not intersect.
fn trimmed(path: &mut Vec<Element>, run: &Run) -> Option<()> {
    let next = &run.elements;
    for sum in 0..path.len() + next.len() - 1 {
        for ahead in 0..=sum.min(next.len() - 1) {
            let Some(i) = (path.len() - 1).checked_sub(sum - ahead) else { continue };
            let (a, b) = (path[i].piece, next[ahead].piece);
            let on = |p: &Piece, at: DVec2| (-BEYOND..=1.0 + BEYOND).contains(&p.share_of(at));
            let found = meetings(&a, &b).into_iter().filter(|m| on(&a, *m) && on(&b, *m));
            let Some(at) = found.min_by(|m, n| a.share_of(*m).total_cmp(&a.share_of(*n))) else { continue };
            path.truncate(i + 1);
            cut(path, at, next, ahead);
            return Some(());
        }
    }
    None
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

/// The contour that a control with the radius R drives along a path: R inside of it and moved by
/// `shift`. Ways about convex corners are left out; where pieces end apart they are extended to
/// where their carriers intersect.
///
/// # Errors
/// Pieces that do not intersect next to their ends.
pub(super) fn inside(path: &[Element], radius_mm: f64, shift: DVec2) -> Result<Vec<Element>, ToolError> {
    let mut contour: Vec<Element> = Vec::new();
    for element in path.iter().filter(|e| !e.rolls) {
        let Some(piece) = inwards(&element.piece, radius_mm) else { continue };
        let next = Element { piece: piece.moved(shift), ..*element };
        let apart = contour.last().is_some_and(|last| last.piece.to.distance(next.piece.from) > NO_LENGTH_MM);
        if apart { extend(&mut contour, next)? } else { contour.push(next) }
    }
    Ok(contour)
}

/// A piece moved by R against its normal; none where an arc turns inside out.
fn inwards(piece: &Piece, radius_mm: f64) -> Option<Piece> {
    let Some(arc) = piece.arc else {
        return Some(piece.moved(-radius_mm * DVec2::from_angle(piece.from_rad)));
    };
    let smaller = Arc { radius_mm: arc.radius_mm - radius_mm, ..arc };
    let turn = piece.to_rad - piece.from_rad;
    (smaller.radius_mm * turn > 0.0).then(|| Piece::arc(smaller, piece.from_rad, piece.to_rad))
}

/// Joins a piece to a contour that ends apart from it.
fn extend(contour: &mut Vec<Element>, next: Element) -> Result<(), ToolError> {
    let Some(last) = contour.last().copied() else { return Ok(()) };
    let near = |m: &DVec2| m.distance(last.piece.to) + m.distance(next.piece.from);
    let found = meetings(&last.piece, &next.piece).into_iter().min_by(|m, n| near(m).total_cmp(&near(n)));
    match found.filter(|at| last.piece.share_of(*at) > 0.0 && next.piece.share_of(*at) < 1.0) {
        Some(at) => {
            cut(contour, at, &[next], 0);
            Ok(())
        }
        None => {
            let why = "the edited contour has no corner here: --way path drives the nose round it".to_owned();
            Err(ToolError::Gouge { place: Place(next.piece.from), why })
        }
    }
}
