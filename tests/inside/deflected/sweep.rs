//! Diameters of deflected, eccentric shafts against their truth, pooled over seeds.

use shadowgauge::shaft::{Bow, Deflection, Eccentricity, ShaftForm};
use shadowgauge::truth::station_diameters_mm;

use crate::inside::deflected::setup::{Case, Head};

/// Errors over their standard uncertainties.
#[derive(Clone, Copy, Debug, Default)]
struct Pooled {
    n: f64,
    square: f64,
    beyond: f64,
    off: f64,
    u: f64,
    largest: f64,
}

impl Pooled {
    fn add(&mut self, error_mm: f64, u_mm: f64) {
        let ratio = error_mm / u_mm;
        self.n += 1.0;
        self.square += ratio * ratio;
        self.beyond += f64::from(u8::from(ratio.abs() > 2.0));
        self.off += error_mm;
        self.u += u_mm;
        self.largest = self.largest.max(ratio.abs());
    }

    fn join(&mut self, other: Self) {
        self.n += other.n;
        self.square += other.square;
        self.beyond += other.beyond;
        self.off += other.off;
        self.u += other.u;
        self.largest = self.largest.max(other.largest);
    }

    fn rms(&self) -> f64 {
        (self.square / self.n).sqrt()
    }

    fn beyond(&self) -> f64 {
        self.beyond / self.n
    }
}

/// Sagittae and eccentricity by seed: spread over 0 to 0.5 mm in every direction, and 0 to 0.1 mm.
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

/// Errors over u of streams, of single frames, and of streams less single frames.
fn pooled(case: Case, seeds: std::ops::Range<u64>) -> [Pooled; 3] {
    let mut all = [Pooled::default(); 3];
    for seed in seeds {
        let head = Head::new(case, seed);
        let form = form(seed, seed % 3 == 2);
        let shaft = head.shaft(&form);
        let truth = station_diameters_mm(&shaft, &case.intervals()).unwrap();
        let [stream, single] = head.scan_twice(&shaft).map(|frames| head.profile(&frames).stations);
        let mut own = [Pooled::default(); 3];
        for ((stream, single), truth) in stream.iter().zip(&single).zip(&truth) {
            let (Some(a), Some(b)) = (stream.reading.value(), single.reading.value()) else {
                if case.field_step > 1 {
                    continue;
                }
                panic!("seed {seed}, {form:?}: {stream:?} {single:?}")
            };
            own[0].add(a.d_mm - truth, a.u_mm());
            own[1].add(b.d_mm - truth, b.u_mm());
            own[2].add(a.d_mm - b.d_mm, b.u_mm());
        }
        println!(
            "{seed:>3}: x {:.3} y {:.3} bow {:.3} e {:.3} mm: error {:.4} um, u {:.4} um, rms {:.2}; single {:.2}; apart up to {:.2} u",
            form.deflection.sagitta_x_mm,
            form.deflection.sagitta_y_mm,
            form.bow.sagitta_mm,
            form.eccentricity.amplitude_mm,
            1e3 * own[0].off / own[0].n,
            1e3 * own[0].u / own[0].n,
            own[0].rms(),
            own[1].rms(),
            own[2].largest
        );
        all.iter_mut().zip(own).for_each(|(all, own)| all.join(own));
    }
    for (name, p) in ["streams", "single frames", "streams less single frames"].iter().zip(&all) {
        println!(
            "{name}: {} stations, rms error/u {:.3}, beyond 2u {:.1} %, largest {:.2} u",
            p.n,
            p.rms(),
            100.0 * p.beyond(),
            p.largest
        );
    }
    all
}

/// Limits of the pooled errors.
fn check([streams, single, apart]: &[Pooled; 3], rms: std::ops::Range<f64>) {
    for pooled in [streams, single] {
        assert!(rms.contains(&pooled.rms()) && pooled.beyond() <= 0.06, "{pooled:?}");
    }
    // Both estimate the blur from the same columns; they differ in its course along the field,
    // which a stream continues and a single frame starts from zero. Of 3000 stations one differed
    // by 0.8 u.
    assert!(apart.rms() < 0.15 && apart.largest < 1.0, "{apart:?}");
}

const SHORT: Case = Case {
    diameter_mm: 8.0,
    length_mm: 150.0,
    station_mm: 5.0,
    rows: 672,
    columns: 1280,
    fields: 8,
    angles: 8,
    whole_turn: false,
    field_step: 1,
};

#[test]
#[ignore = "100 seeds: a minute"]
fn diameters_stay_true_over_100_seeds() {
    check(&pooled(SHORT, 1..101), 0.8..1.15);
}

/// The main job's head and shaft. Nearly all of u comes from the masters' certificates, with one
/// draw per seed: a hundred seeds determine the ratio to 7 %, ten to 22 %; so only three fields of
/// fourteen are scanned for each.
#[test]
#[ignore = "40 frames of 5 megapixels a seed: ten minutes"]
fn diameters_stay_true_over_100_seeds_of_the_main_job() {
    let case = Case {
        diameter_mm: 25.0,
        length_mm: 500.0,
        rows: 2048,
        columns: 2448,
        fields: 14,
        field_step: 5,
        ..SHORT
    };
    check(&pooled(case, 1..101), 0.8..1.15);
}

#[test]
fn diameters_stay_true_whatever_the_axis_does() {
    let case = Case { length_mm: 75.0, fields: 4, angles: 4, ..SHORT };
    // 24 seeds with one draw of the masters' errors each: ± 0.3 is two standard deviations of the
    // rms.
    check(&pooled(case, 1..25), 0.7..1.3);
}
