//! Scenes: the frames of every kind, made once, the same for every variant, and as bytes for the
//! processes that measure them.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::draw::{Camera, Random};
use super::kinds::{self, Kind, Source};
use crate::frame::{Buffer, Frame, FrameError, FrameMeta, PixelFormat, Pixels};
use crate::render::Renderer;
use crate::studies::calibration::CalibrateError;
use crate::studies::coverage::{Recorded, record};
use crate::studies::dirty_frames::{Bump, COLUMNS, DrawError, PIXEL_UM, Piece, STATION, step};

/// Frames of a flat-field scene: dark ones, and two at each exposure; shafts follow.
pub(super) const DARKS: usize = 4;
pub(super) const EXPOSURES: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Frames of the masters of a coverage scene.
pub(super) const PINS: usize = 6;
/// Rows and columns of a flat-field scene.
const FLAT_SIZE: (usize, usize) = (96, 128);
/// Width of its shaft, px.
const FLAT_WIDTH: f64 = 40.3;

/// Why scenes cannot be made or read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SceneError {
    /// A frame cannot be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// A frame has no pixels.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A setup of the coverage study cannot be rendered.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// Bytes that are no scenes of this program.
    #[error("the scenes cannot be read: {0}")]
    Bytes(String),
}

/// Frames of one scene, and what is true of them.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(super) kind: Kind,
    pub(super) seed: u64,
    pub(super) frames: Vec<Frame>,
    /// True values of every frame, px; NaN where no one value is true, none where no part is.
    pub(super) truth: Vec<Vec<f64>>,
}

/// Makes `each` scenes of every kind whose name `pick` accepts, half as many of setups with
/// masters.
///
/// # Errors
/// A scene that cannot be drawn.
pub(crate) fn make(
    each: usize,
    seed: u64,
    renderer: &Renderer,
    pick: impl Fn(&str) -> bool,
) -> Result<Vec<Scene>, SceneError> {
    let picked = kinds::all().into_iter().filter(|kind| pick(kind.name));
    let orders: Vec<(Kind, u64)> = picked
        .flat_map(|kind| (0..count(&kind, each)).map(move |number| (kind, seed_of(kind.name, number, seed))))
        .collect();
    orders.into_par_iter().map(|(kind, seed)| scene(kind, seed, renderer)).collect()
}

/// Scenes of a kind: of setups with masters, whose seven frames and calibration take most of the
/// time, half as many.
fn count(kind: &Kind, each: usize) -> u64 {
    let count = if matches!(kind.source, Source::Class(_)) { each.div_ceil(2) } else { each };
    count as u64
}

/// Names of the kinds.
pub(crate) fn kind_names() -> Vec<&'static str> {
    kinds::all().iter().map(|kind| kind.name).collect()
}

