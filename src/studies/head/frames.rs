//! Frames of a part behind a head, rendered and measured: what its repeatability and its edge model
//! come to, beside the prediction.
//!
//! A frame a sixteenth (in general one over the number of frames) of a pixel apart from the last,
//! so that every phase occurs, of the middle columns, the part inclined so that either edge
//! travels by a pixel. Every frame is measured by the edge of the head's own optics and by the
//! plain Gaussian; errors are measured less true widths, uncalibrated. What they have in common is
//! the edge model's, what scatters is noise.

use serde::Serialize;

use super::error::HeadError;
use super::repeatability::Repeatability;
use super::setup::HeadSetup;
use crate::frame::Roi;
use crate::gauge::{EdgeStream, EsfModel, FrameEdges, Gauge, GaugeSettings};
use crate::render::{FrameRequest, OpticalSetup, RenderError, Renderer, Scene};
use crate::shaft::{Eccentricity, Pose, Shaft};
use crate::truth;

/// Most columns of a frame: the scatter of 512 is known to 3 %.
const MOST_COLUMNS: u32 = 512;

/// Errors of rendered frames with one edge model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct ModelErrors {
    /// Edge model: `gaussian`, or `optics` for the edge of the head's own.
    pub model: &'static str,
    /// Frames measured.
    pub frames: usize,
    /// Frames refused.
    pub refused: usize,
    /// Why the last of them was.
    pub why: Option<String>,
    /// Mean of measured less true diameter, µm: what all have in common, before any calibration.
    pub mean_um: Option<f64>,
    /// Its standard uncertainty by the frames' scatter, µm.
    pub u_mean_um: Option<f64>,
    /// Standard deviation of the frames' means, µm.
    pub frame_sd_um: Option<f64>,
    /// Standard deviation of single columns about their frame's mean, µm.
    pub column_sd_um: Option<f64>,
    /// Columns of a frame.
    pub columns: usize,
}

/// What frames gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FrameCheck {
    /// By the edge of the head's own optics.
    pub own: ModelErrors,
    /// By the plain Gaussian; none where that is its own.
    pub gaussian: Option<ModelErrors>,
    /// Scatter of columns about their frame's mean over the bound: what all columns of a frame
    /// share is not in either.
    pub column_ratio: Option<f64>,
    /// Its standard uncertainty by the number of columns, 1/√(2n) of it.
    pub u_column_ratio: Option<f64>,
    /// Scatter of the frames' means over the prediction for as many columns.
    pub frame_ratio: Option<f64>,
    /// Its standard uncertainty by the number of frames.
    pub u_frame_ratio: Option<f64>,
}

impl FrameCheck {
    /// Why no frame could be measured by the edge of the head's own optics, where none could: the
    /// gauge tests every column's residual against its noise, which is stricter than the residual
    /// of a smeared edge alone.
    pub(super) fn refused(&self) -> Option<String> {
        let why = self.own.why.as_deref().unwrap_or("no column has both edges");
        (self.own.frames == 0).then(|| format!("rendered frames are refused: {why}"))
    }
}

/// Sums of one model over frames.
struct Sums {
    /// Frames follow one another, as those of a camera.
    stream: EdgeStream,
    edges: FrameEdges,
    model: &'static str,
    means: Vec<f64>,
    squares: f64,
    freedom: f64,
    refused: usize,
    why: Option<String>,
}

impl Sums {
    fn new(settings: GaugeSettings, model: &'static str) -> Result<Self, HeadError> {
        let stream = Gauge::new(settings)?.stream();
        let edges = FrameEdges::default();
        Ok(Self {
            stream,
            edges,
            model,
            means: Vec::new(),
            squares: 0.0,
            freedom: 0.0,
            refused: 0,
            why: None,
        })
    }

    /// Measures a frame of these true widths, px.
    fn add(&mut self, frame: &crate::frame::Frame, true_px: &[f64]) {
        if let Err(refused) = self.stream.measure(&frame.view(), &mut self.edges) {
            self.refused += 1;
            self.why = Some(refused.to_string());
            return;
        }
        let edges = &self.edges;
        let errors: Vec<f64> = true_px
            .iter()
            .enumerate()
            .filter_map(|(column, truth)| Some(edges.width_px(column)? - truth))
            .collect();
        if errors.is_empty() {
            self.refused += 1;
            return;
        }
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        self.means.push(mean);
        self.squares += errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        self.freedom += n - 1.0;
    }

