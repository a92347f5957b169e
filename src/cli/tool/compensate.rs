//! `shadowgauge tool compensate`: a measured nose and a part to e(a), remainders and a program.

use std::path::PathBuf;

use glam::DVec2;

use super::{pictures, words};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, MoveRow, StudyFolder, csv_text, json_text};
use crate::config;
use crate::nc::{
    Bore, ContourProgram, Dialect, Direction, NcError, NcSettings, NoseRegister, Workpiece, WrittenContour,
};
use crate::nose::{Feed, NoseProfile, ToolGeometry};
use crate::outline::{Outline, Piece, Side};
use crate::setting::SettingError;
use crate::tool::{
    Compensated, Compensator, Document, Element, LargestLeft, Measured, OutlineFile, Remainder, Setting,
    Tool, ToolError, ToolFile, Way, WayResult, measured, read_nose, remainders,
};

/// What a program changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum WayArgument {
    /// Nothing: the drawing's contour, the register as it is.
    Register,
    /// The register radius that leaves least on this part.
    BestRegister,
    /// The contour, by what is left; the register as it is.
    EditedContour,
    /// The path: that of the measured nose, without the control's compensation.
    Path,
}

impl WayArgument {
    fn way(self) -> Way {
        match self {
            Self::Register => Way::Register,
            Self::BestRegister => Way::BestRegister,
            Self::EditedContour => Way::EditedContour,
            Self::Path => Way::Path,
        }
    }
}

