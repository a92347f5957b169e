//! The results over all frames of a series.

use serde::{Serialize, Serializer};

use super::by_key::by_key;
use super::error::MeasureError;
use super::inspector::{Inspector, worse};
use super::settled_part::SettledPart;
use super::statistics::Statistics;
use super::turn::{SectionUncertainty, TurnForm};
use super::turn_frames::LeftOut;
use super::turn_sizes::judge_turn;
use crate::conformity::Judgement;
use crate::gauge::calibration::Conditions;
use crate::gauge::diameter::sections::{PartForm, SectionForm};

/// The results over all frames. Its JSON has the keys of the document beside `frames`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Statistics of the mean diameters; `None` without a calibration or without a diameter.
    pub statistics: Option<Statistics>,
    /// Form and sizes over the revolution, where the frames are one.
    pub turn: Option<TurnForm>,
    /// The conditions of the part; with a calibration.
    pub conditions: Option<Conditions>,
    /// What is to be looked at.
    pub warnings: Vec<String>,
    /// The worst judgement of all; `None` where nothing was to be judged.
    pub judgement: Option<Judgement>,
}

#[derive(Serialize)]
struct Keys<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    statistics: Option<&'a Statistics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    turn: Option<&'a TurnForm>,
    #[serde(skip_serializing_if = "Option::is_none")]
    conditions: Option<Conditions>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    warnings: &'a [String],
}

impl Serialize for Series {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (statistics, turn) = (self.statistics.as_ref(), self.turn.as_ref());
        let keys = Keys { statistics, turn, conditions: self.conditions, warnings: &self.warnings };
        by_key(&keys, serializer)
    }
}

impl Series {
    /// Whether every value is proven good; true where nothing is judged.
    pub fn all_good(&self) -> bool {
        self.judgement.is_none_or(|judgement| judgement == Judgement::GO)
    }

    /// Of the frames that an inspector followed.
    ///
    /// # Errors
    /// Frames that do not form a turn.
    pub(super) fn of(mut inspector: Inspector) -> Result<Self, MeasureError> {
        let limits_mm = inspector.judge.map(|(_, limits)| limits);
        let statistics = inspector.so_far.means.statistics(limits_mm, inspector.settings.parts);
        let mut warnings = Vec::new();
        let mut turn = None;
        if inspector.settings.turn {
            let (form, left_out) = turn_form(&mut inspector)?;
            warnings.extend(left_out);
            warnings.extend(jumps_word(inspector.turn.jumps_left_out));
            warnings.extend(scatter_word(&form.form));
            let judged = form.judged.as_ref().map(super::turn_sizes::TurnJudged::judgement);
            inspector.so_far.worst =
                judged.map_or(inspector.so_far.worst, |judged| worse(inspector.so_far.worst, judged));
            turn = Some(form);
        } else {
            // Over a revolution the means differ by the form error of the part.
            warnings.extend(inspector.so_far.means.word());
        }
        if let Some(word) = inspector.settled.as_ref().and_then(SettledPart::word) {
            inspector.so_far.worst = worse(inspector.so_far.worst, Judgement::HI);
            warnings.push(word);
        }
        let judgement = inspector.judge.map(|_| inspector.so_far.worst);
        Ok(Self { statistics, turn, conditions: Some(inspector.conditions), warnings, judgement })
    }
}

/// Form, sizes and axis over the revolution, and warnings on frames that are not in them.
fn turn_form(inspector: &mut Inspector) -> Result<(TurnForm, Vec<String>), MeasureError> {
    let frames = std::mem::take(&mut inspector.turn.frames);
    let turn = frames.finish(&inspector.asked_of_turn()?)?;
    let common = |z_mm: f64| turn.common_mm(z_mm);
    let none = || Err("it was not asked for".to_owned());
    let envelope = turn.envelope.clone().unwrap_or_else(none);
    let judged = inspector.judge.zip(inspector.settings.tolerance).and_then(|((judge, _), tolerance)| {
        judge_turn(&tolerance, judge.rule(), &turn.form, &envelope, &common)
    });
    let of = |s: &SectionForm| SectionUncertainty { z_mm: s.z_mm, u_mm: common(s.z_mm) };
    let form = TurnForm {
        common: turn.form.sections.iter().map(of).collect(),
        coverage: turn.angles.coverage(),
        sweep_deg: turn.angles.sweep_deg,
        implausible: std::mem::take(&mut inspector.turn.jumps),
        axis: turn.axis,
        judged,
        form: turn.form,
    };
    Ok((form, left_out_words(turn.left_out)))
}

fn left_out_words(LeftOut { elsewhere, beyond }: LeftOut) -> Vec<String> {
    let of_elsewhere = format!(
        "{elsewhere} frames stand elsewhere along the part than the long series before them and are left out of the form over the turn: \
         measure each place by itself, or give fewer frames of each"
    );
    let of_beyond = format!(
        "the last {beyond} frames of the scan along the part are left out of the form over the turn: their columns are more than are kept \
         (2 GiB); measure the part in pieces, or a smaller window of it"
    );
    let words = [(elsewhere, of_elsewhere), (beyond, of_beyond)];
    words.into_iter().filter(|(frames, _)| *frames > 0).map(|(_, word)| word).collect()
}

fn jumps_word(left_out: usize) -> Option<String> {
    let word = || {
        format!(
            "{left_out} further diameters contradict earlier turns and are listed with their frames alone"
        )
    };
    (left_out > 0).then(word)
}

/// A warning where sections scatter by more than their form and their u explain.
fn scatter_word(form: &PartForm) -> Option<String> {
    let beyond: Vec<&SectionForm> =
        form.sections.iter().filter(|s| s.scatter.is_some_and(|test| test.beyond_u)).collect();
    let (worst, test) = beyond
        .iter()
        .filter_map(|s| s.scatter.map(|test| (s, test)))
        .max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()))?;
    Some(format!(
        "{} of {} sections scatter over the turn by more than their form and their u explain, at z = {:.3} mm {:.1} times (chi2 {:.4} at {} degrees \
         of freedom, limit {:.4} at a false alarm of {} %): vibration, drift, dirt or texture; u is taken from the scatter",
        beyond.len(),
        form.sections.len(),
        worst.z_mm,
        test.ratio(),
        test.chi2,
        test.freedom,
        test.chi2_limit,
        100.0 * test.false_alarm_probability
    ))
}
