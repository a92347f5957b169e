//! What `study machine --models` prints.

use crate::studies::machine::Models;

/// Prints the curves and the working space by every model.
pub(super) fn print(models: &Models) {
    say_line!(
        "{} positions of either slide, noise {} µm; errors between the samples against the truth, rms, µm",
        models.positions,
        models.noise_um
    );
    say_line!(
        "{:<30} {:<22} {:>8} {:>9} {:>22}",
        "curve",
        "model",
        "range",
        "held out",
        "at samples left out"
    );
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |um| format!("{um:.4}"));
    for row in &models.curves {
        let least = if row.is_least { "  least" } else { "" };
        say_line!(
            "{:<30} {:<22} {:8.4} {:>9} {:>22}{least}",
            row.curve,
            row.model,
            row.range_um,
            number(row.held_out_um),
            number(row.left_out_um)
        );
    }
    say_line!("\nworking space, constants taken out");
    say_line!(
        "{:<38} {:<30} {:>9} {:>7} {:>9} {:>7}",
        "model",
        "given",
        "along X",
        "factor",
        "along Z",
        "factor"
    );
    for row in &models.fields {
        say_line!(
            "{:<38} {:<30} {:9.4} {:7.2} {:9.4} {:7.2}",
            row.model,
            row.given,
            row.e_x_um,
            row.x_factor,
            row.e_z_um,
            row.z_factor
        );
    }
}
