//! The renderer against closed forms, brute force and the f64 reference.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::render as support;

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use shadowgauge::frame::{PixelFormat, Roi};
use shadowgauge::render::form::form_shaft;
use shadowgauge::render::reference::GaussianReference;
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::silhouette::Outline;
use shadowgauge::render::{
    BackendChoice, FrameRequest, OpticalSetup, RenderError, Renderer, Scene, geometric_edges,
};
use shadowgauge::shaft::{
    AxisKnot, Eccentricity, Lobe, Pose, ProfileKnot, Shaft, ShaftForm, SurfaceTexture, TextureForm,
};
use shadowgauge::truth::station_diameter_mm;
use support::*;

// ---- silhouette

/// Support function by brute force: a dense sweep, then a golden-section search about its best
/// sample.
fn brute_force(outline: &Outline, z_mm: f64, facing: f64) -> f64 {
    let height = |theta: f64| outline.radius_mm(z_mm, theta) * (theta + facing).cos();
    let n = 200_000;
    let step = TAU / f64::from(n);
    let best = (0..n).map(|i| f64::from(i) * step).max_by(|a, b| height(*a).total_cmp(&height(*b))).unwrap();
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..60 {
        let (a, b) = (high - (high - low) * 0.618_033_988_75, low + (high - low) * 0.618_033_988_75);
        if height(a) > height(b) { high = b } else { low = a }
    }
    height(0.5 * (low + high)).max(height(best))
}

fn rough_shaft(nodes: usize, seed: u64) -> Shaft {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 40) as f32 / (1u64 << 24) as f32 - 0.5) * 0.01
    };
    let mut shaft = Shaft::cylinder(25.0);
    shaft.texture = Some(SurfaceTexture {
        z0_mm: 0.0,
        step_mm: 0.5,
        nodes_theta: nodes,
        height_mm: (0..nodes * 3).map(|_| next()).collect(),
    });
    shaft
}

#[test]
fn support_function_is_the_maximum_with_lobes_and_texture() {
    for (nodes, orders) in [(720, vec![3, 15]), (90, vec![50]), (300, vec![]), (7, vec![2, 7])] {
        let mut shaft = rough_shaft(nodes, nodes as u64);
        shaft.lobes =
            orders.iter().map(|&order_upr| Lobe { order_upr, amplitude_mm: 0.01, phase_deg: 17.0 }).collect();
        let outline = Outline::new(shaft).unwrap();
        for (angle, z) in [(0.0, 0.0), (33.3, 0.3), (181.0, 0.77), (300.1, 5.0)] {
            let turned = outline.turned(angle);
            let phi = f64::to_radians(angle);
            let e = turned.edges(z);
            let (top, bottom) = (brute_force(&outline, z, phi), brute_force(&outline, z, phi + PI));
            // 5e-10 mm is 3e-8 px; brute force itself is accurate to 1e-10 mm at a kink.
            assert!((e.top_mm - top).abs() < 5e-10, "{nodes} {orders:?} {angle}: {} {top}", e.top_mm);
            assert!(
                (e.bottom_mm + bottom).abs() < 5e-10,
                "{nodes} {orders:?} {angle}: {} {bottom}",
                e.bottom_mm
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn support_function_never_falls_below_a_point_of_the_slice(
        order in 2u32..50, amplitude in 0.0..0.02f64, angle in 0.0..360.0f64, theta in 0.0..TAU, z in -1.0..3.0f64,
    ) {
        let mut shaft = rough_shaft(360, 5);
        shaft.lobes = vec![Lobe { order_upr: order, amplitude_mm: amplitude, phase_deg: 5.0 }];
        let outline = Outline::new(shaft).unwrap();
        let point = outline.radius_mm(z, theta) * (theta + angle.to_radians()).cos();
        prop_assert!(outline.turned(angle).edges(z).top_mm >= point - 1e-12);
    }
}

#[test]
fn first_order_edge_is_wrong_by_the_published_amounts() {
    // h = r(-φ) errs by r'²/2R with r' = k a sin: at its worst 0.5 (k a)²/R; k = 15, a = 10 µm: .9
    // µm against the plain radius, and the second-order form by 65 nm (k = 15) and 195 nm (k = 50,
    // a = 3 µm).
    for (order, amplitude, error_nm) in [(15.0, 0.010, 65.0), (50.0, 0.003, 195.0)] {
        let mut shaft = Shaft::cylinder(25.0);
        shaft.lobes = vec![Lobe { order_upr: order as u32, amplitude_mm: amplitude, phase_deg: 0.0 }];
        let outline = Outline::new(shaft).unwrap();
        let worst = (0..400)
            .map(|i| {
                let phi = TAU / order * f64::from(i) / 400.0;
                let radius = outline.radius_mm(0.0, -phi);
                let slope = order * amplitude * (order * phi).sin();
                let second_order = radius + slope * slope / (2.0 * 12.5);
                (outline.turned(phi.to_degrees()).edges(0.0).top_mm - second_order).abs() * 1e6
            })
            .fold(0.0, f64::max);
        assert!((worst - error_nm).abs() < 0.15 * error_nm, "k = {order}: {worst} nm");
    }
}

#[test]
fn eccentricity_and_bow_turn_deflection_does_not() {
    let mut shaft = Shaft::cylinder(20.0);
    shaft.eccentricity = Eccentricity { amplitude_mm: 0.03, phase_deg: 40.0 };
    shaft.bow = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: 0.02 }];
    shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: -0.05, y_mm: 0.07 }];
    let outline = Outline::new(shaft).unwrap();
    for angle in [0.0, 77.0, 200.0] {
        let turned = outline.turned(angle);
        let e = turned.edges(1.0);
        let axis = 0.03 * f64::to_radians(40.0 + angle).cos() - 0.02 * f64::to_radians(angle).sin() - 0.05;
        assert!((0.5 * (e.top_mm + e.bottom_mm) - axis).abs() < 1e-12);
        assert!((e.top_mm - e.bottom_mm - 20.0).abs() < 1e-12);
        let y = 0.03 * f64::to_radians(40.0 + angle).sin() + 0.02 * f64::to_radians(angle).cos() + 0.07;
        assert!((turned.axis_y_mm(1.0) - y).abs() < 1e-12);
    }
}

