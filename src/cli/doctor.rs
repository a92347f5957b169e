//! `shadowgauge doctor`: adapters, drivers, what `auto` would choose, what is missing and how to install it.

use std::path::Path;

use crate::render::gpu::{AdapterReport, adapter_reports};
use crate::render::{BackendChoice, Renderer};

use super::{CommandResult, Outcome};

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct DoctorArgs {
    /// Print the findings as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, serde::Serialize)]
struct Findings {
    version: &'static str,
    threads: usize,
    simd: &'static str,
    adapters: Vec<AdapterReport>,
    auto: Choice,
    missing: Vec<Missing>,
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

/// Looks at the machine and says what it found; never fails for what is missing.
///
/// # Errors
/// None.
pub fn run(args: &DoctorArgs) -> CommandResult {
    let findings = look();
    if args.json {
        say_line!("{}", serde_json::to_string_pretty(&findings).unwrap_or_default());
    } else {
        print(&findings);
    }
    Ok(Outcome::Done)
}

fn look() -> Findings {
    let adapters = adapter_reports();
    let auto = match Renderer::new(BackendChoice::Auto) {
        Ok(r) => Choice { backend: r.backend_name().into(), adapter: r.adapter_name().into() },
        Err(e) => Choice { backend: "none".into(), adapter: e.to_string() },
    };
    Findings {
        version: env!("CARGO_PKG_VERSION"),
        threads: rayon::current_num_threads(),
        simd: simd(),
        missing: missing(&adapters),
        auto,
        adapters,
    }
}

fn missing(adapters: &[AdapterReport]) -> Vec<Missing> {
    if adapters.iter().any(|a| a.backend == "vulkan") {
        return Vec::new();
    }
    let loader = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"]
        .iter()
        .any(|folder| Path::new(folder).join("libvulkan.so.1").exists());
    let what = if loader { "a Vulkan driver" } else { "the Vulkan loader and a driver" };
    vec![Missing {
        what: what.into(),
        consequence: if adapters.is_empty() {
            "frames are rendered on the CPU; everything works".into()
        } else {
            "frames are rendered through OpenGL; everything works".into()
        },
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
    say_line!("auto takes: {} ({})", findings.auto.backend, findings.auto.adapter);
    for m in &findings.missing {
        say_line!("missing: {}: {}\n  install: {}", m.what, m.consequence, m.install);
    }
    if findings.missing.is_empty() {
        say_line!("nothing is missing");
    }
}
