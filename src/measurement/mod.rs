//! What `shadowgauge measure` prints, as a library: frames in, diameters with uncertainty out.
//!
//! In: a [`Gauge`](crate::gauge::Gauge), a [`Calibration`](crate::gauge::Calibration) (or a scale
//! alone, [`Calibration::from_scale`](crate::gauge::Calibration::from_scale)), the conditions of
//! the part, [`MeasureSettings`] and frames of any source. Out: a [`Measurement`] a frame, whose
//! JSON is an element of `frames` of the command's document, and a `Series` over all of them
//! (statistics, turn, warnings); [`Document`] is the whole. A part seen end-on is measured by
//! `ring`; `nose` is the document of `tool nose`, `flank` that of `tool flank`,
//! whose hand-drawn lands `flank_labels` reads.
//!
//! [`Gauge::measure`](crate::gauge::Gauge::measure) is one frame by itself, [`Stream`] many of one
//! camera. From below: `settings`, `error`, `warning`, `flags`, `result` (a frame's) → `crests`,
//! `stated`, `preparation`, `reference_pin` (a pin beside the part corrects its frame),
//! `turn_frames` (what a revolution keeps of its frames) → `inspector` (millimetres, averages,
//! judgement of a frame) → `turn`, `statistics`, `series` → `stream` → `one_frame`; `watch` is
//! apart from these: presence, trend, validity and alarm of frames that are watched. One more
//! figure of a frame is one more field of `result`, one more result of a series one more field of
//! `series`.

pub(crate) mod by_key;
mod conditions;
mod crests;
mod document;
mod error;
mod flags;
#[cfg(feature = "cli")]
pub(crate) mod flank;
#[cfg(feature = "cli")]
pub(crate) mod flank_labels;
mod inspector;
mod judged;
pub(crate) mod nose;
mod one_frame;
#[cfg(feature = "cli")]
pub(crate) mod paper_nose;
mod preparation;
mod reference_pin;
mod result;
pub mod ring;
mod series;
mod settings;
mod settled_part;
mod settling;
mod stated;
mod statistics;
mod stream;
mod temperature;
mod turn;
mod turn_angles;
mod turn_frames;
mod turn_sizes;
mod warning;
#[cfg(feature = "cli")]
pub(crate) mod watch;

pub use self::conditions::known_conditions;
pub use self::document::Document;
pub use self::error::MeasureError;
pub use self::flags::Flags;
pub use self::judged::{Deciding, Judged, StationJudgement, StationResult, Verdict};
pub use self::reference_pin::ReferencePin;
pub use self::result::{LargestDiameter, Measurement, Place, Refusal};
pub use self::series::Series;
pub use self::settings::MeasureSettings;
pub use self::settling::{Settled, Settling, TurnMeans};
pub use self::statistics::Statistics;
pub use self::stream::Stream;
pub use self::temperature::{ScaleDrift, TemperatureAge, TemperatureSample, Temperatures, ZeroDrift};
pub use self::turn::{SectionUncertainty, TurnForm};
pub use self::turn_angles::{Coverage, Smear};
pub use self::turn_sizes::{JudgedSize, TurnJudged};
pub use self::warning::Warning;
pub(crate) use conditions::{conditions, edge_model};
pub(crate) use preparation::prepared;