#[test]
fn tilted_taper_shows_the_closed_form_gap() {
    // Gap in a column: D·cos τ/(cos²τ - sin²τ·tan²α), D the diameter where the column crosses the
    // axis.
    let (tilt, alpha) = (0.2f64, 0.3f64);
    let mut shaft = Shaft::cylinder(20.0);
    shaft.profile = vec![
        ProfileKnot { z_mm: -50.0, radius_mm: 30.0 - 50.0 * alpha.tan() },
        ProfileKnot { z_mm: 50.0, radius_mm: 30.0 + 50.0 * alpha.tan() },
    ];
    shaft.pose = Pose { x_mm: 0.4, tilt_mrad: tilt * 1e3, ..Pose::default() };
    let e = Outline::new(shaft).unwrap().turned(0.0).edges(2.0);
    let diameter = 2.0 * (30.0 + 2.0 / tilt.cos() * alpha.tan());
    let gap = diameter * tilt.cos() / (tilt.cos().powi(2) - (tilt.sin() * alpha.tan()).powi(2));
    // The error decreases by tan τ tan α = 0.06 per step, starting from millimetres: three steps at
    // 200 mrad, thousands of times a real tilt.
    assert!((e.top_mm - e.bottom_mm - gap).abs() < 2e-3, "{} {gap}", e.top_mm - e.bottom_mm);
}

#[test]
fn mean_caliper_is_the_perimeter_over_pi() {
    // Cauchy: the mean width of a convex body is its perimeter / π. An ellipse-like two-lobe is
    // convex.
    let mut shaft = Shaft::cylinder(25.0);
    shaft.lobes = vec![Lobe { order_upr: 2, amplitude_mm: 0.5, phase_deg: 0.0 }];
    let outline = Outline::new(shaft.clone()).unwrap();
    let n = 200_000;
    let point = |i: i32| {
        let theta = TAU * f64::from(i) / f64::from(n);
        let r = outline.radius_mm(0.0, theta);
        (r * theta.cos(), r * theta.sin())
    };
    let perimeter: f64 =
        (0..n).map(|i| (point(i), point(i + 1))).map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1)).sum();
    let mean = station_diameter_mm(&shaft, 0.0, 5.0).unwrap();
    assert!((mean - perimeter / PI).abs() < 1e-8, "{mean} {}", perimeter / PI);
}

