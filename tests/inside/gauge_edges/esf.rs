//! Edge-spread functions other than the Gaussian: given as a table, estimated from the frame, and
//! the error of a wrong one.

use crate::inside::gauge_edges::gauge_synth::{Synth, drifting};
use shadowgauge::frame::PixelFormat;
use shadowgauge::gauge::{EsfModel, EsfSamples, FrameEdges, Gauge, GaugeSettings};
use shadowgauge::render::esf_families::{EdgeSpread, PartiallyCoherentEdge};

/// λ/NA in pixels of the frames.
const UNIT_PX: f64 = 3.0;

/// A telecentric lens in focus; distances in px.
fn diffraction(coherence_ratio: f64, unit_px: f64) -> (EdgeSpread, f64) {
    let edge = PartiallyCoherentEdge { coherence_ratio, ..PartiallyCoherentEdge::default() };
    let pixel_um = edge.unit_um() / unit_px;
    (edge.edge_spread().unwrap(), pixel_um)
}

/// The light over a pixel by Gauss-Legendre over the table's values: a method other than the
/// gauge's integral.
fn over_pixel(spread: &EdgeSpread, pixel_um: f64, d_px: f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189),
        (-0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.0, 0.568_888_888_888_889),
        (0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.906_179_845_938_664, 0.236_926_885_056_189),
    ];
    let halves = [-0.25, 0.25];
    let at = |x: f64| spread.value((d_px + x) * pixel_um);
    halves.iter().map(|h| NODES.iter().map(|(x, w)| 0.25 * w * at(h + 0.25 * x)).sum::<f64>()).sum()
}

fn gauge(esf: EsfModel) -> Gauge {
    Gauge::new(GaugeSettings { esf, ..GaugeSettings::default() }).unwrap()
}

/// Mean error, largest departure from it by the phase (64 columns a bin of the phase, sorted), of
/// both lines.
fn phase_bias(edges: &FrameEdges) -> (f64, f64) {
    let (mut mean, mut worst) = (0.0_f64, 0.0_f64);
    for (line, top) in [(&edges.top, true), (&edges.bottom, false)] {
        let truth = |c: usize| if top { drifting(c).0 } else { drifting(c).1 };
        let mut errors: Vec<(f64, f64)> = (0..line.len())
            .filter(|c| line[*c].is_usable())
            .map(|c| (truth(c).rem_euclid(1.0), line[c].row_px - truth(c)))
            .collect();
        assert!(errors.len() > 1000, "{}", errors.len());
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = errors.iter().map(|e| e.1).sum::<f64>() / errors.len() as f64;
        mean = mean.max(all.abs());
        for bin in errors.chunks_exact(64) {
            worst = worst.max((bin.iter().map(|e| e.1).sum::<f64>() / 64.0 - all).abs());
        }
    }
    (mean, worst)
}

fn still() -> Synth {
    Synth { format: PixelFormat::F32, ..Synth::with_snr(1.0, 100.0, true) }
}

/// A gauge that is given the table of a spread.
fn given(spread: &EdgeSpread, pixel_um: f64) -> Gauge {
    let distance_px: Vec<f64> = (-400..=400).map(|k| f64::from(k) * 0.05).collect();
    let light: Vec<f64> = distance_px.iter().map(|d| spread.value(d * pixel_um)).collect();
    gauge(EsfModel::Table(EsfSamples { distance_px, light }))
}

#[test]
fn a_given_diffraction_edge_is_placed_without_phase_bias() {
    for coherence in [0.5, 1.0, 1.5] {
        let (spread, pixel_um) = diffraction(coherence, UNIT_PX);
        let frame = still().frame_of(drifting, |d| over_pixel(&spread, pixel_um, d), None);
        let given = given(&spread, pixel_um).edges(&frame.view()).unwrap();
        let plain = gauge(EsfModel::Gaussian {}).edges(&frame.view()).unwrap();
        let learnt = gauge(EsfModel::Learnt {}).edges(&frame.view()).unwrap();
        let (mean, worst) = phase_bias(&given);
        let (gaussian_mean, gaussian) = phase_bias(&plain);
        let (learnt_mean, by_phase) = phase_bias(&learnt);
        println!(
            "S {coherence}: given {worst:.5} px over the phase (mean {mean:.5}), learnt {by_phase:.5} ({learnt_mean:.4}), Gaussian {gaussian:.5} ({gaussian_mean:.4}); sigma {:?} {:?}",
            given.figures.sigma_px, plain.figures.sigma_px
        );
        assert!(worst <= 1e-3, "S {coherence}: {worst}");
        assert!(by_phase <= 2e-3, "S {coherence}: {by_phase}");
        // The position that an estimated function leaves undetermined is stated: width of both
        // edges, standard uncertainty of a rectangle.
        let stated = learnt.figures.u_position_px();
        assert!(2.0 * learnt_mean < 2.0 * stated && stated < 0.5, "S {coherence}: {learnt_mean} {stated}");
        assert_eq!(given.figures.u_position_px() + plain.figures.u_position_px(), 0.0);
    }
}

