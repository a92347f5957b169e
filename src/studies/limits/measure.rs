//! Measures the scenes with the thresholds of this process: figures, and a digest of every result.

use std::fmt::Debug;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::figures::Counts;
use super::kinds::{Role, Source};
use super::look::{self, Look, Part, Series, View};
use super::scene::{DARKS, EXPOSURES, PINS, Scene};
use crate::frame::{Frame, FrameView};
use crate::gauge::axis_line::AxisAverager;
use crate::gauge::budget::WidthReading;
use crate::gauge::calibration::Conditions;
use crate::gauge::diameter::sections::TurnAverager;
use crate::gauge::form::Cutoff;
use crate::gauge::photon_transfer::{FramePair, photon_transfer};
use crate::gauge::plausibility::TurnHistory;
use crate::gauge::ring::{RingSettings, measure_ring};
use crate::gauge::sensor::{FlatField, response};
use crate::gauge::{
    Calibration, Edge, EdgeStream, FrameEdges, FrameRefused, Gauge, GaugeSettings, Pose, StationAverager,
    crest_pitch_px, largest_caliper,
};
use crate::render::OpticalSetup;
use crate::render::settings::{SetupDeviations, SetupSettings};
use crate::setting::SettingError;
use crate::studies::calibration::{CalibrateError, SimulatedPlan};
use crate::studies::contamination::{ALLOWED_UM, station_px};
use crate::studies::coverage::{Class, Recorded, measure as measure_class};
use crate::studies::dirty_frames;

/// Scale of drawn frames, µm per px: any will do.
const DRAWN_UM: f64 = 10.0;
/// Undulations a revolution of the filter: half the angles of a turn.
const CUTOFF_UPR: f64 = 6.0;

/// What one kind of scene gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct KindCounts {
    /// The kind.
    pub kind: String,
    /// Its counts.
    #[serde(flatten)]
    pub counts: Counts,
    /// Digest of every result: equal where not one bit of them differs.
    pub digest: String,
}

/// What all scenes gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// Kind by kind, in the scenes' order.
    pub kinds: Vec<KindCounts>,
}

impl Measured {
    /// All kinds together.
    pub(crate) fn counts(&self) -> Counts {
        let mut all = Counts::default();
        self.kinds.iter().for_each(|kind| all.add(&kind.counts));
        all
    }

    /// Kinds of which any result differs from the other's.
    pub(crate) fn kinds_unlike(&self, other: &Self) -> Vec<String> {
        let pairs = self.kinds.iter().zip(&other.kinds);
        pairs.filter(|(a, b)| a.digest != b.digest).map(|(a, _)| a.kind.clone()).collect()
    }
}

/// Measures scenes.
///
/// # Errors
/// Settings that the gauge refuses.
pub(crate) fn measure(scenes: &[Scene]) -> Result<Measured, SettingError> {
    let mut kinds = Vec::new();
    for of_kind in scenes.chunk_by(|a, b| a.kind.name == b.kind.name) {
        let mut tally = Tally::new(of_kind[0].kind.role);
        for scene in of_kind {
            tally.scene(scene)?;
        }
        let digest = tally.digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        kinds.push(KindCounts { kind: of_kind[0].kind.name.to_owned(), counts: tally.counts, digest });
    }
    Ok(Measured { kinds })
}

/// Counts and digest of one kind.
struct Tally {
    role: Role,
    /// What a value may be off by besides U, px.
    allowed_px: f64,
    counts: Counts,
    digest: Sha256,
}

/// A value, its standard uncertainty and the half width of its interval, px.
type Value = (f64, f64, f64);

impl Tally {
    fn new(role: Role) -> Self {
        let allowed_px = ALLOWED_UM / dirty_frames::PIXEL_UM;
        Self { role, allowed_px, counts: Counts::default(), digest: Sha256::new() }
    }

    /// Adds any result to the digest.
    fn note(&mut self, result: &impl Debug) {
        self.digest.update(format!("{result:?}"));
    }

