//! The adjustment of an optical setup against setups with given parameters.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use shadowgauge::gauge::calibration::{
    Adjustment, CertificateShare, ColumnSpread, LensLimits, LensModel, MasterPrior, Observation, PARAMETERS,
    Thermometer, Unstated,
};
use shadowgauge::gauge::{CalibrationError, MasterCertificate};

const SIZE: (usize, usize) = (2048, 2448);

fn master(name: &str, diameter_mm: f64, expanded_u_mm: f64) -> MasterPrior {
    let certificate = MasterCertificate { diameter_mm, expanded_u_mm, coverage_factor: 2.0 };
    MasterPrior { name: name.to_owned(), certificate, common: None }
}

/// True values.
#[derive(Clone, Copy)]
struct World {
    scale: f64,
    offset: f64,
    lens: LensModel,
    /// Errors of the certificates, mm.
    delta: [f64; 2],
    /// True temperature and expansion of the masters.
    temperature_c: f64,
    alpha: f64,
    noise_px: f64,
}

/// The image of a pin at a height and a distance from the plane: rows at which the ideal row has
/// the given value, by bisection instead of the correction's own inverse.
fn observations(world: &World, diameters: &[f64; 2], rng: &mut Pcg64) -> Vec<Observation> {
    let mut all = Vec::new();
    let mut frame = 0;
    for (index, diameter) in diameters.iter().enumerate() {
        let true_mm = (diameter + world.delta[index]) * (1.0 + world.alpha * (world.temperature_c - 20.0));
        for (height_mm, y_mm) in [(-2.0, 0.0), (0.0, -3.0), (0.0, 0.0), (0.0, 3.0), (2.0, 0.0)] {
            for block in 0..6 {
                let u = 400.0 * (f64::from(block) - 2.5);
                let near = 1.0 + world.lens.telecentricity_per_mm * y_mm;
                let half = 0.5 * (true_mm - world.offset) / (world.scale * near);
                let middle = -height_mm / world.scale;
                let mut row = |target: f64| {
                    let (mut low, mut high) = (-1100.0, 1100.0);
                    for _ in 0..80 {
                        let mid = 0.5 * (low + high);
                        if world.lens.ideal(u, mid) < target { low = mid } else { high = mid }
                    }
                    let z: f64 = StandardNormal.sample(rng);
                    0.5 * (low + high) + world.noise_px * z
                };
                let (top_px, bottom_px) = (row(middle - half), row(middle + half));
                all.push(Observation {
                    master: index,
                    frame,
                    column_px: u,
                    column_variance_px2: 0.0,
                    top_px,
                    bottom_px,
                    chord: 1.0,
                    axis_y_mm: y_mm,
                    u_width_px: 2.0_f64.sqrt() * world.noise_px.max(1e-5),
                    u_shared_px: 0.0,
                    u_misfit_px: 0.0,
                });
            }
            frame += 1;
        }
    }
    all
}

const THERMOMETER: Thermometer = Thermometer {
    temperature_c: 22.0,
    limit_temperature_k: 0.3,
    expansion_um_per_m_k: 11.5,
    limit_expansion_um_per_m_k: 1.0,
    unstated: Unstated { temperature: false, expansion: false, edge: false },
};

fn world() -> World {
    World {
        scale: 0.015_262,
        offset: -0.0007,
        lens: LensModel {
            radial: 4e-4,
            keystone_across: -1.5e-4,
            keystone_along: 8e-5,
            telecentricity_per_mm: 2.5e-5,
            ..LensModel::perfect(SIZE.0, SIZE.1)
        },
        delta: [0.0; 2],
        temperature_c: 22.0,
        alpha: 11.5e-6,
        noise_px: 0.0,
    }
}

const LIMITS: LensLimits =
    LensLimits { distortion_percent: 0.1, keystone_percent: 0.05, telecentricity_deg: 0.05 };

fn adjust(observations: Vec<Observation>, masters: Vec<MasterPrior>) -> Result<Adjustment, CalibrationError> {
    Adjustment::new(masters, observations, THERMOMETER, &LIMITS, SIZE)
}