/// Edges sharper than a pixel: their blur is smaller than any that a frame can determine.
#[test]
fn a_given_edge_sharper_than_a_pixel_is_placed_without_bias() {
    for (coherence, unit_px) in [(0.5, 2.0), (0.5, 1.1), (0.8, 0.9), (0.8, 0.55)] {
        let (spread, pixel_um) = diffraction(coherence, unit_px);
        let frame = still().frame_of(drifting, |d| over_pixel(&spread, pixel_um, d), None);
        let found = given(&spread, pixel_um).edges(&frame.view()).unwrap();
        let (mean, worst) = phase_bias(&found);
        println!(
            "S {coherence}, {unit_px} px: {worst:.5} px over the phase (mean {mean:.5}), sigma {:?}",
            found.figures.sigma_px
        );
        assert!(worst <= 1e-3 && mean <= 2e-3, "S {coherence}, {unit_px} px: {worst} {mean}");
    }
}

/// The error of an estimated function under noise: equal to that with the given edge, and that of
/// the Gaussian is not smaller.
#[test]
fn a_learnt_edge_is_as_good_as_a_given_one_in_noise() {
    let (spread, pixel_um) = diffraction(0.5, UNIT_PX);
    let synth = Synth { format: PixelFormat::Mono16, ..Synth::with_snr(1.0, 80.0, true) };
    let frame = synth.frame_of(drifting, |d| over_pixel(&spread, pixel_um, d), Some(3));
    let scatter = |gauge: Gauge| {
        let edges = gauge.edges(&frame.view()).unwrap();
        let errors: Vec<f64> = (0..2048)
            .filter(|c| edges.top[*c].is_usable())
            .map(|c| edges.top[c].row_px - drifting(c).0)
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let square = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        (errors.len(), (square / errors.len() as f64).sqrt(), edges.figures.reduced_chi2)
    };
    let (given, learnt) = (scatter(given(&spread, pixel_um)), scatter(gauge(EsfModel::Learnt {})));
    let gaussian = scatter(gauge(EsfModel::Gaussian {}));
    println!("kept, scatter px, misfit: given {given:?}, learnt {learnt:?}, Gaussian {gaussian:?}");
    assert!(given.0 >= 2040 && learnt.0 >= 2000, "{given:?} {learnt:?}");
    assert!(learnt.1 <= 1.05 * given.1, "{learnt:?} {given:?}");
}

/// An edge along a row has one phase only: no function can be estimated, and the frame is measured
/// with the Gaussian.
#[test]
fn an_edge_along_the_rows_teaches_nothing() {
    let frame = Synth::with_snr(0.9, 80.0, true).frame(|_| (22.3, 89.6), Some(1));
    let learnt = gauge(EsfModel::Learnt {}).edges(&frame.view()).unwrap();
    let plain = gauge(EsfModel::Gaussian {}).edges(&frame.view()).unwrap();
    assert_eq!(learnt.top, plain.top);
}

#[test]
fn a_table_that_is_none_is_refused_by_its_key() {
    let refused = |distance_px: Vec<f64>, light: Vec<f64>| {
        let esf = EsfModel::Table(EsfSamples { distance_px, light });
        let settings = GaugeSettings { esf, ..GaugeSettings::default() };
        Gauge::new(settings).unwrap_err().to_string()
    };
    let d: Vec<f64> = (-8..=8).map(f64::from).collect();
    let l: Vec<f64> = d.iter().map(|d| if *d < 0.0 { 0.0 } else { 1.0 }).collect();
    assert!(refused(vec![0.0, 1.0], vec![0.0, 1.0]).contains("esf.table.distance_px = 2"));
    assert!(refused(d.clone(), l[1..].to_vec()).contains("as many values"));
    assert!(refused(d.iter().rev().copied().collect(), l.clone()).contains("rising"));
    assert!(refused(d.clone(), l.iter().map(|l| 0.8 * l).collect()).contains("1 at the last distance"));
    assert!(refused(d.clone(), l.iter().map(|l| 0.1 + 0.9 * l).collect()).contains("0 at the first"));
    assert!(refused(d.clone(), vec![f64::NAN; 17]).contains("shares of the bright field"));
    assert!(refused(d.iter().map(|d| d + 20.0).collect(), l).contains("both sides"));
}
