//! Converts encoded grey values back to light, by `gAMA`, `sRGB`, `iCCP`, `cICP` (PNG),
//! TransferFunction, GrayResponseCurve and ICC profiles (TIFF) and EXIF's colour space (JPEG).
//!
//! An edge-spread function is defined for light. Where grey values are a power of the light, they
//! cross their middle at another place, displaced by about half the blur for a power of 0.45.
//!
//! Curves: sRGB IEC 61966-2-1; BT.709 item 1.2 and the other `cICP` codes ITU-T H.273 table 3;
//! ICC.1:2022 10.6, 10.18.

use std::fmt;

use moxcms::{ColorProfile, DataColorSpace, ToneCurveEvaluator};

use super::error::DecodeError;
use crate::frame::{Buffer, Encoding};

/// Largest ICC profile read, bytes: enough for tone curves and texts; profiles with tables of
/// colours are larger.
const LARGEST_PROFILE: usize = 128 << 10;

/// How grey values encode light, and the tag that states it.
pub(super) struct Transfer {
    pub(super) origin: String,
    curve: Curve,
}

enum Curve {
    /// value = light^exponent
    Power(f64),
    Srgb,
    Bt709,
    /// Light of each value, as a share of the largest.
    Table(Vec<f32>),
    Profile(Box<dyn ToneCurveEvaluator + Send + Sync>),
}

impl fmt::Debug for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.origin, self.encoding())
    }
}

fn refused(origin: &str, what: impl fmt::Display) -> DecodeError {
    DecodeError::Encoding(format!("{origin}: {what}"))
}

impl Transfer {
    /// `gAMA`: 100 000 times the exponent.
    pub(super) fn of_gama(scaled: u32) -> Result<Self, DecodeError> {
        let exponent = f64::from(scaled) / 1e5;
        let origin = format!("gAMA {exponent}");
        // Displays and cameras have exponents from 0.3 to 1; one far outside is a mistake.
        if !(0.1..=10.0).contains(&exponent) {
            return Err(refused(&origin, "no exponent of an image; 0.1 to 10, and 1 for linear values"));
        }
        Ok(Self { origin, curve: Curve::Power(exponent) })
    }

    /// sRGB, by the tag `origin`.
    pub(super) fn srgb(origin: &str) -> Self {
        Self { origin: origin.to_owned(), curve: Curve::Srgb }
    }

    /// `cICP`: primaries, transfer function, matrix, full range. `None` where the function is
    /// unspecified.
    pub(super) fn of_cicp(code: [u8; 4]) -> Result<Option<Self>, DecodeError> {
        let origin = format!("cICP transfer function {}", code[1]);
        if code[3] != 1 {
            return Err(refused(&origin, "values of the narrow range of video; full-range ones are needed"));
        }
        let curve = match code[1] {
            2 => return Ok(None),
            8 => Curve::Power(1.0),
            4 => Curve::Power(1.0 / 2.2),
            5 => Curve::Power(1.0 / 2.8),
            13 => Curve::Srgb,
            1 | 6 | 14 | 15 => Curve::Bt709,
            _ => {
                return Err(refused(
                    &origin,
                    "not linearised here (1, 4, 5, 6, 8, 13, 14 and 15 are); save linear grey values",
                ));
            }
        };
        Ok(Some(Self { origin, curve }))
    }

    /// An ICC profile's tone curve of grey, or of the three primaries where they are equal.
    pub(super) fn of_profile(origin: &str, profile: &[u8]) -> Result<Self, DecodeError> {
        if profile.len() > LARGEST_PROFILE {
            let size = profile.len();
            return Err(refused(
                origin,
                format_args!("a profile of {size} bytes; one of a tone curve has {LARGEST_PROFILE} at most"),
            ));
        }
        let damaged = |e: &dyn fmt::Debug| refused(origin, format_args!("a damaged ICC profile ({e:?})"));
        let profile = ColorProfile::new_from_slice(profile).map_err(|e| damaged(&e))?;
        let curve = match profile.color_space {
            DataColorSpace::Gray => profile.gray_trc,
            DataColorSpace::Rgb
                if profile.red_trc == profile.green_trc && profile.green_trc == profile.blue_trc =>
            {
                profile.green_trc
            }
            _ => None,
        };
        let Some(curve) = curve else {
            return Err(refused(
                origin,
                "an ICC profile without one tone curve for all channels; save linear grey values, or remove the profile \
                 where they are",
            ));
        };
        let curve = curve.make_linear_evaluator().map_err(|e| damaged(&e))?;
        Self { origin: origin.to_owned(), curve: Curve::Profile(curve) }.growing()
    }

