//! Paths, zones, Gaussians and forests against closed forms.

use shadowgauge::gauge::flank::forest::file;
use shadowgauge::gauge::flank::forest::training::{Growth, Samples, grow};
use shadowgauge::numerics::gaussian::blurred;

/// A single bright pixel becomes the Gaussian, different along and down; what is even stays even up
/// to the border.
#[test]
fn a_gaussian_over_an_image_is_one() {
    let (rows, columns, sigmas) = (31, 41, (2.0, 3.0));
    let mut single = vec![0.0; rows * columns];
    single[15 * columns + 20] = 1.0;
    let seen = blurred(&single, (rows, columns), sigmas);
    let top = seen[15 * columns + 20];
    for (row, column) in [(15, 20), (12, 20), (15, 27), (20, 14)] {
        let (down, along) = ((row as f32 - 15.0) / 2.0, (column as f32 - 20.0) / 3.0);
        let expected = top * (-0.5 * (down * down + along * along)).exp();
        assert!((seen[row * columns + column] - expected).abs() < 1e-7, "{row} {column}");
    }
    assert!((seen.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    assert!(blurred(&[0.7; 40], (5, 8), sigmas).iter().all(|v| (v - 0.7).abs() < 1e-6));
    assert_eq!(blurred(&single, (rows, columns), (0.0, 0.0)), single);
}

/// Two features, one of which decides: above 0.3 a pixel is land.
fn samples(n: usize) -> Samples {
    let mut all = Samples { features: 2, ..Samples::default() };
    for k in 0..n {
        let (x, y) = ((k as f32 * 0.618_034).fract(), (k as f32 * 0.414_214).fract());
        all.values.extend([x, y]);
        all.land.push(x > 0.3);
    }
    all
}

#[test]
fn a_forest_finds_the_threshold_of_its_samples() {
    let growth = Growth { tried: 2, ..Growth::default() };
    let forest = grow(&samples(4000), &growth);
    for x in [0.05, 0.2, 0.28] {
        assert!(forest.probability(|k| [x, 0.7][k]) < 0.1, "{x}");
    }
    for x in [0.33, 0.5, 0.9] {
        assert!(forest.probability(|k| [x, 0.2][k]) > 0.9, "{x}");
    }
}

#[test]
fn a_forest_repeats_by_seed_and_survives_its_file() {
    let growth = Growth::default();
    let bytes = |seed: u64| file::write(&grow(&samples(1000), &Growth { seed, ..growth })).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| bytes(1));
    assert!(one == bytes(1) && one != bytes(2));
    assert_eq!(file::write(&file::read(&one, (2, 0)).unwrap()).unwrap(), one);
}

#[test]
fn a_damaged_model_is_refused() {
    let good = file::write(&grow(&samples(300), &Growth::default())).unwrap();
    assert!(file::read(&good, (3, 0)).unwrap_err().contains("2 features"));
    assert!(file::read(&good[..good.len() - 1], (2, 0)).is_err());
    assert!(file::read(b"SGFLANK2", (2, 0)).is_err() && file::read(b"", (2, 0)).is_err());
    let header = good.iter().position(|b| *b == b'\n').unwrap();
    for at in (header + 1..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 0x55;
        // read, or refused: never a panic, and what is read ends
        if let Ok(forest) = file::read(&bad, (2, 0)) {
            assert!((0.0..=1.0).contains(&forest.probability(|_| 0.5)));
        }
    }
}
