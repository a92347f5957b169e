//! Edge-spread families, defocus and the sensor against independent values.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::render as support;

use std::f64::consts::{PI, TAU};

use shadowgauge::frame::PixelFormat;
use shadowgauge::render::esf_families::{
    EdgeSpread, GaussianBlur, GrazingReflection, LaserShadow, MeasuredEsf, PartiallyCoherentEdge, Shifts,
};
use shadowgauge::render::lens::FieldCurvature;
use shadowgauge::render::reference::StraightReference;
use shadowgauge::render::settings::{Esf, GaussianEsf, SetupDeviations, SetupSettings};
use shadowgauge::render::{
    BackendChoice, FrameRequest, OpticalSetup, RenderError, Renderer, Scene, geometric_edges,
};
use shadowgauge::shaft::{AxisKnot, ProfileKnot, Shaft};
use support::*;

// ---- partially coherent

/// The same image by another method: a grating of period `L` expanded in harmonics, the source in
/// rings of equal area.
fn by_harmonics(s: f64, zeta: f64, x: f64) -> f64 {
    let period = 400.0;
    let (rings, around) = (40, 36);
    let (mut sum, mut full) = (0.0, 0.0);
    for i in 0..rings {
        for j in 0..around {
            let r = s * ((f64::from(i) + 0.5) / f64::from(rings)).sqrt();
            let (sin, cos) = (PI * (f64::from(j) + 0.5) / f64::from(around)).sin_cos();
            let (sx, sy) = (r * cos, r * sin);
            full += f64::from(u8::from(sx.hypot(sy) < 1.0));
            let (mut re, mut im) = (0.0, 0.0);
            let harmonics = (period * (1.0 + s)) as i32;
            for n in -harmonics..=harmonics {
                let f = f64::from(n) / period;
                let rho2 = (f + sx).powi(2) + sy * sy;
                if rho2 > 1.0 || (n % 2 == 0 && n != 0) {
                    continue;
                }
                // Light on 0..L/2: 1/2 at n = 0, 1/(iπn) at odd n.
                let phase = PI * zeta * rho2 + TAU * f * x;
                if n == 0 {
                    re += 0.5 * phase.cos();
                    im += 0.5 * phase.sin();
                } else {
                    re += phase.sin() / (PI * f64::from(n));
                    im -= phase.cos() / (PI * f64::from(n));
                }
            }
            sum += re * re + im * im;
        }
    }
    sum / full
}

#[test]
fn partially_coherent_edge_meets_a_third_integration() {
    let mut worst: f64 = 0.0;
    // Up to S = 0.85: at the pupil's rim harmonics converge too slowly for a comparison; there
    // Abbe's sum and the exact 1/3 at S = 1 are used.
    for (s, zeta) in [(0.3, 0.0), (0.7, 0.0), (0.85, 0.0), (0.5, 1.0), (0.5, 2.0)] {
        // λ/NA = 1 µm, λ/NA² = 2 µm.
        let edge = PartiallyCoherentEdge {
            na: 0.5,
            coherence_ratio: s,
            wavelength_nm: 500.0,
            defocus_mm: zeta * 2e-3,
            ..Default::default()
        };
        let table = edge.edge_spread().unwrap();
        for x in [-1.0, -0.3, 0.0, 0.1, 0.5, 1.3] {
            let difference = (table.value(x) - by_harmonics(s, zeta, x)).abs();
            worst = worst.max(difference);
            println!("S {s} defocus {zeta} x {x}: {difference:.1e}");
        }
    }
    println!("worst {worst:.1e} of full intensity");
    assert!(worst < 5e-4);
}

// ---- tables through the kernel

/// Families whose edges span a few pixels of 15 µm.
fn families() -> Vec<(&'static str, Esf)> {
    let laser = LaserShadow { distance_mm: 40.0, bandwidth_nm: 2.0, ..Default::default() };
    let distances = || (-40..=40).map(|i| f64::from(i) * 2.0);
    let measured = MeasuredEsf {
        d_um: distances().collect(),
        intensity: distances().map(|d| 0.5 * libm::erfc(-d / 22.0)).collect(),
        ..Default::default()
    };
    vec![
        ("partially coherent", Esf::PartiallyCoherent(PartiallyCoherentEdge::default())),
        (
            "coherent, defocused",
            Esf::PartiallyCoherent(PartiallyCoherentEdge {
                coherence_ratio: 0.0,
                defocus_mm: 1.5,
                ..Default::default()
            }),
        ),
        (
            "incoherent",
            Esf::PartiallyCoherent(PartiallyCoherentEdge { coherence_ratio: 1e4, ..Default::default() }),
        ),
        ("laser", Esf::Fresnel(laser)),
        ("measured", Esf::Measured(measured)),
    ]
}

