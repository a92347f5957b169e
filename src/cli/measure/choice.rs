//! Arguments of `measure` on the part itself (which of several shadows, rejection of columns), and
//! the warnings on shadows and columns left out.

use serde_json::{Map, Value, json};

use crate::gauge::{FrameEdges, Rejection, ShadowsSeen, Which};
use crate::profile::Reason;

/// The part in the frame.
#[derive(Debug, clap::Args)]
pub struct ChoiceArgs {
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
    pub fn which(&self) -> Option<Which> {
        self.which
    }

    /// The rejection stated, otherwise the gauge's default.
    pub fn rejection(&self) -> Rejection {
        self.rejection.unwrap_or_default()
    }

    /// Whether a frame that is refused for its outline is measured again as crests and roots: not
    /// where the rejection is stated.
    pub fn tries_crests(&self) -> bool {
        self.rejection.is_none()
    }

    /// The option that is given, if any.
    pub fn given(&self) -> Option<&'static str> {
        [(self.which.is_some(), "--which"), (self.rejection.is_some(), "--rejection")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
    }

    /// Warns of other shadows and of light inside the part, and adds them to the frame's JSON
    /// object.
    pub fn report(&self, stem: &str, edges: &FrameEdges, out: &mut Map<String, Value>) {
        let seen = &edges.figures.shadows;
        out.insert("shadows".to_owned(), json!(seen));
        // The flanks of a disc seen end-on are always steep and are not measured.
        let steep = if out.get("max_of") == Some(&json!("disc")) { None } else { steep(edges) };
        let words = [beside(seen, self.which), inside(seen), steep];
        for word in words.into_iter().flatten() {
            tracing::warn!("frame {stem}: {word}");
            add_warning(out, &word);
        }
    }

    /// Whether a shadow as large as the measured one was left out without a request.
    pub fn is_ambiguous(&self, edges: &FrameEdges) -> bool {
        self.which.is_none() && edges.figures.shadows.left_out_px > 0.0
    }
}

/// Adds a warning to a frame's JSON object.
pub fn add_warning(out: &mut Map<String, Value>, word: &str) {
    match out.get_mut("warnings").and_then(Value::as_array_mut) {
        Some(warnings) => warnings.push(json!(word)),
        None => drop(out.insert("warnings".to_owned(), json!([word]))),
    }
}

/// The warning on a shadow that was left out.
fn beside(seen: &ShadowsSeen, which: Option<Which>) -> Option<String> {
    let (row, size) = (seen.left_out_row_px, seen.left_out_px);
    let stated =
        "; --which largest, nearest-centre, outermost or 1, 2 ... (from the top) states which is meant";
    (size > 0.0).then(|| {
        format!(
            "{} shadows lie in the field and number {} from the top was measured; one about {size:.0} px thick at row {row:.0} was left out{}",
            seen.seen,
            seen.measured,
            if which.is_none() { stated } else { "" }
        )
    })
}

/// The warning on light inside the measured shadow.
fn inside(seen: &ShadowsSeen) -> Option<String> {
    (seen.joined > 1).then(|| {
        format!(
            "{} dark strips with about {:.0} px of light between them were measured as one part, from the first edge to the last; \
             --which 1, 2 ... measures one of them",
            seen.joined, seen.light_inside_px
        )
    })
}

/// The warning on flanks that are too steep to be measured.
fn steep(edges: &FrameEdges) -> Option<String> {
    let is_steep =
        |c: &usize| [&edges.top[*c], &edges.bottom[*c]].iter().any(|e| e.reason() == Some(Reason::Steep));
    let steep = (0..edges.columns()).filter(is_steep).count();
    (steep * 20 > edges.columns()).then(|| {
        format!(
            "{steep} of {} columns show flanks steeper than 45° (threads, shoulders, chamfers), which are not measured; crests and \
             cylinders between them are",
            edges.columns()
        )
    })
}
