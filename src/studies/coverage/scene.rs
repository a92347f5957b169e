//! One scene of the coverage study: an optical setup is drawn, calibrated on drawn masters, and a
//! drawn part measured with it.

use crate::frame::{Frame, FrameMeta};
use crate::gauge::budget::{Contribution, Shape, Share, WidthReading};
use crate::gauge::calibration::{Conditions, Date, LensLimits, Thermometer};
use crate::gauge::{Calibration, EsfModel, EsfSamples, Gauge, GaugeSettings, StationAverager};
use crate::render::form::form_shaft;
use crate::render::optics::edge_spread::{EdgeSpread, PartiallyCoherentEdge};
use crate::render::settings::{Esf, GaussianEsf, SetupDeviations, SetupSettings};
use crate::render::{OpticalSetup, RenderError, Renderer};
use crate::shaft::{Lobe, ProfileKnot, Shaft, ShaftForm, TextureForm};
use crate::studies::calibration::{
    CalibrateError, CalibrationPlan, Draws, Fields, Laid, PinPlan, Position, Recordings, SimulatedPlan,
    SimulatedRecordings, SimulatedSetup, calibrate,
};
use crate::truth;

use super::class::Class;
use super::illumination::{OTHER_KIND, coherent};
use super::limb::{self, LimbPart};
use super::outcome::{Outcome, flag, outcome, refused};

/// Frames of the study, px.
const ROWS: u32 = 576;
const COLUMNS: u32 = 320;
/// Spindle angles over half a turn where form is sampled, and stations whose scatter is pooled.
const ANGLES: usize = 10;
const STATION_MM: f64 = 0.4;
const STATIONS: usize = 9;

/// Gaussian blur of the same width as the partially coherent light that replaces it in
/// [`Class::OtherLight`], px.
const OTHER_BLUR_PX: f64 = 1.26;

/// A user's allowance for edges imaged unlike the masters', ± µm per edge.
const DEVIATING_UM: f64 = 0.03;

/// The drawn values of a scene, before anything is rendered.
struct Drawn {
    plan: CalibrationPlan,
    conditions: Conditions,
    class: Class,
    /// Limit of the displacement of the edges, ± µm: the stated limit, or a part of it where the
    /// class uses the rest.
    finish_um: f64,
}

/// An edge as given to the gauge, for the nominal pixel.
fn samples(edge: &PartiallyCoherentEdge, simulate: &SimulatedPlan) -> Result<EsfSamples, RenderError> {
    samples_of(&edge.edge_spread()?, simulate)
}

/// A table as given to the gauge, for the nominal pixel.
fn samples_of(table: &EdgeSpread, simulate: &SimulatedPlan) -> Result<EsfSamples, RenderError> {
    let nominal = nominal(simulate);
    let pixel_um = 1e3 * OpticalSetup::resolve(&nominal, 0)?.pixel_mm;
    let distance_px: Vec<f64> = (-240..=240).map(|i| f64::from(i) / 20.0).collect();
    let light = distance_px.iter().map(|d| table.value(d * pixel_um)).collect();
    Ok(EsfSamples { distance_px, light })
}

/// A plan's optical setup as its data sheets state it.
fn nominal(simulate: &SimulatedPlan) -> SetupSettings {
    SetupSettings { departures: SetupDeviations::none(), ..simulate.setup() }
}

fn pin(name: &str, diameter_mm: f64, expanded_u_mm: f64, positions: &[Position]) -> PinPlan {
    PinPlan {
        name: name.to_owned(),
        diameter_mm,
        expanded_u_mm,
        coverage_factor: 2.0,
        certified_by: None,
        common_expanded_u_mm: None,
        positions: positions.to_vec(),
    }
}

/// A position of a pin.
fn laid(height_mm: f64, y_mm: f64) -> Position {
    Position { frames: None, height_mm, y_mm }
}

/// The settings of a class, from which its calibration is planned.
struct Setup {
    simulate: SimulatedPlan,
    /// Expanded uncertainty of a master, mm.
    u_certificate: f64,
    lens: LensLimits,
    gauge: GaugeSettings,
    positions: [Position; 3],
    thermometer: Thermometer,
    conditions: Conditions,
}

