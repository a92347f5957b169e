//! The head of a job: its process and its renderer behind a camera.

use std::net::Ipv4Addr;

use super::genicam::{DataSheet, MOST_STATIONS};
use super::gvsp::StreamFormat;
use super::head::{FrameMaker, FrameOrder, Object, PassOrder, SceneOrder};
use crate::cell::{SimulatedCell, TurningCell as _};
use crate::frame::Frame;
use crate::job::{Job, LoopJob};
use crate::plan::DiameterOffset;
use crate::render::contamination::{AirDroplets, Chips, Contamination, Mist, WindowDroplets};
use crate::render::form::form_shaft;
use crate::render::settings::SetupSettings;
use crate::render::{FrameRequest, OpticalSetup, Renderer, Scene};
use crate::shaft::ProfileKnot;
use crate::studies::calibration::SimulatedSetup;

/// Sets the head of a job up: draws, cuts and clamps what is ordered.
pub(crate) struct SimulatedHead<'a> {
    job: &'a Job,
    loop_job: LoopJob,
    renderer: &'a Renderer,
    /// Process and masters, from the first order that needs them.
    cell: Option<SimulatedCell<'a>>,
    /// The last scene, and the pin's number of frames that it was drawn for.
    scene: Option<(SceneOrder, usize, Scene)>,
    /// The clamping of the pin, and the frames taken of it.
    look: (u64, usize),
}

impl<'a> SimulatedHead<'a> {
    /// The head of a job whose scene was checked.
    pub(crate) fn new(job: &'a Job, renderer: &'a Renderer) -> Self {
        let loop_job = job.loop_job();
        Self { job, loop_job, renderer, cell: None, scene: None, look: (0, 0) }
    }

    /// The data sheet of the head at an address.
    ///
    /// # Errors
    /// Where the camera of the job is none that GigE Vision describes: a line camera, one with two
    /// windows; or where it has more stations than registers.
    pub(crate) fn data_sheet(&self, address: Ipv4Addr, prefix: u8, mtu: u32) -> Result<DataSheet, String> {
        let (job, loop_job) = (self.job, &self.loop_job);
        if job.camera.line.is_some() {
            return Err(
                "[camera.line]: an area camera can be published, not a line camera; leave it out".into()
            );
        }
        if job.camera.windows.is_some() {
            let right = "the head reads one window, which the client sets; leave camera.windows out";
            return Err(format!("[camera.windows]: {right}"));
        }
        let station_z_mm = loop_job.station_z_mm();
        if station_z_mm.len() > MOST_STATIONS {
            return Err(format!(
                "part.station_mm: {} stations are more than the {MOST_STATIONS} of a pass plan; take longer ones",
                station_z_mm.len()
            ));
        }
        let passes = 1..=loop_job.passes() as u32;
        Ok(DataSheet {
            columns: job.camera.columns,
            rows: job.camera.rows,
            format: StreamFormat::of_sensor(job.sensor.format),
            model: "simulated head".into(),
            serial: format!("SG-{}", job.seed),
            exposure_us: job.camera.exposure_us,
            longest_exposure_us: 1e6_f64.max(job.camera.exposure_us),
            frame_rate_hz: 1e3 / job.camera.frame_period_ms,
            black_level_counts: job.sensor.black_level_counts,
            diameter_mm: job.part.drawn_diameter_mm(),
            diameter_is_drawn: !job.shaft.contour.is_empty(),
            contamination: if job.contamination.is_clean() { 0.0 } else { 1.0 },
            field_mm: f64::from(job.camera.rows) * job.setup_settings().nominal_pixel_mm(),
            length_mm: job.part.length_mm,
            spindle_rpm: job.motion.spindle_rpm,
            masters: job.masters.pins.len() as u32,
            pass_nominal_mm: passes.map(|pass| job.part.target_mm(pass)).collect(),
            station_z_mm,
            address,
            prefix,
            mtu,
        })
    }

