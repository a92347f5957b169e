//! The measurement of the instrument: diameters along z, each with its uncertainty, or a gap with
//! its reason.

use std::fmt;

/// Why there is no value, or why one is impaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Reason {
    /// No transition between light and shadow in this column.
    NoEdge,
    /// Only one edge of the shadow lies in the field.
    OneEdge,
    /// The edge is steeper than is measured: a flank of a thread, a shoulder.
    Steep,
    /// The step is too small against the noise.
    LowContrast,
    /// Part of the edge is clipped at the end of the grey scale (usable, larger uncertainty).
    Clipped,
    /// The whole bright field is saturated and the edge carries no usable grey values.
    Saturated,
    /// The residual of the edge fit is implausibly large for the noise.
    Residual,
    /// The edge does not fit its neighbours.
    Outlier,
    /// The edge is too close to the border of the field.
    Border,
    /// Contamination, a chip or a droplet covers the edge.
    Contaminated,
    /// Rows or columns of the frame repeat each other: it was doubled, filled up or enlarged.
    Repeated,
    /// Two shadows may be two parts or the walls of one, and which it is was not stated.
    SeveralShadows,
    /// The frame could not be read.
    Unreadable,
    /// The frame is blurred otherwise than the masters were: out of focus, or the part moved.
    Blurred,
    /// The diameter contradicts what earlier turns or the pass before showed.
    Implausible,
    /// Too few good columns in the station.
    TooFewColumns,
    /// No frame shows this station.
    NotScanned,
}

impl Reason {
    /// The last one in their order.
    pub(crate) const LAST: Self = Self::NotScanned;

    /// The word used in files, snake_case.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::NoEdge => "no_edge",
            Self::OneEdge => "one_edge",
            Self::Steep => "steep",
            Self::LowContrast => "low_contrast",
            Self::Clipped => "clipped",
            Self::Saturated => "saturated",
            Self::Residual => "residual",
            Self::Outlier => "outlier",
            Self::Border => "border",
            Self::Contaminated => "contaminated",
            Self::Repeated => "repeated",
            Self::SeveralShadows => "several_shadows",
            Self::Unreadable => "unreadable",
            Self::Blurred => "blurred",
            Self::Implausible => "implausible",
            Self::TooFewColumns => "too_few_columns",
            Self::NotScanned => "not_scanned",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A diameter with its standard uncertainties (k = 1).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Diameter {
    /// Caliper diameter, mm.
    pub d_mm: f64,
    /// Standard uncertainty that shrinks with averaging, mm.
    pub u_random_mm: f64,
    /// Standard uncertainty shared by all readings of one calibration, mm.
    pub u_common_mm: f64,
}

impl Diameter {
    /// Combined standard uncertainty, mm (GUM 5.1.2, uncorrelated inputs).
    pub fn u_mm(&self) -> f64 {
        self.u_random_mm.hypot(self.u_common_mm)
    }
}

/// A value with its uncertainty, or the reason why there is none.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// A usable value.
    Value(Diameter),
    /// No usable value.
    Gap(Reason),
}

impl Reading {
    /// The value, where there is one.
    pub fn value(&self) -> Option<Diameter> {
        match self {
            Self::Value(d) => Some(*d),
            Self::Gap(_) => None,
        }
    }
}

/// The reading of one station.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Station {
    /// Middle of the station's z interval, mm.
    pub z_mm: f64,
    /// Mean caliper diameter of the station over its columns and the angles scanned.
    pub reading: Reading,
    /// Effective degrees of freedom of the reading's u; none where u is not estimated from scatter,
    /// or from that of very many values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub freedom: Option<f64>,
}

/// Diameters along z after one pass.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DiameterProfile {
    /// The pass measured, from 1.
    pub pass: u32,
    /// Stations in ascending z.
    pub stations: Vec<Station>,
}
