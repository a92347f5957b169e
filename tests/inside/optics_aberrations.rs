//! Coma, astigmatism, spherical aberration and defocus of a partially coherent edge against an
//! integral over the two-dimensional pupil and source, coded apart.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use std::f64::consts::{PI, TAU};

use crate::render::optics::edge_spread::{PartiallyCoherentEdge, edge_in_field};
use crate::render::optics::lens::FieldAberrations;

/// Zernike coefficients of a lens at one place, in waves, by their definition over the pupil (p
/// into the light of the edge, q along it).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lens {
    pub(super) spherical: f64,
    pub(super) coma: f64,
    pub(super) astigmatism: f64,
    /// Direction from the middle of the field, from into the light.
    pub(super) psi: f64,
    /// Plane of focus from the edge towards the camera, λ/NA².
    pub(super) focus: f64,
}

impl Lens {
    /// Phase of the pupil, rad.
    fn phase(&self, p: f64, q: f64) -> f64 {
        let (rho, theta) = (p.hypot(q), q.atan2(p) - self.psi);
        let waves = self.spherical * 5f64.sqrt() * (6.0 * rho.powi(4) - 6.0 * rho * rho + 1.0)
            + self.coma * 8f64.sqrt() * (3.0 * rho.powi(3) - 2.0 * rho) * theta.cos()
            + self.astigmatism * 6f64.sqrt() * rho * rho * (2.0 * theta).cos();
        -(TAU * waves + PI * self.focus * rho * rho)
    }
}

/// Light `x` λ/NA into the light of an edge: one of the edges of a grating in its harmonics, every
/// one at its place in the pupil, the source in rings of equal area.
pub(super) fn judge(s: f64, lens: &Lens, x: f64) -> f64 {
    const PERIOD: f64 = 200.0;
    const RINGS: i32 = 24;
    const AROUND: i32 = 32;
    let (mut sum, mut full) = (0.0, 0.0);
    for source in 0..RINGS * AROUND {
        let r = s * ((f64::from(source / AROUND) + 0.5) / f64::from(RINGS)).sqrt();
        let (sin, cos) = (TAU * (f64::from(source % AROUND) + 0.5) / f64::from(AROUND)).sin_cos();
        let (p0, q) = (r * cos, r * sin);
        full += f64::from(u8::from(r < 1.0));
        let chord = (1.0 - q * q).max(0.0).sqrt();
        let first = ((-chord - p0) * PERIOD).ceil() as i32;
        let last = ((chord - p0) * PERIOD).floor() as i32;
        let (mut re, mut im) = (0.0, 0.0);
        for n in (first..=last).filter(|n| *n == 0 || n % 2 != 0) {
            let f = f64::from(n) / PERIOD;
            let (sin, cos) = (lens.phase(f + p0, q) + TAU * f * x).sin_cos();
            // Light on half of the period: 1/2 at n = 0, 1/(iπn) at odd n.
            let (a, b) = if n == 0 {
                (0.5 * cos, 0.5 * sin)
            } else {
                (sin / (PI * f64::from(n)), -cos / (PI * f64::from(n)))
            };
            (re, im) = (re + a, im + b);
        }
        sum += re * re + im * im;
    }
    sum / full
}

/// Largest difference over ±3.3 λ/NA between the table of a place and the integral.
fn worst(edge: &PartiallyCoherentEdge, row: FieldAberrations, place: [f64; 2]) -> f64 {
    let table = edge_in_field(edge, &[row], place, 0.0).unwrap();
    let unit_um = 1e-3 * edge.wavelength_nm / edge.na;
    let waves = |nm: f64| nm / edge.wavelength_nm;
    let height: f64 = place[0].hypot(place[1]);
    let lens = Lens {
        spherical: waves(row.spherical_nm),
        // A lens of third order.
        coma: waves(row.coma_nm) * height,
        astigmatism: waves(row.astigmatism_nm) * height * height,
        psi: place[1].atan2(place[0]),
        focus: -1e3 * edge.defocus_mm * edge.na / unit_um,
    };
    let differ = |k: i32| {
        let x = 0.55 * f64::from(k);
        (table.value(x * unit_um) - judge(edge.coherence_ratio, &lens, x)).abs()
    };
    (-6..=6).map(differ).fold(0.0, f64::max)
}

#[test]
fn aberrations_meet_the_integral_over_pupil_and_source() {
    let row = |spherical_nm, coma_nm, astigmatism_nm| FieldAberrations {
        field: 1.0,
        spherical_nm,
        coma_nm,
        astigmatism_nm,
    };
    for (name, of, place, ratio, defocus_mm) in [
        ("none", row(0.0, 0.0, 0.0), [0.5, 0.5], 0.5, 0.0),
        ("coma", row(0.0, 52.5, 0.0), [1.0, 0.0], 0.5, 0.0),
        ("coma inwards", row(0.0, -52.5, 0.0), [1.0, 0.0], 0.5, 0.0),
        ("coma along the edge", row(0.0, 52.5, 0.0), [0.0, 1.0], 0.85, 0.3),
        ("spherical out of focus", row(40.0, 0.0, 0.0), [0.0, 0.0], 0.5, -0.5),
        ("astigmatism", row(0.0, 0.0, 60.0), [0.8, 0.6], 0.7, 0.2),
        ("all", row(20.0, 40.0, 30.0), [0.5, -0.7], 0.85, 0.4),
    ] {
        let edge = PartiallyCoherentEdge { coherence_ratio: ratio, defocus_mm, ..Default::default() };
        let off = worst(&edge, of, place);
        println!("{name}: {off:.1e} of full light");
        assert!(off < 5e-4, "{name}: {off}");
        // And it is another image than a perfect lens's.
        if name != "none" {
            let perfect = edge.edge_spread().unwrap();
            let seen = edge_in_field(&edge, &[of], place, 0.0).unwrap();
            let apart = (-40..=40).map(|i| (perfect.value(f64::from(i)) - seen.value(f64::from(i))).abs());
            assert!(apart.fold(0.0, f64::max) > 5e-3, "{name}: nothing was drawn");
        }
    }
}
