//! `shadowgauge tool nose`: back-lit images of an insert to its edges, nose and support.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::bench::Bench;
use super::overlay::overlay;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::files::OutputFile;
use crate::frame::Frame;
use crate::gauge::Calibration;
use crate::gauge::nose::paper::{PaperSettings, measure_paper_nose};
use crate::gauge::nose::{
    BaselineNose, ExpectedNose, NoseMeasurement, NoseSettings, Reference, Wear, measure_nose, wear,
};
use crate::measurement::nose::{NoseImage, read_baseline};
use crate::measurement::paper_nose::{AnyNose, PaperNoseImage};
use crate::nose::ToolGeometry;
use crate::source::{Channel, FileFrames, listing};
use crate::tool::ToolFile;

/// Arguments of `tool nose`.
#[derive(Debug, clap::Args)]
pub(crate) struct NoseArgs {
    /// Back-lit images of one insert, or folders of them.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Scale, µm per px in the plane of the insert.
    #[arg(long, value_name = "S", value_parser = insert_scale, required_unless_present = "calibration", conflicts_with = "calibration")]
    um_per_px: Option<f64>,
    /// Calibration file (`calibrate`): its scale and edge offset with their uncertainty. Its lens'
    /// distortion is not applied.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// The same insert new, in the same holder and camera: an image, or the JSON document of one.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// A TOML file with the tool (`schema tool`): nominal radius and angles, which are checked.
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// How the nose is measured. `paper` is for comparison with paper 004: it needs --tool, states
    /// no uncertainty and no support.
    #[arg(long, value_enum, default_value_t = Mode::Ml)]
    mode: Mode,
    /// Channel of colour images; green has half of a Bayer sensor's pixels.
    #[arg(long, default_value = "g")]
    channel: Channel,
    /// Measure each image so many times more, and report the time of one, decoding left out.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    bench: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write the JSON document to this file, for `tool compensate --nose` and --baseline.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Draw what was measured over the image; for one image.
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
}

/// How a nose is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    /// Maximum likelihood of every pixel along the contour.
    Ml,
    /// Canny, lines of LSD, the angle forced to the insert's, the mean distance of the edge's
    /// pixels.
    Paper,
}

/// The images of one call.
#[derive(Debug, Default, serde::Serialize)]
struct Document {
    images: Vec<AnyNose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bench: Option<Bench>,
}

/// A scale of the command line, µm per px.
pub(in crate::cli) fn scale(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|s| *s > 0.0 && s.is_finite());
    value.ok_or_else(|| "a scale above 0 is needed, µm per px, for instance 2.415".to_owned())
}

/// The scale of a picture of an insert: at 1000 µm per px the largest nose has a radius of two
/// pixels, and no light resolves 0.01 µm.
pub(super) fn insert_scale(text: &str) -> Result<f64, String> {
    let found = scale(text)?;
    if (0.01..=1000.0).contains(&found) {
        return Ok(found);
    }
    Err("a scale from 0.01 to 1000 is needed, µm per px, for instance 2.415".to_owned())
}

/// Images with their names.
pub(super) type Named = (String, Frame);

