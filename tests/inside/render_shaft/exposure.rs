//! Motion during the exposure.

use shadowgauge::frame::PixelFormat;
use shadowgauge::render::esf_families::PartiallyCoherentEdge;
use shadowgauge::render::motion::{Motion, Strobe, Vibration};
use shadowgauge::render::settings::{Esf, SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene, geometric_edges};
use shadowgauge::shaft::{Eccentricity, Flat, Pose, Shaft};

use crate::inside::render_shaft::close;
use crate::inside::render_shaft::support::{counts, device};

const EXPOSURE_US: f64 = 400.0;

fn setup(motion: Motion, esf: Esf) -> OpticalSetup {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), motion, ..Default::default() };
    (settings.camera.rows, settings.camera.columns) = (220, 24);
    (settings.camera.pixel_um, settings.optics.magnification) = (3.0, 0.2);
    settings.camera.exposure_us = EXPOSURE_US;
    settings.optics.esf = esf;
    settings.light.bright_counts = 2000.0;
    OpticalSetup::resolve(&settings, 0).unwrap()
}

fn still(setup: &OpticalSetup) -> OpticalSetup {
    let mut still = setup.clone();
    still.nominal.motion = Motion::default();
    still
}

fn request(angle_deg: f64, z_mm: f64) -> FrameRequest {
    FrameRequest { format: Some(PixelFormat::F32), angle_deg, z_mm, ..Default::default() }
}

fn shaft() -> Shaft {
    let mut shaft = Shaft::cylinder(2.0);
    shaft.eccentricity = Eccentricity { amplitude_mm: 0.05, phase_deg: 30.0 };
    shaft.features.flats = vec![Flat { from_mm: -9.0, to_mm: 9.0, distance_mm: 0.97, angle_deg: 80.0 }];
    shaft.pose = Pose { tilt_mrad: 20.0, ..Pose::default() };
    shaft
}

/// The mean of frames at many instants, with the shaft displaced explicitly; also the mean top
/// edges.
fn averaged(
    setup: &OpticalSetup,
    shaft: &Shaft,
    pose: impl Fn(f64) -> (f64, f64, f64),
) -> (Vec<f64>, Vec<f64>) {
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let n = 800;
    let (mut sum, mut edges) = (Vec::new(), Vec::new());
    let lifted = |lift: f64| {
        let mut lifted = shaft.clone();
        lifted.pose.x_mm += lift;
        Scene::new(setup, lifted).unwrap()
    };
    let level = lifted(0.0);
    for i in 0..n {
        let (angle, z, lift) = pose(EXPOSURE_US * (f64::from(i) + 0.5) / f64::from(n));
        let high = (lift != 0.0).then(|| lifted(lift));
        let scene = high.as_ref().unwrap_or(&level);
        let frame = counts(&twin.render(scene, &request(angle, z), None).unwrap());
        let top = geometric_edges(scene, &request(angle, z)).unwrap();
        sum.resize(frame.len(), 0.0);
        edges.resize(top.len(), 0.0);
        sum.iter_mut().zip(&frame).for_each(|(s, v)| *s += v / f64::from(n));
        edges.iter_mut().zip(&top).for_each(|(s, e)| *s += e.top_px / f64::from(n));
    }
    (sum, edges)
}

#[test]
fn a_moving_edge_is_the_mean_of_its_images() {
    let rpm = 12_000.0;
    let vibration = |amplitude_um, frequency_hz| Vibration { amplitude_um, frequency_hz, phase_deg: 70.0 };
    let coherent = Esf::PartiallyCoherent(PartiallyCoherentEdge::default());
    let cases = [
        (
            "run-out and a flat turning",
            Motion { spindle_rpm: rpm, ..Default::default() },
            Esf::default(),
            2e-4,
        ),
        (
            "feed and vibration",
            Motion { carriage_mm_s: 800.0, vibration: vec![vibration(25.0, 3000.0)], ..Default::default() },
            Esf::default(),
            2e-4,
        ),
        (
            "many periods",
            Motion { vibration: vec![vibration(20.0, 1.0137e6)], ..Default::default() },
            Esf::default(),
            3e-3,
        ),
        ("coherent", Motion { spindle_rpm: rpm, ..Default::default() }, coherent, 4e-4),
    ];
    for (name, motion, esf, limit) in cases {
        let setup = setup(motion.clone(), esf);
        let scene = Scene::new(&setup, shaft()).unwrap();
        let frame =
            Renderer::new(BackendChoice::Cpu).unwrap().render(&scene, &request(60.0, 0.0), None).unwrap();
        let (mean, edges) = averaged(&still(&setup), &shaft(), |t_us| {
            let t = t_us * 1e-6;
            let wave = |v: &Vibration| {
                1e-3 * v.amplitude_um
                    * (std::f64::consts::TAU * v.frequency_hz * t + v.phase_deg.to_radians()).sin()
            };
            (
                60.0 + 6.0 * motion.spindle_rpm * t,
                motion.carriage_mm_s * t,
                motion.vibration.iter().map(wave).sum(),
            )
        });
        let worst = counts(&frame).iter().zip(&mean).map(|(a, b)| (a - b).abs() / 1890.0).fold(0.0, f64::max);
        println!("{name}: {worst:.1e} of full intensity against 800 instants");
        assert!(worst < limit, "{name}: {worst}");
        let truth = geometric_edges(&scene, &request(60.0, 0.0)).unwrap();
        let off = truth.iter().zip(&edges).map(|(e, m)| (e.top_px - m).abs()).fold(0.0, f64::max);
        assert!(off < limit, "{name}: truth is off the mean by {off} px");
        if let Some(device) = device() {
            let other = counts(&device.render(&scene, &request(60.0, 0.0), None).unwrap());
            let apart = counts(&frame).iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 0.01, "{name}: device and twin {apart} counts apart");
        }
    }
}

#[test]
fn a_strobe_freezes_what_moves() {
    let fast = Motion { spindle_rpm: 12_000.0, ..Default::default() };
    let flash = Motion { strobe: Some(Strobe { delay_us: 100.0, pulse_us: 0.05 }), ..fast };
    let setup = setup(flash, Esf::default());
    let scene = Scene::new(&setup, shaft()).unwrap();
    let frozen = Scene::new(&still(&setup), shaft()).unwrap();
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let a = counts(&twin.render(&scene, &request(60.0, 0.0), None).unwrap());
    // 100 µs at 12 000 rev/min: 7.2°.
    let b = counts(&twin.render(&frozen, &request(67.2, 0.0), None).unwrap());
    let worst = a.iter().zip(&b).map(|(x, y)| (x - y).abs() / 1890.0).fold(0.0, f64::max);
    assert!(worst < 2e-3, "{worst}");
    let e = geometric_edges(&scene, &request(60.0, 0.0)).unwrap()[3];
    close(e.top_px, geometric_edges(&frozen, &request(67.2018, 0.0)).unwrap()[3].top_px, 1e-3, "truth");
}
