//! The tool of a run with its measured nose: the `[tool]` table.
//!
//! In: the contour that is turned, a tool and a nose. Out: the contour that this nose leaves when
//! the control drives the program of a way along the part.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::loop_job::LoopJob;
use super::nc_job::NcJob;
use super::part::Part;
use crate::nc::Dialect;
use crate::nose::{Feed, NoseProfile, Support, ToolGeometry};
use crate::outline::{Outline, Side};
use crate::plan::{Contour, FeedDirection};
use crate::process::{NosePath, ToolSettings};
use crate::setting::{SettingError, require};
use crate::tool::{Compensator, Element, Setting, ToolError, ToolFile, Way, moves_of, read_nose};

/// The `[tool]` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunTool {
    /// File of the tool (docs/tool.md), from the folder of this file; it owns nominal radius and
    /// angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// File of its nose as measured or rendered, as `tool compensate --nose` reads it; without one
    /// the contour itself is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nose: Option<String>,
    /// What the program does about the nose.
    pub(crate) way: Way,
    /// What `file` holds, in its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stated: Option<ToolFile>,
    /// The support of the nose, in place of `nose`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) support: Vec<NoseSupport>,
    /// What really cuts where it is not what the program was made for: the truth of a study.
    #[serde(skip)]
    pub(crate) truth: Option<CuttingTruth>,
}

/// A nose that cuts by a program made for another one, on slides that stand off.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CuttingTruth {
    /// The nose.
    pub nose: NoseProfile,
    /// How far the slides stand off along each piece of the outline, (X, Z) in mm, X radial; on
    /// their path beyond the last.
    pub slides_mm: Vec<DVec2>,
}

impl CuttingTruth {
    /// The nose on the path of a program; `by` leads from the program's tool point to the nose's
    /// own.
    pub(crate) fn path(&self, path: &[Element], by: DVec2) -> NosePath {
        let moves = path.iter().flat_map(|element| {
            let by = by + self.slides_mm.get(element.source).copied().unwrap_or(DVec2::ZERO);
            moves_of(std::slice::from_ref(element)).into_iter().map(move |(a, b)| (a + by, b + by))
        });
        NosePath::new(&self.nose, &moves.collect::<Vec<_>>())
    }
}

/// Support of the nose towards a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoseSupport {
    /// Angle of the surface's normal: 0 on a cylinder, 90 on an end face, degrees.
    pub normal_deg: f64,
    /// Support, µm.
    pub h_um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
}

/// Numbers of two files that are the same, degrees or mm: rounding of decimals.
const SAME: f64 = 1e-9;
/// Directions of the support that is kept, rad: those of the usual file.
const KEPT_RAD: f64 = std::f64::consts::PI / 180.0;

impl RunTool {
    /// Takes the contents of a nose's file in place of its name; `text` is that of the file.
    ///
    /// # Errors
    /// No tool beside it, or text that is no nose.
    pub(crate) fn take_nose(&mut self, text: &str) -> Result<(), SettingError> {
        let tool = self.needed()?;
        let name = self.nose.take().unwrap_or_default();
        let in_file = |e: ToolError| SettingError::at("tool.nose", format!("{name}: {e}"));
        let nose = read_nose(text, None, tool.image, &geometry(&tool)?).map_err(in_file)?.profile;
        let row = |(a, h): (f64, f64)| NoseSupport {
            normal_deg: a.to_degrees(),
            h_um: 1e3 * h,
            u_um: 1e3 * nose.u_of(&nose.weights(a)),
        };
        self.support = nose.supports(KEPT_RAD).into_iter().map(row).collect();
        Ok(())
    }

    /// Fills `[process.tool]` from the tool; `is_set` is whether the config sets a key itself.
    ///
    /// # Errors
    /// A key that contradicts the tool's.
    pub(crate) fn fill(
        &self,
        process: &mut ToolSettings,
        is_set: impl Fn(&str) -> bool,
    ) -> Result<(), SettingError> {
        let Some(tool) = &self.stated else { return Ok(()) };
        geometry(tool)?;
        // beyond 90° the chip is 1/sin κ_r wider, .14 % at 93°: the force laws end at 90°
        let lead_deg = tool.kappa_r_deg.min(90.0);
        let minor_deg = 180.0 - tool.kappa_r_deg - tool.epsilon_r_deg;
        let pairs = [
            (&mut process.nose_radius_mm, tool.nose_radius_mm, "nose_radius_mm", "nose_radius_mm"),
            (&mut process.lead_angle_deg, lead_deg, "lead_angle_deg", "kappa_r_deg"),
            (&mut process.minor_angle_deg, minor_deg, "minor_angle_deg", "180 - kappa_r_deg - epsilon_r_deg"),
        ];
        for (value, wanted, own, its) in pairs {
            let key = format!("process.tool.{own}");
            if is_set(&key) && (*value - wanted).abs() > SAME {
                let right = format!(
                    "{wanted} as {its} in the tool's file (tool.file): leave {key} out, or correct one of them"
                );
                return Err(SettingError::of(key, *value, right));
            }
            *value = wanted;
        }
        Ok(())
    }

    fn needed(&self) -> Result<ToolFile, SettingError> {
        self.stated.ok_or_else(|| {
            let why = "a nose needs its tool: tool.file names the file with nominal radius and angles";
            SettingError::at("tool.file", why)
        })
    }

