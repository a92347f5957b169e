//! The model that `--model` names.

use std::path::Path;

use crate::cli::failure::Failure;
use crate::gauge::flank::forest::file;
use crate::gauge::flank::{CONTEXT, FEATURES, LandModel, shipped};

/// What stands for a model on the command line; `None` is the paper's way.
///
/// # Errors
/// Exit 2 for a file that is no model, or one that this program is built without.
pub(in crate::cli) fn read(name: &str) -> Result<Option<Box<dyn LandModel>>, Failure> {
    match name {
        "paper" => Ok(None),
        "forest" => Ok(Some(Box::new(shipped().map_err(Failure::fail)?))),
        path => of_file(path).map(Some).map_err(|e| {
            Failure::refuse(format!(
                "--model {path}: {e}; give forest, paper, a file of `tool train`, or a network as FILE.onnx"
            ))
        }),
    }
}

/// A forest, or by its ending a network.
fn of_file(path: &str) -> Result<Box<dyn LandModel>, String> {
    if Path::new(path).extension().is_some_and(|e| e.eq_ignore_ascii_case("onnx")) {
        return network(path);
    }
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    Ok(Box::new(file::read(&bytes, (FEATURES, CONTEXT))?))
}

#[cfg(feature = "onnx")]
fn network(path: &str) -> Result<Box<dyn LandModel>, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let network = crate::gauge::flank::network::Network::read(bytes).map_err(|e| e.to_string())?;
    Ok(Box::new(network))
}

#[cfg(not(feature = "onnx"))]
fn network(_: &str) -> Result<Box<dyn LandModel>, String> {
    Err("this program is built without networks: build it with `cargo build --release --locked --features onnx`"
        .to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(name: &str) -> String {
        let Err(failure) = read(name) else { panic!("{name} is taken") };
        assert_eq!(failure.exit, 2);
        failure.report.to_string()
    }

    fn data(name: &str) -> String {
        format!("{}/tests/data/onnx/{name}", env!("CARGO_MANIFEST_DIR"))
    }

    #[test]
    fn a_network_under_another_name_is_no_forest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("network.forest");
        std::fs::copy(data("threshold.onnx"), &path).unwrap();
        let text = refused(&path.to_string_lossy());
        assert!(text.contains("not a file of `tool train`") && text.contains("FILE.onnx"), "{text}");
        assert!(refused("absent.forest").contains("absent.forest"));
    }

    #[cfg(not(feature = "onnx"))]
    #[test]
    fn a_program_without_networks_states_how_to_build_one_with_them() {
        for name in ["threshold.onnx", "absent.ONNX"] {
            let text = refused(&data(name));
            assert!(text.contains("--features onnx") && text.contains(name), "{text}");
        }
    }

    #[cfg(feature = "onnx")]
    #[test]
    fn a_network_is_read_and_a_forest_named_like_one_refused() {
        assert!(read(&data("threshold.onnx")).is_ok_and(|m| m.is_some()));
        assert!(refused(&data("absent.onnx")).contains("absent.onnx"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("forest.onnx");
        std::fs::write(&path, b"SGFLANK2{}\n").unwrap();
        let text = refused(&path.to_string_lossy());
        assert!(text.contains("a forest of `tool train`") && text.contains("another ending"), "{text}");
    }
}
