//! Each kernel of the renderer by itself, on the CPU; `render --bench` times a device.
//!
//! 2048 x 2048 pixels, 12 bit; `job` is the host's preparation of a frame, `frame` the twin's
//! kernels.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use shadowgauge::frame::{Buffer, Roi};
use shadowgauge::render::contamination::{
    AirDroplets, Chips, Contamination, Dirt, Films, Mist, WindowDroplets,
};
use shadowgauge::render::lens::FieldLight;
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::{
    BackendChoice, FrameRequest, OpticalSetup, RenderError, Renderer, Scene, frame_job,
};
use shadowgauge::shaft::{ProfileKnot, Shaft};

fn scene(set: impl FnOnce(&mut SetupSettings)) -> Result<Scene, RenderError> {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..SetupSettings::default() };
    settings.camera.rows = 2048;
    settings.camera.columns = 2048;
    set(&mut settings);
    let mut shaft = Shaft::cylinder(25.0);
    shaft.pose.tilt_mrad = 2.0;
    Scene::new(&OpticalSetup::resolve(&settings, 1)?, shaft)
}

/// A change to optics that are written as in a config.
fn through(optics: &str) -> impl FnOnce(&mut SetupSettings) {
    let read = toml::from_str(optics);
    move |settings| match read {
        Ok(optics) => settings.optics = optics,
        Err(e) => eprintln!("not measured as meant: {e}"),
    }
}

/// A taper of 24 to 25.5 mm over the field.
fn taper(set: impl FnOnce(&mut SetupSettings)) -> Result<Scene, RenderError> {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..SetupSettings::default() };
    (settings.camera.rows, settings.camera.columns) = (2048, 2048);
    set(&mut settings);
    let mut shaft = Shaft::cylinder(24.75);
    shaft.profile =
        [(-20.0, 12.0), (20.0, 12.75)].map(|(z_mm, radius_mm)| ProfileKnot { z_mm, radius_mm }).to_vec();
    Scene::new(&OpticalSetup::resolve(&settings, 1)?, shaft)
}

/// A scene of a limb of another radius each: the tables of the limb and of a flat face.
fn limbs(c: &mut Criterion) -> Result<(), RenderError> {
    for ratio in [0.5, 0.85, 1.0] {
        let mut settings = SetupSettings { departures: SetupDeviations::none(), ..SetupSettings::default() };
        through(&format!("[esf.cylinder]\ncoherence_ratio = {ratio}"))(&mut settings);
        let setup = OpticalSetup::resolve(&settings, 1)?;
        let mut diameter_mm = 18.0;
        c.bench_function(&format!("scene of a limb, two tables, S {ratio}"), |b| {
            b.iter(|| {
                diameter_mm += 1e-6;
                black_box(Scene::new(&setup, Shaft::cylinder(diameter_mm)).is_ok())
            });
        });
    }
    Ok(())
}

fn dirty() -> Contamination {
    Contamination {
        mist: Mist { clouds_per_cm2: 1.0, ..Mist::default() },
        window_droplets: WindowDroplets { per_cm2: 2.0, ..WindowDroplets::default() },
        air_droplets: AirDroplets { per_cm2: 4.0, ..AirDroplets::default() },
        chips: Chips { per_cm2: 0.5, ..Chips::default() },
        films: Films { per_cm2: 1.0, ..Films::default() },
        dirt: Dirt { per_cm2: 4.0, ..Dirt::default() },
        ..Contamination::default()
    }
}

fn frames(c: &mut Criterion) -> Result<(), RenderError> {
    let twin = Renderer::new(BackendChoice::Cpu)?;
    let gradient = FieldLight { gradient_along: 0.1, vignetting_2: 0.1, ..FieldLight::default() };
    let roi = |row| Some(Roi { row, column: 0, rows: 32, columns: 2048 });
    let full = FrameRequest { noise: true, ..FrameRequest::default() };
    let windows = FrameRequest { roi: roi(190), second_roi: roi(1826), ..full.clone() };
    let level = scene(|s| s.camera.pixel_um = 3.45)?;
    let (thin, thick) = ("[esf.partially_coherent]", "[esf.cylinder]");
    let coma = "aberrations = [{ field = 1.0, coma_nm = 25.0 }]\n[esf.partially_coherent]";
    let cases = [
        ("even light", scene(|_| {})?, full.clone()),
        ("without noise", scene(|_| {})?, FrameRequest { noise: false, ..full.clone() }),
        ("uneven light", scene(|s| s.light.field = gradient)?, full.clone()),
        ("fixed pattern", scene(|s| s.sensor.prnu_rel = 0.01)?, full.clone()),
        ("contamination", scene(|s| s.contamination = dirty())?, full.clone()),
        ("partially coherent", scene(through(thin))?, full.clone()),
        ("limb", scene(through(thick))?, full.clone()),
        ("partially coherent, taper", taper(through(thin))?, full.clone()),
        ("limb, taper", taper(through(thick))?, full.clone()),
        ("partially coherent, coma", scene(through(coma))?, full.clone()),
    ];
    for (name, scene, request) in &cases {
        c.bench_function(&format!("job, {name}"), |b| {
            b.iter(|| black_box(frame_job(scene, request, true).map(|j| j.params.size.rows)));
        });
        let job = frame_job(scene, request, true)?;
        let mut spare: Option<Buffer> = None;
        c.bench_function(&format!("frame, {name}"), |b| {
            b.iter(|| spare = twin.draw(&job, spare.take()).ok());
        });
    }
    if let Ok(job) = frame_job(&level, &windows, true) {
        let mut spare: Option<Buffer> = None;
        c.bench_function("frame, 2 x 32 rows", |b| b.iter(|| spare = twin.draw(&job, spare.take()).ok()));
    }
    Ok(())
}

fn all(c: &mut Criterion) {
    if let Err(e) = frames(c).and_then(|()| limbs(c)) {
        eprintln!("not measured: {e}");
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = all
}
criterion_main!(benches);
