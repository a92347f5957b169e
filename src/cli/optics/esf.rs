//! `shadowgauge optics esf`: the edge-spread function of a config's optics as a table.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde_json::json;

use crate::cli::calibration_plan::{self, is_plan};
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::ConfigText;
use crate::config;
use crate::gauge::calibration::Date;
use crate::job::NominalEdge;
use crate::render::settings::{Esf, Optics, SetupSettings};

/// Arguments of `optics esf`.
#[derive(Debug, clap::Args)]
pub(crate) struct EsfArgs {
    /// A job's config, or a calibration's with [simulate].
    config: PathBuf,
    /// Radius of the part, mm, which only the limb of a cylinder and a glancing reflection depend
    /// on; that of the finished part without it.
    #[arg(long, value_name = "R", value_parser = length, allow_negative_numbers = true)]
    radius_mm: Option<f64>,
    /// Distance of the part's axis from the plane of focus, towards the camera, mm.
    #[arg(long, value_name = "Y", default_value_t = 0.0, allow_negative_numbers = true)]
    axis_y_mm: f64,
    /// With the further blur (`extra_sigma_um`: aberration, sensor) of partially coherent light or
    /// a cylinder's limb, as a gauge given CONFIG by --esf fits it.
    #[arg(long)]
    with_blur: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a radius above 0 in mm is needed, for instance 12.5".to_owned()),
    }
}

/// Nominal optics of a config, without random deviations.
pub(crate) struct NominalOptics {
    /// Lens and edge spread.
    pub optics: Optics,
    /// Nominal size of a pixel on the object, mm.
    pub pixel_mm: f64,
    /// Radius of the finished part, or of the middle of the masters, mm.
    pub radius_mm: f64,
}

impl NominalOptics {
    /// The nominal optics of a job's config or of a calibration's with `[simulate]`.
    ///
    /// # Errors
    /// Exit 2 for a config that is refused, or a calibration of recorded frames, which has no
    /// optics.
    pub(crate) fn load(path: &Path) -> Result<Self, Failure> {
        let of = |setup: SetupSettings, radius_mm| Self {
            pixel_mm: setup.nominal_pixel_mm(),
            optics: setup.optics,
            radius_mm,
        };
        if !is_plan(&ConfigText::read(path)?.text) {
            let job = config::load_scene(path).map_err(Failure::refused)?;
            return Ok(of(job.setup_settings(), 0.5 * job.part.drawn_diameter_mm()));
        }
        let plan = calibration_plan::load(path, Date::of(SystemTime::now()))?.plan;
        let Some(simulate) = &plan.simulate else {
            let what =
                "is the calibration of recorded frames and has no optics: give a job's config or [simulate]";
            return Err(Failure::refuse(format!("{}: {what}", path.display())));
        };
        simulate
            .setup()
            .check()
            .map_err(|e| Failure::refuse(format!("{}: simulate: {e}", path.display())))?;
        let sum: f64 = plan.masters.iter().map(|m| 0.5 * m.diameter_mm).sum();
        Ok(of(simulate.setup(), sum / plan.masters.len().max(1) as f64))
    }

    /// The edge-spread function of a cylinder whose axis lies `axis_y_mm` in front of the plane of
    /// focus.
    ///
    /// # Errors
    /// Exit 2 for optics whose table cannot be computed.
    pub(crate) fn edge(&self, radius_mm: f64, axis_y_mm: f64) -> Result<NominalEdge, Failure> {
        NominalEdge::new(&self.optics, self.pixel_mm, radius_mm, axis_y_mm).map_err(Failure::refuse)
    }
}

/// Runs the command.
///
/// # Errors
/// Exit 2 for a config or optics that are refused.
pub(super) fn run(args: &EsfArgs) -> CommandResult {
    if !args.axis_y_mm.is_finite() {
        return Err(Failure::refuse("--axis-y-mm: a finite distance in mm is needed"));
    }
    let mut nominal = NominalOptics::load(&args.config)?;
    let left_out_um = if args.with_blur { 0.0 } else { take_extra_blur(&mut nominal.optics.esf) };
    let radius_mm = args.radius_mm.unwrap_or(nominal.radius_mm);
    let (distance_um, light) = nominal.edge(radius_mm, args.axis_y_mm)?.samples();
    if args.json {
        say_line!(
            "{}",
            json!({
                "config": args.config.display().to_string(),
                "optics": nominal.optics,
                "radius_mm": radius_mm,
                "axis_y_mm": args.axis_y_mm,
                "um_per_px": 1e3 * nominal.pixel_mm,
                "blur_left_out_um": left_out_um,
                "distance_um": distance_um,
                "light": light,
            })
        );
        return Ok(Outcome::Done);
    }
    let mut text = header(args, &nominal, radius_mm, left_out_um)?;
    for (d, l) in distance_um.iter().zip(&light) {
        let _ = writeln!(text, "{d:.6},{l:.9}");
    }
    say!("{text}");
    Ok(Outcome::Done)
}

/// Removes the further blur from partially coherent light (also of a limb) and returns it, µm on
/// the object.
fn take_extra_blur(esf: &mut Esf) -> f64 {
    match esf {
        Esf::PartiallyCoherent(p) => std::mem::take(&mut p.extra_sigma_um),
        Esf::Cylinder(c) => std::mem::take(&mut c.extra_sigma_um),
        _ => 0.0,
    }
}

/// The optics of the table, as comment lines, and the names of its columns.
fn header(
    args: &EsfArgs,
    nominal: &NominalOptics,
    radius_mm: f64,
    left_out_um: f64,
) -> Result<String, Failure> {
    let esf = serde_json::to_value(&nominal.optics.esf).map_err(Failure::fail)?;
    let family = match &nominal.optics.esf {
        // Its samples are the table itself.
        Esf::Measured(_) => "measured".to_owned(),
        _ => esf.to_string(),
    };
    let mut text = format!("# edge-spread function of {}: {family}\n", args.config.display());
    if let Esf::Cylinder(_) = &nominal.optics.esf {
        let _ = writeln!(text, "# limb of a cylinder of radius {radius_mm} mm");
    }
    if let Some(reflection) = &nominal.optics.reflection {
        let reflection = serde_json::to_string(reflection).map_err(Failure::fail)?;
        let _ =
            writeln!(text, "# with glancing reflection of a cylinder of radius {radius_mm} mm: {reflection}");
    }
    let _ = writeln!(
        text,
        "# axis {} mm before the plane of focus (defocus_na {}), {:.6} um on the object a pixel; nominal, departures not drawn",
        args.axis_y_mm,
        nominal.optics.defocus_na,
        1e3 * nominal.pixel_mm
    );
    if left_out_um > 0.0 {
        let _ = writeln!(text, "# without extra_sigma_um = {left_out_um}: --with-blur adds it");
    }
    text += "# distance_um: from the geometric edge into the light, on the object; light: share of the bright field, before the pixel\n";
    text += "distance_um,light\n";
    Ok(text)
}
