//! Where the part stood when a frame was exposed: spindle angle by an encoder, as values alone.
//!
//! `encoder` holds the settings of a job (`[scan.encoder]`) and how a count becomes an angle at
//! mid-exposure; `binding` takes the counts of all frames of a scan to angles, or voids the turns
//! in which a trigger was ignored or doubled or the index pulse contradicts the count;
//! `interpolation` gives a count between latched samples, by which `sampled` binds frames to an
//! encoder that is sampled beside them; `triggered` binds frames by the numbers of their triggers
//! alone, and `mid_exposure` moves angles that were latched at the start of exposure. `smear` is
//! what the exposure takes from lobes of a turning part, `coverage` which angles a set of frames
//! leaves out.
//!
//! In: counts, times, exposures. Out: angles in degrees with a reason where there is none; nothing
//! is guessed. One more way of binding is a file beside `binding` that returns [`Place`]s.

mod binding;
mod coverage;
mod encoder;
mod interpolation;
mod mid_exposure;
mod sampled;
mod smear;
mod triggered;

pub use binding::{Latched, Place, bind, bind_triggers};
pub use coverage::{AngleCover, Uncovered};
pub use encoder::{EncoderDirection, EncoderSettings, LatchedAt};
pub use interpolation::{Sample, interpolated};
pub use mid_exposure::{MidExposure, Moved, shorter_way_deg};
pub use sampled::{EncoderSample, Exposure, SampledEncoder, SampledPlace};
pub use smear::{attenuation, corrected_amplitude_mm, u_uncorrected_mm};
pub use triggered::{TriggerCount, Triggered};
