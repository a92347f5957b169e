//! Timoshenko beam under a load that travels with the tool, condensed from both ends.
//!
//! At the tool the shaft is cut into a left part (chuck to tool) and a right part (tool to
//! tailstock). Each is described by the compliance C of its cut face, q = C·p, with q = (u, θ) the
//! radial deflection and the rotation of the face and p = (F, M) the load there. Lengthening a part
//! by an element of length h, bending stiffness EI and shear stiffness κGA gives the compliance
//!
//! ```text
//! C' = T·C·Tᵀ + [ h³/3EI + h/κGA   h²/2EI ]      T = [1 h]
//!                [ h²/2EI           h/EI   ]          [0 1]
//! ```
//!
//! which is the elimination of a Timoshenko finite element's inner node, exact for piecewise
//! constant sections. It is written in compliances because every sum then has positive terms only:
//! solving an assembled stiffness matrix amplifies rounding errors by about (L/h)³, this recursion
//! does not. A load at the tool acts on both parts in parallel: u/F = [(C_left⁻¹ + C_right⁻¹)⁻¹]₁₁,
//! so that all N positions of the load cost O(N).

use nalgebra::{Matrix2, Vector2};

use super::section::Section;

/// One part of the shaft, from its support to the face at the tool. Rotations and moments are
/// counted positive away from the support, so that left and right parts follow the same equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part {
    /// Supported by a force at the tip alone (centre in the tailstock): the face can rotate freely
    /// about the tip, and yields by `compliance_mm_per_n` under a force whose moment about the tip
    /// vanishes.
    Hinged {
        /// Deflection per force in that direction, mm/N; infinite for a free end.
        compliance_mm_per_n: f64,
        /// Distance from the tip to the face, mm.
        lever_mm: f64,
    },
    /// The face is held in both directions; compliance in mm/N, 1/N and 1/(N·mm).
    Held(Matrix2<f64>),
}

impl Part {
    /// A clamped end that yields by `compliance_mm_per_n` and tilts by `tilt_per_n_mm`; zero for
    /// rigid.
    pub(crate) fn clamped(compliance_mm_per_n: f64, tilt_per_n_mm: f64) -> Self {
        Self::Held(Matrix2::from_diagonal(&Vector2::new(compliance_mm_per_n, tilt_per_n_mm)))
    }

    /// An end on a centre that yields by `compliance_mm_per_n`; zero for rigid, infinite for a free
    /// end.
    pub(crate) fn hinged(compliance_mm_per_n: f64) -> Self {
        Self::Hinged { compliance_mm_per_n, lever_mm: 0.0 }
    }

    /// Lengthens the part by an element of `length_mm`.
    pub(crate) fn extend(&mut self, length_mm: f64, section: &Section) {
        let h = length_mm;
        match self {
            Self::Hinged { compliance_mm_per_n, lever_mm } => {
                let (near, far) = (*lever_mm, *lever_mm + h);
                let bending = h * (near * near + near * far + far * far) / (3.0 * section.bending_n_mm2);
                *compliance_mm_per_n += bending + h / section.shear_n;
                *lever_mm = far;
            }
            Self::Held(c) => {
                let transfer = Matrix2::new(1.0, h, 0.0, 1.0);
                *c = transfer * *c * transfer.transpose() + element_compliance(h, section);
            }
        }
    }

    /// Adds a radial support (a steady rest) at the face; `compliance_mm_per_n` is zero for a rigid
    /// one.
    pub(crate) fn support(&mut self, compliance_mm_per_n: f64) {
        let rest = compliance_mm_per_n;
        match *self {
            Self::Hinged { compliance_mm_per_n: c, lever_mm: b } => {
                *self = if c.is_infinite() {
                    Self::hinged(rest)
                } else if b > 0.0 {
                    Self::Held(Matrix2::new(rest, rest / b, rest / b, (rest + c) / (b * b)))
                } else {
                    Self::hinged(in_parallel(c, rest))
                };
            }
            Self::Held(ref mut c) => {
                let sum = rest + c[(0, 0)];
                if sum > 0.0 && sum.is_finite() {
                    let (own, cross) = (rest * c[(0, 0)], rest * c[(0, 1)]);
                    let tilt = rest * c[(1, 1)] + c.determinant();
                    *c = Matrix2::new(own, cross, cross, tilt) / sum;
                }
            }
        }
    }
}

/// Compliance of two springs side by side.
fn in_parallel(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { 1.0 / (1.0 / a + 1.0 / b) }
}

