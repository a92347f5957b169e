//! Small frames of a shadow and the program while it measures them, line by line.
#![allow(dead_code, reason = "not every test uses every helper")]

use std::io::{BufRead as _, BufReader, Cursor, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use image::{GrayImage, ImageFormat, Luma};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::program;

/// Longest time until a line comes: a hundred times what it takes.
const SOON: Duration = Duration::from_secs(20);
pub const COLUMNS: u32 = 64;
pub const ROWS: u32 = 96;
/// Rows between both edges of the shadow.
pub const WIDTH_PX: f64 = 36.1;

/// A shadow from row 30.2 to 66.3 with soft edges and noise of its own.
pub fn picture(seed: u64) -> GrayImage {
    let mut random = Pcg64::seed_from_u64(seed);
    let soft = |d: f64| 30.0 + 150.0 / (1.0 + (-2.0 * d).exp());
    GrayImage::from_fn(COLUMNS, ROWS, |_, row| {
        let row = f64::from(row);
        let grey = if row < 48.0 { soft(30.2 - row) } else { soft(row - 30.2 - WIDTH_PX) };
        Luma([grey as u8 + random.random_range(0..5_u8)])
    })
}

pub fn encoded(picture: &GrayImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    picture.write_to(&mut out, format).unwrap();
    out.into_inner()
}

pub fn png(seed: u64) -> Vec<u8> {
    encoded(&picture(seed), ImageFormat::Png)
}

pub fn pgm(picture: &GrayImage) -> Vec<u8> {
    [format!("P5 {COLUMNS} {ROWS} 255\n").as_bytes(), picture.as_raw()].concat()
}

/// The program while it measures.
pub struct Running {
    pub child: Child,
    stdin: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Running {
    pub fn start(arguments: &[&str]) -> Self {
        Self::of("measure", arguments)
    }

    /// A command of the program.
    pub fn of(name: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(program::path());
        command.arg(name).args(arguments).env("NO_COLOR", "1");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let (give, lines) = channel();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || out.lines().map_while(Result::ok).all(|line| give.send(line).is_ok()));
        let stdin = child.stdin.take();
        Self { child, stdin, lines }
    }

    pub fn send(&mut self, bytes: &[u8]) {
        let stdin = self.stdin.as_mut().unwrap();
        stdin.write_all(bytes).and_then(|()| stdin.flush()).unwrap();
    }

    pub fn line(&self) -> String {
        self.lines.recv_timeout(SOON).expect("a line, soon")
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.line()).unwrap()
    }

    /// Closes its input and gives its exit code with what it prints on.
    pub fn end(mut self) -> (Option<i32>, Vec<String>) {
        drop(self.stdin.take());
        let code = self.child.wait().unwrap().code();
        (code, self.lines.iter().collect())
    }

    /// The most memory that it has had so far, kB.
    pub fn most_kb(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        line.split_whitespace().next().unwrap().parse().unwrap()
    }
}

pub fn is_measured(frame: &Value) -> bool {
    frame["max_diameter_px"].as_f64().is_some_and(|width| (width - WIDTH_PX).abs() < 0.5)
}