    fn note_edges(&mut self, edges: &FrameEdges) {
        for Edge { row_px, u_own_px, u_shared_px, chi2, state } in edges.top.iter().chain(&edges.bottom) {
            self.digest.update(row_px.to_bits().to_le_bytes());
            for value in [u_own_px, u_shared_px, chi2] {
                self.digest.update(value.to_bits().to_le_bytes());
            }
            self.note(state);
        }
        self.note(&(edges.shared_length, &edges.model_uncertainty_px, edges.clipped_px, edges.figures));
    }

    /// Counts a value that should be `truth`; NaN where no one value is true.
    fn count(&mut self, truth: f64, value: Option<Value>) {
        if truth.is_nan() {
            return;
        }
        let clean = self.role == Role::Clean;
        self.counts.clean += usize::from(clean);
        let Some((value, u, half)) = value else {
            self.counts.lost += usize::from(clean);
            return;
        };
        let error = value - truth;
        if clean {
            self.counts.covered += usize::from(error.abs() <= half);
            // A value without an uncertainty is not covered, and has no ratio.
            let ratio = error / u;
            self.counts.square_over_u += if ratio.is_finite() { ratio * ratio } else { 0.0 };
            self.counts.square_px += if error.is_finite() { error * error } else { 0.0 };
        } else {
            self.counts.kept += 1;
            self.counts.mishandled += usize::from(!(error.abs() <= half + self.allowed_px));
        }
    }

    /// Counts a frame that was refused, with the values it should have given.
    fn refuse(&mut self, why: &impl Debug, truth: &[f64]) {
        self.note(why);
        self.counts.refused += 1;
        truth.iter().for_each(|truth| self.count(*truth, None));
    }

    fn scene(&mut self, scene: &Scene) -> Result<(), SettingError> {
        self.counts.frames += scene.frames.len();
        match scene.kind.source {
            Source::Look(look) => self.look(scene, &look),
            Source::Piece(_) | Source::Film(_) => {
                let mut stream = Gauge::new(GaugeSettings::default())?.stream();
                for (frame, truth) in scene.frames.iter().zip(&scene.truth) {
                    self.shaft(&mut stream, &frame.view(), truth, dirty_frames::STATION);
                }
                Ok(())
            }
            Source::FlatField => self.flat_field(scene),
            Source::Class(class) => {
                self.class(class, scene);
                Ok(())
            }
        }
    }

    fn look(&mut self, scene: &Scene, look: &Look) -> Result<(), SettingError> {
        let mut stream = Gauge::new(look.settings())?.stream();
        let mut turn = Turn::new(&scene.frames);
        for (frame, truth) in scene.frames.iter().zip(&scene.truth) {
            let view = if look.view == View::Upright { frame.view().transposed() } else { frame.view() };
            match (look.part, look.series) {
                (Part::Disc { .. }, _) => self.disc(&view, truth),
                (Part::Thread, _) => self.thread(&mut stream, &view, truth),
                (_, Series::Turn(_)) => {
                    if let Some(edges) = self.shaft(&mut stream, &view, truth, look::STATION) {
                        turn.add(frame, &edges);
                    }
                }
                (_, Series::Line(columns, _)) => {
                    self.shaft(&mut stream, &view, truth, columns);
                }
                _ => {
                    self.shaft(&mut stream, &view, truth, look::STATION);
                }
            }
        }
        if matches!(look.series, Series::Turn(_)) {
            turn.finish(self);
        }
        Ok(())
    }

    /// The edges of a frame, noted; none of one that is refused.
    fn edges(&mut self, stream: &mut EdgeStream, view: &FrameView<'_>, truth: &[f64]) -> Option<FrameEdges> {
        let mut edges = FrameEdges::default();
        if let Err(FrameRefused { reason, .. }) = stream.measure(view, &mut edges) {
            self.refuse(&reason, truth);
            return None;
        }
        self.note_edges(&edges);
        Some(edges)
    }

