//! The whole deflection line of a supported shaft in one plane, exact for pieces of constant
//! section.
//!
//! Along a piece with bending stiffness EI, shear stiffness κGA, axial compression P and load q per
//! unit length, the state (u, ψ, M, V) of deflection, rotation of the section, moment and
//! transverse force follows
//!
//! ```text
//! u' = ψ + V/κGA      ψ' = M/EI      M' = -V - P·u'      V' = -q
//! ```
//!
//! (Timoshenko; with EI·u'''' + P·u'' = q for κGA = ∞: S. Timoshenko, J. Gere, Theory of Elastic
//! Stability, 1961, ch. 1). Its transfer over a piece is a matrix exponential: a polynomial for P =
//! 0, a series otherwise. The state is carried from the chuck with the unknown reactions as further
//! columns; the conditions at the supports determine them. Loads and supports can be anywhere, not
//! only where pieces meet. [`super::beam`] gives the deflection at a travelling load alone, in
//! O(N).

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::beam::{Part, Supports};
use super::section::Section;

/// A piece of constant section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// Length, mm.
    pub length_mm: f64,
    /// Stiffness.
    pub section: Section,
    /// Load per unit length along +u, N/mm: the piece's own weight in this plane.
    pub load_n_per_mm: f64,
}

/// A transverse force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointForce {
    /// Where, mm from the chuck face.
    pub z_mm: f64,
    /// Force along +u, N.
    pub force_n: f64,
}

/// What bends a shaft in one plane besides its own weight.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Action {
    /// Point forces.
    pub forces: Vec<PointForce>,
    /// Axial compression, N.
    pub thrust_n: f64,
    /// Where the unloaded chuck holds the axis, mm along u.
    pub chuck_mm: f64,
    /// Where the unloaded tailstock holds the axis, mm along u.
    pub tailstock_mm: f64,
}

type Transfer = SMatrix<f64, 5, 5>;

/// Terms of the exponential's series; it ends far earlier, with the last term below a double's
/// resolution.
const TERMS: u32 = 60;

/// Transfer of (u, ψ, M, V, 1) over `h` mm.
fn transfer(h: f64, span: &Span, thrust_n: f64) -> Transfer {
    let (bend, shear) = (1.0 / span.section.bending_n_mm2, 1.0 / span.section.shear_n);
    let mut a = Transfer::zeros();
    (a[(0, 1)], a[(0, 3)]) = (h, h * shear);
    a[(1, 2)] = h * bend;
    (a[(2, 1)], a[(2, 3)]) = (-h * thrust_n, -h * (1.0 + thrust_n * shear));
    a[(3, 4)] = -h * span.load_n_per_mm;
    let (mut sum, mut term) = (Transfer::identity(), Transfer::identity());
    for k in 1..TERMS {
        term = term * a / f64::from(k);
        let grown = sum + term;
        if grown == sum {
            break;
        }
        sum = grown;
    }
    sum
}

/// The state along the shaft as a linear function of the unknowns; column 0 is the constant term.
struct Carried {
    /// Rows u, ψ, M, V; columns 1 and the unknowns.
    state: DMatrix<f64>,
    /// Conditions at the supports: coefficients of the unknowns and the right-hand side.
    rows: Vec<(Vec<f64>, f64)>,
}

impl Carried {
    /// Starts at the chuck; the unknowns are its force, its moment (at a hinge: its rotation) and
    /// one reaction per rest.
    fn from_chuck(chuck: &Part, chuck_mm: f64, unknowns: usize) -> Self {
        let mut state = DMatrix::zeros(4, unknowns + 1);
        state[(0, 0)] = chuck_mm;
        state[(3, 1)] = 1.0;
        match chuck {
            Part::Held(c) => {
                state[(0, 1)] = c[(0, 0)];
                (state[(1, 2)], state[(2, 2)]) = (c[(1, 1)], 1.0);
            }
            Part::Hinged { compliance_mm_per_n, .. } => {
                state[(0, 1)] = *compliance_mm_per_n;
                state[(1, 2)] = 1.0;
            }
        }
        Self { state, rows: Vec::new() }
    }

    fn advance(&mut self, h: f64, span: &Span, thrust_n: f64) {
        if h <= 0.0 {
            return;
        }
        let t = transfer(h, span, thrust_n);
        for column in 0..self.state.ncols() {
            let one = f64::from(u8::from(column == 0));
            let s = &self.state;
            let before =
                SVector::<f64, 5>::new(s[(0, column)], s[(1, column)], s[(2, column)], s[(3, column)], one);
            let after = t * before;
            (0..4).for_each(|row| self.state[(row, column)] = after[row]);
        }
    }

