//! A measured sensor: a file of EMVA 1288 results, in the XML that implementations of the standard
//! exchange (that of the reference implementation, PyPI `emva1288`, `Results1288.xml`), or the same
//! names and values in YAML.
//!
//! | name | unit | key of `[sensor]` |
//! |---|---|---|
//! | `K`, or `inverse_K` | DN/e⁻, e⁻/DN | `electrons_per_count` |
//! | `QE` | % | `quantum_efficiency` |
//! | `sigma_d` | e⁻ | `read_noise_e` |
//! | `u_e_sat` | e⁻ | `full_well_e` |
//! | `u_I_mean`, or `u_I_var` | e⁻/s | `dark_current.electrons_per_s` |
//! | `DSNU1288`, `_row`, `_col`, `_pixel` | e⁻ | `dsnu_e`, `spatial.dsnu_row_e`, `.dsnu_column_e` |
//! | `PRNU1288`, `_row`, `_col`, `_pixel` | % | `prnu_rel`, `spatial.prnu_row_rel`, `.prnu_column_rel` |
//!
//! DN are counts of `sensor.format`. Not in these files and left as the table has them: black
//! level, hot pixels, row noise, cross-talk, and the shape of the non-linearity, of which `LE_min`
//! and `LE_max` state the extremes only.

use std::collections::BTreeMap;

use super::dark_current::DarkCurrent;
use super::data_sheet::{Sensor, SensorFile};
use super::spatial::SpatialShares;
use crate::setting::SettingError;

/// The key in a config.
const KEY: &str = "sensor.data_sheet";

/// Names that are read.
const NAMES: [&str; 15] = [
    "K",
    "inverse_K",
    "QE",
    "sigma_d",
    "u_e_sat",
    "u_I_mean",
    "u_I_var",
    "DSNU1288",
    "DSNU1288_row",
    "DSNU1288_col",
    "DSNU1288_pixel",
    "PRNU1288",
    "PRNU1288_row",
    "PRNU1288_col",
    "PRNU1288_pixel",
];

/// Figures of a measured sensor by their names in the standard's results.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EmvaResults {
    figures: BTreeMap<&'static str, f64>,
}

impl EmvaResults {
    /// Reads the text of a file: XML where it begins with `<`, else YAML.
    ///
    /// # Errors
    /// Text that is neither, a figure that is no number or negative, a file without a system gain.
    pub(crate) fn read(text: &str) -> Result<Self, SettingError> {
        let text = text.trim_start_matches('\u{feff}').trim_start();
        let leaves = if text.starts_with('<') { xml_leaves(text)? } else { yaml_leaves(text) };
        let mut figures = BTreeMap::new();
        for (path, value) in leaves {
            let Some(name) = figure_name(&path) else { continue };
            let number: f64 =
                value.parse().map_err(|_| refused(format!("{name} is no number: {value:?}")))?;
            // What an implementation could not find it writes as nan.
            if number.is_nan() {
                continue;
            }
            if number < 0.0 || number.is_infinite() {
                return Err(refused(format!("{name} is {number}: must be a number from 0 up")));
            }
            figures.insert(name, number);
        }
        let found = Self { figures };
        if found.electrons_per_count().is_none() {
            let why = "has no system gain: EMVA 1288 results name it K (DN/e-) or inverse_K";
            return Err(refused(why.to_owned()));
        }
        Ok(found)
    }

    fn figure(&self, name: &str) -> Option<f64> {
        self.figures.get(name).copied()
    }

    fn electrons_per_count(&self) -> Option<f64> {
        let gain = self.figure("K").filter(|k| *k > 0.0);
        gain.map(f64::recip).or_else(|| self.figure("inverse_K").filter(|k| *k > 0.0))
    }

    /// Total, row and column share of a non-uniformity; the total of its parts where the pixels'
    /// share is stated, since each estimate of a part has noise of its own.
    fn non_uniformity(&self, name: &str) -> Option<[f64; 3]> {
        let part = |which: &str| self.figure(&format!("{name}_{which}"));
        let (row, column) = (part("row").unwrap_or(0.0), part("col").unwrap_or(0.0));
        let total = match part("pixel") {
            Some(pixel) => row.hypot(column).hypot(pixel),
            None => self.figure(name)?,
        };
        Some([total, row, column])
    }

