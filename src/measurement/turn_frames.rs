//! The frames of a revolution: what of them its form, its sizes and its axis need.
//!
//! Sections divide the length that all frames show together. A scan along z shows it once its last
//! frame is there: its columns are kept until then, up to [`MOST_COLUMNS`]. A camera that stands
//! shows it in every frame: after [`KEPT`] frames at one place the columns of these are summed up
//! by section and spindle angle, those of every further frame at once, and the memory does not grow
//! any more. The sums are those that the kept columns would give, but for one thing: what turns
//! towards the camera is taken off by the axis of the kept frames, some revolutions, not by that of
//! all.

use super::error::MeasureError;
use super::turn_angles::TurnAngles;
use crate::frame::FrameMeta;
use crate::gauge::axis_line::{AxisAverager, AxisLine};
use crate::gauge::diameter::sections::{Envelope, PartForm, TurnAverager};
use crate::gauge::diameter::turning_depth::{DepthCorrection, Telecentricity};
use crate::gauge::form::Cutoff;
use crate::gauge::{Calibration, ColumnDiameters};

/// Frames at one place whose columns are kept: more than a scan takes at one field (720 in half
/// degrees); 160 MB of frames of 2448 columns.
const KEPT: usize = 1024;
/// Most columns of a scan along the part that are kept: 2 GiB at 64 bytes, a half or a quarter of
/// the memory of a computer beside a machine; 13 700 frames of 2448 columns, nineteen fields at
/// half degrees.
const MOST_COLUMNS: usize = 1 << 25;
/// Columns of a section of an envelope: wide enough to suppress the noise of single columns, narrow
/// enough to resolve a crest of that width.
const ENVELOPE_COLUMNS: f64 = 8.0;
/// Number of places at which the axis is reported where there are no stations.
const AXIS_PLACES: f64 = 16.0;

/// What is asked of the frames of a revolution.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) station_mm: Option<f64>,
    pub(super) cutoff: Cutoff,
    /// Whether a tolerance applies to the envelope.
    pub(super) envelope: bool,
    pub(super) calibration: &'a Calibration,
}

/// A frame with the diameters of its columns.
type Seen = (FrameMeta, ColumnDiameters);

/// Where a frame stands and how much it shows: z, columns, pitch.
type View = (f64, usize, f64);

fn view(meta: &FrameMeta, diameters: &ColumnDiameters) -> View {
    (meta.z_mm, diameters.columns.len(), diameters.pitch_mm)
}

/// The frames of a revolution so far.
#[derive(Default)]
pub(super) struct TurnFrames {
    kept: Vec<Seen>,
    /// The first frame's view, as long as all have it.
    stands: Option<View>,
    standing: Option<Gathered>,
    /// Frames that stand elsewhere than those that were summed up.
    elsewhere: usize,
    kept_columns: usize,
    /// Frames of a scan beyond those that are kept.
    beyond: usize,
    angles: TurnAngles,
}

/// Form, sizes and axis of a revolution.
pub(super) struct TurnResults {
    pub(super) axis: AxisLine,
    pub(super) form: PartForm,
    /// The envelope, or why there is none; not where it is not asked for.
    pub(super) envelope: Option<Result<Envelope, String>>,
    /// By section of the form, its common standard uncertainty, mm.
    pub(super) common: Vec<(f64, Option<f64>)>,
    pub(super) left_out: LeftOut,
    pub(super) angles: TurnAngles,
}

/// Frames that are not in the form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LeftOut {
    /// Those that stand elsewhere than a long series before them.
    pub(super) elsewhere: usize,
    /// Those of a scan beyond the first that are kept.
    pub(super) beyond: usize,
}

impl TurnResults {
    /// Common standard uncertainty of the sizes of the section at `z_mm`, mm.
    pub(super) fn common_mm(&self, z_mm: f64) -> Option<f64> {
        self.common.iter().find(|(z, _)| *z == z_mm)?.1
    }
}

