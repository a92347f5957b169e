//! Sensors that are more than the noise of their pixels: row, column and pixel shares after EMVA
//! 1288 release 4, row noise, response, cross-talk.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::render as support;

use shadowgauge::frame::{PixelFormat, Roi};
use shadowgauge::render::settings::{Readout, SetupDeviations, SetupSettings, SpatialShares};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::Shaft;
use support::{counts, device};

/// Frames of a mean field.
const FRAMES: u64 = 12;

/// Rows of the field that the wire in its middle does not reach.
const WIRE: std::ops::Range<usize> = 285..315;

fn bench() -> SetupSettings {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    settings.camera.rows = 600;
    settings.camera.columns = 500;
    settings.light.shadow_counts = 64.0;
    settings.light.bright_counts = 2564.0;
    settings.sensor.dsnu_e = 7.0;
    settings.sensor.prnu_rel = 0.013;
    settings
}

fn scene(settings: &SetupSettings) -> Scene {
    let setup = OpticalSetup::resolve(settings, 5).unwrap();
    Scene::new(&setup, Shaft::cylinder(0.1)).unwrap()
}

fn shot(renderer: &Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f64> {
    counts(&renderer.render(scene, request, None).unwrap())
}

fn twin() -> Renderer {
    Renderer::new(BackendChoice::Cpu).unwrap()
}

/// Frames' mean over the rows without the wire, and the number of those rows.
fn mean_field(settings: &SetupSettings, frames: u64) -> (Vec<f64>, usize) {
    let (scene, renderer) = (scene(settings), twin());
    let columns = settings.camera.columns as usize;
    let mut sum = Vec::new();
    for frame_id in 0..frames {
        let request = FrameRequest { frame_id, noise: true, seed: 3, ..Default::default() };
        let frame = shot(&renderer, &scene, &request);
        let clear = frame.chunks_exact(columns).enumerate().filter(|(row, _)| !WIRE.contains(row));
        let field: Vec<f64> = clear.flat_map(|(_, line)| line.iter().copied()).collect();
        sum.resize(field.len(), 0.0);
        sum.iter_mut().zip(&field).for_each(|(s, v)| *s += v / frames as f64);
    }
    let rows = sum.len() / columns;
    (sum, rows)
}

fn variance(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// Row, column and pixel variance of a field: means of rows hold 1/N of the pixels' variance, means
/// of columns 1/M (EMVA 1288 release 4.0, split of the spatial variance, for large M and N).
fn split(field: &[f64], rows: usize) -> [f64; 3] {
    let columns = field.len() / rows;
    let row_means: Vec<f64> =
        field.chunks_exact(columns).map(|l| l.iter().sum::<f64>() / columns as f64).collect();
    let column_means: Vec<f64> =
        (0..columns).map(|c| field.iter().skip(c).step_by(columns).sum::<f64>() / rows as f64).collect();
    let (total, rav, cav) = (variance(field), variance(&row_means), variance(&column_means));
    let pixel = (total - rav - cav) / (1.0 - 1.0 / rows as f64 - 1.0 / columns as f64);
    [rav - pixel / columns as f64, cav - pixel / rows as f64, pixel]
}

#[test]
fn shares_of_rows_columns_and_pixels_are_found_in_flat_fields() {
    let mut settings = bench();
    let shares =
        SpatialShares { dsnu_row_e: 2.0, dsnu_column_e: 3.0, prnu_row_rel: 0.004, prnu_column_rel: 0.003 };
    settings.sensor.spatial = Some(shares);
    let (bright, rows) = mean_field(&settings, FRAMES);
    settings.light.bright_counts = 64.0;
    let (dark, _) = mean_field(&settings, FRAMES);
    let gain = settings.sensor.electrons_per_count;
    let read = (settings.sensor.read_noise_e / gain).powi(2) + 1.0 / 12.0;
    let (dark, bright) = (split(&dark, rows), split(&bright, rows));
    let light = 2500.0;
    let shot = light / gain;
    for (name, found, set) in [
        ("DSNU row", dark[0].sqrt() * gain, 2.0),
        ("DSNU column", dark[1].sqrt() * gain, 3.0),
        ("DSNU pixel", (dark[2] - read / FRAMES as f64).sqrt() * gain, 6.0),
        ("PRNU row", (bright[0] - dark[0]).sqrt() / light, 0.004),
        ("PRNU column", (bright[1] - dark[1]).sqrt() / light, 0.003),
        ("PRNU pixel", (bright[2] - dark[2] - shot / FRAMES as f64).sqrt() / light, 0.012),
    ] {
        println!("{name}: {found:.5} for {set}");
        // Offsets and gains of 500 columns correlate by 1/√500, which is 4 % of the smaller one.
        assert!((found / set - 1.0).abs() < 0.04, "{name}: {found} for {set}");
    }
}

#[test]
fn row_noise_is_new_in_every_frame_and_leaves_the_dark_noise_as_stated() {
    let mut settings = bench();
    settings.light.bright_counts = 64.0;
    (settings.sensor.dsnu_e, settings.sensor.prnu_rel) = (0.0, 0.0);
    (settings.sensor.read_noise_e, settings.sensor.electrons_per_count) = (5.0, 0.5);
    settings.sensor.readout = Some(Readout { row_noise_e: 3.0, ..Readout::default() });
    let (scene, renderer) = (scene(&settings), twin());
    let frame = |frame_id| {
        shot(&renderer, &scene, &FrameRequest { frame_id, noise: true, seed: 3, ..Default::default() })
    };
    let columns = settings.camera.columns as usize;
    // Difference of two frames: twice the variance, without any pattern.
    let apart: Vec<f64> = frame(0).iter().zip(&frame(1)).map(|(a, b)| a - b).collect();
    let rows: Vec<f64> =
        apart.chunks_exact(columns).map(|l| l.iter().sum::<f64>() / columns as f64).collect();
    let row_e = (variance(&rows) / 2.0).sqrt() * 0.5;
    let all_e = (variance(&apart) / 2.0).sqrt() * 0.5;
    // 600 rows: 3 % of their standard deviation is one standard error.
    assert!((row_e / 3.0 - 1.0).abs() < 0.1, "{row_e}");
    assert!((all_e / 5.0 - 1.0).abs() < 0.04, "{all_e}");
}

#[test]
fn response_follows_its_polynomial() {
    let mut settings = bench();
    (settings.sensor.dsnu_e, settings.sensor.prnu_rel) = (0.0, 0.0);
    settings.sensor.readout = Some(Readout { quadratic_rel: -0.03, cubic_rel: 0.01, ..Readout::default() });
    let full = settings.sensor.full_well_e / settings.sensor.electrons_per_count;
    for bright in [64.0, 564.0, 2064.0, 3564.0] {
        settings.light.bright_counts = bright;
        let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
        let seen = shot(&twin(), &scene(&settings), &request)[0];
        let (s, x) = (bright - 64.0, (bright - 64.0) / full);
        let expected = 64.0 + s * (1.0 - 0.03 * x + 0.01 * x * x);
        assert!((seen - expected).abs() < 1e-3, "{bright}: {seen} for {expected}");
    }
}

/// Cross-talk of means is a convolution of the frame without it.
#[test]
fn crosstalk_is_a_convolution_also_at_the_borders_of_a_window() {
    let mut settings = bench();
    (settings.sensor.dsnu_e, settings.sensor.prnu_rel) = (0.0, 0.0);
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let plain = shot(&twin(), &scene(&settings), &request);
    let (along, down) = (0.01, 0.03);
    settings.sensor.readout =
        Some(Readout { crosstalk_along_rel: along, crosstalk_down_rel: down, ..Readout::default() });
    let (mixed_scene, columns) = (scene(&settings), settings.camera.columns as usize);
    let mixed = shot(&twin(), &mixed_scene, &request);
    let at = |row: usize, column: usize| plain[row * columns + column];
    let mut moved: f64 = 0.0;
    for row in 280..320 {
        for column in [0, 1, 250, columns - 1] {
            let (left, right) = (column.saturating_sub(1), (column + 1).min(columns - 1));
            let m = at(row, column);
            let expected = m
                + along * (at(row, left) + at(row, right) - 2.0 * m)
                + down * (at(row - 1, column) + at(row + 1, column) - 2.0 * m);
            let seen = mixed[row * columns + column];
            moved = moved.max((seen - m).abs());
            assert!((seen - expected).abs() < 2e-3, "{row} {column}: {seen} for {expected}");
        }
    }
    assert!(moved > 10.0, "no light moved: {moved}");
    // Windows read what the full frame has, with noise, in one and in two parts.
    let noisy = FrameRequest { noise: true, seed: 9, ..Default::default() };
    let full = shot(&twin(), &mixed_scene, &noisy);
    let crop = |roi: &Roi| -> Vec<f64> {
        let rows = roi.row as usize..(roi.row + roi.rows) as usize;
        let of = |r: usize| full[r * columns + roi.column as usize..][..roi.columns as usize].to_vec();
        rows.flat_map(of).collect()
    };
    let upper = Roi { row: 286, column: 7, rows: 14, columns: 300 };
    for gap in [0, 1, 2] {
        let lower = Roi { row: 300 + gap, rows: 14 - gap, ..upper };
        let request = FrameRequest { roi: Some(upper), second_roi: Some(lower), ..noisy.clone() };
        assert_eq!(shot(&twin(), &mixed_scene, &request), [crop(&upper), crop(&lower)].concat(), "{gap}");
    }
    let all = Roi { rows: 28, ..upper };
    let request = FrameRequest { roi: Some(all), ..noisy };
    assert_eq!(shot(&twin(), &mixed_scene, &request), crop(&all));
}

#[test]
fn zeros_leave_every_frame_as_it_was() {
    let mut settings = bench();
    let request = FrameRequest { noise: true, seed: 4, ..Default::default() };
    let plain = shot(&twin(), &scene(&settings), &request);
    settings.sensor.spatial = Some(SpatialShares::default());
    settings.sensor.readout = Some(Readout::default());
    assert_eq!(shot(&twin(), &scene(&settings), &request), plain);
}

fn everything() -> SetupSettings {
    let mut settings = bench();
    settings.sensor.spatial = Some(SpatialShares {
        dsnu_row_e: 2.0,
        dsnu_column_e: 3.0,
        prnu_row_rel: 0.004,
        prnu_column_rel: 0.003,
    });
    settings.sensor.readout = Some(Readout {
        row_noise_e: 1.0,
        quadratic_rel: -0.01,
        cubic_rel: 0.005,
        crosstalk_along_rel: 0.004,
        crosstalk_down_rel: 0.006,
    });
    settings
}

#[test]
fn the_device_reads_out_what_the_twin_reads_out() {
    let Some(device) = device() else { return };
    let scene = scene(&everything());
    for format in [PixelFormat::Mono8, PixelFormat::Mono12] {
        let request = FrameRequest { noise: true, seed: 4, format: Some(format), ..Default::default() };
        let (a, b) = (shot(&device, &scene, &request), shot(&twin(), &scene, &request));
        let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count();
        // Adapters that fuse multiply-adds round a mean differently where it lies at a half.
        assert!(differ as f64 <= 1e-4 * a.len() as f64, "{format:?}: {differ} pixels");
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1.0), "{format:?}");
    }
}

