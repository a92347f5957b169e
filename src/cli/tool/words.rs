//! The result of `tool compensate` in words.

use crate::tool::{Document, LargestLeft, PieceChange};

fn largest(found: Option<&LargestLeft>) -> String {
    found.map_or("nothing that the tool touches".to_owned(), |l| {
        format!(
            "{:+.3} µm at diameter {:.3} Z {:.3} mm (normal {:.1}°)",
            l.left_um, l.diameter_mm, l.z_mm, l.a_deg
        )
    })
}

fn piece(p: &PieceChange) -> String {
    let mut parts = vec![format!("left {:+.3} to {:+.3} µm", p.least_left_um, p.most_left_um)];
    let mut add = |name: &str, value: Option<f64>| {
        parts.extend(value.map(|v| format!("{name} {v:+.3} µm")));
    };
    add("diameter", p.diameter_um);
    add("Z", p.z_um);
    add("radius", p.radius_um);
    add("form", p.form_um);
    let kind = serde_json::to_value(p.kind).ok().and_then(|v| v.as_str().map(|s| s.replace('_', " ")));
    format!(
        "  {:<11} Z {:>9.3} to {:>9.3}  {}",
        kind.unwrap_or_default(),
        p.z_mm[0],
        p.z_mm[1],
        parts.join(", ")
    )
}

/// Prints the document, and the program where it is not written into a folder.
pub(super) fn print(d: &Document, program: Option<&str>) {
    let flags = if d.flags.is_empty() { String::new() } else { format!(", flagged {}", d.flags.join(", ")) };
    say_line!("nose of {}{flags}: R in the register {:.5} mm", d.image, d.register_mm);
    say_line!("left along the normal with that register, + is material left:");
    say_line!("  normal/°      e/µm     u/µm");
    let step = (d.e.len() / 12).max(1);
    for row in d.e.iter().step_by(step) {
        say_line!("{:10.2} {:9.3} {:8.3}", row.a_deg, row.e_um, row.u_um);
    }
    say_line!("largest of each way:");
    for way in &d.ways {
        match (way.register_mm, &way.refused) {
            (Some(r), _) => {
                say_line!("  {:<14} R {r:.5} mm  {}", way.way.as_str(), largest(way.largest.as_ref()));
            }
            (None, why) => {
                say_line!("  {:<14} refused: {}", way.way.as_str(), why.as_deref().unwrap_or_default());
            }
        }
    }
    say_line!("way {}, piece by piece:", d.way.as_str());
    d.pieces.iter().for_each(|p| say_line!("{}", piece(p)));
    for c in &d.corners {
        say_line!(
            "  corner      Z {:>9.3}                diameter {:+.3} µm, Z {:+.3} µm",
            c.z_mm,
            c.diameter_um,
            c.z_um
        );
    }
    match d.dialect {
        Some(dialect) => {
            say_line!(
                "program for {dialect}, as its blocks command: {}",
                largest(d.program_largest.as_ref())
            );
        }
        None => {
            let why = d.no_program.as_deref().unwrap_or_default();
            say_line!("no program: {why}; path.csv of --out has the path");
        }
    }
    d.cautions.iter().for_each(|caution| say_line!("caution: {caution}"));
    if let Some(text) = program {
        say!("{text}");
    }
}
