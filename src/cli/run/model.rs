//! A model of a part in place of a job: what the command line adds to it, and the job that it
//! makes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::cli::input_output::ConfigText;
use crate::part_program::shaft_corners;
use crate::plan::CuttingData;
use crate::shaft::ContourPoint;
use crate::stl::{FaultKind, ReadSettings, TOLERANCE_MM, TurnedPart, Unit, read_part};
use crate::tool::{ToolFile, Way};

/// What a model does not hold.
#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "With a model of a part (.stl)")]
pub(crate) struct ModelArgs {
    /// Unit of its coordinates: mm, cm, m or inch. The file has none; it is checked against the
    /// bar.
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// Diameter of the bar, mm.
    #[arg(long, value_name = "MM")]
    stock: Option<f64>,
    /// A TOML file with the tool (`schema tool`); the speed and feed of its measured pass are cut
    /// with where --speed and --feed are left out.
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// Its nose as measured (`tool nose`, JSON); without it a round one of the nominal radius.
    #[arg(long, value_name = "FILE")]
    nose: Option<PathBuf>,
    /// What the finishing cut does about the nose: register, best-register, edited-contour, path.
    #[arg(long, value_name = "WAY", value_parser = way)]
    way: Option<Way>,
    /// Cutting speed, m/min.
    #[arg(long, value_name = "M_PER_MIN")]
    speed: Option<f64>,
    /// Feed, mm per revolution.
    #[arg(long, value_name = "MM")]
    feed: Option<f64>,
    /// Largest distance of the outline from the model's vertices, mm.
    #[arg(long, value_name = "MM")]
    tolerance: Option<f64>,
    /// The lighter end comes to the chuck; else the heavier one.
    #[arg(long)]
    turn_round: bool,
    /// Tolerance of the diameters of its cylinders in a run, as a drawing writes it behind the
    /// size: h7, ±0.02; without it the run gives no verdict.
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    size_tolerance: Option<String>,
}

fn way(word: &str) -> Result<Way, String> {
    let name = word.replace('-', "_");
    Way::ALL.into_iter().find(|way| way.as_str() == name).ok_or_else(|| {
        format!("no way is called {word:?}; there are register, best-register, edited-contour, path")
    })
}

/// Whether a path names a model.
pub(crate) fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl"))
}

/// A tool's file with its text.
pub(crate) struct ModelTool {
    /// The file.
    pub(crate) text: ConfigText,
    /// What it holds.
    pub(crate) tool: ToolFile,
}