/// Compliance of a cantilever of one element at its end.
fn element_compliance(h: f64, section: &Section) -> Matrix2<f64> {
    let ei = section.bending_n_mm2;
    let bend = h * h / (2.0 * ei);
    Matrix2::new(h * h * h / (3.0 * ei) + h / section.shear_n, bend, bend, h / ei)
}

/// Radial deflection per newton, mm/N, of a load where the faces of `left` and `right` meet.
pub(crate) fn compliance_at_joint(left: &Part, right: &Part) -> f64 {
    match (left, right) {
        (Part::Held(held), &Part::Hinged { compliance_mm_per_n, lever_mm })
        | (&Part::Hinged { compliance_mm_per_n, lever_mm }, Part::Held(held)) => {
            held_and_hinged(held, compliance_mm_per_n, lever_mm)
        }
        (Part::Held(l), Part::Held(r)) => {
            let mirrored = Matrix2::new(r[(0, 0)], -r[(0, 1)], -r[(1, 0)], r[(1, 1)]);
            (l + mirrored).try_inverse().map_or(0.0, |sum| (l * sum * mirrored)[(0, 0)])
        }
        (
            &Part::Hinged { compliance_mm_per_n: c, lever_mm: a },
            &Part::Hinged { compliance_mm_per_n: d, lever_mm: b },
        ) => two_hinged(c, a, d, b),
    }
}

/// Sherman-Morrison, C - (Cn)(Cn)ᵀ/(c + nᵀCn) with n = (1, b), multiplied out so that nothing
/// cancels: (c·C₁₁ + b²·det C)/(c + nᵀCn).
fn held_and_hinged(held: &Matrix2<f64>, compliance: f64, lever: f64) -> f64 {
    if compliance.is_infinite() {
        return held[(0, 0)];
    }
    let direction = Vector2::new(1.0, lever);
    let sum = compliance + direction.dot(&(held * direction));
    let product = compliance * held[(0, 0)] + lever * lever * held.determinant();
    if sum > 0.0 { product / sum } else { 0.0 }
}

/// A simply supported shaft: the force is divided by the lever rule, and each side yields under its
/// own share.
fn two_hinged(c: f64, a: f64, d: f64, b: f64) -> f64 {
    let length = a + b;
    if length > 0.0 { c * (b / length).powi(2) + d * (a / length).powi(2) } else { in_parallel(c, d) }
}

/// A steady rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SteadyRest {
    /// Where it stands, mm.
    pub z_mm: f64,
    /// Radial compliance, mm/N; zero for a rigid one.
    pub compliance_mm_per_n: f64,
}

/// Supports of a shaft in the machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Supports {
    /// The chuck's end, before the first element.
    pub chuck: Part,
    /// The tailstock's end, before the first element.
    pub tailstock: Part,
    /// Steady rests.
    pub steady_rests: Vec<SteadyRest>,
}

impl Supports {
    /// Compliance of the steady rests that belong to node `node` of a grid of step `step_mm`.
    pub(super) fn rests_at(&self, node: usize, step_mm: f64) -> impl Iterator<Item = f64> + '_ {
        let mine = move |rest: &&SteadyRest| (rest.z_mm / step_mm).round() == node as f64;
        self.steady_rests.iter().filter(mine).map(|rest| rest.compliance_mm_per_n)
    }
}

/// Radial deflection at the load per newton of load, mm/N, for a load at every node of a grid of
/// equal elements: `sections.len() + 1` values from chuck to tailstock.
#[cfg(test)]
pub(crate) fn travelling_load(step_mm: f64, sections: &[Section], supports: &Supports) -> Vec<f64> {
    let lefts = left_parts(step_mm, sections, supports);
    let mut right = supports.tailstock;
    let mut compliance = vec![0.0; lefts.len()];
    for node in (0..lefts.len()).rev() {
        if let Some(section) = sections.get(node) {
            right.extend(step_mm, section);
        }
        compliance[node] = compliance_at_joint(&lefts[node], &right);
        supports.rests_at(node, step_mm).for_each(|rest| right.support(rest));
    }
    compliance
}

/// The left part up to every node, its own steady rest included.
#[cfg(test)]
fn left_parts(step_mm: f64, sections: &[Section], supports: &Supports) -> Vec<Part> {
    let mut part = supports.chuck;
    let mut parts = Vec::with_capacity(sections.len() + 1);
    for node in 0..=sections.len() {
        supports.rests_at(node, step_mm).for_each(|rest| part.support(rest));
        parts.push(part);
        if let Some(section) = sections.get(node) {
            part.extend(step_mm, section);
        }
    }
    parts
}
