//! A pass of 1000 stations (beam, force law and error copying) and the choice of cutting data:
//! genetic algorithm with 10 000 evaluations, and the deterministic method that proves its optimum.
//! Limits: 2 ms per pass, 0.1 s for the algorithm.
#![allow(missing_docs, reason = "Criterion's macros write functions without documentation")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};
use shadowgauge::process::{BaseForm, ProcessSettings, Stock, TurningProcess};
use shadowgauge::studies::optimize::TimedProblem;

fn pass_of_1000_stations(c: &mut Criterion) {
    let mut settings = ProcessSettings::default();
    (settings.texture.rms_um, settings.texture.lobe_um, settings.pass.node_mm) = (0.0, 0.0, 0.5);
    let stock = Stock { diameter_mm: 27.0, length_mm: 500.0 };
    let Ok(process) = TurningProcess::new(&settings, stock, &BaseForm::default(), 1) else { return };
    let plan = PassPlan {
        pass: 1,
        nominal_mm: 26.5,
        cutting: CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 },
        station_z_mm: (0..1000).map(|i| 0.25 + 0.5 * f64::from(i)).collect(),
        offset: DiameterOffset { o_mm: vec![0.0; 1000] },
        form: PlannedForm::PLAIN,
    };
    c.bench_function("pass_of_1000_stations (limit 2 ms)", |b| {
        b.iter_batched(
            || process.clone(),
            |mut process| process.cut_profile(black_box(&plan)).is_ok(),
            criterion::BatchSize::SmallInput,
        );
    });
}

fn cutting_data(c: &mut Criterion) {
    let Ok(problem) = TimedProblem::parse(include_str!("../configs/optimize_003.toml")) else { return };
    let mut group = c.benchmark_group("cutting_data");
    group.sample_size(20);
    group.bench_function("genetic, 10 000 evaluations (limit 100 ms)", |b| {
        b.iter(|| black_box(&problem).genetic_min(1));
    });
    group.bench_function("exact, proven to 1e-4", |b| {
        b.iter(|| black_box(&problem).exact_min());
    });
    group.finish();
}

criterion_group!(benches, pass_of_1000_stations, cutting_data);
criterion_main!(benches);
