//! Files of a tool and of a part's outline, in TOML.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::precondition::MeasuredPass;
use super::register::Stated;
use crate::nose::{Feed, Numbering, TipDirection, ToolGeometry};
use crate::outline::{Outline, Side};
use crate::plan::CuttingData;
use crate::setting::{SettingError, positive, require, within};
use crate::shaft::ContourPoint;

/// A turning tool in its holder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolFile {
    /// Nominal nose radius, mm.
    pub nose_radius_mm: f64,
    /// Cutting edge angle of the leading edge (ISO 3002-1), degrees.
    pub kappa_r_deg: f64,
    /// Included angle of the insert in the reference plane, degrees; the trailing edge's angle is
    /// 180° less both.
    pub epsilon_r_deg: f64,
    /// Angle that the trailing edge must keep from a falling surface, degrees.
    #[serde(default)]
    pub clearance_deg: f64,
    /// Tip direction in the control's offset, 0-9: where the gauge point lies beside the nose's
    /// centre.
    pub tip_direction: u8,
    /// Whose numbers `tip_direction` takes.
    #[serde(default)]
    pub numbering: Numbering,
    /// Whether the tool turns shafts or bores.
    #[serde(default)]
    pub side: Side,
    /// The way its leading edge cuts.
    #[serde(default)]
    pub feed: Feed,
    /// Nose radius R in the control's register today, mm; the nominal one where it is not stated.
    #[serde(default)]
    pub register_mm: Option<f64>,
    /// How the camera's image lies in the machine.
    #[serde(default)]
    pub image: ImageAxes,
    /// Where the tool was set with another nose than the one measured.
    #[serde(default)]
    pub setting: SetWith,
    /// The pass after which the nose was measured: cuts that are corrected by it must have its
    /// speed, feed and depth; not compared where it is not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_pass: Option<MeasuredPass>,
}

/// Directions of the machine's axes in the image as seen: 0° to the right, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ImageAxes {
    /// Direction of +X, away from the axis, degrees.
    pub plus_x_deg: f64,
    /// Direction of +Z, towards the tailstock, degrees; at right angles to that of +X.
    pub plus_z_deg: f64,
}

impl Default for ImageAxes {
    fn default() -> Self {
        Self { plus_x_deg: 90.0, plus_z_deg: 0.0 }
    }
}

/// Extremes of the nose with which the offsets were set, about the tool point of the measured one;
/// where they are not stated the tool was set with the measured nose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct SetWith {
    /// Distance of the extreme along X, mm.
    pub x_extent_mm: Option<f64>,
    /// Distance of the extreme along Z, mm.
    pub z_extent_mm: Option<f64>,
    /// Standard uncertainty of either, mm.
    pub u_extent_mm: f64,
}

/// Largest departure of the image's axes from right angles, degrees: what a square of the machine's
/// travels shows in any camera, far above the squareness of lathes.
const SQUARE_DEG: f64 = 0.5;

impl ToolFile {
    /// The tool, checked.
    ///
    /// # Errors
    /// Values out of range, angles that leave no trailing edge, a tip direction that cannot belong
    /// to the side or the feed.
    pub(crate) fn geometry(&self) -> Result<ToolGeometry, SettingError> {
        within("nose_radius_mm", self.nose_radius_mm, 0.01, 20.0, "a radius of 0.01 to 20 mm")?;
        within("kappa_r_deg", self.kappa_r_deg, 10.0, 170.0, "an angle of 10 to 170 degrees")?;
        within("epsilon_r_deg", self.epsilon_r_deg, 5.0, 160.0, "an angle of 5 to 160 degrees")?;
        let kappa_prime = 180.0 - self.kappa_r_deg - self.epsilon_r_deg;
        let right = format!(
            "below {} degrees: kappa_r_deg and epsilon_r_deg must leave an angle to the trailing edge",
            180.0 - self.kappa_r_deg
        );
        require(kappa_prime > 0.0, "epsilon_r_deg", self.epsilon_r_deg, &right)?;
        let right = format!("an angle of 0 to below {kappa_prime} degrees, the trailing edge's");
        require(
            (0.0..kappa_prime).contains(&self.clearance_deg),
            "clearance_deg",
            self.clearance_deg,
            &right,
        )?;
        self.register_mm.map_or(Ok(()), |mm| positive("register_mm", mm))?;
        self.check_image()?;
        self.check_set_with()?;
        self.measured_pass.map_or(Ok(()), |pass| pass.validate())?;
        Ok(ToolGeometry {
            nose_radius_mm: self.nose_radius_mm,
            kappa_r_rad: self.kappa_r_deg.to_radians(),
            epsilon_r_rad: self.epsilon_r_deg.to_radians(),
            clearance_rad: self.clearance_deg.to_radians(),
            tip: self.tip()?,
            side: self.side,
            feed: self.feed,
        })
    }

    /// The extents stated.
    pub(crate) fn stated(&self) -> Stated {
        let s = self.setting;
        Stated { x_mm: s.x_extent_mm, z_mm: s.z_extent_mm, u_mm: s.u_extent_mm }
    }

