//! The loop's half of a job: what the closed loop needs, whatever cell it turns on.

use super::error::{from_control, from_nc};
use super::field_of_view::FieldOfView;
use super::nc_job::NcJob;
use super::part::Part;
use super::scan::{Masters, Scan, ScanWhen, StockScan};
use super::sections::{self, Drawing};
use super::{probe, stations};
use crate::control::{ControlSettings, ControllerName, Workpiece};
use crate::gauge::GaugeSettings;
use crate::gauge::calibration::{Conditions, HeadGeometry};
use crate::plan::{
    Contour, CuttingData, DiameterOffset, FeedDirection, PassPlan, PlannedForm, ScanPlan, StationLayout,
};
use crate::probe::ProbeSettings;
use crate::setting::{SettingError, positive};
use crate::shaft::ContourPoint;

/// Everything the closed loop needs besides a cell. The fields that are tables of a config file
/// have its keys; the others follow from its `[camera]`, `[optics]` and `[process]`.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopJob {
    /// Name for reports; identifies the optics in the calibration.
    pub name: String,
    /// The part and its passes.
    pub part: Part,
    /// The drawing of a stepped shaft, corner by corner; empty for a plain one.
    pub contour: Vec<ContourPoint>,
    /// Passes to cut, where not all of the part's.
    pub passes: Option<usize>,
    /// Cutting data of every pass.
    pub cutting: CuttingData,
    /// The way the tool travels.
    pub feed_direction: FeedDirection,
    /// Where steady rests stand, mm from the chuck face.
    pub steady_z_mm: Vec<f64>,
    /// Expansion of the part's material, µm/(m·K).
    pub expansion_um_per_m_k: f64,
    /// Force and stiffness that the model-based controller assumes; length and stock are the
    /// part's.
    pub workpiece: Workpiece,
    /// Fields and angles.
    pub scan: Scan,
    /// Master pins.
    pub masters: Masters,
    /// The camera's data sheet.
    pub field: FieldOfView,
    /// The gauge.
    pub gauge: GaugeSettings,
    /// A touch probe: where it stands, the loop takes its diameters from it in place of the camera.
    pub probe: Option<ProbeSettings>,
    /// Where the machine carries the head, as far as it was identified: the readings are corrected
    /// by it. None where it counts as standing as commanded.
    pub head_geometry: Option<HeadGeometry>,
    /// The controller.
    pub control: ControlSettings,
    /// The control that the offsets go to: the controller is given what its rounding leaves
    /// of them. Without one offsets are commanded as they are.
    pub nc: Option<NcJob>,
}

impl Default for LoopJob {
    fn default() -> Self {
        Self {
            name: "slender shaft".to_owned(),
            part: Part::default(),
            contour: Vec::new(),
            passes: None,
            cutting: CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 },
            feed_direction: FeedDirection::default(),
            steady_z_mm: Vec::new(),
            expansion_um_per_m_k: Conditions::default().expansion_um_per_m_k,
            workpiece: Workpiece::default(),
            scan: Scan::default(),
            masters: Masters::default(),
            field: FieldOfView::default(),
            gauge: GaugeSettings::default(),
            probe: None,
            head_geometry: None,
            control: ControlSettings::default(),
            nc: None,
        }
    }
}

impl LoopJob {
    /// Passes to cut.
    pub fn passes(&self) -> usize {
        self.passes.unwrap_or(usize::MAX).min(self.part.passes())
    }

    /// Plan of pass `pass` (from 1) with the given offsets.
    pub fn pass_plan(&self, pass: u32, offset: DiameterOffset) -> PassPlan {
        PassPlan {
            pass,
            nominal_mm: self.part.target_mm(pass),
            cutting: self.cutting,
            station_z_mm: self.station_z_mm(),
            offset,
            form: self.turned_contour().map_or(PlannedForm::PLAIN, PlannedForm::stepped),
        }
    }

