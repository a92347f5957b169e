//! A job: the part, the scan, the masters and the settings of every stage, checked as a whole.
//!
//! Each stage owns its settings; the job composes them and checks conditions across stages (a shaft
//! larger than the field, masters outside it, passes that do not remove material). Errors name the
//! key and the valid range.
//!
//! `part`, `scan`, `probe` and `follow` are tables of the job itself; `stations` and `workpiece`
//! are functions of their values; `edge` and `gauge_settings` give the gauge the edge of the job's
//! own optics; `error` is what a check refuses. A new table is a field of [`Job`] with a check of
//! its own, called in [`Job::check`].

mod edge;
mod error;
mod follow;
mod gauge_settings;
mod part;
mod part_facts;
mod probe;
mod scan;
mod stations;
mod workpiece;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::conformity::Tolerance;
use crate::control::{ControlSettings, ControllerName};
use crate::gauge::GaugeSettings;
use crate::nc::{Dialect, NcSettings};
use crate::plan::{CuttingData, PassPlan, ScanPlan};
use crate::probe::ProbeSettings;
use crate::process::ProcessSettings;
use crate::render::contamination::Contamination;
use crate::render::motion::Motion;
use crate::render::settings::{Camera, Light, Optics, Sensor, SetupDeviations, SetupSettings};
use crate::setting::{SettingError, positive};
use crate::shaft::ShaftForm;
pub use edge::{NominalEdge, sampled_edge};
pub use error::from_render;
use error::{from_control, from_nc};
pub use part::Part;
pub use scan::{Masters, Scan, ScanWhen, StockScan};

/// Where offsets go: the control whose increments they are rounded to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NcJob {
    /// The control.
    pub dialect: Dialect,
    /// What its programs need to know of the machine.
    #[serde(default)]
    pub machine: NcSettings,
}

/// Everything one run needs. The top-level tables of a config file are its fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Job {
    /// Name for reports.
    pub name: String,
    /// Seed of everything random.
    pub seed: u64,
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
            gauge: GaugeSettings::default(),
            probe: None,
            control: ControlSettings::default(),
            nc: None,
        }
    }
}