    /// The sensor of these figures, with the keys of a `[sensor]` table over them.
    pub(crate) fn below(&self, own: SensorFile) -> Sensor {
        let sensor = self.sensor(&own.base());
        Sensor { data_sheet: None, ..own.on(&sensor) }
    }

    /// The sensor with these figures; what a file does not state stays as `base` has it.
    fn sensor(&self, base: &Sensor) -> Sensor {
        let dsnu = self.non_uniformity("DSNU1288");
        let prnu = self.non_uniformity("PRNU1288").map(|parts| parts.map(|percent| percent / 100.0));
        let [dsnu_e, dsnu_row_e, dsnu_column_e] = dsnu.unwrap_or([base.dsnu_e, 0.0, 0.0]);
        let [prnu_rel, prnu_row_rel, prnu_column_rel] = prnu.unwrap_or([base.prnu_rel, 0.0, 0.0]);
        let shares = SpatialShares { dsnu_row_e, dsnu_column_e, prnu_row_rel, prnu_column_rel };
        let dark = self.figure("u_I_mean").or_else(|| self.figure("u_I_var"));
        let dark = dark
            .filter(|rate| *rate > 0.0)
            .map(|electrons_per_s| DarkCurrent { electrons_per_s, ..base.dark_current.unwrap_or_default() });
        Sensor {
            electrons_per_count: self.electrons_per_count().unwrap_or(base.electrons_per_count),
            quantum_efficiency: self.figure("QE").map_or(base.quantum_efficiency, |percent| percent / 100.0),
            read_noise_e: self.figure("sigma_d").unwrap_or(base.read_noise_e),
            full_well_e: self.figure("u_e_sat").unwrap_or(base.full_well_e),
            dsnu_e,
            prnu_rel,
            dark_current: dark.or(base.dark_current),
            spatial: if shares.is_none() { base.spatial } else { Some(shares) },
            ..base.clone()
        }
    }
}

fn refused(why: String) -> SettingError {
    SettingError::at(KEY, why)
}

/// Which figure a leaf states: `…/K/value` or `…/K`.
fn figure_name(path: &[String]) -> Option<&'static str> {
    let last = path.last()?;
    let name = if last.eq_ignore_ascii_case("value") { path.get(path.len().checked_sub(2)?)? } else { last };
    NAMES.into_iter().find(|known| known == name)
}

/// Text of an element or key, with the names that lead to it.
type Leaf = (Vec<String>, String);

/// Elements of an XML file that hold text.
///
/// # Errors
/// Elements that do not nest.
fn xml_leaves(text: &str) -> Result<Vec<Leaf>, SettingError> {
    let (mut open, mut leaves): (Vec<String>, Vec<Leaf>) = (Vec::new(), Vec::new());
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        let (content, tag) = (rest[..at].trim(), &rest[at + 1..]);
        if !content.is_empty() && !open.is_empty() {
            leaves.push((open.clone(), content.to_owned()));
        }
        let end = if tag.starts_with("!--") { "-->" } else { ">" };
        let Some(close) = tag.find(end) else { return Err(broken(text, rest)) };
        let inner = &tag[..close];
        rest = &tag[close + end.len()..];
        if inner.starts_with(['?', '!']) || inner.ends_with('/') {
            continue;
        }
        match inner.strip_prefix('/') {
            Some(name) if open.last().is_some_and(|last| last == name.trim()) => drop(open.pop()),
            Some(_) => return Err(broken(text, rest)),
            None => open.push(inner.split_whitespace().next().unwrap_or_default().to_owned()),
        }
    }
    if open.is_empty() { Ok(leaves) } else { Err(broken(text, "")) }
}

/// That the elements of a file do not nest, with the line up to which it was read.
fn broken(text: &str, rest: &str) -> SettingError {
    let line = text[..text.len() - rest.len()].lines().count().max(1);
    refused(format!("is no XML of EMVA 1288 results: its elements do not close at line {line}"))
}