fn family_bench(rows: u32, esf: &Esf) -> OpticalSetup {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    (settings.camera.rows, settings.camera.columns) = (rows, 9);
    (settings.camera.pixel_um, settings.optics.magnification) = (3.0, 0.2);
    settings.optics.esf = esf.clone();
    // Rings reach 1.37 times the field's light: the full well must not clip them.
    settings.light.bright_counts = 2000.0;
    OpticalSetup::resolve(&settings, 0).unwrap()
}

/// Worst signed shift, px, of noise-free frames of straight edges against the closed form over the
/// pixel.
fn worst_of_family(renderer: &Renderer, setup: &OpticalSetup, row: f64) -> f64 {
    let rows = setup.rows() as u32;
    let mut all: f64 = 0.0;
    for degrees in [0.0, 0.3, 12.0, 45.0, 60.0] {
        let slope = f64::to_radians(degrees).tan();
        let scene = Scene::new(setup, cone(setup, row, slope)).unwrap();
        let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
        let frame = counts(&renderer.render(&scene, &request, None).unwrap());
        let edges = geometric_edges(&scene, &request).unwrap();
        let levels = scene.setup().levels(PixelFormat::F32);
        let table = scene.edge_spreads()[0].clone();
        let reference = StraightReference { esf: &table, pixel_um: setup.pixel_mm * 1e3 };
        let truth: Vec<f64> = (0..rows)
            .flat_map(|r| edges.iter().map(move |e| (f64::from(r), e)))
            .map(|(r, e)| reference.light(e.top_px - r, slope) + reference.light(r - e.bottom_px, slope))
            .map(|light| levels.shadow + (levels.bright - levels.shadow) * light)
            .collect();
        let shift = worst(&shifts(&frame, &truth, 9, levels.bright - levels.shadow));
        println!("  {rows} rows, {degrees} deg: {shift:.2e} px");
        all = all.max(shift);
    }
    all
}

#[test]
fn twin_and_device_meet_every_family_to_row_4096_and_60_degrees() {
    let renderers = [Some(Renderer::new(BackendChoice::Cpu).unwrap()), device()];
    for (name, esf) in families() {
        let setup = family_bench(4200, &esf);
        for renderer in renderers.iter().flatten() {
            let worst = worst_of_family(renderer, &setup, 180.37);
            println!("{name} by {}: {worst:.2e} px against the f64 reference", renderer.adapter_name());
            assert!(worst < 1e-4, "{name}: {worst} px");
        }
    }
}

#[test]
fn measured_edges_that_cannot_be_are_refused() {
    let good = MeasuredEsf {
        d_um: (-4..=4).map(f64::from).collect(),
        intensity: vec![0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0],
        ..Default::default()
    };
    assert!(Esf::Measured(good.clone()).check().is_ok());
    let spoiled: [fn(&mut MeasuredEsf); 6] = [
        |t| t.intensity[2] = 0.95,
        |t| t.intensity[8] = 0.9,
        |t| t.d_um[1] = -9.0,
        |t| t.intensity.truncate(3),
        |t| t.intensity[3] = f64::NAN,
        |t| t.file = Some("edge.csv".into()),
    ];
    for spoil in spoiled {
        let mut t = good.clone();
        spoil(&mut t);
        let error = Esf::Measured(t).check().unwrap_err();
        assert!(matches!(error, RenderError::Setting(_)), "{error}");
    }
}

