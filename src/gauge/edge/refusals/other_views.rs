//! What other options would show in a frame that shows no part: upright, light and shadow
//! exchanged, a smaller part, or these together.

use crate::gauge::edge::image::part_localisation::PartSearch;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::limit::limits;
use crate::gauge::settings::GaugeSettings;

limits! {
    /// When another view of a frame is recommended.
    OtherViewLimits = "other_views";
    /// Least size, px, of a shadow that is looked for in order to report the size of the largest
    /// one: two edges with a blur of 1 px either side, three standard deviations each.
    smallest_px: f64 = 6.0;
    /// Share of the columns in which another view of the frame must show a part: most of them.
    recommended: f64 = 0.5;
}

/// A view of a frame by other options than those given.
#[derive(Clone, Copy, Debug)]
struct View {
    upright: bool,
    exchanged: bool,
    smaller: bool,
}

/// All views, those of fewer options first; a smaller part only where a part of the size wanted is
/// nowhere.
const VIEWS: [View; 7] = [
    view(false, false, true),
    view(true, false, false),
    view(false, true, false),
    view(true, true, false),
    view(true, false, true),
    view(false, true, true),
    view(true, true, true),
];

const fn view(upright: bool, exchanged: bool, smaller: bool) -> View {
    View { upright, exchanged, smaller }
}

/// The first view that shows a part, and the options that give it; `None` where none does.
pub(crate) fn recommended<T: Sample>(plane: &Plane<'_, T>, settings: &GaugeSettings) -> Option<String> {
    VIEWS.iter().find_map(|view| view.words(plane, settings))
}

impl View {
    fn words<T: Sample>(&self, given: &Plane<'_, T>, settings: &GaugeSettings) -> Option<String> {
        let limits = OtherViewLimits::get();
        let least = settings.min_diameter_px;
        let turned = if self.upright { given.transposed() } else { *given };
        let plane = if self.exchanged { turned.inverted() } else { turned };
        let min_diameter_px = if self.smaller { limits.smallest_px } else { least };
        if self.smaller && least <= limits.smallest_px {
            return None;
        }
        let settings = GaugeSettings { min_diameter_px, ..settings.clone() };
        let width = PartSearch::found(&plane, &settings).filter(|f| f.share >= limits.recommended)?.width_px;
        if self.smaller && width >= least {
            return None;
        }
        let (mut with, mut without) = (Vec::new(), Vec::new());
        if self.upright {
            // A frame read by columns is one that was turned before.
            let list = if given.row_stride < given.column_stride { &mut without } else { &mut with };
            list.push("--vertical".to_owned());
        }
        if self.exchanged {
            let list = if given.sign < 0.0 { &mut without } else { &mut with };
            list.push("--bright-on-dark".to_owned());
        }
        if self.smaller {
            with.push(format!(
                "--min-diameter-px {:.0} (gauge.min_diameter_px)",
                (0.7 * width).floor().max(4.0)
            ));
        }
        let part = if plane.sign > 0.0 { "a shadow" } else { "a lit part" };
        let stands = if self.upright { " that runs the other way" } else { "" };
        let size = match self.smaller {
            true => format!(", where the least size taken for a part is {least} px"),
            false => String::new(),
        };
        let without =
            if without.is_empty() { String::new() } else { format!("without {}", without.join(" ")) };
        let options = [with.join(" "), without].into_iter().filter(|o| !o.is_empty()).collect::<Vec<_>>();
        Some(format!(
            "{part} about {width:.0} px across{stands} stands before the other level{size}: try {}",
            options.join(", ")
        ))
    }
}
