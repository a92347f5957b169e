//! The turning cell: cuts a pass, shows the part to the camera. The simulated one joins process and render.

mod in_process;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use thiserror::Error;

mod touch;

use crate::control::{PartAndTool, PartEvent};
use crate::frame::{Frame, FrameSource, SourceError};
use crate::job::{Job, MasterPin};
use crate::plan::{DiameterOffset, FollowPlan, PassPlan, ScanPlan};
use crate::probe::{Touch, TouchOrder};
use crate::process::bending::sum_of_lines;
use crate::process::{BaseForm, CutSummary, ProcessError, Stock, TurningProcess};
use crate::render::form::form_shaft;
use crate::render::{FrameRequest, OpticalBench, RenderError, Renderer, Scene};
use crate::shaft::{AxisKnot, Pose, ProfileKnot, Shaft};
use crate::truth;
use touch::TrueProbe;

/// A cell that cannot do what it was told.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CellError {
    /// The pass cannot be cut.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// The part cannot be shown.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The cell does not change parts.
    #[error("this cell turns one part only")]
    OnePart,
    /// The cell has no probe.
    #[error("this cell has no touch probe")]
    NoProbe,
    /// The cell has no gauge that follows the tool.
    #[error("this cell cannot be looked at while it cuts: scan.when must be after_pass")]
    NotFollowed,
}

/// A pass under way, seen by the gauge behind the tool: frames, and the command of what is still to be cut.
pub trait FollowedCut: FrameSource {
    /// Machine z of the tool when the last frame was taken, mm.
    fn tool_z_mm(&self) -> f64;

    /// The clock that frames are stamped with, ns; `None` where the cell has none.
    fn now_ns(&self) -> Option<u64> {
        None
    }

    /// Changes the offsets of stations that the tool has not reached; what is cut stays cut.
    ///
    /// # Errors
    /// Where the machine refuses.
    fn command(&mut self, offset: &DiameterOffset) -> Result<(), CellError>;

    /// Lets the tool finish the pass.
    ///
    /// # Errors
    /// Where the machine refuses; the workpiece is then as before.
    fn finish(self: Box<Self>) -> Result<(), CellError>;
}

/// The axis of a part for comparison only, as it was when it was looked at (tool clear, or bent by the force while it was cut): what
/// stands still and what turns with it, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueAxis {
    /// In the machine's frame.
    pub still: Vec<AxisKnot>,
    /// In the body's frame: bow and eccentricity.
    pub turning: Vec<AxisKnot>,
}

/// A lathe with a gauge on its carriage, real or simulated.
pub trait TurningCell {
    /// Cuts a pass.
    ///
    /// # Errors
    /// Where the machine refuses; the workpiece is then as before.
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError>;

    /// Frames of the part as it now is, field after field, angle after angle, tool clear.
    ///
    /// # Errors
    /// Where no frame can be taken at all.
    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError>;

    /// Frames of master pin `index` of the job.
    ///
    /// # Errors
    /// Where no frame can be taken at all.
    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError>;

    /// Touches of the part as it now is, or of master pin `master` of the job, in the order asked for, spindle still.
    ///
    /// # Errors
    /// Where the cell has no probe.
    fn touch(&mut self, _master: Option<usize>, _orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        Err(CellError::NoProbe)
    }