/// Arguments of `tool compensate`.
#[derive(Debug, clap::Args)]
pub(crate) struct CompensateArgs {
    /// The nose as measured: a JSON document with the `support` of its hull (docs/tool.md).
    #[arg(long, value_name = "FILE")]
    nose: PathBuf,
    /// The image of the nose, where the file has several.
    #[arg(long, value_name = "NAME")]
    image: Option<String>,
    /// A TOML file with the tool: its angles, nominal nose and tip direction (`schema tool`).
    #[arg(long, value_name = "FILE")]
    tool: PathBuf,
    /// A TOML file with the part's outline and cutting data (`schema outline`).
    #[arg(long, value_name = "FILE")]
    part: PathBuf,
    /// What the program changes.
    #[arg(long, value_enum, default_value = "path")]
    way: WayArgument,
    /// The control of the program: fanuc, linuxcnc, gsk or sinumerik.
    #[arg(long, value_parser = dialect, default_value = "linuxcnc")]
    dialect: Dialect,
    /// A TOML file with the machine's data (docs/nc.md).
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write program, tables and pictures into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn dialect(word: &str) -> Result<Dialect, String> {
    word.parse()
}

/// What the files hold, checked one by one.
struct Inputs {
    nose_text: String,
    tool_text: ConfigText,
    part_text: ConfigText,
    tool: ToolFile,
    geometry: ToolGeometry,
    part: OutlineFile,
    outline: Outline,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for files that are refused, a part that the tool cannot cut, a program that collides; 3
/// for a nose file that cannot be read and outputs that cannot be written.
pub(crate) fn run(args: &CompensateArgs) -> CommandResult {
    let inputs = Inputs::read(args)?;
    let in_nose = |e: ToolError| Failure::refuse(format!("{}: {e}", args.nose.display()));
    let nose = read_nose(&inputs.nose_text, args.image.as_deref(), inputs.tool.image, &inputs.geometry)
        .map_err(in_nose)?;
    let compensator = inputs.compensator(&nose.profile, args.dialect)?;
    let folder = StudyFolder::claim(args.out.as_deref())?;

    let tool = Tool::new(&nose.profile);
    let way = args.way.way();
    let tried = Way::ALL.map(|way| (way, measured(&compensator, &tool, way)));
    let (done, left) = chosen(&tried, way).map_err(|e| inputs.refused(e))?;
    let (written, no_program) = match written(args, &inputs, &compensator, done)? {
        Ok(written) => (Some(written), None),
        Err(why) => (None, Some(why)),
    };
    let gauge = compensator.setting.gauge_point();
    let by_program = written.as_ref().map(|written| {
        let moves: Vec<_> = written.moves.iter().map(|m| (m.0 - gauge, m.1 - gauge)).collect();
        remainders(&inputs.outline, &done.path, &moves, &tool)
    });
    let results = tried.iter().map(|(way, result)| way_result(*way, result)).collect();
    let final_left = by_program.as_ref().unwrap_or(left);
    let mut document =
        Document::new(&nose, &compensator, results, (way, final_left), inputs.geometry.range_rad());
    document.dialect = written.as_ref().map(|_| args.dialect.as_str());
    document.no_program = no_program;
    document.cautions = inputs.cautions();
    document.program_largest = by_program.as_ref().and_then(|left| LargestLeft::of(left));

    let program = written.as_ref().map(|written| written.text.as_str());
    StudyFolder::fill(folder, |folder| {
        folder.write("compensation.json", (json_text(&document)? + "\n").as_bytes())?;
        write(folder, &inputs.outline, &tried, (done, written.as_ref()))
    })?;
    if args.json {
        say_line!("{}", json_text(&document)?);
    } else {
        words::print(&document, program.filter(|_| args.out.is_none()));
    }
    Ok(Outcome::Done)
}

/// Every way with its result.
type Tried = [(Way, Result<Measured, ToolError>); 4];

/// The result of the way that is written.
fn chosen(tried: &Tried, way: Way) -> Result<&Measured, &ToolError> {
    let [first, rest @ ..] = tried;
    rest.iter().find(|t| t.0 == way).unwrap_or(first).1.as_ref()
}

/// Tables, program and pictures.
fn write(
    folder: &StudyFolder,
    outline: &Outline,
    tried: &Tried,
    (done, written): (&Compensated, Option<&WrittenContour>),
) -> Result<(), Failure> {
    let left: Vec<(Way, &[Remainder])> =
        tried.iter().filter_map(|(way, found)| Some((*way, found.as_ref().ok()?.1.as_slice()))).collect();
    folder.write("left.csv", &csv_text(&left_rows(&left))?)?;
    folder.write("path.csv", &csv_text(&path_rows(&done.programmed))?)?;
    if let Some(WrittenContour { text, moves }) = written {
        folder.write("program.nc", text.as_bytes())?;
        let rows: Vec<MoveRow> = moves.iter().map(|m| MoveRow::new(m.0, m.1, "finishing")).collect();
        folder.write("moves.csv", &csv_text(&rows)?)?;
    }
    let svg = pictures::left(&left, outline).map_err(Failure::fail)?;
    folder.write("left.svg", svg.as_bytes())?;
    let svg = pictures::path(outline, done).map_err(Failure::fail)?;
    folder.write("path.svg", svg.as_bytes())
}

/// The program of a way, or why none is written.
fn written(
    args: &CompensateArgs,
    inputs: &Inputs,
    compensator: &Compensator<'_>,
    done: &Compensated,
) -> Result<Result<WrittenContour, String>, Failure> {
    let settings = machine(args, inputs)?;
    if inputs.geometry.side == Side::Internal && settings.boring_bar.is_none() {
        let why = "that of a bore needs boring_bar in the machine's data (--machine FILE): what goes into the bore with the \
                   nose";
        return Ok(Err(why.to_owned()));
    }
    let (setting, radius_mm) = (&compensator.setting, done.register_mm);
    let register = (done.way != Way::Path).then_some(NoseRegister { radius_mm, tip: setting.tip });
    let gauge = setting.gauge_point();
    let nose: Vec<DVec2> = setting.nose.outline().into_iter().map(|p| p - gauge).collect();
    program(args, inputs, (&settings, &done.programmed), (register, &nose)).map(Ok)
}

fn way_result(way: Way, result: &Result<Measured, ToolError>) -> WayResult {
    match result {
        Ok((done, left)) => WayResult {
            way,
            register_mm: Some(done.register_mm),
            largest: LargestLeft::of(left),
            refused: None,
        },
        Err(e) => WayResult { way, register_mm: None, largest: None, refused: Some(e.to_string()) },
    }
}

impl Inputs {
    fn read(args: &CompensateArgs) -> Result<Self, Failure> {
        let nose_text = std::fs::read_to_string(&args.nose)
            .map_err(|e| Failure::fail(format!("{}: cannot be read: {e}", args.nose.display())))?;
        let (tool_text, part_text) = (ConfigText::read(&args.tool)?, ConfigText::read(&args.part)?);
        let tool: ToolFile = tool_text.parse()?;
        let geometry = tool.geometry().map_err(|e| tool_text.refuse_at(e))?;
        let part: OutlineFile = part_text.parse()?;
        let outline = part.outline().map_err(|e| part_text.refuse_at(e))?;
        if part.side != tool.side {
            let found = format!("{:?}", part.side).to_lowercase();
            let right = format!("the side of the tool in {}", tool_text.name);
            return Err(part_text.refuse_at(SettingError::of("side", found, right)));
        }
        if let Some(measured) = tool.measured_pass {
            let depth = part.depth_mm.map(|depth| ("depth_mm", depth));
            measured.allows(&part.cutting, depth).map_err(|e| part_text.refuse_at(e))?;
        }
        Ok(Self { nose_text, tool_text, part_text, tool, geometry, part, outline })
    }