    fn errors(&self, um_per_px: f64, columns: usize) -> ModelErrors {
        let n = self.means.len() as f64;
        let mean = self.means.iter().sum::<f64>() / n;
        let variance = self.means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let um = |px: f64, known: bool| known.then_some(um_per_px * px);
        ModelErrors {
            model: self.model,
            frames: self.means.len(),
            refused: self.refused,
            why: self.why.clone(),
            mean_um: um(mean, n > 0.0),
            u_mean_um: um((variance / n).sqrt(), n > 1.0),
            frame_sd_um: um(variance.sqrt(), n > 1.0),
            column_sd_um: um((self.squares / self.freedom).sqrt(), self.freedom > 0.0),
            columns,
        }
    }
}

/// Frames of a head as built: its deviations from the nominal setup are drawn by seed.
struct Drawn<'a> {
    head: &'a HeadSetup,
    setup: OpticalSetup,
    frames: usize,
    columns: u32,
}

impl Drawn<'_> {
    fn scene(&self, k: usize) -> Result<Scene, RenderError> {
        let turning = &self.head.turning;
        let mut shaft = Shaft::cylinder(self.head.diameter_mm);
        let by_px = k as f64 / self.frames as f64;
        shaft.pose = Pose {
            x_mm: by_px * self.setup.pixel_mm,
            tilt_mrad: 1e3 / f64::from(self.columns),
            ..Pose::default()
        };
        if turning.rpm > 0.0 {
            shaft.eccentricity = Eccentricity { amplitude_mm: turning.eccentricity_mm, phase_deg: 0.0 };
        }
        Scene::new(&self.setup, shaft)
    }

    /// A frame of the middle columns; a turning part where its run-out is fastest.
    fn request(&self, k: usize, seed: u64) -> FrameRequest {
        let camera = &self.head.job.camera;
        let column = (camera.columns - self.columns) / 2;
        let windows = camera
            .windows
            .map(|w| w.rois(camera.columns).map(|roi| Roi { column, columns: self.columns, ..roi }));
        let whole = Roi { row: 0, column, rows: camera.rows, columns: self.columns };
        let (roi, second_roi) = match windows {
            Some([upper, lower]) => (upper, Some(lower)),
            None => (whole, None),
        };
        let half_deg = 3e-6 * self.head.turning.rpm * self.head.turning.exposure_us;
        FrameRequest {
            frame_id: k as u64,
            noise: true,
            seed,
            roi: Some(roi),
            second_roi,
            angle_deg: 90.0 - half_deg,
            ..FrameRequest::default()
        }
    }
}

/// Renders and measures `frames` frames of the part in use; `done` is called after each.
///
/// # Errors
/// A part that leaves the field, or motion for longer than a turn.
pub(super) fn check(
    head: &HeadSetup,
    (frames, seed): (usize, u64),
    predicted: &Repeatability,
    renderer: &Renderer,
    done: &dyn Fn(u64),
) -> Result<FrameCheck, HeadError> {
    let mut settings = head.job.setup_settings();
    settings.motion.spindle_rpm = head.turning.rpm;
    let setup = OpticalSetup::resolve(&settings, head.job.seed)?;
    let um_per_px = 1e3 * setup.pixel_mm;
    let columns = head.job.camera.columns.min(MOST_COLUMNS);
    let drawn = Drawn { head, setup, frames, columns };
    let mut own = Sums::new(head.gauge.clone(), "optics")?;
    let plain = GaugeSettings { esf: EsfModel::Gaussian {}, ..head.gauge.clone() };
    let is_own = head.gauge.esf == plain.esf;
    let mut gaussian = if is_own { None } else { Some(Sums::new(plain, "gaussian")?) };
    if is_own {
        own.model = "gaussian";
    }
    for k in 0..frames {
        let (scene, request) = (drawn.scene(k)?, drawn.request(k, seed));
        let truth = truth::true_edges(&scene, &request)?;
        let true_px: Vec<f64> = truth.iter().map(|e| e.bottom_px - e.top_px).collect();
        let frame = renderer.render(&scene, &request, None)?;
        own.add(&frame, &true_px);
        if let Some(gaussian) = &mut gaussian {
            gaussian.add(&frame, &true_px);
        }
        done(1);
    }
    let errors = own.errors(um_per_px, columns as usize);
    let column_ratio = errors.column_sd_um.map(|um| um / predicted.bound_um);
    let of_frame = predicted.frame_um * (predicted.columns as f64 / f64::from(columns)).sqrt();
    let frame_ratio = errors.frame_sd_um.map(|um| um / of_frame);
    let u_of = |ratio: Option<f64>, freedom: f64| ratio.map(|ratio| ratio / (2.0 * freedom).sqrt());
    let u_column_ratio = u_of(column_ratio, own.freedom);
    let u_frame_ratio = u_of(frame_ratio, own.means.len() as f64 - 1.0);
    let gaussian = gaussian.map(|sums| sums.errors(um_per_px, columns as usize));
    Ok(FrameCheck { own: errors, gaussian, column_ratio, u_column_ratio, frame_ratio, u_frame_ratio })
}
