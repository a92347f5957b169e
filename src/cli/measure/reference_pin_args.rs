//! Argument of a fixed pin beside the part.

use crate::measurement::ReferencePin;

/// A fixed pin beside the part.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct ReferencePinArgs {
    /// Corrects every frame by a fixed pin beside the part: FROM-TO,DIAMETER_MM[,U_UM] are the
    /// columns that the pin has to itself, its diameter as it stands there, and the expanded
    /// uncertainty of that (k = 2; 1 µm unless given). The part is measured on the pin's wider
    /// side, whose columns are counted from 0. A frame whose pin is gone or contaminated has no
    /// diameter.
    #[arg(long, value_name = "COLUMNS,DIAMETER_MM")]
    pub(crate) reference_pin: Option<ReferencePin>,
}

impl ReferencePinArgs {
    /// Its name, where it is given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        self.reference_pin.map(|_| "--reference-pin")
    }
}
