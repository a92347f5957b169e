//! The nose: rendered, measured by both modes, and as it truly is.

use serde::Serialize;
use serde_json::json;

use super::error::WornToolError;
use super::settings::Settings;
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::nose::paper::{PaperNose, PaperSettings, measure_paper_nose};
use crate::gauge::nose::{NoseMeasurement, NoseSettings, measure_nose};
use crate::measurement::nose::{NoseDocument, NoseImage};
use crate::nose::{Feed, NoseProfile, Numbering, ToolGeometry};
use crate::outline::Side;
use crate::render::insert::{Truth, render_insert};
use crate::tool::{Setting, Stated, ToolFile, read_nose};

/// Cutting edge angle of the paper's holder, degrees.
const KAPPA_R_DEG: f64 = 93.0;
/// Tip direction of a tool set in X and Z, by Fanuc's numbers: towards axis and chuck.
const TIP: u8 = 3;
/// Directions as seen of what cuts cylinders and faces, degrees: +X up, +Z to the right.
const CYLINDER_DEG: f64 = 270.0;
const FACE_DEG: f64 = 180.0;

/// The figures that the paper takes from a nose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct PaperRadii {
    /// Nominal radius R0, mm.
    pub nominal_mm: f64,
    /// Mean radius r, mm.
    pub radius_mm: f64,
    /// Gaps between the worn nose and the tangents of the new one along X and Z, mm.
    pub gaps_mm: [f64; 2],
}

impl PaperRadii {
    /// R1 = R0 less the mean gap, mm.
    pub(crate) fn set_radius_mm(&self) -> f64 {
        self.nominal_mm - 0.5 * (self.gaps_mm[0] + self.gaps_mm[1])
    }

    fn of(nose: &PaperNose, nominal_mm: f64, um_per_px: f64) -> Self {
        let mm = 1e-3 * um_per_px;
        let gap = |deg: f64| nominal_mm - mm * nose.reach_px(deg);
        Self { nominal_mm, radius_mm: mm * nose.mean_radius_px, gaps_mm: [gap(CYLINDER_DEG), gap(FACE_DEG)] }
    }
}

/// The nose in all its forms.
#[derive(Clone, Debug)]
pub(crate) struct Noses {
    /// The frame.
    pub frame: Frame,
    /// By the program's own mode, px.
    pub measured: NoseMeasurement,
    /// Scale, µm per px.
    um_per_px: f64,
    /// The tool of the study, set when new.
    pub(super) tool: ToolFile,
    pub(super) geometry: ToolGeometry,
    /// Nominal radius, mm.
    pub(super) nominal_mm: f64,
    /// The nose's document, as `tool nose` writes it.
    pub(super) document: String,
    /// As measured.
    pub(super) known: NoseProfile,
    /// As it is.
    pub(super) real: NoseProfile,
    truth: Truth,
    /// By the paper's mode, or why not.
    pub(super) paper: Result<PaperRadii, String>,
}

/// What was found of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct NoseFound {
    /// Mean radius: true, measured, its standard uncertainty, mm.
    pub mean_radius_mm: [f64; 3],
    /// Distance of the measured centre from the true one, µm.
    pub centre_off_um: f64,
    /// Largest error of e(a) over 0° to 90°, set by touching, R0 in the register, µm.
    pub e_off_um: f64,
    /// Largest standard uncertainty of e(a) there, µm.
    pub u_e_um: f64,
    /// What the measurement flagged.
    pub flags: Vec<&'static str>,
    /// By the paper's mode.
    pub paper: Option<PaperRadii>,
    /// Its R1, mm.
    pub paper_set_radius_mm: Option<f64>,
    /// Why there is none.
    pub paper_refused: Option<String>,
}

/// e(a) by the truth and as measured: angle of the normal in degrees, µm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ErrorCurves {
    /// Of the true nose, R0 in the register.
    pub real: Vec<(f64, f64)>,
    /// Of the measured one.
    pub known: Vec<(f64, f64)>,
    /// Of the true nose with the paper's R1.
    pub by_set_radius: Vec<(f64, f64)>,
}

