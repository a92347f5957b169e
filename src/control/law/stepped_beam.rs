//! Deflection of a stepped shaft under a load that travels along it, as the model-based controller
//! assumes it: the force method on an Euler-Bernoulli cantilever of round pieces.
//!
//! ```text
//! δ(a, b) = 1/k_c + ∫₀^min(a,b) (a − s)(b − s) / EI(s) ds      unit load at a, deflection at b
//! w(a)    = δ(a, a) − dᵀ (F + C)⁻¹ d      d_j = δ(a, z_j), F_jk = δ(z_j, z_k), C = diag(c_j)
//! ```
//!
//! The clamp yields sideways by 1/k_c; z_j are the redundant supports, the tailstock with c = 1/k_t
//! and rigid steady rests (Castigliano's second theorem: the reactions make the work stationary;
//! S. Timoshenko, Strength of Materials I, 1955, ch. XI). A shaft of one diameter held at both ends
//! is the closed form in [`super::model`].

use nalgebra::{DMatrix, DVector};

use crate::plan::{Contour, Piece};

/// The pieces of a contour between chuck and tailstock; one of a plain shaft.
pub(super) fn pieces(contour: Option<&Contour>, length_mm: f64) -> Vec<Piece> {
    let plain = || vec![Piece { from_mm: 0.0, to_mm: length_mm, relative_mm: 0.0 }];
    contour.map_or_else(plain, Contour::pieces)
}

/// A stepped shaft in its supports.
pub(super) struct SteppedBeam<'a> {
    pub pieces: &'a [Piece],
    pub length_mm: f64,
    pub e_n_per_mm2: f64,
    /// Diameter of the largest section, mm.
    pub diameter_mm: f64,
    /// Where rigid steady rests stand, mm.
    pub steady_z_mm: &'a [f64],
    /// Stiffness of chuck and tailstock, N/mm; 0 for a free end.
    pub chuck: f64,
    pub tailstock: f64,
}

impl SteppedBeam<'_> {
    /// Deflection under a unit radial load at a, mm/N.
    pub(super) fn compliance(&self, a: f64) -> f64 {
        let mut supports: Vec<(f64, f64)> = self.steady_z_mm.iter().map(|z| (*z, 0.0)).collect();
        if self.tailstock > 0.0 {
            supports.push((self.length_mm, 1.0 / self.tailstock));
        }
        let own = self.flexibility(a, a);
        if supports.is_empty() {
            return own;
        }
        let n = supports.len();
        let d = DVector::from_iterator(n, supports.iter().map(|(z, _)| self.flexibility(a, *z)));
        let f = DMatrix::from_fn(n, n, |j, k| {
            let yielding = if j == k { supports[j].1 } else { 0.0 };
            self.flexibility(supports[j].0, supports[k].0) + yielding
        });
        let reactions = f.cholesky().map(|f| f.solve(&d));
        reactions.map_or(own, |r| own - d.dot(&r))
    }

    /// δ(a, b), mm/N.
    fn flexibility(&self, a: f64, b: f64) -> f64 {
        let reach = a.min(b);
        let primitive = |s: f64| s * (a * b - 0.5 * (a + b) * s + s * s / 3.0);
        let bent: f64 = self
            .pieces
            .iter()
            .filter(|p| p.from_mm < reach)
            .map(|p| {
                let d = self.diameter_mm + p.relative_mm;
                let ei = self.e_n_per_mm2 * std::f64::consts::PI * d.powi(4) / 64.0;
                (primitive(p.to_mm.min(reach)) - primitive(p.from_mm)) / ei
            })
            .sum();
        1.0 / self.chuck + bent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const E: f64 = 7.0e4;

    fn beam<'a>(pieces: &'a [Piece], steady_z_mm: &'a [f64], tailstock: f64) -> SteppedBeam<'a> {
        let length_mm = pieces.last().map_or(0.0, |p| p.to_mm);
        SteppedBeam {
            pieces,
            length_mm,
            e_n_per_mm2: E,
            diameter_mm: 60.0,
            steady_z_mm,
            chuck: 8e4,
            tailstock,
        }
    }

    fn ei(d: f64) -> f64 {
        E * std::f64::consts::PI * d * d * d * d / 64.0
    }

    /// Castigliano by hand: a cantilever of lengths p (Ø60) and q (Ø40) loaded at its end yields
    /// q³/3EI₂ + [(p + q)³ − q³]/3EI₁.
    #[test]
    fn a_cantilever_of_two_sections_is_the_closed_form() {
        let (p, q) = (120.0_f64, 80.0_f64);
        let pieces = [
            Piece { from_mm: 0.0, to_mm: p, relative_mm: 0.0 },
            Piece { from_mm: p, to_mm: p + q, relative_mm: -20.0 },
        ];
        let wanted =
            q.powi(3) / (3.0 * ei(40.0)) + ((p + q).powi(3) - q.powi(3)) / (3.0 * ei(60.0)) + 1.0 / 8e4;
        let found = beam(&pieces, &[], 0.0).compliance(p + q);
        assert!((found / wanted - 1.0).abs() < 1e-12, "{found} {wanted}");
        // Maxwell: the deflection at a by a load at b is that at b by a load at a.
        let b = beam(&pieces, &[], 0.0);
        assert_eq!(b.flexibility(70.0, 150.0), b.flexibility(150.0, 70.0));
    }

    /// Clamped, rigid rest and end: nothing yields at a rigid support, and a rigid end stiffens.
    #[test]
    fn rests_hold_and_a_plain_shaft_on_a_rigid_centre_is_in_the_handbook() {
        let whole = [Piece { from_mm: 0.0, to_mm: 200.0, relative_mm: 0.0 }];
        assert!(beam(&whole, &[90.0], 0.0).compliance(90.0).abs() < 1e-15);
        // a³b²(3L + b)/12EIL³ + chuck's share: with a rigid chuck the propped cantilever.
        let rigid = SteppedBeam { chuck: f64::INFINITY, tailstock: f64::INFINITY, ..beam(&whole, &[], 1.0) };
        let (a, l) = (130.0_f64, 200.0_f64);
        let b = l - a;
        let wanted = a.powi(3) * b * b * (3.0 * l + b) / (12.0 * ei(60.0) * l.powi(3));
        assert!((rigid.compliance(a) / wanted - 1.0).abs() < 1e-9, "{} {wanted}", rigid.compliance(a));
    }
}
