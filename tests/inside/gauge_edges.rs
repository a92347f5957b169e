//! Edges on synthetic frames: error against the Cramér-Rao bound, kept columns, phase bias,
//! consistency of the uncertainty.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

#[path = "gauge_edges/esf.rs"]
mod esf;
use crate::inside::support::gauge_synth;
#[path = "gauge_edges/contamination.rs"]
mod contamination;

use gauge_synth::{Synth, drifting};
use shadowgauge::frame::PixelFormat;
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};
use shadowgauge::profile::Reason;

fn gauge() -> Gauge {
    Gauge::new(GaugeSettings::default()).unwrap()
}

/// Sums over one cell of the table.
#[derive(Default)]
struct Cell {
    square: f64,
    bound_square: f64,
    u_square: f64,
    kept: usize,
    all: usize,
    error_sum: f64,
    /// Groups of 9 and of 100 columns: (squared error of the mean, squared u), count.
    groups: [(f64, f64, usize); 2],
}

impl Cell {
    fn add(&mut self, synth: &Synth, edges: &FrameEdges) {
        for (line, is_top) in [(&edges.top, true), (&edges.bottom, false)] {
            let truth = |c: usize| if is_top { drifting(c).0 } else { drifting(c).1 };
            for (column, edge) in line.iter().enumerate() {
                self.all += 1;
                if edge.is_usable() {
                    let error = edge.row_px - truth(column);
                    self.kept += 1;
                    self.error_sum += error;
                    self.square += error * error;
                    self.u_square += edge.u_px().powi(2);
                    self.bound_square += synth.bound(truth(column)).powi(2);
                }
            }
            let length = edges.shared_length[usize::from(!is_top)];
            for (group, size) in [9, 100].into_iter().enumerate() {
                for start in (0..line.len() - size + 1).step_by(size) {
                    if let Some(mean) = FrameEdges::mean(line, length, start..start + size) {
                        let usable: Vec<f64> =
                            (start..start + size).filter(|c| line[*c].is_usable()).map(truth).collect();
                        let error = mean.value_px - usable.iter().sum::<f64>() / usable.len() as f64;
                        let sums = &mut self.groups[group];
                        *sums = (sums.0 + error * error, sums.1 + mean.u_px.powi(2), sums.2 + 1);
                    }
                }
            }
        }
    }

    fn sum(cells: &[Self]) -> Self {
        cells.iter().fold(Self::default(), |mut sum, cell| {
            sum.square += cell.square;
            sum.bound_square += cell.bound_square;
            sum.u_square += cell.u_square;
            sum.kept += cell.kept;
            sum.all += cell.all;
            sum.error_sum += cell.error_sum;
            for (a, b) in sum.groups.iter_mut().zip(&cell.groups) {
                *a = (a.0 + b.0, a.1 + b.1, a.2 + b.2);
            }
            sum
        })
    }

    /// RMSE over the bound, fraction kept, rms(u)/rms(error) for single columns and means of 9
    /// and 100.
    fn figures(&self) -> (f64, f64, [f64; 3]) {
        let ratio = |g: (f64, f64, usize)| (g.1 / g.0).sqrt();
        (
            (self.square / self.bound_square).sqrt(),
            self.kept as f64 / self.all as f64,
            [(self.u_square / self.square).sqrt(), ratio(self.groups[0]), ratio(self.groups[1])],
        )
    }
}

#[test]
fn error_reaches_the_bound_and_uncertainty_is_true() {
    let mut worst = String::new();
    for shot in [false, true] {
        for sigma in [0.5, 0.8, 1.2, 2.0] {
            for snr in [20.0, 60.0, 200.0] {
                let synth = Synth::with_snr(sigma, snr, shot);
                let mut cell = Cell::default();
                for seed in 0..3 {
                    let frame = synth.frame(drifting, Some(seed + 1000));
                    cell.add(&synth, &gauge().edges(&frame.view()).unwrap());
                }
                let (ratio, kept, honesty) = cell.figures();
                let bias = cell.error_sum / cell.kept as f64;
                println!(
                    "shot {shot:5} sigma {sigma} snr {snr:5}: RMSE/bound {ratio:.4} kept {kept:.4} u/sd 1: {:.3} 9: {:.3} 100: {:.3} bias {bias:.5}",
                    honesty[0], honesty[1], honesty[2]
                );
                // Means of 100: 120 groups a cell, so their ratio itself scatters by 6 %; the next
                // test is stricter.
                let fine = ratio <= 1.05
                    && kept >= 0.99
                    && (honesty[0] - 1.0).abs() < 0.10
                    && (honesty[1] - 1.0).abs() < 0.10
                    && (honesty[2] - 1.0).abs() < 0.20;
                if !fine {
                    worst += &format!("shot {shot} sigma {sigma} snr {snr}; ");
                }
            }
        }
    }
    assert!(worst.is_empty(), "outside the limits: {worst}");
}

#[test]
fn uncertainty_of_means_is_true() {
    for (sigma, snr, shot) in [(0.8, 60.0, true), (1.2, 30.0, false)] {
        let synth = Synth { rows: 112, ..Synth::with_snr(sigma, snr, shot) };
        let mut cell = Cell::default();
        for seed in 0..16 {
            let frame = synth.frame(drifting, Some(seed + 77_000));
            cell.add(&synth, &gauge().edges(&frame.view()).unwrap());
        }
        let (_, _, honesty) = cell.figures();
        println!(
            "sigma {sigma} snr {snr}: u/sd 1: {:.3} 9: {:.3} 100: {:.3}",
            honesty[0], honesty[1], honesty[2]
        );
        // 640 means of 100: their ratio scatters by 2.8 %.
        assert!(honesty.iter().all(|h| (h - 1.0).abs() < 0.10), "{honesty:?}");
    }
}

