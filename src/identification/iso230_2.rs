//! Positioning by ISO 230-2: accuracy, repeatability, reversal and systematic deviations of one
//! axis.
//!
//! With x_ij the deviation at the position i in the run j, ↑ and ↓ its directions, mean x̄_i and
//! standard deviation s_i (n − 1) a direction:
//!
//! ```text
//! B_i = x̄_i↑ − x̄_i↓                      B = max |B_i|
//! R_i↑ = 4·s_i↑                           R↑ = max R_i↑
//! R_i = max(2s_i↑ + 2s_i↓ + |B_i|, R_i↑, R_i↓)   R = max R_i
//! E↑ = max x̄_i↑ − min x̄_i↑               E = max(x̄_i↑, x̄_i↓) − min(x̄_i↑, x̄_i↓)
//! M = max x̄_i − min x̄_i,                 x̄_i = (x̄_i↑ + x̄_i↓)/2
//! A↑ = max(x̄_i↑ + 2s_i↑) − min(x̄_i↑ − 2s_i↑), A the same over both directions
//! ```

use serde::{Deserialize, Serialize};

use super::equations::positions;
use super::reading::Reading;
use crate::machine::conditions::Direction;

/// Runs in each direction that ISO 230-2 asks for.
const RUNS: usize = 5;

/// One direction; in the unit of the deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OneDirection {
    /// A, accuracy.
    pub a: f64,
    /// R, repeatability.
    pub r: f64,
    /// E, systematic deviation.
    pub e: f64,
}

/// Both directions; in the unit of the deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BothDirections {
    /// A, accuracy.
    pub a: f64,
    /// R, repeatability.
    pub r: f64,
    /// E, systematic deviation.
    pub e: f64,
    /// M, mean bidirectional deviation.
    pub m: f64,
    /// B, largest reversal.
    pub b: f64,
    /// Mean of the reversals with their sign.
    pub b_mean: f64,
}

/// The parameters of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Positioning {
    /// Positions.
    pub positions: usize,
    /// Least number of runs in a direction at any position.
    pub runs: usize,
    /// Where the positions grow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forward: Option<OneDirection>,
    /// Where they fall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backward: Option<OneDirection>,
    /// Of both, where both were read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub both: Option<BothDirections>,
    /// Where the readings fall short of the standard.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub short_of_standard: Vec<String>,
}

/// Mean and standard deviation at a position.
#[derive(Clone, Copy, Debug)]
struct Spread {
    mean: f64,
    s: f64,
    count: usize,
}

/// The parameters of readings of one quantity, times a scale; none where a direction was read once
/// only at a position.
pub(crate) fn positioning(readings: &[Reading], scale: f64) -> Option<Positioning> {
    let at: Vec<f64> = positions(readings);
    let of = |direction: Direction| -> Option<Vec<Spread>> {
        let values = |p: &f64| -> Vec<f64> {
            let here = readings.iter().filter(|r| r.position_mm == *p && r.direction == direction);
            here.map(|r| scale * r.value).collect()
        };
        at.iter().map(|p| spread(&values(p))).collect()
    };
    let (up, down) = (of(Direction::Forward), of(Direction::Backward));
    if up.is_none() && down.is_none() {
        return None;
    }
    let runs = up.iter().chain(&down).flatten().map(|spread| spread.count).min().unwrap_or(0);
    let both = up.as_ref().zip(down.as_ref()).map(|(up, down)| both_directions(up, down));
    let mut short_of_standard = Vec::new();
    if runs < RUNS {
        short_of_standard.push(format!("{runs} runs a direction; ISO 230-2 asks for {RUNS}"));
    }
    if both.is_none() {
        short_of_standard.push("one direction alone; ISO 230-2 asks for both".to_owned());
    }
    Some(Positioning {
        positions: at.len(),
        runs,
        forward: up.as_deref().map(one_direction),
        backward: down.as_deref().map(one_direction),
        both,
        short_of_standard,
    })
}

fn spread(values: &[f64]) -> Option<Spread> {
    let count = values.len();
    if count < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count as f64;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Some(Spread { mean, s: (squares / (count - 1) as f64).sqrt(), count })
}

fn one_direction(spreads: &[Spread]) -> OneDirection {
    OneDirection {
        a: range(spreads.iter().flat_map(|x| [x.mean + 2.0 * x.s, x.mean - 2.0 * x.s])),
        r: spreads.iter().map(|x| 4.0 * x.s).fold(0.0, f64::max),
        e: range(spreads.iter().map(|x| x.mean)),
    }
}

fn both_directions(up: &[Spread], down: &[Spread]) -> BothDirections {
    let reversals: Vec<f64> = up.iter().zip(down).map(|(u, d)| u.mean - d.mean).collect();
    let repeatability = up
        .iter()
        .zip(down)
        .zip(&reversals)
        .map(|((u, d), b)| (2.0 * u.s + 2.0 * d.s + b.abs()).max(4.0 * u.s).max(4.0 * d.s));
    let all = || up.iter().chain(down);
    BothDirections {
        a: range(all().flat_map(|x| [x.mean + 2.0 * x.s, x.mean - 2.0 * x.s])),
        r: repeatability.fold(0.0, f64::max),
        e: range(all().map(|x| x.mean)),
        m: range(up.iter().zip(down).map(|(u, d)| 0.5 * (u.mean + d.mean))),
        b: reversals.iter().map(|b| b.abs()).fold(0.0, f64::max),
        b_mean: reversals.iter().sum::<f64>() / reversals.len().max(1) as f64,
    }
}

/// Largest less smallest value.
fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    high - low
}
