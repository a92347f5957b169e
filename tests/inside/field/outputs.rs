//! Files that outputs must not replace, and two commands that write to one place.
#![cfg(unix)]

use std::fs::{self, File};
use std::io::Read as _;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use super::conformity::{COLUMNS, draw};
use super::support::{said, shadowgauge, text};

/// A shaft of 60 px.
fn picture(folder: &Path) -> PathBuf {
    let path = folder.join("part.png");
    draw(&path, 60.0, 1, |_| 0.0);
    path
}

fn measure(picture: &Path, edges: &Path, more: &[&str]) -> Output {
    let arguments = ["measure".as_ref(), picture.as_os_str(), "--edges".as_ref(), edges.as_os_str()];
    let scale = if more.contains(&"--calibration") { &[][..] } else { &["--um-per-px", "10"] };
    shadowgauge(arguments.into_iter().chain(scale.iter().chain(more).map(std::ffi::OsStr::new)))
}

/// Exit code and message of a refusal.
fn assert_ends(output: &Output, code: i32, word: &str) {
    let said = said(output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.contains(word), "{said}");
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

const HEADER: &str = "frame,column,top_px,bottom_px";

#[test]
fn an_input_is_never_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let picture = picture(folder.path());
    let bytes = fs::read(&picture).unwrap();
    let (link, twin) = (folder.path().join("link.csv"), folder.path().join("twin.csv"));
    symlink(&picture, &link).unwrap();
    fs::hard_link(&picture, &twin).unwrap();
    for edges in [&picture, &link, &twin] {
        assert_ends(&measure(&picture, edges, &[]), 2, "is an input of this command");
        assert_eq!(fs::read(&picture).unwrap(), bytes);
    }
    let table = folder.path().join("frames.csv");
    fs::write(&table, "frame,bit_depth\npart,8\n").unwrap();
    assert_ends(&measure(&picture, &table, &[]), 2, "is an input of this command");
    assert!(fs::read_to_string(&table).unwrap().starts_with("frame,bit_depth"));
    let conditions = folder.path().join("conditions.toml");
    fs::write(&conditions, "temperature_c = 20.0\n").unwrap();
    let more = ["--conditions", conditions.to_str().unwrap()];
    assert_ends(&measure(&picture, &conditions, &more), 2, "is an input of this command");
    assert_eq!(names(folder.path()), ["conditions.toml", "frames.csv", "link.csv", "part.png", "twin.csv"]);
}

#[test]
fn links_and_modes_stay_and_nothing_temporary_does() {
    let folder = tempfile::tempdir().unwrap();
    let picture = picture(folder.path());
    let elsewhere = folder.path().join("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    let target = elsewhere.join("old.csv");
    fs::write(&target, "old").unwrap();
    fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).unwrap();
    let (link, dangling) = (folder.path().join("edges.csv"), folder.path().join("new.csv"));
    symlink("elsewhere/old.csv", &link).unwrap();
    symlink("elsewhere/new.csv", &dangling).unwrap();
    for path in [&link, &dangling] {
        assert_ends(&measure(&picture, path, &[]), 0, "");
        assert!(fs::symlink_metadata(path).unwrap().is_symlink());
        assert!(fs::read_to_string(path).unwrap().starts_with(HEADER));
    }
    assert_eq!(fs::metadata(&target).unwrap().mode() & 0o777, 0o640);
    assert_eq!(names(&elsewhere), ["new.csv", "old.csv"]);
    fs::set_permissions(&target, fs::Permissions::from_mode(0o440)).unwrap();
    fs::write(elsewhere.join("kept"), "").unwrap();
    let before = fs::read(&target).unwrap();
    assert_ends(&measure(&picture, &link, &[]), 3, "read-only");
    assert_eq!(fs::read(&target).unwrap(), before);
    assert_ends(&measure(&picture, &elsewhere, &[]), 2, "is a folder");
    let circle = folder.path().join("circle");
    symlink(&circle, &circle).unwrap();
    assert_ends(&measure(&picture, &circle, &[]), 3, "circle");
    assert_eq!(names(folder.path()), ["circle", "edges.csv", "elsewhere", "new.csv", "part.png"]);
}

