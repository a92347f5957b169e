//! Buffers of a frame size, in the order of the shader's bindings.

use std::sync::mpsc;

use bytemuck::cast_slice;

use super::super::error::RenderError;
use crate::render::kernel::job::Job;
use crate::render::kernel::params::{FILL_ROWS, Params};

/// Most nodes of the quadrature over a pixel, 8 × 8.
const MOST_NODES: u64 = 64;

/// Longest edge-spread table in a uniform buffer, as in the shader.
pub(super) const ESF_UNIFORM_SEGMENTS: usize = 1024;

/// Buffers kept while the frame size stays the same.
pub(super) struct Buffers {
    pub(super) group: wgpu::BindGroup,
    size: Size,
    inputs: [wgpu::Buffer; 6],
    light: wgpu::Buffer,
    frame_bytes: u64,
    image: wgpu::Buffer,
    readback: Option<wgpu::Buffer>,
}

/// Bytes of every binding.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Size([u64; 8]);

impl Size {
    fn of(job: &Job<'_>) -> Self {
        let bytes = |count: usize, each: usize| (count * each) as u64;
        Self([
            size_of::<Params>() as u64,
            bytes(job.columns.len(), size_of::<crate::render::kernel::column_edges::Column>()),
            bytes(job.bands.start.len(), 8),
            MOST_NODES * 16,
            bytes(ESF_UNIFORM_SEGMENTS, 16),
            bytes(job.esf.segments.len() + job.profiles.len(), 16),
            // Whole steps of `fill`, which also writes rows beyond the last one.
            u64::from(job.params.size.words)
                * u64::from(job.params.size.rows.next_multiple_of(FILL_ROWS))
                * 4,
            bytes(light_words(job).len().max(4), 4),
        ])
    }
}

/// Bytes of the largest buffer that a job needs.
pub(super) fn largest_bytes(job: &Job<'_>) -> u64 {
    Size::of(job).0.into_iter().max().unwrap_or(0)
}

/// Factors of the contamination; none where nothing dims the light.
fn light_words<'a>(job: &'a Job<'_>) -> &'a [u32] {
    job.contamination.as_ref().map_or(&[], |map| &map.words)
}

/// Rows whose factors the kernels read: those above and below the shadow.
fn lit_rows(job: &Job<'_>) -> [std::ops::Range<u32>; 2] {
    let p = &job.params;
    if light_words(job).is_empty() {
        return [0..0, 0..0];
    }
    let from = (p.dark.from * FILL_ROWS).min(p.size.rows);
    if p.dark.steps == 0 {
        return [0..p.size.rows, 0..0];
    }
    [0..from, from + p.dark.steps * FILL_ROWS..p.size.rows]
}

/// The bind-group layout: uniforms (parameters, quadrature, short tables), read-only buffers, the
/// image.
pub(super) fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding: u32| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding {
                0 | 3 | 4 => wgpu::BufferBindingType::Uniform,
                6 => wgpu::BufferBindingType::Storage { read_only: false },
                _ => wgpu::BufferBindingType::Storage { read_only: true },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("shadowgraph"),
        entries: &std::array::from_fn::<_, 8, _>(|i| entry(i as u32)),
    })
}

impl Buffers {
    pub(super) fn new(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        job: &Job<'_>,
        mappable: bool,
    ) -> Self {
        use wgpu::BufferUsages as Use;
        let size = Size::of(job);
        let buffer = |size: u64, usage: Use| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let inputs = std::array::from_fn(|i| {
            let usage = if matches!(i, 0 | 3 | 4) { Use::UNIFORM } else { Use::STORAGE };
            buffer(size.0[i], usage | Use::COPY_DST)
        });
        let light = buffer(size.0[7], Use::STORAGE | Use::COPY_DST);
        let image_use = if mappable { Use::STORAGE | Use::MAP_READ } else { Use::STORAGE | Use::COPY_SRC };
        let image = buffer(size.0[6], image_use);
        let readback = (!mappable).then(|| buffer(size.0[6], Use::MAP_READ | Use::COPY_DST));
        let entries: Vec<_> = inputs
            .iter()
            .chain([&image, &light])
            .enumerate()
            .map(|(i, b): (usize, &wgpu::Buffer)| wgpu::BindGroupEntry {
                binding: i as u32,
                resource: b.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadowgraph"),
            layout,
            entries: &entries,
        });
        let frame_bytes = u64::from(job.params.size.words) * u64::from(job.params.size.rows) * 4;
        Self { group, size, inputs, light, frame_bytes, image, readback }
    }

    /// Whether the job has exactly this size.
    pub(super) fn fits(&self, job: &Job<'_>) -> bool {
        self.size == Size::of(job)
    }

    pub(super) fn upload(&self, queue: &wgpu::Queue, job: &Job<'_>) {
        let segments = job.esf.segments.as_slice();
        let (short, long): (&[_], &[_]) =
            if segments.len() <= ESF_UNIFORM_SEGMENTS { (segments, &[]) } else { (&[], segments) };
        let parts: [&[u8]; 6] = [
            bytemuck::bytes_of(&job.params),
            cast_slice(&job.columns),
            cast_slice(&job.bands.start),
            cast_slice(&job.quadrature),
            cast_slice(short),
            cast_slice(long),
        ];
        for (buffer, bytes) in self.inputs.iter().zip(parts) {
            if !bytes.is_empty() {
                queue.write_buffer(buffer, 0, bytes);
            }
        }
        for rows in lit_rows(job) {
            let each = job.params.light.words as usize;
            let words = &light_words(job)[rows.start as usize * each..rows.end as usize * each];
            if !words.is_empty() {
                queue.write_buffer(&self.light, 4 * u64::from(rows.start) * each as u64, cast_slice(words));
            }
        }
        if !job.profiles.is_empty() {
            queue.write_buffer(
                &self.inputs[5],
                16 * job.esf.segments.len() as u64,
                cast_slice(&job.profiles),
            );
        }
    }

    pub(super) fn copy_out(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(readback) = &self.readback {
            encoder.copy_buffer_to_buffer(&self.image, 0, readback, 0, self.frame_bytes);
        }
    }

    /// Waits for the image and passes its words to `read`.
    pub(super) fn read<R>(
        &self,
        device: &wgpu::Device,
        read: impl FnOnce(&[u32]) -> R,
    ) -> Result<R, RenderError> {
        let failed = |what: String| RenderError::Device { what };
        let source = self.readback.as_ref().unwrap_or(&self.image);
        let (sender, receiver) = mpsc::channel();
        source.map_async(wgpu::MapMode::Read, ..self.frame_bytes, move |result| {
            let _ = sender.send(result);
        });
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(e.to_string()))?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(failed(e.to_string())),
            Err(_) => return Err(failed("the image was never delivered".into())),
        }
        let result = {
            let view = source.get_mapped_range(..self.frame_bytes).map_err(|e| failed(e.to_string()))?;
            read(cast_slice(&view))
        };
        source.unmap();
        Ok(result)
    }
}