#[test]
fn drawn_texture_has_the_rms_and_correlation_asked_for() {
    let form = ShaftForm {
        texture: Some(TextureForm {
            rms_um: 0.8,
            correlation_z_mm: 1.0,
            correlation_theta_deg: 4.0,
            ..Default::default()
        }),
        ..Default::default()
    };
    let knots = vec![ProfileKnot { z_mm: 0.0, radius_mm: 12.5 }];
    let texture = form_shaft(knots, &form, 400.0, 3).unwrap().texture.unwrap();
    let n = texture.nodes_theta;
    let h: Vec<f64> = texture.height_mm.iter().map(|&v| f64::from(v) * 1e3).collect();
    let mean_of = |f: &dyn Fn(usize) -> f64, count: usize| (0..count).map(f).sum::<f64>() / count as f64;
    let variance = mean_of(&|i| h[i] * h[i], h.len());
    assert!((variance.sqrt() - 0.8).abs() < 0.02, "rms {}", variance.sqrt());
    let lag = (1.0 / texture.step_mm).round() as usize;
    let along = mean_of(&|i| h[i] * h[i + lag * n], h.len() - lag * n) / variance;
    assert!((along - (-1f64).exp()).abs() < 0.04, "correlation along z {along}");
}

// ---- reference against 2-D quadrature

/// Light on a pixel with the edge at distance `e` above its centre, by a midpoint grid of Φ(d/σ)
/// over the pixel's area.
fn by_quadrature(e: f64, slope: f64, sigma: f64) -> f64 {
    let n = 400;
    let cos = 1.0 / slope.hypot(1.0);
    let sum: f64 = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .map(|(i, j)| {
            let (x, y) =
                ((f64::from(i) + 0.5) / f64::from(n) - 0.5, (f64::from(j) + 0.5) / f64::from(n) - 0.5);
            0.5 * libm::erfc(-(e + slope * x - y) * cos / (sigma * std::f64::consts::SQRT_2))
        })
        .sum();
    sum / f64::from(n * n)
}

#[test]
fn reference_agrees_with_two_dimensional_quadrature() {
    for sigma in [0.5, 1.2, 2.0] {
        let reference = GaussianReference { sigma_px: sigma, shadow: 0.0, bright: 1.0 };
        for degrees in [0.0, 7.0, 30.0, 60.0] {
            let slope = f64::to_radians(degrees).tan();
            let rows = 61;
            let frame = reference.frame(rows, 1, |x| [30.3 + slope * x, 1e6]);
            let shift: f64 = (0..rows).map(|r| frame[r] - by_quadrature(30.3 - r as f64, slope, sigma)).sum();
            let worst = (0..rows)
                .map(|r| (frame[r] - by_quadrature(30.3 - r as f64, slope, sigma)).abs())
                .fold(0.0, f64::max);
            println!("sigma {sigma} slope {degrees}: shift {shift:.1e} px, worst {worst:.1e}");
            assert!(shift.abs() < 1e-6, "sigma {sigma}, {degrees} deg: {shift} px");
            assert!(worst < 1e-6, "sigma {sigma}, {degrees} deg: {worst}");
        }
    }
}

// ---- kernels against the reference

fn noise_free(z_mm: f64, format: PixelFormat) -> FrameRequest {
    FrameRequest { z_mm, format: Some(format), ..Default::default() }
}

/// Worst edge shift of a renderer against the reference over blurs, slopes and rows.
fn worst_against_reference(renderer: &Renderer) -> f64 {
    let mut all: f64 = 0.0;
    for (rows, row, sigma) in [(64u32, 9.37, 1.2), (4200, 37.37, 1.2), (4200, 37.21, 0.5), (4200, 60.7, 2.0)]
    {
        for degrees in [0.0, 0.3, 12.0, 45.0, 60.0] {
            if rows == 64 && degrees > 12.0 {
                continue;
            }
            let setup = setup(rows, 9, sigma);
            let scene = Scene::new(&setup, cone(&setup, row, f64::to_radians(degrees).tan())).unwrap();
            let frame = renderer.render(&scene, &noise_free(0.0, PixelFormat::F32), None).unwrap();
            let levels = scene.setup().levels(PixelFormat::F32);
            let reference =
                GaussianReference { sigma_px: sigma, shadow: levels.shadow, bright: levels.bright };
            let truth = reference.frame(rows as usize, 9, exact(&scene, 0.0, 0.0));
            let shift = worst(&shifts(&counts(&frame), &truth, 9, levels.bright - levels.shadow));
            println!("{rows} rows, sigma {sigma}, {degrees} deg: {shift:.2e} px");
            all = all.max(shift);
        }
    }
    all
}

