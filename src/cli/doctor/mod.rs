//! `shadowgauge doctor`: adapters, drivers, the choice of `auto`, missing parts and how to install
//! them; cameras by network interface.
//!
//! `gpu_check` compares an adapter's frames with the CPU twin's and times both; `cameras` are those
//! that answer, with what the `network` would keep from arriving.

mod cameras;
mod gpu_check;
#[cfg(feature = "camera")]
mod network;

use std::path::Path;

use crate::render::BackendChoice;
use crate::render::gpu::{AdapterReport, adapter_reports, automatic};

use self::cameras::CameraFindings;
use crate::cli::failure::{CommandResult, Outcome};

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub(crate) struct DoctorArgs {
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
    /// List OpenGL's adapters, which are else looked at only where Vulkan offers none.
    #[arg(long, conflicts_with = "gpu_check")]
    gl: bool,
    /// Takes control of every GigE Vision camera that is free for a moment and has it send test
    /// packets: shows a firewall that drops them, and a network that carries no large ones.
    #[arg(long, conflicts_with_all = ["gpu_check", "gl"])]
    test_packets: bool,
    /// Hold an adapter against the CPU path over the golden frames and print what a frame costs on
    /// both.
    #[arg(long)]
    gpu_check: bool,
    /// With --gpu-check: which adapter; auto takes a hardware adapter and fails where there is
    /// none.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto, requires = "gpu_check")]
    backend: BackendChoice,
    /// With --gpu-check: frames to time of each kind.
    #[arg(long, value_name = "N", default_value_t = 100, requires = "gpu_check",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
}

#[derive(Debug, serde::Serialize)]
struct Findings {
    version: &'static str,
    threads: usize,
    simd: &'static str,
    adapters: Vec<AdapterReport>,
    /// Absent where only OpenGL's adapters were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    auto: Option<Choice>,
    missing: Vec<Missing>,
    /// Absent where only OpenGL's adapters were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    cameras: Option<CameraFindings>,
}

#[derive(Debug, serde::Serialize)]
struct Choice {
    backend: String,
    adapter: String,
}

#[derive(Debug, serde::Serialize)]
struct Missing {
    what: String,
    consequence: String,
    install: String,
}

/// Prints the findings; a missing part is no failure.
///
/// # Errors
/// Only those of `--gpu-check`.
pub(crate) fn run(args: &DoctorArgs) -> CommandResult {
    if args.gpu_check {
        return gpu_check::run(args.backend, args.frames as usize, args.json);
    }
    let cameras = (!args.gl).then(|| CameraFindings::look(args.test_packets));
    let findings = look(args.gl, cameras);
    if args.json {
        say_line!("{}", serde_json::to_string_pretty(&findings).unwrap_or_default());
    } else {
        print(&findings);
    }
    Ok(Outcome::Done)
}

fn look(gl: bool, cameras: Option<CameraFindings>) -> Findings {
    let vulkan = if gl { Vec::new() } else { adapter_reports(false) };
    let adapters = if vulkan.is_empty() { adapter_reports(true) } else { vulkan };
    Findings {
        version: env!("CARGO_PKG_VERSION"),
        threads: rayon::current_num_threads(),
        simd: simd(),
        missing: if gl { Vec::new() } else { missing(&adapters) },
        auto: (!gl).then(|| auto(&adapters)),
        adapters,
        cameras,
    }
}

/// The choice of `--backend auto` among these adapters.
fn auto(adapters: &[AdapterReport]) -> Choice {
    automatic(adapters).and_then(|index| adapters.get(index)).map_or_else(
        || Choice { backend: "cpu".into(), adapter: "CPU twin".into() },
        |a| Choice { backend: a.backend.clone(), adapter: a.name.clone() },
    )
}

fn missing(adapters: &[AdapterReport]) -> Vec<Missing> {
    if adapters.iter().any(|a| a.backend == "vulkan") {
        return Vec::new();
    }
    let loader = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"]
        .iter()
        .any(|folder| Path::new(folder).join("libvulkan.so.1").exists());
    let what = if loader { "a Vulkan driver" } else { "the Vulkan loader and a driver" };
    let way = if automatic(adapters).is_some() { "through OpenGL" } else { "on the CPU" };
    vec![Missing {
        what: what.into(),
        consequence: format!("frames are rendered {way}; everything works"),
        install:
            "apt-get install libvulkan1 mesa-vulkan-drivers (Debian, Ubuntu: software and most hardware)"
                .into(),
    }]
}

/// Widest instruction set that the CPU path will use.
fn simd() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx2") { "avx2" } else { "sse2" }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        "default"
    }
}

fn print(findings: &Findings) {
    say_line!(
        "shadowgauge {}, {} threads, CPU path with {}",
        findings.version,
        findings.threads,
        findings.simd
    );
    for a in &findings.adapters {
        say_line!("adapter: {} ({}, {}), driver {}", a.name, a.backend, a.kind, a.driver);
    }
    if let Some(auto) = &findings.auto {
        say_line!("auto takes: {} ({})", auto.backend, auto.adapter);
    }
    for m in &findings.missing {
        say_line!("missing: {}: {}\n  install: {}", m.what, m.consequence, m.install);
    }
    if findings.missing.is_empty() {
        say_line!("nothing is missing");
    }
    if let Some(cameras) = &findings.cameras {
        cameras.print();
    }
}
