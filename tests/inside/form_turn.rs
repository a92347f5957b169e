//! Results of a turn of silhouettes: even lobes independent of the spindle, filter, hull, run-out,
//! sizes.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use shadowgauge::frame::FrameMeta;
use shadowgauge::gauge::diameter::sections::{PartForm, TurnAverager};
use shadowgauge::gauge::form::{
    Cutoff, FormError, Origin, Turn, circular_run_out, gaussian_closed, gaussian_transmission, harmonics,
    hull_from_support, hull_limit, least_squares_circle, maximum_inscribed_circle,
    minimum_circumscribed_circle, polar_profile, total_run_out,
};
use shadowgauge::gauge::size::{circumscribed, inscribed, turn_sizes};
use shadowgauge::gauge::{ColumnDiameter, ColumnDiameters};
use shadowgauge::profile::{Diameter, Reading};

const NM: f64 = 1e-6;

/// A body r(θ) = R + Σ a·cos(k(θ − θ_k)).
struct Body {
    radius: f64,
    lobes: Vec<(f64, f64, f64)>,
}

impl Body {
    fn r(&self, theta: f64) -> f64 {
        self.radius + self.lobes.iter().map(|(k, a, t)| a * (k * (theta - t)).cos()).sum::<f64>()
    }

    /// Support function by brute force: the maximum over the body, refined by golden section.
    fn support(&self, alpha: f64) -> f64 {
        let height = |theta: f64| self.r(theta) * (theta - alpha).cos();
        let n = 500;
        let grid = |i: i32| alpha + 0.5 * PI * f64::from(i) / f64::from(n);
        let best = (-n..=n).max_by(|a, b| height(grid(*a)).total_cmp(&height(grid(*b)))).unwrap();
        let (mut low, mut high) = (grid(best - 1), grid(best + 1));
        for _ in 0..60 {
            let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if height(a) < height(b) { low = a } else { high = b }
        }
        height(0.5 * (low + high))
    }

    /// Edges over a turn with spindle motion c(φ).
    fn turn(&self, n: usize, spindle: impl Fn(f64) -> f64) -> Turn {
        let phi = |i: usize| TAU * i as f64 / n as f64;
        let top = (0..n).map(|i| 7.0 + spindle(phi(i)) + self.support(-phi(i))).collect();
        let bottom = (0..n).map(|i| 7.0 + spindle(phi(i)) - self.support(-phi(i) - PI)).collect();
        Turn::even(0.0, top, bottom).unwrap()
    }
}

#[test]
fn even_lobes_are_free_of_spindle_motion_and_odd_ones_are_not() {
    let body = Body { radius: 25.0, lobes: vec![(2.0, 4e-4, 0.3), (3.0, 3e-4, 1.0), (8.0, 1e-4, 0.0)] };
    let motion =
        |phi: f64| 5e-3 * (2.0 * phi).cos() + 2e-3 * (3.0 * phi).cos() + 1e-3 * (8.0 * phi + 0.4).cos();
    let (still, moving) = (body.turn(360, |_| 0.0), body.turn(360, motion));
    let (a, b) = (harmonics(&still, 20, 1e-4), harmonics(&moving, 20, 1e-4));
    for (p, q) in a.section.iter().zip(&b.section) {
        let expected = body.lobes.iter().find(|(k, ..)| *k == p.lobes as f64).map_or(0.0, |l| l.1);
        assert!(
            (p.amplitude_mm - expected).abs() < 1e-7 || expected == 0.0 && p.amplitude_mm < 1e-6,
            "{p:?}"
        );
        if p.lobes % 2 == 0 {
            assert!((p.amplitude_mm - q.amplitude_mm).abs() < 1e-12 && q.origin == Origin::Form);
        } else if p.lobes == 3 {
            assert!((p.amplitude_mm - q.amplitude_mm).abs() > 1e-4 && q.origin == Origin::FormAndSpindle);
        }
    }
    // Phase: the body's first peak at θ = .3 faces up at φ = −.3 mod π.
    assert!((a.section[1].phase_deg - (PI - 0.3).to_degrees()).abs() < 1e-3);
    let spindle: Vec<f64> = b.even_spindle.iter().map(|h| h.amplitude_mm).collect();
    assert!((spindle[0] - 5e-3).abs() < 1e-9 && (spindle[3] - 1e-3).abs() < 1e-9 && spindle[1] < 1e-9);
    assert!((a.section[0].u_amplitude_mm - 1e-4 / 360f64.sqrt()).abs() < 1e-18);
}

