//! How often contamination in front of or on the shaft causes wrong stations, and how many stations
//! its rejection loses.
//!
//! Every frame is measured three times: clean, contaminated with nothing refused, contaminated with
//! the gauge's settings. *Harmful* is a frame where, with nothing refused, some station lies more
//! than 5 µm from the clean one. It is *mishandled* where a station then is neither a gap nor
//! within 1 µm + U (k = 2, random part) of the clean one.
//!
//! Frames are numbered by `contamination_plan`; here is what one shows, and the study of them all.

use serde::Serialize;

use super::dirty_frames::{Bump, COLUMNS, Contaminant, DrawError, PIXEL_UM, Piece, STATION};
use crate::frame::Frame;
use crate::gauge::{FrameEdges, Gauge, GaugeSettings, Rejection, StationColumns};

/// Error from which a station counts as harmed, µm.
const HARMED_UM: f64 = 5.0;
/// Error allowed in addition to U, µm.
pub(super) const ALLOWED_UM: f64 = 1.0;

/// Result for one kind of contamination.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct KindResult {
    /// The kind.
    #[serde(rename = "matter")]
    pub contaminant: Contaminant,
    /// Frames drawn.
    pub frames: usize,
    /// Frames where a station would be off by more than 5 µm.
    pub harmful: usize,
    /// Harmful frames with a station that is neither a gap nor within 1 µm + U.
    pub mishandled: usize,
    /// Their seeds, from which the frames can be drawn again.
    pub mishandled_seeds: Vec<u64>,
    /// Frames of any kind with such a station.
    pub misled: usize,
    /// Share of the stations of harmful frames that kept a value.
    pub kept: Option<f64>,
    /// Largest |error| of a station that kept a value, in all frames, µm.
    pub worst_um: f64,
}

/// A point of a curve: an effect and how it was handled.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct CurvePoint {
    /// Size of the effect, µm (height) or mm (half length).
    pub size: f64,
    /// Frames in which a station became a gap, as a share.
    pub noticed: f64,
    /// Root mean square error of the stations that kept a value, µm.
    pub rms_um: f64,
    /// The same with nothing refused, µm.
    pub rms_off_um: f64,
}

/// The study.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ContaminationStudy {
    /// Seed of the first frame.
    pub seed: u64,
    /// By kind of contamination.
    pub kinds: Vec<KindResult>,
    /// Clean frames.
    pub clean_frames: usize,
    /// Clean frames with a station that became a gap.
    pub clean_lost: usize,
    /// Largest share of columns refused in a clean frame.
    pub clean_worst_share: f64,
    /// Short films (half length 0.6 mm) over their height, µm.
    pub by_height: Vec<CurvePoint>,
    /// Films 8 µm high over their half length, mm.
    pub by_length: Vec<CurvePoint>,
}

