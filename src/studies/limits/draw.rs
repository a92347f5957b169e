//! Frames drawn for the study: a small sensor before light, a shadow with edges of a chosen shape.
//!
//! Pixel-integrated edges, light and noise as EMVA 1288 has them, the end of the grey scale where a
//! camera clips. Everything is drawn from one generator, so that a seed gives the same frames.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::frame::{Buffer, Frame, FrameError, FrameMeta, PixelFormat};
use crate::numerics::distributions::phi_cdf;
use crate::studies::dirty_frames::step;

/// Draws of one scene.
pub(super) struct Random(Pcg64);

impl Random {
    /// Of a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Evenly between two values; the first one where they do not rise.
    pub(super) fn within(&mut self, (low, high): (f64, f64)) -> f64 {
        Uniform::new(low, high).map_or(low, |uniform| uniform.sample(&mut self.0))
    }

    /// A standard normal draw.
    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// One of two at random.
    pub(super) fn heads(&mut self) -> bool {
        self.within((0.0, 1.0)) < 0.5
    }
}

/// A camera: where it clips, in what container, and what noise it adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    pub(super) format: PixelFormat,
    /// Largest grey value.
    pub(super) clip: f64,
    /// Grey values are multiples of this; 0 of floating point.
    pub(super) step: f64,
    /// Share of hot pixels.
    pub(super) hot: f64,
    /// Noise at the clip as a share of it: of the read-out, of the photons.
    pub(super) noise: (f64, f64),
    /// Share of the clip from which on the response bends towards it; none of a linear one.
    pub(super) knee: Option<f64>,
}

impl Camera {
    /// Eight bits with ordinary noise.
    pub(super) const EIGHT: Self = Self {
        format: PixelFormat::Mono8,
        clip: 255.0,
        step: 1.0,
        hot: 0.0,
        noise: (0.004, 0.008),
        knee: None,
    };

    /// A frame of light given as shares of the clip.
    pub(super) fn expose(
        &self,
        (rows, columns): (usize, usize),
        random: &mut Random,
        share: impl Fn(usize, usize) -> f64,
    ) -> Result<Frame, FrameError> {
        let (read, photons) = (self.noise.0 * self.clip, self.noise.1.powi(2) * self.clip);
        let mut values = Vec::with_capacity(rows * columns);
        for index in 0..rows * columns {
            let mean = self.clip * share(index / columns, index % columns);
            let noise = (read * read + photons * mean.max(0.0)).sqrt() * random.normal();
            let hot = self.hot > 0.0 && random.within((0.0, 1.0)) < self.hot;
            let value = if hot { self.clip } else { self.bent(mean + noise) };
            let whole = if self.step > 0.0 { (value / self.step).round() * self.step } else { value };
            values.push(whole.clamp(0.0, self.clip));
        }
        let buffer = match self.format {
            PixelFormat::Mono8 => Buffer::U8(values.iter().map(|v| *v as u8).collect()),
            PixelFormat::F32 => Buffer::F32(values.iter().map(|v| *v as f32).collect()),
            _ => Buffer::U16(values.iter().map(|v| *v as u16).collect()),
        };
        Frame::new(buffer, self.format, rows, columns, FrameMeta::default())
    }

    /// What a soft knee leaves of a grey value: it nears the clip exponentially.
    fn bent(&self, value: f64) -> f64 {
        let Some(knee) = self.knee.map(|share| share * self.clip).filter(|knee| value > *knee) else {
            return value;
        };
        let left = self.clip - knee;
        knee + left * (1.0 - (-(value - knee) / left).exp())
    }
}

/// How the light falls over the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fall {
    Even,
    /// To between a quarter and two thirds, along the shaft.
    Along,
    /// The same across it.
    Across,
    /// A spot round a point in the middle half of the field.
    Spot,
    /// To 0.6 of it along the shaft: half of a shaft below the clip.
    Half,
}

impl Fall {
    /// Light at (row, column), both 0 to 1, as a share of its most.
    pub(super) fn field(self, random: &mut Random) -> Box<dyn Fn(f64, f64) -> f64> {
        let ratio = random.within((1.5, 4.0));
        let turned = random.heads();
        let (y, x) = (random.within((0.25, 0.75)), random.within((0.25, 0.75)));
        let along = move |t: f64| 1.0 - (1.0 - 1.0 / ratio) * if turned { 1.0 - t } else { t };
        match self {
            Self::Even => Box::new(|_, _| 1.0),
            Self::Along => Box::new(move |_, c| along(c)),
            Self::Across => Box::new(move |r, _| along(r)),
            Self::Spot => Box::new(move |r, c| ratio.powf(-((r - y).powi(2) + (c - x).powi(2)) / 0.8)),
            Self::Half => Box::new(|_, c| 1.0 - 0.4 * c),
        }
    }
}

/// The shape of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Gaussian,
    /// A tenth of the light in a blur three times as wide.
    Tailed,
    /// An overshoot of a tenth beside it, odd about the half: light of some coherence.
    Ringing,
    /// Blur that grows by half along the shaft.
    Widening,
}

impl Shape {
    /// Light of a pixel whose centre lies `d` px in the light, at 0 to 1 along the shaft.
    pub(super) fn light(self, d: f64, sigma: f64, along: f64) -> f64 {
        match self {
            Self::Gaussian => step(d, sigma),
            Self::Tailed => 0.9 * step(d, sigma) + 0.1 * step(d, 3.0 * sigma),
            Self::Ringing => step(d, sigma) + 0.1 * (d / sigma) * (-0.25 * (d / sigma).powi(2)).exp(),
            Self::Widening => step(d, sigma * (1.0 + 0.5 * along)),
        }
    }
}

/// Light of a pixel at (dy, dx) from the centre of a disc: 8 × 8 points of its edge, blurred as a
/// straight one is; a blurred disc's half of the light stands σ²/2R inside it (Laplacian of a
/// curved step).
pub(super) fn outside(dy: f64, dx: f64, radius: f64, sigma: f64) -> f64 {
    if (dy.hypot(dx) - radius).abs() > 7.0 * sigma + 1.0 {
        return if dy.hypot(dx) > radius { 1.0 } else { 0.0 };
    }
    let points = (0..64).map(|k| {
        let (y, x) = ((f64::from(k / 8) + 0.5) / 8.0 - 0.5, (f64::from(k % 8) + 0.5) / 8.0 - 0.5);
        let d = (dy + y).hypot(dx + x) - radius + sigma * sigma / (2.0 * radius);
        phi_cdf(d / sigma)
    });
    points.sum::<f64>() / 64.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_has_half_its_light_at_its_place() {
        for shape in [Shape::Gaussian, Shape::Tailed, Shape::Ringing, Shape::Widening] {
            let at = |d| shape.light(d, 1.1, 0.5);
            assert!((at(0.0) - 0.5).abs() < 1e-12, "{shape:?}");
            assert!(at(-9.0).abs() < 1e-3 && (at(9.0) - 1.0).abs() < 1e-3, "{shape:?}: {}", at(9.0));
        }
    }

    #[test]
    fn a_seed_gives_the_same_frame() {
        let frame = |seed| {
            let mut random = Random::new(seed);
            Camera::EIGHT.expose((20, 30), &mut random, |_, _| 0.5).unwrap()
        };
        assert_eq!(frame(3), frame(3));
        assert_ne!(frame(3), frame(4));
    }
}