    /// Cuts a pass while the gauge follows the tool; [`FollowedCut::finish`] ends it.
    ///
    /// # Errors
    /// Where the machine refuses, or has no such gauge.
    fn cut_followed(
        &mut self,
        _plan: &PassPlan,
        _follow: &FollowPlan,
    ) -> Result<Box<dyn FollowedCut + '_>, CellError> {
        Err(CellError::NotFollowed)
    }

    /// Forces and deflections of the pass cut last, where the cell has them. For reports only.
    fn last_cut(&self) -> Option<CutSummary> {
        None
    }

    /// The part's axis as the last pass was looked at; `None` where nobody knows. For comparison only.
    fn true_axis(&self) -> Option<TrueAxis> {
        None
    }

    /// Clamps the next blank of a batch; `part` counts from 0, the one the cell began with.
    ///
    /// # Errors
    /// Where the cell has no other blank.
    fn next_part(&mut self, _part: u64, _event: PartEvent) -> Result<(), CellError> {
        Err(CellError::OnePart)
    }

    /// Part and tool that are in the machine; `None` where the cell cannot tell.
    fn in_machine(&self) -> Option<PartAndTool> {
        None
    }

    /// The clock that frames are stamped with, ns; `None` where the cell has none.
    fn now_ns(&self) -> Option<u64> {
        None
    }

    /// True mean caliper diameter of stations (z from, z to), mm; `None` where nobody knows. For comparison only.
    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>>;
}

/// Process and renderer in place of a lathe and a camera.
pub struct SimulatedCell<'a> {
    renderer: &'a Renderer,
    bench: OpticalBench,
    process: TurningProcess,
    /// The part at 20 °C.
    part: Shaft,
    /// `[shaft.deflection]`: what bends the axis besides the process.
    deflection: Vec<AxisKnot>,
    masters_mm: Vec<f64>,
    seed: u64,
    frame_id: u64,
    master_frame_id: u64,
    clock_ns: u64,
    /// Pass cut last; 0 before the first.
    pass: u32,
    stock: Stock,
    batch: Batch,
    probe: Option<TrueProbe>,
    /// Bursts of a pass that was looked at while it was cut.
    followed: Vec<in_process::SeenBurst>,
}

/// What is filmed: the two count their frames apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Film {
    Part,
    Master,
}

/// Which part of a batch, cut by which insert.
#[derive(Clone, Debug, Default)]
struct Batch {
    name: String,
    first_seed: u64,
    part: u64,
    insert: u32,
}

/// Streams of the job's seed, one a purpose, so that no purpose shifts another's draws.
const MASTER_STREAM: u64 = 0x6d61_7374_6572;
const PROCESS_STREAM: u64 = 0x0070_726f_6365_7373;
/// Passes that a part may have: ids and clock of the next part start beyond them.
const PASSES_OF_A_PART: u64 = 1024;
/// Frame ids of pass k start at k·2³²: noise does not depend on how many frames an earlier pass took.
const FRAMES_OF_A_PASS: u64 = 1 << 32;
/// The scan of pass k starts k times this after the clock's zero: about what cutting and scanning a pass takes, and
/// independent of whether an earlier pass was scanned by this process.
const PASS_PERIOD_NS: u64 = 600_000_000_000;

/// The stock with the form that `[shaft]` gives it.
fn formed(job: &Job) -> Result<Shaft, RenderError> {
    let blank = vec![ProfileKnot { z_mm: 0.0, radius_mm: job.part.stock_diameter_mm / 2.0 }];
    form_shaft(blank, &job.shaft, job.part.length_mm, job.seed)
}

fn base_form_of(formed: &Shaft) -> BaseForm {
    BaseForm {
        lobes: formed.lobes.clone(),
        eccentricity: formed.eccentricity,
        bow: formed.bow.clone(),
        pose: formed.pose,
    }
}

/// What of a job's `[shaft]` stays with the part through all passes.
///
/// # Errors
/// Where the shaft is refused.
pub fn base_form(job: &Job) -> Result<BaseForm, RenderError> {
    Ok(base_form_of(&formed(job)?))
}

