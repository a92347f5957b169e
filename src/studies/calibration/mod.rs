//! Calibration of an optical setup: from recorded or rendered frames of dark and flat fields and
//! master pins to a calibration with its residuals and the verdict of a check pin.

mod calibrated;
mod error;
mod one_encoding;
mod plan;
mod recordings;
mod simulated;
mod words;

pub(crate) use calibrated::Calibrated;
pub(crate) use error::CalibrateError;
use one_encoding::OneEncoding;
pub(crate) use plan::{CalibrationPlan, Fields, PinPlan, Position, SimulatedPlan};
pub(crate) use recordings::Recordings;
pub(crate) use simulated::{Draws, Laid, SimulatedRecordings, SimulatedSetup};
pub(crate) use words::{edge_model_line, parameter_table};

use crate::frame::{Frame, FrameView};
use crate::gauge::budget::{Budget, Contribution, Shape, Share, WidthReading};
use crate::gauge::calibration::{
    Adjustment, CheckPin, CheckResult, Conditions, LensModel, MasterPrior, Observation, SetupCalibration,
    Thermometer, Validity, observe, shared_source,
};
use crate::gauge::photon_transfer::{FramePair, PhotonTransfer, photon_transfer};
use crate::gauge::sensor::{FlatField, FlatFieldError, NoResponse, Response, response};
use crate::gauge::{
    Calibration, CalibrationError, Edge, EsfModel, FrameEdges, Gauge, GaugeSettings, MasterFigure,
    ResidualAccumulator, SettledStream, SystematicResidual, least_travel_px,
};

/// Edges of a pin's frames with their position.
struct PinEdges {
    edges: Vec<(FrameEdges, f64)>,
    size: (usize, usize),
    /// Frames left out because no edge-spread function could be estimated from them.
    unlearnt: usize,
}

/// Makes a calibration.
///
/// # Errors
/// A plan out of range, frames that are unavailable or cannot be measured, masters that do not
/// determine the optical setup.
pub(crate) fn calibrate(
    plan: &CalibrationPlan,
    recordings: &mut dyn Recordings,
) -> Result<Calibrated, CalibrateError> {
    let plan = &plan.settled();
    plan.validate()?;
    let gauge = Gauge::new(plan.gauge.clone())?;
    let mut recordings = OneEncoding::new(recordings);
    let (flat_field, sensor) = fields(plan, &mut recordings)?;
    let (pins, systematic_residual) = all_pins(plan, &gauge, flat_field.as_ref(), &mut recordings)?;
    let size = pins[0].size;
    for (pin, seen) in plan.masters.iter().chain(&plan.check).zip(&pins) {
        if seen.size != size {
            return Err(CalibrateError::Size { pin: pin.name.clone(), found: seen.size, expected: size });
        }
    }
    let masters = plan.masters.len();
    let (mut adjustment, figures) = adjustment(plan, &pins[..masters], size)?;
    let adjusted = adjustment.fit()?;
    let (sigma_px, defocus_px_per_mm) = blur(&pins[..masters]);
    let validity = Validity { date: plan.date, valid_days: plan.valid_days };
    let mut setup = SetupCalibration::new(&adjusted, size, validity, sigma_px);
    setup.defocus_px_per_mm = defocus_px_per_mm;
    setup.conditions = plan.conditions;
    setup.sensor = sensor;
    setup.flat_field = flat_field;
    let mut calibration = Calibration::of_setup(&adjusted, figures, setup)
        .with_optics_id(&plan.optics_id)
        .with_systematic_residual(systematic_residual)
        .with_edge_model(&plan.gauge.esf)
        .with_encoding(recordings.encoding.unwrap_or_default());
    let check = plan
        .check
        .as_ref()
        .zip(pins.get(masters))
        .and_then(|(pin, seen)| judge(plan, pin, seen, &calibration));
    if let Some(setup) = &mut calibration.setup {
        setup.check = check;
    }
    let first = pins[masters / 2].edges.first();
    let reading = first.and_then(|(edges, _)| WidthReading::of_frame(edges, 0..edges.columns()));
    let example = reading.as_ref().map(|r| r.budget(&calibration, &plan.conditions));
    let unlearnt_frames = pins.iter().map(|p| p.unlearnt).sum();
    Ok(Calibrated { calibration, adjustment, reading, example, unlearnt_frames })
}