    fn tip(&self) -> Result<TipDirection, SettingError> {
        let tip = TipDirection::of(self.tip_direction, self.numbering);
        let tip =
            tip.ok_or_else(|| SettingError::of("tip_direction", self.tip_direction, "a number of 0 to 9"))?;
        let (x, x_is) = match self.side {
            Side::External => (-1, "side = \"external\" touches towards the axis"),
            Side::Internal => (1, "side = \"internal\" touches away from the axis"),
        };
        let (z, z_is) = match self.feed {
            Feed::TowardsChuck => (-1, "feed = \"towards_chuck\" leads towards the chuck"),
            Feed::TowardsTailstock => (1, "feed = \"towards_tailstock\" leads towards the tailstock"),
        };
        for (found, wanted, is) in [(tip.x, x, x_is), (tip.z, z, z_is)] {
            if found != 0 && found != wanted {
                let full = TipDirection { x, z }.number(self.numbering);
                let right = format!("a direction that fits the tool, {full} for a tool set in X and Z: {is}");
                return Err(SettingError::of("tip_direction", self.tip_direction, right));
            }
        }
        Ok(tip)
    }

    fn check_image(&self) -> Result<(), SettingError> {
        let ImageAxes { plus_x_deg, plus_z_deg } = self.image;
        within("image.plus_x_deg", plus_x_deg, -360.0, 360.0, "a direction of -360 to 360 degrees")?;
        within("image.plus_z_deg", plus_z_deg, -360.0, 360.0, "a direction of -360 to 360 degrees")?;
        let between = (plus_x_deg - plus_z_deg).to_radians().cos().acos().to_degrees();
        let right = format!("at right angles to plus_x_deg = {plus_x_deg} within {SQUARE_DEG} degrees");
        require((between - 90.0).abs() <= SQUARE_DEG, "image.plus_z_deg", plus_z_deg, &right)
    }

    fn check_set_with(&self) -> Result<(), SettingError> {
        let s = self.setting;
        for (key, value) in [("setting.x_extent_mm", s.x_extent_mm), ("setting.z_extent_mm", s.z_extent_mm)] {
            value.map_or(Ok(()), |mm| within(key, mm, -1e3, 1e3, "a length of -1000 to 1000 mm"))?;
        }
        within("setting.u_extent_mm", s.u_extent_mm, 0.0, 1.0, "an uncertainty of 0 to 1 mm")
    }
}

/// A part's outline, as finished, and how it is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutlineFile {
    /// Whether it is a shaft or a bore.
    #[serde(default)]
    pub side: Side,
    /// Diameter of the bar around it, mm; of a shaft its largest diameter where it is not stated,
    /// of a bore unbounded.
    #[serde(default)]
    pub stock_diameter_mm: Option<f64>,
    /// Diameter of the drilled hole in which a bore is cut, mm; its smallest diameter where it is
    /// not stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hole_diameter_mm: Option<f64>,
    /// Depth of the finishing cut, mm of radius, to be compared with that of the pass after which
    /// the nose was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// Cutting data of the finishing cut.
    pub cutting: CuttingData,
    /// Corners from the chuck to the tailstock, as in `[shaft] contour`; two at one z make a
    /// shoulder or, at diameter 0, the end face.
    pub contour: Vec<ContourPoint>,
}

impl OutlineFile {
    /// The outline, checked.
    ///
    /// # Errors
    /// Corners that make no outline, a bar thinner than the part, cutting data out of range.
    pub(crate) fn outline(&self) -> Result<Outline, SettingError> {
        let outline = Outline::from_corners(&self.contour, self.side)?;
        positive("cutting.speed_m_per_min", self.cutting.speed_m_per_min)?;
        positive("cutting.feed_mm_per_rev", self.cutting.feed_mm_per_rev)?;
        self.depth_mm.map_or(Ok(()), |depth| positive("depth_mm", depth))?;
        self.check_blank(&outline)?;
        Ok(outline)
    }

    /// Bar and hole against the part.
    fn check_blank(&self, outline: &Outline) -> Result<(), SettingError> {
        let largest = 2.0 * outline.largest_radius_mm();
        if let Some(stock) = self.stock_diameter_mm {
            let right = format!("at least the part's largest diameter, {largest} mm");
            require(stock.is_finite() && stock >= largest, "stock_diameter_mm", stock, &right)?;
        }
        let Some(hole) = self.hole_diameter_mm else { return Ok(()) };
        require(
            self.side == Side::Internal,
            "hole_diameter_mm",
            hole,
            "left out: side = \"internal\" has one",
        )?;
        let right = format!("above 0 and at most {largest} mm, the bore's largest diameter");
        require(hole > 0.0 && hole <= largest, "hole_diameter_mm", hole, &right)
    }

    /// Diameter of the hole in which a bore is cut, mm: as stated, else the bore's smallest.
    pub(crate) fn hole_mm(&self, outline: &Outline) -> f64 {
        let least = outline.pieces.iter().flat_map(|p| [p.from.x, p.to.x]).fold(f64::INFINITY, f64::min);
        self.hole_diameter_mm.unwrap_or(2.0 * least)
    }
}
