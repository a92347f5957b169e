//! `measure --shape ring`: rings and discs seen end-on.

use serde_json::json;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::calibration::Conditions;
use crate::gauge::ring::{EdgeCircle, RingSettings};
use crate::gauge::stated::stated;
use crate::measurement::ring::NamedRing;

/// Measures a ring in each named frame and prints one JSON document
/// (`{"frames":[{"frame":…,"outer_diameter_px":…}]}`) or one line per ring, in mm as well with a
/// calibration; a frame without a ring has an `error` and does not stop the others.
///
/// # Errors
/// Settings out of range (exit 2); no frame that could be measured (exit 3).
pub(crate) fn run(
    frames: impl IntoIterator<Item = (String, Frame)>,
    settings: &RingSettings,
    calibration: Option<(&Calibration, &Conditions)>,
    as_json: bool,
) -> CommandResult {
    settings.validate().map_err(Failure::refuse)?;
    let (mut rings, mut measured, mut last_error) = (Vec::new(), 0, None);
    for (name, frame) in frames {
        let named = NamedRing::measure(name, &frame.view(), settings, calibration);
        let name = &named.frame;
        match &named.ring {
            Ok(ring) => {
                measured += 1;
                if !as_json {
                    let bore = ring.inner.as_ref().map_or(String::new(), |b| format!(", inner {}", line(b)));
                    say_line!("{name}: outer {}{bore}", line(&ring.outer));
                }
            }
            Err(error) => {
                tracing::warn!("{name}: {error}");
                last_error = Some(format!("{name}: {error}"));
            }
        }
        rings.push(named);
    }
    if as_json {
        say_line!("{}", json!({ "frames": rings }));
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
