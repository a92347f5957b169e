//! `measure --shape ring`: rings and discs seen end-on.

use serde_json::{Map, json};

use super::document::{Lines, Whole};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::calibration::Conditions;
use crate::gauge::ring::{EdgeCircle, RingSettings};
use crate::gauge::stated::stated;
use crate::measurement::ring::NamedRing;
use crate::source::Arrival;

/// How rings are printed as JSON.
pub(crate) enum Json {
    /// One document.
    Whole(Whole),
    /// A line a frame.
    Lines(Lines),
}

impl Json {
    /// One document.
    pub(crate) fn whole() -> Self {
        Self::Whole(Whole::default())
    }

    /// A line a frame.
    pub(crate) fn lines() -> Self {
        Self::Lines(Lines::default())
    }

    fn frame(&mut self, ring: &NamedRing, arrival: &Arrival) {
        match self {
            Self::Whole(whole) => whole.frame(&json!(ring)),
            Self::Lines(lines) => lines.frame(json!(ring), arrival),
        }
    }

    fn end(self) {
        if let Self::Whole(mut whole) = self {
            whole.end(&Map::new());
        }
    }
}

/// Measures a ring in each named frame as it comes and prints one JSON document
/// (`{"frames":[{"frame":…,"outer_diameter_px":…}]}`) or one line per ring, in mm as well with a
/// calibration; a frame without a ring has an `error` and does not stop the others.
///
/// # Errors
/// Settings out of range (exit 2); no frame that could be measured (exit 3).
pub(crate) fn run(
    frames: impl IntoIterator<Item = (Arrival, Frame)>,
    settings: &RingSettings,
    calibration: Option<(&Calibration, &Conditions)>,
    mut json: Option<Json>,
) -> CommandResult {
    settings.validate().map_err(Failure::refuse)?;
    let (mut measured, mut last_error) = (0, None);
    for (arrival, frame) in frames {
        let named = NamedRing::measure(arrival.stem.clone(), &frame.view(), settings, calibration);
        let name = &named.frame;
        match &named.ring {
            Ok(ring) => {
                measured += 1;
                if json.is_none() {
                    let bore = ring.inner.as_ref().map_or(String::new(), |b| format!(", inner {}", line(b)));
                    say_line!("{name}: outer {}{bore}", line(&ring.outer));
                }
            }
            Err(error) => {
                tracing::warn!("{name}: {error}");
                last_error = Some(format!("{name}: {error}"));
            }
        }
        if let Some(json) = &mut json {
            json.frame(&named, &arrival);
        }
    }
    if let Some(json) = json {
        json.end();
    }
    match (measured, last_error) {
        (0, Some(error)) => Err(Failure::fail(format!("no frame could be measured; the last said: {error}"))),
        (0, None) => Err(Failure::fail("there is no frame to be measured")),
        _ => Ok(Outcome::Done),
    }
}

fn line(edge: &EdgeCircle) -> String {
    let (unit, diameter, u, roundness) = match edge.mm {
        Some(mm) => ("mm", mm.diameter_mm, mm.u_diameter_mm, mm.roundness_mm),
        None => ("px", edge.diameter_px, edge.u_diameter_px, edge.roundness_px),
    };
    let [diameter, u_text] = stated(diameter, u);
    format!("{diameter} {unit} (u {u_text}), roundness {} {unit}", stated(roundness, u)[0])
}
