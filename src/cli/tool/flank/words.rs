//! The result of `tool flank` in words.

use crate::measurement::flank::{FlankDocument, FlankImage};
use crate::tool::wear::Forecast;

/// Prints the document.
pub(super) fn print(document: &FlankDocument) {
    document.images.iter().for_each(one);
    document.forecasts.iter().for_each(of);
}

/// A word as JSON has it.
fn word(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(|s| s.replace('_', " "))).unwrap_or_default()
}

fn one(i: &FlankImage) {
    let with = |name: &str, um: f64, u: Option<f64>| {
        u.map_or_else(|| format!("{name} {um:.1} µm"), |u| format!("{name} {um:.1} µm (u {u:.1})"))
    };
    let mut parts = vec![with("VBB", i.vbb_um, i.u_vbb_um), with("VBBmax", i.vbb_max_um, i.u_vbb_max_um)];
    parts.extend(i.vc_um.map(|um| with("VC", um, i.u_vc_um)));
    parts.extend(i.vn_um.map(|um| with("VN", um, i.u_vn_um)));
    let flags = if i.flags.is_empty() { String::new() } else { format!(", flagged {}", i.flags.join(", ")) };
    say_line!(
        "{}: {}, worn over {:.0} µm, wear {}, {}{flags}",
        i.image,
        parts.join(", "),
        i.worn_length_um,
        word(&i.class),
        word(&i.verdict)
    );
}

fn of(f: &Forecast) {
    let cut = |c: Option<f64>| c.map_or_else(|| "open".to_owned(), |c| format!("{c:.1}"));
    say_line!(
        "grows by {:.3} µm a cut (u {:.3}); {:.0} µm are reached at cut {}, 95 % from {} to {}, of {} readings",
        f.um_per_cut,
        f.u_um_per_cut,
        f.limit_um,
        cut(f.cut),
        cut(f.from_cut),
        cut(f.to_cut),
        f.readings
    );
}
