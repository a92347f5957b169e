//! `docs/reference/files.md` against files that the program writes: the tables marked "(tested)".

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::Value;

use super::markdown::root;

/// A row of a table: a column, or a key with whether every document has it.
struct Entry {
    name: String,
    is_always: bool,
}

/// The tables marked "(tested)", by their headings.
fn tables() -> BTreeMap<String, Vec<Entry>> {
    let text = std::fs::read_to_string(root().join("docs/reference/files.md")).unwrap();
    let mut found: BTreeMap<String, Vec<Entry>> = BTreeMap::new();
    let mut heading = None;
    for line in text.lines() {
        if line.starts_with('#') {
            let title = line.trim_start_matches('#').trim();
            heading = title.strip_suffix(" (tested)").map(|name| name.replace('`', ""));
        }
        let (Some(heading), Some(row)) = (&heading, line.strip_prefix("| `")) else { continue };
        let (name, rest) = row.split_once('`').unwrap();
        let entry = Entry { name: name.to_owned(), is_always: !rest.starts_with(" | where it applies") };
        found.entry(heading.clone()).or_default().push(entry);
    }
    found
}

/// Paths of the values of a document: `a.b[].c`.
fn paths(value: &Value, path: String, found: &mut Vec<String>) {
    match value {
        Value::Object(table) if !table.is_empty() => {
            for (key, below) in table {
                paths(below, if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, found);
            }
        }
        Value::Array(items) if !items.is_empty() => {
            items.iter().for_each(|below| paths(below, format!("{path}[]"), found));
        }
        Value::Array(_) => found.push(format!("{path}[]")),
        _ => found.push(path),
    }
}

