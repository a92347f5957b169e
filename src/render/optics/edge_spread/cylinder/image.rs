//! The image of a cylinder's limb, from the half-shadow integral of every point of the source.
//!
//! Lengths across the light in ℓ = M/k, angles in 1/M, with M = (kR/2)^(1/3): X = (x - R)/ℓ, s =
//! Mθ, Y = y_f M/R for a plane of focus y_f on the camera's side of the axis. With f(s) = exp i(Xs
//! - s³/3 - Ys²), a source point in the direction s₀ has behind a pupil |s| < s_m the image
//!
//! ```text
//! u = [½ f(s₀) if |s₀| < s_m] + (1/2πi) PV∫ f(s)/(s - s₀) ds - (1/π) ∫ f(s) P(s - s₀) ds
//! ```
//!
//! The half plane is this without s³/3 and P (V. A. Fock 1965). From the principal value f(s₀) is
//! subtracted under the integral and its own, f(s₀) ln|(s_m - s₀)/(s_m + s₀)|, added. A source
//! point at the angle ζ along the axis keeps it: its chord of the pupil is √(NA² - ζ²), of the
//! source √(NA_i² - ζ²). |u|² is added over the source and divided by the part of it that passes
//! directly.
//!
//! A lens with aberrations multiplies f by e^(-2πiW) of its own chord, W in waves
//! ([`PupilPath`]); both halves of the source along the edge are added up where W separates them.
//!
//! The image is the square of a function of the bandwidth NA/λ, so that twelve samples a λ/NA
//! contain it; between them a polynomial through twelve errs by less than 1e-6. The phase between
//! the light of two source points grows with the distance from the limb, and with it the number of
//! source points that is needed: the samples are computed in zones.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use multiversion::multiversion;
use rayon::prelude::*;

use super::airy::{C, unit};
use super::half_shadow::{HalfShadow, lagrange};
use super::surface::Boundary;
use crate::render::optics::edge_spread::quadrature::{kept_rule, scaled};
use crate::render::optics::lens::aberrations::PupilPath;

/// Samples of the image a λ/NA, and points of the polynomial between them.
const SAMPLES: f64 = 12.0;
const POINTS: usize = 12;

/// Nodes on a chord of the source of half length S (of the pupil's) for a distance of x λ/NA: 6 +
/// 5.3 S x err by 3e-4 of full light, 2e-5 within 2 λ/NA (against 96 nodes on 48 chords, S .3 to
/// 1.5).
const LEAST_NODES: f64 = 6.0;
const NODES_PER_UNIT: f64 = 5.3;

/// Chords near the limb for narrow sources, and all others.
const FEW_CHORDS: usize = 8;
const CHORDS: usize = 12;

/// Further chords a wave by which the path may differ over half the pupil.
const CHORDS_PER_WAVE: f64 = 1.0;

/// S up to which, and distance in λ/NA to which, few chords do.
const NARROW: f64 = 0.72;
const NEAR: f64 = 4.0;

/// Zones, λ/NA from the limb; more of the last one's width follow.
const ZONES: [f64; 5] = [2.0, 4.0, 6.0, 8.0, 12.0];
const ZONE: f64 = 4.0;

/// Share of the reach beyond which the table fades, so that samples there need no more nodes.
const FULL: f64 = 0.85;

/// Nodes over the pupil beyond half its phase, where a Gauss rule converges: e^(iωx) has the Bessel
/// functions J_n(ω) as its coefficients.
const MORE_NODES: f64 = 26.0;

/// Light whose source is narrower than this share of the pupil is coherent; the image differs by
/// less than 1e-5.
const COHERENT: f64 = 1e-3;

/// Source nodes are kept this far from the pupil's, s: the difference of f loses 1e-16/1e-6.
const APART: f64 = 1e-6;

/// Samples computed at a time.
const LANES: usize = 16;

/// The limb of a cylinder at a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limb {
    /// Wavenumber 2π/λ, 1/µm.
    pub k: f64,
    /// M = (kR/2)^(1/3).
    pub m: f64,
    /// Coefficient of s³ in the phase: 1/3, or 0 for a thin screen.
    cubic: f64,
}

impl Limb {
    /// The limb of a radius of curvature.
    pub(crate) fn new(radius_mm: f64, wavelength_nm: f64) -> Self {
        let k = 2e3 * PI / wavelength_nm;
        Self { k, m: (0.5e3 * k * radius_mm).cbrt(), cubic: 1.0 / 3.0 }
    }

    /// A thin screen: a half plane in the plane of the axis; any M serves as its unit.
    pub(crate) fn screen(wavelength_nm: f64) -> Self {
        Self { cubic: 0.0, ..Self::new(1.0, wavelength_nm) }
    }