impl Setup {
    /// The settings common to all classes.
    fn usual(seed: u64, draws: &mut Draws) -> Self {
        let mut simulate = SimulatedPlan { seed, frames_each: 1, ..SimulatedPlan::default() };
        (simulate.camera.rows, simulate.camera.columns) = (ROWS, COLUMNS);
        simulate.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px: 1.3 + 0.6 * draws.even() });
        simulate.light.bright_counts = 2400.0 + 900.0 * draws.even();
        Self {
            simulate,
            u_certificate: 2e-4,
            lens: LensLimits { telecentricity_deg: 0.02, distortion_percent: 0.0, keystone_percent: 0.0 },
            gauge: GaugeSettings::default(),
            positions: [(-0.3, -3.0), (0.0, 0.0), (0.3, 3.0)].map(|(height_mm, y_mm)| laid(height_mm, y_mm)),
            thermometer: Thermometer {
                temperature_c: 20.5,
                limit_temperature_k: 0.1,
                limit_expansion_um_per_m_k: 0.5,
                ..Thermometer::default()
            },
            conditions: Conditions {
                temperature_c: 21.0,
                limit_temperature_k: 0.1,
                limit_expansion_um_per_m_k: 0.5,
                limit_axis_y_mm: 0.2,
                limit_edge_um: 0.05,
                limit_drift_ppm: 2.0,
                ..Conditions::default()
            },
        }
    }

    /// The settings of a class: the source that it is named after dominates the budget.
    fn of_class(class: Class, seed: u64, draws: &mut Draws) -> Result<Self, RenderError> {
        let mut setup = Self::usual(seed, draws);
        let Self { simulate, u_certificate, lens, thermometer, conditions, .. } = &mut setup;
        match class {
            Class::Certificates => *u_certificate = 2e-3,
            Class::Noise | Class::LowContrast => {
                simulate.light.bright_counts = 420.0 + 80.0 * draws.even();
                simulate.sensor.read_noise_e = 12.0;
                simulate.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px: 2.0 + 0.6 * draws.even() });
            }
            Class::Temperature => {
                thermometer.limit_temperature_k = 2.0;
                conditions.temperature_c = 26.0;
                conditions.limit_temperature_k = 3.0;
                conditions.limit_expansion_um_per_m_k = 2.0;
            }
            Class::Focus => conditions.limit_axis_y_mm = 3.0,
            Class::Finish => conditions.limit_edge_um = 1.0,
            Class::Lens => {
                lens.distortion_percent = 0.1;
                lens.keystone_percent = 0.1;
            }
            Class::Mixed => {
                lens.distortion_percent = 0.02;
                lens.keystone_percent = 0.01;
                *u_certificate = 4e-4;
                conditions.limit_temperature_k = 1.5;
                conditions.limit_axis_y_mm = 1.0;
                conditions.limit_edge_um = 0.15;
            }
            Class::Diffraction => setup.in_coherent_light(false, draws)?,
            Class::GivenEsf => setup.in_coherent_light(true, draws)?,
            Class::Gradient => {
                simulate.light.field.gradient_down = 0.05 * draws.even();
                simulate.light.field.gradient_along = 0.1 * draws.even();
            }
            Class::Defocus => conditions.limit_axis_y_mm = 2.0,
            Class::LimbNarrow | Class::LimbWide => setup.before_limbs(class)?,
            Class::OtherLight => {
                simulate.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px: OTHER_BLUR_PX });
                setup.in_focus();
            }
            Class::Form
            | Class::Tilt
            | Class::Lobes
            | Class::Vibration
            | Class::LossOfFocus
            | Class::WarmPart
            | Class::OtherFinish
            | Class::Overexposed
            | Class::Clipped => {}
        }
        Ok(setup)
    }

    /// Partially coherent light, with its edge given to the gauge or not.
    fn in_coherent_light(&mut self, given: bool, draws: &mut Draws) -> Result<(), RenderError> {
        self.simulate.optics.esf = Esf::PartiallyCoherent(coherent(given, (2.0 * draws.even()).round()));
        // Out of the plane the rings change; in focus one set of tables serves every scene.
        self.in_focus();
        if given {
            self.gauge.esf = EsfModel::Table(samples(&coherent(true, 0.0), &self.simulate)?);
        }
        Ok(())
    }

    /// Round masters of steel in focus, parts of which only the limits of the limb's rows are
    /// known; the gauge fits the edge of these optics before a part of the middle diameter.
    fn before_limbs(&mut self, class: Class) -> Result<(), RenderError> {
        let ratio = class.coherence_of_limbs();
        let light = limb::light(ratio);
        let in_focus = light.edge_spread(0.25 * (limb::MASTERS_MM[0] + limb::MASTERS_MM[1]), 0.0)?;
        self.simulate.optics.esf = Esf::Cylinder(light);
        self.in_focus();
        self.lens.telecentricity_deg = 0.0;
        self.gauge.esf = EsfModel::Table(samples_of(&in_focus, &self.simulate)?);
        self.conditions.limit_edge_um = 0.0;
        self.conditions.limit_axis_y_mm = limb::LIMIT_DEPTH_MM;
        self.conditions.limb = Some(limb::difference(ratio, &nominal(&self.simulate), &self.gauge)?);
        Ok(())
    }

    /// Masters and part in the plane of best focus, with the planned blur.
    fn in_focus(&mut self) {
        self.simulate.departures.blur_rel = 0.0;
        for position in &mut self.positions {
            position.y_mm = 0.0;
        }
        self.conditions.limit_axis_y_mm = 0.0;
    }
}

