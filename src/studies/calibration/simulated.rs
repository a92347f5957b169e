//! A bench rendered in place of a recorded one. What it really is (scale, blur, gain, telecentricity, the masters' true
//! diameters and temperature) is drawn from what the plan says is known of it, and only the frames show it.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::plan::{CalibrationPlan, PinPlan, Position};
use super::{CalibrateError, Recordings};
use crate::frame::Frame;
use crate::gauge::MasterCertificate;
use crate::gauge::bench::{LensLimits, LensModel, Thermometer};
use crate::render::lens::Distortion;
use crate::render::{FrameRequest, OpticalBench, RenderError, Renderer, Scene};
use crate::shaft::{AxisKnot, Pose, Shaft};

/// Stream of the true values, apart from the bench's own.
const TRUTH_STREAM: u64 = 0x0063_616c_6962;

/// Stream of the lens' true distortion.
const LENS_STREAM: u64 = 0x6c65_6e73;

/// A shaft laid before a simulated bench.
#[derive(Clone, Debug, PartialEq)]
pub struct Laid {
    /// Its form at 20 °C; pose and deflection are set here.
    pub shaft: Shaft,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Expansion, 1/K.
    pub expansion_per_k: f64,
    /// Height of the axis, mm.
    pub height_mm: f64,
    /// Distance from the masters' plane, mm.
    pub y_mm: f64,
    /// Tilt in the image plane, mrad.
    pub tilt_mrad: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
}

/// The bench as it is.
pub struct SimulatedBench<'a> {
    renderer: &'a Renderer,
    bench: OpticalBench,
    /// True telecentricity error, 1/mm.
    pub telecentricity_per_mm: f64,
    seed: u64,
    frame_id: u64,
}

impl<'a> SimulatedBench<'a> {
    /// A bench with this telecentricity error.
    pub fn new(renderer: &'a Renderer, bench: OpticalBench, telecentricity_per_mm: f64, seed: u64) -> Self {
        Self { renderer, bench, telecentricity_per_mm, seed, frame_id: 0 }
    }

    /// The true bench.
    pub fn bench(&self) -> &OpticalBench {
        &self.bench
    }

    /// A frame of a shaft. A chief ray at an angle magnifies what stands nearer: the body is scaled by 1 + t·y, and out of
    /// the plane it blurs.
    ///
    /// # Errors
    /// Where the shaft cannot be drawn.
    pub fn frame(&mut self, laid: &Laid) -> Result<Frame, RenderError> {
        let growth = (1.0 + laid.expansion_per_k * (laid.temperature_c - 20.0))
            * (1.0 + self.telecentricity_per_mm * laid.y_mm);
        let mut shaft = laid.shaft.clone();
        shaft.profile.iter_mut().for_each(|k| k.radius_mm *= growth);
        shaft.lobes.iter_mut().for_each(|l| l.amplitude_mm *= growth);
        shaft.pose = Pose { x_mm: laid.height_mm, tilt_mrad: laid.tilt_mrad, ..Pose::default() };
        if laid.y_mm != 0.0 {
            shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: laid.y_mm }];
        }
        self.take(&self.bench, shaft, laid.angle_deg).inspect(|_| self.frame_id += 1)
    }

    /// A frame without a part at a share of the light, 0 for a dark one.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub fn flat(&mut self, share: f64) -> Result<Frame, RenderError> {
        let mut bench = self.bench.clone();
        let black = bench.nominal.sensor.black_level_counts;
        let level = black + share * (bench.nominal.light.bright_counts - black);
        (bench.nominal.light.bright_counts, bench.nominal.light.shadow_counts) = (level, level);
        let any = Shaft::cylinder(0.2 * bench.rows() as f64 * bench.pixel_mm);
        self.take(&bench, any, 0.0).inspect(|_| self.frame_id += 1)
    }

    fn take(&self, bench: &OpticalBench, shaft: Shaft, angle_deg: f64) -> Result<Frame, RenderError> {
        let scene = Scene::new(bench, shaft)?;
        let request = FrameRequest {
            frame_id: self.frame_id,
            t_ns: self.frame_id * 28_000_000,
            angle_deg,
            noise: true,
            seed: self.seed,
            ..FrameRequest::default()
        };
        self.renderer.render(&scene, &request, None)
    }
}

/// A value drawn from what is known of it.
pub struct Draws(Pcg64);