    /// ℓ = M/k, µm.
    pub(crate) fn length_um(&self) -> f64 {
        self.m / self.k
    }

    /// Y of a plane of focus `focus_mm` from the axis on the camera's side: y M/R = y k/2M².
    pub(crate) fn depth(&self, focus_mm: f64) -> f64 {
        0.5e3 * focus_mm * self.k / (self.m * self.m)
    }
}

/// Lens, source and plane of focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    /// Numerical apertures of the lens and of the source.
    pub na: f64,
    pub source_na: f64,
    /// Plane of focus from the axis, + on the camera's side, mm.
    pub focus_mm: f64,
    /// Reach of the samples to either side of the limb, µm.
    pub reach_um: f64,
    /// Aberrations of the lens at the limb's place in the field.
    pub path: PupilPath,
}

/// Light over the distance from the limb, sampled.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    from_um: f64,
    step_um: f64,
    /// Light and its slope, 1/µm.
    knots: Vec<(f64, f64)>,
}

impl Samples {
    /// Light at a distance into the light, and its slope, 1/µm.
    pub(crate) fn at(&self, d_um: f64) -> (f64, f64) {
        let place = (d_um - self.from_um) / self.step_um;
        let first = (place as usize).saturating_sub(POINTS / 2 - 1).min(self.knots.len() - POINTS);
        let weights: [f64; POINTS] = lagrange(place - first as f64);
        let window = &self.knots[first..first + POINTS];
        window.iter().zip(weights).fold((0.0, 0.0), |(v, d), (k, w)| (v + w * k.0, d + w * k.1))
    }
}

/// The image of a limb: mean of the polarisations whose boundaries are given; of a screen without
/// any.
pub(crate) fn image(limb: Limb, view: &View, boundaries: &[Boundary]) -> Samples {
    let both = shadows(limb, view, boundaries);
    // Far from the limb polarisations differ by less than 1e-3 of the amplitude, and the image
    // by half its square.
    let mean = vec![HalfShadow::mean(&both)];
    let grid = Grid::new(limb, view);
    let mut light = vec![0.0; grid.count];
    for zone in grid.zones() {
        let shadows = if zone.reach <= NEAR { &both } else { &mean };
        let chords = chords(view, zone.reach);
        let parts: Vec<(f64, Vec<f64>)> =
            chords.par_iter().map(|chord| chord.light(limb, view, shadows, (&grid, &zone))).collect();
        let passed: f64 = parts.iter().map(|(passed, _)| passed).sum();
        let scale = 1.0 / (passed * shadows.len() as f64);
        for (i, lane) in zone.lanes.iter().enumerate() {
            for j in 0..LANES {
                light[lane * LANES + j] = scale * parts.iter().map(|(_, l)| l[i * LANES + j]).sum::<f64>();
            }
        }
    }
    let slopes = (POINTS / 2..grid.count - POINTS / 2).map(|i| (light[i], slope(&light, i) / grid.step_um));
    let from_um = grid.from_um + (POINTS / 2) as f64 * grid.step_um;
    Samples { from_um, step_um: grid.step_um, knots: slopes.collect() }
}

/// P of every polarisation, as far as the pupil and the source need it.
fn shadows(limb: Limb, view: &View, boundaries: &[Boundary]) -> Vec<HalfShadow> {
    let largest = limb.m * (view.na + view.source_na);
    if boundaries.is_empty() {
        return vec![HalfShadow::none(largest)];
    }
    boundaries.iter().map(|b| HalfShadow::new(b.scaled(limb.m), largest)).collect()
}

/// Central difference of sample `i` over twelve neighbours, error below 2e-4 of the highest
/// frequency: weights (-1)^(k+1) n!²/(k (n-k)! (n+k)!), n = 6.
fn slope(light: &[f64], i: usize) -> f64 {
    const N: usize = POINTS / 2;
    let mut ratio = 1.0;
    (1..=N).fold(0.0, |sum, k| {
        ratio *= -((N + 1 - k) as f64) / (N + k) as f64;
        sum - ratio / k as f64 * (light[i + k] - light[i - k])
    })
}

/// The samples' places.
#[derive(Clone, Copy, Debug)]
struct Grid {
    from_um: f64,
    step_um: f64,
    /// Whole lanes.
    count: usize,
    /// λ/NA to which nodes are counted.
    full: f64,
}

/// Lanes of samples whose source is summed with the same nodes.
struct Zone {
    /// Farthest distance from the limb, λ/NA.
    reach: f64,
    lanes: Vec<usize>,
}