/// A scene of a class: its calibration, and the conditions of its part.
fn draw(class: Class, seed: u64, draws: &mut Draws) -> Result<Drawn, RenderError> {
    let Setup { simulate, u_certificate, lens, gauge, positions, thermometer, conditions } =
        Setup::of_class(class, seed, draws)?;
    let mut plan = CalibrationPlan {
        channel: None,
        source: None,
        frames_each: None,
        optics_id: "coverage".to_owned(),
        date: "2026-01-01".parse().unwrap_or_else(|_| Date::of(std::time::SystemTime::UNIX_EPOCH)),
        valid_days: 365,
        lens,
        thermometer,
        conditions,
        fields: Fields::default(),
        masters: [("small", limb::MASTERS_MM[0]), ("large", limb::MASTERS_MM[1])]
            .map(|(name, mm)| pin(name, mm, u_certificate, &positions))
            .to_vec(),
        check: None,
        gauge,
        simulate: Some(simulate),
    };
    let finish_um = conditions.limit_edge_um;
    if Class::DEVIATING.contains(&class) {
        // Edge-spread function, light and tilt displace edges as well: the user's limit allows for
        // them.
        plan.conditions.limit_edge_um += DEVIATING_UM;
    }
    Ok(Drawn { conditions: plan.conditions, plan, class, finish_um })
}

/// A scene before anything of it is rendered: its setup and its part, by the seed alone.
struct Planned {
    drawn: Drawn,
    /// True diameter of the part at 20 °C, mm.
    d20_mm: f64,
    laid: Laid,
    /// Light on the part over the end of the grey scale, for [`Class::Clipped`].
    overexposure: Option<f64>,
    /// Surface of the part and distance of its axis from the plane of focus, mm, for
    /// [`Class::LIMBS`].
    limb: Option<(LimbPart, f64)>,
    seed: u64,
}

impl Planned {
    fn draw(class: Class, seed: u64) -> Result<Self, RenderError> {
        let mut draws = Draws::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let drawn = draw(class, seed, &mut draws)?;
        let overexposure = (class == Class::Clipped).then(|| 1.2 + 0.3 * draws.even());
        let d20_mm = 5.3 + 1.5 * draws.even();
        let surface = Class::LIMBS.contains(&class).then(|| LimbPart::draw(&mut draws));
        let film_mm = surface.map_or(0.0, |part| 2e-3 * part.film_um);
        let mut laid = lay(&drawn, d20_mm + film_mm, seed, &mut draws)?;
        // The limb's own table is that of its depth: one a scene in place of a stack.
        let limb = surface.map(|part| (part, std::mem::take(&mut laid.y_mm)));
        Ok(Self { drawn, d20_mm, laid, overexposure, limb, seed })
    }