    /// A frame of a shaft: its stations, and what else is computed of its edges.
    fn shaft(
        &mut self,
        stream: &mut EdgeStream,
        view: &FrameView<'_>,
        truth: &[f64],
        station: usize,
    ) -> Option<FrameEdges> {
        let edges = self.edges(stream, view, truth)?;
        let min_fill = stream.settings().station.min_fill;
        if truth.is_empty() {
            // There is no part to be measured.
            self.counts.kept += 1;
            self.counts.mishandled += 1;
        }
        for (index, truth) in truth.iter().enumerate() {
            let columns = index * station..(index + 1) * station;
            let value = station_px(&edges, columns, min_fill).map(|(value, u)| {
                let u = u.hypot(edges.figures.u_position_px());
                (value, u, 2.0 * u)
            });
            self.note(&value);
            self.count(*truth, value);
        }
        let reading = WidthReading::of_frame(&edges, 0..edges.columns());
        let calibration = Calibration::from_scale(DRAWN_UM);
        let budget = reading.as_ref().map(|r| r.budget(&calibration, &Conditions::default()));
        let interval = budget.as_ref().map(|b| b.half_width_mm(0.95));
        let largest = WidthReading::of_largest(&edges, &calibration, 8);
        self.note(&(largest_caliper(&edges), crest_pitch_px(&edges), Pose::of(&edges), reading));
        self.note(&(budget, interval, largest));
        Some(edges)
    }

    /// A frame of a thread: the distance of the crests.
    fn thread(&mut self, stream: &mut EdgeStream, view: &FrameView<'_>, truth: &[f64]) {
        let Some(edges) = self.edges(stream, view, truth) else { return };
        let largest = largest_caliper(&edges);
        self.note(&(largest, crest_pitch_px(&edges)));
        let value = largest.map(|l| (l.diameter_px, l.u_px, 2.0 * l.u_px));
        truth.iter().for_each(|truth| self.count(*truth, value));
    }

    fn disc(&mut self, view: &FrameView<'_>, truth: &[f64]) {
        let ring = match measure_ring(view, &RingSettings::default()) {
            Ok(ring) => ring,
            Err(error) => return self.refuse(&std::mem::discriminant(&error), truth),
        };
        self.note(&ring);
        let circles = [Some(&ring.outer), ring.inner.as_ref()];
        for (truth, circle) in truth.iter().zip(circles) {
            let value = circle.map(|c| (c.diameter_px, c.u_diameter_px, 2.0 * c.u_diameter_px));
            self.count(*truth, value);
        }
    }

    /// Response, flat field and photon transfer of a sensor, and its shafts corrected by them.
    fn flat_field(&mut self, scene: &Scene) -> Result<(), SettingError> {
        let all = views(&scene.frames);
        let (dark, rest) = all.split_at(DARKS);
        let (flats, _) = rest.split_at(2 * EXPOSURES.len());
        let by_exposure = || EXPOSURES.iter().zip(flats.chunks_exact(2));
        let levels: Vec<(f64, Vec<FrameView<'_>>)> = by_exposure().map(|(e, f)| (*e, f.to_vec())).collect();
        let response = response(dark, &levels);
        self.note(&response);
        let pairs: Vec<FramePair<'_>> = by_exposure().filter_map(|(e, f)| pair(*e, f)).collect();
        let darks: Vec<FramePair<'_>> = dark.chunks_exact(2).filter_map(|f| pair(0.0, f)).collect();
        self.note(&photon_transfer(&pairs, &darks));
        let response = response.unwrap_or_default();
        let of_frame = |frame: &Frame| match &response {
            Some(response) => response.linearised(frame.clone()),
            None => frame.clone(),
        };
        let linear =
            |range: Range<usize>| -> Vec<Frame> { scene.frames[range].iter().map(of_frame).collect() };
        let shafts = DARKS + 2 * EXPOSURES.len();
        // The brightest one shows defects and light best.
        let (dark, flat) = (linear(0..DARKS), linear(shafts - 2..shafts));
        let field = FlatField::new(&views(&dark), &views(&flat)).map(|field| field.with_response(response));
        self.note(&field);
        let mut stream = Gauge::new(GaugeSettings::default())?.stream();
        for (frame, truth) in scene.frames.iter().zip(&scene.truth).skip(shafts) {
            let corrected =
                field.as_ref().map_or_else(|_| frame.clone(), |field| field.corrected(frame.clone()));
            self.shaft(&mut stream, &corrected.view(), truth, look::STATION);
        }
        Ok(())
    }

    /// A setup of the coverage study: its masters, its part, the interval of its diameter.
    fn class(&mut self, class: Class, scene: &Scene) {
        let (pins, part) = scene.frames.split_at(PINS.min(scene.frames.len()));
        let recorded = Recorded { pins: pins.to_vec(), part: part.to_vec() };
        let measured = pixel_mm().and_then(|mm| Ok((mm, measure_class(class, scene.seed, &recorded)?)));
        match measured {
            Err(error) => self.refuse(&error.to_string(), &[0.0]),
            Ok((mm, outcome)) => {
                self.note(&outcome);
                let px = |mm_value: f64| mm_value / mm;
                let accepted = outcome.error_mm.filter(|_| outcome.flag.is_empty());
                self.count(0.0, accepted.map(|e| (px(e), px(outcome.u_mm), px(outcome.half_mm))));
            }
        }
    }
}

fn views(frames: &[Frame]) -> Vec<FrameView<'_>> {
    frames.iter().map(Frame::view).collect()
}

