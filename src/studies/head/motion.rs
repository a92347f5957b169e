//! What motion during the exposure does to a diameter in use.
//!
//! The edge is smeared over its path: noise grows with the blur, and the fitted edge is displaced
//! where it is not symmetric, at both edges outwards alike. Lobes of amplitude a lose a·(1 −
//! sin(x)/x) of it: the rms of what a diameter then misses of them is √2·a·loss. All are added as
//! one row. An edge that is blurred or deformed beyond what the gauge accepts has no diameter.

use serde::Serialize;

use super::depth::is_accepted;
use super::displacement::displacement;
use super::error::HeadError;
use super::exposure::{amplitude_loss, path_um, phase};
use super::repeatability::Repeatability;
use super::setup::HeadSetup;

/// The row of the budget.
pub(crate) const MOTION: &str = "motion during the exposure";

/// Effect of motion at the speed in use.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct MotionEffect {
    /// Speed, rev/min.
    pub rpm: f64,
    /// Path of the edges in the exposure, µm.
    pub path_um: f64,
    /// Change of the diameter by the smeared edges, µm.
    pub change_um: f64,
    /// Noise of a diameter over that at rest.
    pub noise_factor: f64,
    /// Standard uncertainty that motion adds to the diameter of a frame, µm.
    pub u_um: f64,
    /// Why the gauge measures nothing at this speed.
    pub refused: Option<String>,
}

impl MotionEffect {
    /// Of a head in use, with its repeatability at rest.
    ///
    /// # Errors
    /// Optics whose table cannot be computed.
    pub(super) fn of(head: &HeadSetup, at_rest: &Repeatability) -> Result<Self, HeadError> {
        let turning = &head.turning;
        let path_um = path_um(turning.eccentricity_mm, turning.rpm, turning.exposure_us);
        let still = Self { rpm: turning.rpm, path_um, noise_factor: 1.0, ..Self::default() };
        if turning.rpm == 0.0 {
            return Ok(still);
        }
        let path_px = path_um / head.um_per_px();
        let half_px = head.most_half_px();
        let longest_px = half_px as f64;
        if path_px > longest_px {
            let refused = Some(format!(
                "its edges are smeared over {path_px:.0} px, more than the {longest_px:.0} px beside an edge that the gauge reads"
            ));
            return Ok(Self { refused, ..still });
        }
        let focused = head.optics.at(0.0)?;
        let seen = focused.over_pixels(half_px, 1.0, path_px);
        let Some(found) = displacement(&focused, &seen, half_px, &head.levels) else {
            let refused = Some(format!("its edges, smeared over {path_px:.1} px, are no longer fitted"));
            return Ok(Self { refused, ..still });
        };
        if !is_accepted(head, found.blur_factor, found.residual_rel) {
            let refused = Some(format!(
                "its edges are smeared over {path_px:.1} px: the gauge would find a blur of {:.1} px (at most {:.1}) and leave {:.3} of the \
                 contrast (gauge.max_residual_rel = {})",
                head.room.blur_px * found.blur_factor,
                head.room.blur_range_px[1],
                found.residual_rel,
                head.gauge.max_residual_rel
            ));
            return Ok(Self { refused, ..still });
        }
        let smeared = Repeatability::of(head, path_px)?;
        let noise_factor = (smeared.frame_um / at_rest.frame_um).max(1.0);
        let change_um = 2.0 * found.into_light_px * head.um_per_px();
        let noise_um = at_rest.frame_um * (noise_factor * noise_factor - 1.0).sqrt();
        // A path is somewhere from none to the whole: limits, not a value.
        let change = change_um / 3.0_f64.sqrt();
        let u_um = noise_um.hypot(change).hypot(lobes_um(head));
        Ok(Self { change_um, noise_factor, u_um, ..still })
    }
}

/// Rms of what a diameter misses of the config's lobes.
fn lobes_um(head: &HeadSetup) -> f64 {
    let turning = &head.turning;
    let lost = turning.lobes.iter().map(|lobe| {
        let phase = phase(f64::from(lobe.order_upr), turning.rpm, turning.exposure_us);
        // Odd lobes leave the diameter as it is: both edges move alike.
        let even = f64::from(u8::from(lobe.order_upr % 2 == 0));
        even * std::f64::consts::SQRT_2 * 1e3 * lobe.amplitude_mm * amplitude_loss(phase)
    });
    lost.map(|um| um * um).sum::<f64>().sqrt()
}
