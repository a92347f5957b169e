//! A rendered optical setup in place of a recorded one. Its true values (scale, blur, gain,
//! telecentricity, the masters' true diameters and temperature) are drawn from the uncertainties in
//! the plan, and affect the calibration through the frames alone.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::error::CalibrateError;
use super::plan::{CalibrationPlan, PinPlan, Position, SimulatedPlan};
use super::recordings::Recordings;
use crate::frame::{Buffer, Frame, PixelFormat, Roi};
use crate::gauge::MasterCertificate;
use crate::gauge::calibration::{LensLimits, Thermometer};
use crate::render::optics::lens::Distortion;
use crate::render::settings::Sensor;
use crate::render::{FrameRequest, OpticalSetup, RenderError, Renderer, Scene};
use crate::shaft::{AxisKnot, Pose, Shaft};

/// Stream of the true values, apart from the optical setup's own.
const TRUTH_STREAM: u64 = 0x0063_616c_6962;

/// Stream of the lens' true distortion.
const LENS_STREAM: u64 = 0x6c65_6e73;

/// A shaft placed in a simulated optical setup.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Laid {
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

/// The true optical setup.
pub(crate) struct SimulatedSetup<'a> {
    renderer: &'a Renderer,
    setup: OpticalSetup,
    /// True telecentricity error, 1/mm.
    pub telecentricity_per_mm: f64,
    seed: u64,
    frame_id: u64,
}

impl<'a> SimulatedSetup<'a> {
    /// An optical setup with this telecentricity error.
    pub(crate) fn new(
        renderer: &'a Renderer,
        setup: OpticalSetup,
        telecentricity_per_mm: f64,
        seed: u64,
    ) -> Self {
        Self { renderer, setup, telecentricity_per_mm, seed, frame_id: 0 }
    }

    /// The true optical setup.
    pub(crate) fn setup(&self) -> &OpticalSetup {
        &self.setup
    }

    /// A frame of a shaft. Inclined chief rays magnify nearer bodies: the body is scaled by 1 +
    /// t·y, and blurred out of the plane.
    ///
    /// # Errors
    /// Where the shaft cannot be drawn.
    pub(crate) fn frame(&mut self, laid: &Laid) -> Result<Frame, RenderError> {
        self.numbered(laid, self.frame_id, true).inspect(|_| self.frame_id += 1)
    }

    /// Frame number `frame_id` of a shaft, with or without the sensor's temporal noise.
    ///
    /// # Errors
    /// As [`Self::frame`].
    pub(crate) fn numbered(&self, laid: &Laid, frame_id: u64, noise: bool) -> Result<Frame, RenderError> {
        let request = FrameRequest { angle_deg: laid.angle_deg, noise, ..self.request(frame_id) };
        self.renderer.render(&self.scene(laid)?, &request, None)
    }

