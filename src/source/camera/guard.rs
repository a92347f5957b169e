//! Features that alter grey values or geometry: set off, or refused, and restored at the end.
//!
//! Names are those of the SFNC 2.7 unless a line states another origin. Grey values must be linear
//! in light (EMVA 1288 4.0, section 2) and the same from frame to frame, since edges are fitted to
//! them.

use super::error::CameraError;
use super::features::Features;

/// What is done about a feature that has another value than the right one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Action {
    /// It is set, and restored at the end.
    Set,
    /// The camera is refused: the right value changes size or place of the pixels, by which a
    /// calibration is bound, or cannot be set at all.
    Refuse,
}

/// Feature, the value that is right, what is done about another one, and what that does.
type Rule = (&'static str, &'static str, Action, &'static str);

const CURVE: &str = "grey values are not linear in light";
const AUTOMATIC: &str = "grey values change from frame to frame by themselves";
const FILTER: &str = "a filter moves edges";
const JOINED: &str = "pixels are joined or left out";
const MIRRORED: &str = "frames are mirrored against the calibration";
const PATTERN: &str = "frames are a test pattern, not the sensor's";
const SHUTTER: &str = "rows are exposed at different times, so that a turning part is sheared";

const RULES: [Rule; 21] = [
    ("ExposureAuto", "Off", Action::Set, AUTOMATIC),
    ("GainAuto", "Off", Action::Set, AUTOMATIC),
    ("BlackLevelAuto", "Off", Action::Set, AUTOMATIC),
    ("GammaEnable", "false", Action::Set, CURVE),
    ("Gamma", "1", Action::Set, CURVE),
    ("LUTEnable", "false", Action::Set, CURVE),
    // Teledyne FLIR Spinnaker, Basler pylon (ace 2)
    ("SharpeningEnable", "false", Action::Set, FILTER),
    ("BslSharpnessEnhancement", "0", Action::Set, FILTER),
    ("BslNoiseReduction", "0", Action::Set, FILTER),
    ("ReverseX", "false", Action::Refuse, MIRRORED),
    ("ReverseY", "false", Action::Refuse, MIRRORED),
    ("BinningHorizontal", "1", Action::Refuse, JOINED),
    ("BinningVertical", "1", Action::Refuse, JOINED),
    ("DecimationHorizontal", "1", Action::Refuse, JOINED),
    ("DecimationVertical", "1", Action::Refuse, JOINED),
    ("TestPattern", "Off", Action::Refuse, PATTERN),
    // its name before SFNC 2.0
    ("TestImageSelector", "Off", Action::Refuse, PATTERN),
    ("ImageCompressionMode", "Off", Action::Refuse, "pixels are compressed"),
    ("SensorShutterMode", "Global", Action::Refuse, SHUTTER),
    // Basler pylon
    ("ShutterMode", "Global", Action::Refuse, SHUTTER),
    ("DeviceScanType", "Areascan", Action::Refuse, "an area camera is needed"),
];

/// Whether two texts are the same value: numbers, truth values, or names in any case. Binning by
/// enumeration is named X1, x2 and so on.
fn is_same(found: &str, right: &str) -> bool {
    let number = |text: &str| text.trim_start_matches(['x', 'X']).parse::<f64>().ok();
    let flag = |text: &str| match text.to_ascii_lowercase().as_str() {
        "true" | "on" => Some(true),
        "false" | "off" => Some(false),
        _ => None,
    };
    let (found, right) = (found.trim(), right.trim());
    found.eq_ignore_ascii_case(right)
        || matches!((number(found), number(right)), (Some(a), Some(b)) if (a - b).abs() < 1e-6)
        || matches!((flag(found), flag(right)), (Some(a), Some(b)) if a == b)
}

/// A selector and its entry.
type Selected<'a> = (&'a str, &'a str);

/// What a feature had before it was set.
#[derive(Clone, Debug, PartialEq)]
struct Had {
    selected: Option<(String, String)>,
    name: String,
    value: String,
}

/// Values that features had before they were set.
#[derive(Clone, Debug, Default)]
pub(crate) struct Restore {
    /// In the order in which they were set.
    had: Vec<Had>,
}

impl Restore {
    /// Sets a feature where it has another value, which is kept; whether it had.
    ///
    /// # Errors
    /// A camera that does not have it or does not take it.
    pub(super) fn set(
        &mut self,
        camera: &mut impl Features,
        name: &str,
        value: &str,
    ) -> Result<bool, CameraError> {
        self.set_of(camera, None, name, value)
    }

    /// Sets a feature of an entry of its selector.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub(super) fn set_selected(
        &mut self,
        camera: &mut impl Features,
        selected: Selected<'_>,
        (name, value): (&str, &str),
    ) -> Result<bool, CameraError> {
        camera.set(selected.0, selected.1).map_err(|cause| not_set(selected.0, selected.1, cause))?;
        self.set_of(camera, Some(selected), name, value)
    }

    fn set_of(
        &mut self,
        camera: &mut impl Features,
        selected: Option<Selected<'_>>,
        name: &str,
        value: &str,
    ) -> Result<bool, CameraError> {
        let had = camera.value(name);
        if had.as_ref().is_some_and(|had| is_same(had, value)) {
            return Ok(false);
        }
        camera.set(name, value).map_err(|cause| not_set(name, value, cause))?;
        let selected = selected.map(|(selector, entry)| (selector.to_owned(), entry.to_owned()));
        // A camera that was away is set again: what it had first counts.
        let is_new = self.had.iter().all(|known| known.name != name || known.selected != selected);
        if let Some(value) = had.filter(|_| is_new) {
            self.had.push(Had { selected, name: name.to_owned(), value });
        }
        Ok(true)
    }

    /// Restores the values of the features, the last one first; returns what could not be restored,
    /// as text.
    pub(super) fn restore(&mut self, camera: &mut impl Features) -> Vec<String> {
        let restored = std::mem::take(&mut self.had).into_iter().rev().map(|had| {
            let Had { selected, name, value } = had;
            let select = selected.map_or(Ok(()), |(selector, entry)| camera.set(&selector, &entry));
            let set = select.and_then(|()| camera.set(&name, &value));
            set.map_err(|why| format!("{name} was {value} and is not restored: {why}"))
        });
        restored.filter_map(Result::err).collect()
    }

    /// As [`Self::restore`]; what could not be restored is a warning each.
    pub(super) fn give_back(&mut self, camera: &mut impl Features) {
        self.restore(camera).iter().for_each(|why| tracing::warn!("{why}"));
    }
}

