//! What an identified machine says of its head: the place by its own tables, with their u, and the
//! errors that count as zero.

use super::{GEOMETRY, config, identify, sets, truth};
use crate::identification::head_geometry::{of_identified, unread};
use crate::machine::{Conditions, ErrorName};

#[test]
fn the_place_of_the_head_is_that_of_the_tables_with_their_uncertainty() {
    let text = format!(
        "name = \"lathe\"\nidentify = [\"eyz\"]\n[[readings]]\ninstrument = \"laser\"\nline_mm = [0.0, 250.0, -80.0]\nu_um = 0.1\n\
         plan = {{ from_mm = -60.0, to_mm = 140.0, positions = 41, quantities = [\"eyz\"] }}\n[machine]{GEOMETRY}"
    );
    let config = config(&text);
    let truth = truth("[errors.eyz]\nfourier = [{ wavelength_mm = 110.0, amplitude_um = 4.0 }]\n");
    let found = identify(&config, &sets(&config, &truth, 3)).unwrap().file;
    let geometry = of_identified(&found).unwrap();
    let eyz = found.errors.iter().find(|error| error.error == "EYZ").unwrap();
    let motion = found.machine.motion().unwrap();
    let (mut largest, mut least_u) = (0.0_f64, f64::MAX);
    for (position, u) in eyz.position_mm.iter().zip(&eyz.u) {
        // the head stands 40 mm beside the tool
        let Some(place) = geometry.at(position + 40.0) else { continue };
        let own = motion.value(ErrorName::Eyz, [0.0, *position], &Conditions::default());
        assert!((place.axis_y_mm + own).abs() < 0.05e-3, "{position}: {} {own}", place.axis_y_mm);
        assert!(
            (1e3 * place.u_axis_y_mm - u).abs() < 0.1 * u + 1e-3,
            "{position}: {} {u}",
            place.u_axis_y_mm
        );
        largest = largest.max(own.abs());
        least_u = least_u.min(*u);
    }
    assert!(largest > 3e-3 && least_u > 0.0, "{largest} {least_u}");
    // pitch and the spindle's orientation move the head along Y, too, and were not read
    let unread = unread(&found);
    assert!(unread.contains(&"EAZ".to_owned()) && unread.contains(&"A0C".to_owned()), "{unread:?}");
    assert!(!unread.contains(&"EXZ".to_owned()) && !unread.contains(&"EYZ".to_owned()), "{unread:?}");
}