impl TurnFrames {
    /// Adds a frame.
    pub(super) fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters, asked: &Asked<'_>) {
        if diameters.columns.iter().any(|c| c.reading.value().is_some()) {
            self.angles.add(meta);
        }
        let view = view(meta, diameters);
        if let Some(standing) = &mut self.standing {
            match self.stands == Some(view) {
                true => standing.add(meta, diameters),
                false => self.elsewhere += 1,
            }
            return;
        }
        if self.kept_columns + diameters.columns.len() > MOST_COLUMNS {
            self.beyond += 1;
            return;
        }
        self.kept_columns += diameters.columns.len();
        self.stands = if self.kept.is_empty() { Some(view) } else { self.stands.filter(|v| *v == view) };
        self.kept.push((meta.clone(), diameters.clone()));
        if self.kept.len() == KEPT && self.stands.is_some() {
            self.standing = Gathered::of(&std::mem::take(&mut self.kept), asked, true);
        }
    }

    /// Ends the revolution.
    ///
    /// # Errors
    /// Frames that do not form a turn.
    pub(super) fn finish(self, asked: &Asked<'_>) -> Result<TurnResults, MeasureError> {
        let gathered = self.standing.or_else(|| Gathered::of(&self.kept, asked, false));
        let Gathered { axis, form, envelope, common, .. } = gathered.ok_or(MeasureError::NoFrameOfTurn)?;
        let form = form.finish(asked.cutoff);
        if let (Some((z_mm, why)), true) = (form.refused.first(), form.sections.is_empty()) {
            return Err(MeasureError::NoTurn { z_mm: *z_mm, why: why.clone() });
        }
        let envelope = envelope.map(|envelope| envelope.envelope(asked.cutoff));
        let common = common.sums.iter().map(|s| (s.z_mm, s.mean_mm())).collect();
        let left_out = LeftOut { elsewhere: self.elsewhere, beyond: self.beyond };
        Ok(TurnResults { axis: axis.finish(), form, envelope, common, left_out, angles: self.angles })
    }
}

/// What frames show, summed up.
struct Gathered {
    axis: AxisAverager,
    correction: Option<DepthCorrection>,
    form: TurnAverager,
    envelope: Option<TurnAverager>,
    common: Common,
    /// Memory of a frame's corrected diameters.
    corrected: ColumnDiameters,
}

impl Gathered {
    /// Of these frames, and of more like them where all stand at one place; `None` where they show
    /// no length.
    fn of(frames: &[Seen], asked: &Asked<'_>, stands: bool) -> Option<Self> {
        let (low, high) = z_range_mm(frames)?;
        let (axis, correction) = axis(frames, (low, high), asked, stands);
        let whole = high - low + 1e-9;
        let length_mm = asked.station_mm.unwrap_or(whole).min(whole);
        let z_mm = middles((low, high), length_mm);
        let common = Common::new(&z_mm, length_mm, asked.station_mm.unwrap_or(f64::INFINITY));
        let averager = |z_mm, length_mm| {
            let averager = TurnAverager::new(z_mm, length_mm);
            if stands { averager.standing() } else { averager }
        };
        let envelope = asked.envelope.then(|| {
            let pitch_mm = frames.iter().map(|(_, d)| d.pitch_mm).fold(f64::NAN, f64::max);
            // From the outer side of the first column to that of the last, without a remainder.
            let range = (low - 0.5 * pitch_mm, high + 0.5 * pitch_mm);
            let count = ((range.1 - range.0) / (ENVELOPE_COLUMNS * pitch_mm)).round().max(1.0);
            let length_mm = (range.1 - range.0) / count;
            averager(middles(range, length_mm), length_mm)
        });
        let (form, corrected) = (averager(z_mm, length_mm), ColumnDiameters::default());
        let mut this = Self { axis, correction, form, envelope, common, corrected };
        frames.iter().for_each(|(meta, diameters)| this.add_sizes(meta, diameters));
        Some(this)
    }

    fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        self.axis.add(meta, diameters);
        self.add_sizes(meta, diameters);
    }

    /// All but the axis.
    fn add_sizes(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        let diameters = match &self.correction {
            None => diameters,
            Some(correction) => {
                self.corrected.clone_from(diameters);
                correction.apply(meta, &mut self.corrected);
                &self.corrected
            }
        };
        self.form.add(meta, diameters);
        if let Some(envelope) = &mut self.envelope {
            envelope.add(meta, diameters);
        }
        self.common.add(meta, diameters);
    }
}

/// The axis along the length that the frames show, and what of it turns towards the camera, where
/// the calibration determines the telecentricity.
fn axis(
    frames: &[Seen],
    (low, high): (f64, f64),
    asked: &Asked<'_>,
    stands: bool,
) -> (AxisAverager, Option<DepthCorrection>) {
    let length_mm = asked.station_mm.unwrap_or((high - low) / AXIS_PLACES).min(high - low);
    // From the first row of the frames, or from the axis of the lens.
    let zero = asked.calibration.axis_zero(1.0);
    let axis = AxisAverager::new(middles((low, high), length_mm), length_mm, zero);
    let mut axis = if stands { axis.standing() } else { axis };
    frames.iter().for_each(|(meta, diameters)| axis.add(meta, diameters));
    let correction = Telecentricity::of(asked.calibration).map(|telecentricity| {
        let angles: Vec<f64> = frames.iter().map(|(meta, _)| meta.angle_deg).collect();
        DepthCorrection::new(axis.finish(), &angles, telecentricity)
    });
    (axis, correction)
}

/// Lowest and highest z that frames show, mm.
fn z_range_mm(frames: &[Seen]) -> Option<(f64, f64)> {
    let ends = frames
        .iter()
        .filter(|(_, d)| !d.columns.is_empty())
        .map(|(meta, d)| (d.z_mm(meta, 0), d.z_mm(meta, d.columns.len() - 1)));
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
    (high > low).then_some((low, high))
}

/// Middles of the sections of a length, whole sections only.
fn middles((low, high): (f64, f64), length_mm: f64) -> Vec<f64> {
    let count = ((high - low) / length_mm + 1e-6).floor().clamp(1.0, 1e5) as usize;
    (0..count).map(|i| low + (i as f64 + 0.5) * length_mm).collect()
}

/// Common standard uncertainties of the columns of every section.
struct Common {
    sums: Vec<CommonSum>,
    pitch_mm: f64,
    /// Length over which columns belong to a section, mm.
    over_mm: f64,
}

struct CommonSum {
    z_mm: f64,
    sum_mm: f64,
    columns: f64,
}

impl CommonSum {
    /// That of its columns, to which it is common.
    fn mean_mm(&self) -> Option<f64> {
        (self.columns > 0.0).then(|| self.sum_mm / self.columns)
    }
}

impl Common {
    /// Of sections with these middles, `pitch_mm` apart, and of the columns within `over_mm`.
    fn new(z_mm: &[f64], pitch_mm: f64, over_mm: f64) -> Self {
        let sum = |z_mm: &f64| CommonSum { z_mm: *z_mm, sum_mm: 0.0, columns: 0.0 };
        Self { sums: z_mm.iter().map(sum).collect(), pitch_mm, over_mm }
    }

