//! Many frames of one camera: edges with tracking, the results of each, and those over all.

use super::conditions::known_conditions;
use super::crests::CrestStream;
use super::error::MeasureError;
use super::inspector::Inspector;
use super::judged::{Deciding, Judged};
use super::preparation::{check_size, copied, laid, prepared};
use super::reference_pin::{PinReader, ReferencePin, meta_of};
use super::result::Measurement;
use super::series::Series;
use super::settings::MeasureSettings;
use super::stated::is_uncalibrated;
use super::warning::Warning;
use crate::frame::{Buffer, Frame, FrameMeta, FrameView};
use crate::gauge::calibration::{Conditions, HeadGeometry};
use crate::gauge::{
    Calibration, EdgeStream, EsfModel, FrameEdges, Gauge, Rejection, Which, largest_caliper_over,
};
use crate::profile::Reason;

/// Digits of the largest number of a frame, 2⁶⁴ − 1.
const MOST_DIGITS: usize = 20;

/// The number of a frame as `render` names its files: with six digits or more.
fn number(frame_id: u64, digits: &mut [u8; MOST_DIGITS]) -> &str {
    let mut rest = frame_id;
    let mut first = MOST_DIGITS;
    while rest > 0 || first > MOST_DIGITS - 6 {
        first -= 1;
        digits[first] = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    std::str::from_utf8(&digits[first..]).unwrap_or_default()
}

/// Measures the frames of one camera one after another: [`Self::push`] a frame, [`Self::finish`]
/// the series.
pub struct Stream {
    settings: MeasureSettings,
    which: Option<Which>,
    learns: bool,
    edge_stream: EdgeStream,
    crests: Option<CrestStream>,
    inspector: Option<Inspector>,
    edges: FrameEdges,
    measurement: Measurement,
    unlearnt: usize,
    /// Memory of the last corrected frame.
    corrected: Option<Buffer>,
    /// A fixed pin beside the part.
    pin: Option<PinReader>,
    /// Limits of the scale's drift that the conditions state, ± ppm, beside that by temperature.
    stated_drift_ppm: Option<f64>,
}

impl Stream {
    /// A stream that gives millimetres, of the part's conditions.
    ///
    /// # Errors
    /// Settings out of range, or that exclude each other.
    pub fn new(
        gauge: &Gauge,
        calibration: &Calibration,
        conditions: &Conditions,
        settings: MeasureSettings,
    ) -> Result<Self, MeasureError> {
        settings.validate()?;
        let own = if settings.vertical { calibration.transposed() } else { calibration.clone() };
        let inspector = Inspector::new(settings.clone(), own, *conditions)?;
        Ok(Self { inspector: Some(inspector), ..Self::of(gauge, settings) })
    }

    /// A stream in the conditions that the calibration itself carries.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn calibrated(
        gauge: &Gauge,
        calibration: &Calibration,
        settings: MeasureSettings,
    ) -> Result<Self, MeasureError> {
        Self::new(gauge, calibration, &known_conditions(Some(calibration)), settings)
    }

    /// A stream that gives pixels only.
    ///
    /// # Errors
    /// Settings that need millimetres.
    pub fn in_pixels(gauge: &Gauge, settings: MeasureSettings) -> Result<Self, MeasureError> {
        settings.validate()?;
        match settings.needs_scale() {
            Some(setting) => Err(MeasureError::NeedsScale { setting }),
            None => Ok(Self::of(gauge, settings)),
        }
    }

    fn of(gauge: &Gauge, settings: MeasureSettings) -> Self {
        let of = gauge.settings();
        // Where less than the full rejection is asked for, the outline is measured as it is.
        let crests = settings.crests && of.rejection == Rejection::default();
        Self {
            which: of.which,
            learns: of.esf == (EsfModel::Learnt {}),
            edge_stream: gauge.stream(),
            crests: crests.then(|| CrestStream::new(of)),
            inspector: None,
            edges: FrameEdges::default(),
            measurement: Measurement::default(),
            unlearnt: 0,
            corrected: None,
            pin: None,
            stated_drift_ppm: None,
            settings,
        }
    }

    /// With a fixed pin beside the part that corrects every frame: the part is measured in the
    /// columns of the pin's wider side, which are counted from there on.
    ///
    /// # Errors
    /// A stream that gives pixels only.
    pub fn with_reference_pin(mut self, gauge: &Gauge, pin: ReferencePin) -> Result<Self, MeasureError> {
        let Some(inspector) = &self.inspector else {
            return Err(MeasureError::NeedsScale { setting: "reference_pin" });
        };
        self.pin = Some(PinReader::new(pin, gauge, &inspector.calibration));
        Ok(self)
    }

    /// With the place of the head on a machine over z: every frame is corrected by that at its own
    /// z, which a displacement along the spindle moves. A frame outside the geometry's range has no
    /// diameter.
    #[must_use]
    pub fn with_head_geometry(mut self, geometry: Option<HeadGeometry>) -> Self {
        if let Some(inspector) = &mut self.inspector {
            inspector.geometry = geometry;
        }
        self
    }

    /// Measures a frame, as the camera gives it, by its number.
    ///
    /// # Errors
    /// A frame without a diameter: it counts as a gap of the series, and [`Self::measurement`] is
    /// what the command line prints of it.
    pub fn push(&mut self, meta: &FrameMeta, view: &FrameView<'_>) -> Result<&Measurement, MeasureError> {
        let mut digits = [0; MOST_DIGITS];
        self.push_named(number(meta.frame_id, &mut digits), meta, view)
    }

    /// Measures a frame by a name.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn push_named(
        &mut self,
        name: &str,
        meta: &FrameMeta,
        view: &FrameView<'_>,
    ) -> Result<&Measurement, MeasureError> {
        let calibration = self.inspector.as_ref().map(|i| &i.calibration);
        let setup = calibration.and_then(|c| c.setup.as_ref());
        if setup.is_some_and(|setup| setup.flat_field.is_some())
            && let Ok(frame) = copied(meta, view, self.corrected.take())
        {
            return match self.prepared(name, frame) {
                Ok(frame) => {
                    let pushed = self.push_prepared(name, meta, &frame.view()).map(|_| ());
                    self.corrected = Some(frame.into_buffer());
                    pushed.map(|()| &self.measurement)
                }
                Err(error) => self.refuse_unread(name, error),
            };
        }
        if let Err(error) = check_size(name, &laid(view, self.settings.vertical), calibration) {
            return self.refuse_unread(name, error);
        }
        self.push_prepared(name, meta, view)
    }

    /// A frame with the calibration's corrections of sensor and light, for
    /// [`Self::push_prepared`].
    ///
    /// # Errors
    /// Another size than the calibration's.
    pub fn prepared(&self, name: &str, frame: Frame) -> Result<Frame, MeasureError> {
        let calibration = self.inspector.as_ref().map(|i| &i.calibration);
        prepared(name, frame, calibration, self.settings.vertical)
    }

    /// Measures a frame that has its corrections ([`Self::prepared`]), without a copy of it.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn push_prepared(
        &mut self,
        name: &str,
        meta: &FrameMeta,
        view: &FrameView<'_>,
    ) -> Result<&Measurement, MeasureError> {
        let view = laid(view, self.settings.vertical);
        if self.pin.is_some() {
            return self.push_beside_pin(name, meta, &view);
        }
        self.push_laid(name, meta, &view)
    }

    /// Measures a frame, its shaft lying level, beside the reference pin.
    fn push_beside_pin(
        &mut self,
        name: &str,
        meta: &FrameMeta,
        view: &FrameView<'_>,
    ) -> Result<&Measurement, MeasureError> {
        match self.read_pin(view) {
            Err(why) => {
                self.begin(name, meta.frame_id, view.columns());
                self.refuse(MeasureError::ReferencePin { frame: name.to_owned(), why })
            }
            Ok((part, columns)) => {
                let pitch_mm = self.inspector.as_ref().map_or(0.0, |i| i.calibration.scale_mm_per_px);
                let meta = meta_of(meta, columns, view.columns(), pitch_mm);
                self.push_laid(name, &meta, &part)
            }
        }
    }

    /// Takes the correction of a frame by its pin; the view of the part, and its columns.
    fn read_pin<'a>(&mut self, view: &FrameView<'a>) -> Result<(FrameView<'a>, [usize; 2]), String> {
        let (Some(pin), Some(inspector)) = (&mut self.pin, &mut self.inspector) else {
            return Err("there is none".to_owned());
        };
        let columns = pin.part_columns(view.columns())?;
        inspector.change.pin = Some(pin.read(view)?);
        if let Some(place) = pin.part_place(columns[0]) {
            // the lens of the part's columns, once the size of the frames is known
            inspector.calibration = place;
        }
        let part = view.columns_between(columns[0], columns[1]).ok_or("it leaves no part")?;
        Ok((part, columns))
    }

    /// Measures a frame whose shaft lies level.
    fn push_laid(
        &mut self,
        name: &str,
        meta: &FrameMeta,
        view: &FrameView<'_>,
    ) -> Result<&Measurement, MeasureError> {
        self.begin(name, meta.frame_id, view.columns());
        let placed = self.inspector.as_mut().map_or(Ok(None), |i| i.take_place(name, meta));
        let placed = match placed {
            Ok(placed) => placed,
            Err(error) => return self.refuse(error),
        };
        let meta = placed.as_ref().unwrap_or(meta);
        if let Err(error) = self.measure_edges(name, meta, view) {
            return self.refuse(error);
        }
        self.take_edges();
        let Some(inspector) = &mut self.inspector else { return Ok(&self.measurement) };
        let added = inspector.add(meta, &self.edges, &mut self.measurement);
        if self.which.is_none() && self.edges.figures.shadows.left_out_px > 0.0 {
            // A shadow as large as the measured one was left out without a request.
            inspector.not_proven(&mut self.measurement);
            if self.measurement.judged.is_some() {
                let by = Deciding::Gap(Reason::SeveralShadows);
                self.measurement.judged = Some(Judged { what: "frame", z_mm: None, by });
            }
        }
        added.map(|()| &self.measurement)
    }

    /// A frame that its source could not deliver: a gap of the series; `why` is the source's
    /// reason.
    pub fn push_unreadable(&mut self, name: &str, why: String) -> &Measurement {
        self.begin(name, 0, 0);
        self.take_refusal(Reason::Unreadable, why);
        &self.measurement
    }

    /// The frame pushed last.
    pub fn measurement(&self) -> &Measurement {
        &self.measurement
    }

    /// Takes the budget out of the frame pushed last.
    pub(crate) fn leave_out_budget(&mut self) {
        self.measurement.budget = None;
    }

    /// The edges of the frame pushed last, px; `None` where it was refused.
    pub fn edges(&self) -> Option<&FrameEdges> {
        self.measurement.refusal.is_none().then_some(&self.edges)
    }

    /// Frames whose edge-spread function was to be learnt and that were measured with a Gaussian:
    /// their edges show too few sub-pixel phases.
    pub fn unlearnt(&self) -> usize {
        self.unlearnt
    }

    /// Whether sizes are judged by a scale alone, whose uncertainty is in none of them.
    pub fn judges_uncalibrated(&self) -> bool {
        self.inspector.as_ref().is_some_and(|i| i.judge.is_some() && is_uncalibrated(&i.calibration))
    }

    /// The conditions of the part; with a calibration.
    pub(crate) fn conditions(&self) -> Option<&Conditions> {
        self.inspector.as_ref().map(|i| &i.conditions)
    }

    /// The temperature of the part from the next frame on, °C, and the limits of its error, ± K;
    /// without a calibration it matters to nothing.
    pub fn set_part_temperature(&mut self, part_c: f64, limit_k: f64) {
        if let Some(inspector) = &mut self.inspector {
            let conditions = &mut inspector.conditions;
            (conditions.temperature_c, conditions.limit_temperature_k) = (part_c, limit_k);
            conditions.unstated.temperature = false;
        }
    }

    /// Limits of the scale's drift by its temperature since the calibration, from the next frame
    /// on, ± ppm; they add to those that the conditions state. Without a calibration there are
    /// none.
    pub fn set_scale_drift(&mut self, limit_ppm: f64) {
        if let Some(inspector) = &mut self.inspector {
            let drift_ppm = &mut inspector.conditions.limit_drift_ppm;
            let stated_ppm = *self.stated_drift_ppm.get_or_insert(*drift_ppm);
            *drift_ppm = stated_ppm + limit_ppm;
        }
    }

    /// Standard uncertainty of all diameters by the gauge's drift since its last zero, from the
    /// next frame on, mm, with its inputs for the budget ("1.2 h, head +0.4 K"); without a
    /// calibration there is none.
    pub fn set_zero_drift(&mut self, u_mm: f64, since: String) {
        if let Some(inspector) = &mut self.inspector {
            inspector.change.drift = Some((u_mm, since));
        }
    }

    /// Another part from the next frame on: its diameter has to settle by itself.
    pub fn restart_settling(&mut self) {
        if let Some(part) = self.inspector.as_mut().and_then(|i| i.settled.as_mut()) {
            part.restart();
        }
    }

    /// The part turns: what must agree are means of whole turns, by the angles of the frames.
    pub fn settle_by_turns(&mut self) {
        if let Some(part) = self.inspector.as_mut().and_then(|i| i.settled.as_mut()) {
            part.take_turns();
        }
    }

    /// Refuses the frame pushed last for a reason outside of it: it has no diameter then, and what
    /// settled has to settle again.
    #[cfg(feature = "cli")]
    pub(crate) fn refuse_measured(&mut self, why: String) {
        let columns = self.measurement.columns;
        let (name, id) = (std::mem::take(&mut self.measurement.frame), self.measurement.frame_id);
        self.begin(&name, id, columns);
        self.measurement.refuse(Reason::Unreadable, why);
        if let Some(inspector) = &mut self.inspector {
            inspector.not_proven(&mut self.measurement);
        }
        self.restart_settling();
    }

    /// The results over all frames.
    ///
    /// # Errors
    /// Frames that do not form a turn, where they were to.
    pub fn finish(self) -> Result<Series, MeasureError> {
        self.inspector.map_or_else(|| Ok(Series::default()), Series::of)
    }

    /// Starts another frame, in the memory of the last one's results.
    fn begin(&mut self, name: &str, frame_id: u64, columns: usize) {
        if let Some(inspector) = &mut self.inspector {
            inspector.take_back(&mut self.measurement);
        }
        self.measurement.begin(name, frame_id, columns);
    }

    /// Edges of a frame whose shaft lies level.
    fn measure_edges(
        &mut self,
        name: &str,
        meta: &FrameMeta,
        view: &FrameView<'_>,
    ) -> Result<(), MeasureError> {
        let frame = || name.to_owned();
        if let Some(inspector) = &self.inspector {
            let checked = inspector.calibration.check_encoding(meta.encoding);
            checked.map_err(|source| MeasureError::OtherEncoding { frame: frame(), source })?;
        }
        let first = self.edge_stream.measure(view, &mut self.edges);
        let looked_for = first.as_ref().copied();
        let crests = self.crests.as_mut().and_then(|c| c.measure(looked_for, &mut self.edges, view));
        self.measurement.crest_pitch_px = crests;
        if let (None, Err(source)) = (crests, first) {
            return Err(MeasureError::Refused { frame: frame(), source });
        }
        let rows_between = meta.rows_between().unwrap_or(self.settings.rows_between);
        self.edges.place_windows(0.0, f64::from(rows_between));
        self.check_focus(name)
    }

    /// Refuses a frame whose blur differs from the masters', because its edges are displaced.
    fn check_focus(&self, name: &str) -> Result<(), MeasureError> {
        let Some(inspector) = self.inspector.as_ref().filter(|_| !self.settings.accept_blur) else {
            return Ok(());
        };
        let Some(setup) = &inspector.calibration.setup else { return Ok(()) };
        setup
            .check_focus(self.edges.figures.sigma_px, &inspector.conditions)
            .map_err(|source| MeasureError::Blurred { frame: name.to_owned(), source })
    }

    /// What the edges show, with the remarks on the choice of the shadow.
    fn take_edges(&mut self) {
        let calibration = self.inspector.as_ref().map(|i| &i.calibration);
        let least = self.settings.least_stretch(calibration);
        let largest = largest_caliper_over(&self.edges, least);
        self.measurement.take_edges(&self.edges, largest);
        self.unlearnt += usize::from(self.learns && self.edges.figures.position_ambiguity_px == [0.0; 2]);
        let warnings = &mut self.measurement.warnings;
        warnings.extend(Warning::of_shadows(&self.edges.figures.shadows, self.which));
        // The flanks of a disc seen end-on are always steep and are not measured.
        if !largest.is_some_and(|l| l.end_on) {
            warnings.extend(Warning::of_flanks(&self.edges));
        }
        warnings.extend(self.measurement.crest_pitch_px.map(|pitch_px| Warning::Crests { pitch_px }));
    }

    fn refuse(&mut self, error: MeasureError) -> Result<&Measurement, MeasureError> {
        self.measurement.crest_pitch_px = None;
        self.take_refusal(error.reason(), error.to_string());
        Err(error)
    }

    /// A frame of another size than the calibration's: nothing of it is read.
    fn refuse_unread(&mut self, name: &str, error: MeasureError) -> Result<&Measurement, MeasureError> {
        self.begin(name, 0, 0);
        self.refuse(error)
    }

    fn take_refusal(&mut self, reason: Reason, why: String) {
        self.measurement.refuse(reason, why);
        if let Some(inspector) = &mut self.inspector {
            inspector.add_refused(&mut self.measurement);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_named_as_they_are_rendered() {
        for (id, name) in [(0, "000000"), (42, "000042"), (1_234_567, "1234567")] {
            assert_eq!(number(id, &mut [0; MOST_DIGITS]), name);
        }
        assert_eq!(number(u64::MAX, &mut [0; MOST_DIGITS]), u64::MAX.to_string());
    }
}
