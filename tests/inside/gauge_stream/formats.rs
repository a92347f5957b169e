//! Grey values of every depth, windows of a larger buffer, low contrast, saturation, a lit part.

use shadowgauge::frame::{Buffer, FrameView, PixelFormat, Pixels};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings, Polarity};
use shadowgauge::profile::Reason;

use crate::inside::gauge_stream::gauge_synth::{Synth, drifting};

/// Rms error, rms of the stated u and share of usable upper edges.
fn figures(edges: &FrameEdges) -> (f64, f64, f64) {
    let used: Vec<(f64, f64)> = (0..edges.columns())
        .filter(|c| edges.top[*c].is_usable())
        .map(|c| (edges.top[c].row_px - drifting(c).0, edges.top[c].u_px()))
        .collect();
    let n = used.len() as f64;
    let rms = |pick: fn(&(f64, f64)) -> f64| (used.iter().map(|e| pick(e).powi(2)).sum::<f64>() / n).sqrt();
    (rms(|e| e.0), rms(|e| e.1), n / edges.columns() as f64)
}

fn gauge() -> Gauge {
    Gauge::new(GaugeSettings::default()).unwrap()
}

/// The scene of [`Synth::with_snr`] from a sensor of another depth.
fn of_depth(format: PixelFormat, snr: f64) -> Synth {
    let base = Synth::with_snr(1.0, snr, true);
    let k = f64::from(format.full_scale().unwrap()) / 4095.0;
    Synth {
        dark: k * base.dark,
        light: k * base.light,
        read: k * base.read,
        gain: k * base.gain,
        black: k * base.black,
        format,
        ..base
    }
}

#[test]
fn every_depth_is_measured_at_its_bound_with_a_true_uncertainty() {
    for format in [PixelFormat::Mono8, PixelFormat::Mono10, PixelFormat::Mono12, PixelFormat::Mono16] {
        let synth = of_depth(format, 60.0);
        let runs: Vec<(f64, f64, f64)> = (3..7)
            .map(|seed| figures(&gauge().edges(&synth.frame(drifting, Some(seed)).view()).unwrap()))
            .collect();
        let mean = |pick: fn(&(f64, f64, f64)) -> f64| {
            (runs.iter().map(|r| pick(r).powi(2)).sum::<f64>() / runs.len() as f64).sqrt()
        };
        let (rms, u, kept, bound) = (mean(|r| r.0), mean(|r| r.1), mean(|r| r.2), synth.bound(22.3));
        println!("{format:?}: rms {rms:.5}, bound {bound:.5}, u {u:.5} px, kept {kept:.4}");
        // 8192 columns: a standard deviation scatters by 0.8 %.
        let (efficient, honest) = ((0.97..1.04).contains(&(rms / bound)), (0.96..1.05).contains(&(u / rms)));
        assert!(kept > 0.97 && efficient && honest);
    }
}

#[test]
fn a_window_of_a_larger_buffer_is_the_frame_cut_out_of_it() {
    let synth = Synth::with_snr(0.9, 60.0, true);
    let Buffer::U16(sensor) = synth.frame(drifting, Some(5)).into_buffer() else { panic!("12 bit") };
    let (row, column, rows, columns) = (4, 300, 106, 700);
    let from = row * synth.columns + column;
    let window =
        FrameView::new(Pixels::U16(&sensor[from..]), PixelFormat::Mono12, rows, columns, synth.columns)
            .unwrap();
    let cut: Vec<u16> =
        (0..rows).flat_map(|r| sensor[from + r * synth.columns..][..columns].to_vec()).collect();
    let copy = FrameView::new(Pixels::U16(&cut), PixelFormat::Mono12, rows, columns, columns).unwrap();
    let (a, b) = (gauge().edges(&window).unwrap(), gauge().edges(&copy).unwrap());
    assert!(a.valid() > 680);
    for c in 0..columns {
        assert_eq!(a.top[c].row_px.to_bits(), b.top[c].row_px.to_bits());
        if let Some(width) = a.width_px(c) {
            let (top, bottom) = drifting(c + column);
            assert!((width - (bottom - top)).abs() < 0.2, "{c}: {width}");
        }
    }
}

#[test]
fn low_contrast_is_measured_with_a_larger_uncertainty_and_refused_below_the_limit() {
    let measured =
        |snr: f64| gauge().edges(&of_depth(PixelFormat::Mono12, snr).frame(drifting, Some(6)).view());
    let (good, poor) = (figures(&measured(80.0).unwrap()), figures(&measured(20.0).unwrap()));
    println!("SNR 80: {good:.4?}; SNR 20: {poor:.4?}");
    assert!((poor.1 / good.1 / 4.0 - 1.0).abs() < 0.1 && (0.9..1.1).contains(&(poor.1 / poor.0)));
    match measured(3.5) {
        Ok(edges) => {
            assert_eq!(edges.valid(), 0);
            assert!(edges.top.iter().any(|e| e.reason() == Some(Reason::LowContrast)));
        }
        Err(refused) => assert_eq!(refused.reason, Reason::LowContrast),
    }
}

