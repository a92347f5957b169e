//! The feature `onnx` in Cargo.toml and Cargo.lock: off by default, and without anything that is
//! downloaded or compiled by a C compiler. Its own tests run with it (`make peers ONLY=onnx`).

use std::collections::BTreeSet;

fn table(name: &str) -> toml::Table {
    let path = format!("{}/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

#[test]
fn the_feature_is_optional_and_resolves_in_the_lock_file() {
    let manifest = table("Cargo.toml");
    let features = manifest["features"].as_table().unwrap();
    let of = |name: &str| -> Vec<&str> {
        features[name].as_array().unwrap().iter().filter_map(toml::Value::as_str).collect()
    };
    assert_eq!(of("onnx"), ["dep:rten"]);
    for (name, _) in features.iter().filter(|(name, _)| *name != "onnx") {
        assert!(!of(name).iter().any(|part| part.contains("onnx") || part.contains("rten")), "{name}");
    }
    let rten = &manifest["dependencies"]["rten"];
    assert_eq!((rten["optional"].as_bool(), rten["default-features"].as_bool()), (Some(true), Some(false)));
    let lock = table("Cargo.lock");
    let packages = lock["package"].as_array().unwrap();
    let named = |name: &str| -> Vec<&toml::Value> {
        packages.iter().filter(|p| p["name"].as_str() == Some(name)).collect()
    };
    assert!(named("rten").iter().any(|p| p["version"] == rten["version"]), "{}", rten["version"]);
    // everything that rten brings along
    let (mut seen, mut next) = (BTreeSet::new(), vec!["rten".to_owned()]);
    while let Some(name) = next.pop() {
        let needs = named(&name).into_iter().filter_map(|p| p.get("dependencies")?.as_array());
        for need in needs.flatten().filter_map(toml::Value::as_str) {
            let need = need.split(' ').next().unwrap_or(need).to_owned();
            if seen.insert(need.clone()) {
                next.push(need);
            }
        }
    }
    assert!(seen.contains("rten-onnx"), "{seen:?}");
    for refused in ["cc", "cmake", "bindgen", "prost-build", "ureq", "reqwest"] {
        assert!(!seen.contains(refused), "rten brings {refused}: {seen:?}");
    }
}
