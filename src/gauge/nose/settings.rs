//! Settings of the nose measurement.

/// What a tool's file states of its nose in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExpectedNose {
    /// Included angle ε_r, degrees.
    pub epsilon_deg: f64,
    /// Directions of the outward normals of both edges, counter-clockwise over the nose, degrees.
    pub normals_deg: [f64; 2],
    /// What states them.
    pub by: &'static str,
}

/// What is known of the insert before it is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NoseSettings {
    /// Nominal nose radius, px: the centre lies at it from both edges. `None`: of the circle that
    /// touches both and fits the nose where it is not worn.
    pub nominal_radius_px: Option<f64>,
    /// Scale, µm per px, by which a worn nose without a nominal radius is given the next one of ISO
    /// 1832.
    pub um_per_px: f64,
    /// The tool, where its file is given.
    pub expected: Option<ExpectedNose>,
}
