//! The simulated cell: process and renderer in place of a lathe and a camera.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::moved_head::Shown;
use super::seen_burst::SeenBurst;
use super::true_probe::TrueProbe;
use super::turning_cell::CellError;
use crate::frame::{Frame, FrameSource, SourceError};
use crate::gauge::MasterCertificate;
use crate::job::{Job, Lathe};
use crate::process::bending::sum_of_lines;
use crate::process::{
    BaseForm, PathDisplacement, PathPlace, ProcessError, ProcessSettings, Stock, TurningProcess,
};
use crate::render::form::form_shaft;
use crate::render::settings::Camera;
use crate::render::{FrameRequest, OpticalSetup, RenderError, Renderer};
use crate::shaft::{AxisKnot, Pose, ProfileKnot, Shaft};

impl From<ProcessError> for CellError {
    fn from(error: ProcessError) -> Self {
        Self::Refused(Box::new(error))
    }
}

impl From<RenderError> for CellError {
    fn from(error: RenderError) -> Self {
        Self::Refused(Box::new(error))
    }
}

/// Process and renderer in place of a lathe and a camera.
pub struct SimulatedCell<'a> {
    pub(super) renderer: &'a Renderer,
    pub(super) setup: OpticalSetup,
    pub(super) process: TurningProcess,
    /// The lathe with its errors; none where it stands as commanded.
    pub(super) lathe: Option<Arc<Lathe>>,
    /// The part at 20 °C.
    pub(super) part: Shaft,
    /// `[shaft.deflection]`: bending of the axis besides the process.
    pub(super) deflection: Vec<AxisKnot>,
    pub(super) masters: TrueMasters,
    /// The part's next frame.
    pub(super) next: NextFrame,
    /// Number of the last pass; 0 before the first.
    pub(super) pass: u32,
    pub(super) batch: Batch,
    pub(super) probe: Option<TrueProbe>,
    /// Bursts of a followed pass.
    pub(super) followed: Vec<SeenBurst>,
}

/// The frame that is taken next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NextFrame {
    /// Its number: with the seed it gives the noise.
    pub(super) id: u64,
    /// Its time, ns.
    pub(super) t_ns: u64,
}

/// True values of the master pins.
#[derive(Clone, Debug)]
pub(super) struct TrueMasters {
    /// Their diameters, mm.
    pub(super) diameter_mm: Vec<f64>,
    /// Id of the next frame of a pin.
    pub(super) frame_id: u64,
}

/// The object of a frame; part and pins have separate frame counters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Acquisition {
    Part,
    Master,
}

/// The part's number in its batch, and the insert that cuts it.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// The stock of every part.
    pub(super) stock: Stock,
    pub(super) name: String,
    pub(super) first_seed: u64,
    pub(super) part: u64,
    pub(super) insert: u32,
}

impl Batch {
    /// Seed of the current part.
    pub(super) fn seed(&self) -> u64 {
        self.first_seed + self.part
    }
}

/// Streams of the job's seed, one per purpose, so that no purpose shifts another's draws.
pub(super) const MASTER_STREAM: u64 = 0x6d61_7374_6572;
pub(super) const PROCESS_STREAM: u64 = 0x0070_726f_6365_7373;
/// Most passes of a part: ids and clock of the next part start beyond them.
const PASSES_OF_A_PART: u64 = 1024;
/// Frame ids of pass k start at k·2³²: noise does not depend on how many frames an earlier pass
/// took.
pub(super) const FRAMES_OF_A_PASS: u64 = 1 << 32;
/// The scan of pass k starts k times this after the clock's zero: about the duration of a cut and
/// its scan, and independent of whether this process scanned an earlier pass.
const PASS_PERIOD_NS: u64 = 600_000_000_000;

/// Number of a frame within its pass, from 0: the other digits of its number are part and pass.
pub(crate) fn frame_of_pass(frame_id: u64) -> u64 {
    frame_id % FRAMES_OF_A_PASS
}