/// What measures an image.
struct Instrument {
    settings: NoseSettings,
    baseline: Option<BaselineNose>,
    /// The paper's mode, where it is asked for.
    paper: Option<PaperSettings>,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for files that are refused, 3 for images that show no nose that can be measured.
pub(crate) fn run(args: &NoseArgs) -> CommandResult {
    let calibration = calibration(args)?;
    let mut paths = Vec::new();
    for input in &args.images {
        paths.extend(listing(input).map_err(Failure::fail)?.images);
    }
    if args.overlay.is_some() && paths.len() != 1 {
        return Err(Failure::refuse(format!("--overlay draws over one image, {} are given", paths.len())));
    }
    let inputs =
        || args.images.iter().chain(&args.tool).chain(&args.baseline).chain(&args.calibration).cloned();
    let out = args.out.as_deref().map(|p| OutputFile::claim(p, inputs())).transpose()?;
    let drawn = args.overlay.as_deref().map(|p| OutputFile::claim(p, inputs())).transpose()?;
    let um_per_px = 1e3 * calibration.scale_mm_per_px;
    let instrument = Instrument::new(args, um_per_px)?;
    let (mut document, mut refused, mut picture) = (Document::default(), Vec::new(), None);
    let mut times = Vec::new();
    for read in frames(paths, args.channel) {
        let (name, frame) = read?;
        times.extend((0..args.bench).map(|_| time_ms(&instrument, (&name, &frame), &calibration)));
        match found(&instrument, (&name, &frame), &calibration) {
            Ok((image, measured)) => {
                if !args.json {
                    print(&image);
                }
                document.images.push(image);
                if let Some(measured) = measured.filter(|_| drawn.is_some()) {
                    picture = Some(overlay(&frame.view(), &measured).map_err(Failure::fail)?);
                }
            }
            Err(error) => refused.push(format!("{name}: {error}")),
        }
    }
    document.bench = Bench::of(times);
    if let Some(bench) = document.bench.as_ref().filter(|_| !args.json) {
        say_line!("{} measurements, {:.1} ms in the median", bench.measurements, bench.ms_per_image_median);
    }
    let Some(error) = end(&refused, document.images.len()) else {
        return write(args, &document, out, (drawn, picture));
    };
    if !document.images.is_empty() {
        write(args, &document, out, (drawn, picture))?;
    }
    Err(Failure::fail(error))
}

/// An image by the mode that is asked for, and what can be drawn over it.
fn found(
    instrument: &Instrument,
    (name, frame): (&str, &Frame),
    calibration: &Calibration,
) -> Result<(AnyNose, Option<NoseMeasurement>), String> {
    if let Some(paper) = &instrument.paper {
        let nose = measure_paper_nose(&frame.view(), paper).map_err(|e| e.to_string())?;
        return Ok((
            AnyNose::Paper(Box::new(PaperNoseImage::new(name.to_owned(), &nose, calibration))),
            None,
        ));
    }
    let (measured, wear) = instrument.measure(frame)?;
    let image = NoseImage::new(name.to_owned(), &measured, wear.as_ref(), calibration);
    Ok((AnyNose::Own(Box::new(image)), Some(measured)))
}

/// Time that a measurement takes, ms.
fn time_ms(instrument: &Instrument, image: (&str, &Frame), calibration: &Calibration) -> f64 {
    let from = Instant::now();
    let done = found(instrument, image, calibration);
    let ms = 1e3 * from.elapsed().as_secs_f64();
    drop(done);
    ms
}

/// The failure for images that were refused.
fn end(refused: &[String], measured: usize) -> Option<String> {
    match refused {
        [] => None,
        [only] if measured == 0 => Some(only.clone()),
        [first, ..] => {
            Some(format!("{} of {} images are refused: {first}", refused.len(), refused.len() + measured))
        }
    }
}

fn write(
    args: &NoseArgs,
    document: &Document,
    out: Option<OutputFile>,
    (drawn, picture): (Option<OutputFile>, Option<Vec<u8>>),
) -> CommandResult {
    let text = json_text(document)? + "\n";
    if let Some(out) = out {
        out.write(text.as_bytes())?;
    }
    if let (Some(drawn), Some(picture)) = (drawn, picture) {
        drawn.write(&picture)?;
    }
    if args.json {
        say!("{text}");
    }
    Ok(Outcome::Done)
}

fn calibration(args: &NoseArgs) -> Result<Calibration, Failure> {
    let Some(path) = &args.calibration else {
        return Ok(Calibration::from_scale(args.um_per_px.unwrap_or(1.0)));
    };
    let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
    let file = std::fs::File::open(path).map_err(|e| named(&e))?;
    Calibration::read(std::io::BufReader::new(file)).map_err(|e| named(&e))
}

/// The images of files, one after another.
pub(super) fn frames(paths: Vec<PathBuf>, channel: Channel) -> impl Iterator<Item = Result<Named, Failure>> {
    let mut source = FileFrames::new(paths).of_channel(Some(channel));
    std::iter::from_fn(move || {
        let read = source.next_stored()?;
        Some(read.map_err(Failure::fail).map(|stored| {
            stored.changed.iter().for_each(|note| tracing::warn!("{}: {note}", stored.stem));
            (stored.stem, stored.frame)
        }))
    })
}

impl Instrument {
    fn new(args: &NoseArgs, um_per_px: f64) -> Result<Self, Failure> {
        let mut settings = NoseSettings { nominal_radius_px: None, um_per_px, expected: None };
        if let Some(path) = &args.tool {
            let text = ConfigText::read(path)?;
            let file: ToolFile = text.parse()?;
            let geometry = file.geometry().map_err(|e| text.refuse_at(e))?;
            settings.nominal_radius_px = Some(1e3 * geometry.nose_radius_mm / um_per_px);
            settings.expected = Some(expected(&file, &geometry));
        }
        let mut instrument = Self { settings, baseline: None, paper: None };
        if args.mode == Mode::Paper {
            instrument.paper = Some(instrument.by_paper(args)?);
            return Ok(instrument);
        }
        if let Some(path) = &args.baseline {
            let baseline = instrument.baseline(path, args.channel)?;
            instrument.settings.nominal_radius_px = Some(baseline.nominal_radius_px);
            instrument.baseline = Some(baseline);
        }
        Ok(instrument)
    }

