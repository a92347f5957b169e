//! Borders of the land: its end below the reference line, and the chipped edge, µm by the distance
//! along the edge from the corner.

use super::noise::rough;
use super::settings::FlankWear;

/// Width of the land, from the reference line of the new edge down; 0 where nothing is worn.
pub(super) fn land_um(wear: &FlankWear, s_um: f64, seed: u64) -> f64 {
    if s_um < 0.0 || s_um > wear.length_um || wear.vb_um + wear.notch_um <= 0.0 {
        return 0.0;
    }
    let t = s_um / wear.length_um;
    let scatter =
        1.0 + wear.scatter * (1.4 * rough(s_um / 220.0, 0.0, seed) + 0.5 * rough(s_um / 30.0, 3.0, seed));
    // the corner's wear fades over a tenth of the length, the notch stands before the far end
    let corner = wear.corner_um * (-t / 0.1).exp();
    let notch = wear.notch_um * (-0.5 * ((t - 0.93) / 0.03).powi(2)).exp();
    let ends = ((1.0 - t) / 0.02).min(1.0) * ((t + 0.01) / 0.02).min(1.0);
    let taper = 1.0 + wear.taper * (2.0 * t - 1.0);
    ((wear.vb_um * taper * scatter + corner + notch) * ends).max(0.0)
}

/// Depth to which the edge above a land has chipped, µm; never more than nine tenths of the land.
pub(super) fn chip_um(wear: &FlankWear, s_um: f64, land_um: f64, seed: u64) -> f64 {
    if wear.chipping_um <= 0.0 || land_um <= 0.0 {
        return 0.0;
    }
    let chip = wear.chipping_um * (2.0 * rough(s_um / 60.0, 9.0, seed) - 0.5).clamp(0.0, 1.0);
    chip.min(0.9 * land_um)
}
