//! Sizes over a revolution for the modifiers of a tolerance: the envelope (E), the least
//! circumscribed cylinder (GN) and circles (GN) ACS.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use super::error::MeasureError;
use crate::conformity::{Decision, DecisionRule, Estimate, Judgement, MANY, SizeCriterion, Tolerance};
use crate::frame::FrameMeta;
use crate::gauge::axis_line::{AxisAverager, AxisLine};
use crate::gauge::diameter::sections::{Envelope, PartForm, TurnAverager};
use crate::gauge::diameter::turning_depth::{Telecentricity, correct_frames};
use crate::gauge::form::Cutoff;
use crate::gauge::{Calibration, ColumnDiameters};

/// Columns of a section of an envelope: wide enough to suppress the noise of single columns, narrow
/// enough to resolve a crest of that width.
const ENVELOPE_COLUMNS: f64 = 8.0;

/// The judgement of a size over a revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnJudged {
    /// The size that the tolerance applies to.
    pub what: &'static str,
    /// Middle of the section that decided, mm; `None` for a size over the length.
    pub z_mm: Option<f64>,
    /// Sections of a size over the length.
    pub sections: Option<usize>,
    /// The size, or why there is none.
    pub size: Result<JudgedSize, String>,
}

/// A size with its judgement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedSize {
    /// The size, mm.
    pub d_mm: f64,
    /// Its combined standard uncertainty, mm.
    pub u_mm: f64,
    /// Guard band, mm; `None` where it leaves no acceptance zone.
    pub guard_mm: Option<f64>,
    /// Its judgement.
    pub judgement: Judgement,
}

impl TurnJudged {
    /// The judgement; a size that was not measured is not proven small enough.
    pub(crate) fn judgement(&self) -> Judgement {
        self.size.as_ref().map_or(Judgement::HI, |size| size.judgement)
    }
}

impl Serialize for TurnJudged {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("what", self.what)?;
        if let Some(z_mm) = self.z_mm {
            map.serialize_entry("z_mm", &z_mm)?;
        }
        match &self.size {
            Err(why) => {
                map.serialize_entry("judgement", &None::<Judgement>)?;
                map.serialize_entry("why", why)?;
            }
            Ok(size) => {
                map.serialize_entry("d_mm", &size.d_mm)?;
                map.serialize_entry("u_mm", &size.u_mm)?;
                if let Some(sections) = self.sections {
                    map.serialize_entry("sections", &sections)?;
                }
                map.serialize_entry("judgement", &size.judgement)?;
                map.serialize_entry("guard_mm", &size.guard_mm)?;
            }
        }
        map.end()
    }
}

/// Judges the sizes over a revolution that `tolerance` applies to; `None` where there are none.
/// `common_mm` is the common standard uncertainty of sizes at z, mm, `envelope` the envelope or why
/// there is none.
pub(super) fn judge_turn(
    tolerance: &Tolerance,
    rule: DecisionRule,
    form: &PartForm,
    envelope: &Result<Envelope, String>,
    common_mm: &dyn Fn(f64) -> Option<f64>,
) -> Option<TurnJudged> {
    let (lower, upper) = tolerance.limits_mm();
    let what = tolerance.criterion.as_str();
    let common = |z_mm: f64| common_mm(z_mm).unwrap_or(0.0);
    let largest_common = form.sections.iter().map(|s| common(s.z_mm)).fold(0.0, f64::max);
    let over_length = |lower: f64| TurnJudged {
        what,
        z_mm: None,
        sections: envelope.as_ref().ok().map(|e| e.sections),
        size: envelope.as_ref().map_err(Clone::clone).map(|envelope| {
            let u_mm = envelope.u_random_mm.hypot(largest_common);
            judged(rule, &Estimate { value_mm: envelope.diameter_mm, u_mm, freedom: MANY }, (lower, upper))
        }),
    };
    match tolerance.criterion {
        SizeCriterion::TwoPoint => None,
        // The lower limit applies to the two-point sizes, which are judged by frame.
        SizeCriterion::Envelope => Some(over_length(f64::NEG_INFINITY)),
        SizeCriterion::CircumscribedCylinder => Some(over_length(lower)),
        SizeCriterion::CircumscribedCircle => {
            let sections = form.sections.iter().map(|s| {
                let u_mm = (std::f64::consts::SQRT_2 * s.u_edge_mm).hypot(common(s.z_mm));
                let estimate = Estimate { value_mm: s.gn_mm, u_mm, freedom: MANY };
                let size = Ok(judged(rule, &estimate, (lower, upper)));
                TurnJudged { what, z_mm: Some(s.z_mm), sections: None, size }
            });
            let worst = sections.max_by_key(|s| s.judgement().severity());
            let refused = form.refused.first().map(|(z_mm, why)| TurnJudged {
                what,
                z_mm: Some(*z_mm),
                sections: None,
                size: Err(why.clone()),
            });
            // A section without a full turn is not proven good.
            match (worst, refused) {
                (Some(worst), Some(refused)) if worst.judgement() == Judgement::GO => Some(refused),
                (Some(worst), _) => Some(worst),
                (None, refused) => refused,
            }
        }
    }
}

