//! `shadowgauge optics limb`: the shifts of a part's limbs against the masters', as the `[limb]`
//! table of a conditions file.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::SystemTime;

use serde::de::DeserializeOwned;
use serde_json::json;

use super::head_config::{head_failure, load_head};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::json_text;
use crate::gauge::EsfModel;
use crate::gauge::calibration::{Date, Finish};
use crate::render::optics::edge_spread::cylinder::Material;
use crate::studies::head::limb::{Comparison, FittedEdge, LimbHead, Surfaces, Texture, compare};
use crate::studies::head::{HeadConfig, HeadSettings, HeadSetup};

/// Arguments of `optics limb`.
#[derive(Debug, clap::Args)]
pub(crate) struct LimbArgs {
    /// A job's config with [camera] and [optics].
    config: PathBuf,
    /// Diameter of the part, mm; the config's without it.
    #[arg(long, value_name = "D", value_parser = positive, allow_negative_numbers = true)]
    diameter_mm: Option<f64>,
    /// Diameters of a stepped part, mm: smallest and largest.
    #[arg(long, value_name = "D,D", num_args = 1.., value_delimiter = ',', value_parser = positive)]
    diameters_mm: Vec<f64>,
    /// Diameters of the masters, mm; those of the config without it.
    #[arg(long, value_name = "D,D", num_args = 1.., value_delimiter = ',', value_parser = positive)]
    masters_mm: Vec<f64>,
    /// Material of the masters: steel, iron, chromium, aluminium or ceramic.
    #[arg(long, value_name = "NAME", default_value = "steel", value_parser = named::<Material>)]
    masters_material: Material,
    /// Material of the part; not known without it.
    #[arg(long, value_name = "NAME", value_parser = named::<Material>)]
    part_material: Option<Material>,
    /// Finish of the masters: lapped, ground or turned.
    #[arg(long, value_name = "NAME", default_value = "lapped", value_parser = named::<Finish>)]
    masters_finish: Finish,
    /// Finish of the part around it; turned without it, which is the widest.
    #[arg(long, value_name = "NAME", value_parser = named::<Finish>, conflicts_with = "part_rq_um")]
    part_finish: Option<Finish>,
    /// Roughness Rq of the part around it, µm, where it was measured.
    #[arg(long, value_name = "RQ", value_parser = not_negative)]
    part_rq_um: Option<f64>,
    /// The masters were certified by contact, on their peaks.
    #[arg(long)]
    certified_by_contact: bool,
    /// Thickness of a film (oil, coolant) on the part, µm.
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = not_negative)]
    film_um: f64,
    /// Limits of that thickness, ± µm.
    #[arg(long, value_name = "L", default_value_t = 0.0, value_parser = not_negative)]
    limit_film_um: f64,
    /// Distance of the masters' axes from the plane of focus, towards the camera, mm.
    #[arg(long, value_name = "Y", default_value_t = 0.0, allow_negative_numbers = true)]
    masters_y_mm: f64,
    /// Edge that the gauge fits: gaussian or optics; the config's [gauge.esf] without it.
    #[arg(long, value_name = "EDGE", value_parser = fitted_edge)]
    esf: Option<FittedEdge>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("a number of 0 or more is needed".to_owned()),
    }
}

/// A variant by the name that a config gives it.
fn named<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(json!(text)).map_err(|e| e.to_string())
}

fn fitted_edge(text: &str) -> Result<FittedEdge, String> {
    match text {
        "gaussian" => Ok(FittedEdge::Gaussian),
        "optics" => Ok(FittedEdge::Optics),
        _ => Err("gaussian or optics is needed".to_owned()),
    }
}

/// The edge that a config's gauge fits: `learnt` and tables are those of the optics.
pub(crate) fn fitted_by(config: &HeadConfig) -> FittedEdge {
    match config.job.gauge.esf {
        EsfModel::Gaussian {} => FittedEdge::Gaussian,
        _ => FittedEdge::Optics,
    }
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a config, optics or masters that are refused.
pub(super) fn run(args: &LimbArgs) -> CommandResult {
    let config = load_head(&args.config)?;
    let settings = HeadSettings::plain(args.diameter_mm, Date::of(SystemTime::now()));
    let failed = |e| head_failure(&config.file, &e);
    let setup = HeadSetup::new(&config, &settings).map_err(failed)?;
    let surfaces = surfaces(args, &config, &setup)?;
    let fitted = args.esf.unwrap_or_else(|| fitted_by(&config));
    let head = LimbHead::new(&setup, fitted).map_err(failed)?;
    let found = compare(&head, &surfaces).map_err(failed)?;
    if args.json {
        let mut json = serde_json::to_value(&found).map_err(Failure::fail)?;
        json["config"] = json!(config.file);
        json["fitted"] = json!(fitted);
        say_line!("{}", json_text(&json)?);
        return Ok(Outcome::Done);
    }
    say!("{}", in_toml(&config, fitted, &found)?);
    Ok(Outcome::Done)
}

fn surfaces(args: &LimbArgs, config: &HeadConfig, setup: &HeadSetup) -> Result<Surfaces, Failure> {
    let given = &args.masters_mm;
    let masters_mm = if given.is_empty() { setup.masters_mm() } else { given.clone() };
    let (least, most) = masters_mm.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(*d), h.max(*d)));
    if most <= least {
        let what = "--masters-mm: two masters of different diameters are needed, for instance 18,27";
        return Err(Failure::refuse(format!("{}: {what}", config.file)));
    }
    let own = [setup.diameter_mm()];
    let of_part = if args.diameters_mm.is_empty() { &own[..] } else { &args.diameters_mm };
    // The masters' own diameters are part of the range, so that a check on them is corrected, too.
    let range_mm = of_part.iter().fold((least, most), |(l, h), d| (l.min(*d), h.max(*d)));
    let texture = args.part_rq_um.map(Texture::Roughness);
    let finish = Texture::Finish(args.part_finish.unwrap_or(Finish::Turned));
    Ok(Surfaces {
        masters_mm,
        masters_material: args.masters_material,
        part_material: args.part_material,
        masters_finish: args.masters_finish,
        certified_by_contact: args.certified_by_contact,
        part_texture: texture.unwrap_or(finish),
        film_um: (args.film_um, args.limit_film_um),
        range_mm,
        masters_y_mm: args.masters_y_mm,
    })
}

/// The table with what it was made from as comments.
fn in_toml(config: &HeadConfig, fitted: FittedEdge, found: &Comparison) -> Result<String, Failure> {
    #[derive(serde::Serialize)]
    struct File<'a> {
        limb: &'a crate::gauge::calibration::LimbDifference,
    }
    let edge = json!(fitted);
    let mut text = format!("# limbs before {}, as a gauge with the edge {edge} reads them\n", config.file);
    for (mm, um) in &found.masters {
        let _ = writeln!(text, "# master of {mm} mm: {um:+.4} um an edge outside");
    }
    let surfaces = serde_json::to_string(&found.surfaces).map_err(Failure::fail)?;
    let _ = writeln!(text, "# {surfaces}");
    let _ = writeln!(text, "# the cubic leaves {:.4} um at most", found.largest_residual_um);
    text += &toml::to_string(&File { limb: &found.limb }).map_err(Failure::fail)?;
    Ok(text)
}
