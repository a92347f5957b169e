//! The limb of a cylinder against the series of the infinite cylinder, published widths and
//! identities.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use rustfft::num_complex::Complex;
use shadowgauge::render::esf_families::cylinder::airy::{airy, unit};
use shadowgauge::render::esf_families::cylinder::half_shadow::HalfShadow;
use shadowgauge::render::esf_families::cylinder::image::Limb;
use shadowgauge::render::esf_families::cylinder::surface::{Boundary, Surface};
use shadowgauge::render::esf_families::cylinder::{CylinderEdge, Material, Polarisation};
use shadowgauge::render::esf_families::quadrature::gauss_legendre;
use shadowgauge::render::esf_families::{EdgeSpread, PartiallyCoherentEdge};

type C = Complex<f64>;

const STEEL: C = C::new(2.9, 3.1);

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

// -- Airy functions and P

#[test]
fn the_airy_function_has_its_published_values_and_wronskian() {
    // DLMF 9.2.3; Abramowitz & Stegun, Table 10.11: Ai(1), Ai'(1), Ai(-10), Ai'(-10).
    for (x, value, slope) in [
        (0.0, 0.355_028_053_9, -0.258_819_403_8),
        (1.0, 0.135_292_416_3, -0.159_147_441_3),
        (-10.0, 0.040_241_23, 0.996_265_04),
    ] {
        let [a, b] = airy(C::new(x, 0.0));
        close(a.re, value, 1e-8, &format!("Ai({x})"));
        close(b.re, slope, 1e-8, &format!("Ai'({x})"));
        close(a.im.abs().max(b.im.abs()), 0.0, 1e-12, "real on the axis");
    }
    // W{Ai(z), Ai(ze^(2πi/3))} = e^(-iπ/6)/2π everywhere (DLMF 9.2.8).
    let turn = unit(2.0 * PI / 3.0);
    for i in 0..32 {
        for radius in [0.3, 3.0, 6.99, 7.01, 12.0] {
            let z = C::from_polar(radius, PI * f64::from(i) / 16.0);
            let ([a, da], [b, db]) = (airy(z), airy(z * turn));
            let found = (a * db * turn - da * b) * 2.0 * PI;
            let lost = (a * da).norm().max((b * db).norm()).max(1.0);
            close((found - unit(-PI / 6.0)).norm() / lost, 0.0, 3e-10, &format!("Wronskian at {z}"));
        }
    }
}

#[test]
fn p_is_the_same_on_every_path_and_gives_the_extinction_width() {
    // Widths of the extinction of thick cylinders, 4a[1 + .49810 (ka)^(-2/3)] with E along the axis
    // and -.43213 with H (S. I. Rubinow, T. T. Wu, J. Appl. Phys. 27 (1956) 1032): the edge lies
    // 2ℓ Re P(0) outside the limb, ℓ = (kR/2)^(1/3)/k.
    for (surface, coefficient) in [(Boundary::soft(), 0.498_10), (Boundary::hard(), -0.432_13)] {
        let p = HalfShadow::new(surface, 4.0);
        close(2.0 * p.at(0.0).re / 2f64.cbrt(), coefficient, 6e-6, "extinction");
        // The path leaves the axis elsewhere for another largest s.
        for largest in [2.0, 7.0, 12.0] {
            let other = HalfShadow::new(surface, largest);
            let worst = (-200..=200)
                .map(|i| 0.01 * f64::from(i))
                .map(|s| (p.at(s) - other.at(s)).norm())
                .fold(0.0, f64::max);
            assert!(worst < 1e-9, "{largest}: {worst:.1e}");
        }
    }
}

