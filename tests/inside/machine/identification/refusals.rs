//! Readings and configs that cannot be right.

use super::{GEOMETRY, config, refusal, whole};
use crate::identification::{IdentifiedMachine, MachineIdentity};

const HEAD: &str = "axis,position_mm,direction,run,error,value,unit\n";

/// Rows of EZZ of one run.
fn rows(direction: &str, positions: &[f64]) -> String {
    positions.iter().map(|p| format!("Z,{p},{direction},1,EZZ,0.1,um\n")).collect()
}

#[track_caller]
fn refused(k: usize, text: &str, words: &[&str]) {
    let said = refusal(&whole(0.1), k, text).to_string();
    for word in words.iter().chain(&["my.csv", &format!("readings[{k}]")]) {
        assert!(said.contains(word), "'{word}' is missing in: {said}");
    }
}

#[test]
fn positions_of_a_run_are_those_of_its_direction() {
    let csv = |direction: &str, p: &[f64]| HEAD.to_owned() + &rows(direction, p);
    refused(1, &csv("forward", &[0.0, 20.0, 10.0, 30.0]), &["line 4", "10 mm after 20 mm", "shuffled"]);
    refused(1, &csv("forward", &[0.0, 10.0, 20.0, 10.0, 0.0]), &["line 5", "two directions are mixed"]);
    refused(1, &csv("forward", &[20.0, 10.0, 0.0]), &["line 3", "the direction the opposite one?"]);
    refused(1, &csv("backward", &[0.0, 10.0, 20.0]), &["the direction the opposite one?"]);
    refused(1, &csv("forward", &[0.0, 10.0, 10.0]), &["each position once a run"]);
    refused(1, &csv("up", &[0.0]), &["direction 'up'", "forward or backward"]);
}

#[test]
fn values_of_another_unit_and_other_cells_are_named() {
    let one = |row: &str| format!("{HEAD}{row}\n");
    refused(1, &one("Z,0,forward,1,EZZ,4000,um"), &["line 2", "4000 um", "a thousand times", "nm"]);
    refused(1, &one("Z,0,forward,1,EBZ,1.5,mrad"), &["1.5 mrad", "a thousand times", "nrad"]);
    refused(1, &one("Z,0,forward,1,EZZ,1,urad"), &["unit 'urad'", "nm, um or mm"]);
    refused(1, &one("X,0,forward,1,EZZ,1,um"), &["axis 'X'", "must be Z"]);
    refused(1, &one("Z,0,forward,1,ECZ,1,urad"), &["'ECZ' is not read by a laser", "no roll"]);
    refused(1, &one("Z,0,forward,0,EZZ,1,um"), &["run '0'"]);
    refused(1, &one("Z,x,forward,1,EZZ,1,um"), &["position_mm 'x'", "finite"]);
    refused(1, &one("Z,500,forward,1,EZZ,1,um"), &["500 mm", "-60 to 140 mm", "the travel"]);
    refused(1, HEAD, &["no readings"]);
    refused(1, "axis,position_mm\n", &["no column direction"]);
    refused(2, &one("Z,0,forward,1,EZZ,1,um"), &["not read by a cylinder: radius"]);
}

#[test]
fn a_midline_needs_opposite_angles_and_a_straightedge_both_ways() {
    let text = |more: &str| {
        config(&format!("name = \"a\"\nhead = \"h\"\nidentify = [\"exz\"]\n{more}[machine]{GEOMETRY}"))
    };
    let midline = text(
        "[[readings]]\ninstrument = \"midline\"\nfile = \"my.csv\"\nu_um = 0.1\npart = { diameter_mm = 20.0, length_mm = 160.0, held = \"overhung\", gravity_x = 0.0 }\n",
    );
    let head = HEAD.replace("unit", "unit,angle_deg,setup");
    let row = |angle: &str| format!("Z,50,forward,1,midline,0.1,um,{angle},\n");
    let said = refusal(&midline, 0, &(head.clone() + &row("0") + &row("90"))).to_string();
    assert!(said.contains("angle 0°") && said.contains("without 180°"), "{said}");
    let said = refusal(&midline, 0, &(head.clone() + &row("0") + &row(""))).to_string();
    assert!(said.contains("angle_deg is missing"), "{said}");
    let edge = text(
        "[[readings]]\ninstrument = \"straightedge\"\nfile = \"my.csv\"\nline_mm = [0, 0, 0]\nu_um = 0.1\n",
    );
    let said = refusal(&edge, 0, &(head.clone() + "Z,0,forward,1,EXZ,1,um,,normal\n")).to_string();
    assert!(said.contains("one way only") && said.contains("turn it over"), "{said}");
    let said = refusal(&edge, 0, &(head + "Z,0,forward,1,EXZ,1,um,,\n")).to_string();
    assert!(said.contains("setup is missing"), "{said}");
}

