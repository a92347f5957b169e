//! `shadowgauge render --gallery`: a frame of every kind that can be drawn, and a contact sheet of
//! all.

use std::path::Path;

use crate::config;
use crate::files::OutputFolder;
use crate::frame::{Frame, PixelFormat};
use crate::job::Job;
use crate::render::{FrameRequest, Renderer};

use super::args::{RenderArgs, scene};
use super::folder_files::{of_render, put};
use super::frame_files::{FileFormat, encode, encode_mask, write_grey};
use super::gallery_cases::{CASES, Case};
use super::label_font;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;

/// Pictures side by side on the sheet.
const ACROSS: usize = 5;

/// Frame pixels averaged into one of the sheet's, along either side.
const REDUCTION: usize = 2;

/// White gap between pictures, px.
const GAP: usize = 6;

/// Grey value of the brightest light on the sheet, so that the field is bright but not saturated.
const BRIGHTEST: f32 = 225.0;

/// Draws the gallery into `out`.
///
/// # Errors
/// Exit 2 for a folder that is taken, 3 for a device or a disk that fails.
pub(super) fn gallery(args: &RenderArgs, out: &Path) -> CommandResult {
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let folder = OutputFolder::claim(out)?;
    draw_all(&renderer, &folder)?;
    folder.finish()?;
    say_line!(
        "{} frames and contact_sheet.png by {} ({}) in {}",
        CASES.len(),
        renderer.backend_name(),
        renderer.adapter_name(),
        out.display()
    );
    Ok(Outcome::Done)
}

fn draw_all(renderer: &Renderer, folder: &OutputFolder) -> Result<(), Failure> {
    let mut tiles = Vec::new();
    let bar = progress::bar(CASES.len() as u64, "drawing", "frames");
    for case in CASES {
        let text = case.toml();
        let job = config::parse(&text, case.name).map_err(Failure::refused)?;
        put(folder, &format!("{}.toml", case.name), Ok(text.into_bytes()))?;
        let (frame, mask) = draw(renderer, &job, case)?;
        put(folder, &format!("{}.png", case.name), encode(&frame, FileFormat::Png16, case.um_per_px))?;
        if let Some(mask) = mask {
            let bytes = encode_mask(&frame.view(), &mask, case.um_per_px);
            put(folder, &format!("{}_mask.png", case.name), bytes)?;
        }
        tiles.push(tile(&frame, case, &job));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let (picture, columns) = sheet(&tiles);
    put(folder, "contact_sheet.png", write_grey(columns, &picture))
}

fn draw(renderer: &Renderer, job: &Job, case: &Case) -> Result<(Frame, Option<Vec<u8>>), Failure> {
    let scene = scene(job)?;
    let request = FrameRequest {
        z_mm: 0.5 * job.part.length_mm,
        angle_deg: case.angle_deg,
        noise: true,
        seed: job.seed,
        format: Some(PixelFormat::Mono12),
        ..FrameRequest::default()
    };
    renderer.render_masked(&scene, &request, None).map_err(of_render)
}

/// A reduced picture of a frame.
struct Tile {
    rows: usize,
    columns: usize,
    grey: Vec<u8>,
    label: &'static str,
}

fn tile(frame: &Frame, case: &Case, job: &Job) -> Tile {
    let view = frame.view();
    let (rows, columns) = (view.rows() / REDUCTION, view.columns() / REDUCTION);
    let mean = |r: usize, c: usize| {
        let near = (0..REDUCTION).flat_map(|i| (0..REDUCTION).map(move |j| (i, j)));
        let sum: f32 = near.filter_map(|(i, j)| view.get(REDUCTION * r + i, REDUCTION * c + j)).sum();
        sum / (REDUCTION * REDUCTION) as f32
    };
    let values: Vec<f32> =
        (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))).map(|(r, c)| mean(r, c)).collect();
    let (dark, bright) = if case.stretched {
        values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
    } else {
        (job.sensor.black_level_counts as f32, job.light.bright_counts as f32)
    };
    let grey = |v: &f32| ((v - dark) / (bright - dark).max(1.0) * BRIGHTEST).clamp(0.0, 255.0) as u8;
    Tile { rows, columns, grey: values.iter().map(grey).collect(), label: case.label }
}

/// All pictures with their labels, and the sheet's columns.
fn sheet(tiles: &[Tile]) -> (Vec<u8>, usize) {
    let (high, wide) = tiles.iter().fold((0, 0), |(h, w), t| (t.rows.max(h), t.columns.max(w)));
    let pitch = [high + label_font::HEIGHT + 2 * GAP, wide + GAP];
    let columns = ACROSS * pitch[1] + GAP;
    let rows = tiles.len().div_ceil(ACROSS) * pitch[0] + GAP;
    let mut picture = vec![255; rows * columns];
    for (i, tile) in tiles.iter().enumerate() {
        let (row, column) = (GAP + i / ACROSS * pitch[0], GAP + i % ACROSS * pitch[1]);
        for (r, line) in tile.grey.chunks_exact(tile.columns.max(1)).enumerate() {
            let at = (row + r) * columns + column;
            picture[at..at + line.len()].copy_from_slice(line);
        }
        label_font::write(&mut picture, columns, [row + tile.rows + GAP / 2, column], tile.label);
    }
    (picture, columns)
}
