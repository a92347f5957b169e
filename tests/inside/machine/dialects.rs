//! Tables as spreadsheets write them: semicolons and decimal commas hold what commas and points do.

use super::identification_of;
use crate::identification::{IdentificationConfig, checked_set};
use crate::inside::support::program::{json, said, shadowgauge};
use crate::machine::MachineSettings;
use crate::studies::machine_readings::SimulatedMachine;

const PLAN: &str = include_str!("../../../configs/machine_coverage.toml");

/// The text with semicolons and decimal commas.
fn in_another_dialect(text: &str) -> String {
    text.replace(',', ";").replace('.', ",")
}

#[test]
fn readings_with_semicolons_and_decimal_commas_identify_the_same() {
    let config: IdentificationConfig = toml::from_str(PLAN).unwrap();
    let truth: MachineSettings = MachineSettings { b0c_urad: 30.0, a0c_urad: 0.0, ..config.machine.clone() };
    let machine = SimulatedMachine::new(truth.clone(), 20.0, 3).unwrap();
    for k in 0..config.readings.len() {
        let text = machine.text(&config.readings[k], k).unwrap();
        let plain = checked_set(&config, k, text.as_bytes(), "a.csv").unwrap();
        let other = format!("sep=;\r\n{}", in_another_dialect(&text));
        let other = checked_set(&config, k, other.as_bytes(), "b.csv").unwrap();
        assert_eq!(plain.readings.len(), other.readings.len());
        for (a, b) in plain.readings.iter().zip(&other.readings) {
            assert_eq!((a.quantity, a.position_mm, a.value), (b.quantity, b.position_mm, b.value));
        }
    }
    let found = identification_of(PLAN, &truth, 3).file;
    let b0c = found.errors.iter().find(|error| error.error == "B0C").unwrap();
    assert!((b0c.value[0] - 30.0).abs() < 4.0 * b0c.u[0], "{b0c:?}");
    // a comma that separates and is a decimal comma, too
    let torn = "axis,position_mm,direction,run,error,value,unit\nZ,0,5,forward,1,radius,1,um\n";
    let refused = checked_set(&config, 0, torn.as_bytes(), "c.csv").err().unwrap().to_string();
    assert!(refused.contains("line 2: 8 fields under 7 names (a decimal comma"), "{refused}");
}

#[test]
fn gauges_are_compared_from_either_dialect() {
    let folder = tempfile::tempdir().unwrap();
    let table = "part,d_mm,reference_mm,expanded_u_mm\na,10.0012,10.0009,0.0008\nb,12.0031,12.0027,0.0008\nc,14.0001,14.0003,0.0008\n";
    let run = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap().to_owned();
        shadowgauge(["study", "correlation", &path, "--reference-expanded-u-um", "0.5", "--json"])
    };
    let plain = run("a.csv", table);
    let other = run("b.csv", &in_another_dialect(table));
    assert_eq!(json(&plain), json(&other));
    assert_eq!(json(&plain)["parts"].as_array().map(Vec::len), Some(3));
    let wrong = run("c.csv", &table.replace("12.0031", "far"));
    assert_eq!(wrong.status.code(), Some(2));
    assert!(said(&wrong).contains("line 3: d_mm 'far' must be a finite number"), "{}", said(&wrong));
    let short = run("d.csv", &table.replace("d_mm", "diameter"));
    assert!(said(&short).contains("no column d_mm"), "{}", said(&short));
}

#[test]
fn measure_refuses_a_machine_of_another_head() {
    let folder = tempfile::tempdir().unwrap();
    let truth: MachineSettings = toml::from_str::<IdentificationConfig>(PLAN).unwrap().machine;
    let found = identification_of(PLAN, &truth, 1).file;
    let machine = folder.path().join("machine.json");
    std::fs::write(&machine, serde_json::to_string(&found).unwrap()).unwrap();
    let calibration = folder.path().join("calibration.json");
    let scale = crate::gauge::Calibration::from_scale(17.0);
    std::fs::write(&calibration, serde_json::to_string(&scale).unwrap()).unwrap();
    let frame = folder.path().join("0.png");
    image::GrayImage::from_pixel(64, 140, image::Luma([200])).save(&frame).unwrap();
    let measure = |more: &[&str]| {
        let paths = [&frame, &calibration, &machine].map(|path| path.to_str().unwrap());
        let own = ["measure", paths[0], "--calibration", paths[1], "--machine", paths[2]];
        shadowgauge(own.iter().chain(more))
    };
    let refused = measure(&["--head", "entocentric"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    for words in ["machine.json", "telecentric 12", "entocentric"] {
        assert!(said(&refused).contains(words), "'{words}' is missing in: {}", said(&refused));
    }
    let hot = measure(&["--machine-temperature", "200"]);
    assert_eq!(hot.status.code(), Some(2), "{}", said(&hot));
}

/// A frame whose field lies where no reading was taken has no diameter, and the range is named; the
/// frame beside it is measured.
#[test]
fn a_frame_beyond_the_identified_range_has_no_diameter() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let truth: MachineSettings = toml::from_str::<IdentificationConfig>(PLAN).unwrap().machine;
    let found = identification_of(PLAN, &truth, 1).file;
    std::fs::write(at("machine.json"), serde_json::to_string(&found).unwrap()).unwrap();
    let scale = crate::gauge::Calibration::from_scale(17.0);
    std::fs::write(at("calibration.json"), serde_json::to_string(&scale).unwrap()).unwrap();
    std::fs::create_dir(at("frames")).unwrap();
    for name in ["0.png", "1.png"] {
        let shadow = |_, row| image::Luma([if (40..100).contains(&row) { 20 } else { 200 }]);
        image::GrayImage::from_fn(64, 140, shadow).save(at("frames").join(name)).unwrap();
    }
    std::fs::write(at("frames/frames.csv"), "frame,z_mm\n0,30\n1,500\n").unwrap();
    let paths = ["frames", "calibration.json", "machine.json"].map(|name| at(name).display().to_string());
    let [frames, calibration, machine] = &paths;
    let output =
        shadowgauge(["measure", frames.as_str(), "--calibration", calibration, "--machine", machine]);
    let words = said(&output) + &String::from_utf8_lossy(&output.stdout);
    for word in ["500.000 mm lies outside", "where the machine was identified", "1.02"] {
        assert!(words.contains(word), "'{word}' is missing in: {words}");
    }
}