/// Scale from the smallest and the largest master by Gaussian edges, µm/px: accurate to parts in a
/// thousand, used to convert an edge-spread function in µm before it can be fitted.
///
/// # Errors
/// Frames that are unavailable or cannot be measured.
pub(crate) fn rough_um_per_px(
    plan: &CalibrationPlan,
    recordings: &mut dyn Recordings,
) -> Result<f64, CalibrateError> {
    let plan = &plan.settled();
    plan.validate()?;
    let gauge = Gauge::new(GaugeSettings { esf: EsfModel::Gaussian {}, ..plan.gauge.clone() })?;
    let by_size = |a: &(usize, &PinPlan), b: &(usize, &PinPlan)| a.1.diameter_mm.total_cmp(&b.1.diameter_mm);
    let masters = || plan.masters.iter().enumerate();
    let mut ends = Vec::new();
    for (index, pin) in masters().min_by(by_size).into_iter().chain(masters().max_by(by_size)) {
        let mut one = PinPlan { positions: pin.positions.clone(), ..pin.clone() };
        one.positions.truncate(1);
        let seen = pin_edges(&mut SettledStream::new(gauge.stream()), None, (index, &one), recordings, None)?;
        let of_pin: Vec<FrameEdges> = seen.edges.into_iter().map(|(e, _)| e).collect();
        ends.push(MasterFigure::from_edges(pin.certificate(), &of_pin)?);
    }
    let [small, large] = &ends[..] else { return Err(CalibrationError::TooFew { found: ends.len() }.into()) };
    let travel_mm = large.certificate.diameter_mm - small.certificate.diameter_mm;
    Ok(1e3 * travel_mm / (large.width_px - small.width_px))
}

/// Blur in the masters' plane and its growth with the distance from it, px and px/mm: σ² = σ₀² +
/// (c·y)² by least squares.
fn blur(pins: &[PinEdges]) -> (f64, f64) {
    let points: Vec<(f64, f64)> = pins
        .iter()
        .flat_map(|p| {
            p.edges.iter().map(|(e, y)| (y * y, e.figures.sigma_px.map(|s| s * s).iter().sum::<f64>() / 2.0))
        })
        .collect();
    let n = points.len().max(1) as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, v) = (mean(&|p| p.0), mean(&|p| p.1));
    let square = mean(&|p| (p.0 - x).powi(2));
    let growth = if square > 0.0 { (mean(&|p| (p.0 - x) * (p.1 - v)) / square).max(0.0) } else { 0.0 };
    ((v - growth * x).max(0.01).sqrt(), growth.sqrt())
}