#[test]
fn devices_and_pipes_are_written_through() {
    let folder = tempfile::tempdir().unwrap();
    let picture = picture(folder.path());
    assert_ends(&measure(&picture, Path::new("/dev/null"), &[]), 0, "");
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    assert_ends(&measure(&picture, Path::new("/dev/full"), &[]), 3, "/dev/full: cannot be written");
    let fifo = folder.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let read = std::thread::spawn({
        let fifo = fifo.clone();
        move || {
            let mut text = String::new();
            File::open(fifo).unwrap().read_to_string(&mut text).unwrap();
            text
        }
    });
    assert_ends(&measure(&picture, &fifo, &[]), 0, "");
    assert!(read.join().unwrap().starts_with(HEADER));
    assert!(fs::metadata(&fifo).unwrap().file_type().is_fifo());
    assert_eq!(names(folder.path()), ["fifo", "part.png"]);
}

#[test]
fn stdout_takes_one_output() {
    let folder = tempfile::tempdir().unwrap();
    let picture = picture(folder.path());
    for name in ["-", "/dev/stdout", "/dev/fd/1"] {
        let output = measure(&picture, Path::new(name), &[]);
        assert_ends(&output, 0, "");
        let edges = text(&output.stdout);
        assert_eq!(edges.lines().count(), 1 + COLUMNS as usize, "edges alone, no table: {edges}");
        assert!(edges.starts_with(HEADER));
        assert_ends(&measure(&picture, Path::new(name), &["--json"]), 2, "stdout");
    }
    // The file to which the shell redirects stdout or stderr.
    let log = folder.path().join("log.csv");
    let redirected = |stream: fn(&mut Command, Stdio) -> &mut Command| {
        let mut command = Command::new(crate::inside::support::program::path());
        command.arg("measure").arg(&picture).arg("--edges").arg(&log);
        stream(&mut command, File::create(&log).unwrap().into()).output().unwrap()
    };
    assert_ends(&redirected(Command::stdout::<Stdio>), 2, "is where stdout goes");
    assert_eq!(redirected(Command::stderr::<Stdio>).status.code(), Some(2));
    assert!(!Path::new("-").exists());
}

#[test]
fn a_file_that_another_process_writes_is_left_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let picture = picture(folder.path());
    let (edges, temporary) = (folder.path().join("edges.csv"), folder.path().join(".tmp-edges.csv"));
    let held = File::create(&temporary).unwrap();
    fs::write(&temporary, "process 17 (shadowgauge measure)").unwrap();
    held.lock().unwrap();
    assert_ends(&measure(&picture, &edges, &[]), 2, "is being written by process 17 (shadowgauge measure)");
    assert!(!edges.exists());
    // The remains of a killed command are not locked.
    drop(held);
    assert_ends(&measure(&picture, &edges, &[]), 0, "");
    assert_eq!(names(folder.path()), ["edges.csv", "part.png"]);
    // The same for a folder, and for a file in place of a folder.
    fs::create_dir_all(temporary.join("frames")).unwrap();
    assert_ends(&measure(&picture, &edges, &[]), 0, "");
    let out = folder.path().join("study");
    fs::write(folder.path().join(".tmp-study"), "half").unwrap();
    let words = ["study", "stability", "--out"].iter().map(std::ffi::OsStr::new);
    assert_ends(&shadowgauge(words.chain([out.as_os_str()])), 0, "");
    assert_eq!(names(folder.path()), ["edges.csv", "part.png", "study"]);
}

/// A small job with a tolerance that its last pass aims at.
fn job_text() -> String {
    include_str!("../../support/small_render_job.toml")
        .replace("station_mm = 0.5\n", "station_mm = 0.5\ntolerance = \"1 ±0,1\"\n")
}

/// Commands that fill a folder: arguments before `--out`, and a file of the finished folder.
fn fillers(folder: &Path) -> Vec<(Vec<String>, &'static str)> {
    let job = folder.join("job.toml");
    fs::write(&job, job_text()).unwrap();
    let words = |text: &str| text.split(' ').map(|w| w.replace("JOB", &job.to_string_lossy())).collect();
    vec![
        (words("render JOB --backend cpu"), "frames.csv"),
        (words("study stability"), "report.html"),
        (words("reproduce 000 --no-frames"), "report.html"),
    ]
}

