//! Curves of the reproduction, for plots.

/// What is left over the angle of the surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// Setting and register.
    pub name: String,
    /// Angle of the normal, degrees, and e, µm.
    pub points: Vec<(f64, f64)>,
}

/// A workpiece's mean errors as distances along the normal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartError {
    /// Its number.
    pub part: usize,
    /// Angle of the surface's normal, degrees; of a cone the one stated or needed.
    pub a_deg: f64,
    /// Before compensation, µm.
    pub before_um: f64,
    /// After it, µm.
    pub after_um: f64,
}

/// All curves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curves {
    /// e(a) by each register.
    pub e: Vec<Curve>,
    /// The workpieces.
    pub parts: Vec<PartError>,
    /// d = R1 − r, µm.
    pub d_um: f64,
}