#[test]
fn amplitude_uncertainty_is_the_scatter_of_noise() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64::seed_from_u64(8);
    let normal = rand_distr::Normal::new(0.0, 1e-3).unwrap();
    let (n, runs) = (64, 3000);
    let mut squares = [0.0; 2];
    let mut u = 0.0;
    for _ in 0..runs {
        let mut edges = |at: f64| (0..n).map(|_| at + random.sample(normal)).collect::<Vec<f64>>();
        let turn = Turn::even(0.0, edges(25.0), edges(-25.0)).unwrap();
        let found = harmonics(&turn, 6, 1e-3);
        for (sum, k) in squares.iter_mut().zip([4, 5]) {
            *sum += found.section[k - 1].amplitude_mm.powi(2) / (2.0 * f64::from(runs));
        }
        u = found.section[3].u_amplitude_mm;
    }
    for s in squares {
        assert!((s.sqrt() / u - 1.0).abs() < 0.04, "{} {u}", s.sqrt());
    }
}

#[test]
fn gaussian_filter_passes_one_half_at_its_cutoff_and_agrees_with_the_convolution() {
    let n = 720_i32;
    for (cutoff, value) in [(Cutoff::UPR_15, 15.0), (Cutoff::UPR_50, 50.0), (Cutoff::UPR_150, 150.0)] {
        assert!((gaussian_transmission(value, cutoff) - 0.5).abs() < 1e-15);
        let wave: Vec<f64> =
            (0..n).map(|i| 25.0 + (value * TAU * f64::from(i) / f64::from(n)).cos()).collect();
        let out = gaussian_closed(&wave, cutoff);
        assert!((out[0] - 25.5).abs() < 1e-12);
    }
    // ISO 16610-21 by its weighting function, wrapped around, on a profile with a step.
    let profile: Vec<f64> = (0..n).map(|i| if (200..330).contains(&i) { 1.0 } else { 0.0 }).collect();
    let alpha_wave = (2f64.ln() / PI).sqrt() * f64::from(n) / 15.0;
    let weight = |d: f64| (-PI * (d / alpha_wave).powi(2)).exp() / alpha_wave;
    let out = gaussian_closed(&profile, Cutoff::UPR_15);
    for i in (0..n).step_by(7) {
        let direct: f64 = (0..n)
            .map(|j| {
                let d = f64::from((i - j).rem_euclid(n));
                let d = d.min(f64::from(n) - d);
                weight(d) * profile[j as usize]
            })
            .sum();
        assert!((out[i as usize] - direct).abs() < 1e-9, "{i}: {} {direct}", out[i as usize]);
    }
}

#[test]
fn the_hull_gives_the_profile_back_where_the_support_function_alone_does_not() {
    let cutoff = Cutoff::upr(5000.0).unwrap();
    for (k, a) in [(3.0, 0.05), (15.0, 0.010), (50.0, 0.003)] {
        let body = Body { radius: 25.0, lobes: vec![(k, a, 0.2)] };
        let n = 1440;
        let angle = |i: usize| TAU * i as f64 / n as f64;
        let support: Vec<f64> = (0..n).map(|i| body.support(angle(i))).collect();
        let profile = polar_profile(&support, cutoff).unwrap();
        let worst = (0..n).map(|i| (profile[i] - body.r(angle(i))).abs()).fold(0.0, f64::max);
        let naive = (0..n).map(|i| (support[i] - body.r(angle(i))).abs()).fold(0.0, f64::max);
        let (ratio, excess) = hull_limit(k, a, 25.0);
        println!(
            "k = {k}: hull {worst:.2e} mm, h taken for r {naive:.2e} mm, stated {excess:.2e}, k2a/R {ratio:.3}"
        );
        assert!(worst < NM, "k = {k}: {worst}");
        assert!((naive / excess - 1.0).abs() < 0.3, "k = {k}: {naive} {excess}");
    }
}

