//! A whole job, as a config file holds it: the loop's half and the simulation's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::from_render;
use super::field_of_view::FieldOfView;
use super::loop_job::LoopJob;
use super::machine::{Lathe, MachineRow, OnMachine, ProbeRow, RunMachine, TruePlace};
use super::nc_job::NcJob;
use super::part::Part;
use super::run_tool::{self, RunTool};
use super::scan::{Masters, Scan, ScanWhen};
use super::workpiece;
use crate::control::{ControlSettings, ControllerName};
use crate::gauge::GaugeSettings;
use crate::gauge::calibration::Conditions;
use crate::plan::{Contour, CuttingData, DiameterOffset};
use crate::probe::ProbeSettings;
use crate::process::ProcessSettings;
use crate::render::contamination::Contamination;
use crate::render::motion::Motion;
use crate::render::settings::{Camera, Light, Optics, Sensor, SetupDeviations, SetupSettings};
use crate::setting::SettingError;
use crate::shaft::ShaftForm;

/// Everything one run needs. The top-level tables of a config file are its fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Job {
    /// Name for reports.
    pub name: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Where a run takes its frames from in place of the simulation: a folder with the frames of
    /// its passes, from the folder of this file (docs/control.md), or a head on the wire, `gige:IP`
    /// or `gige:NAME` (docs/cameras.md).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The part and its passes.
    pub part: Part,
    /// Passes to cut, where not all of the part's.
    pub passes: Option<usize>,
    /// Cutting data of every pass.
    pub cutting: CuttingData,
    /// Fields and angles.
    pub scan: Scan,
    /// Master pins.
    pub masters: Masters,
    /// Form errors of the shaft, as set up in the machine.
    pub shaft: ShaftForm,
    /// Camera geometry.
    pub camera: Camera,
    /// Lens.
    pub optics: Optics,
    /// Backlight.
    pub light: Light,
    /// Sensor.
    pub sensor: Sensor,
    /// What moves during an exposure.
    pub motion: Motion,
    /// What soils the view; clean by default.
    pub contamination: Contamination,
    /// How far the true optics and sensor may lie from their nominal values (drawn by seed).
    pub departures: SetupDeviations,
    /// The turning process.
    pub process: ProcessSettings,
    /// The tool by its file, and its measured nose: what a worn one leaves is what is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool: Option<RunTool>,
    /// The lathe with its geometric errors: they displace the tool and the head.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<RunMachine>,
    /// The gauge.
    pub gauge: GaugeSettings,
    /// A touch probe: where it stands, the loop takes its diameters from it in place of the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<ProbeSettings>,
    /// The controller.
    pub control: ControlSettings,
    /// The control that the offsets go to: the controller is given what its rounding leaves
    /// of them. Without one offsets are commanded as they are.
    pub nc: Option<NcJob>,
}

impl Default for Job {
    fn default() -> Self {
        Self {
            name: "slender shaft".to_owned(),
            seed: 1,
            source: None,
            part: Part::default(),
            passes: None,
            cutting: CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 },
            scan: Scan::default(),
            masters: Masters::default(),
            shaft: ShaftForm::default(),
            camera: Camera::default(),
            optics: Optics::default(),
            light: Light::default(),
            sensor: Sensor::default(),
            motion: Motion::default(),
            contamination: Contamination::default(),
            departures: SetupDeviations::default(),
            process: ProcessSettings::default(),
            tool: None,
            machine: None,
            gauge: GaugeSettings::default(),
            probe: None,
            control: ControlSettings::default(),
            nc: None,
        }
    }
}

impl Job {
    /// The optical setup of the simulator, put together.
    pub(crate) fn setup_settings(&self) -> SetupSettings {
        SetupSettings {
            camera: self.camera.clone(),
            optics: self.optics.clone(),
            light: self.light.clone(),
            sensor: self.sensor.clone(),
            motion: self.motion.clone(),
            contamination: self.contamination.clone(),
            departures: self.departures.clone(),
        }
    }

