//! Models of turned parts: STL files to outlines.
//!
//! In: the bytes of an STL file (binary or ASCII, separated by its size) and the unit of its
//! coordinates. Out: [`TurnedPart`], the outside as an [`Outline`](crate::outline::Outline) of
//! lines and arcs with Z from the end at the chuck, or a `ModelFault` with its place. The model may
//! lie and point anywhere.
//!
//! `read` → `mesh` (corners welded) → `topology` (one closed body) → `axis` (the normals' linear
//! complex) → `ring_fit` (Levenberg-Marquardt on `rings`, vertices of one turn) → `turns` (every
//! vertex to its turn) → `meridian` (turns in order) → `outside` → `segments` → `carriers` (least
//! squares, tangency kept) → `contour`. Vertices lie on the part's surface, facets do not: only
//! vertices are fitted, so that a coarse mesh gives the same outline as a fine one.

mod axis;
mod carriers;
mod contour;
mod fault;
mod meridian;
mod mesh;
mod outside;
mod part;
mod read;
mod ring_fit;
mod rings;
mod segments;
mod topology;
mod turns;

pub(crate) use fault::FaultKind;
pub(crate) use part::{ReadSettings, TOLERANCE_MM, TurnedPart, read_part};
pub(crate) use read::Unit;
