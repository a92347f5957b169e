//! `study tool`: the four workpieces of the paper on tool wear (Zhang, Lu, Xia, Zhang, Zhu 2025)
//! cut by a worn nose that is measured in an image, before and after every way to compensate.
//!
//! The nose is that of a rendered insert (`noses`): measured from its frame by the program's own
//! mode and by the paper's, which gives two radii. A program is made for what was measured, and the
//! true nose cuts by it (`cut`): the surface is the envelope of that nose. `workpieces` are the
//! four outlines and the sizes on that surface; `frames` measures them through frames and the
//! gauge, of the first three by lines and arcs (`seen`). `scatter` moves the slides by the lathe's
//! repeatability. One more workpiece is a variant of [`Workpiece`]; one more way to compensate a
//! variant of [`Tried`].
//!
//! In: an insert, cone angles, a seed, the cameras' jobs. Out: [`Study`].

mod cut;
mod error;
mod frames;
mod noses;
mod result;
mod scatter;
mod seen;
mod settings;
mod workpieces;

use glam::DVec2;

pub(crate) use cut::Tried;
pub(crate) use error::WornToolError;
pub(crate) use frames::Jobs;
pub(crate) use noses::{Noses, curves};
pub(crate) use result::{OfPaper, Row, Study};
pub(crate) use settings::Settings;
pub(crate) use workpieces::Workpiece;

use self::cut::Cut;
use self::frames::Frames;
use self::scatter::Scatter;
use super::reproduce_004::{Inputs, PrintedPart};
use crate::render::Renderer;

/// Programs that [`run`] cuts in all.
pub(crate) fn programs_in_all() -> usize {
    Workpiece::ALL.len() * Tried::ALL.len()
}

/// Cuts the workpieces of the settings by every program, before the cameras of `jobs`; `step` is
/// called after each program.
///
/// # Errors
/// A nose that cannot be rendered or measured, a job or a renderer that fails. A program that is
/// refused is a row with its reason.
pub(crate) fn run(
    settings: &Settings,
    jobs: &Jobs,
    renderer: &Renderer,
    step: &dyn Fn(),
) -> Result<(Study, Noses), WornToolError> {
    settings.check()?;
    let noses = Noses::new(settings)?;
    let paper = Inputs::default();
    let scatter = Scatter::new(paper.repeatability_mm, settings.seed);
    let mut frames = Frames::new(jobs, renderer);
    let mut rows = Vec::new();
    for workpiece in settings.workpieces.iter().copied() {
        let mut first: Option<Row> = None;
        for program in Tried::ALL {
            let cut = Cut { noses: &noses, workpiece, program, cone_deg: settings.cone_deg };
            let row = row(&cut, &mut frames, (&scatter, settings.pieces))?;
            let row = against(row, first.as_ref());
            first.get_or_insert_with(|| row.clone());
            rows.push(row);
            step();
        }
    }
    let of_paper = |part: &PrintedPart| OfPaper {
        before_um: 1e3 * PrintedPart::mean_mm(&part.before_mm),
        after_um: 1e3 * PrintedPart::mean_mm(&part.after_mm),
        reduction_percent: part.rate_percent,
    };
    let study = Study {
        nose: noses.found(),
        cone_deg: settings.cone_deg,
        slides_um: scatter.slides_um(),
        pieces: settings.pieces,
        paper: paper.parts.each_ref().map(of_paper),
        rows,
    };
    Ok((study, noses))
}

/// A workpiece by one program, without and with scatter.
fn row(
    cut: &Cut<'_>,
    frames: &mut Frames<'_>,
    (scatter, pieces): (&Scatter, u32),
) -> Result<Row, WornToolError> {
    let mut row = Row {
        workpiece: cut.workpiece.number(),
        program: cut.program,
        register_mm: cut.register_used_mm(),
        measured_by: "frames",
        error_um: None,
        u_um: None,
        reduction_percent: None,
        scattered_um: None,
        scattered_reduction_percent: None,
        refused: None,
        true_error_um: None,
        calipers_left_out: None,
    };
    let exact = |_: usize| DVec2::ZERO;
    match cut.error_um(&exact).and_then(|on_surface| Ok((on_surface, frames.measure(cut, &exact)?))) {
        Ok((on_surface, measured)) => {
            (row.error_um, row.u_um) = (Some(measured.error_um), Some(measured.u_um));
            row.true_error_um = Some(on_surface);
            row.calipers_left_out = measured.left_out;
        }
        Err(e) if e.is_of_program() => {
            row.refused = Some(e.to_string());
            return Ok(row);
        }
        Err(e) => return Err(e),
    }
    let mut sum = 0.0;
    for piece in 0..pieces {
        let place = |element| [cut.workpiece.number(), cut.program as usize, piece as usize, element];
        sum += frames.measure(cut, &|element| scatter.slides_mm(place(element)))?.error_um.abs();
    }
    row.scattered_um = Some(sum / f64::from(pieces));
    Ok(row)
}

/// The row with its reductions against the first program's.
fn against(mut row: Row, first: Option<&Row>) -> Row {
    let reduced = |before: Option<f64>, after: Option<f64>| {
        let (before, after) = (before?.abs(), after?.abs());
        (before > 0.0).then(|| 100.0 * (before - after) / before)
    };
    if let Some(first) = first {
        row.reduction_percent = reduced(first.error_um, row.error_um);
        row.scattered_reduction_percent = reduced(first.scattered_um, row.scattered_um);
    }
    row
}
