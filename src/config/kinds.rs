//! The kinds of files that a user writes, with their JSON Schemas: config files in TOML, and the
//! rows of tables in CSV.
//!
//! Out: [`CONFIGS`] and [`TABLES`]. A new config file or table is a line of them; its name is then
//! known to `schema NAME`, to the reference and to the refusals, which name the file that a key
//! belongs to.

use schemars::{Schema, schema_for};
use serde_json::{Value, json};

use crate::gauge::calibration::Conditions;
use crate::identification::IdentificationConfig;
use crate::job::Job;
use crate::nc::NcSettings;
use crate::part_offsets::OffsetState;
use crate::render::flank::FlankScene;
use crate::render::insert::InsertSettings;
use crate::render::optics::lens_file::LensFile;
use crate::studies::calibration::CalibrationPlan;
use crate::studies::deflection::DeflectionConfig;
use crate::studies::factor::FactorConfig;
use crate::studies::machine::MachineStudyConfig;
use crate::studies::optimize::OptimizeConfig;
use crate::studies::reproduce_003::Inputs;
use crate::tool::{OutlineFile, ToolFile};

/// A kind of file.
pub(crate) struct FileKind {
    /// Name of its schema: `schema NAME`, and the file `NAME.schema.json`.
    pub name: &'static str,
    /// Which file it is and which command reads it.
    pub title: &'static str,
    /// Makes its schema.
    pub schema: fn() -> Schema,
}

/// Config files, jobs first.
pub(crate) const CONFIGS: [FileKind; 16] = [
    FileKind { name: "job", title: "A job (`run`, `render`, most studies)", schema: || schema_for!(Job) },
    FileKind {
        name: "calibration",
        title: "A calibration (`calibrate`, `study uncertainty`)",
        schema: || schema_for!(CalibrationPlan),
    },
    FileKind {
        name: "conditions",
        title: "Conditions of a part (`measure --conditions`)",
        schema: || schema_for!(Conditions),
    },
    FileKind {
        name: "lens",
        title: "A lens (`[optics] lens_file`, `calibrate --lens`)",
        schema: || schema_for!(LensFile),
    },
    FileKind { name: "machine", title: "A machine (`nc --machine`)", schema: || schema_for!(NcSettings) },
    FileKind {
        name: "offsets",
        title: "The offsets between two parts (`measure --offsets`, `nc --state`)",
        schema: || schema_for!(OffsetState),
    },
    FileKind {
        name: "optimize",
        title: "A choice of cutting data (`optimize`)",
        schema: || schema_for!(OptimizeConfig),
    },
    FileKind {
        name: "factor",
        title: "A study of single factors (`study factor`)",
        schema: || schema_for!(FactorConfig),
    },
    FileKind {
        name: "beam",
        title: "A held shaft (`study deflection`)",
        schema: || schema_for!(DeflectionConfig),
    },
    FileKind {
        name: "machine_errors",
        title: "A lathe's 21 errors (`study machine`)",
        schema: || schema_for!(MachineStudyConfig),
    },
    FileKind {
        name: "machine_identification",
        title: "A lathe whose errors are identified (`calibrate machine`)",
        schema: || schema_for!(IdentificationConfig),
    },
    FileKind {
        name: "reproduce_003",
        title: "A paper's inputs (`reproduce 003 --inputs`)",
        schema: || schema_for!(Inputs),
    },
    FileKind {
        name: "tool",
        title: "A turning tool (`tool nose --tool`, `tool compensate --tool`)",
        schema: || schema_for!(ToolFile),
    },
    FileKind {
        name: "flank",
        title: "A front-lit flank (`tool render-flank`)",
        schema: || schema_for!(FlankScene),
    },
    FileKind {
        name: "insert",
        title: "A back-lit insert (`tool render`)",
        schema: || schema_for!(InsertSettings),
    },
    FileKind {
        name: "outline",
        title: "A part's outline (`tool compensate --part`)",
        schema: || schema_for!(OutlineFile),
    },
];

/// Tables in CSV: the schema is that of a row, by the names of the columns.
pub(crate) const TABLES: [FileKind; 8] = [
    FileKind { name: "frames", title: "frames.csv beside frames (`measure`)", schema: frames },
    FileKind { name: "contour", title: "A contour (`[shaft] contour_file`)", schema: contour },
    FileKind {
        name: "edge",
        title: "An edge-spread function (`--esf FILE.csv`, `[optics.esf.measured] file`)",
        schema: edge,
    },
    FileKind { name: "forces", title: "Measured forces (`study factor --forces`)", schema: forces },
    FileKind {
        name: "error_table",
        title: "An error of a machine's axis (`[machine.errors.exz.table] file`)",
        schema: error_table,
    },
    FileKind {
        name: "machine_readings",
        title: "Readings of a machine (`[[readings]] file` of `calibrate machine`)",
        schema: machine_readings,
    },
    FileKind {
        name: "correlation",
        title: "Readings of two gauges (`study correlation`)",
        schema: correlation,
    },
    FileKind { name: "rings", title: "cmm.csv: sizes of rings (`study washers`)", schema: rings },
];

/// A column: its name, its type, whether every row needs it, its meaning.
type Column = (&'static str, &'static str, bool, &'static str);

/// The schema of a row with these columns.
fn row(title: &str, columns: &[Column]) -> Schema {
    let properties: serde_json::Map<String, Value> = columns
        .iter()
        .map(|(name, kind, _, meaning)| ((*name).to_owned(), json!({ "type": kind, "description": meaning })))
        .collect();
    let required: Vec<&str> = columns.iter().filter(|column| column.2).map(|column| column.0).collect();
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "properties": properties,
        "required": required,
    });
    Schema::try_from(schema).unwrap_or_default()
}

