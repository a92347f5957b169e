//! Threads, feed marks, flats and keyways of a shaft: their heights, their bounds, and the ranges
//! where they make the outline non-smooth.

use std::f64::consts::TAU;

use crate::shaft::{Features, Helix, Shaft};

/// Corners closer than this belong to one range, mm.
const NEAR_MM: f64 = 0.01;

/// Lowest and highest sum of all helices' heights, mm.
pub(super) fn bounds(features: &Features) -> (f64, f64) {
    features
        .helices
        .iter()
        .map(extent)
        .fold((0.0, 0.0), |(low, high), (a, b)| (low + a.min(0.0), high + b.max(0.0)))
}

fn extent(helix: &Helix) -> (f64, f64) {
    let ends = helix.pieces.iter().skip(1).map(|p| p.from).chain([1.0]);
    let heights = helix.pieces.iter().zip(ends).flat_map(|(p, end)| {
        let [c0, c1, c2] = p.height_mm;
        let at = move |w: f64| c0 + w * (c1 + w * c2);
        let width = end - p.from;
        let vertex = if c2 == 0.0 { 0.0 } else { (-0.5 * c1 / c2).clamp(0.0, width) };
        [at(0.0), at(width), at(vertex)]
    });
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

/// Radius of a disc inside every slice, mm; `low_mm` is the lower bound of form errors and helices.
pub(super) fn core_mm(shaft: &Shaft, low_mm: f64) -> f64 {
    let waves: f64 = shaft.features.waves.iter().map(|w| w.amplitude_mm.abs()).sum();
    let smallest = shaft.profile.iter().map(|k| k.radius_mm).fold(f64::INFINITY, f64::min);
    let cuts = shaft.features.flats.iter().map(|f| f.distance_mm);
    cuts.chain(shaft.features.keyways.iter().map(|k| k.floor_mm)).fold(smallest - waves + low_mm, f64::min)
}

/// Ranges of z whose outline is not smooth: corners of the profile whose slope changes by more than
/// `corner`, threads and feed marks over their whole length, the ends of flats and keyways.
/// Disjoint and ascending.
pub(super) fn broken(shaft: &Shaft, corner: f64) -> Vec<(f64, f64)> {
    let slope = |i: usize| {
        let (a, b) = (shaft.profile[i], shaft.profile[i + 1]);
        let rise = b.radius_mm - a.radius_mm;
        if rise == 0.0 { 0.0 } else { rise / (b.z_mm - a.z_mm) }
    };
    let count = shaft.profile.len();
    let mut broken: Vec<(f64, f64)> = (0..count)
        .filter(|&i| {
            let before = if i == 0 { 0.0 } else { slope(i - 1) };
            let behind = if i + 1 == count { 0.0 } else { slope(i) };
            !((behind - before).abs() <= corner)
        })
        .map(|i| (shaft.profile[i].z_mm, shaft.profile[i].z_mm))
        .collect();
    let f = &shaft.features;
    broken.extend(f.helices.iter().map(|h| (h.from_mm, h.to_mm)));
    let ends =
        f.flats.iter().map(|f| [f.from_mm, f.to_mm]).chain(f.keyways.iter().map(|k| [k.from_mm, k.to_mm]));
    broken.extend(ends.flatten().map(|z| (z, z)));
    broken.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (start, end) in broken {
        match merged.last_mut() {
            Some(last) if start <= last.1 + NEAR_MM => last.1 = last.1.max(end),
            _ => merged.push((start, end)),
        }
    }
    merged
}

/// Height of a helix at (z, θ), mm.
pub(super) fn helix_height(helix: &Helix, z_mm: f64, theta: f64) -> f64 {
    if !(helix.from_mm..=helix.to_mm).contains(&z_mm) {
        return 0.0;
    }
    let phase = (z_mm / helix.pitch_mm + turn(helix) * theta).rem_euclid(1.0);
    let piece = &helix.pieces[piece_at(helix, phase)];
    let w = phase - piece.from;
    let [c0, c1, c2] = piece.height_mm;
    c0 + w * (c1 + w * c2)
}

/// Change of a helix' phase with θ.
pub(super) fn turn(helix: &Helix) -> f64 {
    let turn = f64::from(helix.starts) / TAU;
    if helix.left_handed { turn } else { -turn }
}

pub(super) fn piece_at(helix: &Helix, phase: f64) -> usize {
    helix.pieces.partition_point(|p| p.from <= phase).saturating_sub(1)
}