/// Keys of a YAML file that have a scalar: mappings by indentation. Lists and block scalars hold no
/// figure and are passed over.
fn yaml_leaves(text: &str) -> Vec<Leaf> {
    let (mut open, mut leaves): (Vec<(usize, String)>, Vec<Leaf>) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let content = line.trim_start();
        if content.is_empty() || content.starts_with(['#', '-']) {
            continue;
        }
        let Some((key, value)) = content.split_once(':') else { continue };
        let indent = line.len() - content.len();
        open.retain(|(at, _)| *at < indent);
        open.push((indent, unquoted(key).to_owned()));
        let value = unquoted(value.split(" #").next().unwrap_or_default());
        if !value.is_empty() {
            leaves.push((open.iter().map(|(_, name)| name.clone()).collect(), value.to_owned()));
        }
    }
    leaves
}

fn unquoted(text: &str) -> &str {
    text.trim().trim_matches(['"', '\''])
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = "<?xml version='1.0'?>\n<results>\n<!-- of a camera <K> -->\n<sensitivity>\n\
        <K><Short>Overall system gain</Short><Value>0.4</Value><Unit>$DN/e^-$</Unit></K>\n\
        <QE><value>61.5</value></QE><sigma_d><Value>3.1</Value></sigma_d>\n\
        <u_e_sat><Value>9000.0</Value></u_e_sat><R><Value>0.2</Value></R></sensitivity>\n\
        <spatial><DSNU1288><Value>7.1</Value></DSNU1288><DSNU1288_row><Value>2.0</Value></DSNU1288_row>\n\
        <DSNU1288_col><Value>3.0</Value></DSNU1288_col><DSNU1288_pixel><Value>6.0</Value></DSNU1288_pixel>\n\
        <PRNU1288><Value>1.2</Value></PRNU1288></spatial>\n\
        <dark_current><u_I_mean><Value>nan</Value></u_I_mean><u_I_var><Value>12.5</Value></u_I_var>\n\
        </dark_current><info><Comment/></info></results>\n";

    const YAML: &str = "# measured\n---\nsensitivity:\n  K:\n    value: 0.4  # DN/e-\n    unit: 'DN/e^-'\n\
        \x20 QE: {value: x}\n  sigma_d:\n    value: '3.1'\nspatial:\n  levels:\n  - 1.0\n  - 2.0\n\
        \x20 DSNU1288: 7.1\n  PRNU1288:\n    value: 1.2\n";

    #[test]
    fn figures_of_the_xml_become_those_of_the_sensor() {
        let sensor = EmvaResults::read(XML).unwrap().sensor(&Sensor::default());
        assert_eq!((sensor.electrons_per_count, sensor.quantum_efficiency), (2.5, 0.615));
        assert_eq!((sensor.read_noise_e, sensor.full_well_e), (3.1, 9000.0));
        // √(2² + 3² + 6²), not the 7.1 stated apart.
        assert!((sensor.dsnu_e - 7.0).abs() < 1e-12 && (sensor.prnu_rel - 0.012).abs() < 1e-15);
        let shares = sensor.spatial.unwrap();
        assert_eq!((shares.dsnu_row_e, shares.dsnu_column_e, shares.prnu_row_rel), (2.0, 3.0, 0.0));
        assert_eq!(sensor.dark_current.unwrap().electrons_per_s, 12.5);
        assert_eq!(sensor.black_level_counts, Sensor::default().black_level_counts);
        sensor.check().unwrap();
    }

    #[test]
    fn the_same_names_in_yaml_are_read() {
        let text = YAML.replace("  QE: {value: x}\n", "");
        let sensor = EmvaResults::read(&text).unwrap().sensor(&Sensor::default());
        assert_eq!((sensor.electrons_per_count, sensor.read_noise_e), (2.5, 3.1));
        assert_eq!((sensor.dsnu_e, sensor.spatial), (7.1, None));
        let flow = EmvaResults::read(YAML).unwrap_err().to_string();
        assert!(flow.contains("QE is no number"), "{flow}");
    }

    #[test]
    fn what_is_no_file_of_results_is_refused_with_the_reason() {
        let refused = |text: &str| EmvaResults::read(text).unwrap_err().to_string();
        assert!(refused("<results><QE><Value>60</Value></QE></results>").contains("no system gain"));
        assert!(refused("<results><K><Value>0.4</K></results>").contains("do not close at line 1"));
        assert!(refused("<results>\n<K>").contains("line 2"));
        assert!(refused("K: -0.4").contains("must be a number from 0 up"));
        assert!(refused("").contains("no system gain"));
    }
}