    /// The loop's half as the config gives it: the camera by its data sheet, and of the process
    /// only what drawing and handbooks give.
    pub fn loop_job(&self) -> LoopJob {
        let material = self.process.material.resolve();
        let steel = Conditions::default().expansion_um_per_m_k;
        LoopJob {
            name: self.name.clone(),
            part: self.part.clone(),
            contour: self.shaft.contour.clone(),
            passes: self.passes,
            cutting: self.cutting,
            feed_direction: self.process.pass.feed_direction,
            steady_z_mm: self.process.support.steady_rests.iter().map(|rest| rest.z_mm).collect(),
            expansion_um_per_m_k: material.map_or(steel, |m| m.expansion_um_per_m_k),
            workpiece: workpiece::workpiece(&self.part, &self.process, &self.cutting).0,
            scan: self.scan.clone(),
            masters: self.masters.clone(),
            field: self.field_of_view(),
            gauge: self.gauge.clone(),
            probe: self.probe.clone(),
            head_geometry: self.machine.as_ref().and_then(RunMachine::head_geometry),
            control: self.control.clone(),
            nc: self.nc.clone(),
        }
    }

    /// The loop's half of a job that a run accepts, its gauge with the edge of the job's own optics
    /// where `[gauge.esf.optics]` asks for it.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub fn checked_loop(&self) -> Result<LoopJob, SettingError> {
        self.check()?;
        self.check_coverage()?;
        Ok(LoopJob { gauge: self.gauge_settings()?, ..self.loop_job() })
    }

    /// The contour to be turned, and the one that the tool's worn nose leaves in its place; none
    /// of a plain shaft.
    ///
    /// # Errors
    /// A contour that cannot be turned, a nose that cannot turn it.
    pub(crate) fn contours(&self) -> Result<(Option<Contour>, Option<Contour>), SettingError> {
        let part = self.loop_job();
        let drawn = part.contour_to_turn()?;
        let path = self.tool.as_ref().map(|tool| tool.path(&part, self.nc.as_ref())).transpose()?.flatten();
        let worn = drawn.as_ref().zip(path).map(|(drawn, path)| run_tool::worn(&part, drawn, &path));
        let worn = worn.transpose()?;
        Ok((drawn, worn))
    }

    /// The lathe with its errors; none where the machine stands as commanded.
    ///
    /// # Errors
    /// A machine that is missing, cannot be right, or does not fit the job.
    pub(crate) fn lathe(&self) -> Result<Option<Lathe>, SettingError> {
        let Some(machine) = &self.machine else { return Ok(None) };
        let on = OnMachine {
            part: &self.loop_job(),
            process: &self.process,
            spindle: &self.shaft.spindle,
            is_recorded: self.source.is_some(),
        };
        machine.lathe(&on).map(Some)
    }

    /// What the machine's errors amount to at the stations of the first `passes` passes, for
    /// comparison only; empty where the machine stands as commanded.
    ///
    /// # Errors
    /// As [`Self::lathe`].
    pub(crate) fn machine_rows(&self, passes: usize) -> Result<Vec<MachineRow>, SettingError> {
        let Some(lathe) = self.lathe()? else { return Ok(Vec::new()) };
        let order = self.loop_job();
        let stations = order.station_z_mm().len();
        let plan = |pass: usize| order.pass_plan(pass as u32, DiameterOffset::zero(stations));
        Ok((1..=passes).flat_map(|pass| lathe.contributions(&plan(pass))).collect())
    }

    /// What the displacement probe of `[machine]` indicates of a pass, of its stations' true
    /// diameters, mm; empty without one.
    ///
    /// # Errors
    /// As [`Self::lathe`].
    pub(crate) fn probe_rows(&self, pass: u32, true_mm: &[f64]) -> Result<Vec<ProbeRow>, SettingError> {
        let Some(probe) = self.machine.as_ref().and_then(|machine| machine.probe) else {
            return Ok(Vec::new());
        };
        let Some(lathe) = self.lathe()? else { return Ok(Vec::new()) };
        let order = self.loop_job();
        let plan = order.pass_plan(pass, DiameterOffset::zero(order.station_z_mm().len()));
        let places = plan.station_z_mm.iter().zip(plan.station_nominal_mm()).zip(true_mm);
        let place = |((z_mm, nominal_mm), true_mm): ((&f64, f64), &f64)| TruePlace {
            z_mm: *z_mm,
            nominal_mm,
            true_mm: *true_mm,
        };
        Ok(probe.rows(&lathe, pass, &places.map(place).collect::<Vec<_>>(), self.seed))
    }

    /// The camera's data sheet.
    fn field_of_view(&self) -> FieldOfView {
        FieldOfView {
            columns: self.camera.columns,
            rows: self.camera.rows,
            mm_per_px: self.nominal_mm_per_px(),
            rows_about_axis: self.camera.rows_about_axis(),
            is_line: self.camera.line.is_some(),
            frame_period_ms: self.camera.frame_period_ms,
            telecentricity_mrad: self.optics.telecentricity_mrad,
        }
    }

    /// Size of a pixel on the object by the data sheets, mm.
    pub fn nominal_mm_per_px(&self) -> f64 {
        self.setup_settings().nominal_pixel_mm()
    }

    /// Checks that the controller can be built for the job's stations: an unstable loop is refused
    /// here, so that a study of stability can still read the config.
    ///
    /// # Errors
    /// The controller's reason.
    pub(crate) fn check_control(&self) -> Result<(), SettingError> {
        self.loop_job().check_control()
    }

    /// Warnings for a run: a force law for another material, an aim at a limit of size.
    pub(crate) fn cautions(&self) -> Vec<String> {
        let model =
            self.control.controller == ControllerName::Model && self.control.model.coefficient_n.is_none();
        let force =
            if model { workpiece::workpiece(&self.part, &self.process, &self.cutting).1 } else { None };
        let tool = self.tool.as_ref().and_then(RunTool::caution);
        let machine = self.machine.as_ref().map_or(Vec::new(), RunMachine::cautions);
        force.into_iter().chain(tool).chain(machine).chain(self.loop_job().cautions()).collect()
    }

    /// Checks every stage's settings and the conditions across stages.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(crate) fn check(&self) -> Result<(), SettingError> {
        let in_loop = self.loop_job();
        in_loop.check_passes()?;
        self.check_setup()?;
        self.process.validate()?;
        in_loop.check_stages()?;
        self.tool.as_ref().map_or(Ok(None), |tool| tool.path(&in_loop, self.nc.as_ref()))?;
        in_loop.check_instrument()?;
        self.lathe().map(drop)
    }

    /// Whether the fields cover the part, the angles determine its uncertainty, the last pass aims
    /// at the tolerance, and the shaft is one that can be turned: needed by a run, not by `render`.
    ///
    /// # Errors
    /// Names the key and what would be enough.
    pub(crate) fn check_coverage(&self) -> Result<(), SettingError> {
        if let Some(key) = self.shaft.finished_key() {
            return Err(SettingError::at(
                key,
                "describes a finished part, which `render` draws; a run turns plain and stepped shafts (shaft.contour): leave it out",
            ));
        }
        let in_loop = self.loop_job();
        in_loop.check_coverage()?;
        self.machine.as_ref().map_or(Ok(()), |machine| machine.check_fields(&in_loop))?;
        if self.scan.when != ScanWhen::DuringCut {
            return Ok(());
        }
        // The last pass turns fastest.
        let follow = in_loop.follow_plan(self.part.passes() as u32);
        let (spindle_rpm, carriage_mm_s) = (follow.spindle_rpm, follow.carriage_mm_s);
        let motion = Motion { spindle_rpm, carriage_mm_s, ..self.motion.clone() };
        motion.check(self.camera.exposure_us).map_err(from_render)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell of one's own starts from the values that a config leaves out.
    #[test]
    fn both_halves_have_the_same_defaults() {
        assert_eq!(Job::default().loop_job(), LoopJob::default());
    }
}
