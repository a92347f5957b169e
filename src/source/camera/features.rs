//! Features of a camera by their names, as text.

use viva_genicam::genapi::{FeatureValue, RegisterIo};
use viva_genicam::{Camera, GigeRegisterIo};

/// A camera under control.
pub(super) type Device = Camera<GigeRegisterIo>;

/// Access to features; values are text as GenICam's feature files have them.
pub(super) trait Features {
    /// The value; `None` where there is no such feature, or it has no value now.
    fn value(&self, name: &str) -> Option<String>;

    /// Sets a feature.
    ///
    /// # Errors
    /// The refusal of the camera or of its description, as text.
    fn set(&mut self, name: &str, value: &str) -> Result<(), String>;

    /// Entries of an enumeration that can be set now.
    fn entries(&self, name: &str) -> Vec<String>;

    /// The value as a number.
    fn number(&self, name: &str) -> Option<f64> {
        self.value(name)?.trim().parse().ok()
    }
}

impl<T: RegisterIo> Features for Camera<T> {
    fn value(&self, name: &str) -> Option<String> {
        self.nodemap().node(name)?;
        let state = self.feature_state(name).ok()?;
        match state.value {
            FeatureValue::Integer(value) => Some(value.to_string()),
            FeatureValue::Float(value) => Some(value.to_string()),
            FeatureValue::Boolean(value) => Some(value.to_string()),
            FeatureValue::Enum(text) | FeatureValue::String(text) => Some(text),
            _ => None,
        }
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        Self::set(self, name, value).map_err(|error| error.to_string())
    }

    fn entries(&self, name: &str) -> Vec<String> {
        let state = self.nodemap().node(name).and_then(|_| self.feature_state(name).ok());
        state.and_then(|state| state.enum_entries).unwrap_or_default()
    }
}

/// The name of the exposure time, µs: `ExposureTimeAbs` before SFNC 1.5.
pub(super) fn exposure_name(camera: &impl Features) -> &'static str {
    let names = ["ExposureTime", "ExposureTimeAbs"];
    names.into_iter().find(|name| camera.value(name).is_some()).unwrap_or(names[0])
}

/// Features in memory, for tests.
#[cfg(test)]
#[derive(Clone, Debug, Default)]
pub(super) struct Stated {
    /// Names with values.
    pub values: std::collections::BTreeMap<String, String>,
    /// Names that cannot be written.
    pub fixed: Vec<String>,
    /// What was written, in order.
    pub written: Vec<(String, String)>,
}

#[cfg(test)]
impl Stated {
    /// Features with these values.
    pub(super) fn of(values: &[(&str, &str)]) -> Self {
        let owned = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        Self { values: values.iter().map(owned).collect(), ..Self::default() }
    }
}

#[cfg(test)]
impl Features for Stated {
    fn value(&self, name: &str) -> Option<String> {
        self.values.get(name).cloned()
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        if self.fixed.iter().any(|fixed| fixed == name) || !self.values.contains_key(name) {
            return Err("not writable".to_owned());
        }
        self.values.insert(name.to_owned(), value.to_owned());
        self.written.push((name.to_owned(), value.to_owned()));
        Ok(())
    }

    fn entries(&self, _name: &str) -> Vec<String> {
        Vec::new()
    }
}