fn not_set(feature: &str, value: &str, cause: String) -> CameraError {
    CameraError::NotSet { feature: feature.to_owned(), value: value.to_owned(), cause }
}

/// Refuses what cannot be set off, then sets off the rest; what was set, or is taken as it is, in
/// words. A rolling shutter is taken where that is accepted.
///
/// # Errors
/// A feature with a value that frames cannot be measured with.
pub(super) fn guard(
    camera: &mut impl Features,
    accepts_rolling_shutter: bool,
    restore: &mut Restore,
) -> Result<Vec<String>, CameraError> {
    let other = |camera: &dyn Features, (feature, right, _, _): &Rule| {
        // A curve that is set off has no effect, whatever its exponent.
        if *feature == "Gamma" && camera.value("GammaEnable").is_some_and(|on| is_same(&on, "false")) {
            return None;
        }
        camera.value(feature).filter(|found| !is_same(found, right))
    };
    let refused = |feature: &str, found, why, right| {
        Err(CameraError::Refused { feature: feature.to_owned(), found, why, right })
    };
    let mut set = Vec::new();
    for rule in RULES.iter().filter(|rule| rule.2 == Action::Refuse) {
        let Some(found) = other(camera, rule) else { continue };
        if rule.3 != SHUTTER || !accepts_rolling_shutter {
            return refused(rule.0, found, rule.3, rule.1);
        }
        set.push(format!("{} is {found}, as accepted: {SHUTTER}; measure it at rest", rule.0));
    }
    for rule in RULES.iter().filter(|rule| rule.2 == Action::Set) {
        let Some(found) = other(camera, rule) else { continue };
        if restore.set(camera, rule.0, rule.1).is_err() {
            return refused(rule.0, found, rule.3, rule.1);
        }
        set.push(format!("{} set from {found} to {}: {}; restored at the end", rule.0, rule.1, rule.3));
    }
    Ok(set)
}

