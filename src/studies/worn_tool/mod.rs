//! `study tool`: the four workpieces of the paper on tool wear (Zhang, Lu, Xia, Zhang, Zhu 2025)
//! cut by a worn nose that is measured in an image, before and after every way to compensate.
//!
//! The nose is that of a rendered insert (`noses`): measured from its frame by the program's own
//! mode and by the paper's, which gives two radii. A program is made for what was measured, and the
//! true nose cuts by it (`cut`): the surface is the envelope of that nose. `workpieces` are the
//! four outlines and what is measured of each; `frames` measures the diameter of the fourth through
//! frames and the gauge. `scatter` moves the slides by the lathe's repeatability. One more
//! workpiece is a variant of [`Workpiece`]; one more way to compensate a variant of [`Tried`].
//!
//! In: an insert, cone angles, a seed, a job for the fourth workpiece. Out: [`Study`].

mod cut;
mod error;
mod frames;
mod noses;
mod scatter;
mod workpieces;

use glam::DVec2;
use serde::Serialize;

pub(crate) use cut::Tried;
pub(crate) use error::WornToolError;
pub(crate) use noses::{NoseFound, Noses, curves};
pub(crate) use workpieces::Workpiece;

use self::cut::Cut;
use self::frames::Frames;
use self::scatter::Scatter;
use super::reproduce_004::{Inputs, PrintedPart};
use crate::job::Job;
use crate::render::Renderer;
use crate::render::insert::InsertSettings;
use crate::setting::within;

/// What is studied.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Insert and camera; its direction is made that of the tool.
    pub insert: InsertSettings,
    /// Half angles of the cones of workpieces 1 and 2, degrees: the paper does not give them.
    pub cone_deg: [f64; 2],
    /// Workpieces of each kind with the lathe's scatter.
    pub pieces: u32,
    /// Seed.
    pub seed: u64,
}

/// What the paper has of a workpiece, mm and %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct OfPaper {
    /// Mean error before compensation, µm.
    pub before_um: f64,
    /// After it, µm.
    pub after_um: f64,
    /// Reduction as printed, %.
    pub reduction_percent: f64,
}

/// A workpiece cut by one program.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Row {
    /// Number of the workpiece in the paper.
    pub workpiece: usize,
    /// The program.
    pub program: Tried,
    /// Nose radius in the control's register, mm.
    pub register_mm: Option<f64>,
    /// `frames`: by the gauge; `envelope`: by the surface itself.
    pub measured_by: &'static str,
    /// Error of the size on a lathe that repeats exactly, µm.
    pub error_um: Option<f64>,
    /// Its standard uncertainty by the gauge, µm.
    pub u_um: Option<f64>,
    /// Reduction of the size of the error against the first program, %.
    pub reduction_percent: Option<f64>,
    /// Mean size of the errors of several workpieces with the lathe's scatter, µm.
    pub scattered_um: Option<f64>,
    /// Its reduction against the first program, %.
    pub scattered_reduction_percent: Option<f64>,
    /// Why there is none.
    pub refused: Option<String>,
}

/// Everything that was found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Study {
    /// The nose by both modes beside the truth.
    pub nose: NoseFound,
    /// Half angles of the cones, degrees.
    pub cone_deg: [f64; 2],
    /// Standard deviation of the slides along X (radial) and Z, µm.
    pub slides_um: [f64; 2],
    /// Workpieces of each kind with scatter.
    pub pieces: u32,
    /// The paper's figures, a workpiece each.
    pub paper: [OfPaper; 4],
    /// A row a workpiece and program.
    pub rows: Vec<Row>,
}

impl Settings {
    /// Checks insert and angles.
    ///
    /// # Errors
    /// The first value out of range.
    pub(crate) fn check(&self) -> Result<(), WornToolError> {
        self.insert.check()?;
        let right = "a half angle of 5 to 80 degrees, from the axis to the cone's side";
        self.cone_deg.iter().try_for_each(|deg| within("--cone-deg", *deg, 5.0, 80.0, right))?;
        within("--pieces", f64::from(self.pieces), 1.0, 1000.0, "1 to 1000 workpieces")?;
        let right = "a corner of 35 to 80 degrees (ISO 1832), which a holder of 93 degrees carries";
        within("nose.epsilon_deg", self.insert.nose.epsilon_deg, 35.0, 80.0, right)?;
        let right = "a nose of .1 to 2 mm: the workpieces have arcs of 5 mm and faces of 5 mm";
        within("nose.radius_mm", self.insert.nose.radius_mm, 0.1, 2.0, right)?;
        Ok(())
    }
}

/// Programs that [`run`] cuts in all.
pub(crate) fn programs_in_all() -> usize {
    Workpiece::ALL.len() * Tried::ALL.len()
}

/// Cuts every workpiece by every program. `job` is the fourth workpiece before its camera, `step`
/// is called after each program.
///
/// # Errors
/// A nose that cannot be rendered or measured, a job or a renderer that fails. A program that is
/// refused is a row with its reason.
pub(crate) fn run(
    settings: &Settings,
    job: &Job,
    renderer: &Renderer,
    step: &dyn Fn(),
) -> Result<(Study, Noses), WornToolError> {
    settings.check()?;
    let noses = Noses::new(settings)?;
    let paper = Inputs::default();
    let scatter = Scatter::new(paper.repeatability_mm, settings.seed);
    let mut frames = Frames::new(job, renderer);
    let mut rows = Vec::new();
    for workpiece in Workpiece::ALL {
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
    let in_frames = cut.workpiece == Workpiece::BatchDiameter;
    let mut row = Row {
        workpiece: cut.workpiece.number(),
        program: cut.program,
        register_mm: cut.register_mm(),
        measured_by: if in_frames { "frames" } else { "envelope" },
        error_um: None,
        u_um: None,
        reduction_percent: None,
        scattered_um: None,
        scattered_reduction_percent: None,
        refused: None,
    };
    let mut size = |slides: &dyn Fn(usize) -> DVec2| -> Result<(f64, Option<f64>), WornToolError> {
        if in_frames { frames.error_um(cut, slides(0)) } else { Ok((cut.error_um(slides)?, None)) }
    };
    match size(&|_| DVec2::ZERO) {
        Ok((error, u)) => (row.error_um, row.u_um) = (Some(error), u),
        Err(e) if e.is_of_program() => {
            row.refused = Some(e.to_string());
            return Ok(row);
        }
        Err(e) => return Err(e),
    }
    let mut sum = 0.0;
    for piece in 0..pieces {
        sum += size(&|element| scatter.slides_mm(cut, piece, element))?.0.abs();
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