/// Seed of a scene: another one for every kind, number and seed of the study (FNV-1a).
fn seed_of(name: &str, number: u64, seed: u64) -> u64 {
    let bytes = name.bytes().chain(number.to_le_bytes()).chain(seed.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn scene(kind: Kind, seed: u64, renderer: &Renderer) -> Result<Scene, SceneError> {
    let (frames, truth) = match kind.source {
        Source::Look(look) => look.draw(seed)?,
        Source::FlatField => flat_field(seed)?,
        Source::Piece(contaminant) => {
            let piece = Piece::draw(seed);
            let frame = match contaminant {
                None => piece.frame(None)?,
                Some(contaminant) => piece.dirty(contaminant)?,
            };
            (vec![frame], vec![widths(&piece)])
        }
        Source::Film(height_um) => {
            let piece = Piece::draw(seed);
            let film = Bump {
                column: COLUMNS as f64 / 2.0,
                half_length: 40.0,
                height_px: height_um / PIXEL_UM,
                upper: seed.is_multiple_of(2),
            };
            (vec![piece.with_bumps(&[film]).frame(None)?], vec![widths(&piece)])
        }
        Source::Class(class) => {
            let Recorded { pins, part } = record(class, seed, renderer)?;
            ([pins, part].concat(), Vec::new())
        }
    };
    Ok(Scene { kind, seed, frames, truth })
}

/// True mean widths of a piece's stations, px.
fn widths(piece: &Piece) -> Vec<f64> {
    let width = |column: usize| piece.edges(column).1 - piece.edges(column).0;
    let mean = |s: usize| (s * STATION..(s + 1) * STATION).map(width).sum::<f64>() / STATION as f64;
    (0..COLUMNS / STATION).map(mean).collect()
}

/// A 12-bit sensor with black levels and responses of its own a pixel, a few defects and a bent
/// response: dark and flat fields, and two shafts.
fn flat_field(seed: u64) -> Result<(Vec<Frame>, Vec<Vec<f64>>), FrameError> {
    let camera = Camera { format: PixelFormat::Mono12, clip: 4095.0, ..Camera::EIGHT };
    let mut random = Random::new(seed);
    let (rows, columns) = FLAT_SIZE;
    let pixels: Vec<(f64, f64)> = (0..rows * columns)
        .map(|_| match random.within((0.0, 1.0)) {
            draw if draw < 0.001 => (1.0, 0.0),
            draw if draw < 0.002 => (0.02, 0.0),
            _ => (0.02 + 0.001 * random.normal(), 1.0 + 0.01 * random.normal()),
        })
        .collect();
    let exponent = random.within((0.8, 1.0));
    let place = 30.0 + random.within((-0.5, 0.5));
    let level = |row: usize, column: usize, light: f64| {
        let (r, c) = (row as f64 / rows as f64 - 0.5, column as f64 / columns as f64 - 0.5);
        let (black, response) = pixels[row * columns + column];
        black + response * 0.9 * (light * (1.0 - 0.4 * (r * r + c * c))).powf(exponent)
    };
    let mut frames = Vec::new();
    let exposures = [0.0; DARKS].into_iter().chain(EXPOSURES.into_iter().flat_map(|e| [e, e]));
    for light in exposures {
        frames.push(camera.expose(FLAT_SIZE, &mut random, |row, column| level(row, column, light))?);
    }
    for _ in 0..2 {
        let shaft = |row: usize, column: usize| {
            let top = place + 0.02 * column as f64;
            let lit = step(top - row as f64, 1.0) + step(row as f64 - top - FLAT_WIDTH, 1.0);
            level(row, column, 0.75 * (0.06 + 0.94 * lit))
        };
        frames.push(camera.expose(FLAT_SIZE, &mut random, shaft)?);
    }
    let mut truth = vec![Vec::new(); DARKS + 2 * EXPOSURES.len()];
    truth.extend(vec![vec![FLAT_WIDTH; columns / super::look::STATION]; 2]);
    Ok((frames, truth))
}

/// What of a frame stands before its pixels.
#[derive(Serialize, Deserialize)]
struct FrameHead {
    format: PixelFormat,
    rows: usize,
    columns: usize,
    full_scale: Option<f32>,
    frame_id: u64,
    angle_deg: f64,
}

/// What of a scene stands before its frames' pixels.
#[derive(Serialize, Deserialize)]
struct SceneHead {
    kind: String,
    seed: u64,
    /// JSON has no NaN: none stands for it.
    truth: Vec<Vec<Option<f64>>>,
    frames: Vec<FrameHead>,
}

/// Scenes as bytes: the length of a JSON text, the text, the pixels of all frames.
///
/// # Errors
/// Heads that cannot be written as JSON.
pub(crate) fn to_bytes(scenes: &[Scene]) -> Result<Vec<u8>, SceneError> {
    let heads: Vec<SceneHead> = scenes.iter().map(head).collect();
    let text = serde_json::to_vec(&heads).map_err(|e| SceneError::Bytes(e.to_string()))?;
    let mut bytes = (text.len() as u64).to_le_bytes().to_vec();
    bytes.extend(text);
    for frame in scenes.iter().flat_map(|scene| &scene.frames) {
        match frame.view().pixels() {
            Pixels::U8(pixels) => bytes.extend_from_slice(pixels),
            Pixels::U16(pixels) => bytes.extend_from_slice(bytemuck::cast_slice(pixels)),
            Pixels::F32(pixels) => bytes.extend_from_slice(bytemuck::cast_slice(pixels)),
        }
    }
    Ok(bytes)
}

fn head(scene: &Scene) -> SceneHead {
    let of_frame = |frame: &Frame| {
        let view = frame.view();
        FrameHead {
            format: view.format(),
            rows: view.rows(),
            columns: view.columns(),
            full_scale: view
                .full_scale()
                .filter(|full| Some(*full) != view.format().full_scale().map(f32::from)),
            frame_id: frame.meta.frame_id,
            angle_deg: frame.meta.angle_deg,
        }
    };
    let values = |values: &Vec<f64>| values.iter().map(|v| v.is_finite().then_some(*v)).collect();
    SceneHead {
        kind: scene.kind.name.to_owned(),
        seed: scene.seed,
        truth: scene.truth.iter().map(values).collect(),
        frames: scene.frames.iter().map(of_frame).collect(),
    }
}

/// Scenes of bytes that [`to_bytes`] gave.
///
/// # Errors
/// Bytes that are no scenes of this program.
pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Vec<Scene>, SceneError> {
    let refused = |what: &str| SceneError::Bytes(what.to_owned());
    let (length, rest) = bytes.split_first_chunk::<8>().ok_or_else(|| refused("no length"))?;
    let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
    let (text, mut pixels) =
        rest.split_at_checked(length).ok_or_else(|| refused("they end within the heads"))?;
    let heads: Vec<SceneHead> = serde_json::from_slice(text).map_err(|e| SceneError::Bytes(e.to_string()))?;
    let kinds = kinds::all();
    let mut scenes = Vec::with_capacity(heads.len());
    for SceneHead { kind, seed, truth, frames } in heads {
        let kind =
            kinds.iter().find(|k| k.name == kind).ok_or_else(|| refused("a kind that is not there"))?;
        let frames = frames.iter().map(|head| frame(head, &mut pixels)).collect::<Result<_, _>>()?;
        let truth = truth.iter().map(|of| of.iter().map(|v| v.unwrap_or(f64::NAN)).collect()).collect();
        scenes.push(Scene { kind: *kind, seed, frames, truth });
    }
    Ok(scenes)
}

/// The next frame of the pixels.
fn frame(head: &FrameHead, pixels: &mut &[u8]) -> Result<Frame, SceneError> {
    let depth = match head.format {
        PixelFormat::Mono8 => 1,
        PixelFormat::F32 => 4,
        _ => 2,
    };
    let needed = head.rows.saturating_mul(head.columns).saturating_mul(depth);
    let ends = || SceneError::Bytes("they end within the pixels".to_owned());
    let (own, rest) = pixels.split_at_checked(needed).ok_or_else(ends)?;
    *pixels = rest;
    let buffer = match head.format {
        PixelFormat::Mono8 => Buffer::U8(own.to_vec()),
        PixelFormat::F32 => {
            Buffer::F32(own.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect())
        }
        _ => Buffer::U16(own.chunks_exact(2).map(|b| u16::from_ne_bytes([b[0], b[1]])).collect()),
    };
    let meta = FrameMeta { frame_id: head.frame_id, angle_deg: head.angle_deg, ..FrameMeta::default() };
    let frame = Frame::new(buffer, head.format, head.rows, head.columns, meta)?;
    Ok(match head.full_scale {
        Some(full) => frame.with_full_scale(full),
        None => frame,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::BackendChoice;

    #[test]
    fn scenes_come_back_from_their_bytes() {
        let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        let pick = |name: &str| ["plain", "plain, float", "plain, 12 bits", "stepped"].contains(&name);
        let scenes = make(2, 5, &renderer, pick).unwrap();
        assert_eq!(scenes.len(), 8);
        let back = from_bytes(&to_bytes(&scenes).unwrap()).unwrap();
        for (one, two) in scenes.iter().zip(&back) {
            assert_eq!((one.kind.name, one.seed, &one.frames), (two.kind.name, two.seed, &two.frames));
            assert_eq!(format!("{:?}", one.truth), format!("{:?}", two.truth));
        }
        assert!(from_bytes(&[1, 2]).is_err() && from_bytes(&99_u64.to_le_bytes()).is_err());
    }
}
