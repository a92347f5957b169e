//! A smoke test of the Python package: the library that Cargo built beside this test, under the name
//! by which Python imports it, before the package's tests that need NumPy and pytest alone.
//!
//! The wheel itself is not built here (`make wheel`): its crate would be compiled anew without the
//! features that dev-dependencies turn on, in as many minutes as all else takes.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Pythons that may have NumPy and pytest: the one that is named, the one of the cameras' tests, the
/// system's.
fn pythons() -> impl Iterator<Item = PathBuf> {
    let named = ["SHADOWGAUGE_PYTHON", "GENICAM_PYTHON"].map(std::env::var_os);
    named.into_iter().flatten().map(PathBuf::from).chain([PathBuf::from("python3")])
}

fn has_packages(python: &Path) -> bool {
    let found = Command::new(python).args(["-c", "import numpy, pytest"]).output();
    found.is_ok_and(|output| output.status.success())
}

/// The package as it would be installed, in a folder of its own.
fn package(native: &Path, into: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = into.join("shadowgauge");
    std::fs::create_dir_all(&folder).unwrap();
    for entry in std::fs::read_dir(root.join("python/shadowgauge")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
    std::fs::copy(native, folder.join("_shadowgauge.abi3.so")).unwrap();
}

#[test]
fn the_package_measures_streams_and_draws() {
    let Some(python) = pythons().find(|python| has_packages(python)) else {
        eprintln!(
            "SKIPPED: no Python with NumPy and pytest: the Python package is not tested (SHADOWGAUGE_PYTHON)"
        );
        return;
    };
    let beside = std::env::current_exe().unwrap();
    let native = beside.with_file_name("lib_shadowgauge.so");
    if !native.exists() {
        eprintln!(
            "SKIPPED: no {}: the package's test knows the name of a library of Linux alone",
            native.display()
        );
        return;
    }
    let installed = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("package-{}", std::process::id()));
    package(&native, &installed);
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let done = Command::new(&python)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .args(
            ["test_arrays.py", "test_controller.py", "test_package.py", "test_streams.py"]
                .map(|f| tests.join(f)),
        )
        .env("PYTHONPATH", &installed)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    std::fs::remove_dir_all(&installed).unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{said}\n{}", String::from_utf8_lossy(&done.stderr));
    println!("{said}");
}
