//! State is held in small structs: a struct of more than twelve fields is settings that a user
//! gives, or a result that is written, and nothing else.

use std::path::Path;

use syn::visit::{self, Visit};
use syn::{Attribute, Fields, ItemStruct};

use super::texts;

/// Most fields of a struct that is neither settings nor a result.
const MOST: usize = 12;

/// What a struct with more fields is, where its derives do not show it: every field is given and
/// none changes, or every field is a figure that is handed out.
const LISTED: [(&str, &str, &str); 9] = [
    ("src/closed_loop.rs", "PassResult", "result"),
    ("src/gauge/nose/result.rs", "NoseMeasurement", "result"),
    ("src/job/loop_job.rs", "LoopJob", "settings"),
    ("src/measurement/result.rs", "Measurement", "result"),
    ("src/nc/replay/judge.rs", "WorkingSpace", "settings"),
    ("src/publish/genicam/data_sheet.rs", "DataSheet", "settings"),
    ("src/report/measured_frames.rs", "FrameRow", "result"),
    ("src/studies/reproduce_001/inputs.rs", "Inputs", "settings"),
    ("src/studies/reproduce_004/inputs.rs", "Inputs", "settings"),
];

/// Derives that mark settings (read from files and the command line) and results (written).
const MARKS: [&str; 5] = ["Serialize", "Deserialize", "Args", "Parser", "JsonSchema"];

/// A struct: its name, its fields, and whether its derives show what it is.
#[derive(Debug, PartialEq, Eq)]
struct Found {
    name: String,
    fields: usize,
    is_marked: bool,
}

#[derive(Default)]
struct Structs(Vec<Found>);

impl<'ast> Visit<'ast> for Structs {
    fn visit_item_struct(&mut self, item: &'ast ItemStruct) {
        if let Fields::Named(named) = &item.fields {
            let is_marked = item.attrs.iter().any(is_mark);
            self.0.push(Found { name: item.ident.to_string(), fields: named.named.len(), is_marked });
        }
        visit::visit_item_struct(self, item);
    }
}

/// Whether an attribute derives one of [`MARKS`].
fn is_mark(attribute: &Attribute) -> bool {
    let Ok(list) = attribute.meta.require_list() else { return false };
    let tokens = list.tokens.to_string();
    list.path.is_ident("derive")
        && tokens.split(|c: char| !c.is_alphanumeric()).any(|word| MARKS.contains(&word))
}

fn structs(text: &str) -> Vec<Found> {
    let mut found = Structs::default();
    found.visit_file(&syn::parse_file(text).expect("a source file"));
    found.0
}

#[test]
fn state_is_held_in_small_structs() {
    let (mut bad, mut listed, mut largest) = (Vec::new(), 0, (0, String::new()));
    for (file, text) in texts() {
        for found in structs(&text).into_iter().filter(|found| !found.is_marked) {
            let is_listed = LISTED.iter().any(|(of, name, _)| file == Path::new(of) && found.name == *name);
            let place = format!("{}: {}", file.display(), found.name);
            if is_listed {
                listed += 1;
                assert!(found.fields > MOST, "{place} has {} fields: it need not be listed", found.fields);
            } else if found.fields > MOST {
                bad.push(format!("{place} has {} fields", found.fields));
            } else {
                largest = largest.max((found.fields, place));
            }
        }
    }
    println!(
        "fields of the largest struct that is neither settings nor a result: {} ({})",
        largest.0, largest.1
    );
    assert_eq!(listed, LISTED.len(), "of {LISTED:?} some are no more");
    assert!(bad.is_empty(), "more than {MOST}, and neither settings nor a result:\n{}", bad.join("\n"));
}

#[test]
fn planted_structs_are_found() {
    let fields = |n: usize| (0..n).map(|k| format!("f{k}: f64, ")).collect::<String>();
    let of = |before: &str, n: usize| structs(&format!("{before} struct A {{ {} }}", fields(n))).remove(0);
    assert_eq!(of("", 13), Found { name: "A".to_owned(), fields: 13, is_marked: false });
    assert!(of("#[derive(Debug, serde::Serialize)]", 13).is_marked);
    assert!(of("#[derive(Debug, clap::Args)]", 20).is_marked);
    assert!(!of("#[derive(Clone, Debug)] #[serde(skip)]", 13).is_marked);
    assert_eq!(structs(&format!("fn f() {{ struct B {{ {} }} }}", fields(2)))[0].fields, 2);
}