fn frames() -> Schema {
    row(
        "A row of frames.csv",
        &[
            ("frame", "string", true, "Name of the image, with or without its extension."),
            ("t_ns", "integer", false, "Start of the exposure, ns."),
            ("z_mm", "number", false, "Machine z of the central column, mm."),
            ("angle_deg", "number", false, "Spindle angle, degrees."),
            ("exposure_us", "number", false, "Exposure, µs."),
            ("bit_depth", "integer", false, "Bits of a grey value."),
            ("um_per_px", "number", false, "Nominal scale, µm a pixel."),
            ("encoder_count", "integer", false, "Count of the spindle's encoder, in place of angle_deg."),
            ("index", "integer", false, "Count at the encoder's last index pulse."),
            ("stop", "integer", false, "Number of the stop of a scan program, from 1."),
        ],
    )
}

fn contour() -> Schema {
    row(
        "A row of a contour",
        &[
            ("z_mm", "number", true, "Place of the corner, mm; two rows at one z make a shoulder."),
            ("diameter_mm", "number", true, "Diameter there, mm."),
            ("chamfer_mm", "number", false, "Length cut off either line at this corner, mm."),
            ("radius_mm", "number", false, "Radius of the arc at this corner, mm."),
        ],
    )
}

fn edge() -> Schema {
    row(
        "A row of an edge-spread function",
        &[
            ("distance_um", "number", true, "Distance from the geometric edge into the light, µm, rising."),
            ("light", "number", true, "Light there: 0 in the shadow, 1 in the bright field."),
        ],
    )
}

fn correlation() -> Schema {
    row(
        "A row of readings of two gauges",
        &[
            ("part", "string", true, "Name of the part."),
            ("d_mm", "number", true, "Diameter by this gauge, mm."),
            ("expanded_u_mm", "number", false, "Its U (k = 2), mm."),
            ("reference_mm", "number", true, "Diameter by the other gauge, mm."),
            ("reference_expanded_u_mm", "number", false, "Its U (k = 2), mm."),
        ],
    )
}

fn forces() -> Schema {
    row(
        "A row of measured forces",
        &[
            ("depth_mm", "number", true, "Depth of cut, mm, above 0."),
            ("speed_m_per_min", "number", true, "Cutting speed, m/min, above 0."),
            ("feed_mm_per_rev", "number", true, "Feed, mm a revolution, above 0."),
            ("force_n", "number", true, "Force, N, above 0."),
        ],
    )
}

fn error_table() -> Schema {
    let angular = "As the column in um, µrad: of an error about an axis, in its place.";
    row(
        "A row of an error's table",
        &[
            (
                "position_mm",
                "number",
                false,
                "Position of the slide, mm, ascending; every row of a slide has it.",
            ),
            ("angle_deg", "number", false, "Angle of the spindle, degrees, in place of a position."),
            ("value_um", "number", false, "Error along an axis where the position grew, µm."),
            ("value_urad", "number", false, angular),
            (
                "backward_um",
                "number",
                false,
                "The same where the position fell, where it was measured apart.",
            ),
            ("backward_urad", "number", false, angular),
        ],
    )
}

fn machine_readings() -> Schema {
    row(
        "A row of a machine's readings, in the order in which they were read",
        &[
            ("axis", "string", true, "Slide that was moved: X or Z."),
            (
                "position_mm",
                "number",
                true,
                "Its position, mm; of a midline the place on the part from the chuck's face.",
            ),
            ("direction", "string", true, "From which side the position was reached: forward or backward."),
            ("run", "integer", true, "Run, from 1."),
            (
                "error",
                "string",
                true,
                "What was read: an error by its name of ISO 230-1, radius, height, midline or slope.",
            ),
            ("value", "number", true, "Deviation, in the unit of the row."),
            ("unit", "string", true, "nm, um or mm of lengths; urad, mrad or arcsec of angles."),
            ("angle_deg", "number", false, "Spindle angle of a midline, degrees; with φ also φ + 180."),
            ("setup", "string", false, "Of a straightedge: normal or reversed."),
        ],
    )
}

fn rings() -> Schema {
    row(
        "A row of cmm.csv",
        &[
            ("part", "integer", true, "Number of the part, the name of its image."),
            ("outer_diameter_mm", "number", true, "Outer diameter, mm."),
            ("inner_diameter_mm", "number", true, "Inner diameter, mm."),
        ],
    )
}

/// The schema of a kind as a file's text.
pub(crate) fn schema_text(kind: &FileKind) -> String {
    serde_json::to_string_pretty(&(kind.schema)()).unwrap_or_default() + "\n"
}

/// The kind of a name.
pub(crate) fn find(name: &str) -> Option<&'static FileKind> {
    const CONFIGS_OF: &[FileKind] = &CONFIGS;
    const TABLES_OF: &[FileKind] = &TABLES;
    CONFIGS_OF.iter().chain(TABLES_OF).find(|kind| kind.name == name)
}

/// All names, configs first.
pub(crate) fn names() -> Vec<&'static str> {
    CONFIGS.iter().chain(&TABLES).map(|kind| kind.name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_schema_of_its_own_and_is_found_by_its_name() {
        let mut titles: Vec<String> = Vec::new();
        for name in names() {
            let kind = find(name).expect("a kind of this name");
            let text = schema_text(kind);
            let schema: Value = serde_json::from_str(&text).expect("JSON");
            assert!(schema["properties"].as_object().is_some_and(|keys| keys.len() >= 2), "{name}");
            titles.push(schema["title"].as_str().expect("a title").to_owned());
        }
        let count = titles.len();
        titles.sort();
        titles.dedup();
        assert_eq!(titles.len(), count, "{titles:?}");
        assert!(find("none").is_none());
    }
}
