//! One renderer for the process: a wgpu device, or the CPU twin where there is none or it is
//! requested.

use std::sync::{Mutex, OnceLock, PoisonError};

use super::error::RenderError;
use super::gpu::{Api, Gpu, Work};
use crate::frame::{Buffer, Frame, PixelFormat};
use crate::render::kernel::cpu;
use crate::render::kernel::job::Job;
use crate::render::kernel::readout::{DrawnMeans, read_out};
use crate::render::kernel::readout_terms::Readout;
use crate::render::scene::frame_job::frame_job;
use crate::render::scene::request::FrameRequest;
use crate::render::scene::scene::Scene;

/// What renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum BackendChoice {
    /// A hardware adapter; the CPU twin where there is none.
    #[default]
    Auto,
    /// A Vulkan adapter or an error.
    Vulkan,
    /// An OpenGL (ES) adapter or an error.
    Gl,
    /// The CPU twin.
    Cpu,
}

/// A renderer; may be shared between threads, renders one frame at a time on a device.
#[derive(Debug)]
pub struct Renderer {
    engine: Engine,
    backend: String,
    adapter: String,
    lost: OnceLock<String>,
    refused: OnceLock<()>,
    strict: bool,
}

/// Fault injection: number of frames after which the device is lost.
const LOSE_DEVICE_AFTER: &str = "SHADOWGAUGE_LOSE_DEVICE_AFTER";

/// Fault injection: the adapter's largest buffer, bytes.
const LARGEST_BUFFER: &str = "SHADOWGAUGE_LARGEST_BUFFER";

#[derive(Debug)]
enum Engine {
    Device(Box<Mutex<Gpu>>),
    Twin,
}

impl Renderer {
    /// Opens the requested backend and logs the adapter.
    ///
    /// # Errors
    /// When Vulkan or GL is requested and offers no adapter. `auto` chooses a hardware adapter,
    /// otherwise the CPU twin; software adapters are used only where Vulkan or GL is requested.
    ///
    /// A device that fails later does not end the run: it continues on the CPU twin, which is
    /// reported once and in `Self::adapter_name`. To test that, `SHADOWGAUGE_LOSE_DEVICE_AFTER=N`
    /// destroys the device after N frames. Frames larger than the adapter's buffers are rendered by
    /// the twin, which is reported once (`SHADOWGAUGE_LARGEST_BUFFER=BYTES` to test it). Every
    /// adapter supports all pixel formats: images are plain buffers of packed words.
    pub fn new(choice: BackendChoice) -> Result<Self, RenderError> {
        let renderer = match choice {
            BackendChoice::Auto => Self::automatic(),
            BackendChoice::Vulkan => Self::device(Gpu::open(Api::Vulkan)?),
            BackendChoice::Gl => Self::device(Gpu::open(Api::Gl)?),
            BackendChoice::Cpu => Self::twin(),
        };
        tracing::info!("rendering with {} on {}", renderer.backend, renderer.adapter);
        Ok(renderer)
    }

    /// A hardware adapter, or the CPU twin: without a warning where there is no adapter, with one
    /// where the adapter does not work.
    fn automatic() -> Self {
        match Gpu::open_hardware() {
            Ok(Some(gpu)) => Self::device(gpu),
            Ok(None) => Self::twin(),
            Err(e) => {
                tracing::warn!("rendering on the CPU: {e}");
                Self::twin()
            }
        }
    }

    fn twin() -> Self {
        Self {
            engine: Engine::Twin,
            backend: "cpu".into(),
            adapter: "CPU twin".into(),
            lost: OnceLock::new(),
            refused: OnceLock::new(),
            strict: false,
        }
    }

    fn device(mut gpu: Gpu) -> Self {
        let (backend, adapter) = (gpu.info().backend.to_string(), gpu.info().name.clone());
        if let Some(frames) = std::env::var(LOSE_DEVICE_AFTER).ok().and_then(|n| n.parse().ok()) {
            gpu.lose_after(frames);
        }
        if let Some(bytes) = std::env::var(LARGEST_BUFFER).ok().and_then(|n| n.parse().ok()) {
            gpu.limit_buffers(bytes);
        }
        let engine = Engine::Device(Box::new(Mutex::new(gpu)));
        Self { engine, backend, adapter, lost: OnceLock::new(), refused: OnceLock::new(), strict: false }
    }

