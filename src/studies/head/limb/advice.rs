//! What of a limb's shift can be bought: the ratio of the apertures of light and lens.
//!
//! Wide light (S = NA of the light over NA of the lens near 1) averages over the half shadows of
//! many directions: the edge then hardly moves with depth. What the diameter does depends on the
//! window that the gauge fits. Beyond S = 1 the lens no longer sees what is added, and mirrored
//! light comes in.

use serde::Serialize;

use super::shift::LimbHead;
use crate::render::optics::edge_spread::CylinderEdge;

/// Ratios that illuminators have.
const RATIOS: [f64; 7] = [0.3, 0.5, 0.65, 0.75, 0.85, 0.92, 1.0];
/// Half of the distance over which a slope by depth is taken, mm.
const DEPTH_STEP_MM: f64 = 0.2;
/// Depth that a part is held to, mm, and diameters of masters over the part's, by which focus and
/// diameter are made comparable.
const DEPTH_MM: f64 = 0.3;
const SPREAD: [f64; 2] = [0.5, 1.5];
/// A gain below this share is none that a buyer notices.
const WORTH: f64 = 0.8;

/// What focus and diameter do at one ratio of apertures, to a gauge that fits the edge of
/// that light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct FocusOfRatio {
    /// NA of the light over NA of the lens.
    pub coherence_ratio: f64,
    /// Shift by a millimetre of depth towards the camera, µm an edge.
    pub by_depth_um_per_mm: f64,
    /// Shift from half the diameter to one and a half times it, µm an edge.
    pub by_diameter_um: f64,
}

impl FocusOfRatio {
    /// At every ratio whose limbs can be computed and fitted.
    pub(super) fn all(head: &LimbHead) -> Vec<Self> {
        let mut ratios = RATIOS.to_vec();
        let own = head.lens.coherence_ratio;
        if ratios.iter().all(|ratio| (ratio - own).abs() > 1e-6) {
            ratios.push(own);
            ratios.sort_by(f64::total_cmp);
        }
        ratios.into_iter().filter_map(|ratio| Self::at(head, ratio)).collect()
    }

    fn at(head: &LimbHead, coherence_ratio: f64) -> Option<Self> {
        let head = head.with_ratio(coherence_ratio).ok()?;
        let shift = |mm: f64, y_mm: f64| head.shift_um(&head.lens, mm, y_mm).ok();
        let d = head.diameter_mm;
        let by_depth_um_per_mm =
            (shift(d, DEPTH_STEP_MM)? - shift(d, -DEPTH_STEP_MM)?) / (2.0 * DEPTH_STEP_MM);
        let by_diameter_um = shift(SPREAD[1] * d, 0.0)? - shift(SPREAD[0] * d, 0.0)?;
        Some(Self { coherence_ratio, by_depth_um_per_mm, by_diameter_um })
    }

    /// Both together, µm of diameter: ± 0.3 mm of depth, and masters of half or one and a half
    /// times the diameter.
    pub(crate) fn together_um(&self) -> f64 {
        2.0 * (DEPTH_MM * self.by_depth_um_per_mm).hypot(0.5 * self.by_diameter_um)
    }
}

/// The ratio to buy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Advice {
    /// The best of those looked at; none where no limb could be computed.
    pub coherence_ratio: Option<f64>,
    /// In a sentence or two.
    pub words: String,
}

impl Advice {
    /// From what each ratio does.
    pub(super) fn of(lens: &CylinderEdge, by_ratio: &[FocusOfRatio]) -> Self {
        let best = by_ratio.iter().min_by(|a, b| a.together_um().total_cmp(&b.together_um()));
        let own = by_ratio.iter().find(|r| (r.coherence_ratio - lens.coherence_ratio).abs() <= 1e-6);
        let (Some(best), Some(own)) = (best, own) else {
            let words = "No limb at other ratios of apertures could be computed.".to_owned();
            return Self { coherence_ratio: None, words };
        };
        let now = format!(
            "At S = {:.2} (NA of the light over NA of the lens) ±{DEPTH_MM} mm of depth and masters of half to one and a half times \
             the diameter move a diameter by {:.2} µm together.",
            own.coherence_ratio,
            own.together_um()
        );
        let words = if best.together_um() > WORTH * own.together_um() {
            format!("{now} No other ratio is better by a fifth: keep the light.")
        } else {
            format!(
                "{now} With light of NA {:.4} in place of {:.4} (S = {:.2}) it is {:.2} µm: take a wider illuminator for this lens, or close \
                 the lens to the light's aperture.",
                best.coherence_ratio * lens.na,
                own.coherence_ratio * lens.na,
                best.coherence_ratio,
                best.together_um()
            )
        };
        let words = if best.coherence_ratio < own.coherence_ratio {
            words.replace(
                "take a wider illuminator for this lens, or close the lens to the light's aperture",
                "close the illuminator's aperture",
            )
        } else {
            words
        };
        Self { coherence_ratio: Some(best.coherence_ratio), words }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(coherence_ratio: f64, by_depth_um_per_mm: f64, by_diameter_um: f64) -> FocusOfRatio {
        FocusOfRatio { coherence_ratio, by_depth_um_per_mm, by_diameter_um }
    }

    /// The design's slopes at Ø18: 1.8 µm/mm at S 0.5, 0.45 at 0.85, -0.16 at 1.
    #[test]
    fn wide_light_is_advised_where_it_flattens_focus() {
        let all = [at(0.5, 1.8, 0.35), at(0.85, 0.45, 0.12), at(1.0, -0.16, 0.05)];
        let lens = CylinderEdge::default();
        let advice = Advice::of(&lens, &all);
        assert_eq!(advice.coherence_ratio, Some(1.0));
        assert!(
            advice.words.contains("wider illuminator") && advice.words.contains("0.0200"),
            "{}",
            advice.words
        );
        let wide = CylinderEdge { coherence_ratio: 1.0, ..lens.clone() };
        assert!(Advice::of(&wide, &all).words.contains("keep the light"));
        assert_eq!(Advice::of(&lens, &[]).coherence_ratio, None);
    }
}