#[test]
fn twin_meets_the_reference_to_row_4096_and_60_degrees() {
    let worst = worst_against_reference(&Renderer::new(BackendChoice::Cpu).unwrap());
    println!("twin against the f64 reference: {worst:.2e} px");
    assert!(worst < 1e-5);
}

#[test]
fn device_meets_the_reference_to_row_4096_and_60_degrees() {
    let Some(renderer) = device() else { return };
    let worst = worst_against_reference(&renderer);
    println!("{} against the f64 reference: {worst:.2e} px", renderer.adapter_name());
    assert!(worst < 1e-5);
}

#[test]
fn rough_edges_meet_the_two_dimensional_blur() {
    let form = ShaftForm {
        texture: Some(TextureForm {
            rms_um: 1.0,
            correlation_z_mm: 0.2,
            correlation_theta_deg: 2.0,
            ..Default::default()
        }),
        ..Default::default()
    };
    let setup = setup(256, 300, 1.2);
    let knots = vec![ProfileKnot { z_mm: 0.0, radius_mm: 1.4 }];
    let scene = Scene::new(&setup, form_shaft(knots, &form, 20.0, 7).unwrap()).unwrap();
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let frame = twin.render(&scene, &noise_free(10.0, PixelFormat::F32), None).unwrap();
    let levels = scene.setup().levels(PixelFormat::F32);
    let reference = GaussianReference { sigma_px: 1.2, shadow: levels.shadow, bright: levels.bright };
    let truth = reference.frame(256, 300, exact(&scene, 10.0, 0.0));
    let worst = worst(&shifts(&counts(&frame), &truth, 300, levels.bright - levels.shadow));
    println!("rough edge: {worst:.2e} px");
    // The kernel uses the edge at whole columns: the remaining error comes from a kink of the
    // texture between two of them.
    assert!(worst < 5e-4, "{worst}");
}

// ---- twin against device, windows, formats

fn ordinary_scene(rows: u32, columns: u32) -> Scene {
    let setup = setup(rows, columns, 1.2);
    let radius = 0.4 * f64::from(rows) * setup.pixel_mm;
    let mut shaft = Shaft::cylinder(2.0 * radius);
    shaft.lobes = vec![Lobe { order_upr: 3, amplitude_mm: 0.01, phase_deg: 0.0 }];
    shaft.pose.tilt_mrad = 2.0;
    Scene::new(&setup, shaft).unwrap()
}

fn noisy(frame_id: u64) -> FrameRequest {
    FrameRequest { frame_id, angle_deg: 20.0, noise: true, seed: 11, ..Default::default() }
}