    /// What was not compared of this cut and the pass after which the nose was measured.
    fn cautions(&self) -> Vec<String> {
        let (tool, part) = (&self.tool_text.name, &self.part_text.name);
        let compared = match self.tool.measured_pass {
            None => Some(format!("measured_pass is not stated in {tool}: speed, feed and depth are")),
            Some(pass) if pass.depth_mm.is_none() => {
                Some(format!("measured_pass.depth_mm is not stated in {tool}: the depth is"))
            }
            Some(_) if self.part.depth_mm.is_none() => {
                Some(format!("depth_mm is not stated in {part}: the depth is"))
            }
            Some(_) => None,
        };
        let of_pass =
            "not compared with the pass after which the nose was measured, as a correction presumes";
        compared.map(|what| format!("{what} {of_pass}")).into_iter().collect()
    }

    /// What is bored; none of a shaft.
    fn bore(&self) -> Option<Bore<'_>> {
        (self.geometry.side == Side::Internal).then(|| Bore {
            hole_mm: self.part.hole_mm(&self.outline),
            outer_mm: self.part.stock_diameter_mm,
            outline: &self.outline,
        })
    }

    /// The part and the nose as the control of `dialect` takes it.
    fn compensator<'a>(
        &'a self,
        nose: &'a NoseProfile,
        dialect: Dialect,
    ) -> Result<Compensator<'a>, Failure> {
        let setting =
            Setting::new(nose, &self.geometry, &self.tool.stated()).map_err(|e| self.refused(&e))?;
        let compensator = Compensator {
            outline: &self.outline,
            setting,
            register_mm: self.tool.register_mm.unwrap_or(self.geometry.nose_radius_mm),
            register_range_mm: dialect.nose_register_mm(),
            increment_mm: 10f64.powi(-(dialect.x_decimals() as i32)),
        };
        compensator.check(&self.geometry).map_err(|e| self.refused(&e))?;
        Ok(compensator)
    }

    /// An error of the tool at its key, another one at the part.
    fn refused(&self, error: &ToolError) -> Failure {
        match error {
            ToolError::Setting(at) => self.tool_text.refuse_at(at.clone()),
            ToolError::Register { .. } => self.tool_text.refuse(error),
            other => self.part_text.refuse(other),
        }
    }
}

