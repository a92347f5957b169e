//! Why a program cannot be written.

use crate::setting::SettingError;

/// A program that cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum NcError {
    /// A value of the `[nc]` table is out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Stations, offsets or knots that do not fit together.
    #[error("{0}")]
    Plan(String),
    /// A point of the path lies outside the range allowed.
    #[error("range check: X {x_mm} mm at Z {z_mm} mm lies outside {low_mm} to {high_mm} mm")]
    Range {
        /// Diameter commanded.
        x_mm: f64,
        /// Place.
        z_mm: f64,
        /// Least diameter allowed.
        low_mm: f64,
        /// Largest diameter allowed.
        high_mm: f64,
    },
    /// The machine's data lack what differs between machines with this control.
    #[error(
        "{dialect} leaves open what the machine's data must state (nc --machine FILE, [nc.machine]): {missing}"
    )]
    Unstated {
        /// The dialect.
        dialect: &'static str,
        /// Keys, and where to look up their values.
        missing: String,
    },
    /// A block of the finished program makes a forbidden move.
    #[error("the program is refused: block {block} ({text}): {what}")]
    Block {
        /// Number of the line, from 1.
        block: usize,
        /// The line.
        text: String,
        /// Why it is refused.
        what: String,
    },
}