fn fields(
    plan: &CalibrationPlan,
    recordings: &mut dyn Recordings,
) -> Result<(Option<FlatField>, Option<PhotonTransfer>), CalibrateError> {
    if plan.fields.flats.is_empty() {
        return Ok((None, None));
    }
    let dark = recordings.dark(plan)?;
    at_least_two("fields.dark", dark.len())?;
    let mut flats = Vec::new();
    for index in 0..plan.fields.flats.len() {
        let frames = recordings.flat(plan, index)?;
        at_least_two(&format!("fields.flats[{index}]"), frames.len())?;
        flats.push((plan.fields.flats[index].exposure, frames));
    }
    let response = sensor_response(&dark, &flats)?;
    let (dark, mut flats) = match &response {
        Some(response) => {
            let light =
                |frames: Vec<Frame>| frames.into_iter().map(|f| response.linearised(f)).collect::<Vec<_>>();
            (light(dark), flats.into_iter().map(|(exposure, frames)| (exposure, light(frames))).collect())
        }
        None => (dark, flats),
    };
    let dark_views: Vec<FrameView<'_>> = dark.iter().map(Frame::view).collect();
    // The brightest exposure that is not clipped has the best signal for defects and light.
    flats.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut flat_field = Err(FlatFieldError::TooFew { what: "flat" });
    for (_, frames) in &flats {
        let views: Vec<FrameView<'_>> = frames.iter().map(Frame::view).collect();
        flat_field = FlatField::new(&dark_views, &views);
        if flat_field.is_ok() {
            break;
        }
    }
    let flat_field = flat_field?.with_response(response);
    if flats.len() < 3 {
        return Ok((Some(flat_field), None));
    }
    let pairs: Vec<FramePair<'_>> = flats.iter().filter_map(|(exposure, f)| pair(*exposure, f)).collect();
    let darks: Vec<FramePair<'_>> = pair(0.0, &dark).into_iter().collect();
    Ok((Some(flat_field), Some(photon_transfer(&pairs, &darks)?)))
}

/// The nonlinearity of the response, from two exposures or more.
fn sensor_response(dark: &[Frame], flats: &[(f64, Vec<Frame>)]) -> Result<Option<Response>, NoResponse> {
    let dark: Vec<FrameView<'_>> = dark.iter().map(Frame::view).collect();
    let flats: Vec<(f64, Vec<FrameView<'_>>)> = flats
        .iter()
        .map(|(exposure, frames)| (*exposure, frames.iter().map(Frame::view).collect()))
        .collect();
    response(&dark, &flats)
}

/// A single frame of a field does not determine the noise; without this check it would be left out
/// of the transfer curve without notice.
fn at_least_two(key: &str, found: usize) -> Result<(), CalibrateError> {
    match found {
        2.. => Ok(()),
        _ => Err(CalibrateError::Frames(format!(
            "{key}: {found} frame(s); two or more are needed, so that their noise can be told from the pixels' own pattern"
        ))),
    }
}

fn pair(exposure: f64, frames: &[Frame]) -> Option<FramePair<'_>> {
    let [first, second, ..] = frames else { return None };
    Some(FramePair { exposure, first: first.view(), second: second.view() })
}

/// Edges of all pins, and the masters' systematic residual of the edge model. Where that exceeds
/// the noise, the pins are measured again with it as expected residual: their own uncertainties
/// then include only departures from it.
fn all_pins(
    plan: &CalibrationPlan,
    gauge: &Gauge,
    flat_field: Option<&FlatField>,
    recordings: &mut dyn Recordings,
) -> Result<(Vec<PinEdges>, Option<SystematicResidual>), CalibrateError> {
    let mut look =
        |gauge: &Gauge, residuals: &mut ResidualAccumulator| -> Result<Vec<PinEdges>, CalibrateError> {
            let mut stream = SettledStream::new(gauge.stream());
            let mut pins = Vec::new();
            for (index, pin) in plan.masters.iter().chain(&plan.check).enumerate() {
                let residuals = (index < plan.masters.len()).then_some(&mut *residuals);
                pins.push(pin_edges(&mut stream, flat_field, (index, pin), recordings, residuals)?);
            }
            Ok(pins)
        };
    let mut residuals = ResidualAccumulator::default();
    let pins = look(gauge, &mut residuals)?;
    let Some(systematic_residual) = residuals.finish() else { return Ok((pins, None)) };
    let pins = look(
        &gauge.clone().with_systematic_residual(Some(&systematic_residual)),
        &mut ResidualAccumulator::default(),
    )?;
    Ok((pins, Some(systematic_residual)))
}

