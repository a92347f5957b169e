//! `shadowgauge tool flank`: front-lit images of a flank to the widths of its land.

pub(in crate::cli) mod model;
mod overlay;
mod words;

use std::path::PathBuf;

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::json_text;
use crate::cli::tool::nose::{frames, scale};
use crate::files::OutputFile;
use crate::frame::Frame;
use crate::gauge::flank::paper::measure_paper_flank;
use crate::gauge::flank::{CornerSide, FlankSettings, FlankSide, LandModel, measure_flank};
use crate::measurement::flank::{FlankDocument, FlankImage};
use crate::source::{Channel, listing};
use crate::tool::wear::{WearLimits, WearRow, WearVerdict, forecast, read_history, write_history};

/// Arguments of `tool flank`.
#[derive(Debug, clap::Args)]
pub(crate) struct FlankArgs {
    /// Front-lit images of flanks, or folders of them.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Scale, µm per px in the plane of the flank.
    #[arg(long, value_name = "S", value_parser = scale)]
    um_per_px: f64,
    /// Relative standard uncertainty of the scale.
    #[arg(long, value_name = "U", default_value_t = 0.002, value_parser = share)]
    u_scale: f64,
    /// `forest` (trained on rendered flanks), `paper` (for comparison with paper 004), a file of
    /// `tool train`, or a network of yours, FILE.onnx (in a program built with the feature `onnx`).
    #[arg(long, value_name = "MODEL", default_value = "forest")]
    model: String,
    /// At which side of the cutting edge the flank lies in the image, for images that show another
    /// border too.
    #[arg(long, value_enum, default_value_t = FlankSide::Any)]
    flank_side: FlankSide,
    /// An image of the same edge new: the bend of its edge is that of the reference.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Angle between the camera's axis and the normal of the flank, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, value_parser = angle)]
    viewing_deg: f64,
    /// Standard uncertainty of that angle, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 1.0, value_parser = angle)]
    u_viewing_deg: f64,
    /// Nose radius, mm: the length of zone C.
    #[arg(long, value_name = "MM", value_parser = scale)]
    nose_radius_mm: Option<f64>,
    /// At which end of the land the insert's corner lies.
    #[arg(long, value_enum, default_value_t = Corner::Auto)]
    corner: Corner,
    /// Limit of VBB, µm (ISO 3685: 300); with a limit given, exit 1 unless every edge is sharp.
    #[arg(long, value_name = "UM", value_parser = scale)]
    vbb_limit_um: Option<f64>,
    /// Limit of VBBmax, µm (ISO 3685: 600).
    #[arg(long, value_name = "UM", value_parser = scale)]
    vbb_max_limit_um: Option<f64>,
    /// The edge's wear history (CSV), which the images are added to; a forecast is printed.
    #[arg(long, value_name = "FILE.csv", requires = "cut")]
    history: Option<PathBuf>,
    /// Number of the cut after which the image was taken (or minutes, metres: one unit a file).
    #[arg(long, value_name = "N", requires = "history", value_parser = share_or_more)]
    cut: Option<f64>,
    /// Channel of colour images.
    #[arg(long, default_value = "g")]
    channel: Channel,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Draw reference and land over the image; for one image.
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
}

/// Where the corner lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Corner {
    /// At the end of the land that is nearer to an end of the flank.
    Auto,
    /// Towards the left of the image.
    Left,
    /// Towards its right.
    Right,
    /// Not in the image: no zones C and N.
    None,
}

fn share(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| (0.0..1.0).contains(v));
    value.ok_or_else(|| "a share from 0 to below 1 is needed, for instance 0.002".to_owned())
}

fn share_or_more(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| *v >= 0.0 && v.is_finite());
    value.ok_or_else(|| "a number from 0 up is needed".to_owned())
}

fn angle(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| v.abs() <= 60.0);
    value.ok_or_else(|| {
        "an angle of -60 to 60 degrees is needed: flanks seen more obliquely show no land".to_owned()
    })
}