impl Draws {
    /// Draws of a seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed ^ TRUTH_STREAM))
    }

    /// A standard normal draw.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A draw from −1 to 1.
    pub fn even(&mut self) -> f64 {
        Uniform::new_inclusive(-1.0, 1.0).map_or(0.0, |d| d.sample(&mut self.0))
    }

    /// A true diameter, given its certificate.
    pub fn certified(&mut self, certificate: &MasterCertificate) -> f64 {
        certificate.diameter_mm + certificate.u_mm() * self.normal()
    }

    /// True temperature and expansion, given a thermometer's reading.
    pub fn thermal(&mut self, t: &Thermometer) -> (f64, f64) {
        let temperature = t.temperature_c + t.limit_temperature_k * self.even();
        (temperature, 1e-6 * (t.expansion_um_per_m_k + t.limit_expansion_um_per_m_k * self.even()))
    }
}

/// Distortion within the limits of the data sheet. The gauge's correction a·r², q·v²/ρ, g·u·v/ρ is, to first order, the
/// negative of Brown's k1, 3·p1, 2·p2.
fn distort(distortion: &mut Distortion, limits: &LensLimits, seed: u64) {
    let mut draws = Draws::new(seed ^ LENS_STREAM);
    distortion.k1 -= 1e-2 * limits.distortion_percent * draws.even();
    distortion.p1 -= 1e-2 * limits.keystone_percent * draws.even() / 3.0;
    distortion.p2 -= 1e-2 * limits.keystone_percent * draws.even() / 2.0;
}

/// Frames of a plan's pins on a simulated bench.
pub struct SimulatedRecordings<'a> {
    bench: SimulatedBench<'a>,
    draws: Draws,
    frames_each: usize,
    true_mm: Vec<f64>,
    thermal: (f64, f64),
}

impl<'a> SimulatedRecordings<'a> {
    /// The bench of a plan that has a `[simulate]` table.
    ///
    /// # Errors
    /// A bench that cannot be.
    pub fn new(plan: &CalibrationPlan, renderer: &'a Renderer) -> Result<Self, CalibrateError> {
        let simulate = plan.simulate.clone().unwrap_or_default();
        let mut settings = simulate.bench();
        distort(&mut settings.optics.distortion, &plan.lens, simulate.seed);
        let bench = OpticalBench::resolve(&settings, simulate.seed)?;
        let mut draws = Draws::new(simulate.seed);
        let size = LensModel::perfect(bench.rows(), bench.columns());
        let limit = 3.0_f64.sqrt() * plan.lens.u_parameters(size.half_diagonal_px * bench.pixel_mm)[3];
        let telecentricity = limit * draws.even();
        let thermal = draws.thermal(&plan.thermometer);
        let pins = plan.masters.iter().chain(&plan.check);
        let true_mm = pins.map(|p| draws.certified(&p.certificate())).collect();
        Ok(Self {
            bench: SimulatedBench::new(renderer, bench, telecentricity, simulate.seed),
            draws,
            frames_each: simulate.frames_each,
            true_mm,
            thermal,
        })
    }

    /// The bench, to be measured with.
    pub fn into_bench(self) -> SimulatedBench<'a> {
        self.bench
    }
}

impl Recordings for SimulatedRecordings<'_> {
    fn pin(&mut self, index: usize, _: &PinPlan, position: &Position) -> Result<Vec<Frame>, CalibrateError> {
        let mut frames = Vec::new();
        for _ in 0..self.frames_each {
            // Laid in by hand: a little oblique each time.
            let laid = Laid {
                shaft: Shaft::cylinder(self.true_mm[index]),
                temperature_c: self.thermal.0,
                expansion_per_k: self.thermal.1,
                height_mm: position.height_mm + 0.02 * self.draws.even(),
                y_mm: position.y_mm,
                tilt_mrad: 0.3 * self.draws.even(),
                angle_deg: 0.0,
            };
            frames.push(self.bench.frame(&laid)?);
        }
        Ok(frames)
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        if plan.fields.flats.is_empty() {
            return Ok(Vec::new());
        }
        (0..self.frames_each.max(2)).map(|_| Ok(self.bench.flat(0.0)?)).collect()
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        let most = plan.fields.flats.iter().map(|f| f.exposure).fold(0.0, f64::max);
        let share = plan.fields.flats[index].exposure / most.max(f64::MIN_POSITIVE);
        (0..self.frames_each.max(2)).map(|_| Ok(self.bench.flat(share)?)).collect()
    }
}
