//! What readings do not separate is named, and reversals separate.

use super::{GEOMETRY, config, identified, slope_urad, truth};
use crate::inside::machine::close;
use crate::machine::ErrorName;

fn with(identify: &str, readings: &str) -> crate::identification::IdentificationConfig {
    config(&format!(
        "name = \"lathe\"\nhead = \"telecentric\"\nidentify = [{identify}]\n{readings}[machine]{GEOMETRY}"
    ))
}

const CYLINDER: &str = "[[readings]]\ninstrument = \"cylinder\"\nradius_mm = 12.5\nu_um = 0.01\nplan = { from_mm = -60.0, to_mm = 140.0, positions = 21, quantities = [\"radius\"] }\n";
const AUTOCOLLIMATOR: &str = "[[readings]]\ninstrument = \"autocollimator\"\nu_urad = 0.05\nplan = { from_mm = -60.0, to_mm = 140.0, positions = 21, quantities = [\"ebz\"] }\n";
const MIDLINE: &str = "[[readings]]\ninstrument = \"midline\"\nu_um = 0.01\nu_urad = 0.05\npart = { diameter_mm = 20.0, length_mm = 160.0, held = \"HELD\", gravity_x = -1.0 }\nplan = { from_mm = 0.0, to_mm = 150.0, positions = 31, quantities = [\"midline\", \"slope\"] }\n";

const BENT: &str = "b0c_urad = -20.0\n[errors.exz]\nfourier = [{ wavelength_mm = 90.0, amplitude_um = 1.5 }]\n[errors.ebz]\npolynomial = { coefficients_urad = [0.0, 8.0, 4.0] }\n";

#[test]
fn a_cylinder_alone_does_not_separate_straightness_and_yaw() {
    let alone = identified(&with("\"exz\", \"ebz\", \"b0c\"", CYLINDER), BENT, 1);
    let words = alone.file.rank.inseparable.join("\n");
    assert!(alone.file.rank.determined < alone.file.rank.unknowns);
    for word in ["EXZ", "EBZ", "cannot be separated", "read EBZ itself", "combinations"] {
        assert!(words.contains(word), "'{word}' is missing in: {words}");
    }
    let both =
        identified(&with("\"exz\", \"ebz\", \"b0c\"", &format!("{CYLINDER}{AUTOCOLLIMATOR}")), BENT, 1);
    assert_eq!(both.file.rank.inseparable, [""; 0]);
    // u of EXZ says the same: of the class of the machine before, of the readings after
    let u = |found: &crate::identification::Identification| {
        found.file.errors.iter().find(|e| e.error == "EXZ").unwrap().u[120]
    };
    assert!(u(&alone) > 5.0 * u(&both), "{} {}", u(&alone), u(&both));
}

#[test]
fn a_probe_on_the_tools_side_sees_nothing_of_what_it_cut() {
    let own = CYLINDER.replace("u_um", "read = \"same_side\"\nu_um").replace("0.05\n", "0.0\n");
    let mut config = with("\"exz\", \"b0c\"", &own);
    config.machine.tip_above_axis_mm = 0.0;
    config.machine.head_mm[1] = 120.0;
    let mut machine = truth(BENT);
    machine.tip_above_axis_mm = 0.0;
    machine.head_mm[1] = 120.0;
    let sets = super::sets(&config, &machine, 1);
    let error = crate::identification::identify(&config, &sets).map(|found| found.file.rank);
    // every coefficient cancels: both are named
    let words = match error {
        Ok(rank) => rank.inseparable.join("\n"),
        Err(error) => error.to_string(),
    };
    assert!(words.contains("EXZ"), "{words}");
    let far = CYLINDER.replace("u_um", "read = \"opposite_side\"\nu_um");
    let far = identified(&with("\"exz\", \"b0c\"", &far), "b0c_urad = -20.0\n", 1);
    close(far.file.errors.iter().find(|e| e.error == "B0C").unwrap().value[0], -20.0, 0.1, "B0C");
}

#[test]
fn a_midline_shows_the_carriage_and_names_sag_and_tailstock() {
    let free = MIDLINE.replace("HELD", "overhung");
    let found = identified(&with("\"exz\", \"ebz\", \"b0c\"", &free), BENT, 5);
    let of = |code: &str| found.file.errors.iter().find(|e| e.error == code).unwrap();
    let b0c = -20.0 - slope_urad(&truth(BENT), ErrorName::Exz, found.file.range.z_mm);
    close(of("B0C").value[0], b0c, 4.0 * of("B0C").u[0].max(0.1), "B0C");
    let rise = of("EBZ").value[240] - of("EBZ").value[0];
    let slide = |z: f64| (2.0 * z - 80.0) / 200.0;
    let yaw = |z: f64| 8.0 * slide(z) + 4.0 * slide(z) * slide(z);
    let [from, to] = found.file.range.z_mm;
    close(rise, yaw(to) - yaw(from), 0.5, "EBZ");
    let tied = MIDLINE.replace("HELD", "centres");
    let words =
        identified(&with("\"exz\", \"ebz\", \"b0c\"", &tied), BENT, 5).file.rank.inseparable.join("\n");
    for word in ["B0C", "tailstock", "cannot be separated", "without a tailstock"] {
        assert!(words.contains(word), "'{word}' is missing in: {words}");
    }
}

#[test]
fn a_straightedge_turned_over_is_free_of_its_own_shape() {
    let edge = "[[readings]]\ninstrument = \"straightedge\"\nline_mm = [0.0, 0.0, 0.0]\nu_um = 0.005\nplan = { from_mm = -60.0, to_mm = 140.0, positions = 41, quantities = [\"exz\"] }\n";
    let bow = "[errors.exz]\npolynomial = { coefficients_um = [0.0, 0.0, 0.8] }\n";
    let found = identified(&with("\"exz\"", edge), bow, 7);
    assert_eq!(found.file.rank.inseparable, [""; 0]);
    let exz = &found.file.errors[0];
    let bends = exz.value[0] - 2.0 * exz.value[120] + exz.value[240];
    // 0.8·s²: 1.6 over the second difference; the straightedge's own bow of 2 µm is not in it
    close(bends, 1.6, 0.03, "bow");
}