/// What measures an image.
struct Instrument {
    settings: FlankSettings,
    limits: WearLimits,
    /// `None`: the paper's way.
    model: Option<Box<dyn LandModel>>,
}

type Measured = (FlankImage, Vec<[glam::DVec2; 2]>);

/// Runs the command.
///
/// # Errors
/// Exit 2 for arguments and files that are refused, 3 for images that show no flank that can be
/// measured.
pub(crate) fn run(args: &FlankArgs) -> CommandResult {
    let mut paths = Vec::new();
    for input in &args.images {
        paths.extend(listing(input).map_err(Failure::fail)?.images);
    }
    for (option, given) in [("--overlay", args.overlay.is_some()), ("--history", args.history.is_some())] {
        if given && paths.len() != 1 {
            return Err(Failure::refuse(format!("{option} is for one image, {} are given", paths.len())));
        }
    }
    let inputs = || args.images.iter().chain(&args.baseline).cloned();
    let drawn = args.overlay.as_deref().map(|p| OutputFile::claim(p, inputs())).transpose()?;
    let mut history = args.history.as_deref().map(History::open).transpose()?;
    let instrument = Instrument::new(args)?;
    let (mut document, mut refused, mut picture) = (FlankDocument::default(), Vec::new(), None);
    for read in frames(paths, args.channel) {
        let (name, frame) = read?;
        match instrument.measure(name.clone(), &frame) {
            Ok((image, places)) => {
                if drawn.is_some() {
                    picture = Some(overlay::overlay(&frame.view(), &places).map_err(Failure::fail)?);
                }
                document.images.push(image);
            }
            Err(error) => refused.push(format!("{name}: {error}")),
        }
    }
    if let (Some(history), Some(cut), Some(image)) = (&mut history, args.cut, document.images.first()) {
        document.forecasts = history.add(image, cut, &instrument.limits)?;
    }
    if args.json && !document.images.is_empty() {
        say_line!("{}", json_text(&document)?);
    } else {
        words::print(&document);
    }
    if let (Some(drawn), Some(picture)) = (drawn, picture) {
        drawn.write(&picture)?;
    }
    if let Some(history) = history.filter(|_| !document.images.is_empty()) {
        history.write()?;
    }
    end(args, &document, &refused)
}

fn end(args: &FlankArgs, document: &FlankDocument, refused: &[String]) -> CommandResult {
    if let Some(first) = refused.first() {
        let all = refused.len() + document.images.len();
        let text = if all == 1 {
            first.clone()
        } else {
            format!("{} of {all} images are refused: {first}", refused.len())
        };
        return Err(Failure::fail(text));
    }
    let given = args.vbb_limit_um.is_some() || args.vbb_max_limit_um.is_some();
    let sharp = document.images.iter().all(|i| i.verdict == WearVerdict::Sharp);
    Ok(if given && !sharp { Outcome::OutOfTolerance } else { Outcome::Done })
}

impl Instrument {
    fn new(args: &FlankArgs) -> Result<Self, Failure> {
        let model = model::read(&args.model)?;
        let default = WearLimits::default();
        let limits = WearLimits {
            vbb_um: args.vbb_limit_um.unwrap_or(default.vbb_um),
            vbb_max_um: args.vbb_max_limit_um.unwrap_or(default.vbb_max_um),
            ..default
        };
        let corner = match args.corner {
            Corner::Auto => CornerSide::Found,
            Corner::Left => CornerSide::Left,
            Corner::Right => CornerSide::Right,
            Corner::None => CornerSide::None,
        };
        let settings = FlankSettings {
            um_per_px: args.um_per_px,
            u_scale: args.u_scale,
            viewing_deg: args.viewing_deg,
            u_viewing_deg: args.u_viewing_deg.abs(),
            nose_radius_mm: args.nose_radius_mm,
            corner,
            side: args.flank_side,
            baseline: None,
            full_scale: f32::INFINITY,
        };
        let mut instrument = Self { settings, limits, model };
        if let Some(path) = &args.baseline {
            instrument.settings.baseline = Some(instrument.baseline(path, args.channel)?);
        }
        Ok(instrument)
    }

