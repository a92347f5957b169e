//! Combinations that readings do not separate, in words.

use super::rank::Inseparable;
use super::unknowns::Group;
use crate::machine::error_name::Component;

impl Inseparable {
    /// Whether an error takes part; else only what sets have besides them.
    pub(crate) fn holds_an_error(&self) -> bool {
        self.groups.iter().any(|group| group.error().is_some())
    }

    /// The combination in words, with what would separate it; `set` is the name of a set.
    pub(crate) fn words(&self, set: &dyn Fn(usize) -> String) -> String {
        let names: Vec<String> = self.groups.iter().map(|group| name(group, set)).collect();
        let dimension = self.dimension.round().max(1.0);
        let what = match names.as_slice() {
            [alone] => format!("{alone} is not determined"),
            _ => format!("{} cannot be separated", names.join(", ")),
        };
        let combinations =
            if dimension > 1.0 { format!(" ({dimension} combinations)") } else { String::new() };
        format!("{what}{combinations}; {}", self.remedy())
    }

    /// Readings that would separate it.
    fn remedy(&self) -> String {
        let angle = self
            .groups
            .iter()
            .filter_map(Group::error)
            .find(|error| matches!(error.component(), Component::About(_)));
        let has_tailstock = self.groups.iter().any(|group| matches!(group, Group::Tailstock(_)));
        let has_sag = self.groups.iter().any(|group| matches!(group, Group::Sag(_)));
        let is_orientation = self.groups.iter().any(|group| matches!(group, Group::Orientation(_)));
        let has_reversal = self.groups.iter().any(|group| matches!(group, Group::Reversal(_)));
        if has_tailstock {
            "read a part without a tailstock, or measure where the tailstock stands (tailstock_u_um)"
                .to_owned()
        } else if has_sag {
            "read a thicker or shorter part, or one at another angle to gravity".to_owned()
        } else if let Some(angle) = angle {
            format!(
                "read {} itself (level, autocollimator, angular optics), or at another lever",
                angle.code()
            )
        } else if is_orientation {
            "read a cylinder or a face to the axis of rotation (datum = \"axis\")".to_owned()
        } else if has_reversal {
            "read in both directions".to_owned()
        } else {
            "read at more positions, or with a smaller uncertainty".to_owned()
        }
    }
}

/// A group in words.
fn name(group: &Group, set: &dyn Fn(usize) -> String) -> String {
    match group {
        Group::Slope(error) => format!("the slope of {}", error.code()),
        Group::Shape(error) => format!("the shape of {}", error.code()),
        Group::Reversal(error) => format!("the reversal of {}", error.code()),
        Group::Orientation(error) => error.code(),
        Group::Datum(k) => format!("the datum of {}", set(*k)),
        Group::Artefact(k) => format!("the straightedge of {}", set(*k)),
        Group::Sag(k) => format!("the sag of the part of {}", set(*k)),
        Group::Tailstock(k) => format!("the tailstock's offset of {}", set(*k)),
    }
}