    /// The same renderer, for which a device that fails is an error: for comparisons of the device
    /// with the twin.
    #[must_use]
    pub(crate) fn strict(self) -> Self {
        Self { strict: true, ..self }
    }

    /// `vulkan`, `gl` or `cpu`.
    pub(crate) fn backend_name(&self) -> &str {
        &self.backend
    }

    /// The adapter's name, or `CPU twin`; both where the device was lost during the run.
    pub(crate) fn adapter_name(&self) -> &str {
        self.lost.get().unwrap_or(&self.adapter)
    }

    /// Runs the job on the device, where there is one that is not lost; `false` where the twin must
    /// run it.
    fn on_device(&self, job: &Job<'_>, work: Work, buffer: &mut Buffer) -> Result<bool, RenderError> {
        let Engine::Device(gpu) = &self.engine else { return Ok(false) };
        if self.lost.get().is_some() {
            return Ok(false);
        }
        let mut gpu = gpu.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(e) = gpu.holds(job) {
            if self.strict {
                return Err(e);
            }
            if self.refused.set(()).is_ok() {
                tracing::warn!("{e}: frames of this size are drawn by the CPU twin");
            }
            return Ok(false);
        }
        match gpu.run(job, work, |words| unpack(job, words, buffer)) {
            Ok(()) => Ok(true),
            Err(e) if self.strict => Err(e),
            Err(e) => {
                if self.lost.get().is_none() {
                    tracing::warn!("{e}; the run goes on with the CPU twin");
                }
                let adapter = format!("{}, lost on the way, then the CPU twin", self.adapter);
                let _ = self.lost.set(adapter);
                Ok(false)
            }
        }
    }

    /// Renders a frame of a scene into the allocation of `reuse`.
    ///
    /// # Errors
    /// Refuses windows outside the sensor and shafts outside the field; fails with the device.
    pub fn render(
        &self,
        scene: &Scene,
        request: &FrameRequest,
        reuse: Option<Frame>,
    ) -> Result<Frame, RenderError> {
        Ok(self.frame(scene, request, reuse, false)?.0)
    }

    /// [`Self::render`] with the truth of the contamination: bits of [`super::contamination::mask`]
    /// for every pixel of the frame, row-major; `None` where the scene is clean.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub(crate) fn render_masked(
        &self,
        scene: &Scene,
        request: &FrameRequest,
        reuse: Option<Frame>,
    ) -> Result<(Frame, Option<Vec<u8>>), RenderError> {
        self.frame(scene, request, reuse, true)
    }

    fn frame(
        &self,
        scene: &Scene,
        request: &FrameRequest,
        reuse: Option<Frame>,
        with_mask: bool,
    ) -> Result<(Frame, Option<Vec<u8>>), RenderError> {
        let mut job = frame_job(scene, request, with_mask)?;
        let buffer = self.draw(&job, reuse.map(Frame::into_buffer))?;
        let (format, rows, columns) = job.output();
        let frame = Frame::new(buffer, format, rows, columns, scene.setup().meta(request))
            .map_err(|e| RenderError::Device { what: e.to_string() })?;
        let contamination = job.contamination.take();
        let mask = contamination.map(|map| scene.setup().recycle(map));
        Ok((frame, mask.map(|mask| within_frame(&job, mask))))
    }

    /// Renders a job into a buffer of its format.
    ///
    /// # Errors
    /// When the device fails and the renderer is strict.
    pub fn draw(&self, job: &Job<'_>, reuse: Option<Buffer>) -> Result<Buffer, RenderError> {
        let Some(readout) = &job.readout else { return self.drawn(job, reuse) };
        let means = self.drawn(job, None)?;
        Ok(read(job, readout, &means, reuse))
    }

    /// What the kernel draws of a job.
    fn drawn(&self, job: &Job<'_>, reuse: Option<Buffer>) -> Result<Buffer, RenderError> {
        let mut buffer = fitting((job.format, pixels_of(job)), reuse);
        if !self.on_device(job, Work::Frame, &mut buffer)? {
            match &mut buffer {
                Buffer::U8(p) => cpu::render(job, p),
                Buffer::U16(p) => cpu::render(job, p),
                Buffer::F32(p) => cpu::render(job, p),
            }
        }
        Ok(buffer)
    }

    /// Writes one constant instead of a frame: the write floor, with which a frame's time is
    /// compared.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub(crate) fn draw_constant(&self, job: &Job<'_>, reuse: Option<Buffer>) -> Result<Buffer, RenderError> {
        let mut buffer = fitting((job.format, pixels_of(job)), reuse);
        if !self.on_device(job, Work::Constant, &mut buffer)? {
            match &mut buffer {
                Buffer::U8(p) => cpu::constant(job, p),
                Buffer::U16(p) => cpu::constant(job, p),
                Buffer::F32(p) => cpu::constant(job, p),
            }
        }
        Ok(buffer)
    }
}

