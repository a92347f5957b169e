//! Arguments of `measure` on the part itself: which of several shadows, rejection of columns.

use crate::gauge::{Rejection, Which};

/// The part in the frame.
#[derive(Debug, clap::Args)]
pub(crate) struct ChoiceArgs {
    /// Which of several shadows is measured: largest, nearest-centre, outermost (from the first
    /// edge to the last: the walls of a tube) or N, counted from the top. Without it the largest,
    /// across a bright line inside it; two equal shadows that may be one tube are refused.
    #[arg(long, value_name = "WHICH", value_parser = which)]
    which: Option<Which>,
    /// Columns refused: full (by residual, levels, neighbours and what leaves the axis on one
    /// side), by_edge (each edge by itself: keyways, flats, threads, knurls) or off (none, for
    /// comparisons).
    #[arg(long, value_name = "HOW", value_parser = rejection)]
    rejection: Option<Rejection>,
}

fn which(text: &str) -> Result<Which, String> {
    match text {
        "largest" => Ok(Which::Largest),
        "nearest-centre" | "nearest_centre" => Ok(Which::NearestCentre),
        "outermost" => Ok(Which::Outermost),
        _ => match text.parse::<u16>() {
            Ok(number) if number > 0 => Ok(Which::Number(number)),
            _ => Err(
                "right would be largest, nearest-centre, outermost or a number from 1, counted from the top"
                    .to_owned(),
            ),
        },
    }
}

fn rejection(text: &str) -> Result<Rejection, String> {
    match text {
        "full" => Ok(Rejection::Full),
        "by_edge" | "by-edge" => Ok(Rejection::ByEdge),
        "off" => Ok(Rejection::Off),
        _ => Err("right would be full, by_edge or off".to_owned()),
    }
}

impl ChoiceArgs {
    /// The shadow stated.
    pub(crate) fn which(&self) -> Option<Which> {
        self.which
    }

    /// The rejection stated, otherwise the gauge's default.
    pub(crate) fn rejection(&self) -> Rejection {
        self.rejection.unwrap_or_default()
    }

    /// Whether a frame that is refused for its outline is measured again as crests and roots: not
    /// where the rejection is stated.
    pub(crate) fn tries_crests(&self) -> bool {
        self.rejection.is_none()
    }

    /// The option that is given, if any.
    pub(crate) fn given(&self) -> Option<&'static str> {
        [(self.which.is_some(), "--which"), (self.rejection.is_some(), "--rejection")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
    }
}