#[test]
fn a_film_of_the_bodys_index_and_one_of_no_thickness_change_nothing() {
    let bare =
        Surface { index: STEEL, film_um: 0.0, film_index: 1.47, roughness_um: 0.0, correlation_um: 10.0 };
    let glass = Surface { index: C::new(1.47, 0.0), ..bare };
    for along in [true, false] {
        let thin = Surface { film_um: 1e-12, ..bare }.boundary(12.0, along);
        assert!((of(thin) - of(bare.boundary(12.0, along))).norm() < 1e-9);
        let coated = Surface { film_um: 0.37, ..glass }.boundary(12.0, along);
        assert!((of(coated) - of(glass.boundary(12.0, along))).norm() < 1e-12);
        assert_eq!(of(Boundary::hard()), C::new(0.0, 0.0));
        // Roughness is seen in proportion to Rq² and moves the edge outwards.
        let rough = |rq: f64| of(Surface { roughness_um: rq, ..bare }.boundary(12.0, along)).inv();
        let smooth = of(bare.boundary(12.0, along)).inv();
        assert!((rough(0.2) - smooth - 4.0 * (rough(0.1) - smooth)).norm() < 1e-12);
        assert!(rough(0.2).re < smooth.re);
    }
}

/// g of a boundary.
fn of(boundary: Boundary) -> C {
    let [slope, value] = boundary.pair();
    value / slope
}

// -- the series of the infinite cylinder

/// The coefficients a_n about n = kR, as far as the limb at +R is seen, and what is needed to sum
/// them.
struct Series {
    k: f64,
    first: usize,
    coefficients: Vec<C>,
    /// n at R, about which phases are counted.
    centre: f64,
}

/// J_n(x) and Y_n(x) for n = 0..=last: Y upwards from Hankel's series, J downwards and scaled by
/// J_(n+1) Y_n - J_n Y_(n+1) = 2/πx.
fn bessel(x: f64, last: usize) -> (Vec<f64>, Vec<f64>) {
    // Hankel's asymptotic series (Abramowitz & Stegun 9.2.6) for orders 0 and 1; x is above 1000.
    let hankel = |order: f64| {
        let mu = 4.0 * order * order;
        let (mut term, mut p, mut q) = (1.0, 1.0, 0.0);
        for k in 1..8 {
            let k = f64::from(k);
            term *= (mu - (2.0 * k - 1.0).powi(2)) / (k * 8.0 * x);
            match k as usize % 4 {
                1 => q += term,
                2 => p -= term,
                3 => q -= term,
                _ => p += term,
            }
        }
        let (sin, cos) = (x - (0.5 * order + 0.25) * PI).sin_cos();
        (2.0 / (PI * x)).sqrt() * (p * sin + q * cos)
    };
    let mut y = vec![hankel(0.0), hankel(1.0)];
    for n in 1..=last {
        y.push(2.0 * n as f64 / x * y[n] - y[n - 1]);
    }
    let mut j = vec![0.0; last + 2];
    j[last] = 1e-30;
    for n in (1..=last).rev() {
        j[n - 1] = 2.0 * n as f64 / x * j[n] - j[n + 1];
    }
    let scale = 2.0 / (PI * x) / (j[1] * y[0] - j[0] * y[1]);
    j.iter_mut().for_each(|v| *v *= scale);
    (j, y)
}

impl Series {
    /// A body of index m (or an ideal conductor without one) of radius R µm; the coefficients taper
    /// off over `taper_um` deep in the shadow, so that the other limb is not seen.
    fn new(
        radius_um: f64,
        wavelength_um: f64,
        index: Option<C>,
        along: bool,
        taper: Option<(f64, f64)>,
    ) -> Self {
        let k = 2.0 * PI / wavelength_um;
        let x = k * radius_um;
        let last = (x + 10.0 * x.cbrt() + 30.0) as usize;
        let (j, y) = bessel(x, last + 1);
        let mut log_slope = C::new(0.0, 0.0);
        let mut coefficients = vec![C::new(0.0, 0.0); last + 1];
        for n in (0..=last).rev() {
            let order = n as f64;
            let slope = |f: &[f64]| order / x * f[n] - f[n + 1];
            let (dj, dy) = (slope(&j), slope(&y));
            let g = match index {
                // D_n = J_n'/J_n at mx from D_(n+1): J_n/J_(n+1) = (n+1)/z + D_(n+1).
                Some(m) => {
                    let z = m * x;
                    log_slope = order / z - (log_slope + (order + 1.0) / z).inv();
                    if along { m * log_slope } else { log_slope / m }
                }
                None if along => C::new(1e30, 0.0),
                None => C::new(0.0, 0.0),
            };
            let (h, dh) = (C::new(j[n], y[n]), C::new(dj, dy));
            coefficients[n] = (dj - g * j[n]) / (dh - g * h);
        }
        let mut first = 0;
        if let Some((from_um, over_um)) = taper {
            first = (x - k * from_um) as usize;
            let end = k * over_um;
            for (i, a) in coefficients[first..].iter_mut().enumerate() {
                let t = (i as f64 / end).min(1.0);
                *a *= 0.5 - 0.5 * (PI * t).cos();
            }
        }
        Self { k, first, coefficients: coefficients.split_off(first), centre: x }
    }