/// Pixels that the kernel draws.
fn pixels_of(job: &Job<'_>) -> usize {
    job.params.size.rows as usize * job.params.size.columns as usize
}

/// The frame that a sensor reads out of drawn means.
fn read(job: &Job<'_>, readout: &Readout, means: &Buffer, reuse: Option<Buffer>) -> Buffer {
    let (format, rows, columns) = job.output();
    let mut buffer = fitting((format, rows * columns), reuse);
    let Buffer::F32(counts) = means else { return buffer };
    let (rows, columns) = (job.params.size.rows as usize, job.params.size.columns as usize);
    let drawn = DrawnMeans { counts, rows, columns };
    match &mut buffer {
        Buffer::U8(p) => read_out(readout, &drawn, p),
        Buffer::U16(p) => read_out(readout, &drawn, p),
        Buffer::F32(p) => read_out(readout, &drawn, p),
    }
    buffer
}

/// The part of a drawn mask that the frame shows.
fn within_frame(job: &Job<'_>, mask: Vec<u8>) -> Vec<u8> {
    let Some(readout) = &job.readout else { return mask };
    let drawn = job.params.size.columns as usize;
    if mask.is_empty() {
        return mask;
    }
    let (first, count) = (readout.first_column, readout.column_gain.len());
    let line = |row: usize| mask[row * drawn + first..][..count].iter().copied();
    readout.rows.iter().flat_map(|row| line(row.drawn)).collect()
}

/// A buffer of a format and a number of pixels, the old allocation where it fits.
fn fitting((format, count): (PixelFormat, usize), reuse: Option<Buffer>) -> Buffer {
    match (format, reuse) {
        (PixelFormat::Mono8, Some(Buffer::U8(mut p))) => {
            p.resize(count, 0);
            Buffer::U8(p)
        }
        (PixelFormat::F32, Some(Buffer::F32(mut p))) => {
            p.resize(count, 0.0);
            Buffer::F32(p)
        }
        (PixelFormat::Mono8, _) => Buffer::U8(vec![0; count]),
        (PixelFormat::F32, _) => Buffer::F32(vec![0.0; count]),
        (_, Some(Buffer::U16(mut p))) => {
            p.resize(count, 0);
            Buffer::U16(p)
        }
        (_, _) => Buffer::U16(vec![0; count]),
    }
}

/// Copies packed rows into a frame's buffer, without the padding of the last word of a row.
fn unpack(job: &Job<'_>, words: &[u32], buffer: &mut Buffer) {
    let columns = job.params.size.columns as usize;
    let words_a_row = job.params.size.words as usize;
    match buffer {
        Buffer::U8(p) => unpack_rows(bytemuck::cast_slice(words), 4 * words_a_row, columns, p),
        Buffer::U16(p) => unpack_rows(bytemuck::cast_slice(words), 2 * words_a_row, columns, p),
        Buffer::F32(p) => unpack_rows(bytemuck::cast_slice(words), words_a_row, columns, p),
    }
}

fn unpack_rows<T: Copy>(packed: &[T], stride: usize, columns: usize, out: &mut [T]) {
    if stride == columns {
        out.copy_from_slice(&packed[..out.len()]);
        return;
    }
    for (line, source) in out.chunks_exact_mut(columns).zip(packed.chunks_exact(stride)) {
        line.copy_from_slice(&source[..columns]);
    }
}