impl<'a> SimulatedCell<'a> {
    /// A cell with the stock clamped and the true bench drawn from the job's seed.
    ///
    /// # Errors
    /// Where a stage refuses its settings.
    pub fn new(job: &Job, renderer: &'a Renderer) -> Result<Self, CellError> {
        let bench = OpticalBench::resolve(&job.bench_settings(), job.seed)?;
        let stock = Stock { diameter_mm: job.part.stock_diameter_mm, length_mm: job.part.length_mm };
        let formed = formed(job)?;
        let form = base_form_of(&formed);
        let process = TurningProcess::new(&job.process, stock, &form, job.seed ^ PROCESS_STREAM)?;
        let blank = process.blank();
        let deflection = sum_of_lines(&formed.deflection, &blank.deflection);
        let part = Shaft { deflection, spindle: formed.spindle, ..blank };
        Ok(Self {
            renderer,
            bench,
            process,
            part,
            deflection: formed.deflection,
            masters_mm: true_masters_mm(&job.masters.pins, job.seed),
            seed: job.seed,
            frame_id: 0,
            master_frame_id: 0,
            clock_ns: 0,
            pass: 0,
            stock,
            probe: job.probe.as_ref().map(|probe| {
                TrueProbe::new(probe, &job.process.disturbance.guideway, job.part.length_mm, job.seed)
            }),
            followed: Vec::new(),
            batch: Batch { name: job.name.clone(), first_seed: job.seed, ..Batch::default() },
        })
    }
}

impl TurningCell for SimulatedCell<'_> {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        let cut = self.process.cut(plan)?;
        self.part = self.clamped(cut);
        self.begin_pass(plan.pass);
        Ok(())
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let scene = Scene::new(&self.bench, self.process.as_scanned(&self.part))?;
        let stops =
            plan.field_z_mm.iter().flat_map(|&z| plan.angle_deg.iter().map(move |&a| (z, a))).collect();
        Ok(self.film(vec![scene], stops, Film::Part))
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let diameter_mm = self.masters_mm[index];
        // the calibration's pins lie as the seed says; a pin looked at again after a pass lies elsewhere
        let again = u64::from(self.pass) << 40;
        let poses = hand_poses(frames, self.seed ^ MASTER_STREAM ^ ((index as u64 + 1) << 48) ^ again);
        let scenes: Result<Vec<Scene>, RenderError> = poses
            .into_iter()
            .map(|pose| {
                Scene::new(&self.bench, Shaft { pose, ..Shaft::cylinder(diameter_mm) }).map(Scene::wiped)
            })
            .collect();
        self.master_frame_id = self.first_frame_id() + (1 << 31) + ((index as u64) << 24);
        let stops = (0..frames).map(|_| (0.0, 0.0)).collect();
        Ok(self.film(scenes?, stops, Film::Master))
    }

    fn touch(&mut self, master: Option<usize>, orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        self.touches(master, orders)
    }

    fn cut_followed(
        &mut self,
        plan: &PassPlan,
        follow: &FollowPlan,
    ) -> Result<Box<dyn FollowedCut + '_>, CellError> {
        Ok(Box::new(in_process::SimulatedCut::begin(self, plan, follow)?))
    }

    fn last_cut(&self) -> Option<CutSummary> {
        self.process.last_cut().cloned()
    }

    fn true_axis(&self) -> Option<TrueAxis> {
        let shaft = &self.part;
        let (sin, cos) = shaft.eccentricity.phase_deg.to_radians().sin_cos();
        let offset = shaft.eccentricity.amplitude_mm;
        let whole = [AxisKnot { z_mm: 0.0, x_mm: offset * cos, y_mm: offset * sin }];
        Some(TrueAxis {
            still: in_process::axis_seen(&self.followed, &shaft.deflection, self.stock.length_mm),
            turning: sum_of_lines(&whole[..usize::from(offset != 0.0)], &shaft.bow),
        })
    }

    fn next_part(&mut self, part: u64, event: PartEvent) -> Result<(), CellError> {
        match event {
            PartEvent::Continued => {}
            PartEvent::InsertChanged => {
                self.process.change_insert();
                self.batch.insert += 1;
            }
            PartEvent::ColdStart => self.process.cool_down(),
        }
        self.batch.part = part;
        self.seed = self.batch.first_seed + part;
        self.process = self.process.next_blank(self.stock, self.seed ^ PROCESS_STREAM)?;
        self.part = self.clamped(self.process.blank());
        self.begin_pass(0);
        Ok(())
    }

    fn in_machine(&self) -> Option<PartAndTool> {
        let Batch { name, part, insert, .. } = &self.batch;
        Some(PartAndTool {
            part: format!("{name}, part {}", part + 1),
            tool: format!("T1, insert {}", insert + 1),
        })
    }

    fn now_ns(&self) -> Option<u64> {
        Some(self.clock_ns)
    }

    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        truth::station_diameters_mm(&self.part, stations_mm).ok()
    }
}

