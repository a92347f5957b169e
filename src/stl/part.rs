//! A file to a turned part, checked against its bar.

use glam::DVec3;

use super::axis::{self, Axis};
use super::fault::{FaultKind, ModelFault};
use super::mesh::Mesh;
use super::outside::Recess;
use super::read::{Unit, triangles};
use super::{contour, meridian, outside, ring_fit, topology, turns};
use crate::outline::Outline;

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReadSettings {
    /// Unit of its coordinates.
    pub unit: Unit,
    /// Diameter of the bar, mm.
    pub stock_mm: f64,
    /// Largest distance of the outline from the model's vertices, mm.
    pub tolerance_mm: f64,
    /// Whether the lighter end comes to the chuck.
    pub turn_round: bool,
}

/// A turned part.
#[derive(Clone, Debug)]
pub(crate) struct TurnedPart {
    /// Its outside from the end at the chuck, Z 0, to the other.
    pub outline: Outline,
    /// Length, mm.
    pub length_mm: f64,
    /// Its axis in the model; the point is the middle of the end at the chuck, the direction +Z.
    pub axis: Axis,
    /// Bores and recesses in its end faces, which are not turned.
    pub recesses: Vec<Recess>,
    /// Number of facets.
    pub facets: usize,
    /// Number of turns on the outside.
    pub turns: usize,
    /// Largest distance of a vertex from its turn, mm.
    pub scatter_mm: f64,
    /// Largest distance of a turn from the outline, mm.
    pub departure_mm: f64,
}

/// Tolerance of the outline where none is stated, mm: twenty steps of single precision on 100 mm,
/// below a control's increment.
pub(crate) const TOLERANCE_MM: f64 = 2e-4;
/// Share of the bar below which the part's largest diameter is taken for another unit: a bar is
/// seldom turned down to an eighth of its diameter, and units differ by ten and more.
const LEAST_SHARE: f64 = 0.125;

/// Reads a part.
///
/// # Errors
/// A file that is no STL, or a model that is no turned part or does not fit the bar, with its
/// place.
pub(crate) fn read_part(bytes: &[u8], settings: &ReadSettings) -> Result<TurnedPart, ModelFault> {
    let mut mesh = Mesh::welded(&triangles(bytes, settings.unit)?)?;
    topology::checked(&mut mesh)?;
    let first = pointed(axis::of_normals(&mesh)?);
    let axis = ring_fit::refined(&mesh, first);
    // first of all: facets of another unit look too coarse
    fits_the_bar(&mesh, &axis, settings)?;
    let turns = turns::of(&mesh, &axis)?;
    let profile = meridian::profile(&mesh, &axis, &turns)?;
    let outside = outside::of(&profile, settings.turn_round);
    let contour = contour::through(&outside.points, (settings.tolerance_mm, turns.scatter_mm));
    let direction = if outside.is_turned_round { -axis.direction } else { axis.direction };
    Ok(TurnedPart {
        length_mm: contour.outline.z_mm().1,
        outline: contour.outline,
        axis: Axis { point: axis.point + outside.zero_z * axis.direction, direction },
        recesses: outside.recesses,
        facets: mesh.facets.len(),
        turns: outside.points.len(),
        scatter_mm: turns.scatter_mm,
        departure_mm: contour.departure_mm,
    })
}

/// The axis in the sense in which its largest component is positive, so that the order of the
/// facets does not decide.
fn pointed(axis: Axis) -> Axis {
    let d = axis.direction;
    let largest = [d.x, d.y, d.z].into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
    Axis { direction: if largest < 0.0 { -d } else { d }, ..axis }
}

/// Refuses a part that is thicker than its bar, or so thin that another unit is meant.
fn fits_the_bar(mesh: &Mesh, axis: &Axis, settings: &ReadSettings) -> Result<(), ModelFault> {
    let radius = |at: &DVec3| axis.meridian(*at).1;
    let Some(at) = mesh.vertices.iter().copied().max_by(|a, b| radius(a).total_cmp(&radius(b))) else {
        return Err(ModelFault::whole(FaultKind::Empty, "a model without a vertex"));
    };
    let (diameter, stock) = (2.0 * radius(&at), settings.stock_mm);
    // single precision must not refuse a part that is as thick as its bar
    let fits = |d: f64| d <= stock + settings.tolerance_mm && d >= LEAST_SHARE * stock;
    if fits(diameter) {
        return Ok(());
    }
    let others = Unit::ALL.into_iter().filter(|unit| fits(diameter / settings.unit.mm() * unit.mm()));
    let hint = others.map(|unit| {
        format!("--unit {} would make it {:.3} mm", unit.as_str(), diameter / settings.unit.mm() * unit.mm())
    });
    let hint = hint.collect::<Vec<_>>().join(", ");
    let hint = if hint.is_empty() {
        "no unit fits: another bar (--stock) or another model".to_owned()
    } else {
        hint
    };
    let why = format!(
        "the largest diameter, {diameter:.4} mm read in {}, does not fit a bar of {stock} mm (from {:.3} mm, an eighth of it): {hint}",
        settings.unit.as_str(),
        LEAST_SHARE * stock
    );
    Err(ModelFault::at(FaultKind::Unit, at, why))
}
