//! The generated references are what the program prints.

use shadowgauge::cli::reference_pages;

use super::markdown::root;

#[test]
fn references_are_those_of_the_program() {
    let folder = root().join("docs/reference");
    let bless = std::env::var("BLESS").is_ok_and(|what| what == "docs");
    assert!(!bless || std::env::var_os("CI").is_none(), "BLESS=docs where CI is set");
    let mut bad = Vec::new();
    let pages = reference_pages();
    for page in &pages {
        let path = folder.join(&page.name);
        if std::fs::read_to_string(&path).is_ok_and(|text| text == page.text) {
            continue;
        }
        bad.push(page.name.clone());
        if bless {
            std::fs::write(path, &page.text).unwrap();
        }
    }
    let hint = "write them by `shadowgauge reference --out docs/reference` or BLESS=docs, and look at the difference";
    assert!(bad.is_empty(), "{bad:?} differ from the program; {hint}");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let is_known = name == "files.md" || pages.iter().any(|page| page.name == name);
        assert!(is_known, "docs/reference/{name} belongs to no page");
    }
}
