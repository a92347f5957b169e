//! The midline of a part through rendered and measured frames, over φ and φ + 180°, against the
//! head's true pose: what `measure --midline` hands to `calibrate machine`.

use std::path::Path;

use crate::cell::{SimulatedCell, TurningCell as _};
use crate::config;
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, Gauge, GaugeSettings};
use crate::job::Job;
use crate::machine::Pose;
use crate::machine::response::{Part, TwoSided};
use crate::plan::{DiameterOffset, ScanPlan};
use crate::render::{BackendChoice, Renderer};

/// Height (µm) and slope (µrad) of the midline at each field, means over the angles.
fn midlines(job: &Job, fields_mm: &[f64], angles: u32) -> Vec<[f64; 2]> {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut cell = SimulatedCell::new(job, &renderer).unwrap();
    let order = job.loop_job();
    cell.cut(&order.pass_plan(1, DiameterOffset::zero(order.station_z_mm().len()))).unwrap();
    let angle_deg = (0..angles).map(|k| 360.0 * f64::from(k) / f64::from(angles)).collect();
    let plan = ScanPlan { field_z_mm: fields_mm.to_vec(), angle_deg };
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    let calibration = Calibration::from_scale(1e3 * order.field.mm_per_px);
    let mut frames = cell.scan(&plan).unwrap();
    let mut sums = vec![[0.0; 2]; fields_mm.len()];
    while let Some(frame) = frames.next_frame().unwrap() {
        let measured = gauge.measure(&frame.view(), &calibration, &Conditions::default()).unwrap();
        let midline = measured.midline.unwrap();
        let field = fields_mm.iter().position(|z| (z - frame.meta.z_mm).abs() < 1e-9).unwrap();
        sums[field][0] += 1e3 * midline.height_mm / f64::from(angles);
        sums[field][1] += 1e6 * midline.slope_rad / f64::from(angles);
    }
    sums
}

/// Rms of the deviations about their mean (where the head was set up), heights in µm and slopes in
/// µrad; and the rms of the truth about its own.
fn deviations(job: &Job, fields_mm: &[f64], angles: u32) -> [[f64; 2]; 2] {
    let rows = job.machine_rows(1).unwrap();
    let at = |z: &f64| {
        let row = rows.iter().find(|row| (row.z_mm - z).abs() < 1e-9).unwrap();
        [row.midline_um, -row.head_b_urad]
    };
    let truth: Vec<[f64; 2]> = fields_mm.iter().map(at).collect();
    let found = midlines(job, fields_mm, angles);
    let rms = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let off = |k: usize| rms(found.iter().zip(&truth).map(|(f, t)| f[k] - t[k]).collect());
    let own = |k: usize| rms(truth.iter().map(|t| t[k]).collect());
    [[off(0), off(1)], [own(0), own(1)]]
}

#[test]
fn the_midline_through_frames_is_the_heads_own_pose() {
    let job = config::load(Path::new("configs/machine_run.toml")).unwrap();
    let [[height, slope], [own_height, own_slope]] = deviations(&job, &[12.5, 22.5, 37.5, 47.5], 8);
    println!("midline off by {height:.4} µm of {own_height:.2}, slope by {slope:.3} µrad of {own_slope:.2}");
    // 512 columns of 30 µm with .02 px of noise each: .03 px/√2/√512 of a frame, 8 of them; the
    // slope by √12 over 15 mm of it
    assert!(own_height > 0.5 && height < 0.05, "{height} of {own_height}");
    assert!(own_slope > 1.0 && slope < 8.0, "{slope} of {own_slope}");
}

/// Mean width of the frames of one field, px.
fn width_px(job: &Job) -> f64 {
    let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut cell = SimulatedCell::new(job, &renderer).unwrap();
    let plan = ScanPlan { field_z_mm: vec![32.5], angle_deg: vec![0.0, 45.0, 90.0, 135.0] };
    let gauge = Gauge::new(GaugeSettings::default()).unwrap();
    // a pixel is a millimetre: widths come out in px
    let calibration = Calibration::from_scale(1e3);
    let mut frames = cell.scan(&plan).unwrap();
    let mut sum = 0.0;
    while let Some(frame) = frames.next_frame().unwrap() {
        let measured = gauge.measure(&frame.view(), &calibration, &Conditions::default()).unwrap();
        sum += measured.mean.unwrap().d_mm;
    }
    sum / plan.angle_deg.len() as f64
}

/// EYZ of 100 µm before an entocentric lens, the same noise in both scans: −D·u_y/ℓ.
#[test]
fn the_distance_of_the_head_through_frames_is_that_of_its_response() {
    let (distance_mm, u_y_mm) = (300.0, 0.1);
    let text = include_str!("../../../configs/small_shaft.toml");
    let lathe = "[machine.stated]\nchain = \"carriage\"\ntool_mm = [0.0, 0.0, 0.0]\nhead_mm = [0.0, 0.0, 0.0]\nhead_on = \"x_carrier\"\n\
                 carriage_mm = [0.0, 0.0, 0.0]\nx_travel_mm = [-1.0, 20.0]\nz_travel_mm = [-20.0, 100.0]\n";
    let job = |eyz_um: f64| {
        let errors =
            format!("[machine.stated.errors.eyz]\npolynomial = {{ coefficients_um = [{eyz_um:.1}] }}\n");
        let optics = format!("magnification = 0.115\nentocentric = {{ distance_mm = {distance_mm:.1} }}");
        let text = text.replace("magnification = 0.115", &optics);
        config::parse(&format!("{text}\n[machine]\n{lathe}{errors}"), "job.toml").unwrap()
    };
    let (still, moved) = (width_px(&job(0.0)), width_px(&job(1e3 * u_y_mm)));
    let part = Part { diameter_mm: 12.0, taper: 0.0 };
    let head = TwoSided { pupil_mm: distance_mm, keystone_per_mm: 0.0, pair_mm: [0.0, 0.0] };
    let pose = Pose { shift_mm: [0.0, u_y_mm, 0.0].into(), turn_rad: [0.0; 3].into() };
    let wanted = head.read_mm(&part, &pose) / part.diameter_mm * still;
    println!("{still} px, by {:.5} px, response {wanted:.5}", moved - still);
    assert!(wanted < -0.1, "{wanted}");
    assert!((moved - still - wanted).abs() < 1e-3, "{} px, not {wanted}", moved - still);
}

/// The preset's camera, 16 angles of a turn, texture: what section 5 of the design asks.
#[test]
#[ignore = "64 frames of five megapixels: minutes"]
fn the_presets_midline_is_good_to_a_hundredth_of_a_micrometre() {
    let shaft: Job = config::load(Path::new("configs/slender_shaft.toml")).unwrap();
    let mut job = config::load(Path::new("configs/machine_run.toml")).unwrap();
    (job.camera, job.optics, job.light, job.sensor) = (shaft.camera, shaft.optics, shaft.light, shaft.sensor);
    let [[height, slope], _] = deviations(&job, &[22.5, 27.5, 32.5, 37.5], 16);
    println!("midline off by {height:.4} µm, slope by {slope:.3} µrad");
    assert!(height < 0.01 && slope < 0.2, "{height} {slope}");
}