    /// A table of light for every grey value: TIFF's TransferFunction.
    pub(super) fn of_table(origin: &str, light: &[f32]) -> Result<Self, DecodeError> {
        let most = light.last().copied().unwrap_or(0.0);
        if light.len() < 2 || !(most > 0.0 && most.is_finite()) {
            return Err(refused(origin, "a table that does not grow from black to white"));
        }
        let light: Vec<f32> = light.iter().map(|l| l / most).collect();
        if light.windows(2).any(|pair| !(pair[0] <= pair[1])) || !(light[0] >= 0.0) {
            return Err(refused(origin, "a table that does not grow from black to white"));
        }
        Self { origin: origin.to_owned(), curve: Curve::Table(light) }.growing()
    }

    fn growing(self) -> Result<Self, DecodeError> {
        let points: Vec<f64> = (0..=64).map(|i| self.light(f64::from(i) / 64.0)).collect();
        let grows = points.windows(2).all(|pair| pair[0] <= pair[1]) && points.iter().all(|p| p.is_finite());
        if grows && points[64] > points[0] {
            return Ok(self);
        }
        Err(refused(&self.origin, "a tone curve that does not grow from black to white"))
    }

    /// The encoding, for comparison between frames.
    pub(super) fn encoding(&self) -> Encoding {
        Encoding::of(|value| self.light(value))
    }

    /// Light of a grey value, both as shares of full scale.
    fn light(&self, value: f64) -> f64 {
        let value = value.clamp(0.0, 1.0);
        match &self.curve {
            Curve::Power(exponent) => value.powf(exponent.recip()),
            Curve::Srgb if value <= 0.040_45 => value / 12.92,
            Curve::Srgb => ((value + 0.055) / 1.055).powf(2.4),
            Curve::Bt709 if value < 0.081 => value / 4.5,
            Curve::Bt709 => ((value + 0.099) / 1.099).powf(1.0 / 0.45),
            Curve::Table(light) => {
                let at = value * (light.len() - 1) as f64;
                let below = (at as usize).min(light.len() - 2);
                let share = at - below as f64;
                f64::from(light[below]) * (1.0 - share) + f64::from(light[below + 1]) * share
            }
            Curve::Profile(curve) => f64::from(curve.evaluate_value(value as f32)),
        }
    }

    /// Grey values proportional to the light, with unchanged full scale.
    ///
    /// # Errors
    /// Floating-point values above 1 without a full scale.
    pub(super) fn linearised(
        &self,
        buffer: Buffer,
        full_scale: Option<f32>,
    ) -> Result<(Buffer, f32), DecodeError> {
        let full = full_scale.unwrap_or(1.0);
        let one = |value: f32| (f64::from(full) * self.light(f64::from(value / full))) as f32;
        let values = match buffer {
            Buffer::U8(values) => {
                let table: Vec<f32> = (0..=u8::MAX).map(|v| one(v.into())).collect();
                values.iter().map(|v| table[usize::from(*v)]).collect()
            }
            Buffer::U16(values) => {
                let most = values.iter().copied().max().unwrap_or(0);
                let table: Vec<f32> = (0..=most).map(|v| one(v.into())).collect();
                values.iter().map(|v| table[usize::from(*v)]).collect()
            }
            Buffer::F32(values) => {
                if let Some(beyond) = values.iter().find(|v| !(0.0..=full).contains(*v)) {
                    return Err(refused(
                        &self.origin,
                        format_args!(
                            "encoded values reach {beyond}, and only those from 0 to {full} stand for light"
                        ),
                    ));
                }
                values.into_iter().map(one).collect()
            }
        };
        Ok((Buffer::F32(values), full))
    }
}
