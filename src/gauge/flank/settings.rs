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
    /// Curve of the new edge (`FlankMeasurement::curve`), whose bend is taken over.
    pub baseline: Option<Vec<f64>>,
    /// Grey value from which a pixel is saturated; infinite where none is known.
    pub full_scale: f32,
}

impl FlankSettings {
    /// Of a flank seen at right angles, without a corner, a baseline or a full scale, at an exact
    /// scale in µm per px.
    pub(crate) fn at_scale(um_per_px: f64) -> Self {
        Self {
            um_per_px,
            u_scale: 0.0,
            viewing_deg: 0.0,
            u_viewing_deg: 0.0,
            nose_radius_mm: None,
            corner: CornerSide::None,
            baseline: None,
            full_scale: f32::INFINITY,
        }
    }
}