#[test]
fn levers_and_uncertainties_are_not_assumed() {
    let csv = HEAD.to_owned() + &rows("forward", &[0.0, 10.0]);
    for (change, words) in [("line_mm", "levers"), ("u_um", "standard uncertainty")] {
        let mut config = whole(0.1);
        match change {
            "line_mm" => config.readings[1].line_mm = None,
            _ => config.readings[1].u_um = None,
        }
        let said = refusal(&config, 1, &csv).to_string();
        assert!(said.contains(&format!("readings[1].{change}")) && said.contains(words), "{said}");
    }
}

#[test]
fn configs_that_cannot_be_right_name_their_key() {
    let checked = |change: &dyn Fn(&mut crate::identification::IdentificationConfig)| {
        let mut config = whole(0.1);
        change(&mut config);
        config.check().err().unwrap().to_string()
    };
    for (said, words) in [
        (checked(&|c| c.identify.push("exq".into())), "identify[8] = exq"),
        (checked(&|c| c.identify.push("exc".into())), "by reversals: [[spindle]]"),
        (checked(&|c| c.identify.push("exx".into())), "named once"),
        (checked(&|c| c.identify.clear()), "at least one error"),
        (checked(&|c| c.name.clear()), "the machine's name"),
        (
            checked(&|c| c.machine.b0c_urad = 5.0),
            "machine.errors: an identification takes the geometry alone",
        ),
        (checked(&|c| c.readings[2].radius_mm = None), "readings[2].radius_mm"),
        (checked(&|c| c.readings[3].face_z_mm = None), "readings[3].face_z_mm"),
        (checked(&|c| c.readings[0].u_um = Some(0.0)), "readings[0].u_um"),
        (checked(&|c| c.readings.clear()), "at least one set"),
        (checked(&|c| c.simulate = None), "readings[0].file"),
    ] {
        assert!(said.contains(words), "'{words}' is missing in: {said}");
    }
    // an error that is read at one position, and one that no reading holds
    let unread = |name: &str| {
        let mut config = whole(0.1);
        config.identify.push(name.to_owned());
        config.machine.tip_above_axis_mm = 0.0;
        if name == "eyx" {
            config.machine.tip_above_axis_mm = 0.05;
        }
        let sets = super::sets(&config, &super::truth(""), 1);
        crate::identification::identify(&config, &sets).err().unwrap().to_string()
    };
    assert!(unread("eyx").contains("EYX is read at 1 positions"), "{}", unread("eyx"));
    assert!(unread("eyz").contains("EYZ is in no reading"), "{}", unread("eyz"));
}

#[test]
fn a_file_of_another_machine_or_head_is_refused() {
    let config = whole(0.05);
    let found = super::identified(&config, super::TRUTH, 1).file;
    let text = serde_json::to_string(&found).unwrap();
    let read = IdentifiedMachine::read(&text).unwrap();
    assert_eq!(read, found);
    let identity = |machine: &str, head: Option<&str>| MachineIdentity {
        machine: Some(machine.to_owned()),
        head: head.map(str::to_owned),
    };
    let mut with_head = read.clone();
    with_head.head = Some("telecentric".to_owned());
    assert_eq!(with_head.fits(&identity("lathe", Some("telecentric")), &config.machine), Ok(()));
    let said = read.fits(&identity("mill", None), &config.machine).unwrap_err();
    assert!(said.contains("machine 'lathe'") && said.contains("'mill'"), "{said}");
    let said = with_head.fits(&identity("lathe", Some("other")), &config.machine).unwrap_err();
    assert!(said.contains("head 'telecentric'"), "{said}");
    let mut other = config.machine.clone();
    other.carriage_mm[2] += 1.0;
    let said = read.fits(&identity("lathe", None), &other).unwrap_err();
    assert!(said.contains("carriage_mm") && said.contains("identify again"), "{said}");
    other = config.machine.clone();
    other.chain = crate::machine::topology::Topology::TShaped;
    let said = read.fits(&identity("lathe", None), &other).unwrap_err();
    assert!(said.contains("its chain"), "{said}");
    for (text, words) in [
        ("{", "is no machine.json"),
        ("{\"format\": \"x\"}", "its format is 'x'"),
        ("{\"scale_mm_per_px\": 1}", "its format is 'none'"),
    ] {
        let said = IdentifiedMachine::read(text).unwrap_err();
        assert!(said.contains(words), "{said}");
    }
}