    /// Σ a_n e^(-i(n - kR)φ) over the n kept: a_-n = a_n, and -n belongs to the limb at +R; n of
    /// the other sign too where n = 0 is kept.
    fn scattered(&self, phi: f64) -> C {
        let sum = |turn: C| {
            let mut now = unit(turn.arg() * self.first as f64);
            self.coefficients.iter().fold(C::new(0.0, 0.0), |sum, a| {
                let term = a * now;
                now *= turn;
                sum + term
            })
        };
        let other = if self.first == 0 { sum(unit(phi)) - self.coefficients[0] } else { C::new(0.0, 0.0) };
        (sum(unit(-phi)) + other) * unit(self.centre * phi)
    }
}

/// Whether an image needs a fine sum over the source.
fn is_fine(edge: &CylinderEdge) -> bool {
    edge.na > 0.03 || edge.coherence_ratio > 0.95
}

/// Light at distances from the limb, by Abbe's sum over a round source (polar nodes) of the waves
/// of a series, for the polarisations given; y is the plane of focus towards the camera, µm.
fn imaged(series: &[Series], edge: &CylinderEdge, places: &[f64], y_um: f64) -> Vec<f64> {
    let rule = if is_fine(edge) { (28, 40) } else { (14, 24) };
    let k = series[0].k;
    let source = edge.na * edge.coherence_ratio;
    // The scattered light over the angle, on an even grid fine against its bandwidth.
    let bandwidth =
        series.iter().map(|s| s.coefficients.len() * if s.first == 0 { 2 } else { 1 }).max().unwrap_or(0)
            as f64;
    let (reach, step) = (edge.na + source + 1e-3, 0.35 / bandwidth);
    let count = (2.0 * reach / step) as usize;
    let grids: Vec<Vec<C>> =
        series.iter().map(|s| (0..count).map(|i| s.scattered(i as f64 * step - reach)).collect()).collect();
    let at = |grid: &[C], phi: f64| -> C {
        let place = (phi + reach) / step;
        let first = place as usize - 4;
        (first..first + 10)
            .map(|i| {
                let others = (first..first + 10).filter(|j| *j != i);
                grid[i] * others.map(|j| (place - j as f64) / (i as f64 - j as f64)).product::<f64>()
            })
            .sum()
    };
    let radial = gauss_legendre(rule.0);
    let along = gauss_legendre(60 + 2 * (0.3 * bandwidth * edge.na) as usize);
    let (mut light, mut passed) = (vec![0.0; places.len()], 0.0);
    let inner = source.min(edge.na);
    let rings = radial.iter().flat_map(|(u, w)| {
        // Denser towards the pupil's rim, from either side.
        let t = 0.5 * (u + 1.0);
        let outer = (inner + (source - inner) * t * t, (source - inner) * w * t);
        [(inner * t * (2.0 - t), inner * w * (1.0 - t)), outer]
    });
    for (radius, weight) in rings.filter(|r| r.1 > 0.0) {
        let weight = radius * weight;
        for j in 0..rule.1 {
            let (zeta, direct) = (PI * (j as f64 + 0.5) / rule.1 as f64).sin_cos();
            let (zeta, direct) = (radius * zeta, radius * direct);
            passed += if radius < edge.na { weight } else { 0.0 };
            if zeta >= edge.na {
                continue;
            }
            let half = (edge.na * edge.na - zeta * zeta).max(0.0).sqrt();
            for grid in &grids {
                let focus = |theta: f64| -0.5 * k * y_um * theta * theta;
                let terms: Vec<(f64, C)> = along
                    .iter()
                    .map(|(v, w)| {
                        let theta = half * v;
                        // The expansion is about R: e^(-ikR(θ - θ₀)) is taken out of the series and
                        // e^(ikx θ) counted from R.
                        let exact = series[0].centre * (theta.sin() - theta - direct.sin() + direct);
                        (theta.sin(), at(grid, theta - direct) * unit(focus(theta) + exact) * (w * half))
                    })
                    .collect();
                for (light, x) in light.iter_mut().zip(places) {
                    let scattered: C = terms.iter().map(|(sin, a)| a * unit(k * x * sin)).sum();
                    let through = if direct.abs() < half { 1.0 } else { 0.0 };
                    let u = unit(k * x * direct.sin() + focus(direct)) * through - scattered / PI;
                    *light += weight * u.norm_sqr() / grids.len() as f64;
                }
            }
        }
    }
    light.iter().map(|l| l / passed).collect()
}