fn pin_edges(
    stream: &mut SettledStream<f64>,
    flat_field: Option<&FlatField>,
    (index, pin): (usize, &PinPlan),
    recordings: &mut dyn Recordings,
    mut residuals: Option<&mut ResidualAccumulator>,
) -> Result<PinEdges, CalibrateError> {
    let learns = stream.settings().esf == (EsfModel::Learnt {});
    let (mut edges, mut size, mut unlearnt) = (Vec::new(), None, Vec::new());
    let mut why = "no frame arrived".to_owned();
    let is_lost = |seen: &FrameEdges| learns && !seen.figures.is_learnt();
    let mut keep = |y_mm: f64, seen: &FrameEdges| match is_lost(seen) {
        true => unlearnt.push(travel(seen)),
        false => edges.push((seen.clone(), y_mm)),
    };
    for position in &pin.positions {
        for frame in recordings.pin(index, pin, position)? {
            let frame = match flat_field {
                Some(field) => field.corrected(frame),
                None => frame,
            };
            let view = frame.view();
            let found = (view.rows(), view.columns());
            let expected = *size.get_or_insert(found);
            if found != expected {
                return Err(CalibrateError::Size { pin: pin.name.clone(), found, expected });
            }
            let mut seen = FrameEdges::default();
            match stream.measure(&view, &mut seen, position.y_mm, &mut keep) {
                Ok(()) => match &mut residuals {
                    Some(residuals) if !is_lost(&seen) => stream.accumulate(residuals, &seen),
                    _ => {}
                },
                Err(refused) => why = refused.to_string(),
            }
        }
    }
    stream.finish(&mut keep);
    let pin = pin.name.clone();
    match size {
        Some(size) if !edges.is_empty() => Ok(PinEdges { edges, size, unlearnt: unlearnt.len() }),
        Some((_, columns)) if !unlearnt.is_empty() => Err(CalibrateError::Unlearnt {
            pin,
            frames: unlearnt.len(),
            needed: least_travel_px(),
            travel: unlearnt.into_iter().fold(0.0, f64::max),
            tilt_mrad: 1e3 * least_travel_px() / columns as f64,
        }),
        _ => Err(CalibrateError::Pin { pin, why }),
    }
}

/// The smaller travel of both edges along a frame, rows.
fn travel(edges: &FrameEdges) -> f64 {
    let along = |line: &[Edge]| {
        let rows = || line.iter().filter(|e| e.is_usable()).map(|e| e.row_px);
        rows().fold(f64::NEG_INFINITY, f64::max) - rows().fold(f64::INFINITY, f64::min)
    };
    along(&edges.top).min(along(&edges.bottom)).max(0.0)
}

fn adjustment(
    plan: &CalibrationPlan,
    pins: &[PinEdges],
    size: (usize, usize),
) -> Result<(Adjustment, Vec<MasterFigure>), CalibrationError> {
    let perfect = LensModel::perfect(size.0, size.1);
    let (mut observations, mut figures, mut frame) = (Vec::<Observation>::new(), Vec::new(), 0);
    for (index, (pin, seen)) in plan.masters.iter().zip(pins).enumerate() {
        for (edges, y_mm) in &seen.edges {
            let of_frame = observe(edges, &perfect, index, frame, *y_mm);
            frame += usize::from(!of_frame.is_empty());
            observations.extend(of_frame);
        }
        let edges: Vec<FrameEdges> = seen.edges.iter().map(|(e, _)| e.clone()).collect();
        figures.push(MasterFigure::from_edges(pin.certificate(), &edges)?);
    }
    let masters = plan
        .masters
        .iter()
        .map(|p| MasterPrior { name: p.name.clone(), certificate: p.certificate(), common: p.common() })
        .collect();
    let adjustment = Adjustment::new(masters, observations, plan.thermometer, &plan.lens, size)?;
    Ok((adjustment, figures))
}