impl Grid {
    fn new(limb: Limb, view: &View) -> Self {
        let unit_um = 2.0 * PI / (limb.k * view.na);
        let step_um = unit_um / SAMPLES;
        let needed = 2 * ((view.reach_um / step_um).ceil() as usize + POINTS) + 1;
        let count = needed.next_multiple_of(LANES);
        let from_um = -0.5 * step_um * (count - 1) as f64;
        Self { from_um, step_um, count, full: FULL * view.reach_um / unit_um }
    }

    /// All lanes, by their distance from the limb.
    fn zones(&self) -> Vec<Zone> {
        let mut zones: Vec<Zone> = Vec::new();
        for lane in 0..self.count / LANES {
            let ends =
                [lane * LANES, (lane + 1) * LANES - 1].map(|i| i as f64 - 0.5 * (self.count - 1) as f64);
            let far = ends[0].abs().max(ends[1].abs()) / SAMPLES;
            let far = far.min(self.full);
            let last = ZONES[ZONES.len() - 1];
            let beyond = last + ZONE * ((far - last) / ZONE).ceil();
            let reach =
                ZONES.into_iter().find(|edge| far <= *edge).unwrap_or(beyond).min(self.full.max(ZONES[0]));
            match zones.iter_mut().find(|z| z.reach == reach) {
                Some(zone) => zone.lanes.push(lane),
                None => zones.push(Zone { reach, lanes: vec![lane] }),
            }
        }
        zones
    }

    /// X of a lane's first sample, and between two samples.
    fn lane(&self, limb: Limb, lane: usize) -> (f64, f64) {
        let length_um = limb.length_um();
        ((self.from_um + (lane * LANES) as f64 * self.step_um) / length_um, self.step_um / length_um)
    }
}

/// One chord of pupil and source.
#[derive(Clone, Copy, Debug)]
struct Chord {
    /// Half lengths, as sines of angles.
    pupil: f64,
    source: f64,
    /// Its own angle along the limb.
    along: f64,
    weight: f64,
    nodes: usize,
}

/// The chords of the source that pupil and source share, for samples up to `reach` λ/NA away; one
/// for coherent light.
fn chords(view: &View, reach: f64) -> Vec<Chord> {
    if view.source_na < COHERENT * view.na {
        return vec![Chord { pupil: view.na, source: 0.0, along: 0.0, weight: 1.0, nodes: 1 }];
    }
    // Rays land as far beside their places as the path is steep, in λ/NA.
    let steepest = view.path.steepest_waves();
    let reach = reach + steepest;
    let ratio = (view.source_na / view.na).min(1.0);
    let nodes = 2 * (0.5 * (LEAST_NODES + NODES_PER_UNIT * ratio * reach)).ceil() as usize;
    let count = if ratio < NARROW && reach <= NEAR { FEW_CHORDS } else { CHORDS };
    let count = count + (CHORDS_PER_WAVE * steepest).ceil() as usize;
    let most = view.na.min(view.source_na);
    let chord = |(u, w): (f64, f64)| {
        let (sin, cos) = (FRAC_PI_2 * u).sin_cos();
        let along = most * sin;
        let square = along.powi(2);
        let half = |na: f64| (na * na - square).max(0.0).sqrt();
        Chord { pupil: half(view.na), source: half(view.source_na), along, weight: w * cos, nodes }
    };
    let half: Vec<Chord> = scaled(&kept_rule(count), 0.0, 1.0).map(chord).collect();
    if view.path.is_even_along() {
        return half;
    }
    let other = half.iter().map(|chord| Chord { along: -chord.along, ..*chord });
    half.iter().copied().chain(other).collect()
}

impl Chord {
    /// Source points s₀ and weights, denser towards the ends and towards the pupil's rim.
    fn source_points(&self, m: f64) -> Vec<(f64, f64)> {
        if self.nodes == 1 {
            return vec![(0.0, 1.0)];
        }
        let (rim, end) = (m * self.pupil, m * self.source);
        let pieces = if end <= rim { vec![(-end, end)] } else { vec![(-end, -rim), (-rim, rim), (rim, end)] };
        let rule = kept_rule(self.nodes);
        let points = pieces.iter().flat_map(|&(a, b)| {
            rule.iter().map(move |(u, w)| {
                let (sin, cos) = (FRAC_PI_2 * u).sin_cos();
                (0.5 * (a + b) + 0.5 * (b - a) * sin, 0.5 * (b - a) * w * cos)
            })
        });
        points.collect()
    }

