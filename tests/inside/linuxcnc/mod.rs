//! LinuxCNC's stand-alone interpreter, where it is installed.

use std::process::Command;

use glam::DVec2;

/// Where a move ends, (x radius, z), and whether it is in rapid.
pub type Move = ((f64, f64), bool);

/// Runs a program through LinuxCNC's interpreter: its moves as ((x radius, z), in rapid), and the
/// whole output; `None` where it is not installed.
pub fn interpret(program: &str) -> Option<(Vec<Move>, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("program.ngc");
    std::fs::write(&file, program).expect("written");
    let table = folder.path().join("tool.tbl");
    std::fs::write(&table, "T1 P1 X0 Z0\nT5 P5 X0 Z0\n").expect("written");
    // it maps ~/.tool.mmap: two processes with the same home end with a bus error
    let run = Command::new("rs274")
        .env("HOME", folder.path())
        .current_dir(folder.path())
        .arg("-t")
        .arg(&table)
        .arg("-g")
        .arg(&file)
        .output();
    let output = match run {
        Ok(output) => output,
        Err(e) => {
            eprintln!(
                "SKIPPED: LinuxCNC's rs274 cannot be run ({e}); install the Debian package linuxcnc-uspace"
            );
            return None;
        }
    };
    let printed =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let moved = |line: &str| {
        let line = &line.replace("STRAIGHT_PROBE(", "STRAIGHT_FEED(");
        let (inside, rapid) = match (line.split_once("STRAIGHT_FEED("), line.split_once("STRAIGHT_TRAVERSE("))
        {
            (Some((_, rest)), _) => (rest, false),
            (_, Some((_, rest))) => (rest, true),
            _ => return None,
        };
        let numbers: Vec<f64> =
            inside.split(')').next()?.split(',').filter_map(|n| n.trim().parse().ok()).collect();
        Some(((*numbers.first()?, *numbers.get(2)?), rapid))
    };
    Some((printed.lines().filter_map(moved).collect(), printed))
}

/// Straight moves of LinuxCNC's canonical commands, arcs by chords: (X radius, Z).
pub fn canonical(printed: &str) -> Vec<(DVec2, DVec2)> {
    let mut at: Option<DVec2> = None;
    let mut moves = Vec::new();
    for line in printed.lines() {
        let Some((name, rest)) = line.split_once('(') else { continue };
        let numbers: Vec<f64> =
            rest.split(')').next().unwrap().split(',').filter_map(|n| n.trim().parse().ok()).collect();
        let points = if name.ends_with("STRAIGHT_FEED") || name.ends_with("STRAIGHT_TRAVERSE") {
            vec![DVec2::new(numbers[0], numbers[2])]
        } else if name.ends_with("ARC_FEED") {
            // first axis Z, second X in G18; rotation > 0 is anticlockwise from Z to X
            let (end, centre) = (DVec2::new(numbers[1], numbers[0]), DVec2::new(numbers[3], numbers[2]));
            let from = at.unwrap() - centre;
            let angle = |v: DVec2| v.x.atan2(v.y);
            let whole = std::f64::consts::TAU;
            let mut turn = angle(end - centre) - angle(from);
            if numbers[4] > 0.0 && turn < 0.0 {
                turn += whole;
            }
            if numbers[4] < 0.0 && turn > 0.0 {
                turn -= whole;
            }
            let radius = from.length();
            let point = |k: i32| {
                let a = angle(from) + turn * f64::from(k) / 500.0;
                centre + radius * DVec2::new(a.sin(), a.cos())
            };
            (1..500).map(point).chain([end]).collect()
        } else {
            continue;
        };
        for to in points {
            moves.extend(at.map(|from| (from, to)));
            at = Some(to);
        }
    }
    moves
}
