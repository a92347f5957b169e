//! Uneven light: vignetting, gradient, contamination with its mask, films that turn with the shaft.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use crate::inside::support::render as support;

use shadowgauge::frame::{Frame, PixelFormat, Roi};
use shadowgauge::render::contamination::{
    AirDroplets, Chips, Contamination, ContaminationField, Dirt, FieldGeometry, Films, Mist, Scratches,
    WindowDroplets, mask,
};
use shadowgauge::render::lens::FieldLight;
use shadowgauge::render::reference::GaussianReference;
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::Shaft;
use shadowgauge::truth::true_edges;
use support::{counts, device, exact, shifts, worst};

const UNEVEN: FieldLight = FieldLight {
    vignetting_2: 0.2,
    vignetting_4: 0.05,
    gradient_along: 0.15,
    gradient_down: -0.1,
    sag: 0.08,
};

fn dirty() -> Contamination {
    Contamination {
        window_distance_mm: 2.0,
        mist: Mist { clouds_per_cm2: 2.0, ..Mist::default() },
        window_droplets: WindowDroplets { per_cm2: 20.0, ..WindowDroplets::default() },
        air_droplets: AirDroplets { per_cm2: 40.0, ..AirDroplets::default() },
        chips: Chips { per_cm2: 3.0, ..Chips::default() },
        films: Films { per_cm2: 4.0, ..Films::default() },
        dirt: Dirt { per_cm2: 30.0, ..Dirt::default() },
        scratches: Scratches { per_cm2: 2.0, ..Scratches::default() },
        ..Contamination::default()
    }
}

fn setup(light: FieldLight, contamination: Contamination) -> OpticalSetup {
    let mut settings =
        SetupSettings { departures: SetupDeviations::none(), contamination, ..Default::default() };
    settings.light.field = light;
    settings.camera.rows = 320;
    settings.camera.columns = 401;
    settings.camera.pixel_um = 3.0;
    settings.optics.magnification = 0.2;
    settings.optics.defocus_na = 0.01;
    OpticalSetup::resolve(&settings, 5).unwrap()
}

fn scene(light: FieldLight, contamination: Contamination) -> Scene {
    Scene::new(&setup(light, contamination), Shaft::cylinder(3.0)).unwrap()
}

fn request(noise: bool) -> FrameRequest {
    FrameRequest { frame_id: 3, noise, seed: 9, format: Some(PixelFormat::F32), ..Default::default() }
}

fn twin() -> Renderer {
    Renderer::new(BackendChoice::Cpu).unwrap()
}