    /// The part of the source that passes directly, and the light of all of it at the samples of a
    /// zone.
    fn light(
        &self,
        limb: Limb,
        view: &View,
        shadows: &[HalfShadow],
        (grid, zone): (&Grid, &Zone),
    ) -> (f64, Vec<f64>) {
        let rim = limb.m * self.pupil;
        let depth = limb.depth(view.focus_mm);
        let (aperture, along) = (limb.m * view.na, self.along / view.na);
        let path = |s: f64| TAU * view.path.waves(s / aperture, along);
        let own = |s: f64| unit(-s * s * (s * limb.cubic + depth) - path(s));
        // Phase of the integrand over the half pupil, with that of P.
        let far = zone
            .lanes
            .iter()
            .map(|lane| grid.lane(limb, *lane))
            .map(|(x, step)| x.abs().max((x + step * LANES as f64).abs()));
        let far = far.fold(0.0, f64::max);
        let rate = far
            + rim * (rim + 2.0 * depth.abs())
            + 0.25 * (rim + limb.m * self.source).powi(2)
            + TAU * view.path.steepest_waves() / aperture;
        let rule = kept_rule(2 * (0.25 * rim * rate + 0.5 * MORE_NODES).ceil() as usize);
        let pupil = Pupil::new(scaled(&rule, -rim, rim).map(|(s, w)| (s, own(s) * w, w)).collect());
        let (mut passed, mut waves) = (0.0, Vec::new());
        for (s0, weight) in self.source_points(limb.m) {
            let s0 = pupil.apart(s0);
            let weight = weight * self.weight;
            passed += if s0.abs() < rim { weight } else { 0.0 };
            waves.extend(shadows.iter().map(|shadow| pupil.wave((s0, weight), own(s0), rim, shadow)));
        }
        let mut light = vec![0.0; zone.lanes.len() * LANES];
        for (light, lane) in light.chunks_exact_mut(LANES).zip(&zone.lanes) {
            let lane = grid.lane(limb, *lane);
            add_light(light, &pupil.phases(lane), &waves, lane);
        }
        (passed, light)
    }
}

/// The image of a source point as a sum over the pupil's nodes, and its own direction.
struct Wave {
    direction: f64,
    weight: f64,
    own: C,
    terms: Vec<C>,
}

/// Nodes over the pupil: s, f times the node's weight, the weight.
struct Pupil(Vec<(f64, C, f64)>);

impl Pupil {
    fn new(nodes: Vec<(f64, C, f64)>) -> Self {
        Self(nodes)
    }

    /// A source point kept off the nodes.
    fn apart(&self, s0: f64) -> f64 {
        let near = self.0.iter().any(|(s, ..)| (s - s0).abs() < APART);
        if near { s0 + 2.0 * APART } else { s0 }
    }

    fn wave(&self, (s0, weight): (f64, f64), own: C, rim: f64, shadow: &HalfShadow) -> Wave {
        let per = C::new(0.0, -0.5 / PI);
        let term = |(s, f, _): &(f64, C, f64)| f * (per / (s - s0) - shadow.at(s - s0) / PI);
        let subtracted: f64 = self.0.iter().map(|(s, _, w)| w / (s - s0)).sum();
        let pole = ((rim - s0) / (rim + s0)).abs().ln() - subtracted;
        let direct = if s0.abs() < rim { 0.5 } else { 0.0 };
        let terms = self.0.iter().map(term).collect();
        Wave { direction: s0, weight, own: own * (per * pole + direct), terms }
    }

    fn phases(&self, lane: (f64, f64)) -> Phases {
        let (re, im) = self.0.iter().map(|(s, ..)| phases(*s, lane)).unzip();
        Phases { re, im }
    }
}

/// e^(iXs) of a lane of samples, a node after another.
struct Phases {
    re: Vec<[f64; LANES]>,
    im: Vec<[f64; LANES]>,
}

fn phases(s: f64, (from, step): (f64, f64)) -> ([f64; LANES], [f64; LANES]) {
    let (mut now, turn) = (unit(s * from), unit(s * step));
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    for (re, im) in re.iter_mut().zip(&mut im) {
        (*re, *im) = (now.re, now.im);
        now *= turn;
    }
    (re, im)
}

/// Adds Σ weight |u|² of the waves at a lane of samples.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"), dispatcher = "direct")]
fn add_light(light: &mut [f64], at: &Phases, waves: &[Wave], lane: (f64, f64)) {
    for wave in waves {
        let (own_re, own_im) = phases(wave.direction, lane);
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            re[i] = wave.own.re * own_re[i] - wave.own.im * own_im[i];
            im[i] = wave.own.re * own_im[i] + wave.own.im * own_re[i];
        }
        for ((term, a), b) in wave.terms.iter().zip(&at.re).zip(&at.im) {
            for i in 0..LANES {
                re[i] += term.re * a[i] - term.im * b[i];
                im[i] += term.re * b[i] + term.im * a[i];
            }
        }
        for i in 0..LANES {
            light[i] += wave.weight * (re[i] * re[i] + im[i] * im[i]);
        }
    }
}