#[test]
fn a_body_with_hollows_and_noise_are_told_apart_by_convexity() {
    // Alternating noise of 1 µm on 720 samples has h'' of 130 mm: no convex body, unless it is
    // filtered.
    let support: Vec<f64> = (0..720).map(|i| 25.0 + if i % 7 == 0 { 1e-3 } else { 0.0 }).collect();
    let wide = Cutoff::upr(5000.0).unwrap();
    assert!(matches!(hull_from_support(&support, wide), Err(FormError::NotConvex { .. })));
    assert!(hull_from_support(&support, Cutoff::UPR_50).is_ok());
}

#[test]
fn sizes_are_those_of_the_hull() {
    let body = Body { radius: 25.0, lobes: vec![(3.0, 0.02, 0.1), (5.0, 0.01, 0.7), (4.0, 0.01, 0.0)] };
    let turn = body.turn(720, |_| 0.0);
    let sizes = turn_sizes(&turn, Cutoff::upr(5000.0).unwrap(), 1e-4).unwrap();
    let points: Vec<DVec2> = (0..20_000)
        .map(|i| TAU * f64::from(i) / 20_000.0)
        .map(|t| DVec2::from_angle(t) * body.r(t))
        .collect();
    let gn = minimum_circumscribed_circle(&points).unwrap().circle.diameter();
    let gx = maximum_inscribed_circle(&points).unwrap().circle.diameter();
    let gg = least_squares_circle(&points).unwrap().fit.circle.diameter();
    println!("GN {:.7} {gn:.7}  GX {:.7} {gx:.7}  GG {:.7} {gg:.7}", sizes.gn_mm, sizes.gx_mm, sizes.gg_mm);
    // Tangents every half degree miss the extreme by at most ½·r''·(δ/2)² of the support function.
    assert!((sizes.gn_mm - gn).abs() < 2e-5 && (sizes.gx_mm - gx).abs() < 2e-5);
    assert!((sizes.gg_mm - gg).abs() < NM);
    assert!(sizes.gx_mm < sizes.gg_mm && sizes.gg_mm < sizes.gn_mm);
    assert!((sizes.u_gg_mm - 1e-4 * (2.0 / 720.0_f64).sqrt()).abs() < 1e-15);
    // A three-lobed body is invisible to the caliper: GN − GX contains the form, max − min of the
    // widths does not.
    let three = Body { radius: 25.0, lobes: vec![(3.0, 0.02, 0.1)] }.turn(720, |_| 0.0);
    let s = turn_sizes(&three, Cutoff::UPR_50, 1e-4).unwrap();
    assert!(s.max_caliper_mm - s.min_caliper_mm < 1e-3 && s.gn_mm - s.gx_mm > 0.07);
}

/// Half a turn of a cylinder in 36 angles, four columns each, edges with noise of `sd` mm.
fn half_turn(sd: f64, rng: &mut rand_pcg::Pcg64) -> PartForm {
    use rand_distr::{Distribution, Normal};
    let noise = Normal::new(0.0, sd).unwrap();
    let mut averager = TurnAverager::new(vec![0.0], 1.0);
    for k in 0..36 {
        let edges: Vec<[f64; 2]> = (0..4).map(|_| [noise.sample(rng), noise.sample(rng)]).collect();
        let column = |e: &[f64; 2]| ColumnDiameter {
            reading: Reading::Value(Diameter {
                d_mm: 50.0 + e[0] - e[1],
                u_random_mm: sd * 2.0_f64.sqrt(),
                u_common_mm: 0.0,
            }),
            shared_mm: 0.0,
            width_px: 500.0,
            middle_mm: 0.5 * (e[0] + e[1]),
            u_middle_common_mm: 0.0,
        };
        let columns = edges.iter().map(column).collect();
        let diameters = ColumnDiameters { columns, shared_length: 64.0, pitch_mm: 0.1 };
        averager.add(&FrameMeta { angle_deg: 5.0 * f64::from(k), ..FrameMeta::default() }, &diameters);
    }
    averager.finish(Cutoff::UPR_15)
}

