//! Films that adhere to the shaft and turn with it, and the rise of the silhouette by them.
//!
//! A film is a bump of the radius, t·cos²(πu/2)·cos²(πv/2) with u, v the places along and around it
//! in units of its half extents. A liquid film is transparent, but it deflects grazing rays out of
//! the beam: at the silhouette it counts as opaque. The support function is exact, max over θ of
//! (R + film)·cos(θ + φ).

use std::f64::consts::{FRAC_PI_2, TAU};

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::field::{draw_size, poisson};
use super::settings::Contamination;
use crate::render::error::RenderError;

const FILM_STREAM: u64 = 0x66_696c_6d73;

/// Steps over the facing arc and of the search for the highest point: a maximum found to 1e-7 of
/// the film's thickness.
const STEPS: usize = 32;
const GOLDEN_STEPS: usize = 24;

/// One film on the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Film {
    /// Machine z of its middle, mm.
    pub z_mm: f64,
    /// Body angle of its middle, degrees.
    pub theta_deg: f64,
    /// Half extent along the shaft, mm.
    pub half_length_mm: f64,
    /// Half extent around the shaft, degrees.
    pub half_width_deg: f64,
    /// Thickness in the middle, mm.
    pub thickness_mm: f64,
}

impl Film {
    /// Height over the clean surface, mm.
    pub(crate) fn height_mm(&self, z_mm: f64, theta_deg: f64) -> f64 {
        let away = (theta_deg - self.theta_deg + 180.0).rem_euclid(360.0) - 180.0;
        self.thickness_mm * bump((z_mm - self.z_mm) / self.half_length_mm) * bump(away / self.half_width_deg)
    }
}

fn bump(u: f64) -> f64 {
    if u.abs() < 1.0 { (FRAC_PI_2 * u).cos().powi(2) } else { 0.0 }
}

/// All films of a shaft.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AdheringFilms {
    films: Vec<Film>,
}

impl AdheringFilms {
    /// The given films.
    pub(crate) fn new(films: Vec<Film>) -> Self {
        Self { films }
    }

    /// Draws the films of a shaft of mean radius `radius_mm` over `z_mm`; the same seed gives the
    /// same films.
    ///
    /// # Errors
    /// Refuses settings outside their ranges and more than a hundred thousand films.
    pub(crate) fn draw(
        settings: &Contamination,
        radius_mm: f64,
        z_mm: std::ops::Range<f64>,
        seed: u64,
    ) -> Result<Self, RenderError> {
        settings.check()?;
        let films = &settings.films;
        let mut random = Pcg64::seed_from_u64(seed ^ FILM_STREAM);
        let length = (z_mm.end - z_mm.start).max(0.0);
        let area_cm2 = TAU * radius_mm * length / 100.0;
        let count = poisson("contamination.films.per_cm2", films.per_cm2 * area_cm2, &mut random)?;
        let unit = Uniform::new(0.0, 1.0)
            .map_err(|e| RenderError::setting("contamination.films", &0.0, e.to_string()))?;
        let films = (0..count)
            .map(|_| {
                let z = z_mm.start + length * unit.sample(&mut random);
                let theta_deg = 360.0 * unit.sample(&mut random);
                let half_length_mm = draw_size(&films.half_extent_um, &mut random) * 1e-3;
                let around_mm = draw_size(&films.half_extent_um, &mut random) * 1e-3;
                let thickness_mm = draw_size(&films.thickness_um, &mut random) * 1e-3;
                let half_width_deg = (around_mm / radius_mm.max(1e-6)).to_degrees().min(180.0);
                Film { z_mm: z, theta_deg, half_length_mm, half_width_deg, thickness_mm }
            })
            .collect();
        Ok(Self { films })
    }

    /// The films.
    pub(crate) fn films(&self) -> &[Film] {
        &self.films
    }

    /// Height of all films over the clean surface, mm.
    pub(crate) fn height_mm(&self, z_mm: f64, theta_deg: f64) -> f64 {
        self.films.iter().map(|f| f.height_mm(z_mm, theta_deg)).sum()
    }

    /// The films over a z that reach within `within_deg` of a body angle.
    fn facing(&self, z_mm: f64, theta_deg: f64, within_deg: f64) -> Self {
        let reaches = |f: &&Film| {
            let away = (theta_deg - f.theta_deg + 180.0).rem_euclid(360.0) - 180.0;
            (z_mm - f.z_mm).abs() < f.half_length_mm && away.abs() <= f.half_width_deg + within_deg
        };
        Self { films: self.films.iter().filter(reaches).copied().collect() }
    }

    /// Rise of the tangent at the top (direction x) by the films over that of the clean circle of
    /// `radius_mm`, mm, at spindle angle `angle_deg`. The bottom edge is the top edge at
    /// `angle_deg + 180`.
    pub(crate) fn rise_mm(&self, radius_mm: f64, z_mm: f64, angle_deg: f64) -> f64 {
        let thickest: f64 = self
            .films
            .iter()
            .filter(|f| (z_mm - f.z_mm).abs() < f.half_length_mm)
            .map(|f| f.thickness_mm)
            .sum();
        if thickest <= 0.0 || radius_mm <= 0.0 {
            return 0.0;
        }
        // A point at δ from the top can be the highest only if (R + t) cos δ ≥ R.
        let arc = (radius_mm / (radius_mm + thickest)).acos();
        let step = 2.0 * arc / STEPS as f64;
        let facing = self.facing(z_mm, -angle_deg, (arc + step).to_degrees());
        if facing.films.is_empty() {
            return 0.0;
        }
        let rise = |delta: f64| {
            let film = facing.height_mm(z_mm, delta.to_degrees() - angle_deg);
            (radius_mm + film) * delta.cos() - radius_mm
        };
        let best = (0..=STEPS).map(|i| -arc + i as f64 * step).fold((0.0, 0.0), |best: (f64, f64), delta| {
            let height = rise(delta);
            if height > best.1 { (delta, height) } else { best }
        });
        highest(rise, best.0 - step, best.0 + step).max(best.1)
    }
}

/// Golden-section search for the maximum between `a` and `b`.
fn highest(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let share = 2.0 / (1.0 + 5f64.sqrt());
    for _ in 0..GOLDEN_STEPS {
        let (c, d) = (b - share * (b - a), a + share * (b - a));
        if f(c) > f(d) { b = d } else { a = c }
    }
    f(0.5 * (a + b))
}
