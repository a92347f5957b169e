//! Separations of spindle and form, without noise and with, and what multi-step cannot separate.

use std::f64::consts::TAU;

use super::Draws;
use crate::machine::spindle::{donaldson, multi_step, rechucked, three_probe, three_probe_weights};

const N: usize = 360;

/// Cosines of orders, amplitudes and phases over a turn.
fn waves(terms: &[(usize, f64, f64)]) -> Vec<f64> {
    let at = |i: usize| TAU * i as f64 / N as f64;
    let sum = |i: usize| terms.iter().map(|(k, a, phase)| a * (*k as f64 * at(i) + phase).cos()).sum();
    (0..N).map(sum).collect()
}

fn added(a: &[f64], b: &[f64], sign: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + sign * b).collect()
}

/// The values of a turn begun `by` readings later.
fn begun(values: &[f64], by: usize) -> Vec<f64> {
    (0..N).map(|i| values[(i + by) % N]).collect()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

fn form() -> Vec<f64> {
    waves(&[(0, 0.3, 0.0), (2, 1.0, 0.4), (3, 0.5, 1.0), (5, 0.2, 2.0), (8, 0.1, 0.1)])
}

fn motion() -> Vec<f64> {
    waves(&[(2, 0.4, 1.4), (3, 0.3, -1.0), (7, 0.2, 0.3), (12, 0.05, 0.0)])
}

#[test]
fn reversal_separates_every_order() {
    let (p, s) = (form(), motion());
    let found = donaldson(&added(&p, &s, 1.0), &added(&p, &s, -1.0)).unwrap();
    assert!(rms(&found.form, &p) < 1e-12 && rms(&found.motion, &s) < 1e-12);
    assert!(donaldson(&p, &s[1..]).is_none() && donaldson(&[], &[]).is_none());
}

#[test]
fn a_head_of_two_edges_separates_the_odd_form() {
    // Both edges of the silhouette of small lobes: the upper at the angle, the lower half a turn
    // on.
    let (p, s) = (form(), motion());
    let midline = |p: &[f64]| -> Vec<f64> {
        let lower = begun(p, N / 2);
        (0..N).map(|i| 0.5 * ((s[i] + p[i]) + (s[i] - lower[i]))).collect()
    };
    let found = rechucked(&midline(&p), &midline(&begun(&p, N / 2))).unwrap();
    assert!(rms(&found.motion, &s) < 1e-12, "{}", rms(&found.motion, &s));
    let odd = waves(&[(3, 0.5, 1.0), (5, 0.2, 2.0)]);
    assert!(rms(&found.form, &odd) < 1e-12, "{}", rms(&found.form, &odd));
}

#[test]
fn steps_leave_the_multiples_of_their_number() {
    let (p, s) = (form(), motion());
    for steps in [3, 4, 5, 6, 8, 10, 12] {
        let row = |j: usize| added(&begun(&p, j * N / steps), &s, 1.0);
        let rows: Vec<Vec<f64>> = (0..steps).map(row).collect();
        let found = multi_step(&rows).unwrap();
        let stays = |terms: &[(usize, f64, f64)]| {
            waves(&terms.iter().copied().filter(|(k, _, _)| *k > 0 && k % steps == 0).collect::<Vec<_>>())
        };
        let of_p = stays(&[(3, 0.5, 1.0), (5, 0.2, 2.0), (8, 0.1, 0.1)]);
        let of_s = stays(&[(3, 0.3, -1.0), (12, 0.05, 0.0)]);
        assert!(rms(&found.motion, &added(&s, &of_p, 1.0)) < 1e-12, "{steps} steps, motion");
        assert!(rms(&found.form, &added(&p, &of_s, 1.0)) < 1e-12, "{steps} steps, form");
    }
    assert!(multi_step(std::slice::from_ref(&p)).is_none(), "one row");
    assert!(multi_step(&vec![p.clone(); 7]).is_none(), "360 readings are no seven equal parts");
    assert!(multi_step(&[p.clone(), p[1..].to_vec()]).is_none());
}

/// Normal numbers of unit variance: the sum of twelve uniform ones.
fn noise(draws: &mut Draws, count: usize) -> Vec<f64> {
    (0..count).map(|_| (0..12).map(|_| 0.5 * draws.next()).sum()).collect()
}

#[test]
fn noise_falls_as_stated() {
    let mut draws = Draws(17);
    let (mut reversal, mut head, mut step) = ([0.0; 2], 0.0, 0.0);
    const TURNS: usize = 40;
    let zero = vec![0.0; N];
    let square = |values: &[f64]| rms(values, &zero).powi(2) / TURNS as f64;
    for _ in 0..TURNS {
        let found = donaldson(&noise(&mut draws, N), &noise(&mut draws, N)).unwrap();
        reversal[0] += square(&found.form);
        reversal[1] += square(&found.motion);
        let midline = |draws: &mut Draws| {
            let (top, bottom) = (noise(draws, N), noise(draws, N));
            added(&top, &bottom, 1.0).iter().map(|v| 0.5 * v).collect::<Vec<_>>()
        };
        head += square(&rechucked(&midline(&mut draws), &midline(&mut draws)).unwrap().motion);
        let rows: Vec<Vec<f64>> = (0..9).map(|_| noise(&mut draws, N)).collect();
        step += square(&multi_step(&rows).unwrap().motion);
    }
    for (found, right, what) in [
        (reversal[0].sqrt(), 0.5_f64.sqrt(), "reversal, form"),
        (reversal[1].sqrt(), 0.5_f64.sqrt(), "reversal, motion"),
        (head.sqrt(), 0.5, "re-chucked, motion"),
        (step.sqrt(), 1.0 / 3.0, "nine steps, motion"),
    ] {
        assert!((found / right - 1.0).abs() < 0.05, "{what}: {found}, not {right}");
    }
}

/// Readings of a probe some readings round the part: the form that passes it, the axis towards it.
fn probe_at(steps: usize, [form, s_x, s_y]: [&[f64]; 3]) -> Vec<f64> {
    let alpha = TAU * steps as f64 / N as f64;
    let passing = begun(form, steps);
    (0..N).map(|i| passing[i] + s_x[i] * alpha.cos() + s_y[i] * alpha.sin()).collect()
}

#[test]
fn three_probes_separate_all_orders_with_a_weight_and_name_the_others() {
    let (p, s_x) = (form(), waves(&[(1, 0.3, 0.2), (2, 0.4, 1.4), (3, 0.3, -1.0), (7, 0.2, 0.3)]));
    let s_y = waves(&[(1, 0.2, 0.9), (2, 0.1, 0.4), (4, 0.3, -1.0)]);
    let turns = |steps: [usize; 2]| [0, steps[0], steps[1]].map(|step| probe_at(step, [&p, &s_x, &s_y]));
    let steps = [47, 146];
    let [a, b, c] = turns(steps);
    let found = three_probe([&a, &b, &c], steps).unwrap();
    assert!(rms(&found.separation.form, &p) < 1e-10, "{}", rms(&found.separation.form, &p));
    assert!(rms(&found.separation.motion, &s_x) < 1e-10, "{}", rms(&found.separation.motion, &s_x));
    assert_eq!(found.hidden, [1]);
    // thirds of a turn: 1 + e^{in120°} + e^{in240°} is zero but for multiples of 3
    let steps = [120, 240];
    let [a, b, c] = turns(steps);
    let found = three_probe([&a, &b, &c], steps).unwrap();
    assert!(found.hidden.contains(&2) && found.hidden.contains(&8) && !found.hidden.contains(&3));
    assert!((three_probe_weights(steps, N, 3).unwrap() - 3.0).abs() < 1e-12);
    assert!(three_probe_weights(steps, N, 2).unwrap() < 1e-12);
    let held = waves(&[(0, 0.3, 0.0), (3, 0.5, 1.0)]);
    assert!(rms(&found.separation.form, &held) < 1e-10, "{}", rms(&found.separation.form, &held));
    // in line, of different length
    assert!(three_probe([&a, &b, &c], [0, 180]).is_none());
    assert!(three_probe([&a, &b, &c[1..]], steps).is_none());
}
