//! Stability limits against closed forms and published values.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use shadowgauge::control::stability::{
    Plant, Polynomial, Transfer, integral_transfer, judge, pid_transfer, stable_gains,
};
use shadowgauge::control::{OffsetForm, PidSettings};

fn pid(form: OffsetForm) -> Transfer {
    pid_transfer(&PidSettings { form, ..PidSettings::default() })
}

fn only_range(transfer: &Transfer, plant: Plant) -> (f64, f64) {
    let ranges = stable_gains(transfer, plant);
    assert_eq!(ranges.len(), 1, "{ranges:?}");
    ranges[0]
}

#[test]
fn limits_of_the_papers_gains() {
    let (kp, ki, kd) = (1.2, 0.05, 0.05);
    let constant = 2.0 / (2.0 * kp + ki + 4.0 * kd);
    let (absolute, accumulated) = (pid(OffsetForm::Absolute), pid(OffsetForm::Accumulated));
    let transfer = Plant::Transfer { alpha: 1.3566 };
    let cases = [
        ("absolute, constant", &absolute, Plant::Constant, 0.0, constant),
        ("accumulated, constant", &accumulated, Plant::Constant, 0.0, 2.0 * constant),
        ("absolute, copying", &absolute, Plant::Copying, 0.0, 0.8599),
        ("accumulated, copying", &accumulated, Plant::Copying, 0.038, 1.2028),
        ("absolute, error transfer", &absolute, transfer, 0.2971, 1.7786),
    ];
    for (name, controller, plant, low, high) in cases {
        let found = only_range(controller, plant);
        println!("{name}: {:.4} < g < {:.4} (expected {low:.4}, {high:.4})", found.0, found.1);
        assert!((found.0 - low).abs() < 1e-3 && (found.1 - high).abs() < 1e-3, "{name}: {found:?}");
    }
}

#[test]
fn run_to_run_limits_with_delay() {
    for (delay, limit) in [(0, 2.0), (1, 1.0), (2, 0.618)] {
        let weight = 1.0;
        let found = only_range(&integral_transfer(weight).delayed(delay), Plant::Constant).1;
        let closed = 2.0 * (std::f64::consts::PI / (2.0 * (2.0 * delay as f64 + 1.0))).sin();
        assert!(
            (found - limit).abs() < 1e-3 && (found - closed).abs() < 1e-6,
            "delay {delay}: {found}, {closed}"
        );
    }
}

#[test]
fn jury_and_eigenvalues_agree() {
    let mut rng = Pcg64::seed_from_u64(9);
    let (mut stable, mut unstable) = (0, 0);
    for _ in 0..2000 {
        let degree = rng.random_range(1..7);
        let roots: Vec<f64> = (0..degree).map(|_| rng.random_range(-1.3..1.3)).collect();
        let product = roots
            .iter()
            .fold(Polynomial::new([rng.random_range(0.5..3.0)]), |p, r| p.times(&Polynomial::new([-r, 1.0])));
        let largest = roots.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
        if (largest - 1.0).abs() < 1e-3 {
            continue;
        }
        let found = product.roots()[0];
        assert!((found.0.hypot(found.1) - largest).abs() < 1e-3, "{roots:?}: {found:?}");
        assert_eq!(product.jury_stable(), largest < 1.0, "{roots:?}");
        if largest < 1.0 { stable += 1 } else { unstable += 1 }
    }
    assert!(stable > 100 && unstable > 100, "{stable} {unstable}");
}

#[test]
fn the_poles_are_the_simulated_loops_rates() {
    // the linear loop written out as a state recursion; its growth over many passes is the spectral
    // radius
    for (form, gain) in
        [(OffsetForm::Absolute, 0.95), (OffsetForm::Absolute, 0.8), (OffsetForm::Accumulated, 0.95)]
    {
        let report = judge("pid", &pid(form), Plant::Copying, gain);
        let (mut e, mut last, mut sum, mut o) = (1.0_f64, 1.0, 0.0, 0.0);
        let (mut peak, mut at_100, mut at_200) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 1..=240 {
            sum += e;
            // a controller at rest starts from zero error: its first difference is e(1) itself
            let u = 1.2 * e + 0.05 * sum + 0.05 * (e - if k == 1 { 0.0 } else { last });
            o = if form == OffsetForm::Absolute { u } else { o + u };
            (last, e) = (e, (1.0 - gain) * e - gain * o + gain);
            if k < 200 {
                peak = peak.max(e.abs());
            }
            if (81..=120).contains(&k) {
                at_100 = at_100.max(e.abs());
            }
            if (181..=220).contains(&k) {
                at_200 = at_200.max(e.abs());
            }
        }
        let rate = (at_200 / at_100).powf(0.01);
        println!(
            "{form:?} g {gain}: radius {:.5}, simulated {rate:.5}, peak {peak:.4}",
            report.spectral_radius
        );
        assert!((rate - report.spectral_radius).abs() < 2e-3);
        assert_eq!(report.stable, rate < 1.0);
        assert_eq!(report.stable, report.jury_stable);
        assert_eq!(report.gain_margin.is_some(), report.stable);
        if peak < 1e3 {
            assert!((report.peak_error - peak).abs() < 1e-9 * peak);
        }
    }
}

#[test]
fn transient_growth_of_a_known_matrix() {
    // q² − .25: companion [[0, 1], [.25, 0]], whose square is .25 I: the norms are 1, .25, .25, …
    let p = Polynomial::new([-0.25, 0.0, 1.0]);
    assert!((p.transient_growth(50) - 1.0).abs() < 1e-12);
    // a Jordan block at .9 grows before it decays
    let jordan = Polynomial::new([0.81, -1.8, 1.0]);
    let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -0.81, 1.8]);
    let mut x = DVector::from_vec(vec![-1.0, 1.0]) / 2.0_f64.sqrt();
    let mut seen = 0.0_f64;
    for _ in 0..50 {
        x = &a * x;
        seen = seen.max(x.norm());
    }
    assert!(jordan.jury_stable() && jordan.transient_growth(50) >= seen && seen > 1.0);
}
