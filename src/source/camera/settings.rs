//! What a camera is opened with.

use std::str::FromStr;

/// What becomes of a camera that is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WhenGone {
    /// It ends the source with the reason: a series of measurements is cut short.
    Ends,
    /// It is looked for until it is back.
    Returns,
}

/// A feature by its name (SFNC or the maker's) and the value that it is set to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FeatureSetting {
    /// Name.
    pub name: String,
    /// Value, as GenICam's feature files have it.
    pub value: String,
}

impl FromStr for FeatureSetting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let is_name =
            |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        match text.split_once('=').map(|(name, value)| (name.trim(), value.trim())) {
            Some((name, value)) if is_name(name) && !value.is_empty() => {
                Ok(Self { name: name.to_owned(), value: value.to_owned() })
            }
            _ => Err("a feature and its value are needed, for instance TriggerMode=On".to_owned()),
        }
    }
}

/// What a camera is opened with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraSettings {
    /// Exposure time to set, µs; `None` leaves the camera's.
    pub exposure_us: Option<f64>,
    /// Gain to set, dB; `None` leaves the camera's.
    pub gain_db: Option<f64>,
    /// Features to set, in this order, before anything else is.
    pub features: Vec<FeatureSetting>,
    /// Whether a shutter that exposes row after row is taken as it is: of a part at rest.
    pub accepts_rolling_shutter: bool,
    /// What becomes of a camera that is gone.
    pub when_gone: WhenGone,
}

impl CameraSettings {
    /// A camera as it is set.
    pub(crate) fn unchanged(when_gone: WhenGone) -> Self {
        let (exposure_us, gain_db, features) = (None, None, Vec::new());
        Self { exposure_us, gain_db, features, accepts_rolling_shutter: false, when_gone }
    }

    /// The packet size that is asked for, bytes; `None` where the interface decides.
    pub(super) fn packet_bytes(&self) -> Option<&str> {
        let mut sizes = self.features.iter().rev().filter(|feature| feature.name == PACKET_SIZE);
        Some(sizes.next()?.value.as_str())
    }
}

/// Bytes of a stream packet (SFNC 2.7): set when the stream is opened, by a test packet.
pub(super) const PACKET_SIZE: &str = "GevSCPSPacketSize";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_has_a_name_and_a_value() {
        let of = |text: &str| text.parse::<FeatureSetting>().map(|f| (f.name, f.value));
        assert_eq!(of("TriggerMode = On"), Ok(("TriggerMode".to_owned(), "On".to_owned())));
        for wrong in ["", "Width", "Width=", "=5", "Wi dth=5"] {
            assert!(of(wrong).unwrap_err().contains("TriggerMode=On"), "{wrong}");
        }
        let mut settings = CameraSettings::unchanged(WhenGone::Ends);
        assert_eq!(settings.packet_bytes(), None);
        settings.features = vec!["GevSCPSPacketSize=1500".parse().unwrap()];
        assert_eq!(settings.packet_bytes(), Some("1500"));
    }
}