/// Over half a turn every reading is used at two places of the turn, which does not reduce its u.
#[test]
fn over_half_a_turn_the_uncertainty_is_that_of_readings_that_count_once() {
    use rand::SeedableRng;
    let mut rng = rand_pcg::Pcg64::seed_from_u64(6);
    let (mut error, mut stated, mut lobe, mut stated_lobe) = (0.0, 0.0, 0.0, 0.0);
    for _ in 0..400 {
        let form = half_turn(1e-4, &mut rng);
        let section = &form.sections[0];
        assert!(section.half_turn);
        let two = section.harmonics.section.iter().find(|h| h.lobes == 2).unwrap();
        error += (section.gg_mm - 50.0).powi(2);
        stated += section.u_gg_random_mm.powi(2);
        // Two quadratures.
        lobe += 0.5 * two.amplitude_mm.powi(2);
        stated_lobe += two.u_amplitude_mm.powi(2);
    }
    let (size, amplitude) = ((error / stated).sqrt(), (lobe / stated_lobe).sqrt());
    println!("scatter over stated: GG {size:.3}, two lobes {amplitude:.3}");
    // u is the larger of the edges' u and the scatter of 36 readings: a tenth more than either.
    assert!((0.8..1.05).contains(&size) && (0.8..1.05).contains(&amplitude), "{size} {amplitude}");
}

#[test]
fn size_programmes_are_exact_on_a_displaced_circle_and_an_ellipse() {
    let n = 720;
    let angle = |i: usize| TAU * i as f64 / n as f64;
    let circle: Vec<f64> = (0..n).map(|i| 25.0 + 0.3 * angle(i).cos() - 0.2 * angle(i).sin()).collect();
    for found in [circumscribed(&circle).unwrap(), inscribed(&circle).unwrap()] {
        assert!((found.radius - 25.0).abs() < NM && found.centre.distance(DVec2::new(0.3, -0.2)) < NM);
    }
    // Support function of an ellipse with semi-axes 25.05 and 24.95: GN and GX are its axes.
    let ellipse: Vec<f64> = (0..n).map(|i| (25.05 * angle(i).cos()).hypot(24.95 * angle(i).sin())).collect();
    assert!((circumscribed(&ellipse).unwrap().radius - 25.05).abs() < NM);
    assert!((inscribed(&ellipse).unwrap().radius - 24.95).abs() < NM);
}

#[test]
fn run_out_of_an_eccentric_shaft_is_twice_the_eccentricity() {
    let section = |e: f64| (0..360).map(|i| 25.0 + e * f64::from(i).to_radians().cos()).collect::<Vec<f64>>();
    assert!((circular_run_out(&section(0.01)).unwrap() - 0.02).abs() < 1e-12);
    let total = total_run_out(&[section(0.01), section(0.02)]).unwrap();
    assert!((total - 0.04).abs() < 1e-12);
    assert_eq!(circular_run_out(&[f64::NAN]), None);
}

#[test]
fn uneven_and_unpaired_turns_are_refused() {
    let reading = |angle: f64| [angle, 25.0, -25.0];
    let mut readings: Vec<[f64; 3]> = (0..12).rev().map(|i| reading(30.0 * f64::from(i) - 60.0)).collect();
    assert_eq!(Turn::from_readings(&readings).unwrap().len(), 12);
    readings[4][0] += 1.0;
    assert!(matches!(Turn::from_readings(&readings), Err(FormError::UnevenAngles { .. })));
    assert!(matches!(Turn::even(0.0, vec![1.0; 9], vec![0.0; 9]), Err(FormError::Argument { .. })));
    assert!(matches!(Turn::even(0.0, vec![1.0; 8], vec![0.0; 9]), Err(FormError::Unpaired { .. })));
    assert!(matches!(
        Turn::even(0.0, vec![f64::NAN; 8], vec![0.0; 8]),
        Err(FormError::NotFinite { index: 0 })
    ));
}