#[test]
fn light_beyond_full_scale_leaves_gaps_or_edges_called_clipped_that_are_covered() {
    for (light, sigma) in [(300.0, 0.8), (360.0, 1.0)] {
        let synth = Synth {
            format: PixelFormat::Mono8,
            dark: 12.0,
            light,
            sigma,
            read: 1.0,
            gain: 0.0,
            black: 0.0,
            ..Synth::with_snr(1.0, 100.0, true)
        };
        match gauge().edges(&synth.frame(drifting, Some(7)).view()) {
            Ok(edges) => {
                let (rms, u, kept) = figures(&edges);
                println!("light {light}, blur {sigma}: rms {rms:.4}, u {u:.4}, kept {kept:.3}");
                assert!(kept == 0.0 || rms <= 2.0 * u, "light {light}: {rms} {u}");
                let usable = edges.top.iter().filter(|e| e.is_usable());
                assert!(usable.clone().all(|e| e.reason() == Some(Reason::Clipped)));
            }
            Err(refused) => println!("light {light}, blur {sigma}: {refused}"),
        }
    }
}

#[test]
fn a_lit_part_upright_is_measured_as_a_shadow_is_clipped_or_not() {
    // The part is bright here; 300 lies beyond full scale.
    for bright in [225.0, 300.0] {
        let synth = Synth {
            format: PixelFormat::Mono8,
            dark: bright,
            light: 15.0,
            sigma: 1.1,
            read: 1.0,
            gain: 0.02,
            black: 0.0,
            ..Synth::with_snr(1.0, 100.0, true)
        };
        let Buffer::U8(level) = synth.frame(drifting, Some(8)).into_buffer() else { panic!("8 bit") };
        let (rows, columns) = (synth.rows, synth.columns);
        let upright: Vec<u8> = (0..columns)
            .flat_map(|c| (0..rows).map(|r| level[r * columns + c]).collect::<Vec<u8>>())
            .collect();
        let view = FrameView::new(Pixels::U8(&upright), PixelFormat::Mono8, columns, rows, rows).unwrap();
        let settings = GaugeSettings { polarity: Polarity::BrightOnDark, ..GaugeSettings::default() };
        let edges = Gauge::new(settings).unwrap().edges(&view.transposed()).unwrap();
        let (rms, u, kept) = figures(&edges);
        let clipped = edges.top.iter().filter(|e| e.reason() == Some(Reason::Clipped)).count();
        println!("lit part of {bright}, upright: rms {rms:.4}, u {u:.4}, kept {kept:.3}, clipped {clipped}");
        assert!(kept > 0.97);
        if bright < 255.0 {
            assert!((0.93..1.07).contains(&(u / rms)) && clipped == 0);
        } else {
            assert!(rms <= 2.0 * u && clipped as f64 > 0.97 * columns as f64);
        }
        // The wrong polarity finds no shaft between the edges.
        assert!(gauge().edges(&view.transposed()).map_or(0, |e| e.valid()) == 0);
    }
}

/// Light from once to four times full scale: accepted widths lie within three times the stated u,
/// with equal errors of both edges; the others are refused as saturated.
#[test]
fn light_beyond_full_scale_is_covered_or_refused() {
    for sigma in [0.6, 1.0, 2.0] {
        for beyond in [1.0, 1.05, 1.2, 1.4, 1.5, 1.6, 1.7, 1.85, 2.0, 2.5, 3.0, 4.0] {
            let synth = Synth {
                columns: 256,
                dark: 15.0,
                light: 255.0 * beyond,
                sigma,
                format: PixelFormat::Mono8,
                read: 1.0,
                gain: 0.02,
                black: 0.0,
                ..Synth::with_snr(1.0, 100.0, true)
            };
            let edges = match gauge().edges(&synth.frame(drifting, Some(12)).view()) {
                Ok(edges) => edges,
                Err(refused) => {
                    println!("blur {sigma}, light {beyond}: {refused}");
                    assert!(refused.reason == Reason::Saturated && beyond >= 1.4, "{refused}");
                    continue;
                }
            };
            let usable: Vec<usize> = (0..256).filter(|c| edges.width_px(*c).is_some()).collect();
            let error = |c: usize| edges.width_px(c).unwrap() - (drifting(c).1 - drifting(c).0);
            let mean = usable.iter().map(|c| error(*c)).sum::<f64>() / usable.len() as f64;
            let shared = |c: usize| f64::from(edges.top[c].u_shared_px.hypot(edges.bottom[c].u_shared_px));
            let u = usable.iter().map(|c| shared(*c)).sum::<f64>() / usable.len() as f64;
            println!(
                "blur {sigma}, light {beyond}: width off by {mean:.3}, u {u:.3} px, {} columns",
                usable.len()
            );
            assert!(usable.len() > 200 && mean.abs() <= 3.0 * u, "blur {sigma}, light {beyond}: {mean} {u}");
            assert!(beyond > 1.55 || sigma > 1.2 || u < 0.1, "blur {sigma}, light {beyond}: u {u}");
        }
    }
}

/// Both sides need light beside the edge: where the field ends there, that is the reported reason.
#[test]
fn an_edge_at_the_border_is_refused_for_it() {
    let synth = Synth { columns: 256, sigma: 2.0, ..Synth::with_snr(1.0, 60.0, true) };
    let refused = gauge().edges(&synth.frame(|_| (30.2, 104.3), Some(13)).view()).unwrap_err();
    println!("{refused}");
    assert_eq!(refused.reason, Reason::Border);
}
