//! `study line-camera`: speed of measuring the readings of a line camera, and their repeatability
//! beside its bound.
//!
//! The part is placed at sixteen positions a sixteenth of a pixel apart, in turn, so that every
//! phase occurs. Repeatability is the standard deviation of measured less true width; the bound is
//! that of Cramér and Rao for the width with given levels, blur and noise, over all pixels of the
//! line, from noise-free lines drawn a fiftieth of a pixel apart and the sensor's own noise.
//! Readings are measured one by one as a stream, and in blocks as from a frame grabber.

use std::time::Instant;

use serde::Serialize;
use thiserror::Error;

use crate::frame::{Frame, FrameView, PixelFormat, Pixels};
use crate::gauge::{EdgeStream, FrameEdges, Gauge, GaugeSettings};
use crate::job::Job;
use crate::render::form::form_shaft;
use crate::render::{FrameRequest, OpticalSetup, RenderError, Renderer, Scene};
use crate::setting::SettingError;
use crate::shaft::{Pose, ProfileKnot};
use crate::truth;

/// Number of positions of the part within a pixel.
const PLACES: usize = 16;
/// Readings of a block.
pub(crate) const BLOCK: usize = 256;
/// Half the distance between the lines of a difference quotient, px.
const STEP_PX: f64 = 0.01;
/// Readings after which a stream pools as many as it retains.
const SETTLED: usize = 32;
/// Step from one reading's edge to the next that a block allows, px: a part does not move farther
/// within 60 µs.
const MOST_STEP_PX: f64 = 3.0;

/// Why a study cannot be run.
#[derive(Debug, Error)]
pub(crate) enum LineCameraError {
    /// The job.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The renderer.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A block that is not a valid frame.
    #[error("a block of readings is no frame: {0}")]
    Block(String),
    /// Nothing was measured.
    #[error("no reading could be measured: {0}")]
    Nothing(String),
}

/// Results of the readings, measured in one way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LineCameraRow {
    /// `one_by_one` or `blocks`.
    pub way: &'static str,
    /// Readings measured.
    pub readings: usize,
    /// Readings without a width.
    pub lost: usize,
    /// Edges measured per second, on one thread.
    pub edges_per_s: f64,
    /// Readings per second, kHz.
    pub rate_khz: f64,
    /// Mean of measured less true width, µm on the object.
    pub mean_um: f64,
    /// Standard deviation of measured less true width, µm on the object.
    pub repeatability_um: f64,
    /// Its bound, µm on the object.
    pub bound_um: f64,
    /// Rms of error over stated standard uncertainty.
    pub rms_error_over_u: f64,
}

/// Sums of one way.
#[derive(Debug, Default)]
struct Sums {
    lost: usize,
    n: f64,
    error: f64,
    square: f64,
    normalised: f64,
    seconds: f64,
    timed: f64,
    why: String,
}

impl Sums {
    fn add(&mut self, edges: &FrameEdges, column: usize, true_px: f64) {
        let Some(width) = edges.width_px(column) else {
            self.lost += 1;
            return;
        };
        let (error, u) = (width - true_px, edges.top[column].u_px().hypot(edges.bottom[column].u_px()));
        self.n += 1.0;
        self.error += error;
        self.square += error * error;
        self.normalised += (error / u).powi(2);
    }

    fn row(&self, way: &'static str, (um_per_px, bound_px): (f64, f64)) -> Option<LineCameraRow> {
        let mean = self.error / self.n;
        let variance = (self.square / self.n - mean * mean).max(0.0);
        (self.n > 1.0).then(|| LineCameraRow {
            way,
            readings: self.n as usize,
            lost: self.lost,
            edges_per_s: 2.0 * self.timed / self.seconds,
            rate_khz: 1e-3 * self.timed / self.seconds,
            mean_um: um_per_px * mean,
            repeatability_um: um_per_px * (variance * self.n / (self.n - 1.0)).sqrt(),
            bound_um: um_per_px * bound_px,
            rms_error_over_u: (self.normalised / self.n).sqrt(),
        })
    }
}