fn fill(words: &[String], out: &Path) -> Output {
    shadowgauge(words.iter().map(std::ffi::OsStr::new).chain(["--out".as_ref(), out.as_os_str()]))
}

#[test]
fn folders_are_filled_whole_behind_links_and_in_their_mode() {
    let folder = tempfile::tempdir().unwrap();
    for (index, (words, holds)) in fillers(folder.path()).into_iter().enumerate() {
        let root = folder.path().join(index.to_string());
        fs::create_dir(&root).unwrap();
        // Remains of killed commands, beside an absent place and in an existing one.
        let (fresh, stands, link) = (root.join("fresh"), root.join("stands"), root.join("link"));
        for left in [".tmp-fresh/frames", "stands/.tmp-partial/frames"] {
            fs::create_dir_all(root.join(left)).unwrap();
            fs::write(root.join(left).join("half.png"), "half").unwrap();
        }
        fs::write(root.join(".tmp-fresh/.tmp-lock"), "process 1 (killed)").unwrap();
        fs::set_permissions(&stands, fs::Permissions::from_mode(0o750)).unwrap();
        symlink("stands", &link).unwrap();
        for out in [&fresh, &link] {
            assert_ends(&fill(&words, out), 0, "");
            assert!(out.join(holds).is_file(), "{words:?}");
            assert!(names(out).iter().all(|name| !name.starts_with('.')), "{:?}", names(out));
            assert!(!out.join("frames/half.png").exists());
            assert_ends(&fill(&words, out), 2, "is not empty");
        }
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&stands).unwrap().mode() & 0o777, 0o750);
        assert_eq!(names(&root), ["fresh", "link", "stands"]);
    }
}

#[test]
fn what_is_no_folder_is_no_place_for_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "kept").unwrap();
    let mut commands: Vec<Vec<String>> = fillers(folder.path()).into_iter().map(|f| f.0).collect();
    commands.push(vec!["run".into(), folder.path().join("job.toml").to_string_lossy().into_owned()]);
    for words in commands {
        for out in [file.as_path(), Path::new("/dev/null"), Path::new("-")] {
            let output = fill(&words, out);
            let said = said(&output);
            assert_eq!(output.status.code(), Some(2), "{words:?} {}: {said}", out.display());
            assert!(
                said.contains("folder") || said.contains("stdout"),
                "{words:?} {}: {said}",
                out.display()
            );
        }
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "kept");
    assert_eq!(names(folder.path()), ["file", "job.toml"]);
}

/// Two processes in one place: the second one names the holder in its error; once the first is
/// killed, the next one clears the remains and takes the place.
#[test]
fn a_folder_is_held_while_it_is_filled_and_free_when_its_holder_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let (words, holds) = fillers(folder.path()).swap_remove(0);
    let out = folder.path().join("out");
    let mut first = Command::new(crate::inside::support::program::path())
        .args(&words)
        .args(["--frames", "100000", "--out"])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lock = folder.path().join(".tmp-out/.tmp-lock");
    let waited = (0..600).any(|_| {
        std::thread::sleep(Duration::from_millis(50));
        fs::read_to_string(&lock).is_ok_and(|text| text.starts_with("process"))
    });
    let second = fill(&words, &out);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(waited, "the first command never began");
    assert_ends(&second, 2, &format!("is being written by process {} (shadowgauge render", first.id()));
    assert!(!out.exists() && folder.path().join(".tmp-out").exists());
    assert_ends(&fill(&words, &out), 0, "");
    assert!(out.join(holds).is_file());
    assert_eq!(names(folder.path()), ["job.toml", "out"]);
}

#[test]
fn a_run_folder_is_held_by_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.toml");
    fs::write(&job, job_text()).unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let lock = out.join(".tmp-lock");
    let held = File::create(&lock).unwrap();
    fs::write(&lock, "process 17 (shadowgauge run)").unwrap();
    held.lock().unwrap();
    let words = |name: &str| vec![name.to_owned(), job.to_string_lossy().into_owned()];
    assert_ends(&fill(&words("run"), &out), 2, "is being written by process 17 (shadowgauge run)");
    assert_eq!(names(&out), [".tmp-lock"]);
}