/// Why the study cannot run.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(crate) enum StudyError {
    /// A frame cannot be drawn.
    Draw(#[from] DrawError),
    /// The gauge refuses its settings.
    Gauge(#[from] crate::setting::SettingError),
}

impl ContaminationStudy {
    /// Harmful frames of all kinds.
    pub(crate) fn harmful(&self) -> usize {
        self.kinds.iter().map(|k| k.harmful).sum()
    }

    /// Mishandled frames of all kinds.
    pub(crate) fn mishandled(&self) -> usize {
        self.kinds.iter().map(|k| k.mishandled).sum()
    }
}

/// Diameters of a frame's stations, µm with expanded uncertainty, `None` for a gap.
type Stations = Vec<Option<(f64, f64)>>;

/// Two gauges: with the default settings, and with nothing refused.
pub(crate) struct Pair {
    on: Gauge,
    off: Gauge,
    min_fill: f64,
}

impl Pair {
    pub(super) fn new(settings: &GaugeSettings) -> Result<Self, crate::setting::SettingError> {
        let off = GaugeSettings { rejection: Rejection::Off, ..settings.clone() };
        Ok(Self {
            on: Gauge::new(settings.clone())?,
            off: Gauge::new(off)?,
            min_fill: settings.station.min_fill,
        })
    }

    fn stations(&self, gauge: &Gauge, frame: &Frame, min_fill: f64) -> Stations {
        let Ok(edges) = gauge.edges(&frame.view()) else { return vec![None; COLUMNS / STATION] };
        (0..COLUMNS / STATION).map(|s| station(&edges, s * STATION..(s + 1) * STATION, min_fill)).collect()
    }
}

/// Mean width over a station by its columns with both edges, and U, µm.
fn station(edges: &FrameEdges, columns: std::ops::Range<usize>, min_fill: f64) -> Option<(f64, f64)> {
    station_px(edges, columns, min_fill).map(|(mean, u)| (mean * PIXEL_UM, 2.0 * u * PIXEL_UM))
}

/// Mean width over a station by its columns with both edges, and its standard uncertainty, px.
pub(super) fn station_px(
    edges: &FrameEdges,
    columns: std::ops::Range<usize>,
    min_fill: f64,
) -> Option<(f64, f64)> {
    let length = columns.len() as f64;
    let middle = 0.5 * (columns.start + columns.end - 1) as f64;
    let (mut own, mut shared, mut count) = (0.0, 0.0, 0.0);
    let mut seen = StationColumns::default();
    for column in columns {
        if let Some(width) = edges.width_px(column) {
            let (top, bottom) = (&edges.top[column], &edges.bottom[column]);
            seen.add((column as f64 - middle) / (0.5 * length), width);
            own += f64::from(top.u_own_px).powi(2) + f64::from(bottom.u_own_px).powi(2);
            shared += f64::from(top.u_shared_px).powi(2) + f64::from(bottom.u_shared_px).powi(2);
            count += 1.0;
        }
    }
    let mean = seen.mean();
    let u = (mean.gain * own / (count * count) + shared / count + mean.rest.powi(2)).sqrt();
    (count >= (min_fill * length).max(1.0)).then_some((mean.mean, u))
}

/// Result of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Outcome {
    /// With nothing refused, a station would be off by more than 5 µm.
    pub harmful: bool,
    /// A station is neither a gap nor within 1 µm + U.
    pub misled: bool,
    /// Stations that kept a value.
    pub kept: usize,
    /// Stations that became gaps.
    pub gaps: usize,
    /// Largest |error| of a station that kept a value, µm.
    pub worst_um: f64,
    /// Sum of their squared errors, µm².
    pub square: f64,
    /// The same of all stations with nothing refused, µm².
    pub square_off: f64,
    /// Share of the columns refused, of a clean frame.
    pub refused_share: f64,
}

impl Pair {
    /// A clean frame by itself.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub(super) fn look_at_clean(&self, seed: u64) -> Result<Outcome, DrawError> {
        let frame = Piece::draw(seed).frame(None)?;
        let Ok(edges) = self.on.edges(&frame.view()) else {
            return Ok(Outcome { gaps: 1, refused_share: 1.0, ..Outcome::default() });
        };
        let stations = self.stations(&self.on, &frame, self.min_fill);
        let gaps = stations.iter().filter(|station| station.is_none()).count();
        let refused_share = 1.0 - edges.valid() as f64 / COLUMNS as f64;
        Ok(Outcome { kept: stations.len() - gaps, gaps, refused_share, ..Outcome::default() })
    }

    /// A contaminated frame beside the clean one.
    pub(super) fn judge(&self, clean: &Frame, dirty: &Frame) -> Outcome {
        judge(self, clean, dirty)
    }
}

fn judge(pair: &Pair, clean: &Frame, dirty: &Frame) -> Outcome {
    let truth = pair.stations(&pair.off, clean, 0.0);
    let off = pair.stations(&pair.off, dirty, 0.0);
    let on = pair.stations(&pair.on, dirty, pair.min_fill);
    let mut outcome = Outcome::default();
    for ((truth, off), on) in truth.iter().zip(&off).zip(&on) {
        let Some((expected, _)) = truth else { continue };
        let error_off = off.map_or(0.0, |(d, _)| (d - expected).abs());
        outcome.harmful |= error_off > HARMED_UM;
        outcome.square_off += error_off * error_off;
        match on {
            None => outcome.gaps += 1,
            Some((d, u)) => {
                let error = (d - expected).abs();
                outcome.kept += 1;
                outcome.square += error * error;
                outcome.worst_um = outcome.worst_um.max(error);
                outcome.misled |= error > ALLOWED_UM + u;
            }
        }
    }
    outcome
}