/// The program of a way, replayed.
fn program(
    args: &CompensateArgs,
    inputs: &Inputs,
    (settings, programmed): (&NcSettings, &[Element]),
    (register, nose): (Option<NoseRegister>, &[DVec2]),
) -> Result<WrittenContour, Failure> {
    let largest = 2.0 * inputs.outline.largest_radius_mm();
    let stock = inputs.part.stock_diameter_mm.unwrap_or(largest);
    let piece = Workpiece {
        direction: match inputs.geometry.feed {
            Feed::TowardsChuck => Direction::TowardsChuck,
            Feed::TowardsTailstock => Direction::TowardsTailstock,
        },
        ..Workpiece::new(inputs.outline.z_mm().1, stock, stock)
    };
    let about = match (args.way, register) {
        (WayArgument::Path, _) | (_, None) => {
            "path of the measured nose, no compensation by the control".to_owned()
        }
        (WayArgument::EditedContour, Some(r)) => {
            format!("contour edited for the measured nose, register R {:.5}", r.radius_mm)
        }
        (_, Some(r)) => format!("contour of the drawing, register R {:.5}", r.radius_mm),
    };
    let pieces: Vec<Piece> = programmed.iter().map(|e| e.piece).collect();
    let program = ContourProgram {
        pieces: &pieces,
        register,
        nose,
        piece: &piece,
        bore: inputs.bore(),
        settings,
        cutting: inputs.part.cutting,
        about: &about,
    };
    program.write(args.dialect).map_err(|e| match args.machine {
        Some(_) => Failure::refuse(e),
        None => Failure::refuse(format!(
            "{e}; what stands around the part was assumed: state it by --machine FILE"
        )),
    })
}

/// The machine's data, with the tool's nose.
fn machine(args: &CompensateArgs, inputs: &Inputs) -> Result<NcSettings, Failure> {
    let with_nose = |s: NcSettings| NcSettings { nose_radius_mm: Some(inputs.geometry.nose_radius_mm), ..s };
    let Some(path) = &args.machine else { return Ok(with_nose(NcSettings::default())) };
    let file = ConfigText::read(path)?;
    let settings = with_nose(file.parse()?);
    settings.validate().map_err(|mut at| {
        at.key = at.key.strip_prefix("nc.").unwrap_or(&at.key).to_owned();
        match NcError::from(at) {
            NcError::Setting(at) => Failure::refused(config::value_error(&file.text, &file.name, at)),
            other => file.refuse(other),
        }
    })?;
    Ok(settings)
}

/// A row of left.csv.
#[derive(serde::Serialize)]
struct LeftRow {
    way: &'static str,
    z_mm: f64,
    diameter_mm: f64,
    a_deg: f64,
    left_um: f64,
    reached: bool,
}

fn left_rows(all: &[(Way, &[Remainder])]) -> Vec<LeftRow> {
    let row = |way: Way, r: &Remainder| LeftRow {
        way: way.as_str(),
        z_mm: r.at.y,
        diameter_mm: 2.0 * r.at.x,
        a_deg: r.a_rad.to_degrees(),
        left_um: 1e3 * r.left_mm,
        reached: r.reached,
    };
    all.iter().flat_map(|(way, left)| left.iter().map(move |r| row(*way, r))).collect()
}

/// A row of path.csv.
#[derive(serde::Serialize)]
struct PathRow {
    from_z_mm: f64,
    from_diameter_mm: f64,
    to_z_mm: f64,
    to_diameter_mm: f64,
    radius_mm: Option<f64>,
}

fn path_rows(programmed: &[Element]) -> Vec<PathRow> {
    let row = |e: &Element| PathRow {
        from_z_mm: e.piece.from.y,
        from_diameter_mm: 2.0 * e.piece.from.x,
        to_z_mm: e.piece.to.y,
        to_diameter_mm: 2.0 * e.piece.to.x,
        radius_mm: e.piece.arc.map(|arc| arc.radius_mm),
    };
    programmed.iter().map(row).collect()
}