impl Job {
    /// The optical setup of the simulator, put together.
    pub fn setup_settings(&self) -> SetupSettings {
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

    /// Passes to cut.
    pub fn passes(&self) -> usize {
        self.passes.unwrap_or(usize::MAX).min(self.part.passes())
    }

    /// Plan of pass `pass` (from 1) with the given offsets.
    pub fn pass_plan(&self, pass: u32, offset: crate::plan::DiameterOffset) -> PassPlan {
        PassPlan {
            pass,
            nominal_mm: self.part.target_mm(pass),
            cutting: self.cutting,
            station_z_mm: self.part.station_z_mm(),
            offset,
        }
    }

    /// Field centres spread evenly so that the outer fields end at the part's ends, and angles over
    /// half a revolution.
    pub fn scan_plan(&self) -> ScanPlan {
        let half = self.field_length_mm() / 2.0;
        let (first, last) = (
            half.min(self.part.length_mm / 2.0),
            (self.part.length_mm - half).max(self.part.length_mm / 2.0),
        );
        let steps = self.scan.fields.saturating_sub(1).max(1) as f64;
        let field_z_mm = match self.scan.fields {
            1 => vec![self.part.length_mm / 2.0],
            n => (0..n).map(|i| first + (last - first) * i as f64 / steps).collect(),
        };
        let field_z_mm =
            stations::fields_that_show(self.part.listed(), field_z_mm, half + 0.5 * self.part.station_mm);
        let angle_deg = (0..self.scan.angles).map(|i| 180.0 * i as f64 / self.scan.angles as f64).collect();
        ScanPlan { field_z_mm, angle_deg }
    }

    /// Whether the stock is scanned before the first pass.
    pub fn scans_stock(&self) -> bool {
        match self.scan.stock {
            StockScan::Auto => self.control.controller == ControllerName::Model,
            StockScan::Always => true,
            StockScan::Never => false,
        }
    }

    /// The controller's settings as a run uses them: the workpiece of the model-based controller
    /// from the job, where `[control.model]` does not give it, and the lower limit of size from the
    /// part's tolerance.
    pub fn run_control(&self) -> ControlSettings {
        let mut control = self.control.clone();
        control.model =
            control.model.for_workpiece(&workpiece::workpiece(&self.part, &self.process, &self.cutting).0);
        let lower = self.part.tolerance.map(|t| t.nominal_mm + t.lower_mm).filter(|l| *l > 0.0);
        control.guards.lower_limit_mm = control.guards.lower_limit_mm.or(lower);
        control
    }

    /// Length along z in one frame, mm, at the nominal magnification; slightly less than the whole
    /// field, so that fields overlap whatever the true magnification is. A frame of a line camera
    /// shows a single z: one reading per station.
    pub fn field_length_mm(&self) -> f64 {
        if self.camera.line.is_some() {
            return self.part.station_mm;
        }
        0.97 * f64::from(self.camera.columns) * self.nominal_mm_per_px()
    }

    /// Height of the field, mm, by the nominal magnification.
    pub fn field_height_mm(&self) -> f64 {
        f64::from(self.camera.rows) * self.nominal_mm_per_px()
    }

    /// Limit of the telecentricity error by the lens' data sheet (`optics.telecentricity_mrad`),
    /// 1/mm: masters in one plane do not show it.
    pub fn limit_telecentricity_per_mm(&self) -> f64 {
        let (rows, columns) = (f64::from(self.camera.rows), f64::from(self.camera.columns));
        let half_mm = 0.5 * rows.hypot(columns) * self.nominal_mm_per_px();
        (1e-3 * self.optics.telecentricity_mrad).tan().abs() / half_mm
    }

    fn nominal_mm_per_px(&self) -> f64 {
        self.setup_settings().nominal_pixel_mm()
    }

    fn check_stages(&self) -> Result<(), SettingError> {
        self.setup_settings().check().map_err(from_render)?;
        self.gauge.validate()?;
        self.process.validate()?;
        self.check_nc()?;
        self.control.validate()
    }

    /// Checks that a path of the first pass is possible, and that the settings are in range.
    fn check_nc(&self) -> Result<(), SettingError> {
        let Some(nc) = &self.nc else { return Ok(()) };
        let stations = self.part.station_z_mm().len();
        let plan = self.pass_plan(1, crate::plan::DiameterOffset::zero(stations));
        crate::nc::Path::new(&plan, &nc.machine, nc.dialect).map(drop).map_err(from_nc)
    }

    /// Checks that the controller can be built for the job's stations: an unstable loop is refused
    /// here, so that a study of stability can still read the config.
    ///
    /// # Errors
    /// The controller's reason.
    pub fn check_control(&self) -> Result<(), SettingError> {
        crate::control::build(&self.run_control(), &self.part.station_z_mm()).map(drop).map_err(from_control)
    }

    /// Warnings for a run: a force law for another material, an aim at a limit of size.
    pub fn cautions(&self) -> Vec<String> {
        let model =
            self.control.controller == ControllerName::Model && self.control.model.coefficient_n.is_none();
        let force =
            if model { workpiece::workpiece(&self.part, &self.process, &self.cutting).1 } else { None };
        force.into_iter().chain(self.part.aims_at_a_limit()).collect()
    }

    /// Checks every stage's settings and the conditions across stages.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub fn check(&self) -> Result<(), SettingError> {
        self.part.check()?;
        if self.passes.is_some_and(|n| n == 0 || n > self.part.passes()) {
            return Err(SettingError::at(
                "passes",
                format!("must be 1 to {}, the nominal diameters given", self.part.passes()),
            ));
        }
        positive("cutting.speed_m_per_min", self.cutting.speed_m_per_min)?;
        positive("cutting.feed_mm_per_rev", self.cutting.feed_mm_per_rev)?;
        self.check_stages()?;
        if let Some(probe) = &self.probe {
            return probe::check(probe, &self.masters);
        }
        self.check_scan()?;
        self.check_masters()
    }

