//! Constants of the force law from tables.

use shadowgauge::process::PowerLaw;
use shadowgauge::process::fit::{FitError, ForcePoint, fit_power_law, read_forces};

const TABLE_1: &str = include_str!("../../../configs/paper_003/table_1.csv");
const TABLE_2: &str = include_str!("../../../configs/paper_003/table_2.csv");

#[test]
fn the_papers_tables_give_their_two_calibrations() {
    let given = PowerLaw::default();
    let first = fit_power_law(&read_forces(TABLE_1.as_bytes()).unwrap(), &given, 0.95).unwrap();
    assert!((first.law.depth_exponent - 0.901).abs() < 5e-4, "{:?}", first.law);
    assert!((first.law.coefficient_n / 4764.2 - 1.0).abs() < 3e-3, "{:?}", first.law);
    assert_eq!((first.law.feed_exponent, first.law.speed_exponent), (0.6, -0.3));
    assert!(first.residual_rel < 2e-3, "{}", first.residual_rel);
    let x = first.estimates[1].interval.unwrap();
    assert!(x[0] < first.law.depth_exponent && first.law.depth_exponent < x[1] && x[1] - x[0] < 0.01);
    assert!(first.estimates[2].interval.is_none());
    let second = fit_power_law(&read_forces(TABLE_2.as_bytes()).unwrap(), &given, 0.95).unwrap();
    assert!((second.law.speed_exponent + 0.3025).abs() < 1.5e-3, "{:?}", second.law);
    assert!((second.law.coefficient_n / 521.2 - 1.0).abs() < 0.02);
    assert_eq!(second.law.fitted.speed_m_per_min, [30.0, 100.0]);
    let rows = read_forces(TABLE_1.as_bytes()).unwrap();
    let ratio = PowerLaw::table_1().force_n(0.2, &rows[0].cutting())
        / PowerLaw::table_2().force_n(0.2, &rows[0].cutting());
    assert!((ratio - 9.14).abs() < 0.03, "{ratio}");
}

/// Scatter of 2 % on a full factorial; 400 repetitions must cover the truth at the stated rate.
#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    use rand_distr::{Distribution, Normal};
    let truth = PowerLaw::default();
    let mut random = rand_pcg::Pcg64::new(1, 2);
    let scatter = Normal::new(0.0, 0.02).unwrap();
    let mut covered = [0; 4];
    let runs = 400;
    for _ in 0..runs {
        let mut points = Vec::new();
        for depth_mm in [0.1, 0.2, 0.4] {
            for feed_mm_per_rev in [0.05, 0.1, 0.2] {
                for speed_m_per_min in [40.0, 80.0] {
                    let mut p = ForcePoint { depth_mm, speed_m_per_min, feed_mm_per_rev, force_n: 0.0 };
                    let noise: f64 = scatter.sample(&mut random);
                    p.force_n = truth.force_n(depth_mm, &p.cutting()) * noise.exp();
                    points.push(p);
                }
            }
        }
        let fit = fit_power_law(&points, &truth, 0.9).unwrap();
        let true_values =
            [truth.coefficient_n, truth.depth_exponent, truth.feed_exponent, truth.speed_exponent];
        for (i, (estimate, truth)) in fit.estimates.iter().zip(true_values).enumerate() {
            let [low, high] = estimate.interval.unwrap();
            covered[i] += u32::from(low <= truth && truth <= high);
        }
    }
    for count in covered {
        let share = f64::from(count) / f64::from(runs);
        // Binomial standard deviation 0.015.
        assert!((share - 0.9).abs() < 0.05, "{share}");
    }
}

#[test]
fn tables_that_cannot_be_fitted_say_why() {
    let given = PowerLaw::default();
    let wrong = read_forces("depth,speed\n1,2\n".as_bytes()).unwrap_err().to_string();
    assert!(wrong.contains("depth_mm"), "{wrong}");
    let negative =
        read_forces("depth_mm,speed_m_per_min,feed_mm_per_rev,force_n\n0.1,40,0.1,-3\n".as_bytes());
    assert!(matches!(negative, Err(FitError::NotPositive { row: 1, column: "force_n", .. })), "{negative:?}");
    let rows = read_forces(TABLE_1.as_bytes()).unwrap();
    assert!(matches!(fit_power_law(&rows[..2], &given, 0.95), Err(FitError::TooFew { .. })));
    let together: Vec<ForcePoint> =
        rows.iter().map(|p| ForcePoint { speed_m_per_min: 100.0 * p.depth_mm, ..*p }).collect();
    assert!(matches!(fit_power_law(&together, &given, 0.95), Err(FitError::Collinear)));
}

/// A table as a spreadsheet with decimal commas saves it: the same forces.
#[test]
fn forces_that_a_spreadsheet_saved_are_the_same() {
    let points = read_forces(TABLE_1.as_bytes()).unwrap();
    let commas = TABLE_1.replace(',', ";").replace('.', ",");
    let mut wide = vec![0xff, 0xfe];
    wide.extend(commas.replace(';', "\t").encode_utf16().flat_map(u16::to_le_bytes));
    let marked = [b"\xef\xbb\xbf".as_slice(), commas.as_bytes()].concat();
    for bytes in [commas.clone().into_bytes(), format!("sep=;\r\n{commas}").into_bytes(), wide, marked] {
        let shown = String::from_utf8_lossy(&bytes).into_owned();
        assert_eq!(read_forces(bytes.as_slice()).unwrap(), points, "{shown:?}");
    }
    let torn = "depth_mm;speed_m_per_min;feed_mm_per_rev;force_n\n0,1;40;0,1;far\n";
    let refused = read_forces(torn.as_bytes()).unwrap_err().to_string();
    assert!(
        refused.contains("line 2: force_n 'far'") && refused.contains("the columns must be"),
        "{refused}"
    );
}