#[test]
fn a_known_bench_is_found() {
    let (small, large) = (16.0, 26.0);
    let mut rng = Pcg64::seed_from_u64(1);
    let seen = observations(&world(), &[small, large], &mut rng);
    let mut adjustment = adjust(seen, vec![master("A", small, 2e-6), master("B", large, 2e-6)]).unwrap();
    let found = adjustment.fit().unwrap();
    let truth = world();
    let expected = [
        truth.scale,
        truth.offset,
        truth.lens.radial,
        truth.lens.keystone_across,
        truth.lens.keystone_along,
        truth.lens.telecentricity_per_mm,
    ];
    println!("{:?}\n{expected:?}", found.parameters);
    let tolerance = [2e-8, 3e-5, 2e-6, 2e-6, 2e-6, 2e-7];
    for ((f, e), t) in found.parameters.iter().zip(expected).zip(tolerance) {
        assert!((f - e).abs() < t, "{:?} {expected:?}", found.parameters);
    }
    // A part of 20 mm anywhere in the field, at the masters' temperature, out of the plane.
    let lens = found.lens;
    let (top, bottom) = (-500.0, 811.0);
    let exact = |s: f64, o: f64, l: &LensModel| s * (l.ideal(700.0, bottom) - l.ideal(700.0, top)) + o;
    let error = exact(found.parameters[0], found.parameters[1], &lens)
        - exact(truth.scale, truth.offset, &truth.lens);
    assert!(error.abs() < 5e-6, "{error}");
    assert!(found.residuals.iter().all(|r| r.residual_mm.abs() < 1e-5));
}

/// Scatter of the result over worlds drawn from the priors agrees with the covariance, source by
/// source.
#[test]
fn the_covariance_is_the_scatter_over_worlds_drawn_from_the_priors() {
    let diameters = [16.0, 26.0];
    let masters = || vec![master("A", diameters[0], 8e-4), master("B", diameters[1], 5e-4)];
    let mut rng = Pcg64::seed_from_u64(2);
    let mut normal = |u: f64| {
        let z: f64 = StandardNormal.sample(&mut rng);
        u * z
    };
    let half_diagonal_mm = 0.015_262 * LensModel::perfect(SIZE.0, SIZE.1).half_diagonal_px;
    let u_lens = LIMITS.u_parameters(half_diagonal_mm);
    let [u_t, u_alpha] = THERMOMETER.u();
    let (runs, mut squares, mut stated) = (400, 0.0, 0.0);
    let (u, top, bottom) = (300.0, -640.0, 420.0);
    let mut draws = Pcg64::seed_from_u64(3);
    for _ in 0..runs {
        let mut w = world();
        w.lens.radial = normal(u_lens[0]);
        w.lens.keystone_across = normal(u_lens[1]);
        w.lens.keystone_along = normal(u_lens[2]);
        w.lens.telecentricity_per_mm = normal(u_lens[3]);
        w.delta = [normal(4e-4), normal(2.5e-4)];
        w.temperature_c = 22.0 + normal(u_t);
        w.alpha = 11.5e-6 + normal(u_alpha);
        w.noise_px = 0.004;
        let mut adjustment = adjust(observations(&w, &diameters, &mut draws), masters()).unwrap();
        let found = adjustment.fit().unwrap();
        let d = |s: f64, o: f64, l: &LensModel| s * (l.ideal(u, bottom) - l.ideal(u, top)) + o;
        let error = d(found.parameters[0], found.parameters[1], &found.lens) - d(w.scale, w.offset, &w.lens);
        let l = &found.lens;
        let by_lens = l.width_by(ColumnSpread::at(u), top, bottom).map(|b| found.parameters[0] * b);
        let by: [f64; PARAMETERS] =
            [l.ideal(u, bottom) - l.ideal(u, top), 1.0, by_lens[0], by_lens[1], by_lens[2], 0.0];
        stated += found.parts.iter().map(|p| p.variance(&by)).sum::<f64>() / f64::from(runs);
        squares += error * error / f64::from(runs);
    }
    let ratio = (squares / stated).sqrt();
    println!("sd {:.3} um, stated {:.3} um, ratio {ratio:.3}", 1e3 * squares.sqrt(), 1e3 * stated.sqrt());
    // 400 worlds: the ratio scatters by 3.5 %.
    assert!((0.88..1.12).contains(&ratio), "{ratio}");
}