/// Largest difference of a frame's top edge from the light of `table` along a level edge.
fn against_table(scene: &Scene, table: &EdgeSpread) -> f64 {
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let frame = counts(&Renderer::new(BackendChoice::Cpu).unwrap().render(scene, &request, None).unwrap());
    let edge = geometric_edges(scene, &request).unwrap()[4].top_px;
    let levels = scene.setup().levels(PixelFormat::F32);
    let reference = StraightReference { esf: table, pixel_um: scene.setup().pixel_mm * 1e3 };
    (0..scene.setup().rows() / 2)
        .map(|r| {
            let light = (frame[r * 9 + 4] - levels.shadow) / (levels.bright - levels.shadow);
            (light - reference.light(edge - r as f64, 0.0)).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn every_family_follows_the_axis_out_of_focus() {
    let y_mm = 0.83;
    for (name, esf) in families() {
        let setup = family_bench(600, &esf);
        let mut shaft = Shaft::cylinder(300.3 * setup.pixel_mm);
        shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm }];
        let table = match &esf {
            Esf::PartiallyCoherent(p) => {
                PartiallyCoherentEdge { defocus_mm: p.defocus_mm + y_mm, ..p.clone() }.edge_spread()
            }
            // The shape is constant, its scale depends on the distance to the sensor.
            Esf::Fresnel(f) => LaserShadow {
                distance_mm: f.distance_mm - y_mm,
                source_half_angle_mrad: f.source_half_angle_mrad
                    * (1.0 - y_mm / f.distance_mm).sqrt().recip(),
                ..f.clone()
            }
            .edge_spread(),
            Esf::Measured(m) => {
                m.edge().unwrap().edge_spread().unwrap().spread(&Shifts::disc(y_mm * 0.02 * 1e3, 64), 1e-7)
            }
            _ => unreachable!(),
        };
        let worst = against_table(&Scene::new(&setup, shaft).unwrap(), &table.unwrap());
        println!("{name}, {y_mm} mm out of focus: {worst:.1e} of full intensity");
        assert!(worst < 3e-4, "{name}: {worst}");
    }
}

#[test]
fn a_polished_shaft_reflects_by_its_own_radius() {
    let reflection =
        GrazingReflection { source_half_angle_deg: 4.0, polished_share: 1.0, ..Default::default() };
    for esf in [Esf::default(), Esf::PartiallyCoherent(PartiallyCoherentEdge::default())] {
        let mut setup = family_bench(1000, &esf);
        setup.nominal.optics.reflection = Some(reflection.clone());
        let dull = family_bench(1000, &esf);
        for radius_px in [100.15, 450.15] {
            let mut shaft = Shaft::cylinder(2.0 * radius_px * setup.pixel_mm);
            // A thicker and a thinner piece at other places.
            let radius_mm = shaft.profile[0].radius_mm;
            let far = |z_mm, radius_mm| ProfileKnot { z_mm, radius_mm };
            shaft.profile = vec![
                far(-50.0, 100.15 * setup.pixel_mm),
                far(-40.0, radius_mm),
                far(40.0, radius_mm),
                far(50.0, 450.15 * setup.pixel_mm),
            ];
            let knife = Scene::new(&dull, shaft.clone()).unwrap();
            let edge = match knife.edge_spreads().first() {
                Some(edge) => edge.clone(),
                None => GaussianBlur { lens_sigma_um: 1.2 * 15.0, effective_na: 0.0, ..Default::default() }
                    .edge_spread()
                    .unwrap(),
            };
            let table = reflection.edge_spread(&edge, radius_mm).unwrap();
            let worst = against_table(&Scene::new(&setup, shaft).unwrap(), &table);
            println!("R {radius_mm} mm: {worst:.1e}");
            // Radii share a table within 1 %.
            assert!(worst < 2e-3, "R {radius_mm}: {worst}");
        }
    }
}

// ---- defocus

#[test]
fn an_edge_out_of_focus_is_blurred_by_half_the_aperture() {
    let setup = setup(200, 9, 1.0);
    let mut shaft = Shaft::cylinder(100.4 * setup.pixel_mm);
    shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: 3.0 }];
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let scene = Scene::new(&setup, shaft).unwrap();
    let frame = counts(&twin.render(&scene, &request, None).unwrap());
    let levels = scene.setup().levels(PixelFormat::F32);
    // Variance of the line spread along a column less the pixel's 1/12: σ² + (y·NA)²/4.
    let light: Vec<f64> =
        (0..100).map(|r| (frame[r * 9 + 4] - levels.shadow) / (levels.bright - levels.shadow)).collect();
    let spread: Vec<(f64, f64)> =
        light.windows(2).enumerate().map(|(r, w)| (r as f64 + 0.5, w[0] - w[1])).collect();
    let mean: f64 = spread.iter().map(|(x, w)| x * w).sum();
    let variance: f64 =
        spread.iter().map(|(x, w)| (x - mean).powi(2) * w).sum::<f64>() - 1.0 / 12.0 - 1.0 / 12.0;
    let expected = 1.0 + (3.0 * 0.02 / 2.0 / setup.pixel_mm).powi(2);
    // Differences of pixels convolve the spread with a second box of one pixel.
    assert!((variance / expected - 1.0).abs() < 2e-3, "{variance} {expected}");
    let edges = geometric_edges(&scene, &request).unwrap()[4];
    assert!((light.iter().sum::<f64>() - 0.5 - edges.top_px).abs() < 1e-4, "defocus must not move the edge");
}

