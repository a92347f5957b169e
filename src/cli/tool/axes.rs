//! `shadowgauge tool axes`: how the camera's image lies in the machine, from moves of the tool
//! along X and Z.

use std::path::PathBuf;

use glam::DVec2;
use serde::Serialize;

use super::nose::{frames, insert_scale};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::{ConfigText, json_text};
use crate::files::OutputFile;
use crate::gauge::nose::axes::{MachineAxes, MachineAxis, MovedNose, machine_axes};
use crate::gauge::nose::{NoseSettings, measure_nose};
use crate::source::{Channel, listing};
use crate::tool::ToolFile;

/// Arguments of `tool axes`.
#[derive(Debug, clap::Args)]
pub(crate) struct AxesArgs {
    /// Back-lit images of one insert in three or more places of the slides, or folders of them.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// X of the slides at each image, mm: the distance from the axis, not the diameter; any zero.
    #[arg(long, value_name = "MM,…", value_delimiter = ',', required = true, allow_hyphen_values = true)]
    x_mm: Vec<f64>,
    /// Z of the slides at each image, mm; any zero.
    #[arg(long, value_name = "MM,…", value_delimiter = ',', required = true, allow_hyphen_values = true)]
    z_mm: Vec<f64>,
    /// Nominal scale, µm per px; the moves give the true one.
    #[arg(long, value_name = "S", value_parser = insert_scale)]
    um_per_px: f64,
    /// A TOML file with the tool (`schema tool`): its nominal radius, and what --out changes.
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// Write the tool's file with these directions in its [image] table.
    #[arg(long, value_name = "FILE.toml", requires = "tool")]
    out: Option<PathBuf>,
    /// Channel of colour images.
    #[arg(long, default_value = "g")]
    channel: Channel,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Departure of the scale by the moves from the nominal one, share, beyond which one of them is
/// wrong: a telecentric lens keeps its magnification to a per cent, a wrong unit is off by 2 or
/// more.
const MOST_SCALE: f64 = 0.1;

/// What is printed with --json.
#[derive(Debug, Serialize)]
struct Document {
    image: ImageTable,
    u_plus_x_deg: f64,
    u_plus_z_deg: f64,
    off_square_deg: f64,
    u_off_square_deg: f64,
    mirrored: bool,
    um_per_px_x: f64,
    u_um_per_px_x: f64,
    um_per_px_z: f64,
    u_um_per_px_z: f64,
    to_machine_mm_per_px: [[f64; 2]; 2],
    s_px: f64,
    places: Vec<PlaceRow>,
}

/// The table of a tool's file.
#[derive(Clone, Copy, Debug, Serialize)]
struct ImageTable {
    plus_x_deg: f64,
    plus_z_deg: f64,
}

#[derive(Debug, Serialize)]
struct PlaceRow {
    image: String,
    x_mm: f64,
    z_mm: f64,
    centre_px: [f64; 2],
    u_centre_px: f64,
    residual_px: f64,
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for places that do not fit the images or the moves, a tool's file that is refused; 3 for
/// images that show no nose that can be measured.
pub(crate) fn run(args: &AxesArgs) -> CommandResult {
    let mut paths = Vec::new();
    for input in &args.images {
        paths.extend(listing(input).map_err(Failure::fail)?.images);
    }
    check_counts(args, paths.len())?;
    let tool = args.tool.as_deref().map(ConfigText::read).transpose()?;
    let file: Option<ToolFile> = tool.as_ref().map(ConfigText::parse).transpose()?;
    let inputs = || args.images.iter().chain(&args.tool).cloned();
    let out = args.out.as_deref().map(|p| OutputFile::claim(p, inputs())).transpose()?;
    let (names, moved) = measured(args, paths, file.as_ref())?;
    let found = machine_axes(&moved).map_err(Failure::refuse)?;
    check_scale(args, &found)?;
    let image = ImageTable { plus_x_deg: rounded(&found.x), plus_z_deg: rounded(&found.z) };
    if let (Some(out), Some(tool)) = (out, &tool) {
        out.write(with_image(tool, image)?.as_bytes())?;
    }
    if args.json {
        say_line!("{}", json_text(&document(&found, image, names.into_iter().zip(&moved)))?);
    } else {
        print(&found, image);
    }
    Ok(Outcome::Done)
}

fn check_counts(args: &AxesArgs, images: usize) -> Result<(), Failure> {
    for (name, values) in [("--x-mm", &args.x_mm), ("--z-mm", &args.z_mm)] {
        if values.len() != images {
            return Err(Failure::refuse(format!(
                "{name}: {} places for {images} images; give one a picture, in their order: {name} 0,1,0 for three",
                values.len()
            )));
        }
        if let Some(value) = values.iter().find(|v| !v.is_finite()) {
            return Err(Failure::refuse(format!(
                "{name}: {value} is no place; a number of millimetres is needed"
            )));
        }
    }
    Ok(())
}

/// The centres of the noses, in the order of the images.
fn measured(
    args: &AxesArgs,
    paths: Vec<PathBuf>,
    file: Option<&ToolFile>,
) -> Result<(Vec<String>, Vec<MovedNose>), Failure> {
    // its direction is what is sought: nothing is expected of it
    let nominal_radius_px = file.map(|f| 1e3 * f.nose_radius_mm / args.um_per_px);
    let settings = NoseSettings { nominal_radius_px, um_per_px: args.um_per_px, expected: None };
    let (mut names, mut moved) = (Vec::new(), Vec::new());
    let places = args.x_mm.iter().zip(&args.z_mm);
    for (read, (x, z)) in frames(paths, args.channel).zip(places) {
        let (name, frame) = read?;
        let nose =
            measure_nose(&frame.view(), &settings).map_err(|e| Failure::fail(format!("{name}: {e}")))?;
        names.push(name);
        moved.push(MovedNose { slides_mm: DVec2::new(*x, *z), centre: nose.centre, u_px: nose.u_centre_px });
    }
    Ok((names, moved))
}

fn check_scale(args: &AxesArgs, found: &MachineAxes) -> Result<(), Failure> {
    let mean = 0.5 * (found.x.um_per_px + found.z.um_per_px);
    if (mean / args.um_per_px - 1.0).abs() <= MOST_SCALE {
        return Ok(());
    }
    Err(Failure::refuse(format!(
        "--um-per-px: {} is stated, by the moves it is {mean:.4} µm per px: correct it, or --x-mm and --z-mm (millimetres)",
        args.um_per_px
    )))
}

/// A direction as a file takes it: to 1e-6°, far below its uncertainty.
fn rounded(axis: &MachineAxis) -> f64 {
    (axis.direction_deg * 1e6).round() / 1e6 + 0.0
}

/// The text of a tool's file with these directions in its `[image]` table, checked.
fn with_image(tool: &ConfigText, image: ImageTable) -> Result<String, Failure> {
    let table =
        format!("[image]\nplus_x_deg = {:?}\nplus_z_deg = {:?}\n", image.plus_x_deg, image.plus_z_deg);
    let text = replaced(&tool.text, &table);
    let named = ConfigText { text, name: format!("{} with [image] as measured", tool.name) };
    let file: ToolFile = named.parse()?;
    file.geometry().map_err(|e| named.refuse_at(e))?;
    Ok(named.text)
}

/// The text with its table `[image]` replaced, or with the table at its end; comments of other
/// tables stay.
fn replaced(text: &str, table: &str) -> String {
    let (mut out, mut inside, mut done) = (String::new(), false, false);
    for line in text.lines() {
        let head = line.trim_start();
        if head.starts_with('[') {
            inside = head.starts_with("[image]");
            if inside {
                out.push_str(table);
                done = true;
            }
        }
        // what comments and spaces follow the keys belongs to the next table
        if !inside || head.starts_with('#') || head.is_empty() {
            out.push_str(line);
            out.push('\n');
        }
    }
    if !done {
        out.push('\n');
        out.push_str(table);
    }
    out
}

fn document<'a>(
    found: &MachineAxes,
    image: ImageTable,
    places: impl Iterator<Item = (String, &'a MovedNose)>,
) -> Document {
    let row = |((image, m), residual_px): ((String, &MovedNose), &f64)| PlaceRow {
        image,
        x_mm: m.slides_mm.x,
        z_mm: m.slides_mm.y,
        centre_px: [m.centre.x, -m.centre.y],
        u_centre_px: m.u_px,
        residual_px: *residual_px,
    };
    Document {
        image,
        u_plus_x_deg: found.x.u_direction_deg,
        u_plus_z_deg: found.z.u_direction_deg,
        off_square_deg: found.off_square_deg,
        u_off_square_deg: found.u_off_square_deg,
        mirrored: found.mirrored,
        um_per_px_x: found.x.um_per_px,
        u_um_per_px_x: found.x.u_um_per_px,
        um_per_px_z: found.z.um_per_px,
        u_um_per_px_z: found.z.u_um_per_px,
        to_machine_mm_per_px: found.to_machine_mm_per_px,
        s_px: found.s_px,
        places: places.zip(&found.residuals_px).map(row).collect(),
    }
}

fn print(found: &MachineAxes, image: ImageTable) {
    for (name, axis) in [("X", &found.x), ("Z", &found.z)] {
        say_line!(
            "+{name}: {:.4}° (u {:.4}°), {:.5} µm per px (u {:.5})",
            axis.direction_deg,
            axis.u_direction_deg,
            axis.um_per_px,
            axis.u_um_per_px
        );
    }
    say_line!(
        "axes off a right angle by {:+.4}° (u {:.4}°){}; a centre's coordinate scatters by {:.4} px",
        found.off_square_deg,
        found.u_off_square_deg,
        if found.mirrored { ", +X clockwise of +Z: a mirrored picture" } else { "" },
        found.s_px
    );
    let [x, z] = found.to_machine_mm_per_px;
    say_line!("(X, Z)/mm = ({:.8}, {:.8}; {:.8}, {:.8}) · (column, -row)/px", x[0], x[1], z[0], z[1]);
    say_line!(
        "for the tool's file:\n[image]\nplus_x_deg = {:?}\nplus_z_deg = {:?}",
        image.plus_x_deg,
        image.plus_z_deg
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_replaced_where_it_stands_and_added_where_it_is_not() {
        let table = "[image]\nplus_x_deg = 91.0\nplus_z_deg = 1.0\n";
        let text = include_str!("../../../configs/tool/tool_set_new.toml");
        let changed = replaced(text, table);
        let file: ToolFile = toml::from_str(&changed).unwrap();
        assert_eq!((file.image.plus_x_deg, file.image.plus_z_deg), (91.0, 1.0));
        assert_eq!(file.setting.x_extent_mm, Some(0.4));
        assert!(changed.starts_with("# The tool of paper 004"), "{changed}");
        let first = "nose_radius_mm = 0.4\nkappa_r_deg = 93.0\nepsilon_r_deg = 60.0\ntip_direction = 3\n";
        let with_setting = format!(
            "{first}[image] # as seen\nplus_x_deg = 90.0\n\n# of the new one\n[setting]\nx_extent_mm = 0.4\n"
        );
        for text in [first.to_owned(), with_setting] {
            let changed = replaced(&text, table);
            let file: ToolFile = toml::from_str(&changed).unwrap();
            assert_eq!((file.image.plus_x_deg, file.image.plus_z_deg), (91.0, 1.0), "{changed}");
            assert_eq!(changed.contains("# of the new one"), text.contains("# of the new one"));
        }
    }
}