    /// The setup that looks at the part: the masters' own but for the light.
    fn setup_of_part<'a>(
        &self,
        recordings: SimulatedRecordings<'a>,
        renderer: &'a Renderer,
    ) -> Result<SimulatedSetup<'a>, CalibrateError> {
        if self.drawn.class == Class::OtherLight {
            return in_other_light(&self.drawn, self.seed, renderer);
        }
        if let Some((part, y_mm)) = self.limb {
            return changed(&self.drawn, self.seed, renderer, |simulate| {
                simulate.optics.esf = part.seen_in(&simulate.optics.esf, y_mm);
            });
        }
        let Some(times) = self.overexposure else { return Ok(recordings.into_setup()) };
        let light = |simulate: &mut SimulatedPlan| simulate.light.bright_counts = 4095.0 * times;
        changed(&self.drawn, self.seed, renderer, light)
    }
}

/// The frames of a scene: of every master at every position, and of the part.
#[derive(Clone, Debug)]
pub(in crate::studies) struct Recorded {
    /// Of the masters, in the order in which a calibration takes them.
    pub pins: Vec<Frame>,
    /// Of the part: one, or one an angle.
    pub part: Vec<Frame>,
}

/// Renders the frames of a scene.
///
/// # Errors
/// Where they cannot be drawn.
pub(in crate::studies) fn record(
    class: Class,
    seed: u64,
    renderer: &Renderer,
) -> Result<Recorded, CalibrateError> {
    let planned = Planned::draw(class, seed)?;
    let mut recordings = SimulatedRecordings::new(&planned.drawn.plan, renderer)?;
    let mut pins = Vec::new();
    for (index, pin) in planned.drawn.plan.masters.iter().enumerate() {
        for position in &pin.positions {
            pins.extend(recordings.pin(index, pin, position)?);
        }
    }
    let mut setup = planned.setup_of_part(recordings, renderer)?;
    let laid = &planned.laid;
    let part = if matches!(class, Class::Form | Class::Lobes) {
        let angle_deg = |k: usize| laid.angle_deg + 180.0 * k as f64 / ANGLES as f64;
        let frame = |k: usize| setup.frame(&Laid { angle_deg: angle_deg(k), ..laid.clone() });
        (0..ANGLES).map(frame).collect::<Result<_, _>>()?
    } else {
        vec![expose(&planned.drawn, &mut setup, laid)?]
    };
    Ok(Recorded { pins, part })
}

/// Frames of the masters that were rendered before.
struct Pins<'a>(&'a [Frame]);

impl Recordings for Pins<'_> {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        // Every master has the same positions, and one frame at each.
        let place = pin.positions.iter().position(|p| p == position);
        let frame = place.and_then(|place| self.0.get(index * pin.positions.len() + place));
        Ok(frame.cloned().into_iter().collect())
    }

    fn dark(&mut self, _: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        Ok(Vec::new())
    }

    fn flat(&mut self, _: &CalibrationPlan, _: usize) -> Result<Vec<Frame>, CalibrateError> {
        Ok(Vec::new())
    }
}

/// Calibrates on the masters' frames of a scene and measures its part.
///
/// # Errors
/// Where the masters cannot be measured.
pub(in crate::studies) fn measure(
    class: Class,
    seed: u64,
    recorded: &Recorded,
) -> Result<Outcome, CalibrateError> {
    let Planned { drawn, d20_mm, laid, .. } = Planned::draw(class, seed)?;
    let calibration = calibrate(&drawn.plan, &mut Pins(&recorded.pins))?.calibration;
    match recorded.part.as_slice() {
        [frame] => Ok(judge(&drawn, &calibration, frame, d20_mm)),
        frames => measure_stations(&drawn, &calibration, frames, (&laid, d20_mm)),
    }
}

/// Runs a scene.
///
/// # Errors
/// Where the masters cannot be drawn or measured.
pub(crate) fn run(class: Class, seed: u64, renderer: &Renderer) -> Result<Outcome, CalibrateError> {
    measure(class, seed, &record(class, seed, renderer)?)
}

/// The same optical setup in partially coherent light.
fn in_other_light<'a>(
    drawn: &Drawn,
    seed: u64,
    renderer: &'a Renderer,
) -> Result<SimulatedSetup<'a>, CalibrateError> {
    changed(drawn, seed, renderer, |simulate| {
        simulate.optics.esf = Esf::PartiallyCoherent(coherent(false, OTHER_KIND));
    })
}

