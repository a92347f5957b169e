//! Diameters of deflected, eccentric shafts against their truth, pooled over seeds.

use shadowgauge::shaft::{Bow, Deflection, Eccentricity, ShaftForm};
use shadowgauge::truth::station_diameters_mm;

use crate::bench::{Case, Head};

/// Errors over their standard uncertainties.
#[derive(Clone, Copy, Debug, Default)]
struct Pooled {
    n: f64,
    square: f64,
    beyond: f64,
    off: f64,
    u: f64,
}

impl Pooled {
    fn add(&mut self, error_mm: f64, u_mm: f64) {
        let ratio = error_mm / u_mm;
        self.n += 1.0;
        self.square += ratio * ratio;
        self.beyond += f64::from(u8::from(ratio.abs() > 2.0));
        self.off += error_mm;
        self.u += u_mm;
    }

    fn rms(&self) -> f64 {
        (self.square / self.n).sqrt()
    }

    fn beyond(&self) -> f64 {
        self.beyond / self.n
    }
}

/// Sagittae and eccentricity by seed: spread over 0 to .5 mm in every direction, 0 to .1 mm.
fn form(seed: u64, bowed: bool) -> ShaftForm {
    // Additive recurrences of irrational steps fill the ranges evenly.
    let part = |step: f64| (seed as f64 * step).fract();
    let sagitta = 0.5 * part(0.618_034);
    let direction = std::f64::consts::TAU * part(0.754_878);
    let turned = if bowed { 0.5 } else { 0.0 };
    ShaftForm {
        deflection: Deflection {
            sagitta_x_mm: (1.0 - turned) * sagitta * direction.cos(),
            sagitta_y_mm: (1.0 - turned) * sagitta * direction.sin(),
        },
        bow: Bow { sagitta_mm: turned * sagitta, phase_deg: 360.0 * part(0.569_840) },
        eccentricity: Eccentricity {
            amplitude_mm: 0.1 * part(0.414_214),
            phase_deg: 360.0 * part(0.732_051),
        },
        ..ShaftForm::default()
    }
}

fn pooled(case: Case, seeds: std::ops::Range<u64>, single: bool) -> (Pooled, Pooled) {
    let (mut all, mut relative) = (Pooled::default(), Pooled::default());
    for seed in seeds {
        let head = Head::new(case, seed);
        let form = form(seed, seed % 3 == 2);
        let shaft = head.shaft(&form);
        let truth = station_diameters_mm(&shaft, &case.intervals()).unwrap();
        let profile = head.profile(&head.scan(&shaft, single));
        let readings: Vec<_> = profile.stations.iter().map(|s| s.reading.value().unwrap()).collect();
        let n = truth.len() as f64;
        let mean = readings.iter().zip(&truth).map(|(d, t)| d.d_mm - t).sum::<f64>() / n;
        let (mut one, mut worst) = (Pooled::default(), 0.0_f64);
        for (d, t) in readings.iter().zip(&truth) {
            one.add(d.d_mm - t, d.u_mm());
            all.add(d.d_mm - t, d.u_mm());
            relative.add(d.d_mm - t - mean, d.u_random_mm);
            worst = worst.max((d.d_mm - t - mean).abs());
        }
        println!(
            "{seed}: x {:.3} y {:.3} bow {:.3} e {:.3}: rms {:.2}, mean {:.4} um, worst about it {:.4} um, u {:.4} um",
            form.deflection.sagitta_x_mm,
            form.deflection.sagitta_y_mm,
            form.bow.sagitta_mm,
            form.eccentricity.amplitude_mm,
            one.rms(),
            1e3 * mean,
            1e3 * worst,
            1e3 * one.u / one.n
        );
    }
    (all, relative)
}

const WIDE: Case = Case {
    diameter_mm: 25.0,
    length_mm: 500.0,
    station_mm: 5.0,
    rows: 2048,
    columns: 2448,
    fields: 14,
    angles: 8,
    whole_turn: false,
};

const SHORT: Case = Case {
    diameter_mm: 8.0,
    length_mm: 150.0,
    station_mm: 5.0,
    rows: 672,
    columns: 1280,
    fields: 8,
    angles: 8,
    whole_turn: false,
};

#[test]
#[ignore = "wide"]
fn wide() {
    for single in [false, true] {
        let (all, relative) = pooled(SHORT, 1..13, single);
        println!(
            "single {single}: all rms {:.3} beyond {:.3}; relative rms {:.3} beyond {:.3}",
            all.rms(),
            all.beyond(),
            relative.rms(),
            relative.beyond()
        );
    }
}

#[test]
#[ignore = "wide"]
fn wide_main() {
    for single in [false, true] {
        let (all, relative) = pooled(WIDE, 1..3, single);
        println!(
            "single {single}: all rms {:.3} beyond {:.3}; relative rms {:.3} beyond {:.3}",
            all.rms(),
            all.beyond(),
            relative.rms(),
            relative.beyond()
        );
    }
}
