//! `nc part.stl`: a model of a part to a program from the bar, with a picture.

use std::path::PathBuf;

use super::args::{Form, NcArgs};
use super::machine_data::in_file;
use crate::cli::failure::Failure;
use crate::cli::input_output::{ConfigText, MoveRow, csv_text};
use crate::cli::run::model::ModelTool;
use crate::files::OutputFile;
use crate::nc::{NcSettings, ToolMove};
use crate::nose::NoseProfile;
use crate::part_program::{PartPlan, PartProgram, PartProgramError, Reason};
use crate::report::plot::{Chart, Mark, Series};
use crate::stl::TurnedPart;
use crate::tool::{OutOfReach, ToolError, read_nose};

/// Largest sagitta of a drawn arc, mm.
const SAGITTA_MM: f64 = 0.005;

/// The text of the program; the picture is written, what is left goes to the log.
///
/// # Errors
/// Exit 2 for a model, a tool, machine data or a path that are refused; 3 for files that cannot be
/// read or written.
pub(super) fn program(args: &NcArgs) -> Result<(String, Vec<PathBuf>), Failure> {
    refuse_others(args)?;
    let (model, tool) = (args.model.part(&args.run)?, args.model.tool()?);
    let nose = nose(args, &tool)?;
    let settings = machine(args, &tool)?;
    let plan = PartPlan {
        outline: &model.outline,
        from_z_mm: args.bar.from_z.unwrap_or(0.0),
        stock_mm: args.model.stock_mm()?,
        tool: &tool.tool,
        nose: nose.as_ref(),
        way: args.model.way(),
        machine: &settings,
        cutting: args.model.cutting(&tool)?,
        cuts: args.bar.cuts(&tool),
    };
    let written = plan.write(args.dialect).map_err(|e| refused(args, &tool, e))?;
    report(&model, &written);
    let inputs: Vec<PathBuf> =
        [args.run.clone()].into_iter().chain(args.machine.clone()).chain(args.model.files()).collect();
    if let Some(path) = &args.bar.svg {
        let svg = picture(&written, plan.stock_mm).map_err(Failure::fail)?;
        OutputFile::claim(path, inputs.clone())?.write(svg.as_bytes())?;
    }
    if let Some(path) = &args.bar.moves {
        let kind = |m: &ToolMove| match (m.rapid, m.roughing) {
            (true, _) => "rapid",
            (false, true) => "roughing",
            (false, false) => "finishing",
        };
        let rows: Vec<MoveRow> = written.moves.iter().map(|m| MoveRow::new(m.from, m.to, kind(m))).collect();
        OutputFile::claim(path, inputs.clone())?.write(&csv_text(&rows)?)?;
    }
    Ok((written.text, inputs))
}

fn refuse_others(args: &NcArgs) -> Result<(), Failure> {
    let given = [
        ("--state", args.state.is_some()),
        ("--pass", args.pass.is_some()),
        ("--air", args.air),
        ("--scan", args.scan),
        ("--dry-run", args.dry_run),
        ("--form", args.form != Form::Knots),
    ];
    if args.model.has_size_tolerance() {
        let why =
            "--size-tolerance is what `run part.stl` judges by; a program has no word for it: leave it out";
        return Err(Failure::refuse(why));
    }
    match given.iter().find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((name, _)) => Err(Failure::refuse(format!(
            "{name} belongs to a run or a job, not to a model of a part: leave it out"
        ))),
    }
}

fn nose(args: &NcArgs, tool: &ModelTool) -> Result<Option<NoseProfile>, Failure> {
    let Some(path) = args.model.nose() else { return Ok(None) };
    let text = std::fs::read_to_string(path)
        .map_err(|e| Failure::fail(format!("{}: cannot be read: {e}", path.display())))?;
    let geometry = tool.tool.geometry().map_err(|e| tool.text.refuse_at(e))?;
    let nose = read_nose(&text, None, tool.tool.image, &geometry);
    nose.map(|n| Some(n.profile)).map_err(|e| Failure::refuse(format!("{}: {e}", path.display())))
}

/// The machine's data with the tool's nose.
fn machine(args: &NcArgs, tool: &ModelTool) -> Result<NcSettings, Failure> {
    let with = |s: NcSettings| NcSettings {
        nose_radius_mm: Some(tool.tool.nose_radius_mm),
        part_number: args.part.unwrap_or(s.part_number),
        ..s
    };
    let Some(path) = &args.machine else { return Ok(with(NcSettings::default())) };
    let file = ConfigText::read(path)?;
    let settings = with(file.parse()?);
    settings.validate().map_err(|error| in_file(&file, error.into()))?;
    Ok(settings)
}

