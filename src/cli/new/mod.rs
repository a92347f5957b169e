//! `shadowgauge new`: a commented start for a file of one's own.
//!
//! In: what the file is for. Out: a TOML text with every key that a first try needs, its unit,
//! range and what else could stand there. Each is read and checked by the code of the command that
//! takes it. A new kind is a file here and a variant of [`Kind`].

use std::path::PathBuf;

use super::failure::{CommandResult, Failure, Outcome};
use crate::files::OutputFile;

/// What a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// A plain pin to be drawn (`render`).
    Pin,
    /// A shaft to be turned in passes (`run`), or drawn.
    Shaft,
    /// A stepped shaft with a taper and a shoulder, to be drawn (`render`).
    Stepped,
    /// A thin wire to be drawn (`render`).
    Wire,
    /// A calibration on master pins (`calibrate`).
    Calibrate,
    /// A machine that programs are written for (`nc --machine`).
    Machine,
}

impl Kind {
    fn text(self) -> &'static str {
        match self {
            Self::Pin => include_str!("pin.toml"),
            Self::Shaft => include_str!("shaft.toml"),
            Self::Stepped => include_str!("stepped.toml"),
            Self::Wire => include_str!("wire.toml"),
            Self::Calibrate => include_str!("calibrate.toml"),
            Self::Machine => include_str!("machine.toml"),
        }
    }
}

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub(crate) struct NewArgs {
    /// What the file is for.
    #[arg(value_enum)]
    kind: Kind,
    /// Write into this file, which must not exist yet, instead of to stdout.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Prints or writes the start.
///
/// # Errors
/// Exit 2 for a file that exists, 3 for one that cannot be written.
pub(crate) fn run(args: &NewArgs) -> CommandResult {
    let text = args.kind.text();
    match &args.out {
        Some(path) if path.is_file() => {
            let name = path.display();
            return Err(Failure::refuse(format!("--out {name}: exists already; name a file that does not")));
        }
        Some(path) => OutputFile::claim(path, [])?.write(text.as_bytes())?,
        None => say!("{text}"),
    }
    Ok(Outcome::Done)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use clap::ValueEnum as _;

    use super::Kind;
    use crate::cli::calibration_plan;
    use crate::cli::input_output::ConfigText;
    use crate::config::{self, kinds};
    use crate::nc::NcSettings;

    /// A start as a file of a new folder.
    fn file(kind: Kind) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("my.toml");
        std::fs::write(&path, kind.text()).expect("written");
        (folder, path)
    }

    #[test]
    fn starts_of_parts_are_drawn() {
        for kind in [Kind::Pin, Kind::Shaft, Kind::Stepped, Kind::Wire] {
            let (_folder, path) = file(kind);
            let job = config::load_scene(&path).unwrap_or_else(|e| panic!("{kind:?}: {e}"));
            let plan = job.loop_job().scan_plan();
            assert!(!plan.field_z_mm.is_empty() && !plan.angle_deg.is_empty(), "{kind:?}");
        }
    }

    #[test]
    fn the_start_of_a_shaft_is_a_run() {
        let (_folder, path) = file(Kind::Shaft);
        let job = config::load(&path).expect("a job");
        job.check_coverage().and_then(|()| job.check_control()).expect("a run");
        assert_eq!(job.cautions(), Vec::<String>::new());
    }

    #[test]
    fn the_start_of_a_calibration_is_one() {
        let text = ConfigText { text: Kind::Calibrate.text().to_owned(), name: "my.toml".to_owned() };
        assert!(calibration_plan::is_plan(&text.text));
        let loaded = calibration_plan::of_text(text, PathBuf::new()).expect("a plan");
        loaded.plan.validate().expect("a valid plan");
    }

    #[test]
    fn the_start_of_a_machine_is_one() {
        let machine: NcSettings = config::parse_as(Kind::Machine.text(), "my.toml").expect("a machine");
        machine.validate().expect("a valid machine");
    }

    #[test]
    fn every_start_names_the_schema_of_its_file() {
        for kind in Kind::value_variants() {
            let first = kind.text().lines().next().unwrap_or_default();
            let name = first.strip_prefix("#:schema ./").and_then(|name| name.strip_suffix(".schema.json"));
            assert!(name.is_some_and(|name| kinds::find(name).is_some()), "{kind:?}: {first}");
            let how =
                format!("shadowgauge schema {} > {}", name.unwrap_or_default(), name.unwrap_or_default());
            assert!(kind.text().contains(&how), "{kind:?}: {how}");
            assert!(kind.text().ends_with('\n'), "{kind:?}");
        }
    }
}