fn reference(scene: &Scene, factor: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let levels = scene.setup().levels(PixelFormat::F32);
    let judge = GaussianReference { sigma_px: 1.2, shadow: levels.shadow, bright: levels.bright };
    judge.lit_frame(scene.setup().rows(), scene.setup().columns(), exact(scene, 0.0, 0.0), factor)
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn uneven_light_meets_the_reference() {
    let scene = scene(UNEVEN, Contamination::default());
    let wanted = reference(&scene, |r, c| UNEVEN.at_px(r as f64, c as f64, 320, 401));
    let contrast = 2990.0;
    for renderer in [Some(twin()), device()].into_iter().flatten() {
        let found = counts(&renderer.render(&scene, &request(false), None).unwrap());
        let shift = worst(&shifts(&found, &wanted, 401, contrast));
        println!("{}: {:.1e} counts, {shift:.1e} px", renderer.backend_name(), largest(&found, &wanted));
        assert!(largest(&found, &wanted) < 5e-6 * contrast && shift < 1e-4);
    }
}

#[test]
fn contamination_multiplies_the_light_above_the_shadow() {
    let contamination = Contamination { films: Films::default(), ..dirty() };
    let scene = scene(UNEVEN, contamination.clone());
    let geometry =
        FieldGeometry { rows: 320, columns: 401, pixel_um: 15.0, effective_na: 0.01, sigma_um: 1.2 * 15.0 };
    let field = ContaminationField::new(&contamination, geometry, 5 ^ 0x736f_696c).unwrap();
    let map = field.frame(3, [0, 0], [320, 401]).unwrap();
    let wanted = reference(&scene, |r, c| {
        UNEVEN.at_px(r as f64, c as f64, 320, 401) * f64::from(map.values()[r * 401 + c])
    });
    for renderer in [Some(twin()), device()].into_iter().flatten() {
        let (frame, mask) = renderer.render_masked(&scene, &request(false), None).unwrap();
        assert!(largest(&counts(&frame), &wanted) < 3e-5 * 2990.0, "{}", renderer.backend_name());
        assert_eq!(mask.unwrap(), map.mask(), "the frame's mask is not the field's");
    }
    assert!(map.mask().iter().any(|m| *m != 0), "nothing soils this frame");
}

#[test]
fn window_stays_air_moves_and_a_window_of_the_sensor_sees_the_same() {
    let scene = scene(FieldLight::default(), Contamination { films: Films::default(), ..dirty() });
    let shoot = |request: &FrameRequest| twin().render_masked(&scene, request, None).unwrap();
    let full: Vec<(Frame, Vec<u8>)> = [3, 4]
        .map(|frame_id| shoot(&FrameRequest { frame_id, ..request(true) }))
        .map(|(frame, mask)| (frame, mask.unwrap()))
        .into();
    let fixed = mask::WINDOW_DROPLET | mask::DIRT | mask::SCRATCH;
    let of = |i: usize, bits: u8| full[i].1.iter().map(|m| m & bits).collect::<Vec<_>>();
    assert_eq!(of(0, fixed), of(1, fixed), "the window's soil moved");
    assert_ne!(of(0, !fixed), of(1, !fixed), "the air stood still");
    let roi = Roi { row: 40, column: 51, rows: 100, columns: 150 };
    let (part, part_mask) = shoot(&FrameRequest { roi: Some(roi), ..request(true) });
    let (part, part_mask) = (counts(&part), part_mask.unwrap());
    let whole = counts(&full[0].0);
    for r in 0..100 {
        let at = (r + 40) * 401 + 51;
        assert_eq!(part[r * 150..(r + 1) * 150], whole[at..at + 150], "row {r}");
        assert_eq!(part_mask[r * 150..(r + 1) * 150], full[0].1[at..at + 150], "mask of row {r}");
    }
}

#[test]
fn films_raise_the_drawn_edge_not_the_truth_and_turn_with_the_shaft() {
    let films = Films { per_cm2: 30.0, ..Films::default() };
    let soiled = scene(FieldLight::default(), Contamination { films, ..Contamination::default() });
    let clean = scene(FieldLight::default(), Contamination::default());
    let at = |angle_deg: f64| FrameRequest { angle_deg, ..request(false) };
    assert_eq!(
        true_edges(&soiled, &at(20.0)).unwrap(),
        true_edges(&clean, &at(20.0)).unwrap(),
        "films are no part of the shaft"
    );
    let rise = |angle_deg: f64| {
        let (frame, mask) = twin().render_masked(&soiled, &at(angle_deg), None).unwrap();
        let bare = counts(&twin().render(&clean, &at(angle_deg), None).unwrap());
        (shifts(&counts(&frame), &bare, 401, 2990.0), mask.unwrap())
    };
    let (here, marks) = rise(20.0);
    let (turned, _) = rise(200.0);
    // After half a turn the upper edge's films are at the lower edge.
    let mut raised = 0;
    for (column, (a, b)) in here.iter().zip(&turned).enumerate() {
        assert!((a[0] - b[1]).abs() < 1e-4 && (a[1] - b[0]).abs() < 1e-4, "column {column}: {a:?} {b:?}");
        assert!(a[0] < 1e-5 && a[1] < 1e-5, "a film takes light away");
        let marked = |rows: std::ops::Range<usize>| rows.into_iter().any(|r| marks[r * 401 + column] != 0);
        if a[0] < -0.05 {
            raised += 1;
            assert!(marked(0..160), "column {column}: a rise of {} px is not marked", -a[0]);
        }
        if a[0] == 0.0 {
            assert!(!marked(0..160), "column {column}: marked, but not raised");
        }
    }
    assert!(raised > 20, "only {raised} columns carry a film");
    let wiped = twin().render(&soiled.clone().wiped(), &at(20.0), None).unwrap();
    assert_eq!(counts(&wiped), counts(&twin().render(&clean, &at(20.0), None).unwrap()));
}

#[test]
fn device_and_twin_agree_on_dirty_noisy_frames() {
    let Some(device) = device() else { return };
    let mut setup = setup(UNEVEN, dirty());
    setup.nominal.sensor.prnu_rel = 0.01;
    setup.nominal.sensor.dsnu_e = 3.0;
    let scene = Scene::new(&setup, Shaft::cylinder(3.0)).unwrap();
    for format in [PixelFormat::Mono8, PixelFormat::Mono12, PixelFormat::F32] {
        let request = FrameRequest { format: Some(format), ..request(true) };
        let [a, b] = [&device, &twin()].map(|r| counts(&r.render(&scene, &request, None).unwrap()));
        let apart = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
        let first = a.iter().zip(&b).position(|(a, b)| (a - b).abs() > 1e-3).unwrap_or(0);
        println!(
            "{format:?}: {apart} of {} pixels differ, the first at row {}, column {}",
            a.len(),
            first / 401,
            first % 401
        );
        assert!(apart <= a.len() / 1000 && largest(&a, &b) <= 1.0, "{format:?}: {apart} pixels differ");
    }
}