    /// The reference curve of the new edge.
    fn baseline(&self, path: &std::path::Path, channel: Channel) -> Result<Vec<f64>, Failure> {
        let named = |e: &dyn std::fmt::Display| Failure::fail(format!("baseline {}: {e}", path.display()));
        let Some(read) = frames(vec![path.to_owned()], channel).next() else {
            return Err(named(&"holds no image"));
        };
        let Some(model) = self.model.as_deref() else {
            return Err(Failure::refuse("--baseline: --model paper fits its own line; leave it out"));
        };
        let found = measure_flank(&read?.1.view(), &self.settings, model).map_err(|e| named(&e))?;
        Ok(found.curve)
    }

    fn measure(&self, name: String, frame: &Frame) -> Result<Measured, String> {
        let view = frame.view();
        let Some(model) = self.model.as_deref() else {
            let (um_per_px, side) = (self.settings.um_per_px, self.settings.side);
            let found = measure_paper_flank(&view, um_per_px, side).map_err(|e| e.to_string())?;
            let image = FlankImage::of_paper(name, &found, &self.limits);
            return Ok((image, found.places));
        };
        let full_scale = view.full_scale().unwrap_or(f32::INFINITY);
        let settings = FlankSettings { full_scale, ..self.settings.clone() };
        let found = measure_flank(&view, &settings, model).map_err(|e| e.to_string())?;
        Ok((FlankImage::new(name, &found, &self.limits), found.places))
    }
}

/// A wear history with its file.
struct History {
    file: OutputFile,
    rows: Vec<WearRow>,
}

impl History {
    fn open(path: &std::path::Path) -> Result<Self, Failure> {
        let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
        let rows = match std::fs::read(path) {
            Ok(bytes) => read_history(&bytes).map_err(|e| named(&e))?,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(e) => return Err(named(&e)),
        };
        Ok(Self { file: OutputFile::claim(path, [])?, rows })
    }

    /// Adds a reading; forecasts of both limits.
    fn add(
        &mut self,
        image: &FlankImage,
        cut: f64,
        limits: &WearLimits,
    ) -> Result<Vec<crate::tool::wear::Forecast>, Failure> {
        let (Some(u_vbb_um), Some(u_vbb_max_um)) = (image.u_vbb_um, image.u_vbb_max_um) else {
            return Err(Failure::refuse(
                "--history: this model states no uncertainty, which a history needs; take a forest, or a network with \
                 vb_error_um and vb_max_error_um in its metadata",
            ));
        };
        if let Some(last) = self.rows.last().filter(|last| cut < last.cut) {
            let text = format!("--cut {cut}: the history ends at cut {}; give that or a later one", last.cut);
            return Err(Failure::refuse(text));
        }
        let (vbb_um, vbb_max_um) = (image.vbb_um, image.vbb_max_um);
        let (image, verdict) = (image.image.clone(), image.verdict);
        self.rows.push(WearRow { cut, image, vbb_um, u_vbb_um, vbb_max_um, u_vbb_max_um, verdict });
        let mean: Vec<_> = self.rows.iter().map(|r| (r.cut, r.vbb_um, r.u_vbb_um)).collect();
        let most: Vec<_> = self.rows.iter().map(|r| (r.cut, r.vbb_max_um, r.u_vbb_max_um)).collect();
        let both = [forecast(&mean, limits.vbb_um), forecast(&most, limits.vbb_max_um)];
        Ok(both.into_iter().flatten().collect())
    }

    fn write(self) -> Result<(), Failure> {
        let text = write_history(&self.rows).map_err(Failure::fail)?;
        Ok(self.file.write(&text)?)
    }
}