/// An error of the tool at its file, another one at the model.
fn refused(args: &NcArgs, tool: &ModelTool, error: PartProgramError) -> Failure {
    match error {
        PartProgramError::Tool(ToolError::Setting(at)) => tool.text.refuse_at(at),
        PartProgramError::Tool(e @ ToolError::Register { .. }) => tool.text.refuse(e),
        PartProgramError::Nc(e) if args.machine.is_none() => Failure::refuse(format!(
            "{e}; what stands around the part was assumed: state it by --machine FILE"
        )),
        other => Failure::refuse(format!("{}: {other}", args.run.display())),
    }
}

/// What was read, and what stays, on the log.
fn report(model: &TurnedPart, written: &PartProgram) {
    tracing::info!(
        "{} facets, {:.3} mm long, {} turns on the outside, scatter {:.3} µm, outline within {:.3} µm, {} lines and arcs",
        model.facets,
        model.length_mm,
        model.turns,
        1e3 * model.scatter_mm,
        1e3 * model.departure_mm,
        model.outline.pieces.len()
    );
    let (at, along) = (model.axis.point, model.axis.direction);
    tracing::info!(
        "axis from ({:.4}, {:.4}, {:.4}) mm of the model along ({:.6}, {:.6}, {:.6})",
        at.x,
        at.y,
        at.z,
        along.x,
        along.y,
        along.z
    );
    for recess in &model.recesses {
        tracing::warn!(
            "not turned: a bore or recess of Ø{:.3} mm, {:.3} mm deep, in the end face at Z {:.3} of the part",
            recess.diameter_mm,
            recess.depth_mm,
            recess.z_mm
        );
    }
    report_left(written);
    if let Some(largest) = written.largest {
        tracing::info!(
            "largest remainder on what the tool reaches: {:+.3} µm at Ø{:.3} Z {:.3} mm",
            largest.left_um,
            largest.diameter_mm,
            largest.z_mm
        );
    }
}

/// Where material stays, and why, on the log.
fn report_left(written: &PartProgram) {
    for place in &written.places {
        let why = match place.reason {
            Reason::Grip => "in the grip",
            Reason::OutOfReach => "out of the tool's reach",
            Reason::NoseRadius => "a corner or an arc that the nose rounds",
        };
        tracing::warn!(
            "left, {why}: Z {:.2} to {:.2} mm, up to {:.3} mm of radius, {:.1} mm³",
            place.z_mm[0],
            place.z_mm[1],
            place.most_mm,
            place.volume_mm3
        );
    }
    for out in written.left_out() {
        let (low, high) = out.z_mm;
        match out.why {
            OutOfReach::NoseRadius => {
                tracing::warn!(
                    "a concave arc of {:.3} mm at Z {low:.3} to {high:.3} mm is below the nose's radius",
                    out.value
                );
            }
            OutOfReach::TrailingEdge | OutOfReach::LeadingEdge => {
                tracing::warn!(
                    "normals down to {:.1}° at Z {low:.3} to {high:.3} mm are beyond the tool's edges",
                    out.value.to_degrees()
                );
            }
        }
    }
}

/// Part, bar, path and what is left in the plane of the axis.
fn picture(written: &PartProgram, stock_mm: f64) -> Result<String, String> {
    let part =
        written.placed.drawn.pieces.iter().flat_map(|p| p.points(SAGITTA_MM)).map(|p| (p.y, p.x)).collect();
    let end = written.left_mm.last().map_or(0.0, |p| p.0);
    let start = written.left_mm.first().map_or(0.0, |p| p.0);
    let bar = vec![(start, 0.5 * stock_mm), (end, 0.5 * stock_mm), (end, 0.0)];
    let path = |roughing: bool| {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for m in written.moves.iter().filter(|m| m.roughing == roughing && !m.rapid) {
            if points.last() != Some(&(m.from.y, m.from.x)) {
                // a gap where the tool went on in rapid
                points.extend([(f64::NAN, f64::NAN), (m.from.y, m.from.x)]);
            }
            points.push((m.to.y, m.to.x));
        }
        points
    };
    let chart = Chart {
        title: "Part, path of the programmed point, and what is left".into(),
        x_label: "Z / mm".into(),
        y_label: "distance from the axis / mm".into(),
        series: vec![
            Series::new("bar", Mark::Faint, 3, bar),
            Series::new("roughing", Mark::Faint, 2, path(true)),
            Series::new("finishing", Mark::Dashed, 1, path(false)),
            Series::new("left", Mark::Line, 4, written.left_mm.clone()),
            Series::new("part", Mark::Line, 0, part),
        ],
        equal_axes: true,
        ..Chart::default()
    };
    chart.to_svg()
}
