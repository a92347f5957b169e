//! The table of `measure`, one line a frame, as the frames come.

use std::borrow::Cow;

use serde_json::Value;

use super::statistics::statistics_line;
use super::turn::turn_table;
use super::words::{judged_by, stretch_text};
use crate::gauge::stated::stated;

/// The names of the columns, with that of the average where frames are averaged.
pub(super) fn print_header(averages: bool) {
    let average = if averages { format!(" {:>12} {:>10}", "average mm", "u mm") } else { String::new() };
    say_line!(
        "{:<24} {:>8} {:>8} {:>14} {:>12} {:>10}{average} {:>15} {:<28} flags",
        "frame",
        "columns",
        "valid",
        "max px",
        "max mm",
        "u mm",
        "over columns",
        "judged by"
    );
}

/// A name as a row can hold it: what would end the row, or steer a terminal, is written out.
fn on_one_line(name: &str) -> Cow<'_, str> {
    if !name.contains(char::is_control) {
        return name.into();
    }
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    name.chars().map(shown).collect::<String>().into()
}

/// The row of a frame.
pub(super) fn print_row(f: &Value, averages: bool) {
    let of = |value: &str, u: &str| match (f[value].as_f64(), f[u].as_f64()) {
        (Some(value), Some(u)) => stated(value, u),
        _ => ["-", "-"].map(str::to_owned),
    };
    let [max_px, _] = of("max_diameter_px", "u_max_px");
    let [max_mm, u_mm] = of("max_diameter_mm", "u_max_mm");
    let [average_mm, u_average] = of("average_mm", "u_average_mm");
    let average = if averages { format!(" {average_mm:>12} {u_average:>10}") } else { String::new() };
    let flags = f["flags"].as_object().map_or_else(String::new, |flags| {
        flags.iter().map(|(k, v)| format!("{k}: {v}")).collect::<Vec<_>>().join(", ")
    });
    say_line!(
        "{:<24} {:>8} {:>8} {:>14} {:>12} {:>10}{average} {:>15} {:<28} {flags}",
        on_one_line(f["frame"].as_str().unwrap_or("")),
        f["columns"],
        f["valid"],
        max_px,
        max_mm,
        u_mm,
        stretch_text(f),
        judged_by(f),
    );
}

/// The results over all frames.
pub(super) fn print_series(out: &serde_json::Map<String, Value>, bench: Option<&Value>) {
    if let Some(bench) = bench {
        say_line!("bench: {bench}");
    }
    if let Some(statistics) = out.get("statistics").filter(|s| s["count"].as_u64() > Some(1)) {
        say_line!("{}", statistics_line(statistics));
    }
    if let Some(turn) = out.get("turn") {
        say!("{}", turn_table(turn));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stays_on_its_line() {
        assert_eq!(on_one_line("part 12, Ø8"), "part 12, Ø8");
        assert_eq!(on_one_line("a\nb\u{1b}[31m"), "a\\nb\\u{1b}[31m");
    }
}
