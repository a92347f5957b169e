//! Tolerances as a drawing writes them: `25 h6`, `25 0/-0.013`, `24.987..25`.
//!
//! Standard tolerance grades and fundamental deviations after ISO 286-1:2010, tables 1 and 2, shafts f, g, h, js of grades IT5 to
//! IT11 up to 180 mm.

use thiserror::Error;

use super::judgement::Limits;

/// What is no tolerance.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{text:?} is no tolerance: {why}; right would be \"25 h6\", \"25 0/-0.013\" or \"24.987..25\"")]
pub struct ToleranceError {
    text: String,
    why: String,
}

/// Upper ends of the ranges of nominal size, mm.
const RANGES_MM: [f64; 9] = [3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0];
/// Grades IT5 to IT11 in these ranges, µm.
const GRADES_UM: [[f64; 9]; 7] = [
    [4.0, 5.0, 6.0, 8.0, 9.0, 11.0, 13.0, 15.0, 18.0],
    [6.0, 8.0, 9.0, 11.0, 13.0, 16.0, 19.0, 22.0, 25.0],
    [10.0, 12.0, 15.0, 18.0, 21.0, 25.0, 30.0, 35.0, 40.0],
    [14.0, 18.0, 22.0, 27.0, 33.0, 39.0, 46.0, 54.0, 63.0],
    [25.0, 30.0, 36.0, 43.0, 52.0, 62.0, 74.0, 87.0, 100.0],
    [40.0, 48.0, 58.0, 70.0, 84.0, 100.0, 120.0, 140.0, 160.0],
    [60.0, 75.0, 90.0, 110.0, 130.0, 160.0, 190.0, 220.0, 250.0],
];
/// Upper deviations of g and f, µm below the nominal size.
const G_UM: [f64; 9] = [2.0, 4.0, 5.0, 6.0, 7.0, 9.0, 10.0, 12.0, 14.0];
const F_UM: [f64; 9] = [6.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 36.0, 43.0];

/// Limits of size from a tolerance as drawings write it.
///
/// # Errors
/// What is wrong with the text and what would be right.
pub fn parse_tolerance(text: &str) -> Result<Limits, ToleranceError> {
    let wrong = |why: String| ToleranceError { text: text.to_owned(), why };
    let number = |t: &str| {
        t.trim()
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite())
            .ok_or_else(|| wrong(format!("{t:?} is no number")))
    };
    let (lower_mm, upper_mm) = if let Some((lower, upper)) = text.split_once("..") {
        (number(lower)?, number(upper)?)
    } else {
        let (nominal, rest) = text
            .trim()
            .split_once(char::is_whitespace)
            .ok_or_else(|| wrong("a nominal size and what it may deviate by are needed".to_owned()))?;
        let nominal = number(nominal)?;
        let deviations = match rest.split_once('/') {
            Some((a, b)) => (number(a)?, number(b)?),
            None => class_um(nominal, rest.trim()).map(|(a, b)| (1e-3 * a, 1e-3 * b)).map_err(wrong)?,
        };
        (nominal + deviations.0.min(deviations.1), nominal + deviations.0.max(deviations.1))
    };
    if lower_mm < upper_mm && lower_mm > 0.0 {
        Ok(Limits::Tolerance { lower_mm, upper_mm })
    } else {
        Err(wrong(format!("the limits {lower_mm} and {upper_mm} mm leave nothing between them")))
    }
}

/// Lower and upper deviation of a class such as `h6`, µm.
fn class_um(nominal_mm: f64, class: &str) -> Result<(f64, f64), String> {
    let digits = class.find(|c: char| c.is_ascii_digit()).ok_or_else(|| format!("{class:?} has no grade"))?;
    let (letter, grade) = class.split_at(digits);
    let range = RANGES_MM
        .iter()
        .position(|end| nominal_mm <= *end)
        .filter(|_| nominal_mm > 0.0)
        .ok_or_else(|| format!("sizes above 0 up to 180 mm are known, not {nominal_mm}"))?;
    let width = match grade.parse::<usize>() {
        Ok(grade @ 5..=11) => GRADES_UM[grade - 5][range],
        _ => return Err(format!("grades 5 to 11 are known, not {grade:?}")),
    };
    match letter {
        "h" => Ok((-width, 0.0)),
        "g" => Ok((-G_UM[range] - width, -G_UM[range])),
        "f" => Ok((-F_UM[range] - width, -F_UM[range])),
        "js" => Ok((-0.5 * width, 0.5 * width)),
        _ => Err(format!("positions f, g, h and js are known, not {letter:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(text: &str) -> (f64, f64) {
        match parse_tolerance(text) {
            Ok(Limits::Tolerance { lower_mm, upper_mm }) => (lower_mm, upper_mm),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn drawings_are_understood() {
        for (text, lower, upper) in [
            ("25 h6", 24.987, 25.0),
            ("25 g6", 24.980, 24.993),
            ("18 f7", 17.966, 17.984),
            ("50 js9", 49.969, 50.031),
            ("25 0/-0.013", 24.987, 25.0),
            ("24.987..25", 24.987, 25.0),
        ] {
            let (l, u) = limits(text);
            assert!((l - lower).abs() < 1e-9 && (u - upper).abs() < 1e-9, "{text}: {l} {u}");
        }
        for text in ["25", "25 k6", "25 h4", "300 h6", "x h6", "25..24", "25 h", "", "NaN h6", "25 0/0"] {
            assert!(parse_tolerance(text).is_err(), "{text}");
        }
    }
}