/// The same optical setup with a change.
fn changed<'a>(
    drawn: &Drawn,
    seed: u64,
    renderer: &'a Renderer,
    change: impl FnOnce(&mut SimulatedPlan),
) -> Result<SimulatedSetup<'a>, CalibrateError> {
    let mut plan = drawn.plan.clone();
    if let Some(simulate) = &mut plan.simulate {
        change(simulate);
    }
    let other = SimulatedRecordings::new(&plan, renderer)?.into_setup();
    // Independent noise, not that of the first master's frames.
    Ok(SimulatedSetup::new(renderer, other.setup().clone(), other.telecentricity_per_mm, !seed))
}

/// The true pose of the part, drawn from the conditions, or outside them for the classes that are
/// outside.
fn lay(drawn: &Drawn, d20_mm: f64, seed: u64, draws: &mut Draws) -> Result<Laid, RenderError> {
    let c = &drawn.conditions;
    let edge_mm = 1e-3 * drawn.finish_um * draws.even();
    let drift = 1e-6 * c.limit_drift_ppm * draws.even();
    let mut form = ShaftForm::default();
    let mut laid = Laid {
        shaft: Shaft::cylinder(d20_mm),
        temperature_c: c.temperature_c + c.limit_temperature_k * draws.even(),
        expansion_per_k: 1e-6 * (c.expansion_um_per_m_k + c.limit_expansion_um_per_m_k * draws.even()),
        height_mm: 0.3 * draws.even(),
        y_mm: c.axis_y_mm + c.limit_axis_y_mm * draws.even(),
        tilt_mrad: 0.5 * draws.even(),
        angle_deg: 180.0 * draws.even(),
    };
    let mut seen_mm = d20_mm * (1.0 + drift) + 2.0 * edge_mm;
    match drawn.class {
        Class::Form => {
            form.texture = Some(TextureForm {
                rms_um: 0.5,
                correlation_z_mm: 0.05,
                correlation_theta_deg: 2.0,
                ..TextureForm::default()
            });
        }
        Class::Lobes => {
            form.texture = Some(TextureForm {
                rms_um: 0.3,
                correlation_z_mm: 0.05,
                correlation_theta_deg: 2.0,
                ..TextureForm::default()
            });
            let lobe =
                |order_upr, a: f64, phase: f64| Lobe { order_upr, amplitude_mm: 1e-3 * a, phase_deg: phase };
            form.lobes = vec![
                lobe(2, 3.0 * draws.even(), 180.0 * draws.even()),
                lobe(3, 3.0 * draws.even(), 120.0 * draws.even()),
                lobe(5, draws.even(), 72.0 * draws.even()),
            ];
        }
        Class::Tilt => laid.tilt_mrad = 20.0 * draws.even(),
        Class::WarmPart => laid.temperature_c += 8.0,
        Class::OtherFinish => seen_mm += 2e-3,
        Class::LossOfFocus => laid.y_mm = 6.0 + 4.0 * draws.even().abs(),
        _ => {}
    }
    if form != ShaftForm::default() {
        let blank = vec![
            ProfileKnot { z_mm: -4.0, radius_mm: 0.5 * seen_mm },
            ProfileKnot { z_mm: 4.0, radius_mm: 0.5 * seen_mm },
        ];
        laid.shaft = form_shaft(blank, &form, 8.0, seed)?;
    } else {
        laid.shaft = Shaft::cylinder(seen_mm);
    }
    Ok(laid)
}

/// The frame, with the disturbances during the exposure.
fn expose(drawn: &Drawn, setup: &mut SimulatedSetup<'_>, laid: &Laid) -> Result<Frame, RenderError> {
    match drawn.class {
        Class::Vibration => {
            // Two places 3 px apart within one exposure.
            let shift = 1.5 * setup.setup().pixel_mm;
            let one = setup.frame(&Laid { height_mm: laid.height_mm + shift, ..laid.clone() })?;
            let two = setup.frame(&Laid { height_mm: laid.height_mm - shift, ..laid.clone() })?;
            Ok(mean_of(one, &two))
        }
        Class::Overexposed => {
            let mut frame = setup.frame(laid)?;
            if let crate::frame::PixelsMut::U16(pixels) = frame.pixels_mut() {
                pixels.iter_mut().for_each(|p| *p = p.saturating_mul(3).min(4095));
            }
            Ok(frame)
        }
        _ => setup.frame(laid),
    }
}