impl Noses {
    /// Renders and measures.
    ///
    /// # Errors
    /// An insert that cannot be rendered, a nose that the program's own mode refuses.
    pub(super) fn new(settings: &Settings) -> Result<Self, WornToolError> {
        let mut insert = settings.insert.clone();
        let nominal_mm = insert.nose.radius_mm;
        let tool = tool(nominal_mm, insert.nose.epsilon_deg);
        let geometry = tool.geometry()?;
        let (low, high) = geometry.range_rad();
        insert.nose.direction_deg = CYLINDER_DEG - 0.5 * (low + high).to_degrees();
        let (frame, truth) = render_insert(&insert, (settings.seed, 0), true)?;
        let um_per_px = insert.camera.um_per_px;
        let nominal_radius_px = 1e3 * nominal_mm / um_per_px;
        let wanted = NoseSettings { nominal_radius_px: Some(nominal_radius_px), um_per_px, expected: None };
        let refused = |e: &dyn std::fmt::Display| WornToolError::Nose(e.to_string());
        let measured = measure_nose(&frame.view(), &wanted).map_err(|e| refused(&e))?;
        let image =
            NoseImage::new("rendered".to_owned(), &measured, None, &Calibration::from_scale(um_per_px));
        let document = NoseDocument { images: vec![image] };
        let document = serde_json::to_string(&document).map_err(|e| refused(&e))?;
        let known = read_nose(&document, None, tool.image, &geometry)?.profile;
        let real = read_nose(&truth_document(&truth, um_per_px), None, tool.image, &geometry)?.profile;
        let by_paper =
            PaperSettings { nominal_radius_px, epsilon_deg: insert.nose.epsilon_deg, expected: None };
        let paper = measure_paper_nose(&frame.view(), &by_paper);
        let paper = paper.map(|nose| PaperRadii::of(&nose, nominal_mm, um_per_px)).map_err(|e| e.to_string());
        Ok(Self {
            frame,
            measured,
            um_per_px,
            tool,
            geometry,
            nominal_mm,
            document,
            known,
            real,
            truth,
            paper,
        })
    }

    /// What was found.
    pub(super) fn found(&self) -> NoseFound {
        let mm = 1e-3 * self.um_per_px;
        let [column, row] = self.truth.centre_px;
        let off = (self.measured.centre.x - column).hypot(self.measured.centre.y + row);
        let e = curves(self);
        let largest = e.real.iter().zip(&e.known).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
        let touched = Setting::new(&self.known, &self.geometry, &Stated::default());
        let u = |a: &(f64, f64)| touched.as_ref().map_or(f64::NAN, |s| 1e3 * s.u_left_mm(a.0.to_radians()));
        NoseFound {
            mean_radius_mm: [
                self.truth.mean_radius_px,
                self.measured.mean_radius_px,
                self.measured.u_mean_radius_px,
            ]
            .map(|px| mm * px),
            centre_off_um: self.um_per_px * off,
            e_off_um: largest,
            u_e_um: e.known.iter().map(u).fold(0.0, f64::max),
            flags: self.measured.flags.clone(),
            paper: self.paper.clone().ok(),
            paper_set_radius_mm: self.paper.as_ref().ok().map(PaperRadii::set_radius_mm),
            paper_refused: self.paper.as_ref().err().cloned(),
        }
    }
}

/// e(a) over 0° to 90° of a nose set by touching.
pub(crate) fn curves(noses: &Noses) -> ErrorCurves {
    let of = |nose: &NoseProfile, register_mm: f64| {
        let setting = Setting::new(nose, &noses.geometry, &Stated::default());
        let at = |deg: i32| {
            let a = f64::from(deg);
            let left = setting.as_ref().map_or(f64::NAN, |s| 1e3 * s.left_mm(a.to_radians(), register_mm));
            (a, left)
        };
        (0..=90).map(at).collect::<Vec<_>>()
    };
    let set_radius_mm = noses.paper.as_ref().map(PaperRadii::set_radius_mm);
    ErrorCurves {
        real: of(&noses.real, noses.nominal_mm),
        known: of(&noses.known, noses.nominal_mm),
        by_set_radius: set_radius_mm.map_or_else(|_| Vec::new(), |r| of(&noses.real, r)),
    }
}

/// The true nose as a document of `tool nose`.
fn truth_document(truth: &Truth, um_per_px: f64) -> String {
    let row = |[direction_deg, h_px]: [f64; 2]| {
        let direction_deg = direction_deg.rem_euclid(360.0);
        json!({ "direction_deg": direction_deg, "h_um": um_per_px * h_px, "u_um": 0.0 })
    };
    let rows: Vec<_> = truth.support.iter().copied().map(row).collect();
    json!({ "images": [{ "image": "truth", "support": rows }] }).to_string()
}

/// The tool of the paper, its image with +X up and +Z to the right.
fn tool(nose_radius_mm: f64, epsilon_r_deg: f64) -> ToolFile {
    ToolFile {
        nose_radius_mm,
        kappa_r_deg: KAPPA_R_DEG,
        epsilon_r_deg,
        clearance_deg: 0.0,
        tip_direction: TIP,
        numbering: Numbering::default(),
        side: Side::External,
        feed: Feed::TowardsChuck,
        register_mm: None,
        image: Default::default(),
        setting: Default::default(),
        measured_pass: None,
    }
}