/// The stock with the form errors of `[shaft]`.
fn formed(job: &Job) -> Result<Shaft, RenderError> {
    let blank = vec![ProfileKnot { z_mm: 0.0, radius_mm: job.part.stock_diameter_mm / 2.0 }];
    form_shaft(blank, &job.shaft, job.part.length_mm, job.seed)
}

fn base_form_of(job: &Job, formed: &Shaft) -> Result<BaseForm, RenderError> {
    let (contour, worn) = job.contours()?;
    Ok(BaseForm {
        contour,
        worn,
        lobes: formed.lobes.clone(),
        eccentricity: formed.eccentricity,
        bow: formed.bow.clone(),
        pose: formed.pose,
    })
}

/// The share of a job's `[shaft]` that stays with the part through all passes.
///
/// # Errors
/// Where the shaft is refused.
pub(crate) fn base_form(job: &Job) -> Result<BaseForm, RenderError> {
    base_form_of(job, &formed(job)?)
}

impl<'a> SimulatedCell<'a> {
    /// A cell with the stock clamped and the true optical setup drawn from the job's seed.
    ///
    /// # Errors
    /// Where a stage refuses its settings.
    pub fn new(job: &Job, renderer: &'a Renderer) -> Result<Self, CellError> {
        let setup = OpticalSetup::resolve(&job.setup_settings(), job.seed)?;
        let stock = Stock { diameter_mm: job.part.stock_diameter_mm, length_mm: job.part.length_mm };
        let formed = formed(job)?;
        let form = base_form_of(job, &formed)?;
        let lathe = job.lathe().map_err(ProcessError::from)?.map(Arc::new);
        let settings = process_settings(job, lathe.as_deref());
        let process = TurningProcess::new(&settings, stock, &form, job.seed ^ PROCESS_STREAM)?;
        let process = process.on(lathe.clone().map(|lathe| lathe as Arc<dyn PathDisplacement>));
        let blank = process.blank();
        let deflection = sum_of_lines(&formed.deflection, &blank.deflection);
        let part = Shaft { deflection, spindle: formed.spindle, ..blank };
        Ok(Self {
            renderer,
            setup,
            process,
            lathe,
            part,
            deflection: formed.deflection,
            masters: TrueMasters { diameter_mm: true_masters_mm(&job.masters.pins, job.seed), frame_id: 0 },
            next: NextFrame::default(),
            pass: 0,
            probe: job.probe.as_ref().map(|probe| {
                TrueProbe::new(probe, &job.process.disturbance.guideway, job.part.length_mm, job.seed)
            }),
            followed: Vec::new(),
            batch: Batch { stock, name: job.name.clone(), first_seed: job.seed, part: 0, insert: 0 },
        })
    }
}

impl SimulatedCell<'_> {
    /// A workpiece in this machine: sag and spindle error belong to the machine, not to the part.
    pub(super) fn clamped(&self, part: Shaft) -> Shaft {
        let deflection = sum_of_lines(&self.deflection, &part.deflection);
        Shaft { deflection, spindle: self.part.spindle.clone(), ..part }
    }

    pub(super) fn first_frame_id(&self) -> u64 {
        (self.batch.part * PASSES_OF_A_PART + u64::from(self.pass)) * FRAMES_OF_A_PASS
    }

    pub(super) fn begin_pass(&mut self, pass: u32) {
        self.followed.clear();
        self.pass = pass;
        let t_ns = (self.batch.part * PASSES_OF_A_PART + u64::from(pass)) * PASS_PERIOD_NS;
        self.next = NextFrame { id: self.first_frame_id(), t_ns };
    }

    /// Acquires at stops (z, angle).
    pub(super) fn acquire(
        &mut self,
        shown: Shown,
        stops: Vec<(f64, f64)>,
        acquire: Acquisition,
    ) -> Box<dyn FrameSource + '_> {
        Box::new(SimulatedFrames {
            renderer: self.renderer,
            camera: self.setup.nominal.camera.clone(),
            shown,
            stops,
            next: 0,
            frame_id: match acquire {
                Acquisition::Part => &mut self.next.id,
                Acquisition::Master => &mut self.masters.frame_id,
            },
            clock_ns: &mut self.next.t_ns,
            seed: self.batch.seed(),
            spare: None,
        })
    }
}