/// Whether `path` is `key` or lies below it.
fn is_of(path: &str, key: &str) -> bool {
    path.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// What of a document's keys the table lacks, and what the table has beyond them; `null` and empty
/// arrays stand for any keys below.
fn differences(name: &str, entries: &[Entry], document: &Value) -> Vec<String> {
    let mut found = Vec::new();
    paths(document, String::new(), &mut found);
    found.sort();
    found.dedup();
    let undocumented = found.iter().filter(|path| !entries.iter().any(|e| is_of(path, &e.name)));
    let undocumented = undocumented.map(|path| format!("{name}: {path} is not in files.md"));
    let missing = entries.iter().filter(|e| e.is_always && !found.iter().any(|path| is_of(path, &e.name)));
    let missing = missing.map(|e| format!("{name}: {} is in files.md, not in the document", e.name));
    undocumented.chain(missing).collect()
}

/// The folder in which the files are produced.
struct Work(tempfile::TempDir);

impl Work {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink(root().join("configs"), folder.path().join("configs")).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    /// Stdout of a command; exit code 1 is a verdict.
    fn run(&self, line: &str) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_shadowgauge"));
        let output = command.args(line.split(' ')).current_dir(self.0.path()).output().unwrap();
        let is_done = matches!(output.status.code(), Some(0 | 1));
        assert!(is_done, "{line}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.run(line)).unwrap()
    }

    fn file(&self, name: &str) -> Value {
        serde_json::from_str(&std::fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }

    /// The columns of a CSV file, behind its comments.
    fn columns(&self, name: &str) -> Vec<String> {
        let text = std::fs::read_to_string(self.path(name)).unwrap();
        let header = text.lines().find(|line| !line.starts_with('#')).unwrap();
        header.split(',').map(str::to_owned).collect()
    }
}

fn parquet_columns(path: &Path) -> Vec<String> {
    let reader = SerializedFileReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    schema.columns().iter().map(|column| column.name().to_owned()).collect()
}

/// Tables in CSV and Parquet: heading in files.md and columns produced.
fn produced_tables(work: &Work) -> Vec<(&'static str, Vec<String>)> {
    work.run("measure out/frames/frames --um-per-px file --edges edges.csv --csv diameters.csv");
    std::fs::write(work.path("esf.csv"), work.run("optics esf configs/head_telecentric_25.toml")).unwrap();
    let of_run = ["passes", "stations", "offsets", "axis", "truth_axis", "form", "part_form"];
    let names = [
        "passes.csv",
        "stations.csv",
        "offsets.csv",
        "axis.csv",
        "truth_axis.csv",
        "form.csv",
        "part_form.csv",
    ];
    let csv = of_run.iter().map(|name| work.columns(&format!("out/small/{name}.csv")));
    let mut found: Vec<_> = names.into_iter().zip(csv).collect();
    for name in ["diameters.parquet", "truth.parquet"] {
        found.push((name, parquet_columns(&work.path("out/small").join(name))));
    }
    let others = [
        ("frames.csv", "out/frames/frames.csv"),
        ("truth.csv", "out/frames/truth.csv"),
        ("edges.csv", "edges.csv"),
        ("diameters.csv", "diameters.csv"),
        ("esf.csv", "esf.csv"),
        ("deflection.csv", "out/line/deflection.csv"),
        ("axis.csv of study deflection", "out/line/axis.csv"),
        ("map.csv", "out/machine/map.csv"),
        ("budget.csv", "out/machine/budget.csv"),
        ("heads.csv", "out/machine/heads.csv"),
        ("form.csv of study machine", "out/machine/form.csv"),
        ("aliases.csv", "out/machine/aliases.csv"),
        ("readings.csv", "out/machine/readings.csv"),
        ("stability.csv", "out/stability/stability.csv"),
        ("factor.csv", "out/factor/factor.csv"),
        ("front.csv", "out/optimize/front.csv"),
        ("rows.csv", "out/rows/rows.csv"),
        ("left.csv of tool compensate", "out/nose/left.csv"),
        ("path.csv of tool compensate", "out/nose/path.csv"),
    ];
    found.extend(others.map(|(name, path)| (name, work.columns(path))));
    found
}

/// Documents in JSON: heading in files.md and the document.
fn produced_documents(work: &Work) -> Vec<(&'static str, Value)> {
    let measured = "measure out/frames/frames --calibration calibration.json --json --budget --tolerance";
    let run = "run configs/small_shaft.toml --out out/small --backend cpu --json";
    let calibrate = "calibrate configs/small_calibration.toml --out calibration.json --backend cpu --json";
    let compensate = "tool compensate --nose configs/tool/nose.json --tool configs/tool/tool.toml --part \
                      configs/tool/outline.toml --machine configs/tool/machine.toml --json --out out/nose";
    work.run("render configs/small_shaft.toml --out out/frames --frames 8 --backend cpu");
    work.run("reproduce 000 --no-frames --out out/rows");
    vec![
        ("run --json", work.json(run)),
        ("control.json", work.file("out/small/control.json")),
        ("timings.json", work.file("out/small/timings.json")),
        ("truth.json", work.file("out/frames/truth.json")),
        ("calibrate --json", work.json(calibrate)),
        ("calibration.json", work.file("out/small/calibration.json")),
        ("calibration.json", work.file("calibration.json")),
        ("measure --json", work.json(&format!("{measured} 11±0.05"))),
        ("turn of measure --turn --json", turn(work)),
        ("optics esf --json", work.json("optics esf configs/head_telecentric_25.toml --json")),
        ("doctor --json", work.json("doctor --json")),
        ("study stability --json", work.json("study stability --json --out out/stability")),
        (
            "study deflection --json",
            work.json("study deflection configs/small_shaft.toml --line --json --out out/line"),
        ),
        (
            "study machine --json",
            work.json("study machine configs/machine_001.toml --json --out out/machine"),
        ),
        (
            "study machine --at X,Z --json",
            work.json("study machine configs/machine_001.toml --at 50,20 --json"),
        ),
        ("study factor --json", work.json("study factor --json --out out/factor")),
        ("optimize --json", work.json("optimize configs/optimize_003.toml --json --out out/optimize")),
        ("tool compensate --json", work.json(compensate)),
    ]
}

/// The `turn` of a turn's document, under its own key.
fn turn(work: &Work) -> Value {
    let document = work.json("measure out/frames/frames --um-per-px file --turn --json");
    serde_json::json!({ "turn": document["turn"] })
}

#[test]
fn files_have_the_columns_and_keys_that_are_documented() {
    let work = Work::new();
    let tables = tables();
    let mut unused: Vec<&String> = tables.keys().collect();
    let mut bad = Vec::new();
    for (name, document) in produced_documents(&work) {
        unused.retain(|known| known.as_str() != name);
        bad.extend(differences(name, tables.get(name).unwrap_or(&Vec::new()), &document));
    }
    for (name, columns) in produced_tables(&work) {
        unused.retain(|known| known.as_str() != name);
        let documented: Vec<&str> = tables.get(name).into_iter().flatten().map(|e| e.name.as_str()).collect();
        if documented != columns {
            bad.push(format!("{name}: columns {columns:?}, but files.md has {documented:?}"));
        }
    }
    assert!(
        bad.is_empty() && unused.is_empty(),
        "{}\ntables that nothing produces: {unused:?}",
        bad.join("\n")
    );
}

#[test]
fn planted_keys_are_found() {
    let entry = |name: &str, is_always| Entry { name: name.to_owned(), is_always };
    let entries = [entry("a.b", true), entry("c[]", false), entry("d", true)];
    let document = serde_json::json!({ "a": { "b": { "x": 1 }, "bc": 2 }, "d": null });
    assert_eq!(differences("x", &entries, &document), ["x: a.bc is not in files.md"]);
    assert_eq!(differences("x", &entries, &serde_json::json!({ "a": { "b": 1 } })).len(), 1);
}