fn judged(rule: DecisionRule, estimate: &Estimate, (lower, upper): (f64, f64)) -> JudgedSize {
    let above = !lower.is_finite() || estimate.value_mm >= 0.5 * (lower + upper);
    let judgement = match rule.decide(estimate, lower, upper) {
        Decision::Conforms => Judgement::GO,
        Decision::TooLarge => Judgement::HH,
        Decision::TooSmall => Judgement::LL,
        Decision::NotProven if above => Judgement::HI,
        Decision::NotProven => Judgement::LO,
    };
    let guard_mm = rule.guard_mm(estimate.u_mm, estimate.freedom, upper - lower);
    JudgedSize { d_mm: estimate.value_mm, u_mm: estimate.u_mm, guard_mm, judgement }
}

/// Frames of a revolution with the diameters of their columns.
type Frames = [(FrameMeta, ColumnDiameters)];

/// Lowest and highest z that the frames of a revolution show, mm.
fn z_range_mm(turn: &Frames) -> Option<(f64, f64)> {
    let ends = turn
        .iter()
        .filter(|(_, d)| !d.columns.is_empty())
        .map(|(meta, d)| (d.z_mm(meta, 0), d.z_mm(meta, d.columns.len() - 1)));
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
    (high > low).then_some((low, high))
}

/// Number of places at which the axis is reported where there are no stations.
const AXIS_PLACES: f64 = 16.0;

/// The axis along the length that the frames show; what of it turns towards the camera is taken off
/// their diameters, where the calibration determines the telecentricity.
pub(super) fn corrected_by_axis(
    turn: &mut Frames,
    station_mm: Option<f64>,
    calibration: &Calibration,
) -> AxisLine {
    let axis = axis_line(turn, station_mm, calibration);
    if let Some(telecentricity) = Telecentricity::of(calibration) {
        correct_frames(turn, &axis, telecentricity);
    }
    axis
}

/// The axis along the length that the frames show, by stations of a length.
fn axis_line(turn: &Frames, station_mm: Option<f64>, calibration: &Calibration) -> AxisLine {
    let Some((low, high)) = z_range_mm(turn) else { return AxisLine::default() };
    let length_mm = station_mm.unwrap_or((high - low) / AXIS_PLACES).min(high - low);
    let count = ((high - low) / length_mm + 1e-6).floor().clamp(1.0, 1e5) as usize;
    let z_mm = (0..count).map(|i| low + (i as f64 + 0.5) * length_mm).collect();
    // From the first row of the frames, or from the axis of the lens.
    let mut averager = AxisAverager::new(z_mm, length_mm, calibration.axis_zero(1.0));
    turn.iter().for_each(|(meta, diameters)| averager.add(meta, diameters));
    averager.finish()
}

/// The frames by sections of a length, whole sections only.
fn sections(turn: &Frames, (low, high): (f64, f64), length_mm: f64) -> TurnAverager {
    let count = ((high - low) / length_mm + 1e-6).floor().clamp(1.0, 1e5) as usize;
    let z_mm = (0..count).map(|i| low + (i as f64 + 0.5) * length_mm).collect();
    let mut averager = TurnAverager::new(z_mm, length_mm);
    turn.iter().for_each(|(meta, diameters)| averager.add(meta, diameters));
    averager
}

/// The envelope over the length covered by the frames.
///
/// # Errors
/// Why there is none.
pub(super) fn envelope(turn: &Frames, cutoff_upr: f64) -> Result<Envelope, String> {
    let (low, high) = z_range_mm(turn).ok_or("no frame of the turn could be measured")?;
    let pitch_mm = turn.iter().map(|(_, d)| d.pitch_mm).fold(f64::NAN, f64::max);
    let cutoff = Cutoff::upr(cutoff_upr).map_err(|e| e.to_string())?;
    // From the outer side of the first column to that of the last, without a remainder.
    let range = (low - 0.5 * pitch_mm, high + 0.5 * pitch_mm);
    let count = ((range.1 - range.0) / (ENVELOPE_COLUMNS * pitch_mm)).round().max(1.0);
    sections(turn, range, (range.1 - range.0) / count).envelope(cutoff)
}

/// Form and sizes over the revolution, by stations of a length or of the frames as a whole.
///
/// # Errors
/// A filter out of range; frames that do not form a turn.
pub(super) fn part_form(
    turn: &Frames,
    station_mm: Option<f64>,
    cutoff_upr: f64,
) -> Result<PartForm, MeasureError> {
    let cutoff = Cutoff::upr(cutoff_upr)?;
    let (low, high) = z_range_mm(turn).ok_or(MeasureError::NoFrameOfTurn)?;
    let whole = high - low + 1e-9;
    let form = sections(turn, (low, high), station_mm.unwrap_or(whole).min(whole)).finish(cutoff);
    match form.refused.first() {
        Some((z_mm, why)) if form.sections.is_empty() => {
            Err(MeasureError::NoTurn { z_mm: *z_mm, why: why.clone() })
        }
        _ => Ok(form),
    }
}

/// Common standard uncertainty of the sizes of the section at `z_mm`, mm: that of its columns, to
/// which it is common.
pub(super) fn common_mm(turn: &Frames, z_mm: f64, length_mm: f64) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0.0);
    for (meta, diameters) in turn {
        for (index, column) in diameters.columns.iter().enumerate() {
            if let (Some(d), true) =
                (column.reading.value(), (diameters.z_mm(meta, index) - z_mm).abs() <= 0.5 * length_mm)
            {
                (sum, n) = (sum + d.u_common_mm, n + 1.0);
            }
        }
    }
    (n > 0.0).then(|| sum / n)
}