    /// The scene of a shaft in the optical setup.
    ///
    /// # Errors
    /// As [`Self::frame`].
    pub(crate) fn scene(&self, laid: &Laid) -> Result<Scene, RenderError> {
        let growth = (1.0 + laid.expansion_per_k * (laid.temperature_c - 20.0))
            * (1.0 + self.telecentricity_per_mm * laid.y_mm);
        let mut shaft = laid.shaft.clone();
        shaft.profile.iter_mut().for_each(|k| k.radius_mm *= growth);
        shaft.lobes.iter_mut().for_each(|l| l.amplitude_mm *= growth);
        shaft.pose = Pose { x_mm: laid.height_mm, tilt_mrad: laid.tilt_mrad, ..Pose::default() };
        if laid.y_mm != 0.0 {
            shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm: laid.y_mm }];
        }
        Scene::new(&self.setup, shaft)
    }

    /// A frame without a part at a share of the light, 0 for a dark one.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub(crate) fn flat(&mut self, share: f64) -> Result<Frame, RenderError> {
        let (rows, columns) = (self.setup.rows() as u32, self.setup.columns() as u32);
        let whole = Roi { row: 0, column: 0, rows, columns };
        self.flat_window(share, self.frame_id, whole, None).inspect(|_| self.frame_id += 1)
    }

    /// A window of frame number `frame_id` without a part at a share of the light, in the sensor's
    /// format or another one. Each half of the field is from a scene whose part is in the other
    /// half: light, contamination and sensor are those of any other frame.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub(crate) fn flat_window(
        &self,
        share: f64,
        frame_id: u64,
        window: Roi,
        format: Option<PixelFormat>,
    ) -> Result<Frame, RenderError> {
        let setup = self.at_share(share);
        let (rows, field_mm) = (setup.rows() as u32, setup.rows() as f64 * setup.pixel_mm);
        let half = |upper: bool| {
            let (from, to) = if upper { (0, rows / 2) } else { (rows / 2, rows) };
            let (row, end) = (window.row.max(from), (window.row + window.rows).min(to));
            if row >= end {
                return Ok(None);
            }
            let mut thin = Shaft::cylinder(0.02 * field_mm);
            thin.pose = Pose { x_mm: if upper { -0.25 } else { 0.25 } * field_mm, ..Pose::default() };
            let roi = Some(Roi { row, rows: end - row, ..window });
            let request = FrameRequest { roi, format, ..self.request(frame_id) };
            self.renderer.render(&Scene::new(&setup, thin)?, &request, None).map(Some)
        };
        match (half(true)?, half(false)?) {
            (Some(above), Some(below)) => joined(above, below),
            (Some(one), None) | (None, Some(one)) => Ok(one),
            (None, None) => Err(RenderError::Field { what: "the window has no row".to_owned() }),
        }
    }

    /// The optical setup at a share of its light.
    fn at_share(&self, share: f64) -> OpticalSetup {
        let mut setup = self.setup.clone();
        let Sensor { black_level_counts: black, .. } = setup.nominal.sensor;
        let light = &mut setup.nominal.light;
        let bright = light.bright_in(&setup.nominal.sensor, setup.electrons_per_count);
        light.bright_counts = black + share * (bright - black);
        light.shadow_counts = black + share * (light.shadow_counts - black);
        light.bright_photons = None;
        setup
    }

    fn request(&self, frame_id: u64) -> FrameRequest {
        FrameRequest {
            frame_id,
            t_ns: frame_id * 28_000_000,
            noise: true,
            seed: self.seed,
            ..FrameRequest::default()
        }
    }
}

/// The rows of two frames, one above the other.
fn joined(above: Frame, below: Frame) -> Result<Frame, RenderError> {
    let (meta, format) = (above.meta.clone(), above.view().format());
    let (rows, columns) = (above.view().rows() + below.view().rows(), above.view().columns());
    let whole = match (above.into_buffer(), below.into_buffer()) {
        (Buffer::U8(a), Buffer::U8(b)) => Buffer::U8([a, b].concat()),
        (Buffer::U16(a), Buffer::U16(b)) => Buffer::U16([a, b].concat()),
        (Buffer::F32(a), Buffer::F32(b)) => Buffer::F32([a, b].concat()),
        // Both come from one renderer and have the same format.
        (a, _) => a,
    };
    Frame::new(whole, format, rows, columns, meta).map_err(|e| RenderError::Field { what: e.to_string() })
}

/// Random draws of true values from their estimates and uncertainties.
pub(crate) struct Draws(Pcg64);

impl Draws {
    /// Draws of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed ^ TRUTH_STREAM))
    }

    /// A standard normal draw.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A draw from −1 to 1.
    pub(crate) fn even(&mut self) -> f64 {
        Uniform::new_inclusive(-1.0, 1.0).map_or(0.0, |d| d.sample(&mut self.0))
    }

    /// A true diameter, given its certificate.
    pub(crate) fn certified(&mut self, certificate: &MasterCertificate) -> f64 {
        certificate.diameter_mm + certificate.u_mm() * self.normal()
    }

    /// True temperature and expansion, given a thermometer's reading.
    pub(crate) fn thermal(&mut self, t: &Thermometer) -> (f64, f64) {
        let temperature = t.temperature_c + t.limit_temperature_k * self.even();
        (temperature, 1e-6 * (t.expansion_um_per_m_k + t.limit_expansion_um_per_m_k * self.even()))
    }
}

/// Distortion within the limits of the data sheet. The gauge's correction a·r², q·v²/ρ, g·u·v/ρ is,
/// to first order, the negative of Brown's k1, 3·p1, 2·p2.
fn distort(distortion: &mut Distortion, limits: &LensLimits, seed: u64) {
    let mut draws = Draws::new(seed ^ LENS_STREAM);
    distortion.k1 -= 1e-2 * limits.distortion_percent * draws.even();
    distortion.p1 -= 1e-2 * limits.keystone_percent * draws.even() / 3.0;
    distortion.p2 -= 1e-2 * limits.keystone_percent * draws.even() / 2.0;
}

