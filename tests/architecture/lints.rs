//! Functions are short and take few arguments: clippy's thresholds stand in `clippy.toml`, and a
//! line that is excepted from a lint says why.

use syn::visit::{self, Visit};
use syn::{Attribute, Meta};

use super::{root, texts};

/// Lines of `clippy.toml` that hold functions to a size.
const THRESHOLDS: [&str; 2] = ["too-many-lines-threshold = 60", "too-many-arguments-threshold = 5"];
/// The same lints, which no attribute may switch off.
const SIZES: [&str; 2] = ["too_many_lines", "too_many_arguments"];

/// Exceptions from lints: all, and those that are wrong.
#[derive(Default)]
struct Exceptions {
    count: usize,
    bad: Vec<String>,
}

impl<'ast> Visit<'ast> for Exceptions {
    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        let meta = match &attribute.meta {
            Meta::List(list) if list.path.is_ident("allow") || list.path.is_ident("expect") => list,
            _ => return visit::visit_attribute(self, attribute),
        };
        let text = meta.tokens.to_string();
        self.count += 1;
        if !text.contains("reason =") || SIZES.iter().any(|lint| text.contains(lint)) {
            self.bad.push(text);
        }
    }
}

fn exceptions(text: &str) -> Exceptions {
    let mut found = Exceptions::default();
    found.visit_file(&syn::parse_file(text).expect("a source file"));
    found
}

#[test]
fn exceptions_from_lints_have_reasons() {
    let settings = std::fs::read_to_string(root().join("clippy.toml")).unwrap();
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    for line in THRESHOLDS {
        assert!(settings.lines().any(|found| found == line), "clippy.toml has no line '{line}'");
    }
    assert!(manifest.contains("\ntoo_many_lines = \"warn\"\n"), "the lint is not switched on in Cargo.toml");
    let (mut count, mut bad) = (0, Vec::new());
    for (file, text) in texts() {
        let found = exceptions(&text);
        count += found.count;
        bad.extend(found.bad.into_iter().map(|text| format!("{}: {text}", file.display())));
    }
    println!("exceptions from lints: {count}, without a reason: {}", bad.len());
    assert!(bad.is_empty(), "without a reason, or of a size of functions:\n{}", bad.join("\n"));
}

#[test]
fn planted_exceptions_are_found() {
    let planted = [
        ("#[allow(clippy::cast_lossless)] fn f() {}", 1),
        ("#![allow(dead_code)]", 1),
        ("fn f() { #[expect(unused)] let x = 1; }", 1),
        ("#[allow(clippy::too_many_lines, reason = \"a table\")] fn f() {}", 1),
        ("#[allow(clippy::cast_lossless, reason = \"lengths are small\")] fn f() {}", 0),
    ];
    for (text, bad) in planted {
        assert_eq!(exceptions(text).bad.len(), bad, "{text}");
    }
}