/// Checks the job: its camera must be a line camera.
///
/// # Errors
/// The first setting that is refused.
pub(crate) fn check(job: &Job) -> Result<(), SettingError> {
    job.check()?;
    match job.camera.line {
        Some(_) => Ok(()),
        None => {
            Err(SettingError::at("camera.line", "a line camera is needed: [camera.line] with its rate_khz"))
        }
    }
}

/// Draws and measures `readings` readings of the finished part; `done` is called after each.
///
/// # Errors
/// Where nothing can be drawn or measured.
pub(crate) fn run(
    job: &Job,
    readings: usize,
    renderer: &Renderer,
    done: &dyn Fn(),
) -> Result<Vec<LineCameraRow>, LineCameraError> {
    let setup = OpticalSetup::resolve(&job.setup_settings(), job.seed)?;
    let step_mm = setup.pixel_mm / PLACES as f64;
    let scenes = (0..PLACES).map(|k| scene_at(job, &setup, step_mm * k as f64));
    let scenes = scenes.collect::<Result<Vec<Scene>, RenderError>>()?;
    let truth: Vec<f64> = scenes.iter().map(|scene| true_width_px(job, scene)).collect::<Result<_, _>>()?;
    let mut variance = 0.0;
    for place in 0..PLACES {
        variance += bound_variance_px2(job, &setup, renderer, step_mm * place as f64)? / PLACES as f64;
    }
    let settings = job.gauge_settings()?;
    let beside = GaugeSettings { outlier_px: 1e3, max_slope: MOST_STEP_PX, ..settings.clone() };
    let mut stream = Gauge::new(settings)?.stream();
    let mut blocks =
        Blocks { stream: Gauge::new(beside)?.stream(), lines: Vec::new(), edges: FrameEdges::default() };
    let (mut one_by_one, mut in_blocks) = (Sums::default(), Sums::default());
    let (mut edges, mut spare) = (FrameEdges::default(), None);
    for k in 0..readings {
        let request = FrameRequest { frame_id: k as u64, ..request(job, true) };
        let frame = renderer.render(&scenes[k % PLACES], &request, spare.take())?;
        let start = Instant::now();
        let measured = stream.measure(&frame.view(), &mut edges);
        let seconds = start.elapsed().as_secs_f64();
        done();
        match measured {
            Ok(()) if k >= SETTLED => {
                one_by_one.add(&edges, 0, truth[k % PLACES]);
                one_by_one.seconds += seconds;
                one_by_one.timed += 1.0;
            }
            Ok(()) => {}
            Err(refused) => {
                one_by_one.lost += 1;
                one_by_one.why = refused.to_string();
            }
        }
        blocks.push(&frame, k, &truth, &mut in_blocks)?;
        spare = Some(frame);
    }
    let scale = (1e3 * setup.pixel_mm, variance.sqrt());
    let rows: Vec<LineCameraRow> = [("one_by_one", &one_by_one), ("blocks", &in_blocks)]
        .into_iter()
        .filter_map(|(way, s)| s.row(way, scale))
        .collect();
    if rows.is_empty() { Err(LineCameraError::Nothing(one_by_one.why)) } else { Ok(rows) }
}

/// Blocks of readings.
struct Blocks {
    stream: EdgeStream,
    lines: Vec<u16>,
    edges: FrameEdges,
}