    /// Process and masters, which need more of the config than a drawn shaft.
    fn cell(&mut self) -> Result<&mut SimulatedCell<'a>, String> {
        if self.cell.is_none() {
            self.job.check().map_err(|e| format!("the config cuts no part: {e}"))?;
            if self.job.machine.is_some() {
                let why =
                    "a published head does not draw the lathe's own pose of the head: leave [machine] out";
                return Err(why.to_owned());
            }
            self.cell = Some(SimulatedCell::new(self.job, self.renderer).map_err(|e| e.to_string())?);
        }
        self.cell.as_mut().ok_or_else(|| "the head has no part".to_owned())
    }

    /// The optical setup with what the client sets.
    fn setup(&self, order: &SceneOrder) -> Result<OpticalSetup, String> {
        let settings = ordered_settings(&self.job.setup_settings(), order);
        OpticalSetup::resolve(&settings, self.job.seed).map_err(|e| e.to_string())
    }

    fn draw_scene(&mut self, order: &SceneOrder, frame: usize) -> Result<Scene, String> {
        let setup = self.setup(order)?;
        match order.object {
            Object::Drawn => {
                let radius_mm = order.diameter_mm / 2.0;
                let profile = vec![ProfileKnot { z_mm: 0.0, radius_mm }];
                let job = self.job;
                let shaft = form_shaft(profile, &job.shaft, job.part.length_mm, job.seed);
                shaft.and_then(|shaft| Scene::new(&setup, shaft)).map_err(|e| e.to_string())
            }
            Object::Part => self.cell()?.part_scene(&setup).map_err(|e| e.to_string()),
            Object::Master { index, .. } => {
                let scene = self.cell()?.master_scene(&setup, index as usize, frame);
                scene
                    .map_err(|e| e.to_string())?
                    .ok_or_else(|| format!("[[masters.pins]] has no pin {index} (counted from 0)"))
            }
            Object::Flat | Object::Dark => Err("a field without a part is no scene".to_owned()),
        }
    }

    /// A frame of the light alone, or without it: as `calibrate` renders a config's fields, to the
    /// bit where the exposure times have the ratio of its exposures. Frames are numbered on through
    /// both fields.
    fn field(&self, order: &FrameOrder) -> Result<Frame, String> {
        let nominal_us = self.job.camera.exposure_us;
        let setup = self.setup(&SceneOrder { exposure_us: nominal_us, ..order.scene })?;
        let share = match order.scene.object {
            Object::Dark => 0.0,
            _ => order.scene.exposure_us / nominal_us,
        };
        let number = order.of_object.unwrap_or(order.number);
        let setup = SimulatedSetup::new(self.renderer, setup, 0.0, self.job.seed);
        let frame = setup.flat_window(share, number, order.window, Some(order.format));
        frame.map_err(|e| e.to_string())
    }

    fn part_number(&mut self, ordered: Option<u64>) -> Result<u64, String> {
        let cell = self.cell()?;
        Ok(match ordered {
            Some(number) => cell.part_frame(number),
            None => cell.next_part_frame(),
        })
    }

    /// Number of the frame, by which its noise is drawn, and of frames before it of the same pin.
    fn number(&mut self, order: &FrameOrder) -> Result<(u64, usize), String> {
        Ok(match order.scene.object {
            Object::Drawn | Object::Flat | Object::Dark => (order.number, 0),
            Object::Part => (self.part_number(order.of_object)?, 0),
            Object::Master { index, clamped } => {
                let counted = if self.look.0 == clamped { self.look.1 } else { 0 };
                let before = order.of_object.map_or(counted, |number| number as usize);
                self.look = (clamped, before + 1);
                (self.cell()?.master_frame(index as usize, before), before)
            }
        })
    }
}

impl FrameMaker for SimulatedHead<'_> {
    fn frame(&mut self, order: &FrameOrder, reuse: Option<Frame>) -> Result<Frame, String> {
        if matches!(order.scene.object, Object::Flat | Object::Dark) {
            return self.field(order);
        }
        let (frame_id, before) = self.number(order)?;
        let is_drawn = self.scene.as_ref().is_some_and(|(scene, k, _)| *scene == order.scene && *k == before);
        if !is_drawn {
            self.scene = None;
            self.scene = Some((order.scene, before, self.draw_scene(&order.scene, before)?));
        }
        let Some((_, _, scene)) = &self.scene else { return Err("no scene".into()) };
        let seed = self.cell.as_ref().map_or(self.job.seed, SimulatedCell::seed);
        let request = FrameRequest {
            frame_id,
            t_ns: order.t_ns,
            z_mm: order.z_mm,
            angle_deg: order.angle_deg,
            noise: true,
            roi: Some(order.window),
            second_roi: None,
            seed,
            format: Some(order.format),
        };
        self.renderer.render(scene, &request, reuse).map_err(|e| e.to_string())
    }

    fn cut(&mut self, order: &PassOrder) -> Result<(), String> {
        self.scene = None;
        if order.pass == 0 {
            self.cell = None;
            return self.cell().map(drop);
        }
        let offset = DiameterOffset { o_mm: order.offset_mm.clone() };
        let plan = self.loop_job.pass_plan(order.pass, offset);
        self.cell()?.cut(&plan).map_err(|e| e.to_string())
    }
}

