//! Edge-spread families against closed forms, published values and second integrations.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::render::esf_families::fresnel_integrals::fresnel;
use shadowgauge::render::esf_families::quadrature::gauss_legendre;
use shadowgauge::render::esf_families::{
    EdgeSpread, FocusStack, GaussianBlur, GrazingReflection, LaserShadow, MeasuredEdge,
    PartiallyCoherentEdge, Shifts,
};

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

fn gaussian(sigma_um: f64) -> EdgeSpread {
    GaussianBlur { lens_sigma_um: sigma_um, effective_na: 0.0, ..GaussianBlur::default() }
        .edge_spread()
        .unwrap()
}

// -- table

/// G(u) = u Φ(u/σ) + σ φ(u/σ), the first integral of a Gaussian edge, by libm's erf.
fn gaussian_integral(u: f64, sigma: f64) -> f64 {
    let t = u / sigma;
    let cdf = 0.5 * (1.0 + libm::erf(t / std::f64::consts::SQRT_2));
    u * cdf + sigma * (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

#[test]
fn a_gaussian_table_gives_value_integral_and_level_pixel() {
    let table = gaussian(7.0);
    assert!(table.interpolation_error() <= 1e-8, "{}", table.interpolation_error());
    for i in -400..400 {
        let d = 0.137 * f64::from(i);
        close(table.value(d), 0.5 * (1.0 + libm::erf(d / 7.0 / std::f64::consts::SQRT_2)), 2e-8, "F");
        close(table.integral(d), gaussian_integral(d, 7.0), 2e-7, "∫F");
        let pixel = (gaussian_integral(d + 5.0, 7.0) - gaussian_integral(d - 5.0, 7.0)) / 10.0;
        close(table.over_pixel(d, 10.0, 0.0), pixel, 3e-8, "level pixel");
    }
}

#[test]
fn a_sloped_pixel_equals_quadrature_over_its_area() {
    let table = gaussian(2.0);
    for (d, pixel, slope) in
        [(0.3, 5.0, 0.4), (-1.2, 5.0, 1.0), (2.0, 3.0, 1e-9), (0.7, 5.0, 1.5), (1.0, 5.0, 1e-4)]
    {
        let n = 2000;
        let at = |i: i32| pixel * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
        let (sin, cos) = f64::sin_cos(slope);
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n / 20 {
                let row = at(i);
                let column = pixel * ((f64::from(j) + 0.5) / f64::from(n / 20) - 0.5);
                sum +=
                    0.5 * (1.0 + libm::erf((d + row * cos + column * sin) / 2.0 / std::f64::consts::SQRT_2));
            }
        }
        let area = sum / f64::from(n) / f64::from(n / 20);
        close(table.over_pixel(d, pixel, slope), area, 3e-5, &format!("slope {slope}"));
        let averaged = table.averaged(pixel * cos, 1e-9).unwrap().averaged(pixel * sin, 1e-9).unwrap();
        close(averaged.value(d), table.over_pixel(d, pixel, slope), 1e-7, "two boxes folded");
    }
}

#[test]
fn a_table_says_how_well_it_interpolates_and_what_it_cut() {
    let edge = |d: f64| (0.5 + d.atan() / std::f64::consts::PI, 1.0 / (std::f64::consts::PI * (1.0 + d * d)));
    let table = EdgeSpread::tabulate(-50.0, 50.0, 1e-6, edge).unwrap();
    let worst = (-39_999..39_999).map(|i| 1e-3 * f64::from(i)).map(|d| (table.value(d) - edge(d).0).abs());
    let worst = worst.fold(0.0, f64::max);
    assert!(worst <= 1.2 * table.interpolation_error() && table.interpolation_error() <= 1e-6, "{worst}");
    close(table.truncation(), 1.0 / (40.0 * std::f64::consts::PI), 1e-5, "tail cut");
    assert_eq!((table.value(-51.0), table.value(51.0), table.value(f64::NAN)), (0.0, 1.0, 0.0));
    close(table.value(49.999), 1.0, 1e-5, "joins the light");
    let jump = |d: f64| (f64::from(u8::from(d > 0.123)), 0.0);
    let refused = EdgeSpread::tabulate(-50.0, 50.0, 1e-6, jump).unwrap_err().to_string();
    assert!(refused.contains("still errs") && refused.contains("shorten"), "{refused}");
}

#[test]
fn gaussian_terms_add_as_variances() {
    let blur = GaussianBlur { lens_sigma_um: 3.0, defocus_mm: -0.4, effective_na: 0.02, motion_um: 12.0 };
    close(blur.sigma_um(), (9.0f64 + 16.0 + 12.0).sqrt(), 1e-12, "σ");
    let bad = GaussianBlur { lens_sigma_um: f64::NAN, ..blur }.edge_spread().unwrap_err().to_string();
    assert!(bad.contains("lens_sigma_um"), "{bad}");
}

#[test]
fn spreads_are_the_means_they_stand_for() {
    let table = gaussian(5.0);
    let mean = |f: &dyn Fn(f64) -> f64| {
        (0..20_000).map(|i| f((f64::from(i) + 0.5) / 20_000.0)).sum::<f64>() / 20_000.0
    };
    let turn = std::f64::consts::TAU;
    let boxed = table.spread(&Shifts::uniform(12.0, 12), 1e-8).unwrap();
    let arcsine = table.spread(&Shifts::arcsine(9.0, 24), 1e-8).unwrap();
    let disc = table.spread(&Shifts::disc(9.0, 24), 1e-8).unwrap();
    let wide = table.spread(&Shifts::gaussian(12.0, 61), 1e-8).unwrap();
    let wider = gaussian(13.0);
    for d in [-21.0, -6.0, -0.4, 0.0, 3.0, 11.0] {
        close(boxed.value(d), mean(&|t| table.value(d - 12.0 * (t - 0.5))), 1e-7, "box");
        close(arcsine.value(d), mean(&|t| table.value(d - 9.0 * (turn * t).sin())), 1e-7, "arcsine");
        // A uniform disc: radius √t, angle from a golden-ratio sequence.
        let spiral =
            mean(&|t| table.value(d - 9.0 * t.sqrt() * (turn * t * 20_000.0 * 0.618_033_988_75).cos()));
        close(disc.value(d), spiral, 2e-4, "disc");
        close(wide.value(d), wider.value(d), 1e-7, "Gaussian on Gaussian");
    }
    close(Shifts::uniform(12.0, 8).variance_um2(), 12.0, 1e-12, "box variance");
    close(Shifts::arcsine(9.0, 8).variance_um2(), 40.5, 1e-12, "arcsine variance");
    close(Shifts::disc(9.0, 8).variance_um2(), 81.0 / 4.0, 1e-12, "disc variance");
}

// -- measured

#[test]
fn a_measured_edge_passes_through_its_samples() {
    let mut text = String::from("# knife edge, 2024\nd_um,intensity\n");
    let edge = |d: f64| 0.5 * (1.0 + libm::erf(d / 4.0 / std::f64::consts::SQRT_2));
    for i in -40..=40 {
        let d = 0.5 * f64::from(i);
        text += &format!("{d},{}\n", edge(d));
    }
    let measured = MeasuredEdge::read(text.as_bytes(), true).unwrap();
    let table = measured.edge_spread().unwrap();
    for (d, v) in measured.samples() {
        close(table.value(*d), *v, 1e-9, "sample");
    }
    assert!((-300..300).all(|i| table.value(0.05 * f64::from(i)) >= table.value(0.05 * f64::from(i - 1))));
    close(table.value(0.25), edge(0.25), 2e-3, "between samples");
    close(table.position_um(0.5).unwrap(), 0.0, 1e-6, "50 %");
}

#[test]
fn a_bad_file_is_refused_with_its_line() {
    let good: Vec<String> = (-5..=5).map(|i| format!("{i},{}", (f64::from(i) + 5.0) / 10.0)).collect();
    let with = |i: usize, line: &str| {
        let mut lines = good.clone();
        lines[i] = line.into();
        lines.join("\n")
    };
    let cases = [
        (String::new(), "8 samples"),
        (with(3, "x,0.3"), "line 4"),
        (with(3, "-2,0.3,7"), "two finite numbers"),
        (with(3, "-2,NaN"), "line 4"),
        (with(3, "-3,0.3"), "rise"),
        (with(3, "-2,0.1"), "monotone = false"),
        (with(10, "5,0.95"), "normalised"),
        (good[..4].join("\n"), "8 samples"),
        (good.iter().map(|l| format!("1{}\n", l.trim_start_matches('-'))).collect(), "rise"),
        ("d_um,intensity\n1,0\n2,0\n3,0\n4,.2\n5,.5\n6,.8\n7,1\n8,1\n".into(), "both sides"),
        (with(6, "0.0000001,0.5").replace("-5,0", "-5000,0"), "too fine"),
    ];
    for (text, wanted) in cases {
        let found = MeasuredEdge::read(text.as_bytes(), true).and_then(|m| m.edge_spread());
        let found = found.expect_err(&text).to_string();
        assert!(found.contains(wanted) && found.contains("optics.esf.measured"), "{wanted}: {found}");
    }
    let bytes: &[u8] = &[0x31, 0x2c, 0xff, 0xfe, 0x0a];
    assert!(MeasuredEdge::read(bytes, true).is_err());
    assert!(MeasuredEdge::read(with(3, "-2,0.1").as_bytes(), false).is_ok());
}

#[test]
fn an_edge_with_decimal_commas_is_the_same() {
    let rows = (-5..=5).map(|i| format!("{}.5,{}\n", i, (f64::from(i) + 5.0) / 10.0));
    let text = format!("# knife edge\nd_um,intensity\n{}", rows.collect::<String>());
    let points = MeasuredEdge::read(text.as_bytes(), true).unwrap();
    let commas = text.replace(',', ";").replace('.', ",");
    let mut wide = vec![0xfe, 0xff];
    wide.extend(commas.encode_utf16().flat_map(u16::to_be_bytes));
    let tabs = commas.replace(';', "\t").replace('\n', "\r\n").into_bytes();
    for bytes in [commas.clone().into_bytes(), tabs, wide, format!("sep=;\n{commas}").into_bytes()] {
        let shown = String::from_utf8_lossy(&bytes).into_owned();
        assert_eq!(MeasuredEdge::read(bytes.as_slice(), true).unwrap(), points, "{shown:?}");
    }
    let found = MeasuredEdge::read(commas.replace(";0,2", ";far").as_bytes(), true).unwrap_err().to_string();
    assert!(found.contains("line 5: '-3,5;far'") && found.contains("two finite numbers"), "{found}");
}

// -- Fresnel integrals

/// Abramowitz & Stegun, Table 7.7: x, C(x), S(x), seven decimals.
const TABLE_7_7: [(f64, f64, f64); 10] = [
    (0.0, 0.0, 0.0),
    (0.5, 0.492_344_2, 0.064_732_4),
    (1.0, 0.779_893_4, 0.438_259_1),
    (1.5, 0.445_261_2, 0.697_505_0),
    (2.0, 0.488_253_4, 0.343_415_7),
    (2.5, 0.457_413_0, 0.619_181_8),
    (3.0, 0.605_720_8, 0.496_313_0),
    (4.0, 0.498_426_0, 0.420_515_8),
    (4.5, 0.526_025_9, 0.434_273_0),
    (5.0, 0.563_631_2, 0.499_191_4),
];

#[test]
fn fresnel_integrals_match_abramowitz_and_stegun() {
    for (x, c, s) in TABLE_7_7 {
        let (found_c, found_s) = fresnel(x);
        close(found_c, c, 6e-8, &format!("C({x})"));
        close(found_s, s, 6e-8, &format!("S({x})"));
        assert_eq!(fresnel(-x), (-found_c, -found_s));
    }
}

#[test]
fn fresnel_integrals_match_quadrature_to_1e_10() {
    // Simpson's rule from 0, fine enough for the phase at x = 6.
    let n = 60_000;
    let h = 6.0 / f64::from(n);
    let f = |x: f64| {
        let phase = std::f64::consts::FRAC_PI_2 * x * x;
        (phase.cos(), phase.sin())
    };
    let (mut c, mut s, mut worst) = (0.0, 0.0, 0.0f64);
    for i in 0..n {
        let x = h * f64::from(i);
        let (a, m, b) = (f(x), f(x + 0.5 * h), f(x + h));
        c += h * (a.0 + 4.0 * m.0 + b.0) / 6.0;
        s += h * (a.1 + 4.0 * m.1 + b.1) / 6.0;
        let (found_c, found_s) = fresnel(x + h);
        worst = worst.max((found_c - c).abs()).max((found_s - s).abs());
    }
    assert!(worst < 1e-10, "{worst}");
    let (c, s) = fresnel(1e4);
    close((c - 0.5).hypot(s - 0.5), 1.0 / (std::f64::consts::PI * 1e4), 1e-12, "asymptote");
    assert_eq!(fresnel(f64::INFINITY), (0.5, 0.5));
}

// -- partially coherent

/// A lens with λ/NA = 1 µm, so that µm are the dimensionless units.
fn lens(coherence_ratio: f64, defocus: f64) -> EdgeSpread {
    let edge = PartiallyCoherentEdge { na: 0.5, coherence_ratio, wavelength_nm: 500.0, ..Default::default() };
    PartiallyCoherentEdge { defocus_mm: defocus * 2e-3, ..edge }.edge_spread().unwrap()
}

/// The intensity by Abbe's sum over source points: every point emits a plane wave, whose amplitude
/// behind the lens is an integral over the pupil with the pole of the edge's spectrum subtracted.
/// Only the Gauss-Legendre nodes are common with the table.
fn abbe(x: f64, ratio: f64, defocus: f64) -> f64 {
    const ANGLES: usize = 48;
    let radial = gauss_legendre(32);
    let along = gauss_legendre(96);
    let pi = std::f64::consts::PI;
    let wave = |g: f64| (pi * (2.0 * g * x - defocus * g * g)).sin_cos();
    let (mut light, mut passed) = (0.0, 0.0);
    for (from, to) in [(0.0, ratio.min(1.0)), (1.0, ratio.max(1.0))] {
        for (u, w) in radial.iter().filter(|_| to > from) {
            let t = 0.5 * (u + 1.0);
            let radius = from + (to - from) * t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            let weight = radius * (to - from) * 0.5 * w * 30.0 * (t * (1.0 - t)).powi(2);
            for j in 0..ANGLES {
                let (eta, xi) = (pi * (j as f64 + 0.5) / ANGLES as f64).sin_cos();
                let (eta, xi) = (radius * eta, radius * xi);
                if radius < 1.0 {
                    passed += weight;
                }
                if eta.abs() >= 1.0 {
                    continue;
                }
                let a = (1.0 - eta * eta).sqrt();
                let (s0, c0) = wave(xi);
                let pole = ((a - xi) / (a + xi)).abs().ln();
                let (mut re, mut im) = (c0 * pole, s0 * pole);
                for (v, w) in &along {
                    let (s, c) = wave(a * v);
                    re += a * w * (c - c0) / (a * v - xi);
                    im += a * w * (s - s0) / (a * v - xi);
                }
                let direct = if xi.abs() < a { 0.5 } else { 0.0 };
                let (re, im) = (direct * c0 + im / (2.0 * pi), direct * s0 - re / (2.0 * pi));
                light += weight * (re * re + im * im);
            }
        }
    }
    light / passed
}

#[test]
fn the_cross_coefficient_agrees_with_abbes_sum() {
    let mut worst = 0.0f64;
    for (ratio, defocus) in [
        (0.3, 0.0),
        (0.5, 0.0),
        (0.5, 2.0),
        (0.75, 0.5),
        (1.0, 0.0),
        (1.0, 1.0),
        (1.5, 0.0),
        (1.5, 0.7),
        (3.0, 0.0),
    ] {
        let table = lens(ratio, defocus);
        for x in [-2.3, -1.0, -0.4, -0.1, 0.0, 0.07, 0.24, 0.5, 0.9, 1.7, 3.1] {
            let difference = (table.value(x) - abbe(x, ratio, defocus)).abs();
            worst = worst.max(difference);
            assert!(
                difference < 5e-4,
                "S = {ratio}, z = {defocus}, x = {x}: {} Abbe {}",
                table.value(x),
                abbe(x, ratio, defocus)
            );
        }
    }
    println!("largest difference to Abbe's sum {worst:.1e}");
}

#[test]
fn the_true_edge_and_the_half_light_point_lie_where_published() {
    for (ratio, edge, half) in
        [(0.0, 0.250, 0.106), (0.5, 0.2573, 0.108), (1.0, 1.0 / 3.0, 0.0935), (1.5, 0.4334, 0.039)]
    {
        let table = lens(ratio, 0.0);
        close(table.value(0.0), edge, 5e-5, &format!("light at the edge, S = {ratio}"));
        close(table.position_um(0.5).unwrap(), half, 5e-4, &format!("50 % point, S = {ratio}"));
        let width = table.width_10_90_um().unwrap();
        assert!((0.35..0.665).contains(&width), "10-90 % at S = {ratio}: {width}");
    }
    // NA .02 and 525 nm: diameters read 5.6, 4.9 and 2.0 µm large at S ≤ .75, 1 and 1.5.
    for (ratio, error_um) in [(0.5, 5.6), (0.75, 5.7), (1.0, 4.9), (1.5, 2.0)] {
        let edge =
            PartiallyCoherentEdge { coherence_ratio: ratio, ..Default::default() }.edge_spread().unwrap();
        close(2.0 * edge.position_um(0.5).unwrap(), error_um, 0.12, &format!("diameter error, S = {ratio}"));
    }
}

#[test]
fn defocus_moves_the_half_light_point_below_s_of_one_only() {
    let half = |ratio, defocus| lens(ratio, defocus).position_um(0.5).unwrap();
    close(half(0.5, 1.0), 0.159, 2e-3, "S = .5, z = 1");
    close(half(0.5, 2.0), 0.240, 4e-3, "S = .5, z = 2");
    close(half(1.5, 2.0), half(1.5, 0.0), 2e-3, "S = 1.5 hardly moves");
    let mirrored = PartiallyCoherentEdge { defocus_mm: -1.0, ..Default::default() };
    let plain = PartiallyCoherentEdge { defocus_mm: 1.0, ..Default::default() };
    assert_eq!(mirrored.edge_spread().unwrap(), plain.edge_spread().unwrap());
}

/// Struve's function H1 by its power series (Abramowitz & Stegun 12.1.3), accurate to 1e-8 up
/// to 20.
fn struve_1(z: f64) -> f64 {
    let half = 0.25 * z * z;
    let mut term = half / (libm::tgamma(1.5) * libm::tgamma(2.5));
    let mut sum = 0.0;
    for k in 0..80 {
        sum += term;
        let k = f64::from(k);
        term *= -half / ((k + 1.5) * (k + 2.5));
    }
    sum
}

#[test]
fn the_limits_in_s_are_the_closed_forms() {
    // Incoherent: the line spread of a circular pupil is 2 H1(2v)/v², v = 2πx (λ/NA); Simpson's
    // rule from the edge.
    let spread = |x: f64| {
        let v = std::f64::consts::TAU * x;
        if v < 1e-3 { 16.0 / (3.0 * std::f64::consts::PI) } else { 2.0 * struve_1(2.0 * v) / (v * v) }
    };
    let incoherent = lens(1e5, 0.0);
    let h = 0.005;
    let mut wanted = 0.5;
    for i in 0..250 {
        let x = h * f64::from(i);
        close(incoherent.value(x), wanted, 2e-5, &format!("incoherent at {x}"));
        close(incoherent.value(-x), 1.0 - wanted, 2e-5, "and mirrored");
        wanted += h * (spread(x) + 4.0 * spread(x + 0.5 * h) + spread(x + h)) / 6.0;
    }
    // The general method converges to both limits.
    let (wide, narrow, coherent) = (lens(100.0, 0.4), lens(0.01, 0.4), lens(0.0, 0.4));
    let unfocused = lens(1e5, 0.4);
    for x in [-1.3, -0.2, 0.0, 0.3, 0.8, 2.0] {
        close(wide.value(x), unfocused.value(x), 1e-3, "S = 100");
        close(narrow.value(x), coherent.value(x), 1e-3, "S = .01");
    }
    // Coherent in focus: (½ + Si(2πx)/π)², Si(2π) = 1.41815157613, Si(π) = 1.85193705198 (A&S
    // Table 5.3).
    let sharp = lens(0.0, 0.0);
    for (x, si) in [(1.0, 1.418_151_576_13), (0.5, 1.851_937_051_98)] {
        close(sharp.value(x), (0.5f64 + si / std::f64::consts::PI).powi(2), 2e-6, "coherent");
    }
}

#[test]
fn a_lens_out_of_range_is_refused_by_its_key() {
    let refused = |edge: PartiallyCoherentEdge| edge.edge_spread().unwrap_err().to_string();
    let cases = [
        (refused(PartiallyCoherentEdge { na: 0.0, ..Default::default() }), "numerical_aperture"),
        (refused(PartiallyCoherentEdge { coherence_ratio: -1.0, ..Default::default() }), "coherence_ratio"),
        (refused(PartiallyCoherentEdge { defocus_mm: 1e3, ..Default::default() }), "defocus_mm"),
        (
            refused(PartiallyCoherentEdge { wavelength_nm: f64::INFINITY, ..Default::default() }),
            "wavelength_nm",
        ),
    ];
    for (text, key) in cases {
        assert!(text.contains(&format!("optics.esf.partially_coherent.{key} = ")), "{text}");
    }
    let blurred = PartiallyCoherentEdge { extra_sigma_um: 40.0, ..Default::default() }.edge_spread().unwrap();
    let width = blurred.width_10_90_um().unwrap();
    close(width, 2.563 * 40.0, 2.0, "10-90 % of a blur that dominates");
}

// -- laser shadow

/// Monochromatic light from a point source with √(λz/2) = 1 µm.
fn laser() -> LaserShadow {
    LaserShadow {
        wavelength_nm: 1000.0,
        bandwidth_nm: 0.0,
        distance_mm: 2e-3,
        source_half_angle_mrad: 0.0,
        reach: 40.0,
    }
}

#[test]
fn the_laser_edge_matches_tabulated_integrals() {
    let table = laser().edge_spread().unwrap();
    close(table.value(0.0), 0.25, 1e-6, "true edge");
    close(table.position_um(0.5).unwrap(), 0.354, 5e-4, "50 % point");
    for (x, c, s) in TABLE_7_7 {
        let light = 0.5 * ((0.5f64 + c).powi(2) + (0.5f64 + s).powi(2));
        let shadow = 0.5 * ((0.5f64 - c).powi(2) + (0.5f64 - s).powi(2));
        close(table.value(x), light, 1e-5, &format!("light at v = {x}"));
        close(table.value(-x), shadow, 1e-5, &format!("shadow at v = -{x}"));
    }
    // First maximum 1.3704 at v = 1.2172, first minimum .7782 at 1.8725 (Born & Wolf, 8.7.3).
    close(table.value(1.2172), 1.3704, 1e-4, "first ring");
    close(table.value(1.8725), 0.7782, 1e-4, "first gap");
}

#[test]
fn a_line_and_a_source_of_finite_width_wash_the_rings_out() {
    let broad = LaserShadow { bandwidth_nm: 30.0, ..laser() };
    let table = broad.edge_spread().unwrap();
    // The same by brute force: 4001 colours over ±6 σ.
    let sigma = 30.0 / 2.354_820_045 / 1000.0;
    for v in [-1.0, 0.0, 0.354, 1.2172, 3.0, 6.1, 9.9, 20.0] {
        let (mut light, mut sum) = (0.0, 0.0);
        for i in -2000..=2000 {
            let u = f64::from(i) * 3e-3;
            let (c, s) = fresnel(v / (1.0 + sigma * u).sqrt());
            let w = (-0.5 * u * u).exp();
            light += w * 0.5 * ((0.5 + c).powi(2) + (0.5 + s).powi(2));
            sum += w;
        }
        close(table.value(v), light / sum, 1e-5, &format!("line at v = {v}"));
    }
    let rings = |t: &EdgeSpread| {
        (0..400).map(|i| (t.value(20.0 + 0.01 * f64::from(i)) - 1.0).abs()).fold(0.0, f64::max)
    };
    assert!(rings(&table) < 1e-3 && rings(&laser().edge_spread().unwrap()) > 0.015);
    let wide = LaserShadow { source_half_angle_mrad: 500.0 / 2.0 * 0.4, ..laser() }.edge_spread().unwrap();
    // Source of radius .2 µm in units of 1 µm: rings with a smaller period vanish, the edge
    // remains.
    close(
        wide.value(0.0),
        laser().edge_spread().unwrap().spread(&Shifts::disc(0.2, 64), 1e-6).unwrap().value(0.0),
        1e-5,
        "disc",
    );
    assert!(rings(&wide) < 0.5 * rings(&laser().edge_spread().unwrap()));
}

#[test]
fn a_wire_throws_babinets_pattern() {
    let wire = |d, x| laser().wire(d, x).unwrap();
    let table = laser().edge_spread().unwrap();
    close(wire(0.0, 0.3), 1.0, 1e-12, "no wire");
    assert!(wire(3.0, 0.0) > 0.01, "a bright line stands in the middle of the shadow: {}", wire(3.0, 0.0));
    close(wire(3.0, 0.7), wire(3.0, -0.7), 1e-12, "symmetry");
    // A thick one is two edges.
    close(wire(60.0, 31.0), table.value(1.0), 0.02, "edge of a thick wire");
}

// -- grazing reflection

/// Light at height x by tracing rays through a circular pupil, backwards, with vectors:
/// intersection with the cylinder, reflection, and whether the ray leaves within the source's cone.
fn traced(r: &GrazingReflection, radius: f64, x: f64, mirror: f64) -> f64 {
    let (theta, na) = (r.source_half_angle_deg.to_radians(), r.acceptance_half_angle_deg.to_radians());
    let lit = na.min(theta);
    let n = if na == 0.0 { 1 } else { 240 };
    let (mut light, mut rays) = (0.0, 0.0);
    for i in 0..n {
        for j in 0..n {
            let at =
                |k: i32| if n == 1 { 0.0 } else { lit * ((f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0) };
            let (alpha, zeta) = (at(i), at(j));
            if alpha.hypot(zeta) > lit {
                continue;
            }
            rays += 1.0;
            // Travel direction (height, towards the camera, along the axis), through (x, 0, 0).
            let d = [alpha.sin() * zeta.cos(), alpha.cos() * zeta.cos(), zeta.sin()];
            let (a, b, c) = (d[0] * d[0] + d[1] * d[1], x * d[0], x * x - radius * radius);
            let root = b * b - a * c;
            let (height, source) = if root < 0.0 {
                (1.0, d)
            } else {
                let t = (-b + root.sqrt()) / a;
                let normal = [(x + t * d[0]) / radius, t * d[1] / radius];
                let along = d[0] * normal[0] + d[1] * normal[1];
                (mirror, [d[0] - 2.0 * along * normal[0], d[1] - 2.0 * along * normal[1], d[2]])
            };
            let angle = source[0].hypot(source[2]).atan2(source[1]);
            if angle <= theta * (1.0 + 1e-12) {
                light += height;
            }
        }
    }
    light / rays
}

#[test]
fn the_lit_strip_is_as_wide_as_the_formula_says() {
    let light = |theta, d_um: f64| {
        let r = GrazingReflection { source_half_angle_deg: theta, ..Default::default() };
        r.light(10.0, 10.0 - d_um * 1e-3).unwrap()
    };
    for (theta, strip_of_diameter) in [(5.0, 19.0), (1.0, 0.76)] {
        let half = 0.5 * strip_of_diameter;
        assert!(light(theta, 0.99 * half) > 0.3 && light(theta, 1.01 * half) == 0.0, "{theta}°");
        let r = GrazingReflection { source_half_angle_deg: theta, ..Default::default() };
        close(2.0 * r.strip_um(10.0, 0.0), strip_of_diameter, 0.05, "Dθ²/8");
        close(2.0 * r.strip_um(10.0, theta / 3.0), strip_of_diameter * 8.0 / 6.0, 0.07, "Dθ²/6");
        assert!(
            (0..100)
                .all(|i| r.strip_um(10.0, theta * f64::from(i) / 100.0)
                    <= r.strip_um(10.0, theta / 3.0) + 1e-12)
        );
    }
}

#[test]
fn traced_rays_give_the_same_light() {
    for (theta, na) in [(5.0, 0.0), (5.0, 1.2), (5.0, 5.0), (2.0, 4.0), (1.0, 1.0)] {
        // k → ∞ reflects everything.
        let r = GrazingReflection {
            source_half_angle_deg: theta,
            acceptance_half_angle_deg: na,
            polished_share: 0.8,
            refractive_index: 0.05,
            extinction: 20.0,
        };
        let strip = 10.0 * f64::to_radians(theta).powi(2);
        for share in [-0.2, -0.164, -0.13, -0.11, -0.06, -0.02, -0.003, 0.003, 0.1, 0.3] {
            let x = 10.0 + share * strip;
            let tolerance = if na == 0.0 { 2e-3 } else { 0.012 };
            close(
                r.light(10.0, x).unwrap(),
                traced(&r, 10.0, x, 0.8),
                tolerance,
                &format!("θ {theta} NA {na} at {share}"),
            );
        }
    }
}

#[test]
fn reflection_makes_a_polished_pin_read_small() {
    let edge = gaussian(18.0);
    let seen = |share| {
        let r = GrazingReflection { source_half_angle_deg: 5.0, polished_share: share, ..Default::default() };
        let table = r.edge_spread(&edge, 10.0).unwrap();
        let shifts = r.shifts(10.0).unwrap();
        (table.position_um(0.5).unwrap(), shifts.mean_um())
    };
    let (matt, polished) = (seen(0.0), seen(1.0));
    close(matt.0, 0.0, 1e-3, "matt");
    assert!(polished.0 < -6.0 && polished.0 > -9.6, "polished: {}", polished.0);
    close(polished.0, polished.1, 0.8, "wide blur sees the mean shift");
    let r = GrazingReflection { polished_share: 1.0, ..Default::default() };
    close(r.reflectance(0.0), 1.0, 1e-9, "grazing");
    // Normal incidence: ((n-1)² + k²)/((n+1)² + k²).
    let normal = (1.9f64.powi(2) + 3.1f64.powi(2)) / (3.9f64.powi(2) + 3.1f64.powi(2));
    close(r.reflectance(std::f64::consts::FRAC_PI_2), normal, 1e-9, "normal incidence");
}

// -- what the renderer takes

#[test]
fn sharpness_is_the_sigma_of_a_gaussian() {
    close(gaussian(18.0).sharpness_um() / 15.0, 1.2, 0.01, "σ");
    assert!(lens(0.0, 0.0).sharpness_um() < lens(1.0, 0.0).sharpness_um() + 0.2);
}

#[test]
fn a_stack_follows_the_focus() {
    let edge = PartiallyCoherentEdge::default();
    let stack = FocusStack::new(&edge, 1.0, 1e-3).unwrap();
    println!("{} tables to 1 mm, blend error {:.1e}", stack.tables().len(), stack.blend_error());
    for defocus_mm in [0.0, -0.11, 0.37, -0.8, 1.0] {
        let exact = PartiallyCoherentEdge { defocus_mm, ..edge.clone() }.edge_spread().unwrap();
        for d in [-40.0, -5.0, 0.0, 3.0, 17.0, 60.0] {
            let blended = stack.value(d, defocus_mm);
            close(blended, exact.value(d), 1.1e-3, &format!("{d} µm, {defocus_mm} mm"));
        }
    }
    assert_eq!(stack.place(7.0), (stack.tables().len() - 2, 1.0));
    let text = FocusStack::new(&edge, -1.0, 1e-3).unwrap_err().to_string();
    assert!(text.contains("depth_mm"), "{text}");
}

/// A LED's band is the mean of its wavelengths: five of Gauss and Hermite against 121 even ones.
#[test]
fn a_led_is_the_mean_of_its_wavelengths() {
    let led = PartiallyCoherentEdge { bandwidth_nm: 40.0, ..Default::default() };
    let table = led.edge_spread().unwrap();
    let sigma = 40.0 / 2.354_82;
    let places = (-12..=12).map(|k| 0.25 * f64::from(k));
    let weighted: Vec<(EdgeSpread, f64)> = places
        .map(|x: f64| {
            let wavelength_nm = 525.0 + x * sigma;
            let edge = PartiallyCoherentEdge { wavelength_nm, bandwidth_nm: 0.0, ..led.clone() };
            (edge.edge_spread().unwrap(), (-0.5 * x * x).exp())
        })
        .collect();
    let total: f64 = weighted.iter().map(|w| w.1).sum();
    let narrow = PartiallyCoherentEdge::default().edge_spread().unwrap();
    let mut moved: f64 = 0.0;
    for d in (-40..=60).map(|k| 2.0 * f64::from(k)) {
        let mean = weighted.iter().map(|(edge, w)| w * edge.value(d)).sum::<f64>() / total;
        assert!((table.value(d) - mean).abs() < 1e-4, "{d}: {} {mean}", table.value(d));
        moved = moved.max((table.value(d) - narrow.value(d)).abs());
    }
    assert!((1e-4..0.02).contains(&moved), "{moved}");
}
