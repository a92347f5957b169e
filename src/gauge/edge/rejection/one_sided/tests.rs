//! Of the axis test.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;

fn lines(middle: impl Fn(usize) -> f64, half: impl Fn(usize) -> f64) -> (Vec<Edge>, Vec<Edge>) {
    let edge = |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
    // A rough, reproducible scatter of ±0.02 px.
    let scatter = |c: usize, k: usize| 0.04 * ((((c * 7919 + k * 104_729) % 1000) as f64) / 1000.0 - 0.5);
    let line = |sign: f64, k: usize| -> Vec<Edge> {
        (0..512).map(|c| edge(middle(c) + sign * half(c) + scatter(c, k))).collect()
    };
    (line(-1.0, 1), line(1.0, 2))
}

#[test]
fn form_is_kept_and_matter_on_one_side_is_refused() {
    // A step of 9 px, a taper and a bow.
    let half = |c: usize| 300.0 + if c > 200 { 9.0 } else { 0.0 } + 0.002 * c as f64;
    let middle = |c: usize| 500.0 + 0.003 * c as f64 + 4e-6 * (c as f64 - 250.0).powi(2);
    let (mut top, mut bottom) = lines(middle, half);
    assert!(refuse_one_sided(&mut top, &mut bottom, &mut AxisScratch::default()) < 1e-9);
    // Contamination 0.6 px high above, from column 300 to 420.
    for edge in &mut top[300..420] {
        edge.row_px -= 0.6;
    }
    let share = refuse_one_sided(&mut top, &mut bottom, &mut AxisScratch::default());
    assert!((0.22..0.32).contains(&share), "{share}");
    let kept = bottom.iter().filter(|e| e.is_usable()).count();
    assert!(kept >= 490, "{kept}");
    assert!((300..420).all(|c| top[c].reason() == Some(Reason::Contaminated)));
    assert!((0..280).chain(440..512).all(|c| top[c].is_usable()));
}

/// The scatter of twenty blocks has a relative standard uncertainty of a quarter: a frame that is
/// quiet by chance must not lose columns for it.
#[test]
fn a_narrow_frame_of_noise_keeps_its_columns() {
    const FRAMES: usize = 4000;
    let mut rng = Pcg64::seed_from_u64(11);
    let mut scratch = AxisScratch::default();
    let mut lost = 0;
    for _ in 0..FRAMES {
        let noise = Normal::new(0.0, 0.1).unwrap();
        let mut line = |row: f64| -> Vec<Edge> {
            let mut edge = || {
                let row_px = row + noise.sample(&mut rng);
                Edge { row_px, u_own_px: 0.1, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good }
            };
            (0..320).map(|_| edge()).collect()
        };
        let (mut top, mut bottom) = (line(100.0), line(400.0));
        lost += usize::from(refuse_one_sided(&mut top, &mut bottom, &mut scratch) > 0.03);
    }
    println!("{lost} of {FRAMES} frames of noise lose more than 3 % of their columns");
    assert!(lost <= FRAMES / 1000, "{lost}");
}

mod bumps {
    use super::*;

    /// Edges of a piece 512 columns long with a centreline deviation of `wander` px and films on
    /// the upper edge: (first column, length, height / px).
    fn lines(wander: impl Fn(f64) -> f64, films: &[(usize, usize, f64)]) -> (Vec<Edge>, Vec<Edge>) {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        let scatter = |c: usize, k: usize| 0.04 * ((((c * 7919 + k * 104_729) % 1000) as f64) / 1000.0 - 0.5);
        let film = |c: usize| -> f64 {
            let of = |f: &(usize, usize, f64)| {
                let u = (c as f64 - f.0 as f64) / f.1 as f64;
                if (0.0..1.0).contains(&u) { f.2 * (std::f64::consts::PI * u).sin().powi(2) } else { 0.0 }
            };
            films.iter().map(of).sum()
        };
        let top = (0..512).map(|c| edge(300.0 + wander(c as f64) - film(c) + scatter(c, 1))).collect();
        let bottom = (0..512).map(|c| edge(900.0 + wander(c as f64) + scatter(c, 2))).collect();
        (top, bottom)
    }

    #[test]
    fn films_that_share_a_field_with_gaps_are_found_by_their_ends() {
        let (mut top, mut bottom) = lines(|c| 0.002 * c, &[(20, 120, 0.9), (230, 130, 0.8)]);
        for edge in &mut bottom[390..470] {
            edge.state = EdgeState::Gap(Reason::Residual);
        }
        refuse_one_sided(&mut top, &mut bottom, &mut AxisScratch::default());
        let kept = |c: usize| top[c].is_usable() && bottom[c].is_usable();
        assert!(!(50..110).chain(260..330).any(kept));
    }

    #[test]
    fn an_axis_that_waves_is_kept() {
        for wave in [120.0, 240.0, 480.0] {
            let (mut top, mut bottom) = lines(|c| 0.4 * (c / wave * std::f64::consts::TAU).sin(), &[]);
            let share = refuse_one_sided(&mut top, &mut bottom, &mut AxisScratch::default());
            assert!(share < 1e-9, "wave of {wave} columns: {share}");
        }
    }
}

/// Noise and hot pixels refuse less than one edge in twenty-five; a field of which contamination
/// hides seven columns in a hundred counts as contaminated.
#[test]
fn a_field_is_contaminated_where_seven_columns_in_a_hundred_are_hidden() {
    let hidden = |count: usize| {
        let (mut top, bottom) = lines(|_| 500.0, |_| 300.0);
        top[..count].fill(Edge::gap(Reason::Outlier));
        is_contaminated(&top, &bottom)
    };
    assert!(!hidden(512 * 4 / 100) && hidden(512 * 7 / 100));
}
