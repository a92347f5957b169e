//! Heads side by side.

use serde::Serialize;

use super::budget::frames_of_masters;
use super::error::HeadError;
use super::figures::{HeadFigures, figures};
use super::settings::HeadSettings;
use super::setup::HeadSetup;
use super::verdict::HeadVerdict;
use crate::render::Renderer;

/// Heads side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeadStudy {
    /// A head each.
    pub heads: Vec<HeadFigures>,
    /// Which of them has the smaller U in use.
    pub verdict: HeadVerdict,
}

/// Frames that [`study`] renders.
pub(crate) fn frames_in_all(heads: &[HeadSetup], settings: &HeadSettings) -> u64 {
    heads.iter().map(|head| frames_of_masters(head) + settings.frames as u64).sum()
}

/// Figures of every head; `done` is called with the number of frames rendered.
///
/// # Errors
/// The name of the head and why it has none.
pub(crate) fn study(
    heads: &[HeadSetup],
    settings: &HeadSettings,
    renderer: &Renderer,
    done: &dyn Fn(u64),
) -> Result<HeadStudy, (String, HeadError)> {
    let speeds: Vec<f64> = heads.iter().map(|head| head.turning.rpm).collect();
    let of = |head: &HeadSetup| {
        figures(head, settings, &speeds, (renderer, done)).map_err(|e| (head.config.file.clone(), e))
    };
    let heads = heads.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let verdict = HeadVerdict::of(&heads);
    Ok(HeadStudy { heads, verdict })
}