// ---- sensor: photon transfer after EMVA 1288

struct Flat {
    mean: f64,
    temporal: f64,
    spatial: f64,
}

/// Mean, temporal and spatial variance of a flat field of `bright` counts from `frames` frames.
fn flat_field(renderer: &Renderer, settings: &SetupSettings, bright: f64, frames: u64) -> Flat {
    let mut settings = settings.clone();
    settings.light.bright_counts = bright;
    let setup = OpticalSetup::resolve(&settings, 5).unwrap();
    let scene = Scene::new(&setup, Shaft::cylinder(0.2)).unwrap();
    let (mut sum, mut squares) = (Vec::new(), Vec::new());
    for frame_id in 0..frames {
        let request = FrameRequest { frame_id, noise: true, seed: 3, ..Default::default() };
        let frame = counts(&renderer.render(&scene, &request, None).unwrap());
        let field = &frame[..setup.columns() * setup.rows() / 3];
        sum.resize(field.len(), 0.0);
        squares.resize(field.len(), 0.0);
        for ((s, q), v) in sum.iter_mut().zip(&mut squares).zip(field) {
            *s += v;
            *q += v * v;
        }
    }
    let (n, l) = (sum.len() as f64, frames as f64);
    let mean = sum.iter().sum::<f64>() / n / l;
    let temporal = sum.iter().zip(&squares).map(|(s, q)| (q - s * s / l) / (l - 1.0)).sum::<f64>() / n;
    let spatial = sum.iter().map(|s| (s / l - mean).powi(2)).sum::<f64>() / n - temporal / l;
    Flat { mean, temporal, spatial }
}

fn emva_bench() -> SetupSettings {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    settings.camera.rows = 900;
    settings.camera.columns = 1200;
    settings.light.shadow_counts = 64.0;
    settings.sensor.prnu_rel = 0.012;
    settings.sensor.dsnu_e = 6.0;
    settings
}

/// Gain, read noise, PRNU, DSNU and linearity by photon transfer, each within 1 % of what was set.
fn photon_transfer(renderer: &Renderer) {
    let settings = emva_bench();
    let sensor = &settings.sensor;
    let dark = flat_field(renderer, &settings, sensor.black_level_counts, 24);
    let levels = [500.0, 1000.0, 1800.0, 2600.0];
    let flats: Vec<Flat> = levels.iter().map(|&b| flat_field(renderer, &settings, b, 12)).collect();
    // K: slope of the temporal variance over the mean, through the dark point, by least squares.
    let (xy, xx) = flats.iter().fold((0.0, 0.0), |(xy, xx), f| {
        let (x, y) = (f.mean - dark.mean, f.temporal - dark.temporal);
        (xy + x * y, xx + x * x)
    });
    let k = xy / xx;
    let read = (dark.temporal - 1.0 / 12.0).sqrt() / k;
    let brightest = &flats[3];
    let prnu = (brightest.spatial - dark.spatial).sqrt() / (brightest.mean - dark.mean);
    let dsnu = dark.spatial.sqrt() / k;
    for (name, found, set) in [
        ("electrons per count", 1.0 / k, sensor.electrons_per_count),
        ("read noise", read, sensor.read_noise_e),
        ("PRNU", prnu, sensor.prnu_rel),
        ("DSNU", dsnu, sensor.dsnu_e),
    ] {
        println!("{name}: {found:.4} for {set}");
        assert!((found / set - 1.0).abs() < 0.01, "{name}: {found} for {set}");
    }
    for (flat, level) in flats.iter().zip(levels) {
        assert!((flat.mean / level - 1.0).abs() < 1e-3, "linearity: {} for {level}", flat.mean);
    }
}

