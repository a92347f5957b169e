//! A tolerance of a diameter, in tables and as text.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::criterion::SizeCriterion;
use super::judgement::Limits;

/// Diameter tolerance: lower and upper limit deviation from the nominal size (ISO 286-1). In files
/// a table of `nominal_mm`, `upper_mm` and `lower_mm`, or a text as on drawings: "25 h6", "Ø25
/// ±0.01", "25 +0.1/-0.2", "24.987..25".
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(with = "TableOrText")]
pub struct Tolerance {
    /// Nominal size, mm; the upper limit where limits alone are stated.
    pub nominal_mm: f64,
    /// Upper limit deviation (es), mm.
    pub upper_mm: f64,
    /// Lower limit deviation (ei), mm.
    pub lower_mm: f64,
    /// Which size the limits are for.
    #[serde(skip)]
    pub criterion: SizeCriterion,
}

impl Tolerance {
    /// Limits for the two-point sizes, by their deviations.
    pub fn new(nominal_mm: f64, upper_mm: f64, lower_mm: f64) -> Self {
        Self { nominal_mm, upper_mm, lower_mm, criterion: SizeCriterion::TwoPoint }
    }

    /// Lower and upper limit of size, mm.
    pub fn limits_mm(&self) -> (f64, f64) {
        (self.nominal_mm + self.lower_mm, self.nominal_mm + self.upper_mm)
    }

    /// Its limits for a `super::Judge`.
    pub fn limits(&self) -> Limits {
        let (lower_mm, upper_mm) = self.limits_mm();
        Limits::Tolerance { lower_mm, upper_mm }
    }
}

/// Limit deviations from a nominal size.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Table {
    /// Nominal size, mm.
    nominal_mm: f64,
    /// Upper limit deviation (es), mm.
    upper_mm: f64,
    /// Lower limit deviation (ei), mm.
    lower_mm: f64,
}

/// A tolerance in a file.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum TableOrText {
    /// Limit deviations from a nominal size.
    Table(Table),
    /// As on drawings: "25 h6", "Ø25 ±0.01", "25 +0.1/-0.2", "24.987..25".
    Text(String),
}

impl<'de> Deserialize<'de> for Tolerance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TableOrTextVisitor)
    }
}

struct TableOrTextVisitor;

impl<'de> Visitor<'de> for TableOrTextVisitor {
    type Value = Tolerance;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a tolerance: \"25 h6\", or nominal_mm, upper_mm and lower_mm")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Tolerance, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Tolerance, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Tolerance, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Tolerance, A::Error> {
        let table = Table::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Tolerance::new(table.nominal_mm, table.upper_mm, table.lower_mm))
    }
}