impl SimulatedCell<'_> {
    /// A workpiece in this machine: sag and spindle belong to it, not to the part.
    fn clamped(&self, part: Shaft) -> Shaft {
        let deflection = sum_of_lines(&self.deflection, &part.deflection);
        Shaft { deflection, spindle: self.part.spindle.clone(), ..part }
    }

    fn first_frame_id(&self) -> u64 {
        (self.batch.part * PASSES_OF_A_PART + u64::from(self.pass)) * FRAMES_OF_A_PASS
    }

    fn begin_pass(&mut self, pass: u32) {
        self.followed.clear();
        self.pass = pass;
        self.frame_id = self.first_frame_id();
        self.clock_ns = (self.batch.part * PASSES_OF_A_PART + u64::from(pass)) * PASS_PERIOD_NS;
    }

    /// One scene for all stops, or one a stop.
    fn film(&mut self, scenes: Vec<Scene>, stops: Vec<(f64, f64)>, film: Film) -> Box<dyn FrameSource + '_> {
        Box::new(SimulatedFrames {
            renderer: self.renderer,
            scenes,
            stops,
            next: 0,
            frame_id: match film {
                Film::Part => &mut self.frame_id,
                Film::Master => &mut self.master_frame_id,
            },
            clock_ns: &mut self.clock_ns,
            seed: self.seed,
            spare: None,
        })
    }
}

/// True diameters of the masters: drawn from what their certificates say.
fn true_masters_mm(pins: &[MasterPin], seed: u64) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(seed ^ MASTER_STREAM);
    pins.iter()
        .map(|pin| {
            let draw: f64 = StandardNormal.sample(&mut random);
            pin.diameter_mm + draw * pin.expanded_u_mm / pin.coverage_factor
        })
        .collect()
}

/// A pin laid in by hand: a little off the axis and a little oblique each time.
fn hand_poses(frames: usize, seed: u64) -> Vec<Pose> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut draw = |size: f64| {
        let z: f64 = StandardNormal.sample(&mut random);
        size * z.clamp(-2.0, 2.0)
    };
    (0..frames).map(|_| Pose { x_mm: draw(0.1), tilt_mrad: draw(0.3), ..Pose::default() }).collect()
}

struct SimulatedFrames<'a> {
    renderer: &'a Renderer,
    scenes: Vec<Scene>,
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
        let scene = &self.scenes[self.next.min(self.scenes.len() - 1)];
        let camera = &scene.bench().nominal.camera;
        let windows = camera.windows.map(|w| w.rois(camera.columns));
        let request = FrameRequest {
            frame_id: *self.frame_id,
            t_ns: *self.clock_ns,
            z_mm,
            angle_deg,
            noise: true,
            roi: windows.map(|w| w[0]),
            second_roi: windows.map(|w| w[1]),
            format: None,
            seed: self.seed,
        };
        let frame = self.renderer.render(scene, &request, self.spare.take()).map_err(|e| SourceError {
            what: format!("frame {} (z = {z_mm} mm, {angle_deg}°) was not rendered", request.frame_id),
            cause: Some(Box::new(e)),
        })?;
        self.next += 1;
        *self.frame_id += 1;
        *self.clock_ns += (scene.bench().nominal.camera.period_ms() * 1e6) as u64;
        Ok(Some(frame))
    }

    fn remaining(&self) -> Option<usize> {
        Some(self.stops.len() - self.next)
    }

    fn recycle(&mut self, frame: Frame) {
        self.spare = Some(frame);
    }
}