/// The check pin's diameter by the new calibration against its certificate. The pin was recorded at
/// the masters' temperature, whose effect on both cancels.
fn judge(
    plan: &CalibrationPlan,
    pin: &PinPlan,
    seen: &PinEdges,
    calibration: &Calibration,
) -> Option<CheckResult> {
    let Thermometer { temperature_c, expansion_um_per_m_k, .. } = plan.thermometer;
    let mut measured = Vec::new();
    for (edges, y_mm) in &seen.edges {
        let conditions =
            Conditions { temperature_c, expansion_um_per_m_k, axis_y_mm: *y_mm, ..Conditions::default() };
        let mut budget = WidthReading::of_frame(edges, 0..edges.columns())?.budget(calibration, &conditions);
        budget.contributions.retain(|c| !c.source.contains("of the masters"));
        measured.push(budget);
    }
    let n = measured.len() as f64;
    let mean = |f: &dyn Fn(&Budget) -> f64| measured.iter().map(f).sum::<f64>() / n;
    let measured_mm = mean(&|b| b.diameter_mm);
    let (u_shared_mm, u_certificate_mm) = certificate_beside(pin, &measured);
    let common = (mean(&|b| b.u_common_mm().powi(2)) - u_shared_mm.powi(2)).max(0.0).sqrt();
    // The mean's budget: random rows of each frame separately, common rows and the certificate
    // together.
    let mut whole = Budget { diameter_mm: measured_mm, contributions: Vec::new() };
    let rows = measured.iter().flat_map(|b| &b.contributions).filter(|c| c.share == Share::Random);
    rows.for_each(|c| whole.push(Contribution { u_mm: c.u_mm / n, ..c.clone() }));
    let known = |source: &str, u_mm| Contribution {
        source: source.to_owned(),
        input: String::new(),
        shape: Shape::Normal,
        share: Share::Common,
        freedom: None,
        u_mm,
    };
    whole.push(known("what all frames share", common));
    whole.push(known("certificate of the check pin", u_certificate_mm));
    let coverage_factor = whole.factor_or(None);
    let u_error_mm = whole.u_mm();
    Some(CheckPin { certificate: pin.certificate(), measured_mm, u_error_mm, coverage_factor }.judge())
}