    /// Middles of the stations, mm from the chuck face, ascending: those of the part; of a stepped
    /// shaft those of its sections.
    pub fn station_z_mm(&self) -> Vec<f64> {
        match (self.turned_contour(), self.part.listed()) {
            (Some(contour), None) => sections::station_z_mm(&contour, self.part.station_mm),
            _ => self.part.station_z_mm(),
        }
    }

    /// The stations as a controller needs them.
    pub(crate) fn layout(&self) -> StationLayout {
        StationLayout {
            z_mm: self.station_z_mm(),
            contour: self.turned_contour(),
            steady_z_mm: self.steady_z_mm.clone(),
        }
    }

    /// The contour that all passes leave; none for a plain shaft, or where [`Self::check_coverage`]
    /// refuses it.
    pub(crate) fn turned_contour(&self) -> Option<Contour> {
        self.contour_to_turn().ok().flatten()
    }

    /// The same, or why it cannot be turned.
    ///
    /// # Errors
    /// Names the point of the contour or the entry of `[[part.sections]]`.
    pub(crate) fn contour_to_turn(&self) -> Result<Option<Contour>, SettingError> {
        if self.contour.is_empty() { Ok(None) } else { self.drawing().contour().map(Some) }
    }

    fn drawing(&self) -> Drawing<'_> {
        Drawing {
            points: &self.contour,
            part: &self.part,
            mm_per_px: self.field.mm_per_px,
            direction: self.feed_direction,
        }
    }

    /// Whether the contour can be turned, and its sections be measured.
    fn check_contour(&self) -> Result<(), SettingError> {
        if self.contour.is_empty() {
            let Some(first) = self.part.sections.first() else { return Ok(()) };
            let why = format!("{} mm: sections are those of [shaft] contour, and there is none", first.z_mm);
            return Err(SettingError::at("part.sections[0].z_mm", why));
        }
        if self.part.tolerance.is_some() {
            let why = "a contour has a tolerance a section: write it in [[part.sections]], with z_mm on the section";
            return Err(SettingError::at("part.tolerance", why));
        }
        if self.part.aim_mm != 0.0 {
            let why = "a contour has an aim a section: [[part.sections]] aim_mm";
            return Err(SettingError::at("part.aim_mm", why));
        }
        if self.scan.when == ScanWhen::DuringCut {
            let why = "a contour is cut at constant cutting speed, so that the spindle turns faster on its thin sections and \
                       the angles of a burst are not those planned: scan after_pass";
            return Err(SettingError::at("scan.when", why));
        }
        let contour = self.drawing().contour()?;
        let listed = self.part.listed().map(|z| sections::check_listed(&contour, z, self.part.station_mm));
        listed.unwrap_or(Ok(()))?;
        sections::check_steady(&contour, &self.contour, &self.steady_z_mm)
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

    /// The controller's settings as a run uses them: the workpiece of the model-based controller,
    /// its length and stock from the part, where `[control.model]` does not give it, and the lower
    /// limit of size from the part's tolerance.
    pub fn run_control(&self) -> ControlSettings {
        let mut control = self.control.clone();
        control.model = control.model.for_workpiece(&Workpiece {
            length_mm: self.part.length_mm,
            stock_diameter_mm: self.part.stock_diameter_mm,
            ..self.workpiece
        });
        let lower = self.part.tolerance.map(|t| t.nominal_mm + t.lower_mm).filter(|l| *l > 0.0);
        control.guards.lower_limit_mm = control.guards.lower_limit_mm.or(lower);
        control
    }

    /// Warnings for a run that no cell changes: an aim at a limit of size.
    pub fn cautions(&self) -> Vec<String> {
        self.part.aims_at_a_limit().into_iter().collect()
    }

    /// Length along z in one frame, mm, at the nominal magnification; slightly less than the whole
    /// field, so that fields overlap whatever the true magnification is. A frame of a line camera
    /// shows a single z: one reading per station.
    pub fn field_length_mm(&self) -> f64 {
        if self.field.is_line {
            return self.part.station_mm;
        }
        0.97 * f64::from(self.field.columns) * self.field.mm_per_px
    }

    /// Checks the part, its passes and their cutting data.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(super) fn check_passes(&self) -> Result<(), SettingError> {
        self.part.check()?;
        if self.passes.is_some_and(|n| n == 0 || n > self.part.passes()) {
            return Err(SettingError::at(
                "passes",
                format!("must be 1 to {}, the nominal diameters given", self.part.passes()),
            ));
        }
        positive("cutting.speed_m_per_min", self.cutting.speed_m_per_min)?;
        positive("cutting.feed_mm_per_rev", self.cutting.feed_mm_per_rev)
    }

    /// Checks the settings of gauge, program and controller, each by itself.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(super) fn check_stages(&self) -> Result<(), SettingError> {
        self.gauge.validate()?;
        self.check_nc()?;
        self.control.validate()
    }

    /// Checks the probe, or scan and masters in the camera's field.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub(super) fn check_instrument(&self) -> Result<(), SettingError> {
        if let Some(probe) = &self.probe {
            return probe::check(probe, &self.masters);
        }
        self.field.check()?;
        self.check_scan()?;
        self.check_fits("part.stock_diameter_mm", self.part.stock_diameter_mm)?;
        self.check_masters()
    }

    /// Checks every setting and the conditions across stages.
    ///
    /// # Errors
    /// The first setting that is refused.
    pub fn check(&self) -> Result<(), SettingError> {
        self.check_passes()?;
        self.check_stages()?;
        self.check_instrument()
    }

    /// Checks that a path of the first pass is possible, and that the settings are in range.
    fn check_nc(&self) -> Result<(), SettingError> {
        let Some(nc) = &self.nc else { return Ok(()) };
        let stations = self.station_z_mm().len();
        let plan = self.pass_plan(1, DiameterOffset::zero(stations));
        crate::nc::Path::new(&plan, &nc.machine, nc.dialect).map(drop).map_err(from_nc)
    }

    /// Checks that the controller can be built for the job's stations: an unstable loop is refused
    /// here, so that a study of stability can still read the config.
    ///
    /// # Errors
    /// The controller's reason.
    pub fn check_control(&self) -> Result<(), SettingError> {
        crate::control::build(&self.run_control(), self.layout()).map(drop).map_err(from_control)
    }

    /// Checks the numbers of fields and angles.
    pub(super) fn check_scan(&self) -> Result<(), SettingError> {
        if self.scan.fields == 0 || self.scan.fields > 100_000 {
            return Err(SettingError::at("scan.fields", "must be between 1 and 100 000"));
        }
        if self.scan.angles == 0 || self.scan.angles > 100_000 {
            return Err(SettingError::at("scan.angles", "must be between 1 and 100 000"));
        }
        Ok(())
    }

    /// Checks that a shaft fits the field; `key` is its diameter's.
    pub(super) fn check_fits(&self, key: &str, diameter_mm: f64) -> Result<(), SettingError> {
        let height = self.field.height_mm();
        if diameter_mm > 0.97 * height {
            return Err(SettingError::at(
                key,
                format!(
                    "a shaft of {diameter_mm} mm does not fit the field of {height:.2} mm ({} rows at {:.3} µm); at most {:.2} mm, or lower optics.magnification",
                    self.field.rows,
                    self.field.mm_per_px * 1e3,
                    0.97 * height
                ),
            ));
        }
        Ok(())
    }

    /// Whether the fields cover the part, the angles determine its uncertainty, and the last pass
    /// aims at the tolerance: needed by a run, not by `render`.
    ///
    /// # Errors
    /// Names the key and what would be enough.
    pub fn check_coverage(&self) -> Result<(), SettingError> {
        self.check_contour()?;
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
            if pin.diameter_mm > 0.97 * self.field.height_mm() {
                return Err(SettingError::at(
                    format!("{key}.diameter_mm"),
                    format!(
                        "a pin of {} mm does not fit the field of {:.2} mm",
                        pin.diameter_mm,
                        self.field.height_mm()
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