    /// What is not checked of the tool, for a warning.
    pub(super) fn caution(&self) -> Option<String> {
        let is_open = !self.support.is_empty() && self.stated.is_some_and(|t| t.measured_pass.is_none());
        is_open.then(|| {
            "measured_pass of the tool (tool.file) is not stated: whether the cut has the speed, feed and depth of the pass              after which the nose was measured is not checked"
                .to_owned()
        })
    }

    /// The nose; none where the tool leaves the contour itself.
    fn profile(&self) -> Result<Option<NoseProfile>, SettingError> {
        let unread = [("tool.file", &self.file), ("tool.nose", &self.nose)];
        if let Some((key, _)) = unread.into_iter().find(|(_, name)| name.is_some()) {
            let why = "a file beside a config is read with the config's own file; text alone needs tool.stated and tool.support";
            return Err(SettingError::at(key, why));
        }
        if self.support.is_empty() {
            return Ok(None);
        }
        let row = |s: &NoseSupport| Support {
            a_rad: s.normal_deg.to_radians(),
            h_mm: 1e-3 * s.h_um,
            u_mm: 1e-3 * s.u_um,
        };
        let rows: Vec<Support> = self.support.iter().map(row).collect();
        let made = NoseProfile::new(&rows, None, 0.0);
        made.map(Some).map_err(|e| SettingError::at("tool.support", e.to_string()))
    }

    /// The nose on the path of its program along a part; none without a nose.
    ///
    /// # Errors
    /// A tool that cannot turn this part, a place that tool or nose do not reach, a path that
    /// gouges, each with its place.
    pub(super) fn path(&self, part: &LoopJob, nc: Option<&NcJob>) -> Result<Option<NosePath>, SettingError> {
        let Some(nose) = self.profile()? else { return Ok(None) };
        let tool = self.needed()?;
        let geometry = geometry(&tool)?;
        check_side_and_feed(&tool, part)?;
        if let Some(measured) = tool.measured_pass {
            let depth_mm = last_depth_mm(&part.part).map(|depth| ("part.nominal_diameter_mm", depth));
            measured.allows(&part.cutting, depth_mm)?;
        }
        let outline = Outline::from_corners(&part.contour, Side::External)
            .map_err(|e| SettingError { key: format!("shaft.{}", e.key), ..e })?;
        let refused = |e: ToolError| match e {
            ToolError::Setting(e) => in_tool(&e),
            ToolError::Register { .. } => SettingError::at("tool.file", e.to_string()),
            other => SettingError::at("tool.nose", other.to_string()),
        };
        let dialect = nc.map_or(Dialect::Fanuc, |nc| nc.dialect);
        let compensator = Compensator {
            outline: &outline,
            setting: Setting::new(&nose, &geometry, &tool.stated()).map_err(refused)?,
            register_mm: tool.register_mm.unwrap_or(tool.nose_radius_mm),
            register_range_mm: dialect.nose_register_mm(),
            increment_mm: 10f64.powi(-(dialect.x_decimals() as i32)),
        };
        compensator.check(&geometry).map_err(refused)?;
        let done = compensator.carry_out(self.way).map_err(refused)?;
        let Some(truth) = &self.truth else {
            return Ok(Some(NosePath::new(&nose, &moves_of(&done.path))));
        };
        let real = Setting::new(&truth.nose, &geometry, &tool.stated()).map_err(refused)?;
        Ok(Some(truth.path(&done.path, compensator.setting.to_tool_point_of(&real))))
    }
}

/// The contour that is left where the nose does not leave the drawn one.
///
/// # Errors
/// A place that no position of the nose comes to.
pub(super) fn worn(part: &LoopJob, drawn: &Contour, path: &NosePath) -> Result<Contour, SettingError> {
    let ends = (0.0, part.part.length_mm);
    let knots = path.surface(ends).map_err(|z| {
        SettingError::at(
            "tool.nose",
            format!("at z = {z:.3} mm no place of the nose's path leaves a surface"),
        )
    })?;
    Ok(super::sections::with_surface(drawn, &part.contour, &knots))
}

/// Depth of the last pass, mm of radius; none of a part without passes.
fn last_depth_mm(part: &Part) -> Option<f64> {
    let last = part.nominal_diameter_mm.last()?;
    let before = part.nominal_diameter_mm.iter().rev().nth(1).unwrap_or(&part.stock_diameter_mm);
    Some(0.5 * (before - last))
}

fn check_side_and_feed(tool: &ToolFile, part: &LoopJob) -> Result<(), SettingError> {
    require(tool.side == Side::External, "tool.file", "side = \"internal\"", "a tool for shafts")?;
    if part.contour.is_empty() {
        let why = "a nose leaves its mark on a contour, and there is none: give the corners, two of them for a plain shaft";
        return Err(SettingError::at("shaft.contour", why));
    }
    let (feed, word) = match tool.feed {
        Feed::TowardsChuck => (FeedDirection::TowardsChuck, "towards_chuck"),
        Feed::TowardsTailstock => (FeedDirection::TowardsTailstock, "towards_tailstock"),
    };
    let right = format!("the feed of the tool in tool.file, \"{word}\"");
    let key = "process.pass.feed_direction";
    require(part.feed_direction == feed, key, format!("{:?}", part.feed_direction), &right)
}

fn geometry(tool: &ToolFile) -> Result<ToolGeometry, SettingError> {
    tool.geometry().map_err(|e| in_tool(&e))
}

/// An error of the tool's file at the key that names it.
fn in_tool(error: &SettingError) -> SettingError {
    SettingError::at("tool.file", error.to_string())
}
