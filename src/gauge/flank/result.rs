//! Results of a flank measurement, µm; places are (column, row), px.

use glam::DVec2;

/// A width with its uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct Width {
    /// Width of the land, µm.
    pub um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
}

/// Rows of the budget of VBB, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct FlankBudget {
    /// Where the border of the land lies, by the spread of its path.
    pub border_um: f64,
    /// The reference line.
    pub reference_um: f64,
    /// The model: its errors on flanks that it was not trained on.
    pub model_um: f64,
    /// The scale.
    pub scale_um: f64,
    /// The viewing angle.
    pub viewing_um: f64,
}

/// A flank as measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlankMeasurement {
    /// Mean over zone B.
    pub vbb: Width,
    /// Largest in zone B.
    pub vbb_max: Width,
    /// Largest in zone C; `None` without a nose in the image or its radius.
    pub vc: Option<Width>,
    /// Largest in zone N; `None` without a nose in the image.
    pub vn: Option<Width>,
    /// Length over which the edge is worn, µm.
    pub worn_length_um: f64,
    /// Rows of u(VBB).
    pub budget: FlankBudget,
    /// Width in every column of the strip, and its standard uncertainty, µm.
    pub widths: Vec<Width>,
    /// Distance of two columns, µm.
    pub column_um: f64,
    /// First and last worn column.
    pub worn: (usize, usize),
    /// Reference and border in the image, a pair a column.
    pub places: Vec<[DVec2; 2]>,
    /// The reference curve: px into the flank by powers of s/length.
    pub curve: Vec<f64>,
    /// What limits the use of the measurement.
    pub flags: Vec<&'static str>,
}
