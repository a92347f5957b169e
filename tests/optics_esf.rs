//! Edge-spread families against closed forms, published values and second integrations.

#![expect(clippy::unwrap_used, reason = "tables that must exist; a test without them has failed")]

use shadowgauge::render::esf_families::fresnel_integrals::fresnel;
use shadowgauge::render::esf_families::{EdgeSpread, GaussianBlur, MeasuredEdge, Shifts};

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