/// Contribution to the measured diameter of the laboratory that also certified the check pin, mm,
/// and contribution of the pin's certificate to the difference of both: a common error cancels as
/// far as it is the same in both.
fn certificate_beside(pin: &PinPlan, measured: &[Budget]) -> (f64, f64) {
    let certificate = pin.certificate().u_mm();
    let Some(common) = pin.common() else { return (0.0, certificate) };
    let source = shared_source(&common.certified_by);
    let rows = measured.iter().flat_map(|b| &b.contributions).filter(|c| c.source == source);
    let shared = rows.map(|c| c.u_mm * c.u_mm).sum::<f64>() / measured.len() as f64;
    let shared = shared.sqrt();
    let own = (certificate.powi(2) - common.u_mm.powi(2)).max(0.0).sqrt();
    (shared, own.hypot(shared - common.u_mm))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::frame::{Buffer, FrameMeta, PixelFormat};

    /// Two dark frames, and the given number of each exposure.
    struct Fields(Vec<usize>);

    fn frame() -> Frame {
        Frame::new(Buffer::U8(vec![9; 64 * 64]), PixelFormat::Mono8, 64, 64, FrameMeta::default()).unwrap()
    }

    impl Recordings for Fields {
        fn pin(&mut self, _: usize, _: &PinPlan, _: &Position) -> Result<Vec<Frame>, CalibrateError> {
            Ok(Vec::new())
        }

        fn dark(&mut self, _: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
            Ok(vec![frame(), frame()])
        }

        fn flat(&mut self, _: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
            Ok((0..self.0[index]).map(|_| frame()).collect())
        }
    }

    /// It used to be left out of the transfer curve without notice.
    #[test]
    fn a_flat_field_of_one_frame_is_named() {
        let plan: CalibrationPlan = toml::from_str(
            "optics_id = \"any\"\ndate = \"2026-11-22\"\nmasters = []\n\
             fields.flats = [{ exposure = 0.2 }, { exposure = 0.4 }, { exposure = 1.0 }]",
        )
        .unwrap();
        let said = fields(&plan, &mut Fields(vec![2, 1, 2])).unwrap_err().to_string();
        assert!(said.contains("fields.flats[1]: 1 frame(s); two or more"), "{said}");
        // With two of each the flats themselves are refused, because they are as dark as the dark
        // frames.
        assert!(matches!(fields(&plan, &mut Fields(vec![2; 3])), Err(CalibrateError::Fields(_))));
    }

    /// A 12-bit sensor with black at 64 whose signal is a power of the light, and noise of ± 6
    /// counts.
    struct Power(f64, crate::frame::Encoding);

    impl Power {
        fn frames(&self, exposure: f64) -> Vec<Frame> {
            let seed = (1e3 * exposure) as u64;
            let meta = FrameMeta { encoding: self.1, ..FrameMeta::default() };
            let frame = |k: u64| {
                let mut rng = Pcg64::seed_from_u64(10 * seed + k);
                let pixels = (0..64 * 64).map(|i| {
                    let light = exposure * (1.0 - 0.2 * f64::from(i % 64) / 64.0);
                    let noise: f64 = (0..6).map(|_| rng.random_range(-1.0..1.0)).sum();
                    (64.5 + 3900.0 * light.powf(self.0) + noise) as u16
                });
                Frame::new(Buffer::U16(pixels.collect()), PixelFormat::Mono12, 64, 64, meta.clone()).unwrap()
            };
            vec![frame(0), frame(1)]
        }
    }

    impl Recordings for Power {
        fn pin(&mut self, _: usize, _: &PinPlan, _: &Position) -> Result<Vec<Frame>, CalibrateError> {
            Ok(Vec::new())
        }

        fn dark(&mut self, _: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
            Ok(self.frames(0.0))
        }

        fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
            Ok(self.frames(plan.fields.flats[index].exposure))
        }
    }

    fn flats(exposures: &str) -> CalibrationPlan {
        let start = "optics_id = \"any\"\ndate = \"2026-11-22\"\nmasters = []\nfields.flats = ";
        toml::from_str(&format!("{start}{exposures}")).unwrap()
    }

    #[test]
    fn a_response_that_is_not_linear_enters_the_flat_field() {
        let linear = crate::frame::Encoding::LINEAR;
        let plan = flats("[{ exposure = 0.2 }, { exposure = 0.8 }]");
        let field = fields(&plan, &mut Power(0.6, linear)).unwrap().0.unwrap();
        let response = field.response.unwrap();
        assert!((response.exponent * 0.6 - 1.0).abs() < 0.03, "{response:?}");
        // The corrected field is level: the fall-off of light of 0.2 is compensated, the response
        // linear.
        let shown = field.corrected(Power(0.6, linear).frames(0.4).remove(0));
        let mean =
            |c: usize| (0..64).filter_map(|r| shown.view().get(r, c)).map(f64::from).sum::<f64>() / 64.0;
        let black = field.black_counts;
        assert!(((mean(4) - black) / (mean(60) - black) - 1.0).abs() < 0.02, "{} and {}", mean(4), mean(60));
        let straight = fields(&plan, &mut Power(1.0, linear)).unwrap().0.unwrap();
        assert_eq!(straight.response, None);
    }

    #[test]
    fn frames_of_two_encodings_make_no_calibration() {
        let plan = flats("[{ exposure = 0.2 }, { exposure = 0.8 }]");
        let mut recordings = Power(1.0, crate::frame::Encoding::LINEAR);
        let mut one = OneEncoding::new(&mut recordings);
        one.encoding = Some(crate::frame::Encoding::SRGB);
        let said = fields(&plan, &mut one).unwrap_err().to_string();
        assert!(said.contains("fields.dark: the file encodes its grey values otherwise (linear)"), "{said}");
    }
}