#[test]
fn the_series_of_an_ideal_conductor_absorbs_nothing() {
    for along in [true, false] {
        let series = Series::new(120.0, 0.525, None, along, None);
        let (mut removed, mut scattered) = (0.0, 0.0);
        for a in &series.coefficients {
            removed += a.re;
            scattered += a.norm_sqr();
        }
        close(removed / scattered, 1.0, 1e-9, "Σ Re a = Σ |a|²");
    }
}

/// Largest difference of light to the series over ±60 µm.
fn against_series(edge: &CylinderEdge, radius_mm: f64, index: C) -> f64 {
    let places: Vec<f64> = (-12..=12).map(|i| 5.0 * f64::from(i)).collect();
    let along: &[bool] = match edge.polarisation {
        Polarisation::Unpolarised => &[true, false],
        Polarisation::AlongAxis => &[true],
        Polarisation::AcrossAxis => &[false],
    };
    // Light from the pupil's rim is seen far from the edge.
    let taper = (edge.coherence_ratio < 0.8).then_some((500.0, 300.0));
    let of = |a: &bool| Series::new(1e3 * radius_mm, 1e-3 * edge.wavelength_nm, Some(index), *a, taper);
    let series: Vec<Series> = along.iter().map(of).collect();
    let judged = imaged(&series, edge, &places, -1e3 * edge.defocus_mm);
    let table = edge.edge_spread(radius_mm, 0.0).unwrap();
    places.iter().zip(judged).map(|(x, j)| (table.value(*x) - j).abs()).fold(0.0, f64::max)
}

#[test]
fn the_limb_agrees_with_the_series_of_the_cylinder() {
    let plain = CylinderEdge::default();
    let along = CylinderEdge { polarisation: Polarisation::AlongAxis, ..plain.clone() };
    let across = CylinderEdge { polarisation: Polarisation::AcrossAxis, ..plain.clone() };
    for (diameter, edge) in [
        (2.0, plain.clone()),
        (6.0, plain.clone()),
        (18.0, along.clone()),
        (6.0, CylinderEdge { coherence_ratio: 0.74, ..across.clone() }),
        (6.0, CylinderEdge { na: 0.06, reach: 40.0, ..along.clone() }),
        (6.0, CylinderEdge { defocus_mm: 0.7, ..along.clone() }),
        (6.0, CylinderEdge { defocus_mm: -0.7, ..across.clone() }),
        (2.0, CylinderEdge { coherence_ratio: 1.0, ..along.clone() }),
        (2.0, CylinderEdge { coherence_ratio: 1.5, ..across.clone() }),
    ] {
        let worst = against_series(&edge, 0.5 * diameter, STEEL);
        let (s, na) = (edge.coherence_ratio, edge.na);
        println!("Ø{diameter} S {s} NA {na} defocus {}: {worst:.1e}", edge.defocus_mm);
        // From S = 1 on the source reaches the rim of the pupil, where the judge's own sum
        // converges slowly.
        let limit = if s < 1.0 { 3e-4 } else { 6e-4 };
        assert!(worst < limit, "Ø{diameter} {edge:?}: {worst:.1e}");
    }
}

// -- shifts