#[test]
fn photon_transfer_of_the_twin_gives_back_the_sensor() {
    photon_transfer(&Renderer::new(BackendChoice::Cpu).unwrap());
}

#[test]
fn photon_transfer_of_the_device_gives_back_the_sensor() {
    let Some(device) = device() else { return };
    photon_transfer(&device);
}

#[test]
fn full_well_clips_and_hot_pixels_stay() {
    let mut settings = emva_bench();
    settings.sensor.full_well_e = 5000.0;
    settings.sensor.hot_pixels_ppm = 500.0;
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let clipped = flat_field(&twin, &settings, 3500.0, 2);
    let ceiling = 64.0 + 5000.0 / 2.6;
    assert!((clipped.mean - ceiling).abs() < 1.0 && clipped.temporal < 1e-6, "{}", clipped.mean);
    settings.light.bright_counts = 64.0;
    let dark = OpticalSetup::resolve(&settings, 5).unwrap();
    let scene = Scene::new(&dark, Shaft::cylinder(0.2)).unwrap();
    let hot = |frame_id| -> Vec<usize> {
        let request = FrameRequest { frame_id, noise: true, ..Default::default() };
        let frame = counts(&twin.render(&scene, &request, None).unwrap());
        frame.iter().enumerate().filter(|(_, v)| **v > 400.0).map(|(i, _)| i).collect()
    };
    let (first, second) = (hot(0), hot(1));
    assert_eq!(first, second, "hot pixels move");
    let expected = 900.0 * 1200.0 * 500e-6;
    assert!((first.len() as f64 - expected).abs() < 4.0 * f64::sqrt(expected), "{}", first.len());
}

// ---- field curvature: edges away from the middle are as far out of focus as the lens states

#[test]
fn an_edge_on_the_curved_surface_of_focus_is_sharp_and_one_in_the_plane_is_not() {
    let settings = |sag_mm: f64| {
        let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
        (settings.camera.rows, settings.camera.columns) = (600, 64);
        settings.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px: 1.0 });
        settings.optics.defocus_na = 0.02;
        settings.optics.field_curvature = Some(FieldCurvature { sag_mm, ..Default::default() });
        settings
    };
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    // Variance of the upper edge's light, px², in the middle column.
    let variance = |settings: &SetupSettings, y_mm: f64| {
        let setup = OpticalSetup::resolve(settings, 0).unwrap();
        let mut shaft = Shaft::cylinder(0.8 * 600.0 * setup.pixel_mm);
        shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm }];
        let scene = Scene::new(&setup, shaft).unwrap();
        let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
        let frame = counts(&twin.render(&scene, &request, None).unwrap());
        let falls: Vec<(f64, f64)> = (0..299)
            .map(|r| (f64::from(r), frame[r as usize * 64 + 31] - frame[(r as usize + 1) * 64 + 31]))
            .collect();
        let total: f64 = falls.iter().map(|f| f.1).sum();
        let mean = falls.iter().map(|(r, f)| r * f).sum::<f64>() / total;
        falls.iter().map(|(r, f)| (r - mean).powi(2) * f).sum::<f64>() / total
    };
    let sharp = variance(&settings(0.0), 0.0);
    // 240 rows from the middle of 301.7 px of half a diagonal: 0.633 of the sag.
    let (sag_mm, share) = (3.0, (240.0f64 / 301.7).powi(2));
    let blurred = variance(&settings(sag_mm), 0.0);
    let pixel_mm = settings(0.0).nominal_pixel_mm();
    let wanted = (0.5 * sag_mm * share * 0.02 / pixel_mm).powi(2);
    assert!((blurred - sharp - wanted).abs() < 0.02 * wanted, "{blurred} {sharp} {wanted}");
    // An axis that stands on the surface of focus there is sharp again.
    assert!((variance(&settings(sag_mm), sag_mm * share) - sharp).abs() < 0.01 * wanted);
}