impl Blocks {
    /// Appends a reading, and measures the block that it fills; the first block is not timed.
    fn push(
        &mut self,
        frame: &Frame,
        k: usize,
        truth: &[f64],
        sums: &mut Sums,
    ) -> Result<(), LineCameraError> {
        let view = frame.view();
        let rows = view.rows();
        match view.pixels() {
            Pixels::U16(pixels) => self.lines.extend_from_slice(pixels),
            Pixels::U8(pixels) => self.lines.extend(pixels.iter().map(|p| u16::from(*p))),
            Pixels::F32(_) => {
                return Err(LineCameraError::Block("its pixels are no whole counts".to_owned()));
            }
        }
        if self.lines.len() < BLOCK * rows {
            return Ok(());
        }
        let block = FrameView::new(Pixels::U16(&self.lines), wide(view.format()), BLOCK, rows, rows)
            .map_err(|e| LineCameraError::Block(e.to_string()))?;
        let start = Instant::now();
        let measured = self.stream.measure(&block.transposed(), &mut self.edges);
        let seconds = start.elapsed().as_secs_f64();
        match measured {
            Ok(()) => {
                let first = k + 1 - BLOCK;
                (0..BLOCK).for_each(|c| sums.add(&self.edges, c, truth[(first + c) % PLACES]));
                if first > 0 {
                    sums.seconds += seconds;
                    sums.timed += BLOCK as f64;
                }
            }
            Err(refused) => {
                sums.lost += BLOCK;
                sums.why = refused.to_string();
            }
        }
        self.lines.clear();
        Ok(())
    }
}

/// The format that holds a format's counts in 16 bits.
fn wide(format: PixelFormat) -> PixelFormat {
    if format == PixelFormat::Mono8 { PixelFormat::Mono16 } else { format }
}

/// The finished part, moved across the line.
fn scene_at(job: &Job, setup: &OpticalSetup, x_mm: f64) -> Result<Scene, RenderError> {
    let diameter = job.part.nominal_diameter_mm.last().copied().unwrap_or(job.part.stock_diameter_mm);
    let profile = vec![ProfileKnot { z_mm: 0.0, radius_mm: diameter / 2.0 }];
    let mut shaft = form_shaft(profile, &job.shaft, job.part.length_mm, job.seed)?;
    shaft.pose = Pose { x_mm: shaft.pose.x_mm + x_mm, ..shaft.pose };
    Scene::new(setup, shaft)
}

fn request(job: &Job, noise: bool) -> FrameRequest {
    FrameRequest { z_mm: 0.5 * job.part.length_mm, noise, seed: job.seed, ..FrameRequest::default() }
}

fn true_width_px(job: &Job, scene: &Scene) -> Result<f64, RenderError> {
    let edges = truth::true_edges(scene, &request(job, false))?;
    Ok(edges.first().map_or(f64::NAN, |e| e.bottom_px - e.top_px))
}

/// Smallest variance of an unbiased estimate of the width, px²: 1/I of both edges, each from its
/// half of the line.
fn bound_variance_px2(
    job: &Job,
    setup: &OpticalSetup,
    renderer: &Renderer,
    x_mm: f64,
) -> Result<f64, RenderError> {
    let line = |by_px: f64| -> Result<(Vec<f64>, f64), RenderError> {
        let scene = scene_at(job, setup, x_mm + by_px * setup.pixel_mm)?;
        let request = FrameRequest { format: Some(PixelFormat::F32), ..request(job, false) };
        let edges = truth::true_edges(&scene, &request)?;
        let frame = renderer.render(&scene, &request, None)?;
        let middle = edges.first().map_or(f64::NAN, |e| 0.5 * (e.top_px + e.bottom_px));
        match frame.view().pixels() {
            Pixels::F32(pixels) => Ok((pixels.iter().map(|p| f64::from(*p)).collect(), middle)),
            _ => Ok((Vec::new(), middle)),
        }
    };
    let ((up, middle), (down, _)) = (line(STEP_PX)?, line(-STEP_PX)?);
    let sensor = &setup.nominal.sensor;
    let per_count = setup.electrons_per_count;
    let rounding = if sensor.format == PixelFormat::F32 { 0.0 } else { 1.0 / 12.0 };
    let mut information = [0.0; 2];
    for (row, (a, b)) in up.iter().zip(&down).enumerate() {
        let electrons = ((0.5 * (a + b) - sensor.black_level_counts) * per_count).max(0.0);
        let variance = (electrons + sensor.read_noise_e.powi(2)) / (per_count * per_count) + rounding;
        information[usize::from(row as f64 > middle)] += ((a - b) / (2.0 * STEP_PX)).powi(2) / variance;
    }
    Ok(information.iter().map(|i| 1.0 / i).sum())
}
