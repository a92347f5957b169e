//! The words of SINUMERIK programs: not the control's ISO mode but its own language.
//!
//! - Numbers after X and Z are `X=25.5`, `Z=10`: no decimal point is due, because none is taken in
//!   increments. `DIAMON`, `G710`, `G95`, `G54`: diameters, mm, feed per revolution, the part's
//!   zero.
//! - The change position is fixed point 1 of the machine axes (`G75 FP=1 X1=0`, MD30600), which no
//!   offset moves.
//! - Variables are R parameters, kept at power-off; `STOPRE` stands before one is read or written,
//!   because blocks are prepared ahead of the motion.
//! - An alarm is `MSG("…")` and a loop about `M0`: a start alone does not go on.
//!
//! From the maker's programming guides as commonly used, not checked on a control.

/// Variable with part and pass of the program that ran last: a common variable, kept at power-off
/// on a Fanuc.
pub(super) const RAN_LAST: u32 = 820;

/// The R parameter that stands for [`RAN_LAST`]: controls have R0 to R99 unless more are set up
/// (MD28050), and the last ones are seldom used.
pub(super) const RAN_LAST_R: u32 = 98;

/// Variable with the number of the stop that a scan program triggered last.
pub(super) const STOP: u32 = 838;

/// The R parameter that stands for [`STOP`].
pub(super) const STOP_R: u32 = 97;

/// A variable of the ISO dialects as an R parameter.
pub(super) fn variable(number: u32) -> String {
    let number = match number {
        RAN_LAST => RAN_LAST_R,
        STOP => STOP_R,
        other => other,
    };
    format!("R{number}")
}

/// A value as it stands after `=` or a comparison: no point at its end, `#` variables as R
/// parameters.
pub(super) fn value(text: &str) -> String {
    match text.strip_prefix('#').and_then(|digits| digits.parse().ok()) {
        Some(number) => variable(number),
        None => text.strip_suffix('.').unwrap_or(text).to_owned(),
    }
}

/// The comparison of custom macro B in this language.
fn comparison(op: &str) -> &'static str {
    match op {
        "EQ" => "==",
        "NE" => "<>",
        "GT" => ">",
        "LT" => "<",
        "GE" => ">=",
        _ => "<=",
    }
}

/// Stops for good where `left op right` holds.
pub(super) fn alarm_if(label: u32, (left, negated, right): (&str, &str, &str), text: &str) -> Vec<String> {
    let condition = format!("{} {} {}", value(left), comparison(negated), value(right));
    vec![
        "STOPRE".to_owned(),
        format!("IF {condition} GOTOF GO_ON_{label}"),
        format!("MSG(\"{text}\")"),
        format!("STOP_{label}:"),
        "M0".to_owned(),
        format!("GOTOB STOP_{label}"),
        format!("GO_ON_{label}:"),
    ]
}
