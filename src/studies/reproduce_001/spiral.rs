//! The Archimedean spiral on the face: its points, and which lobes it does not show.

use std::f64::consts::{PI, TAU};

use super::inputs::Inputs;
use crate::gauge::form::FormError;
use crate::studies::machine::Spiral;
use crate::studies::reproduction::{Accept, Row};

/// Relative error of the spindle's speed, for a figure: that of a drive without an encoder.
const SPEED: f64 = 1e-3;

pub(super) fn rows(inputs: &Inputs) -> Result<Vec<Row>, FormError> {
    let points = (inputs.spiral_s / inputs.interval_s).round() as usize + 1;
    let rho = |t: f64| ((TAU * t * inputs.turns_per_s + PI) / TAU).abs();
    let (first, last) = (rho(0.0), rho(inputs.spiral_s));
    let rim = 0.5 * inputs.face_mm;
    let mut rows = vec![
        Row::predicted(
            ("spiral.points", "points of the spiral", ""),
            Some(inputs.spiral_points as f64),
            points as f64,
            Accept::Absolute(0.0),
            "0 to 48 s, .1 s apart, both ends",
        ),
        Row::ours(
            ("spiral.first", "radius of the first point, |ρ|", "mm"),
            first,
            "ρ = −(θ + π)/2π at θ = 0",
        ),
        Row::ours(("spiral.last", "radius of the last point", "mm"), last, "after 48 turns, pitch 1 mm"),
        Row::ours(
            ("spiral.share", "share of the face that it covers", ""),
            (last * last - first * first) / (rim * rim),
            "a face of Ø100",
        ),
        Row::ours(
            ("spiral.arc", "distance of the points along the rim", "mm"),
            TAU * last / inputs.points_per_turn() as f64,
            "ten points a turn",
        ),
        Row::ours(
            ("spiral.drift", "angle that .1 % of the spindle's speed adds up to", "°"),
            360.0 * SPEED * inputs.turns_per_s * inputs.spiral_s,
            "points are placed by time alone",
        ),
    ];
    let spiral =
        Spiral { radius_mm: last, z_mm: 0.0, pitch_mm: 1.0, points_per_turn: inputs.points_per_turn() };
    for alias in spiral.aliases()?.into_iter().filter(|alias| [5, 9, 10, 11].contains(&alias.order)) {
        let id = format!("spiral.lobes{}", alias.order);
        let what =
            format!("flatness shown of a face with {} lobes that grow to ±.05 at the rim", alias.order);
        let why = format!("of {:.3} µm; they read as {} lobes", alias.true_um, alias.reads_as);
        let names = (id.as_str(), what.as_str(), "µm");
        rows.push(if [9, 11].contains(&alias.order) {
            let why = format!("{why}, a tilt, which the least-squares plane takes out");
            Row::printed(names, Some(alias.true_um), alias.shown_um, Accept::Relative(0.5), why)
        } else {
            Row::ours(names, alias.shown_um, why)
        });
    }
    Ok(rows)
}