impl ModelArgs {
    /// Refuses them beside anything but a model.
    pub(crate) fn only_for_models(&self, path: &Path) -> Result<(), Failure> {
        let given = [
            ("--unit", self.unit.is_some()),
            ("--stock", self.stock.is_some()),
            ("--tool", self.tool.is_some()),
            ("--nose", self.nose.is_some()),
            ("--way", self.way.is_some()),
            ("--speed", self.speed.is_some()),
            ("--feed", self.feed.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--turn-round", self.turn_round),
            ("--size-tolerance", self.size_tolerance.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((name, _)) => Err(Failure::refuse(format!(
                "{name} belongs to a model of a part, and {} is no .stl file: leave it out",
                path.display()
            ))),
        }
    }

    fn needed<T: Copy>(value: Option<T>, name: &str, why: &str) -> Result<T, Failure> {
        value.ok_or_else(|| Failure::refuse(format!("a model of a part needs {name}: {why}")))
    }

    /// Diameter of the bar, mm.
    pub(crate) fn stock_mm(&self) -> Result<f64, Failure> {
        let stock = Self::needed(self.stock, "--stock MM", "the diameter of the bar that it is turned from")?;
        if stock.is_finite() && stock > 0.0 {
            return Ok(stock);
        }
        Err(Failure::refuse(format!("--stock {stock}: must be a diameter above 0 mm")))
    }

    /// Whether a tolerance of the diameters is given, which a program has no word for.
    pub(crate) fn has_size_tolerance(&self) -> bool {
        self.size_tolerance.is_some()
    }

    /// The way of the finishing cut.
    pub(crate) fn way(&self) -> Way {
        self.way.unwrap_or_default()
    }

    /// Files that it names.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.tool.iter().chain(&self.nose).cloned()
    }

    /// The nose's file.
    pub(crate) fn nose(&self) -> Option<&Path> {
        self.nose.as_deref()
    }

    /// The part that a model holds.
    ///
    /// # Errors
    /// Exit 3 for a file that cannot be read, 2 for a model that is no turned part of this bar.
    pub(crate) fn part(&self, path: &Path) -> Result<TurnedPart, Failure> {
        let why = "an STL file has no unit (mm, cm, m, inch)";
        let tolerance_mm = self.tolerance.unwrap_or(TOLERANCE_MM);
        if !(1e-6..=1.0).contains(&tolerance_mm) {
            return Err(Failure::refuse(format!("--tolerance {tolerance_mm}: must lie in 0.000001 to 1 mm")));
        }
        let settings = ReadSettings {
            unit: Self::needed(self.unit, "--unit UNIT", why)?,
            stock_mm: self.stock_mm()?,
            tolerance_mm,
            turn_round: self.turn_round,
        };
        let bytes = std::fs::read(path)
            .map_err(|e| Failure::fail(format!("{}: cannot be read: {e}", path.display())))?;
        read_part(&bytes, &settings).map_err(|fault| {
            let text = format!("{}: {fault}", path.display());
            // bytes that are no model fail as an image does; a model is refused
            if fault.kind == FaultKind::File { Failure::fail(text) } else { Failure::refuse(text) }
        })
    }

    /// The tool.
    ///
    /// # Errors
    /// None given, or a file that is refused.
    pub(crate) fn tool(&self) -> Result<ModelTool, Failure> {
        let path = self.tool.as_deref().ok_or_else(|| {
            Failure::refuse("a model of a part needs --tool FILE: the tool's angles and nose (`schema tool`)")
        })?;
        let text = ConfigText::read(path)?;
        let tool: ToolFile = text.parse()?;
        tool.geometry().map_err(|e| text.refuse_at(e))?;
        Ok(ModelTool { text, tool })
    }

    /// Speed and feed, of the command line or of the tool's measured pass.
    ///
    /// # Errors
    /// Neither states them.
    pub(crate) fn cutting(&self, tool: &ModelTool) -> Result<CuttingData, Failure> {
        let pass = tool.tool.measured_pass;
        let why = |what: &str| format!("{} states no measured_pass with its {what}", tool.text.name);
        let speed = self.speed.or(pass.map(|p| p.speed_m_per_min));
        let feed = self.feed.or(pass.map(|p| p.feed_mm_per_rev));
        Ok(CuttingData {
            speed_m_per_min: Self::needed(speed, "--speed M_PER_MIN", &why("speed"))?,
            feed_mm_per_rev: Self::needed(feed, "--feed MM", &why("feed"))?,
        })
    }
}

/// Field of the camera that a job of a model has, in units of the largest diameter: room for the
/// masters and for a shaft that stands off.
const FIELD: f64 = 1.2;
/// Rows and columns of that camera, and the size of its pixels, mm.
const ROWS: f64 = 2048.0;
const COLUMNS: f64 = 1200.0;
const PIXEL_MM: f64 = 3.45e-3;
/// Largest magnification: that of the stepped shaft's lens.
const MAGNIFICATION: f64 = 0.226;
/// Largest and least length of a station, mm.
const STATION_MM: (f64, f64) = (0.5, 2.0);
/// Depth of both passes where the tool's measured pass states none, mm of radius.
const DEPTH_MM: f64 = 0.2;
/// Least step of the passes, mm of diameter, where the bar is as thick as the part.
const LEAST_STEP_MM: f64 = 1e-3;
/// Columns beside the end of a cylinder that a job keeps its stations out of, and one of rounding.
const BESIDE_PX: f64 = 21.0;

/// The job of a model: the part as `[shaft] contour`, two passes of equal depth (what the first one
/// is corrected by holds for a cut of the same force), a camera into which it fits.
///
/// # Errors
/// As [`ModelArgs::part`] and [`ModelArgs::tool`]; an outline that `[shaft] contour` has no words
/// for.
pub(crate) fn job_text(path: &Path, args: &ModelArgs) -> Result<String, Failure> {
    let part = args.part(path)?;
    let tool = args.tool()?;
    let cutting = args.cutting(&tool)?;
    let corners =
        shaft_corners(&part.outline).map_err(|e| Failure::refuse(format!("{}: {e}", path.display())))?;
    let name = path.file_stem().map_or_else(|| "part".to_owned(), |n| n.to_string_lossy().into_owned());
    Ok(text(&name, &corners, (args, &tool), (args.stock_mm()?, cutting)))
}

fn text(
    name: &str,
    corners: &[ContourPoint],
    (args, tool): (&ModelArgs, &ModelTool),
    (stock_mm, cutting): (f64, CuttingData),
) -> String {
    let largest = corners.iter().map(|c| c.diameter_mm).fold(0.0, f64::max);
    let length = corners.last().map_or(0.0, |c| c.z_mm);
    let depth_mm = tool.tool.measured_pass.and_then(|pass| pass.depth_mm).unwrap_or(DEPTH_MM);
    let step = (2.0 * depth_mm).min(0.5 * (stock_mm - largest)).max(LEAST_STEP_MM);
    let magnification = MAGNIFICATION.min(ROWS * PIXEL_MM / (FIELD * largest));
    let fields = 1.0 + (length * magnification / (COLUMNS * PIXEL_MM)).ceil();
    let cylinders = cylinders(corners, BESIDE_PX * PIXEL_MM / magnification);
    let least = cylinders.iter().map(|c| c.diameter_mm).fold(largest, f64::min);
    let clear = cylinders.iter().map(|c| c.clear_mm).filter(|mm| *mm >= STATION_MM.0);
    let station = (0.5 * clear.fold(2.0 * STATION_MM.1, f64::min)).clamp(STATION_MM.0, STATION_MM.1);
    let mut text = format!("name = {name:?}\nseed = 1\n\n[part]\nlength_mm = {length:?}\n");
    let _ = writeln!(
        text,
        "stock_diameter_mm = {:?}\nnominal_diameter_mm = [{:?}, {largest:?}]",
        rounded(largest + 2.0 * step),
        rounded(largest + step)
    );
    let _ = writeln!(text, "station_mm = {station:?}\n");
    text += &sections(&cylinders, args.size_tolerance.as_deref());
    let _ = writeln!(text, "[shaft]\ncontour = [");
    for c in corners {
        let radius =
            if c.radius_mm > 0.0 { format!(", radius_mm = {:?}", c.radius_mm) } else { String::new() };
        let _ = writeln!(text, "    {{ z_mm = {:?}, diameter_mm = {:?}{radius} }},", c.z_mm, c.diameter_mm);
    }
    let _ = writeln!(
        text,
        "]\n\n[cutting]\nspeed_m_per_min = {:?}\nfeed_mm_per_rev = {:?}\n",
        cutting.speed_m_per_min, cutting.feed_mm_per_rev
    );
    if let Some(nose) = args.nose() {
        let (file, nose, way) = (&tool.text.name, nose.display().to_string(), args.way().as_str());
        let _ = writeln!(text, "[tool]\nfile = {file:?}\nnose = {nose:?}\nway = {way:?}\n");
    }
    let _ = writeln!(text, "[scan]\nfields = {fields:.0}\nangles = 8\n\n[masters]\nframes_each = 4\n");
    for pin in [0.98 * least, 1.01 * largest] {
        let _ = writeln!(text, "[[masters.pins]]\ndiameter_mm = {pin:.3}\nexpanded_u_mm = 0.0001\n");
    }
    let _ = writeln!(
        text,
        "[camera]\ncolumns = {COLUMNS:.0}\nrows = {ROWS:.0}\npixel_um = {:?}\n",
        1e3 * PIXEL_MM
    );
    let _ = writeln!(text, "[optics]\nmagnification = {magnification:.4}");
    text
}

/// A diameter without the digits of its sum, mm.
fn rounded(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6
}

/// A cylinder of a part.
struct Cylinder {
    /// Its middle, mm.
    z_mm: f64,
    /// Diameter, mm.
    diameter_mm: f64,
    /// Length that is clear of arcs and of the blur beside its ends, mm.
    clear_mm: f64,
}

/// The cylinders between corners; `beside_mm` is what the blur of a shoulder takes of one.
fn cylinders(corners: &[ContourPoint], beside_mm: f64) -> Vec<Cylinder> {
    let last = corners.len().saturating_sub(1);
    let beside = |i: usize| if i == 0 || i == last { 0.0 } else { beside_mm };
    let mut found = Vec::new();
    for (i, pair) in corners.windows(2).enumerate() {
        let (from, to) = (pair[0].z_mm + pair[0].radius_mm, pair[1].z_mm - pair[1].radius_mm);
        if pair[0].diameter_mm == pair[1].diameter_mm && to > from {
            let clear_mm = (to - beside(i + 1)) - (from + beside(i));
            found.push(Cylinder { z_mm: 0.5 * (from + to), diameter_mm: pair[0].diameter_mm, clear_mm });
        }
    }
    found
}

/// The cylinders as `[[part.sections]]`: those too short for a station are not measured, the others
/// have the tolerance.
fn sections(cylinders: &[Cylinder], tolerance: Option<&str>) -> String {
    let mut text = String::new();
    for cylinder in cylinders {
        let word = match tolerance {
            _ if cylinder.clear_mm < STATION_MM.0 => "measured = false".to_owned(),
            Some(tolerance) => {
                format!("tolerance = {:?}", format!("{} {tolerance}", cylinder.diameter_mm))
            }
            None => continue,
        };
        let _ = writeln!(text, "[[part.sections]]\nz_mm = {:?}\n{word}\n", rounded(cylinder.z_mm));
    }
    text
}