impl SimulatedPlan {
    /// The true optical setup: the common source for `calibrate`, `render` and the studies. The
    /// lens' distortion and telecentricity lie within the data sheet's limits about the config's,
    /// unless the config itself is the truth.
    ///
    /// # Errors
    /// An optical setup that is refused.
    fn true_setup(&self, lens: &LensLimits, draws: &mut Draws) -> Result<OpticalSetup, RenderError> {
        let mut settings = self.setup();
        if self.lens_as_configured {
            return OpticalSetup::resolve(&settings, self.seed);
        }
        distort(&mut settings.optics.distortion, lens, self.seed);
        let even = draws.even();
        if settings.optics.entocentric.is_none() {
            let angle_mrad = 1e3 * (lens.telecentricity_deg.to_radians().tan() * even).atan();
            settings.optics.telecentricity_mrad += angle_mrad;
        }
        OpticalSetup::resolve(&settings, self.seed)
    }
}

/// Poses of a pin at one of its positions, frame by frame, with the frames' numbers.
struct Lying {
    pin: usize,
    position: Position,
    frames: Vec<(Laid, u64)>,
}

/// Frames of a plan's pins on a simulated optical setup: recorded once, however often they are
/// requested.
pub(crate) struct SimulatedRecordings<'a> {
    setup: SimulatedSetup<'a>,
    simulate: SimulatedPlan,
    draws: Draws,
    true_mm: Vec<f64>,
    thermal: (f64, f64),
    lying: Vec<Lying>,
}

impl<'a> SimulatedRecordings<'a> {
    /// The optical setup of a plan that has a `[simulate]` table.
    ///
    /// # Errors
    /// An optical setup that is refused.
    pub(crate) fn new(plan: &CalibrationPlan, renderer: &'a Renderer) -> Result<Self, CalibrateError> {
        let plan = &plan.settled();
        let simulate = plan.simulate.clone().unwrap_or_default();
        let mut draws = Draws::new(simulate.seed);
        let setup = simulate.true_setup(&plan.lens, &mut draws)?;
        let thermal = draws.thermal(&plan.thermometer);
        let pins = plan.masters.iter().chain(&plan.check);
        let true_mm = pins.map(|p| draws.certified(&p.certificate())).collect();
        let setup = SimulatedSetup::new(renderer, setup, 0.0, simulate.seed);
        Ok(Self { setup, simulate, draws, true_mm, thermal, lying: Vec::new() })
    }

    /// The optical setup, for measurements.
    pub(crate) fn into_setup(self) -> SimulatedSetup<'a> {
        self.setup
    }

    /// The optical setup.
    pub(crate) fn setup(&self) -> &SimulatedSetup<'a> {
        &self.setup
    }

    /// Poses of pin `index` (masters first, then the check pin) at a position, with the numbers of
    /// its frames.
    pub(crate) fn laid(&mut self, index: usize, position: &Position) -> Vec<(Laid, u64)> {
        if let Some(known) = self.lying.iter().find(|l| l.pin == index && l.position == *position) {
            return known.frames.clone();
        }
        let SimulatedPlan { frames_each, limit_height_mm, limit_tilt_mrad, .. } = self.simulate;
        let mut frames = Vec::new();
        for _ in 0..frames_each {
            // Inserted by hand: slightly oblique each time.
            let laid = Laid {
                shaft: Shaft::cylinder(self.true_mm[index]),
                temperature_c: self.thermal.0,
                expansion_per_k: self.thermal.1,
                height_mm: position.height_mm + limit_height_mm * self.draws.even(),
                y_mm: position.y_mm,
                tilt_mrad: limit_tilt_mrad * self.draws.even(),
                angle_deg: 0.0,
            };
            frames.push((laid, self.setup.frame_id));
            self.setup.frame_id += 1;
        }
        self.lying.push(Lying { pin: index, position: position.clone(), frames: frames.clone() });
        frames
    }
}

impl Recordings for SimulatedRecordings<'_> {
    fn pin(&mut self, index: usize, _: &PinPlan, position: &Position) -> Result<Vec<Frame>, CalibrateError> {
        let laid = self.laid(index, position);
        laid.iter().map(|(laid, number)| Ok(self.setup.numbered(laid, *number, true)?)).collect()
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        if plan.fields.flats.is_empty() {
            return Ok(Vec::new());
        }
        (0..self.simulate.frames_each.max(2)).map(|_| Ok(self.setup.flat(0.0)?)).collect()
    }

    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        let most = plan.fields.flats.iter().map(|f| f.exposure).fold(0.0, f64::max);
        let share = plan.fields.flats[index].exposure / most.max(f64::MIN_POSITIVE);
        (0..self.simulate.frames_each.max(2)).map(|_| Ok(self.setup.flat(share)?)).collect()
    }
}