    /// Adds the condition Σ weights·state = `right` at this place.
    fn demand(&mut self, weights: [f64; 4], right: f64) {
        let value = |column: usize| (0..4).map(|row| weights[row] * self.state[(row, column)]).sum::<f64>();
        self.rows.push(((1..self.state.ncols()).map(value).collect(), right - value(0)));
    }

    /// A radial support with the reaction R (unknown `index`): u = -c·R.
    fn rest(&mut self, index: usize, compliance_mm_per_n: f64) {
        self.demand([1.0, 0.0, 0.0, 0.0], 0.0);
        if let Some((coefficients, _)) = self.rows.last_mut() {
            coefficients[index] += compliance_mm_per_n;
        }
        self.state[(3, index + 1)] -= 1.0;
    }

    fn end(&mut self, tailstock: &Part, tailstock_mm: f64) {
        match tailstock {
            Part::Hinged { compliance_mm_per_n: c, .. } if c.is_infinite() => {
                self.demand([0.0, 0.0, 0.0, 1.0], 0.0);
                self.demand([0.0, 0.0, 1.0, 0.0], 0.0);
            }
            Part::Hinged { compliance_mm_per_n: c, .. } => {
                self.demand([1.0, 0.0, 0.0, *c], tailstock_mm);
                self.demand([0.0, 0.0, 1.0, 0.0], 0.0);
            }
            Part::Held(c) => {
                self.demand([1.0, 0.0, 0.0, c[(0, 0)]], tailstock_mm);
                self.demand([0.0, 1.0, c[(1, 1)], 0.0], 0.0);
            }
        }
    }

    /// The unknowns; `None` for a mechanism or at the buckling load.
    fn solve(&self) -> Option<DVector<f64>> {
        let n = self.rows.len();
        // Equations and unknowns have different units: they are scaled, so that pivots are
        // comparable.
        let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
        let columns: Vec<f64> = (0..n).map(|j| largest(&mut self.rows.iter().map(|r| r.0[j]))).collect();
        if columns.contains(&0.0) {
            return None;
        }
        let mut a = DMatrix::from_fn(n, n, |i, j| self.rows[i].0[j] / columns[j]);
        let mut b = DVector::from_fn(n, |i, _| self.rows[i].1);
        for i in 0..n {
            let scale = largest(&mut a.row(i).iter().copied());
            a.row_mut(i).scale_mut(1.0 / scale);
            b[i] /= scale;
        }
        let found = a.full_piv_lu().solve(&b)?;
        Some(DVector::from_fn(n, |j, _| found[j] / columns[j]))
    }
}

/// A load or a support inside the shaft.
#[derive(Clone, Copy)]
enum Event {
    Force(f64),
    Rest(usize, f64),
}

/// Deflection in mm along +u at the ends of all spans (`spans.len() + 1` values from chuck to
/// tailstock). `None` where the supports leave the shaft free to move, or where the thrust buckles
/// it.
///
/// Forces and rests outside the shaft are moved to its ends.
pub(crate) fn deflection_line_mm(spans: &[Span], supports: &Supports, action: &Action) -> Option<Vec<f64>> {
    let length: f64 = spans.iter().map(|s| s.length_mm).sum();
    let forces = action.forces.iter().map(|f| (f.z_mm, Event::Force(f.force_n)));
    let rests = supports.steady_rests.iter().enumerate();
    let rests = rests.map(|(i, rest)| (rest.z_mm, Event::Rest(i + 2, rest.compliance_mm_per_n)));
    let mut events: Vec<(f64, Event)> = forces.chain(rests).map(|(z, e)| (z.clamp(0.0, length), e)).collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut events = events.into_iter().peekable();
    let unknowns = 2 + supports.steady_rests.len();
    let mut carried = Carried::from_chuck(&supports.chuck, action.chuck_mm, unknowns);
    let mut lines = vec![carried.state.row(0).clone_owned()];
    let (mut at, mut boundary) = (0.0, 0.0);
    for (index, span) in spans.iter().enumerate() {
        boundary += span.length_mm;
        let last = index + 1 == spans.len();
        while let Some((z, event)) = events.next_if(|e| e.0 < boundary || last) {
            carried.advance(z.min(boundary) - at, span, action.thrust_n);
            at = z.min(boundary);
            match event {
                Event::Force(force) => carried.state[(3, 0)] -= force,
                Event::Rest(unknown, compliance) => carried.rest(unknown, compliance),
            }
        }
        carried.advance(boundary - at, span, action.thrust_n);
        at = boundary;
        lines.push(carried.state.row(0).clone_owned());
    }
    carried.end(&supports.tailstock, action.tailstock_mm);
    let found = carried.solve()?;
    let value = |line: &nalgebra::RowDVector<f64>| {
        line[0] + (0..unknowns).map(|j| line[j + 1] * found[j]).sum::<f64>()
    };
    Some(lines.iter().map(value).collect())
}
