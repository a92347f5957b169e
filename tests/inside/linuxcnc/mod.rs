//! LinuxCNC's stand-alone interpreter, where it is installed.

use std::process::Command;

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