/// `[process]` with the lobes that the spindle of a lathe leaves in the middle of the part.
fn process_settings(job: &Job, lathe: Option<&Lathe>) -> ProcessSettings {
    let mut settings = job.process.clone();
    if let Some(lathe) = lathe.filter(|lathe| lathe.spindle_errs()) {
        let last = job.part.passes() as u32;
        let (z_mm, diameter_mm) = (0.5 * job.part.length_mm, job.part.target_mm(last));
        settings.disturbance.spindle_lobes = lathe.lobes(&PathPlace { z_mm, diameter_mm, taper: 0.0 });
    }
    settings
}

/// True diameters of the masters, mm: drawn from the values and uncertainties of their
/// certificates.
fn true_masters_mm(pins: &[MasterCertificate], seed: u64) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(seed ^ MASTER_STREAM);
    pins.iter()
        .map(|pin| {
            let draw: f64 = StandardNormal.sample(&mut random);
            pin.diameter_mm + draw * pin.expanded_u_mm / pin.coverage_factor
        })
        .collect()
}

/// Poses of a pin inserted by hand: slightly off the axis and slightly oblique each time.
pub(super) fn hand_poses(frames: usize, seed: u64) -> Vec<Pose> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut draw = |size: f64| {
        let z: f64 = StandardNormal.sample(&mut random);
        size * z.clamp(-2.0, 2.0)
    };
    (0..frames).map(|_| Pose { x_mm: draw(0.1), tilt_mrad: draw(0.3), ..Pose::default() }).collect()
}

struct SimulatedFrames<'a> {
    renderer: &'a Renderer,
    camera: Camera,
    shown: Shown,
    stops: Vec<(f64, f64)>,
    next: usize,
    frame_id: &'a mut u64,
    clock_ns: &'a mut u64,
    seed: u64,
    spare: Option<Frame>,
}

impl FrameSource for SimulatedFrames<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Some(&(z_mm, angle_deg)) = self.stops.get(self.next) else { return Ok(None) };
        let failed = |e: RenderError, frame_id: u64| SourceError {
            what: format!("frame {frame_id} (z = {z_mm} mm, {angle_deg}°) was not rendered"),
            cause: Some(Box::new(e)),
        };
        let stop = self.shown.stop(self.next, (z_mm, angle_deg)).map_err(|e| failed(e, *self.frame_id))?;
        let camera = &self.camera;
        let windows = camera.windows.map(|w| w.rois(camera.columns));
        let request = FrameRequest {
            frame_id: *self.frame_id,
            t_ns: *self.clock_ns,
            z_mm: stop.z_mm,
            angle_deg: stop.angle_deg,
            noise: true,
            roi: windows.map(|w| w[0]),
            second_roi: windows.map(|w| w[1]),
            format: None,
            seed: self.seed,
        };
        let frame = self.renderer.render(stop.scene, &request, self.spare.take());
        let mut frame = frame.map_err(|e| failed(e, request.frame_id))?;
        (frame.meta.z_mm, frame.meta.angle_deg) = (z_mm, angle_deg);
        self.next += 1;
        *self.frame_id += 1;
        *self.clock_ns += (self.camera.period_ms() * 1e6) as u64;
        Ok(Some(frame))
    }

    fn remaining(&self) -> Option<usize> {
        Some(self.stops.len() - self.next)
    }

    fn recycle(&mut self, frame: Frame) {
        self.spare = Some(frame);
    }
}