    /// What the paper's mode takes from the tool's file.
    fn by_paper(&self, args: &NoseArgs) -> Result<PaperSettings, Failure> {
        if let Some(other) = [("--baseline", args.baseline.is_some()), ("--overlay", args.overlay.is_some())]
            .into_iter()
            .find_map(|(name, given)| given.then_some(name))
        {
            return Err(Failure::refuse(format!(
                "{other}: --mode paper has none; leave it out, or take --mode ml"
            )));
        }
        let (Some(nominal_radius_px), Some(expected)) =
            (self.settings.nominal_radius_px, self.settings.expected)
        else {
            let why = "--mode paper takes the nominal radius and the included angle from the tool: give its file by --tool";
            return Err(Failure::refuse(why));
        };
        Ok(PaperSettings { nominal_radius_px, epsilon_deg: expected.epsilon_deg, expected: Some(expected) })
    }

    /// A baseline by its document, or by its image: its own radius is the nominal one.
    fn baseline(&self, path: &Path, channel: Channel) -> Result<BaselineNose, Failure> {
        let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
            let text = std::fs::read_to_string(path).map_err(|e| named(&e))?;
            return read_baseline(&text, self.settings.um_per_px).map_err(|e| named(&e));
        }
        let Some(read) = frames(vec![path.to_owned()], channel).next() else {
            return Err(named(&"holds no image"));
        };
        let settings = NoseSettings { nominal_radius_px: None, ..self.settings };
        let measured = measure_nose(&read?.1.view(), &settings).map_err(|e| named(&e))?;
        if measured.reference != Reference::Fitted {
            return Err(named(&"its nose is worn: a baseline is the insert when new"));
        }
        Ok(BaselineNose::from(&measured))
    }

    fn measure(&self, frame: &Frame) -> Result<(NoseMeasurement, Option<Wear>), String> {
        let mut measured = measure_nose(&frame.view(), &self.settings).map_err(|e| e.to_string())?;
        let Some(baseline) = &self.baseline else { return Ok((measured, None)) };
        measured.reference = Reference::Baseline;
        let found = wear(&measured, baseline).map_err(|e| e.to_string())?;
        Ok((measured, Some(found)))
    }
}

/// Where a tool's nose points in the picture: the nose reaches against the normals that it cuts.
fn expected(file: &ToolFile, geometry: &ToolGeometry) -> ExpectedNose {
    let whole = ToolGeometry { clearance_rad: 0.0, ..*geometry };
    let (low, high) = whole.range_rad();
    let direction = |a: f64| {
        let (x, z) = (file.image.plus_x_deg.to_radians(), file.image.plus_z_deg.to_radians());
        let (column, up) = (-a.cos() * x.cos() - a.sin() * z.cos(), -a.cos() * x.sin() - a.sin() * z.sin());
        up.atan2(column).to_degrees().rem_euclid(360.0)
    };
    let (first, second) = (direction(low), direction(high));
    let turned = (second - first).rem_euclid(360.0) > 180.0;
    let normals_deg = if turned { [second, first] } else { [first, second] };
    ExpectedNose { epsilon_deg: file.epsilon_r_deg, normals_deg, by: "tool's file" }
}

fn print(image: &AnyNose) {
    match image {
        AnyNose::Own(image) => print_own(image),
        AnyNose::Paper(p) => say_line!(
            "{}: angle {:.4}° ({:.4}° as found), centre column {:.3} row {:.3} px, mean radius {:.3} px = {:.6} mm; {}",
            p.image,
            p.angle_deg,
            p.found_angle_deg,
            p.centre_px[0],
            p.centre_px[1],
            p.mean_radius_px,
            p.mean_radius_mm,
            p.u_reason
        ),
    }
}

fn print_own(image: &NoseImage) {
    let flags =
        if image.flags.is_empty() { String::new() } else { format!(", flagged {}", image.flags.join(", ")) };
    say_line!(
        "{}: angle {:.4}° (u {:.4}°), centre column {:.3} row {:.3} px (u {:.3}), mean radius {:.3} px (u {:.3}) = {:.6} mm \
         (u {:.6}){flags}",
        image.image,
        image.angle_deg,
        image.u_angle_deg,
        image.centre_px[0],
        image.centre_px[1],
        image.u_centre_px,
        image.mean_radius_px,
        image.u_mean_radius_px,
        image.mean_radius_mm,
        image.u_mean_radius_mm
    );
    if let Some(wear) = &image.wear {
        say_line!(
            "  worn by {:.2} µm in the mean, {:.2} µm at {:.1}° against the baseline",
            wear.mean_um,
            wear.largest_um,
            wear.largest_deg
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_hand_tool_points_down_and_to_the_left() {
        let file: ToolFile = toml::from_str(include_str!("../../../configs/tool/tool.toml")).unwrap();
        let found = expected(&file, &file.geometry().unwrap());
        // its edges' normals: −27° + 180° from +X (up) towards +Z (right), and 93°
        assert!((found.normals_deg[0] - 177.0).abs() < 1e-9, "{found:?}");
        assert!((found.normals_deg[1] - 297.0).abs() < 1e-9, "{found:?}");
    }
}
