//! Examples of every command, with which its `--help` ends.
//!
//! In: the program's definition. Out: the same with a section "Examples:" a command. Every command
//! that `--help` lists has one; the lines are parsed by `tests/documents` and `tests/manners.rs`.

use clap::Command;

/// A command by its words behind the program's name, with its examples.
type Examples = (&'static str, &'static [&'static str]);

const EXAMPLES: &[Examples] = &[
    (
        "",
        &[
            "shadowgauge new shaft > my.toml",
            "shadowgauge run my.toml --out out/my",
            "shadowgauge measure frames --um-per-px 17.4",
        ],
    ),
    ("demo", &["shadowgauge demo", "shadowgauge demo --out out/first --backend cpu"]),
    (
        "run",
        &[
            "shadowgauge run configs/small_shaft.toml --out out/small",
            "shadowgauge run configs/stepped_shaft.toml --out out/stepped",
            "shadowgauge run my.toml --out out/my --controller ilc --seed 7",
            "shadowgauge run my.toml --out out/plain --passes 2 --no-reference --json",
            "shadowgauge run my.toml --out out/part --record frames",
            "shadowgauge run configs/wire_loop.toml --out out/wire",
            "shadowgauge run my.toml --out out/my --store gauge.sqlite --by Ada",
        ],
    ),
    (
        "render",
        &[
            "shadowgauge render my.toml --out out/frames --frames 4",
            "shadowgauge render my.toml --out out/tiff --format tiff16 --no-noise",
            "shadowgauge render my.toml --bench 100 --json",
            "shadowgauge render --gallery out/gallery",
        ],
    ),
    (
        "publish",
        &[
            "shadowgauge publish configs/small_shaft.toml",
            "shadowgauge publish my.toml --listen 192.168.1.5/24 --mtu 9000",
        ],
    ),
    ("doctor", &["shadowgauge doctor", "shadowgauge doctor --json"]),
    (
        "calibrate",
        &[
            "shadowgauge calibrate calibrate.toml --out bench.json",
            "shadowgauge calibrate my.toml --out bench.json --date 2026-11-22",
        ],
    ),
    (
        "calibrate machine",
        &[
            "shadowgauge calibrate machine configs/machine_identify.toml --out out/machine.json",
            "shadowgauge calibrate machine my.toml --out machine.json --tables out/tables --radius-mm 12.5",
        ],
    ),
    ("optics", &["shadowgauge optics esf my.toml > edge.csv"]),
    (
        "optics esf",
        &[
            "shadowgauge optics esf my.toml > edge.csv",
            "shadowgauge optics esf my.toml --axis-y-mm 0.5 --json",
        ],
    ),
    (
        "optics limb",
        &[
            "shadowgauge optics limb my.toml --part-material steel --part-finish ground > conditions.toml",
            "shadowgauge optics limb my.toml --masters-mm 18,27 --diameters-mm 6,40 --film-um 0.5 --limit-film-um 0.5",
        ],
    ),
    (
        "measure",
        &[
            "shadowgauge measure frame.png --um-per-px 17.4",
            "shadowgauge measure frames --um-per-px 17.4 --tolerance \"25 h6\" --csv diameters.csv --report report.html",
            "shadowgauge measure --follow incoming --um-per-px 17.4 --idle-s 60",
            "shadowgauge measure out/frames/frames --um-per-px file --edges edges.csv",
            "shadowgauge measure frames --calibration bench.json --tolerance \"25 h6\" --json",
            "shadowgauge measure part_7 --calibration bench.json --offsets job.toml --state state.toml --part 7",
            "shadowgauge measure washer.png --um-per-px 20 --shape ring",
            "shadowgauge measure shaft.y4m --um-per-px 17.4 --json",
            "shadowgauge measure raw:- --raw 2448x2048:mono12 --um-per-px 17.4 --json",
            "shadowgauge measure sim:configs/small_shaft.toml --um-per-px 17.4",
            "shadowgauge measure gige:192.168.1.20 --calibration bench.json --exposure-us 50 --json",
            "shadowgauge measure replay:day.mcap --calibration bench.json --json",
            "shadowgauge measure turn --calibration bench.json --turn --counts-per-turn 4096 --latched-at exposure_end --frames-per-turn 64",
            "shadowgauge measure --follow incoming --calibration bench.json --tolerance \"25 h6\" --settle-s 10",
            "shadowgauge measure frames --calibration bench.json --temperatures temperatures.csv --json",
        ],
    ),
    (
        "watch",
        &[
            "shadowgauge watch incoming --calibration bench.json --tolerance \"25 h6\"",
            "shadowgauge watch sim:configs/small_shaft.toml --um-per-px 17.4 --json",
            "shadowgauge watch gige:192.168.1.20 --calibration bench.json --tolerance \"25 h6\"",
            "shadowgauge watch incoming --calibration bench.json --record day.mcap",
            "shadowgauge watch gige:192.168.1.20 --setup",
            "shadowgauge watch gige:192.168.1.20 --calibration bench.json --tolerance \"25 h6\" --settle-s 10 --temperatures temperatures.csv --save shift_1",
            "shadowgauge watch incoming --calibration bench.json --zero zeros.csv --zero-interval-s 7200 --zero-um-per-h 0.5",
            "shadowgauge watch raw:- --raw 2448x2048:mono12p --um-per-px 17.4 --tolerance \"25 h6\" --on-alarm \"beep\"",
        ],
    ),
    ("schema", &["shadowgauge schema > job.schema.json", "shadowgauge schema machine > machine.schema.json"]),
    ("new", &["shadowgauge new shaft > my.toml", "shadowgauge new machine --out machine.toml"]),
    ("optimize", &["shadowgauge optimize configs/optimize_003.toml --out out/optimize"]),
    ("reproduce", &["shadowgauge reproduce 003", "shadowgauge reproduce 000 --no-frames"]),
    (
        "reproduce 000",
        &["shadowgauge reproduce 000 --no-frames --json", "shadowgauge reproduce 000 --out out/000"],
    ),
    ("reproduce 001", &["shadowgauge reproduce 001", "shadowgauge reproduce 001 --json --out out/001"]),
    ("reproduce 003", &["shadowgauge reproduce 003 --json", "shadowgauge reproduce 003 --out out/003"]),
    (
        "reproduce 004",
        &["shadowgauge reproduce 004 --out out/004", "shadowgauge reproduce 004 --cone-deg 24,37.6 --json"],
    ),
    (
        "tool",
        &[
            "shadowgauge tool nose worn.png --um-per-px 2.415 --tool tool.toml --out nose.json",
            "shadowgauge tool compensate --nose nose.json --tool tool.toml --part outline.toml --out out/nose",
        ],
    ),
    (
        "tool nose",
        &[
            "shadowgauge tool nose worn.png --um-per-px 2.415",
            "shadowgauge tool nose worn.png --um-per-px 2.415 --tool tool.toml --baseline new.png --out nose.json --overlay nose.png",
            "shadowgauge tool nose images --calibration calibration.json --json",
            "shadowgauge tool nose worn.png --um-per-px 2.415 --tool tool.toml --mode paper",
        ],
    ),
    (
        "tool axes",
        &[
            "shadowgauge tool axes 0.png 1.png 2.png --x-mm 0,0.5,0 --z-mm 0,0,0.5 --um-per-px 2.415 --tool tool.toml --out turned.toml",
        ],
    ),
    (
        "tool render",
        &["shadowgauge tool render configs/tool/insert.toml --out out/insert --frames 4 --seed 7"],
    ),
    (
        "tool flank",
        &[
            "shadowgauge tool flank flank.png --um-per-px 2.415 --model flanks.forest --nose-radius-mm 0.4",
            "shadowgauge tool flank flank.png --um-per-px 2.415 --model flanks.forest --cut 12 --history edge_3.csv --overlay land.png",
            "shadowgauge tool flank images --um-per-px 2.415 --model paper --json",
        ],
    ),
    (
        "tool render-flank",
        &[
            "shadowgauge tool render-flank configs/tool/flank.toml --out out/flank",
            "shadowgauge tool render-flank --random 20 --seed 7 --out out/flanks",
        ],
    ),
    ("tool train", &["shadowgauge tool train labelled --um-per-px 1.725 --out flanks.forest --seed 1"]),
    (
        "serve",
        &[
            "shadowgauge serve --runs out --store gauge.sqlite",
            "shadowgauge serve --source gige:192.168.1.20 -- --calibration bench.json --tolerance '22 h6'",
        ],
    ),
    ("store", &["shadowgauge store list gauge.sqlite", "shadowgauge store check gauge.sqlite"]),
    ("store check", &["shadowgauge store check gauge.sqlite", "shadowgauge store check gauge.sqlite --json"]),
    ("store export", &["shadowgauge store export gauge.sqlite --out gauge.jsonl"]),
    ("store import", &["shadowgauge store import copy.sqlite gauge.jsonl"]),
    ("store list", &["shadowgauge store list gauge.sqlite --from 2026-03-01 --to 2026-03-31"]),
    ("store prune", &["shadowgauge store prune gauge.sqlite --before 2025-01-01 --by Ada"]),
    (
        "tool compensate",
        &[
            "shadowgauge tool compensate --nose nose.json --tool tool.toml --part outline.toml --out out/nose",
            "shadowgauge tool compensate --nose nose.json --tool tool.toml --part outline.toml --way best-register --dialect fanuc --machine machine.toml --json",
        ],
    ),
    (
        "nc",
        &[
            "shadowgauge nc out/small --dialect linuxcnc --dry-run",
            "shadowgauge nc out/small --dialect fanuc --machine machine.toml --out O8001.nc",
            "shadowgauge nc job.toml --state state.toml --dialect sinumerik --machine machine.toml --air",
            "shadowgauge nc out/small --dialect linuxcnc --machine machine.toml --scan --out scan.ngc",
        ],
    ),
    (
        "study",
        &["shadowgauge study stability", "shadowgauge study deflection configs/beam_003.toml --at 500"],
    ),
    (
        "study deflection",
        &[
            "shadowgauge study deflection configs/beam_003.toml --at 500 --json",
            "shadowgauge study deflection my.toml --line --out out/line",
        ],
    ),
    ("study contamination", &["shadowgauge study contamination --json"]),
    ("study controllers", &["shadowgauge study controllers --shafts 3 --out out/controllers"]),
    ("study parts", &["shadowgauge study parts --parts 6 --insert-every 3"]),
    ("study stability", &["shadowgauge study stability my.toml --gain 0.8"]),
    ("study in-process", &["shadowgauge study in-process --out out/in_process"]),
    ("study line-camera", &["shadowgauge study line-camera --json"]),
    (
        "study machine",
        &[
            "shadowgauge study machine configs/machine_001.toml --out out/machine",
            "shadowgauge study machine configs/machine_001.toml --at 50,20 --at 50,80 --json",
        ],
    ),
    (
        "study machine-coverage",
        &["shadowgauge study machine-coverage configs/machine_coverage.toml --machines 100"],
    ),
    (
        "study flank",
        &[
            "shadowgauge study flank --model flanks.forest --flanks 50 --csv out/flanks.csv",
            "shadowgauge study flank --model flanks.forest --size 640x480 --um-per-px 3.5 --tools 1000 --json",
        ],
    ),
    (
        "study tool",
        &[
            "shadowgauge study tool --out out/study_tool",
            "shadowgauge study tool --cone-deg 15,45 --pieces 20 --json",
        ],
    ),
    ("study nose", &["shadowgauge study nose --noses 10", "shadowgauge study nose insert.toml --json"]),
    ("study factor", &["shadowgauge study factor", "shadowgauge study factor my.toml --forces forces.csv"]),
    (
        "study optics",
        &[
            "shadowgauge study optics my.toml --report optics.html",
            "shadowgauge study optics my.toml --diameter-mm 18 --csv optics.csv --json",
        ],
    ),
    (
        "study head",
        &[
            "shadowgauge study head my.toml other.toml --diameter-mm 10",
            "shadowgauge study head my.toml --rpm 1200 --eccentricity-mm 0.02 --report head.html",
        ],
    ),
    (
        "study correlation",
        &[
            "shadowgauge study correlation parts.csv",
            "shadowgauge study correlation parts.csv --expanded-u-um 0.8 --reference-expanded-u-um 1.2 --json",
        ],
    ),
    (
        "study coverage",
        &[
            "shadowgauge study coverage --scenes 40 --json",
            "shadowgauge study coverage --scenes 40 --shard 2/3 --shard-dir out/shards",
        ],
    ),
    (
        "study merge",
        &["shadowgauge study merge out/shards/coverage-1-of-3.parquet out/shards/coverage-2-of-3.parquet \
             out/shards/coverage-3-of-3.parquet"],
    ),
    ("study uncertainty", &["shadowgauge study uncertainty calibrate.toml --diameter-mm 25"]),
    ("study limits", &["shadowgauge study limits --json"]),
    ("study washers", &["shadowgauge study washers washers --out out/washers"]),
    (
        "completions",
        &[
            "shadowgauge completions bash > ~/.local/share/bash-completion/completions/shadowgauge",
            "shadowgauge completions zsh > ~/.zfunc/_shadowgauge",
        ],
    ),
    ("man", &["shadowgauge man > shadowgauge.1", "shadowgauge man --out man"]),
];

/// The program with its examples.
pub(crate) fn with_examples(program: Command) -> Command {
    of_command(program, "")
}

fn of_command(command: Command, path: &str) -> Command {
    let names: Vec<String> = command.get_subcommands().map(|below| below.get_name().to_owned()).collect();
    let command = names.into_iter().fold(command, |command, name| {
        let path = format!("{path} {name}").trim().to_owned();
        command.mut_subcommand(name, |below| of_command(below, &path))
    });
    match EXAMPLES.iter().find(|(known, _)| *known == path) {
        Some((_, lines)) => command.after_help(format!("Examples:\n  {}", lines.join("\n  "))),
        None => command,
    }
}

/// The lines of a command's examples.
pub(crate) fn of(command: &Command) -> Vec<String> {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let lines = help.strip_prefix("Examples:\n").unwrap_or_default().lines();
    lines.map(|line| line.trim().to_owned()).collect()
}
