//! Exact silhouette of a turning, bent shaft, viewed along y by a telecentric lens.
//!
//! A slice at z with radius r(θ) has the tangent height (support function)
//!
//! ```text
//! h(φ) = max_θ r(θ) cos(θ + φ),   top = c_x + h(φ),   bottom = c_x - h(φ + π)
//! r(θ) = R(z) + Σ a_k cos(k(θ - θ_k)) + texture(z, θ)
//! ```
//!
//! with the exact maximum (r(-φ) alone errs by k²a²/2R, 65 nm at k = 15, a = 10 µm). The texture is
//! linear in θ between its nodes, so the circle is divided into segments on which r(θ)cos(θ + φ) is
//! smooth and has at most one inner maximum. Only segments near the top can contain it: r ≤ r_max
//! requires cos δ ≥ r_min/r_max. Lobes do not change along z, so their Taylor polynomials about
//! every segment's middle are computed once per direction for all columns.
//!
//! A pose tilted by τ in the image plane turns the whole outline: z = s cos τ - X sin τ, x = x0 + s
//! sin τ + X cos τ, with X(s) the outline over the body's own axis s. Sections of a bent body
//! remain perpendicular to its axis (`bent`), but its shoulders are modelled upright (a slope of
//! 1e-3 tilts one of R = 12.5 mm by 12 µm along z). Where a shoulder overhangs, the edge is the
//! outermost one, and the light beneath the overhang is a gap ([`Turned::gap`]). Threads, feed
//! marks, flats and keyways divide the segments further (`slice`); tilt towards the camera and
//! perspective take the envelope over the slices (`envelope`).
//!
//! In: a [`Shaft`](crate::shaft::Shaft), refused by `check` where it cannot be drawn. Out:
//! [`Outline`] (bounds, once per shaft), [`Turned`] (once per spindle angle), and from it edges in
//! mm over machine z. A new feature of the body has its height and bounds in `features` and its
//! part of a slice in `slice`.

mod bent;
mod check;
mod envelope;
mod features;
mod outline;
mod segments;
mod slice;
mod turned;

pub(crate) use envelope::View;
pub(crate) use outline::Outline;
pub(crate) use turned::Turned;