#[test]
fn noisy_twin_and_device_differ_by_a_count_in_one_pixel_of_ten_thousand_at_most() {
    let Some(device) = device() else { return };
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let scene = ordinary_scene(1200, 1601);
    for format in [PixelFormat::Mono8, PixelFormat::Mono12, PixelFormat::Mono16] {
        let request = FrameRequest { format: Some(format), ..noisy(5) };
        let a = counts(&twin.render(&scene, &request, None).unwrap());
        let b = counts(&device.render(&scene, &request, None).unwrap());
        let differing = a.iter().zip(&b).filter(|(x, y)| x != y).count();
        let worst = a.iter().zip(&b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        println!("{format:?}: {differing} of {} pixels differ, by {worst} at most", a.len());
        assert!(worst <= 1.0 && differing as f64 <= 1e-4 * a.len() as f64);
    }
}

#[test]
fn window_equals_the_same_part_of_the_full_frame() {
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let scene = ordinary_scene(400, 700);
    let roi = Roi { row: 17, column: 33, rows: 55, columns: 301 };
    let renderers = [Some(twin), device()];
    for renderer in renderers.iter().flatten() {
        let full = renderer.render(&scene, &noisy(9), None).unwrap();
        let part = renderer
            .render(&scene, &FrameRequest { roi: Some(roi), ..noisy(9) }, Some(full.clone()))
            .unwrap();
        assert_eq!(part.view().rows(), 55);
        for r in 0..55 {
            for c in 0..301 {
                assert_eq!(part.view().get(r, c), full.view().get(r + 17, c + 33), "({r}, {c})");
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let scene = ordinary_scene(400, 700);
    let frames: Vec<_> = [1, 2, 5]
        .iter()
        .map(|&threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let twin = Renderer::new(BackendChoice::Cpu).unwrap();
            pool.install(|| twin.render(&scene, &noisy(2), None).unwrap())
        })
        .collect();
    assert_eq!(frames[0], frames[1]);
    assert_eq!(frames[0], frames[2]);
}

#[test]
fn other_frames_and_seeds_have_other_noise() {
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let scene = ordinary_scene(400, 300);
    let first = counts(&twin.render(&scene, &noisy(1), None).unwrap());
    for request in [noisy(2), FrameRequest { seed: 12, ..noisy(1) }] {
        let other = counts(&twin.render(&scene, &request, None).unwrap());
        let same = first.iter().zip(&other).filter(|(a, b)| a == b).count();
        assert!((same as f64) < 0.1 * first.len() as f64, "{same} pixels are the same");
    }
}

// ---- bench

#[test]
fn true_bench_departs_from_nominal_by_seed_and_not_without() {
    let settings = SetupSettings::default();
    let a = OpticalSetup::resolve(&settings, 1).unwrap();
    assert_eq!(a, OpticalSetup::resolve(&settings, 1).unwrap());
    assert_ne!(a.pixel_mm, OpticalSetup::resolve(&settings, 2).unwrap().pixel_mm);
    assert_ne!(a.pixel_mm, settings.nominal_pixel_mm());
    assert!((a.pixel_mm / settings.nominal_pixel_mm() - 1.0).abs() < 2.6e-3);
    let exact = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    assert_eq!(OpticalSetup::resolve(&exact, 1).unwrap().pixel_mm, exact.nominal_pixel_mm());
}

#[test]
fn default_camera_shows_25_mm_over_80_percent_of_its_height() {
    let setup = SetupSettings::default();
    let share = 25.0 / (setup.nominal_pixel_mm() * f64::from(setup.camera.rows));
    assert!((share - 0.8).abs() < 0.002, "{share}");
}

#[test]
fn settings_out_of_range_name_their_key() {
    type Spoil = fn(&mut SetupSettings);
    let cases: [(&str, Spoil); 6] = [
        ("optics.magnification", |s| s.optics.magnification = 0.0),
        ("camera.columns", |s| s.camera.columns = 0),
        ("camera.pixel_um", |s| s.camera.pixel_um = f64::NAN),
        ("light.bright_counts", |s| s.light.bright_counts = 3.0),
        ("sensor.electrons_per_count", |s| s.sensor.electrons_per_count = -1.0),
        ("departures.blur_rel", |s| s.departures.blur_rel = 3.0),
    ];
    for (key, spoil) in cases {
        let mut settings = SetupSettings::default();
        spoil(&mut settings);
        let error = OpticalSetup::resolve(&settings, 0).unwrap_err();
        assert!(matches!(&error, RenderError::Setting(e) if e.key == key), "{key}: {error}");
    }
}

#[test]
fn shaft_larger_than_the_field_is_refused() {
    let setup = setup(100, 100, 1.0);
    let error = Scene::new(&setup, Shaft::cylinder(2.0)).unwrap_err();
    assert!(matches!(error, RenderError::Field { .. }), "{error}");
    let mut shaft = Shaft::cylinder(1.0);
    shaft.pose.x_mm = 0.5;
    let scene = Scene::new(&setup, shaft).unwrap();
    let error = geometric_edges(&scene, &FrameRequest::default()).unwrap_err();
    assert!(matches!(error, RenderError::Field { .. }), "{error}");
}