#[cfg(test)]
mod tests {
    use super::super::features::Stated;
    use super::*;

    #[test]
    fn what_alters_grey_values_is_set_off_and_restored_in_reverse() {
        let before = [
            ("ExposureAuto", "Continuous"),
            ("Gain", "3"),
            ("Gamma", "0.45"),
            ("GammaEnable", "true"),
            ("LUTEnable", "false"),
            ("BinningHorizontal", "X1"),
            ("ReverseX", "false"),
        ];
        let mut camera = Stated::of(&before);
        let mut restore = Restore::default();
        let set = guard(&mut camera, false, &mut restore).unwrap();
        assert_eq!(set.len(), 2, "{set:?}");
        assert!(set[1].contains("GammaEnable set from true to false"), "{set:?}");
        assert_eq!(camera.values["ExposureAuto"], "Off");
        assert_eq!(camera.values["Gamma"], "0.45", "a curve that is off has no exponent");
        assert!(restore.set(&mut camera, "Gain", "6").unwrap());
        assert!(!restore.set(&mut camera, "Gain", "6.0").unwrap(), "the same value is not written");
        camera.written.clear();
        assert!(restore.restore(&mut camera).is_empty());
        assert_eq!(camera.values, Stated::of(&before).values);
        let order: Vec<&str> = camera.written.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(order, ["Gain", "GammaEnable", "ExposureAuto"]);
    }

    #[test]
    fn an_exponent_without_a_switch_is_set_to_one() {
        let mut camera = Stated::of(&[("Gamma", "0.7")]);
        guard(&mut camera, false, &mut Restore::default()).unwrap();
        assert_eq!(camera.values["Gamma"], "1");
    }

    #[test]
    fn what_changes_the_geometry_or_cannot_be_set_is_refused_by_name() {
        for (feature, value) in [
            ("ReverseY", "true"),
            ("BinningVertical", "2"),
            ("DecimationHorizontal", "X2"),
            ("TestPattern", "GreyHorizontalRamp"),
            ("SensorShutterMode", "Rolling"),
        ] {
            let mut camera = Stated::of(&[("GainAuto", "Once"), (feature, value)]);
            let why = guard(&mut camera, false, &mut Restore::default()).unwrap_err().to_string();
            assert!(why.starts_with(&format!("{feature} is {value}: ")), "{why}");
            assert!(camera.written.is_empty(), "nothing is set on a camera that is refused");
        }
        let mut camera = Stated::of(&[("LUTEnable", "true")]);
        camera.fixed.push("LUTEnable".to_owned());
        let why = guard(&mut camera, false, &mut Restore::default()).unwrap_err().to_string();
        assert_eq!(why, format!("LUTEnable is true: {CURVE}; set it to false"));
    }

    #[test]
    fn a_rolling_shutter_that_is_accepted_stays_and_is_stated() {
        let mut camera = Stated::of(&[("SensorShutterMode", "Rolling"), ("ReverseX", "false")]);
        let words = guard(&mut camera, true, &mut Restore::default()).unwrap();
        assert_eq!(words.len(), 1, "{words:?}");
        assert!(words[0].starts_with("SensorShutterMode is Rolling, as accepted"), "{words:?}");
        assert!(camera.written.is_empty());
        camera.values.insert("ReverseX".to_owned(), "true".to_owned());
        assert!(guard(&mut camera, true, &mut Restore::default()).is_err(), "nothing else is accepted");
    }

    #[test]
    fn a_feature_that_comes_back_altered_keeps_its_first_value() {
        let (mut camera, mut restore) = (Stated::of(&[("Gain", "3")]), Restore::default());
        restore.set(&mut camera, "Gain", "6").unwrap();
        // the camera was off: it has its default
        camera.values.insert("Gain".to_owned(), "0".to_owned());
        restore.set(&mut camera, "Gain", "6").unwrap();
        restore.restore(&mut camera);
        assert_eq!(camera.values["Gain"], "3");
        let why = restore.set(&mut camera, "ExposureTime", "5").unwrap_err().to_string();
        assert!(why.contains("ExposureTime cannot be set to 5"), "{why}");
    }
}