/// The same counts in half the bits: levels, noise and response scale with the format.
#[test]
fn eight_bits_are_twelve_bits_shortened() {
    let scene = scene(&everything());
    let shot_in = |format| {
        shot(
            &twin(),
            &scene,
            &FrameRequest { noise: true, seed: 4, format: Some(format), ..Default::default() },
        )
    };
    let (short, long) = (shot_in(PixelFormat::Mono8), shot_in(PixelFormat::Mono12));
    let worst = short.iter().zip(&long).map(|(s, l)| (s - l / 16.0).abs()).fold(0.0, f64::max);
    // Half a count of rounding, and half of one in sixteen.
    assert!(worst <= 0.5 + 0.5 / 16.0 + 0.01, "{worst}");
}

/// Figures of a file beside the config, under the keys that the config sets itself.
#[test]
fn a_data_sheet_beside_the_config_gives_what_the_config_leaves_out() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let load = || shadowgauge::config::load_scene(&folder.path().join("job.toml"));
    write(
        "results.xml",
        "<results><sensitivity><K><Value>0.5</Value></K><sigma_d><Value>3.0</Value></sigma_d>\
         <QE><Value>70</Value></QE></sensitivity><spatial><PRNU1288><Value>0.5</Value></PRNU1288>\
         <PRNU1288_row><Value>0.3</Value></PRNU1288_row></spatial></results>",
    );
    write("job.toml", "[sensor]\ndata_sheet = \"results.xml\"\nread_noise_e = 9.0\n");
    let sensor = load().unwrap().sensor;
    assert_eq!((sensor.electrons_per_count, sensor.read_noise_e, sensor.quantum_efficiency), (2.0, 9.0, 0.7));
    assert_eq!((sensor.prnu_rel, sensor.spatial.unwrap().prnu_row_rel), (0.005, 0.003));
    // The resolved config needs no file.
    assert_eq!(sensor.data_sheet, None);
    write("results.xml", "<results></results>");
    let refused = load().unwrap_err().to_string();
    assert!(refused.contains("sensor.data_sheet") && refused.contains("no system gain"), "{refused}");
}
