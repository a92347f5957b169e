//! Assembled Timoshenko finite elements: the whole deflection line under given loads.
//!
//! Two-node elements with Φ = 12EI/(κGA·h²), whose stiffness
//!
//! ```text
//!        EI         [  12    6h      -12    6h      ]
//! k = ----------- · [  6h   (4+Φ)h²  -6h   (2-Φ)h²  ]
//!     h³(1 + Φ)     [ -12   -6h       12   -6h      ]
//!                   [  6h   (2-Φ)h²  -6h   (4+Φ)h²  ]
//! ```
//!
//! is exact for constant sections (J. S. Przemieniecki, Theory of Matrix Structural
//! Analysis, 1968). The system is block tridiagonal (half bandwidth 4) and solved by block
//! elimination. It amplifies rounding errors by about (L/h)³: accurate enough to draw a deflection
//! line and to check [`super::beam`], which the passes use.

use nalgebra::{Matrix2, Vector2};

use super::beam::{Part, Supports};
use super::section::Section;

/// Stiffness blocks of an element: near-near, near-far, far-far.
fn element(h: f64, section: &Section) -> [Matrix2<f64>; 3] {
    let phi = 12.0 * section.bending_n_mm2 / (section.shear_n * h * h);
    let scale = section.bending_n_mm2 / (h * h * h * (1.0 + phi));
    let (four, two) = ((4.0 + phi) * h * h, (2.0 - phi) * h * h);
    [
        scale * Matrix2::new(12.0, 6.0 * h, 6.0 * h, four),
        scale * Matrix2::new(-12.0, 6.0 * h, -6.0 * h, two),
        scale * Matrix2::new(12.0, -6.0 * h, -6.0 * h, four),
    ]
}

/// A node: its block on the diagonal, and its load.
#[derive(Clone)]
struct Node {
    diagonal: Matrix2<f64>,
    load: Vector2<f64>,
}

struct System {
    nodes: Vec<Node>,
    /// Blocks that couple a node to the next.
    upper: Vec<Matrix2<f64>>,
}

impl System {
    fn assemble(step_mm: f64, sections: &[Section]) -> Self {
        let free = Node { diagonal: Matrix2::zeros(), load: Vector2::zeros() };
        let mut nodes = vec![free; sections.len() + 1];
        let mut upper = Vec::with_capacity(sections.len());
        for (node, section) in sections.iter().enumerate() {
            let [near, across, far] = element(step_mm, section);
            nodes[node].diagonal += near;
            nodes[node + 1].diagonal += far;
            upper.push(across);
        }
        Self { nodes, upper }
    }

    /// A spring of compliance `compliance` on degree of freedom `dof` (0 deflection, 1 rotation);
    /// zero fixes it.
    fn support(&mut self, node: usize, dof: usize, compliance: f64) {
        let Node { diagonal, load } = &mut self.nodes[node];
        if compliance > 0.0 {
            diagonal[(dof, dof)] += 1.0 / compliance;
            return;
        }
        diagonal.fill_row(dof, 0.0);
        diagonal.fill_column(dof, 0.0);
        diagonal[(dof, dof)] = 1.0;
        load[dof] = 0.0;
        if let Some(across) = self.upper.get_mut(node) {
            across.fill_row(dof, 0.0);
        }
        if let Some(across) = node.checked_sub(1).and_then(|before| self.upper.get_mut(before)) {
            across.fill_column(dof, 0.0);
        }
    }

    fn support_end(&mut self, node: usize, end: &Part) {
        match end {
            Part::Hinged { compliance_mm_per_n, .. } => self.support(node, 0, *compliance_mm_per_n),
            Part::Held(c) => {
                self.support(node, 0, c[(0, 0)]);
                self.support(node, 1, c[(1, 1)]);
            }
        }
    }

    /// Block elimination; `None` for a mechanism.
    fn solve(mut self) -> Option<Vec<Vector2<f64>>> {
        for (i, across) in self.upper.iter().enumerate() {
            let factor = across.transpose() * self.nodes[i].diagonal.try_inverse()?;
            self.nodes[i + 1].diagonal -= factor * across;
            let carried = factor * self.nodes[i].load;
            self.nodes[i + 1].load -= carried;
        }
        let mut q = vec![Vector2::zeros(); self.nodes.len()];
        for (node, Node { diagonal, load }) in self.nodes.iter().enumerate().rev() {
            let beyond = q.get(node + 1).map_or(Vector2::zeros(), |next| self.upper[node] * next);
            q[node] = diagonal.try_inverse()? * (load - beyond);
        }
        Some(q)
    }
}

/// Radial deflection in mm of every node (`sections.len() + 1` of them, `step_mm` apart) under
/// forces in N at nodes. `None` where the supports leave the shaft free to move, or a force does
/// not act at a node.
pub(crate) fn deflection_line_mm(
    step_mm: f64,
    sections: &[Section],
    supports: &Supports,
    forces: &[(usize, f64)],
) -> Option<Vec<f64>> {
    let mut system = System::assemble(step_mm, sections);
    for (node, force) in forces {
        system.nodes.get_mut(*node)?.load[0] += force;
    }
    system.support_end(0, &supports.chuck);
    system.support_end(sections.len(), &supports.tailstock);
    for node in 0..=sections.len() {
        for rest in supports.rests_at(node, step_mm) {
            system.support(node, 0, rest);
        }
    }
    Some(system.solve()?.iter().map(|q| q[0]).collect())
}
