//! What is known of a flank before it is seen.

/// Where the corner of the insert lies, as seen along the land.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum CornerSide {
    /// At the end of the land that is nearer to an end of the flank inside of the image.
    #[default]
    Found,
    /// Towards the left of the image.
    Left,
    /// Towards its right.
    Right,
    /// Not in the image: the land is of a straight edge, without zones C and N.
    None,
}

/// At which side of the cutting edge the flank lies in the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "serve", derive(utoipa::ToSchema))]
pub(crate) enum FlankSide {
    /// Not stated: refused where two borders could be the edge.
    #[default]
    Any,
    /// Below the edge.
    Below,
    /// To its right.
    Right,
    /// Above it.
    Above,
    /// To its left.
    Left,
}

impl FlankSide {
    /// Whether a normal into the flank, degrees from the right of the image downwards, may be of
    /// this side: within 60 degrees, so that neighbouring sides share what lies between them.
    pub(crate) fn may_be(self, deg: f64) -> bool {
        let middle = match self {
            Self::Any => return true,
            Self::Right => 0.0,
            Self::Below => 90.0,
            Self::Left => 180.0,
            Self::Above => 270.0,
        };
        between_deg(deg, middle) <= 60.0
    }

    /// Its word, as options and queries have it.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Any => "any",
            Self::Below => "below",
            Self::Right => "right",
            Self::Above => "above",
            Self::Left => "left",
        }
    }
}

/// Angle between two directions, 0 to 180 degrees.
pub(super) fn between_deg(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

/// Settings of one measurement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlankSettings {
    /// Scale in the plane of the flank, µm per px.
    pub um_per_px: f64,
    /// Relative standard uncertainty of the scale.
    pub u_scale: f64,
    /// Angle between the camera's axis and the normal of the flank, in the plane across the edge,
    /// degrees: widths appear shortened by its cosine.
    pub viewing_deg: f64,
    /// Its standard uncertainty, degrees.
    pub u_viewing_deg: f64,
    /// Nose radius, mm: the length of zone C. `None`: no zone C.
    pub nose_radius_mm: Option<f64>,
    /// Where the corner lies.
    pub corner: CornerSide,
    /// At which side of the edge the flank lies.
    pub side: FlankSide,
    /// Curve of the new edge (`FlankMeasurement::curve`), whose bend is taken over.
    pub baseline: Option<Vec<f64>>,
    /// Grey value from which a pixel is saturated; infinite where none is known.
    pub full_scale: f32,
}

impl FlankSettings {
    /// Of a flank seen at right angles at an exact scale in µm per px, without a corner, a side, a
    /// baseline or a full scale.
    pub(crate) fn at_scale(um_per_px: f64) -> Self {
        Self {
            um_per_px,
            u_scale: 0.0,
            viewing_deg: 0.0,
            u_viewing_deg: 0.0,
            nose_radius_mm: None,
            corner: CornerSide::None,
            side: FlankSide::Any,
            baseline: None,
            full_scale: f32::INFINITY,
        }
    }
}