fn kind(contaminant: Contaminant, outcomes: &[Outcome], seed: u64) -> KindResult {
    let harmful: Vec<&Outcome> = outcomes.iter().filter(|o| o.harmful).collect();
    let mishandled_seeds: Vec<u64> =
        (seed..).zip(outcomes).filter(|(_, o)| o.harmful && o.misled).map(|(seed, _)| seed).collect();
    let kept: usize = harmful.iter().map(|o| o.kept).sum();
    let all: usize = harmful.iter().map(|o| o.kept + o.gaps).sum();
    KindResult {
        contaminant,
        frames: outcomes.len(),
        harmful: harmful.len(),
        mishandled: mishandled_seeds.len(),
        mishandled_seeds,
        misled: outcomes.iter().filter(|o| o.misled).count(),
        kept: (all > 0).then(|| kept as f64 / all as f64),
        worst_um: outcomes.iter().map(|o| o.worst_um).fold(0.0, f64::max),
    }
}

/// A point of a curve: frames with one film in the middle of the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Height, µm, or half length, mm.
    pub(super) size: f64,
    /// Half length of the film, columns.
    half_length: f64,
    /// Its height, px.
    height_px: f64,
    /// What the seeds of its frames are counted from, above the study's.
    pub(super) stream: u64,
}

impl Point {
    /// The film, on the upper or on the lower edge.
    pub(super) fn bump(&self, upper: bool) -> Bump {
        let Self { half_length, height_px, .. } = *self;
        Bump { column: COLUMNS as f64 / 2.0, half_length, height_px, upper }
    }

    fn of(&self, outcomes: &[Outcome]) -> CurvePoint {
        let kept: usize = outcomes.iter().map(|o| o.kept).sum();
        let all: usize = outcomes.iter().map(|o| o.kept + o.gaps).sum();
        let rms = |square: f64, count: usize| (square / count.max(1) as f64).sqrt();
        let noticed = outcomes.iter().filter(|o| o.gaps > 0).count();
        CurvePoint {
            size: self.size,
            noticed: noticed as f64 / outcomes.len().max(1) as f64,
            rms_um: rms(outcomes.iter().map(|o| o.square).sum(), kept),
            rms_off_um: rms(outcomes.iter().map(|o| o.square_off).sum(), all),
        }
    }
}

/// Heights of films, µm.
const HEIGHTS_UM: [f64; 10] = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0];

/// Lengths of films, mm.
const LENGTHS_MM: [f64; 11] = [0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0, 20.0, 80.0];

/// The points of both curves: over the height, then over the half length.
pub(super) fn points() -> Vec<Point> {
    let height =
        |um: &f64| Point { size: *um, half_length: 40.0, height_px: um / PIXEL_UM, stream: 101 << 32 };
    let length = |mm: &f64| Point {
        size: *mm,
        half_length: mm * 1e3 / PIXEL_UM,
        height_px: 8.0 / PIXEL_UM,
        stream: 102 << 32,
    };
    HEIGHTS_UM.iter().map(height).chain(LENGTHS_MM.iter().map(length)).collect()
}

/// Frames of a point of a curve.
pub(super) fn few(frames: usize) -> usize {
    (frames / 20).max(4)
}

/// The study of the outcomes of all frames in their order: of every kind of contamination, clean,
/// of the points of the curves.
pub(super) fn result(outcomes: &[Outcome], frames: usize, clean: usize, seed: u64) -> ContaminationStudy {
    let mut rest = outcomes;
    let mut next = |count: usize| {
        let (own, others) = rest.split_at(count.min(rest.len()));
        rest = others;
        own
    };
    let of_kind =
        |(k, contaminant): (usize, &Contaminant)| kind(*contaminant, next(frames), seed + ((k as u64) << 32));
    let kinds = Contaminant::KINDS.iter().enumerate().map(of_kind).collect();
    let of_clean = next(clean);
    let mut by_height: Vec<CurvePoint> = points().iter().map(|p| p.of(next(few(frames)))).collect();
    let by_length = by_height.split_off(HEIGHTS_UM.len());
    ContaminationStudy {
        seed,
        kinds,
        clean_frames: clean,
        clean_lost: of_clean.iter().filter(|o| o.gaps > 0).count(),
        clean_worst_share: of_clean.iter().map(|o| o.refused_share).fold(0.0, f64::max),
        by_height,
        by_length,
    }
}
