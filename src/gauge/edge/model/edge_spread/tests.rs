//! Of the edge-spread functions.

use super::*;
use crate::numerics::distributions::phi_cdf;

#[test]
fn a_tabulated_gaussian_is_the_gaussian() {
    let shape = EdgeSpreadFunction::Table(Arc::new(TabulatedEsf::new(8.0, |d| phi_cdf(d / 0.8))));
    let sigma = shape.own_sigma().unwrap();
    assert!((sigma - 0.8).abs() < 5e-4, "{sigma}");
    for (x0, scale) in [(0.13, 1.0), (-0.4, 1.1)] {
        let (mut a, mut b) = ([EdgeSample::default(); 13], [EdgeSample::default(); 13]);
        shape.samples(-6.0, x0, sigma * scale, &mut a);
        edge_samples(-6.0, x0, 0.8 * scale, &mut b);
        for (a, b) in a.iter().zip(&b) {
            assert!((a.value - b.value).abs() < 2e-4, "{a:?} {b:?}");
            assert!((a.by_position - b.by_position).abs() < 5e-4, "{a:?} {b:?}");
            assert!((a.by_sigma - b.by_sigma).abs() < 5e-4, "{a:?} {b:?}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_values() {
    // A one-sided exponential: asymmetric, centroid 0.7 px in the light.
    let f = |d: f64| if d <= 0.0 { 0.0 } else { 1.0 - (-d / 0.7).exp() };
    let shape = EdgeSpreadFunction::Table(Arc::new(TabulatedEsf::new(12.0, f)));
    let sigma = shape.own_sigma().unwrap();
    assert!((shape.centroid(sigma) - 0.7).abs() < 1e-3);
    let at = |x0: f64, sigma: f64| {
        let mut out = [EdgeSample::default(); 15];
        shape.samples(-7.0, x0, sigma, &mut out);
        out
    };
    let (x0, h) = (0.21, 1e-4);
    let (up, down) = (at(x0 + h, sigma), at(x0 - h, sigma));
    let (wide, narrow) = (at(x0, sigma + h), at(x0, sigma - h));
    for (k, sample) in at(x0, sigma).iter().enumerate() {
        assert!((sample.by_position - (up[k].value - down[k].value) / (2.0 * h)).abs() < 1e-4);
        assert!((sample.by_sigma - (wide[k].value - narrow[k].value) / (2.0 * h)).abs() < 1e-4);
    }
}

/// Between its knots a table is a cubic through I and F: I errs by h⁴/384·max|F‴|, F by some ten
/// thousandths of σ/h of that. A Gaussian of 0.12 px, the sharpest that is tabulated, has max|F‴| =
/// 0.4/σ³ = 231: 3.6e-8 px at 64 knots to the pixel.
#[test]
fn a_sharp_edge_is_tabulated_to_a_millionth() {
    let sigma = 0.12;
    let table = TabulatedEsf::new(2.0, |d| phi_cdf(d / sigma));
    let worst = (0..4000).map(|k| f64::from(k) / 2000.0 - 1.0).map(|t| {
        let [integral, value, _] = gaussian_border(t, sigma);
        let (i, f) = table.at(t);
        [(i - integral).abs(), (f - value).abs()]
    });
    let worst = worst.fold([0.0_f64; 2], |most, off| [most[0].max(off[0]), most[1].max(off[1])]);
    assert!(worst[0] < 5e-8 && worst[1] < 1e-5, "{worst:?}");
}

/// An edge with exponential tails, ½·e^(−|d|/a), differs from its ends by 0.002 at a·ln 250.
#[test]
fn a_table_reaches_to_where_its_tails_are_flat() {
    let a: f64 = 0.7;
    let laplace = |d: f64| if d < 0.0 { 0.5 * (d / a).exp() } else { 1.0 - 0.5 * (-d / a).exp() };
    let table = TabulatedEsf::new(16.0, laplace);
    let sigma = table.sigma();
    let reach = EdgeSpreadFunction::Table(Arc::new(table)).reach(sigma);
    assert!((reach - 1.25 - a * 250.0_f64.ln()).abs() < 0.02, "{reach}");
}

/// The shadow of a straight edge in coherent light without a lens (Fresnel): ½·[(C + ½)² + (S +
/// ½)²] at v = d/unit, C and S by the rule of midpoints.
fn fresnel(unit_px: f64, reach_px: f64) -> EdgeSpreadFunction {
    let step = 1.0 / 512.0;
    let [mut c, mut s] = [0.0, 0.0];
    let integrals: Vec<[f64; 2]> = std::iter::once([0.0; 2])
        .chain((0..(reach_px / unit_px / step) as usize + 2).map(|k| {
            let t = (k as f64 + 0.5) * step;
            let phase = 0.5 * std::f64::consts::PI * t * t;
            (c, s) = (c + step * phase.cos(), s + step * phase.sin());
            [c, s]
        }))
        .collect();
    let light = |d: f64| {
        let place = (d / unit_px).abs() / step;
        let (k, t) = (place as usize, place.fract());
        let at = |i: usize| ((1.0 - t) * integrals[k][i] + t * integrals[k + 1][i]).copysign(d);
        0.5 * ((at(0) + 0.5).powi(2) + (at(1) + 0.5).powi(2))
    };
    EdgeSpreadFunction::Table(Arc::new(TabulatedEsf::new(reach_px, light)))
}

/// Rings of 8 px blur (a part 10 mm before a sensor of 3 µm) would reach twelve times that, 97 px:
/// windows of 256 px hold 96. Those of 4.8 px reach 59 px, and are used whole.
#[test]
fn rings_reach_as_far_as_the_longest_window() {
    let of = |unit_px: f64| {
        let shape = fresnel(unit_px, 120.0);
        assert!(shape.is_ringed());
        let own = shape.own_sigma().unwrap();
        (own, shape.reach(own))
    };
    let (own, reach) = of(28.5);
    assert!(own > 7.9 && reach == 96.0, "{own} {reach}");
    let (own, reach) = of(17.0);
    assert!((own - 4.8).abs() < 0.1 && (12.0 * own + 1.25 - reach).abs() < 1e-9, "{own} {reach}");
}