/// The settings with speed, exposure, gain and contamination as ordered. Grey values above the
/// black level grow with exposure and gain, electrons a count fall with the gain (EMVA 1288 4.0:
/// the gain multiplies the system gain K).
fn ordered_settings(nominal: &SetupSettings, order: &SceneOrder) -> SetupSettings {
    let mut settings = nominal.clone();
    settings.motion.spindle_rpm = order.spindle_rpm;
    let light = order.exposure_us / nominal.camera.exposure_us;
    let gain = 10_f64.powf(order.gain_db / 20.0);
    // not recomputed where nothing changes: frames are then those of the config to the bit
    if light != 1.0 || gain != 1.0 {
        let black = nominal.sensor.black_level_counts;
        let scaled = |counts: f64| black + (counts - black) * light * gain;
        settings.camera.exposure_us = order.exposure_us;
        settings.light.bright_counts = scaled(nominal.light.bright_counts);
        settings.light.shadow_counts = scaled(nominal.light.shadow_counts);
        settings.light.bright_photons = nominal.light.bright_photons.map(|photons| photons * light);
        settings.sensor.electrons_per_count = nominal.sensor.electrons_per_count / gain;
    }
    settings.contamination = ordered_contamination(&nominal.contamination, order.contamination);
    settings
}

/// Contamination of which a client orders a multiple where the config is clean: the mix of all
/// kinds of `study contamination`, a fifth of it.
fn usual_contamination() -> Contamination {
    Contamination {
        mist: Mist { clouds_per_cm2: 0.4, ..Mist::default() },
        window_droplets: WindowDroplets { per_cm2: 1.0, ..WindowDroplets::default() },
        air_droplets: AirDroplets { per_cm2: 3.0, ..AirDroplets::default() },
        chips: Chips { per_cm2: 0.2, ..Chips::default() },
        ..Contamination::default()
    }
}

fn ordered_contamination(nominal: &Contamination, factor: f64) -> Contamination {
    let mut all = match (nominal.is_clean(), factor) {
        (true, 0.0) | (false, 1.0) => return nominal.clone(),
        (true, _) => usual_contamination(),
        (false, _) => nominal.clone(),
    };
    for density in [
        &mut all.mist.clouds_per_cm2,
        &mut all.mist.haze_depth,
        &mut all.window_droplets.per_cm2,
        &mut all.air_droplets.per_cm2,
        &mut all.chips.per_cm2,
        &mut all.films.per_cm2,
        &mut all.dirt.per_cm2,
        &mut all.scratches.per_cm2,
    ] {
        *density *= factor;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(exposure_us: f64, gain_db: f64, contamination: f64) -> SceneOrder {
        let (diameter_mm, spindle_rpm) = (10.0, 0.0);
        SceneOrder { object: Object::Drawn, diameter_mm, spindle_rpm, exposure_us, gain_db, contamination }
    }

    #[test]
    fn exposure_and_gain_move_grey_values_and_electrons_as_in_a_camera() {
        let nominal = SetupSettings::default();
        let exposure_us = nominal.camera.exposure_us;
        assert_eq!(ordered_settings(&nominal, &order(exposure_us, 0.0, 0.0)), nominal);
        let black = nominal.sensor.black_level_counts;
        let electrons = |s: &SetupSettings| (s.light.bright_counts - black) * s.sensor.electrons_per_count;
        let half = ordered_settings(&nominal, &order(exposure_us / 2.0, 0.0, 0.0));
        assert!((electrons(&half) / electrons(&nominal) - 0.5).abs() < 1e-12, "half the light");
        let amplified = ordered_settings(&nominal, &order(exposure_us, 20.0, 0.0));
        assert!(
            (amplified.light.bright_counts - black - 10.0 * (nominal.light.bright_counts - black)).abs()
                < 1e-9
        );
        assert!((electrons(&amplified) / electrons(&nominal) - 1.0).abs() < 1e-12, "the same light");
    }

    #[test]
    fn contamination_is_a_multiple_of_the_configs_or_of_a_usual_mix() {
        let clean = Contamination::default();
        assert_eq!(ordered_contamination(&clean, 0.0), clean);
        let some = Contamination { chips: Chips { per_cm2: 0.5, ..Chips::default() }, ..clean.clone() };
        assert_eq!(ordered_contamination(&some, 1.0), some);
        assert_eq!(ordered_contamination(&some, 3.0).chips.per_cm2, 1.5);
        assert_eq!(
            ordered_contamination(&some, 0.0),
            Contamination { chips: Chips { per_cm2: 0.0, ..Chips::default() }, ..clean.clone() }
        );
        let usual = ordered_contamination(&clean, 2.0);
        assert_eq!(usual.window_droplets.per_cm2, 2.0 * usual_contamination().window_droplets.per_cm2);
        assert!(usual.check().is_ok() && !usual.is_clean());
    }
}