    fn check_scan(&self) -> Result<(), SettingError> {
        if self.scan.fields == 0 || self.scan.fields > 100_000 {
            return Err(SettingError::at("scan.fields", "must be between 1 and 100 000"));
        }
        if self.scan.angles == 0 || self.scan.angles > 100_000 {
            return Err(SettingError::at("scan.angles", "must be between 1 and 100 000"));
        }
        let height = self.field_height_mm();
        if self.part.stock_diameter_mm > 0.97 * height {
            return Err(SettingError::at(
                "part.stock_diameter_mm",
                format!(
                    "a shaft of {} mm does not fit the field of {height:.2} mm ({} rows at {:.3} µm); at most {:.2} mm, or lower optics.magnification",
                    self.part.stock_diameter_mm,
                    self.camera.rows,
                    self.nominal_mm_per_px() * 1e3,
                    0.97 * height
                ),
            ));
        }
        Ok(())
    }

    /// Whether the fields cover the part, the angles determine its uncertainty, the last pass aims
    /// at the tolerance, and the shaft is one that can be turned: needed by a run, not by `render`.
    ///
    /// # Errors
    /// Names the key and what would be enough.
    pub fn check_coverage(&self) -> Result<(), SettingError> {
        if let Some(key) = self.shaft.finished_key() {
            return Err(SettingError::at(
                key,
                "describes a finished part, which `render` draws; a run turns a plain shaft: leave it out",
            ));
        }
        self.part.check_aim()?;
        self.check_follow()?;
        if self.probe.is_some() {
            return Ok(());
        }
        if self.scan.angles < 2 {
            return Err(SettingError::at(
                "scan.angles",
                "1 angle tells nothing of the section's form, so that no uncertainty could be stated; at least 2, 4 to take \
                 two lobes out of the mean",
            ));
        }
        let needed = (self.part.length_mm / self.field_length_mm()).ceil() as usize;
        if self.scan.fields < needed {
            return Err(SettingError::at(
                "scan.fields",
                format!(
                    "{} fields of {:.1} mm leave gaps on a part of {} mm; at least {needed}",
                    self.scan.fields,
                    self.field_length_mm(),
                    self.part.length_mm
                ),
            ));
        }
        Ok(())
    }

    fn check_masters(&self) -> Result<(), SettingError> {
        if self.masters.frames_each == 0 {
            return Err(SettingError::at("masters.frames_each", "must be at least 1"));
        }
        if self.masters.pins.len() < 2 {
            return Err(SettingError::at(
                "masters.pins",
                "scale and edge offset need two pins of different diameter",
            ));
        }
        for (index, pin) in self.masters.pins.iter().enumerate() {
            let key = format!("masters.pins[{index}]");
            positive(&format!("{key}.diameter_mm"), pin.diameter_mm)?;
            positive(&format!("{key}.expanded_u_mm"), pin.expanded_u_mm)?;
            positive(&format!("{key}.coverage_factor"), pin.coverage_factor)?;
            if pin.diameter_mm > 0.97 * self.field_height_mm() {
                return Err(SettingError::at(
                    format!("{key}.diameter_mm"),
                    format!(
                        "a pin of {} mm does not fit the field of {:.2} mm",
                        pin.diameter_mm,
                        self.field_height_mm()
                    ),
                ));
            }
        }
        let least = self.masters.pins.iter().map(|p| p.diameter_mm).fold(f64::INFINITY, f64::min);
        let most = self.masters.pins.iter().map(|p| p.diameter_mm).fold(0.0, f64::max);
        if most - least < 0.01 * most {
            return Err(SettingError::at(
                "masters.pins",
                "the pins must differ by 1 % in diameter to separate scale from edge offset",
            ));
        }
        Ok(())
    }
}
