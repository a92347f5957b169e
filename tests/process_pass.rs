//! The turning pass: error copying, repeatability, the surface it leaves.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan};
use shadowgauge::process::{BaseForm, PowerLaw, ProcessError, ProcessSettings, Stock, TurningProcess};

const STOCK: Stock = Stock { diameter_mm: 27.0, length_mm: 500.0 };
const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

fn plan(pass: u32, nominal_mm: f64, o_mm: Vec<f64>) -> PassPlan {
    let station_z_mm = (0..100).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    PassPlan { pass, nominal_mm, cutting: CUTTING, station_z_mm, offset: DiameterOffset { o_mm } }
}

fn process(settings: &ProcessSettings, seed: u64) -> TurningProcess {
    TurningProcess::new(settings, STOCK, &BaseForm::default(), seed).unwrap()
}

fn errors_um(process: &TurningProcess, nominal: f64) -> Vec<f64> {
    process.diameter_mm().iter().map(|d| (d - nominal) * 1e3).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Mean error of every station (middles at 2.5, 7.5 … mm) from nodes 1 mm apart.
fn stations(errors: &[f64]) -> Vec<f64> {
    (0..100).map(|i| 0.5 * (errors[5 * i + 2] + errors[5 * i + 3])).collect()
}

#[test]
fn errors_grow_without_control() {
    let mut process = process(&ProcessSettings::default(), 1);
    // An independent prototype, with a coarser account of the half-cut shaft.
    let expected = [42.7, 49.1, 53.0, 57.1];
    for (pass, expected) in (1..).zip(expected) {
        let nominal = 27.0 - 0.5 * f64::from(pass);
        process.cut(&plan(pass, nominal, vec![0.0; 100])).unwrap();
        let found = largest(&errors_um(&process, nominal));
        assert!((found - expected).abs() < 0.015 * expected, "pass {pass}: {found} against {expected}");
    }
}

#[test]
fn the_papers_gains_accumulated_hold_the_next_passes() {
    let mut process = process(&ProcessSettings::default(), 1);
    let (mut sum, mut last, mut offset) = (vec![0.0; 100], vec![0.0; 100], vec![0.0; 100]);
    for pass in 1..=4 {
        let nominal = 27.0 - 0.5 * f64::from(pass);
        process.cut(&plan(pass, nominal, offset.clone())).unwrap();
        let errors = errors_um(&process, nominal);
        for (i, e) in stations(&errors).iter().enumerate() {
            sum[i] += e;
            let difference = if pass == 1 { 0.0 } else { e - last[i] };
            offset[i] += 1e-3 * (1.2 * e + 0.05 * sum[i] + 0.05 * difference);
            last[i] = *e;
        }
        assert!(pass == 1 || largest(&errors) < 3.0, "pass {pass}: {}", largest(&errors));
    }
}

/// D = b + 2·w·F((D_before - D)/2), from the process' own answer: w is the only unknown, and must be the same for
/// two different commands at the same half-cut shaft.
#[test]
fn the_depth_solves_its_equation() {
    let law = PowerLaw::default().at(&CUTTING);
    for set in [1e-6, 1e-3, 0.05, 0.25, 1.0] {
        for compliance in [0.0, 1e-6, 2e-4, 1e-2] {
            let depth = law.depth_mm(set, compliance);
            let residual = depth + compliance * law.force_n(depth) - set;
            assert!(residual.abs() <= 1e-12, "{set} {compliance}: {residual:e}");
        }
    }
    assert_eq!(law.depth_mm(-0.1, 1e-4), 0.0);
}

#[test]
fn pass_one_is_the_same_whatever_follows_and_seeds_differ() {
    let settings = ProcessSettings::default();
    let first = |seed| process(&settings, seed).cut(&plan(1, 26.5, vec![0.0; 100])).unwrap();
    assert_eq!(first(7), first(7));
    assert_ne!(first(7).texture, first(8).texture);
    let second = |o: f64| {
        let mut process = process(&settings, 7);
        process.cut(&plan(1, 26.5, vec![0.0; 100])).unwrap();
        process.cut(&plan(2, 26.0, vec![o; 100])).unwrap()
    };
    let (plain, corrected) = (second(0.0), second(0.05));
    assert_eq!((plain.texture, plain.lobes), (corrected.texture, corrected.lobes));
    assert_ne!(plain.profile, corrected.profile);
}

#[test]
fn the_texture_has_its_rms_and_correlation() {
    let settings = ProcessSettings::default();
    let texture = process(&settings, 3).cut(&plan(1, 26.5, vec![0.0; 100])).unwrap().texture.unwrap();
    let n = texture.nodes_theta;
    let h: Vec<f64> = texture.height_mm.iter().map(|h| f64::from(*h) * 1e3).collect();
    let mean_of = |products: &mut dyn Iterator<Item = f64>| {
        let (mut sum, mut count) = (0.0, 0.0);
        for p in products {
            sum += p;
            count += 1.0;
        }
        sum / count
    };
    let variance = mean_of(&mut h.iter().map(|v| v * v));
    assert!((variance.sqrt() - 0.35).abs() < 0.01, "rms {}", variance.sqrt());
    let lag = (1.5 / texture.step_mm).round();
    let along = mean_of(&mut h.iter().zip(&h[n * lag as usize..]).map(|(a, b)| a * b)) / variance;
    let expected = (-(lag * texture.step_mm / 1.5).powi(2)).exp();
    assert!((along - expected).abs() < 0.03, "correlation {along} against {expected}");
    assert!(texture.step_mm <= 0.75 && 360.0 / n as f64 <= 1.5);
    assert!(texture.height_mm.len() * 4 < 4_000_000);
}

#[test]
fn rubbing_is_refused_and_leaves_the_workpiece_alone() {
    let mut process = process(&ProcessSettings::default(), 1);
    let refused = process.cut(&plan(1, 26.95, vec![0.0; 100]));
    assert!(matches!(refused, Err(ProcessError::BelowMinimumChip { pass: 1, .. })), "{refused:?}");
    assert!(process.diameter_mm().iter().all(|d| *d == 27.0));
    let crooked = process.cut(&plan(1, 26.5, vec![0.0; 99]));
    assert!(matches!(crooked, Err(ProcessError::Plan { .. })), "{crooked:?}");
}

#[test]
fn the_mesh_does_not_matter() {
    let errors = |node_mm: f64| {
        let mut settings = ProcessSettings::default();
        settings.pass.node_mm = node_mm;
        let mut process = process(&settings, 1);
        process.cut(&plan(1, 26.5, vec![0.0; 100])).unwrap();
        process.cut(&plan(2, 26.0, vec![0.0; 100])).unwrap();
        process.diameter_mm()[process.diameter_mm().len() / 2]
    };
    assert!((errors(1.0) - errors(0.25)).abs() < 1e-6, "{:e}", errors(1.0) - errors(0.25));
}
