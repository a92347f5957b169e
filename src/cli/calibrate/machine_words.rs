//! What `calibrate machine` prints.

use crate::identification::IdentifiedMachine;
use crate::identification::identified::PositioningRow;

/// Prints the errors, the models, what readings leave open and ISO 230-2.
pub(super) fn print(file: &IdentifiedMachine) {
    let range = &file.range;
    say_line!(
        "{}: X {} to {} mm, Z {} to {} mm, {} °C; model {}",
        file.name,
        range.x_mm[0],
        range.x_mm[1],
        range.z_mm[0],
        range.z_mm[1],
        file.temperature_c,
        file.model
    );
    say_line!("{:<5} {:>10} {:>10} {:>10} {:<5} {}", "", "least", "largest", "largest u", "unit", "what");
    for error in &file.errors {
        let (low, high) = error
            .value
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let u = error.u.iter().copied().fold(0.0, f64::max);
        let (code, unit, meaning) = (&error.error, &error.unit, &error.meaning);
        say_line!("{code:<5} {low:10.3} {high:10.3} {u:10.3} {unit:<5} {meaning}");
    }
    print_models(file);
    for found in &file.positioning {
        print_positioning(found);
    }
    for row in &file.spindle {
        let (low, high) = row
            .motion_um
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        say_line!(
            "EXC {}: {:.3} µm peak to valley, u {:.3} µm; {}",
            row.set,
            high - low,
            row.u_um,
            row.not_separated
        );
    }
    for words in &file.rank.inseparable {
        say_line!("not separated: {words}");
    }
}

fn print_models(file: &IdentifiedMachine) {
    for model in &file.models {
        let held = model.held_out_um.map_or_else(
            || "no part can be left out (two cylinders or two faces are needed)".to_owned(),
            |um| format!("{um:.4} µm rms on parts that took no part"),
        );
        let chosen = if model.is_chosen { ", written" } else { "" };
        say_line!(
            "model {:<10} {held}; {:.2} times u at positions that took no part{chosen}",
            model.model,
            model.held_out_by_u
        );
    }
    let rank = &file.rank;
    say_line!(
        "Birge ratio {:.3}; {} unknowns, {} of them determined by the readings (rank {})",
        file.birge_ratio,
        rank.unknowns,
        rank.determined,
        rank.rank
    );
    for set in &file.sets {
        let left = set.residual_by_u.map_or_else(
            || "not used by this model".to_owned(),
            |by_u| format!("residuals {by_u:.2} times u"),
        );
        say_line!("{:<24} {:>5} {:<15} to {}; {left}", set.set, set.readings, set.instrument, set.datum);
    }
}

fn print_positioning(found: &PositioningRow) {
    let p = &found.parameters;
    if let Some(b) = p.both {
        say_line!(
            "ISO 230-2 {} {}: A {:.3}, R {:.3}, E {:.3}, M {:.3}, B {:.3} {} ({} positions, {} runs)",
            found.error,
            found.set,
            b.a,
            b.r,
            b.e,
            b.m,
            b.b,
            found.unit,
            p.positions,
            p.runs
        );
    }
    for (name, of) in [("forward", p.forward), ("backward", p.backward)] {
        if let Some(d) = of {
            say_line!(
                "ISO 230-2 {} {name}: A {:.3}, R {:.3}, E {:.3} {}",
                found.error,
                d.a,
                d.r,
                d.e,
                found.unit
            );
        }
    }
    for short in &p.short_of_standard {
        say_line!("  {short}");
    }
}