/// The shift of the limb's image outwards against the thin screen's, µm, both under the same blur:
/// least squares over ±18 µm, levels free as a gauge estimates them.
fn shift_um(limb: &EdgeSpread, screen: &EdgeSpread) -> f64 {
    let mut fit = Vector3::new(0.0, 1.0, 0.0);
    for _ in 0..12 {
        let (mut square, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for d in (-72..=72).map(|i| 0.25 * f64::from(i)) {
            let value = screen.value(d - fit[0]);
            let slopes = Vector3::new(-fit[1] * screen.slope(d - fit[0]), value, 1.0);
            square += slopes * slopes.transpose();
            right += slopes * (limb.value(d) - fit[1] * value - fit[2]);
        }
        fit += square.lu().solve(&right).unwrap();
    }
    fit[0]
}

fn shift_of(edge: &CylinderEdge, diameter_mm: f64) -> f64 {
    let screen = PartiallyCoherentEdge {
        na: edge.na,
        coherence_ratio: edge.coherence_ratio,
        wavelength_nm: edge.wavelength_nm,
        extra_sigma_um: edge.extra_sigma_um,
        ..PartiallyCoherentEdge::default()
    };
    shift_um(&edge.edge_spread(0.5 * diameter_mm, 0.0).unwrap(), &screen.edge_spread().unwrap())
}

/// Steel at 525 nm, NA .02, unpolarised, 4 µm of blur: what four methods (series, boundary integral
/// equation, half-shadow integrals, parabolic equation) agree on to .004 µm.
#[test]
fn the_edge_lies_outside_the_limb_as_far_as_four_methods_find() {
    let blurred = CylinderEdge { extra_sigma_um: 4.0, ..CylinderEdge::default() };
    for (ratio, wanted) in [
        (0.5, [0.9222, 1.1744, 1.2999, 1.3823, 1.4424, 1.5339, 1.6119]),
        (1.0, [0.8543, 1.0253, 1.0861, 1.1112, 1.1186, 1.1014, 1.0363]),
    ] {
        let edge = CylinderEdge { coherence_ratio: ratio, ..blurred.clone() };
        for (diameter, wanted) in [2.0, 6.0, 10.0, 14.0, 18.0, 27.0, 40.0].into_iter().zip(wanted) {
            let found = shift_of(&edge, diameter);
            close(found, wanted, 0.002, &format!("S {ratio} Ø{diameter}"));
        }
    }
}

// -- settings

#[test]
fn a_part_or_a_lens_that_the_family_does_not_hold_for_is_refused_with_the_reason() {
    let plain = CylinderEdge::default();
    let refused =
        |edge: &CylinderEdge, radius_mm: f64| edge.edge_spread(radius_mm, 0.0).unwrap_err().to_string();
    for (edge, radius_mm, words) in [
        (plain.clone(), 0.2, "Ø0.4000 mm: is too thin"),
        (CylinderEdge { wavelength_nm: 690.0, ..plain.clone() }, 0.26, "holds from Ø0.58 mm on"),
        (plain.clone(), f64::NAN, "too thin"),
        (CylinderEdge { na: 0.15, ..plain.clone() }, 9.0, "too thick for apertures of 0.1500"),
        (
            CylinderEdge { refractive_index: Some(1.5), extinction: Some(1e-6), ..plain.clone() },
            3.0,
            "transparent",
        ),
        (CylinderEdge { extinction: Some(3.0), ..plain.clone() }, 3.0, "needs `refractive_index`"),
        (CylinderEdge { refractive_index: Some(3.0), ..plain.clone() }, 3.0, "needs `extinction`"),
        (CylinderEdge { wavelength_nm: 850.0, ..plain.clone() }, 3.0, "400 to 700 nm"),
        (CylinderEdge { correlation_um: 1.0, ..plain.clone() }, 3.0, "correlation_um"),
        (
            CylinderEdge { refractive_index: Some(1.0), extinction: Some(0.1), ..plain.clone() },
            3.0,
            "that of air",
        ),
    ] {
        let text = refused(&edge, radius_mm);
        assert!(text.contains(words), "{text}, not {words}");
    }
    let ceramic = CylinderEdge { material: Material::Ceramic, ..plain.clone() };
    assert!(ceramic.edge_spread(3.0, 0.0).is_ok(), "ceramic scatters");
}

#[test]
fn materials_films_and_textures_move_the_edge_as_published() {
    // Against steel, NA .02, S .5, Ø18, 4 µm of blur.
    let steel = CylinderEdge { extra_sigma_um: 4.0, ..CylinderEdge::default() };
    let at = |edge: CylinderEdge| shift_of(&edge, 18.0) - shift_of(&steel, 18.0);
    for (material, wanted, tolerance) in [
        (Material::Iron, -0.008, 0.004),
        (Material::Chromium, 0.011, 0.004),
        (Material::Aluminium, 0.09, 0.01),
        (Material::Ceramic, -0.12, 0.015),
    ] {
        close(at(CylinderEdge { material, ..steel.clone() }), wanted, tolerance, &format!("{material:?}"));
    }
    // A rough surface along the light: what a parabolic equation marched past rough limbs gives.
    for (rq, wanted) in [(0.2, 0.06), (0.4, 0.24)] {
        let rough = CylinderEdge { roughness_um: rq, correlation_um: 5.0, ..steel.clone() };
        close(at(rough), wanted, 0.15 * wanted + 0.01, &format!("Rq {rq}"));
    }
    let difference = |along| {
        let edge = CylinderEdge { polarisation: along, ..steel.clone() };
        at(edge)
    };
    let (te, tm) = (difference(Polarisation::AcrossAxis), difference(Polarisation::AlongAxis));
    close(te + tm, 0.0, 0.006, "unpolarised light is their mean");
    assert!(te > 0.1, "{te}");
}

#[test]
fn polarisations_of_parallel_light_differ_by_the_extinction() {
    // NA → 0: the surface seems displaced by -(λ/2π)Re(1/g), nothing in TM and κλ/2π in TE, as long
    // as |Mg| is large.
    let limb = Limb::new(2000.0, 525.0);
    let steel =
        Surface { index: STEEL, film_um: 0.0, film_index: 1.47, roughness_um: 0.0, correlation_um: 10.0 };
    let shift = |boundary: Boundary| {
        2.0 * limb.length_um() * HalfShadow::new(boundary.scaled(limb.m), 1.0).at(0.0).re
    };
    let soft = shift(Boundary::soft());
    let [tm, te] = [true, false].map(|along| shift(steel.boundary(limb.k, along)) - soft);
    let of = |along| -(steel.boundary(limb.k, along).pair()[0]).re / limb.k;
    println!("TM {tm:.4} µm ({:.4}), TE {te:.4} µm ({:.4})", of(true), of(false));
    close(tm, of(true), 0.01, "TM");
    close(te, of(false), 0.01, "TE");
    close(of(false), 3.1 * 0.525 / (2.0 * PI), 0.01, "κλ/2π");
}

#[test]
fn focus_moves_the_limb_by_its_sign_and_less_the_wider_the_source() {
    // µm of edge a mm of the plane of focus towards the camera, template in focus, Ø18.
    for (ratio, wanted) in [(0.5, 1.8), (0.75, 0.86), (1.0, -0.16)] {
        let edge = CylinderEdge { coherence_ratio: ratio, extra_sigma_um: 4.0, ..CylinderEdge::default() };
        let at = |defocus_mm| shift_of(&CylinderEdge { defocus_mm, ..edge.clone() }, 18.0);
        close((at(-0.1) - at(0.1)) / 0.2, wanted, 0.1, &format!("S {ratio}"));
    }
}

#[test]
fn without_half_shadow_and_cubic_phase_it_is_the_thin_screen() {
    for (coherence_ratio, defocus_mm) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.7), (1.0, 0.3), (1.5, 0.0)] {
        let edge = CylinderEdge { coherence_ratio, defocus_mm, ..CylinderEdge::default() };
        let (face, screen) = (edge.face().unwrap(), edge.thin().edge_spread().unwrap());
        let worst = (-1600..=1600)
            .map(|i| 0.25 * f64::from(i))
            .map(|d| (face.value(d) - screen.value(d)).abs())
            .fold(0.0, f64::max);
        println!("S {coherence_ratio}, {defocus_mm} mm: {worst:.1e}");
        let limit = if coherence_ratio < 1.0 { 1e-4 } else { 5e-4 };
        assert!(worst < limit, "S {coherence_ratio}, {defocus_mm} mm: {worst:.1e}");
    }
}