fn pair<'a>(exposure: f64, frames: &[FrameView<'a>]) -> Option<FramePair<'a>> {
    let [first, second, ..] = frames else { return None };
    Some(FramePair { exposure, first: *first, second: *second })
}

/// Nominal size of a pixel on the object in the coverage study's setups, mm.
fn pixel_mm() -> Result<f64, CalibrateError> {
    let nominal = SetupSettings { departures: SetupDeviations::none(), ..SimulatedPlan::default().setup() };
    Ok(OpticalSetup::resolve(&nominal, 0)?.pixel_mm)
}

/// What the frames of a turn give together: stations, axis, sections, what contradicts the turn
/// before.
struct Turn {
    calibration: Calibration,
    history: TurnHistory,
    stations: StationAverager,
    axis: AxisAverager,
    sections: TurnAverager,
    jumps: usize,
}

impl Turn {
    fn new(frames: &[Frame]) -> Self {
        let settings = GaugeSettings::default();
        let calibration = Calibration::from_scale(DRAWN_UM);
        let station_mm = 1e-3 * DRAWN_UM * look::STATION as f64;
        let size = frames.first().map_or((0, 0), |f| (f.view().rows(), f.view().columns()));
        let count = (size.1 / look::STATION).max(1);
        let z_mm: Vec<f64> =
            (0..count).map(|s| station_mm * (s as f64 - 0.5 * (count as f64 - 1.0))).collect();
        Self {
            history: TurnHistory::new(&settings.plausibility, station_mm),
            stations: StationAverager::new(&settings.station, z_mm.clone(), station_mm),
            axis: AxisAverager::new(z_mm.clone(), station_mm, calibration.axis_zero(size.0 as f64)),
            sections: TurnAverager::new(z_mm, station_mm),
            calibration,
            jumps: 0,
        }
    }

    fn add(&mut self, frame: &Frame, edges: &FrameEdges) {
        let mut diameters = self.calibration.diameters(edges);
        self.jumps += self.history.check(&frame.meta, &mut diameters).len();
        self.stations.add(&frame.meta, &diameters);
        self.axis.add(&frame.meta, &diameters);
        self.sections.add(&frame.meta, &diameters);
    }

    fn finish(&self, tally: &mut Tally) {
        tally.note(&(self.jumps, self.stations.finish(1), self.axis.finish()));
        if let Ok(cutoff) = Cutoff::upr(CUTOFF_UPR) {
            tally.note(&(self.sections.finish(cutoff), self.sections.envelope(cutoff)));
        }
    }
}