    fn add(&mut self, meta: &FrameMeta, diameters: &ColumnDiameters) {
        let Some(first_mm) = self.sums.first().map(|sum| sum.z_mm) else { return };
        for (index, column) in diameters.columns.iter().enumerate() {
            let Some(d) = column.reading.value() else { continue };
            let z_mm = diameters.z_mm(meta, index);
            // A column at the border of two sections belongs to both.
            let near = ((z_mm - first_mm) / self.pitch_mm).round().max(0.0) as usize;
            let last = (near + 2).min(self.sums.len());
            let sections = self.sums.get_mut(near.saturating_sub(1)..last).unwrap_or_default();
            for sum in sections.iter_mut().filter(|s| (z_mm - s.z_mm).abs() <= 0.5 * self.over_mm) {
                sum.sum_mm += d.u_common_mm;
                sum.columns += 1.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::diameter::column_diameters::ColumnDiameter;
    use crate::profile::{Diameter, Reading, Reason};

    /// Frame `index` of an oval, eccentric, tapered part, 24 a revolution; some columns are gaps.
    fn frame(index: usize, z_mm: f64) -> Seen {
        let angle_deg = 15.0 * index as f64;
        let phi = angle_deg.to_radians();
        let column = |c: usize| {
            let along = z_mm + 0.1 * c as f64;
            let noise = 1e-5 * ((index * 31 + c * 17) % 13) as f64;
            let d_mm = 20.0 + 1e-3 * along + 4e-3 * (2.0 * phi).cos() + noise;
            let value = Diameter { d_mm, u_random_mm: 1e-4, u_common_mm: 1e-3 + 1e-6 * along };
            let reading = if (c + index).is_multiple_of(29) {
                Reading::Gap(Reason::Residual)
            } else {
                Reading::Value(value)
            };
            let middle_mm = 3.0 + 5e-3 * phi.cos() + 0.3 * noise;
            ColumnDiameter { reading, shared_mm: 2e-5, width_px: 200.0, middle_mm, u_middle_common_mm: 1e-4 }
        };
        let meta = FrameMeta { angle_deg, z_mm, ..FrameMeta::default() };
        let columns = (0..100).map(column).collect();
        (meta, ColumnDiameters { columns, shared_length: 3.0, pitch_mm: 0.1 })
    }

    fn asked(calibration: &Calibration, station_mm: Option<f64>) -> Asked<'_> {
        Asked { station_mm, cutoff: Cutoff::UPR_50, envelope: true, calibration }
    }

    #[test]
    fn a_camera_that_stands_gives_the_same_sums_in_memory_that_does_not_grow() {
        let calibration = Calibration::from_scale(100.0);
        for station_mm in [None, Some(2.5)] {
            let asked = asked(&calibration, station_mm);
            let frames: Vec<Seen> = (0..KEPT + 100).map(|index| frame(index, 5.0)).collect();
            let mut turn = TurnFrames::default();
            frames.iter().for_each(|(meta, d)| turn.add(meta, d, &asked));
            assert!(turn.standing.is_some() && turn.kept.is_empty());
            let found = turn.finish(&asked).unwrap();
            let all = TurnFrames { kept: frames, ..TurnFrames::default() };
            let right = all.finish(&asked).unwrap();
            assert_eq!(found.form, right.form);
            assert_eq!(found.axis.stations.len(), right.axis.stations.len());
            for (a, b) in found.axis.stations.iter().zip(&right.axis.stations) {
                assert!((a.x_mm - b.x_mm).abs() < 1e-12 && a.angles == b.angles);
            }
            assert_eq!(found.common, right.common);
            assert_eq!(found.envelope, right.envelope);
            assert!(found.envelope.is_some_and(|e| e.is_ok()) && found.left_out == LeftOut::default());
        }
    }

    #[test]
    fn a_scan_along_the_part_is_kept_and_what_comes_late_from_elsewhere_is_counted() {
        let calibration = Calibration::from_scale(100.0);
        let asked = asked(&calibration, Some(2.5));
        let mut scan = TurnFrames::default();
        for index in 0..2 * KEPT {
            let (meta, d) = frame(index, if index % 48 < 24 { 5.0 } else { 12.0 });
            scan.add(&meta, &d, &asked);
        }
        assert!(scan.standing.is_none() && scan.kept.len() == 2 * KEPT);
        // One that has no room any more is counted, and the form is that of those before it.
        scan.kept_columns = MOST_COLUMNS - 100;
        for index in 2 * KEPT..2 * KEPT + 3 {
            let (meta, d) = frame(index, 12.0);
            scan.add(&meta, &d, &asked);
        }
        assert_eq!((scan.kept.len(), scan.beyond), (2 * KEPT + 1, 2));
        let mut stood = TurnFrames::default();
        for index in 0..KEPT + 5 {
            let (meta, d) = frame(index, if index < KEPT { 5.0 } else { 12.0 });
            stood.add(&meta, &d, &asked);
        }
        assert_eq!(stood.elsewhere, 5);
    }
}