/// The position of windows centred by the area of their light is correlated with the noise in their
/// flat ends: levels estimated there were too low on both sides and the shadow too narrow by 0.015
/// px at this noise.
#[test]
fn noise_does_not_narrow_the_shadow() {
    let synth = Synth::with_snr(2.0, 20.0, false);
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 0..8 {
        let edges = gauge().edges(&synth.frame(drifting, Some(seed + 31_000)).view()).unwrap();
        for column in 0..edges.columns() {
            if let Some(width) = edges.width_px(column) {
                let (top, bottom) = drifting(column);
                sum += width - (bottom - top);
                count += 1.0;
            }
        }
    }
    // A column's width has a standard deviation of 0.19 px, and the levels of a frame
    // contribute 0.004 px.
    println!("mean of {count} widths is off by {:.5} px", sum / count);
    assert!(count > 16_000.0 && (sum / count).abs() < 0.007, "{}", sum / count);
}

/// The clipped bright field of an 8-bit camera: flagged, measured, and its larger uncertainty
/// covers the error.
#[test]
fn clipped_edges_are_flagged_and_covered() {
    for light in [252.0, 262.0, 300.0, 360.0] {
        let synth = Synth {
            format: PixelFormat::Mono8,
            dark: 15.0,
            light,
            sigma: 1.1,
            read: 1.0,
            gain: 0.02,
            black: 0.0,
            ..Synth::with_snr(1.0, 100.0, true)
        };
        let edges = gauge().edges(&synth.frame(drifting, Some(5)).view()).unwrap();
        let used: Vec<(f64, f64)> = (0..edges.columns())
            .filter(|c| edges.top[*c].is_usable())
            .map(|c| (edges.top[c].row_px - drifting(c).0, edges.top[c].u_px()))
            .collect();
        let n = used.len() as f64;
        let mean = used.iter().map(|e| e.0).sum::<f64>() / n;
        let rms = (used.iter().map(|e| e.0 * e.0).sum::<f64>() / n).sqrt();
        let u = (used.iter().map(|e| e.1 * e.1).sum::<f64>() / n).sqrt();
        let clipped = edges.top.iter().filter(|e| e.reason() == Some(Reason::Clipped)).count();
        println!("light {light}: kept {n}, flagged {clipped}, mean error {mean:.4}, rms {rms:.4}, u {u:.4}");
        assert!(n >= 0.99 * edges.columns() as f64);
        assert!(light < 260.0 || clipped as f64 == n);
        assert!(rms <= 2.0 * u, "light {light}: rms {rms} against u {u}");
    }
}

#[test]
fn noise_free_frames_have_no_phase_bias() {
    for sigma in [0.5, 0.8, 1.2, 2.0] {
        let synth = Synth { format: PixelFormat::F32, ..Synth::with_snr(sigma, 100.0, true) };
        let frame = synth.frame(drifting, None);
        let edges = gauge().edges(&frame.view()).unwrap();
        let mut worst: f64 = 0.0;
        for column in 0..edges.columns() {
            let (top, bottom) = drifting(column);
            worst = worst.max((edges.top[column].row_px - top).abs());
            worst = worst.max((edges.bottom[column].row_px - bottom).abs());
        }
        println!("sigma {sigma}: worst {worst:.2e} px, sigma found {:?}", edges.figures.sigma_px);
        assert!(worst <= 1e-3, "sigma {sigma}: {worst}");
    }
}

/// Every cell with 400 000 edges for the efficiency and 4000 means of 100 (the ratio of their u
/// then scatters by 1.1 %). Long: `make studies` runs it.
#[test]
#[ignore = "a study of a minute: every cell of the table at its full count"]
fn efficiency_and_honesty_in_every_cell() {
    use rayon::prelude::*;
    let mut failures = String::new();
    println!("noise     sigma   snr  efficiency  kept    rms(u)/sd: single  of 9   of 100");
    for shot in [false, true] {
        for sigma in [0.5, 0.8, 1.2, 2.0] {
            for snr in [20.0, 60.0, 200.0] {
                let synth = Synth { rows: 112, ..Synth::with_snr(sigma, snr, shot) };
                let cells: Vec<Cell> = (0..100_u64)
                    .into_par_iter()
                    .map(|seed| {
                        let mut cell = Cell::default();
                        let frame = synth.frame(drifting, Some(seed + 500_000));
                        cell.add(&synth, &gauge().edges(&frame.view()).unwrap());
                        cell
                    })
                    .collect();
                let (ratio, kept, honesty) = Cell::sum(&cells).figures();
                let efficiency = ratio.powi(-2);
                println!(
                    "{} {sigma:5} {snr:6}  {efficiency:9.4}  {kept:.4}  {:16.3} {:7.3} {:7.3}",
                    if shot { "shot    " } else { "additive" },
                    honesty[0],
                    honesty[1],
                    honesty[2]
                );
                if !(efficiency >= 0.95 && kept >= 0.97 && honesty.iter().all(|h| (h - 1.0).abs() <= 0.05)) {
                    failures += &format!("shot {shot} sigma {sigma} snr {snr}; ");
                }
            }
        }
    }
    assert!(failures.is_empty(), "outside the limits: {failures}");
}
