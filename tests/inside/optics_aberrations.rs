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

/// Middles of equal steps of an angle over an interval, close together at its ends, where chords
/// of a disc end and amplitudes grow like a logarithm; and their weights.
fn nodes(low: f64, high: f64, count: usize) -> impl Iterator<Item = (f64, f64)> {
    let step = PI / count as f64;
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    (0..count).map(move |k| {
        let (sin, cos) = (step * (k as f64 + 0.5)).sin_cos();
        (middle - half * cos, half * step * sin)
    })
}

/// Light `x` λ/NA into the light of an edge, source and pupil in two dimensions: chords of both
/// across the edge, the source's split where it leaves the pupil. Rings of equal area about the
/// middle, of which one lies across the pupil's rim, err by 0.016 of full light at S = 1.2 with 24
/// of them, by half of it with twice as many, in first order.
pub(super) fn judge(s: f64, lens: &Lens, x: f64) -> f64 {
    const ALONG: usize = 24;
    const ACROSS: usize = 64;
    let (mut sum, mut full) = (0.0, 0.0);
    let most = s.min(1.0);
    for (q, chord) in nodes(-most, most, ALONG) {
        let [pupil, source] = [1.0, s].map(|r: f64| (r * r - q * q).max(0.0).sqrt());
        let outside = if source > pupil { ACROSS / 2 } else { 0 };
        let inner = source.min(pupil);
        for (low, high, count) in
            [(-source, -inner, outside), (-inner, inner, ACROSS), (inner, source, outside)]
        {
            for (p, weight) in nodes(low, high, count) {
                sum += chord * weight * behind(lens, (p, q), pupil, x);
                full += if p.abs() < pupil { chord * weight } else { 0.0 };
            }
        }
    }
    sum / full
}

/// Light of one source point: its own wave and the principal value of the edge's spectrum,
/// ∫ f/(2πi(p - p₀)) dp, in cells that lie evenly about p₀. Near the pupil's rim, where cells on
/// one side find none on the other, 1/(p - p₀) is integrated over each.
fn behind(lens: &Lens, (p0, q): (f64, f64), pupil: f64, x: f64) -> f64 {
    const CELL: f64 = 0.01;
    let wave = |p: f64| (lens.phase(p, q) + TAU * (p - p0) * x).sin_cos();
    let first = ((-pupil - p0) / CELL).floor() as i32 - 1;
    let last = ((pupil - p0) / CELL).ceil() as i32;
    let far = pupil - p0.abs() > 5.0 * CELL;
    // Real and imaginary part of the integral without 1/2πi.
    let (mut re, mut im) = (0.0, 0.0);
    for k in first..=last {
        let low = (p0 + CELL * f64::from(k)).max(-pupil);
        let high = (p0 + CELL * f64::from(k + 1)).min(pupil);
        if high <= low {
            continue;
        }
        let touches = p0.abs() < pupil && (k == 0 || k == -1);
        let weight = if far || touches {
            (high - low) / (0.5 * (low + high) - p0)
        } else {
            ((high - p0) / (low - p0)).abs().ln()
        };
        let (sin, cos) = wave(0.5 * (low + high));
        (re, im) = (re + weight * cos, im + weight * sin);
    }
    let (mut own_re, mut own_im) = (0.0, 0.0);
    if p0.abs() < pupil {
        let (sin, cos) = wave(p0);
        (own_re, own_im) = (0.5 * cos, 0.5 * sin);
        // The two cells beside p₀, of which the rim cuts one.
        let cut = (CELL.min(pupil - p0) / CELL.min(pupil + p0)).ln();
        (re, im) = (re + cut * cos, im + cut * sin);
    }
    (own_re + im / TAU).powi(2) + (own_im - re / TAU).powi(2)
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
        ("coma in wide light", row(0.0, 52.5, 0.0), [1.0, 0.0], 1.2, 0.0),
        ("all in wide light", row(20.0, 40.0, 30.0), [0.5, -0.7], 1.5, 0.4),
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
