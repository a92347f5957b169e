//! Every threshold of the instrument is accounted for. Its comment gives a reason (a source, a
//! derivation, a false-alarm probability), or says that it was tuned and names the study that shows
//! what it does; a tuned one changes a result of that study when it is halved or doubled
//! (`docs/thresholds_swept.csv`), or a test fails when it is put out of action
//! (`docs/thresholds_held.csv`).

use std::collections::{BTreeMap, BTreeSet};

use super::constants::{Declared, declared};
use super::root;

/// What makes a comment more than a statement of what is compared: a clause that says why, or a
/// source.
const REASONS: [&str; 13] = [
    ": ",
    "; ",
    ". ",
    " since ",
    " because ",
    " so that ",
    ", as ",
    "(ISO",
    "(GUM",
    "(LSD",
    "(the paper)",
    "(J. ",
    "alse-alarm probability",
];
/// A threshold that has the reason of the one before it.
const THE_SAME: [&str; 2] = ["The same", "As `"];

/// What a comment names that a value was tuned by.
const NAMED: [&str; 2] = ["Tuned: see study limits.", "Tuned: see tests of flanks."];

/// How a threshold is accounted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Account {
    Reason,
    Swept,
    Held,
    /// By nothing.
    None,
}

/// Thresholds that change a result of their study, and those that a test holds.
#[derive(Default)]
struct Evidence {
    swept: BTreeSet<String>,
    held: BTreeSet<String>,
}

impl Evidence {
    fn read() -> Self {
        let rows = |file: &str, none: &str| {
            let text = std::fs::read_to_string(root().join("docs").join(file)).unwrap();
            let cells =
                text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
            cells.filter(|cells| cells[3] != none).map(|cells| cells[0].clone()).collect()
        };
        Self { swept: rows("thresholds_swept.csv", "same"), held: rows("thresholds_held.csv", "-") }
    }

    /// How a threshold with this comment is accounted for.
    fn account(&self, name: &str, why: &str) -> Account {
        if why.contains("Tuned") {
            let named = NAMED.iter().any(|text| why.contains(text));
            return match (named, self.swept.contains(name), self.held.contains(name)) {
                (true, true, _) => Account::Swept,
                (true, _, true) => Account::Held,
                _ => Account::None,
            };
        }
        let reason = |texts: &[&str]| texts.iter().any(|text| why.contains(text));
        let same = THE_SAME.iter().any(|text| why.starts_with(text));
        if same || reason(&REASONS) { Account::Reason } else { Account::None }
    }
}

#[test]
fn every_threshold_is_accounted_for() {
    let evidence = Evidence::read();
    let mut count = BTreeMap::new();
    let (mut open, mut names) = (Vec::new(), BTreeSet::new());
    for group in declared().iter().flat_map(|(_, found)| &found.groups) {
        for (field, why) in &group.fields {
            let name = format!("{}.{field}", group.name.value());
            let account = evidence.account(&name, why);
            *count.entry(account).or_insert(0) += 1;
            if account == Account::None {
                open.push(name.clone());
            }
            names.insert(name);
        }
    }
    println!("thresholds by reason, by study, by test: {count:?}; unaccounted for: {}", open.len());
    let gone: Vec<&String> =
        evidence.swept.iter().chain(&evidence.held).filter(|n| !names.contains(*n)).collect();
    assert!(gone.is_empty(), "docs/thresholds_*.csv list thresholds that are no more: {gone:?}");
    assert!(
        open.is_empty(),
        "{} thresholds with neither a reason, an effect in their study nor a test:\n{}\n\
         (the comment says why; or \"Tuned: see study limits.\", with a row from `study limits --csv` in \
         docs/thresholds_swept.csv or from scripts/limits_held.py in docs/thresholds_held.csv)",
        open.len(),
        open.join("\n")
    );
}

#[test]
fn planted_thresholds_without_an_account_are_found() {
    let one = |name: &str| BTreeSet::from([name.to_owned()]);
    let evidence = Evidence { swept: one("a.swept"), held: one("a.held") };
    let planted = [
        ("a.most", "Most of them, px.", Account::None),
        ("a.most", "Most of them, px: noise reaches it once in a million.", Account::Reason),
        ("a.most", "Most of them (ISO 3685).", Account::Reason),
        ("a.most", "The same in rows.", Account::Reason),
        ("a.most", "Most of them, px: many. Tuned: see study limits.", Account::None),
        ("a.swept", "Most of them, px. Tuned: see study limits.", Account::Swept),
        ("a.held", "Most of them, px. Tuned: see study limits.", Account::Held),
        ("a.held", "Most of them, px: many. Tuned.", Account::None),
    ];
    for (name, why, account) in planted {
        assert_eq!(evidence.account(name, why), account, "{name}: {why}");
    }
    let group =
        Declared::of("limits! { A = \"a\"; /// Most of\n /// them.\n most: f64 = 1.0; }").groups.remove(0);
    assert_eq!(group.fields, [("most".to_owned(), "Most of them.".to_owned())]);
}
