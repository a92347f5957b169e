use rand::SeedableRng;
use rand_distr::{Distribution, Normal};

use super::*;

const SD_PX: f64 = 0.03;

/// Errors over u, covered share and mean u of a form drawn `trials` times; the form is given in px.
fn over_u(columns: usize, trials: u64, form: impl Fn(f64) -> f64) -> (f64, f64, f64, f64) {
    let normal = Normal::new(0.0, SD_PX).unwrap();
    let largest = (0..columns).map(|c| form(c as f64)).fold(f64::NEG_INFINITY, f64::max);
    let (mut mean, mut square, mut covered, mut u) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..trials {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let points: Vec<(f64, f64, f64, f64)> = (0..columns)
            .map(|c| {
                let y = 400.0 + form(c as f64) + normal.sample(&mut rng);
                (c as f64, y, y, SD_PX)
            })
            .collect();
        let found = Line::new(&points).largest(0..columns, LEAST_STRETCH).unwrap();
        let error = (found.value_px - 400.0 - largest) / found.u_px;
        mean += error;
        square += error * error;
        covered += f64::from(u8::from(error.abs() <= 2.0));
        u += found.u_px;
    }
    let n = trials as f64;
    (mean / n, (square / n).sqrt(), covered / n, u / n)
}

/// The largest of many readings is biased: the value must be independent of the choice.
#[test]
fn noise_does_not_raise_the_largest_diameter_of_a_cylinder() {
    let (mean, rms, covered, u_px) = over_u(400, 200, |_| 0.0);
    assert!(mean.abs() < 0.3 && (0.6..1.15).contains(&rms) && covered >= 0.94, "{mean} {rms} {covered}");
    assert!(u_px < 0.6 * SD_PX, "{u_px}");
}

#[test]
fn a_tapers_end_a_bump_a_collar_and_waves_are_reached_within_u() {
    type Form = Box<dyn Fn(f64) -> f64>;
    let forms: [(&str, Form); 7] = [
        ("taper 1:50", Box::new(|c| 0.02 * c)),
        ("taper of a pixel", Box::new(|c| 1.0 - 0.0025 * c)),
        ("bump", Box::new(|c| 0.15 * (-0.5 * ((c - 170.0) / 12.0).powi(2)).exp())),
        ("long bump", Box::new(|c| 0.15 * (-0.5 * ((c - 170.0) / 40.0).powi(2)).exp())),
        ("collar", Box::new(|c| if (200.0..225.0).contains(&c) { 0.3 } else { 0.0 })),
        ("waves", Box::new(|c| 0.1 * (c / 9.5).sin())),
        ("long waves", Box::new(|c| 0.6 * (c / 32.0).sin())),
    ];
    let (mut squares, mut coverage) = (0.0, 0.0);
    for (name, form) in &forms {
        let (mean, rms, covered, u_px) = over_u(400, 60, form);
        println!("{name}: mean error {mean:.2} u, rms {rms:.2} u, covered {covered:.3}, u {u_px:.4} px");
        assert!(rms < 1.7 && covered > 0.84, "{name}: {mean} {rms} {covered}");
        (squares, coverage) = (squares + rms * rms / 7.0, coverage + covered / 7.0);
    }
    assert!((0.7..1.25).contains(&squares.sqrt()) && coverage >= 0.93, "{} {coverage}", squares.sqrt());
}

#[test]
fn one_speck_and_a_gap_move_nothing() {
    let point = |c: f64, y: f64| (c, y, y, 0.01);
    let points: Vec<(f64, f64, f64, f64)> = (0..300)
        .map(f64::from)
        .filter(|c| !(100.0..140.0).contains(c))
        .map(|c| point(c, 80.0 + if c == 60.0 { 9.0 } else { 0.002 * (c * 1.7).sin() }))
        .collect();
    let found = Line::new(&points).largest(0..259, LEAST_STRETCH).unwrap();
    assert!((found.value_px - 80.0).abs() < 0.004, "{found:?}");
}