fn mean_of(mut one: Frame, two: &Frame) -> Frame {
    let (view, mut index) = (two.view(), 0);
    let columns = view.columns();
    if let crate::frame::PixelsMut::U16(pixels) = one.pixels_mut() {
        for p in pixels {
            let other = view.get(index / columns, index % columns).unwrap_or(0.0);
            *p = (0.5 * (f32::from(*p) + other)).round() as u16;
            index += 1;
        }
    }
    one
}

fn judge(drawn: &Drawn, calibration: &Calibration, frame: &Frame, true_mm: f64) -> Outcome {
    let Ok(gauge) = Gauge::new(drawn.plan.gauge.clone()) else { return refused("settings".to_owned()) };
    let gauge = gauge.with_systematic_residual(calibration.systematic_residual());
    let edges = match gauge.edges(&frame.view()) {
        Ok(edges) => edges,
        Err(e) => return refused(e.reason.to_string()),
    };
    let Some(reading) = WidthReading::of_frame(&edges, 0..edges.columns()) else {
        return refused("too few columns".to_owned());
    };
    let budget = reading.budget(calibration, &drawn.conditions);
    // Under clipped light every column is impaired, and the study tests its interval.
    let flag = match drawn.class {
        Class::Clipped => String::new(),
        _ => flag(calibration, &drawn.conditions, &edges),
    };
    outcome(&budget, true_mm, flag)
}

/// The middle station's mean over angles, as a run measures it: random part of type A over the
/// angles.
fn measure_stations(
    drawn: &Drawn,
    calibration: &Calibration,
    frames: &[Frame],
    (laid, d20_mm): (&Laid, f64),
) -> Result<Outcome, CalibrateError> {
    let gauge =
        Gauge::new(drawn.plan.gauge.clone())?.with_systematic_residual(calibration.systematic_residual());
    let z_mm: Vec<f64> = (0..STATIONS).map(|i| (i as f64 - (STATIONS / 2) as f64) * STATION_MM).collect();
    let mut averager = StationAverager::new(&drawn.plan.gauge.station, z_mm, STATION_MM);
    let (mut common, mut flags) = (None, Vec::new());
    for (k, frame) in frames.iter().enumerate() {
        let angle_deg = laid.angle_deg + 180.0 * k as f64 / ANGLES as f64;
        let edges = match gauge.edges(&frame.view()) {
            Ok(edges) => edges,
            Err(e) => return Ok(refused(e.reason.to_string())),
        };
        let meta = FrameMeta { angle_deg, ..FrameMeta::default() };
        averager.add(&meta, &calibration.diameters_under(&edges, &drawn.conditions));
        common = common.or(WidthReading::of_frame(&edges, 0..edges.columns()));
        flags.push(flag(calibration, &drawn.conditions, &edges));
    }
    // A fault of light or lens is present in most frames; columns that one frame of ten loses by
    // chance are covered by the others.
    let clean = flags.iter().filter(|f| f.is_empty()).count();
    let worst = flags.into_iter().find(|f| !f.is_empty() && 2 * clean < ANGLES).unwrap_or_default();
    let station = averager.finish(1).stations[STATIONS / 2];
    let (Some(d), Some(reading)) = (station.reading.value(), common) else {
        return Ok(refused("gap".to_owned()));
    };
    let mut budget = reading.budget(calibration, &drawn.conditions);
    budget.contributions.retain(|c| c.share == Share::Common);
    budget.diameter_mm = d.d_mm;
    budget.push(Contribution {
        source: "noise, texture and form over the angles".to_owned(),
        input: format!("{ANGLES} angles, pooled over {STATIONS} stations"),
        shape: Shape::Normal,
        share: Share::Random,
        freedom: Some((STATIONS * (ANGLES - 5)) as f64),
        u_mm: d.u_random_mm,
    });
    let half = 0.5 * STATION_MM;
    let true_mm = truth::station_diameter_mm(&laid.shaft, -half, half)?;
    // The drawn shaft includes finish and drift, which are not part of the diameter.
    let added_mm = 2.0 * laid.shaft.profile[0].radius_mm - d20_mm;
    Ok(outcome(&budget, true_mm - added_mm, worst))
}