#[test]
fn deviated_data_move_the_result_as_the_covariance_says() {
    let diameters = [16.0, 26.0];
    let mut rng = Pcg64::seed_from_u64(4);
    let seen = observations(&World { noise_px: 0.004, ..world() }, &diameters, &mut rng);
    let mut adjustment = adjust(seen, vec![master("A", 16.0, 8e-4), master("B", 26.0, 5e-4)]).unwrap();
    let found = adjustment.fit().unwrap();
    let zero = vec![0.0; adjustment.inputs()];
    let same = adjustment.parameters_with(&zero).unwrap();
    assert!((same[0] / found.parameters[0] - 1.0).abs() < 1e-12);
    // Pin A's certificate one standard uncertainty (.4 µm) too small: deviation of its δ.
    let first_master = adjustment.observations().len() + 4;
    let mut moved = zero;
    moved[first_master] = 1.0;
    let by: [f64; PARAMETERS] = [1300.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let change: f64 = adjustment
        .parameters_with(&moved)
        .unwrap()
        .iter()
        .zip(&same)
        .zip(by)
        .map(|((a, b), d)| (a - b) * d)
        .sum();
    let part = found.parts.iter().find(|p| p.source.contains("certificate of A")).unwrap();
    assert!((change.abs() / part.variance(&by).sqrt() - 1.0).abs() < 1e-3, "{change}");
}

/// A clean first block must not hide the common error of the other columns of its frame.
#[test]
fn what_any_block_of_a_frame_shares_counts() {
    let u_of = |shared: [f64; 6]| {
        let mut rng = Pcg64::seed_from_u64(6);
        let mut seen = observations(&world(), &[16.0, 26.0], &mut rng);
        seen.iter_mut().enumerate().for_each(|(i, o)| o.u_shared_px = shared[i % 6]);
        let mut adjustment = adjust(seen, vec![master("A", 16.0, 2e-6), master("B", 26.0, 2e-6)]).unwrap();
        let found = adjustment.fit().unwrap();
        let part = found.parts.iter().find(|p| p.source.starts_with("masters' edges")).unwrap();
        part.variance(&[1300.0, 1.0, 0.0, 0.0, 0.0, 0.0]).sqrt()
    };
    let even = u_of([0.05; 6]);
    // The same mean square, with the first block clean, and the reverse.
    let late = u_of([0.0, 0.05, 0.05, 0.05, 0.05, 0.05 * 2.0_f64.sqrt()]);
    let early = u_of([0.05 * 6.0_f64.sqrt(), 0.0, 0.0, 0.0, 0.0, 0.0]);
    println!("{even} {late} {early} mm");
    assert!(even > 1e-4 && (late / even - 1.0).abs() < 1e-6 && (early / even - 1.0).abs() < 1e-6);
}

/// A wrong edge model displaces edges by 0.05 px at 3 mm out of the plane, more on one side than on
/// the other: the lens' parameters and their rows are unaffected, and a separate row states the
/// effect.
#[test]
fn a_wrong_edge_model_is_not_the_lens() {
    let seen = |bias_px: [f64; 2]| {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut seen = observations(&World { noise_px: 0.004, ..world() }, &[16.0, 26.0], &mut rng);
        for o in &mut seen {
            let bias = if o.axis_y_mm < 0.0 { bias_px[0] } else { bias_px[1] };
            o.bottom_px += if o.axis_y_mm == 0.0 { 0.0 } else { bias };
        }
        let mut adjustment = adjust(seen, vec![master("A", 16.0, 2e-4), master("B", 26.0, 2e-4)]).unwrap();
        adjustment.fit().unwrap()
    };
    let row = |found: &shadowgauge::gauge::calibration::Adjusted, source: &str| {
        let by: [f64; PARAMETERS] = [1300.0, 1.0, 50.0, 300.0, 100.0, 0.5 * 20.0];
        found.parts.iter().filter(|p| p.source.contains(source)).map(|p| p.variance(&by).sqrt()).sum::<f64>()
    };
    let (right, wrong) = (seen([0.0; 2]), seen([0.05, 0.11]));
    for k in 0..PARAMETERS {
        println!("{k}: {:e} {:e}", right.parameters[k], wrong.parameters[k]);
    }
    // The telecentricity is determined by the two diameters at one place, to 1.2e-6/mm under this
    // noise: 0.06 px of difference would be 7e-6/mm.
    let t = |found: &shadowgauge::gauge::calibration::Adjusted| found.lens.telecentricity_per_mm;
    assert!((t(&wrong) - world().lens.telecentricity_per_mm).abs() < 3e-6, "{:e}", t(&wrong));
    assert!((wrong.parameters[1] - right.parameters[1]).abs() < 1e-4);
    for source in ["distortion and keystone", "telecentricity of the lens"] {
        let (before, after) = (row(&right, source), row(&wrong, source));
        assert!(after < 1.5 * before + 1e-6, "{source}: {before} {after} mm");
    }
    assert!(
        wrong.birge_ratio < 1.3 && right.birge_ratio < 1.3,
        "{} {}",
        wrong.birge_ratio,
        right.birge_ratio
    );
    assert!(wrong.parts.iter().any(|p| p.source.starts_with("misfit of the edge model")));
    assert!(right.parts.iter().all(|p| !p.source.starts_with("misfit of the edge model")));
}

#[test]
fn masters_that_determine_no_bench_are_refused() {
    let mut rng = Pcg64::seed_from_u64(5);
    let seen = observations(&world(), &[20.0, 20.05], &mut rng);
    let twins = vec![master("A", 20.0, 1e-4), master("B", 20.05, 1e-4)];
    assert!(matches!(adjust(seen.clone(), twins), Err(CalibrationError::SameSize { .. })));
    assert!(matches!(
        adjust(seen.clone(), vec![master("A", 20.0, 1e-4)]),
        Err(CalibrationError::TooFew { .. })
    ));
    let unsure = vec![master("A", 16.0, f64::NAN), master("B", 26.0, 1e-4)];
    assert!(matches!(adjust(seen.clone(), unsure), Err(CalibrationError::Certificate { master: 1 })));
    let unseen = vec![master("A", 16.0, 1e-4), master("B", 26.0, 1e-4), master("C", 30.0, 1e-4)];
    assert!(matches!(adjust(seen, unseen), Err(CalibrationError::Unseen { .. })));
}

/// Two masters determine a line: a diameter between them has the weights a and b of both, and with
/// certificates of the covariance c₁c₂ the variance a²u₁² + b²u₂² + 2ab·c₁c₂. Half-way between
/// fully correlated ones nothing averages, between independent ones half of the variance does.
#[test]
fn certificates_of_one_laboratory_are_correlated() {
    let (small, large) = (16.0, 26.0);
    let seen = observations(&world(), &[small, large], &mut Pcg64::seed_from_u64(1));
    let (u_small, u_large) = (2e-4, 3e-4);
    let at = |d_mm: f64, share: f64| {
        let by_laboratory = |name: &str, diameter_mm: f64, u_mm: f64| MasterPrior {
            common: (share > 0.0)
                .then(|| CertificateShare { certified_by: "PTB".to_owned(), u_mm: share.sqrt() * u_mm }),
            ..master(name, diameter_mm, 2.0 * u_mm)
        };
        let masters = vec![by_laboratory("A", small, u_small), by_laboratory("B", large, u_large)];
        let adjusted = adjust(seen.clone(), masters).unwrap().fit().unwrap();
        let width_px = (d_mm - adjusted.parameters[1]) / adjusted.parameters[0];
        let by = [width_px, 1.0, 0.0, 0.0, 0.0, 0.0];
        let certificates = adjusted.parts.iter().filter(|p| p.source.starts_with("certificate"));
        certificates.map(|p| p.variance(&by)).sum::<f64>().sqrt()
    };
    for d_mm in [14.0, 16.0, 21.0, 25.0, 30.0] {
        let (a, b) = ((large - d_mm) / (large - small), (d_mm - small) / (large - small));
        for share in [0.0, 0.5, 1.0] {
            let variance =
                (a * u_small).powi(2) + (b * u_large).powi(2) + 2.0 * a * b * share * u_small * u_large;
            let found = at(d_mm, share);
            assert!(
                (found / variance.sqrt() - 1.0).abs() < 2e-3,
                "{d_mm} {share}: {found} {}",
                variance.sqrt()
            );
        }
    }
}
