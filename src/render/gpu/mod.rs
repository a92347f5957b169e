//! The kernels on a wgpu device: one device for the process, buffers kept between frames.
//!
//! In: a [`Job`]. Out: its pixels. `adapters` lists devices and chooses one, `buffers` holds the
//! buffers of a frame. The shader is `shaders/shadowgraph.wgsl`; its CPU twin is `render::kernel`.

mod adapters;
mod buffers;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) use adapters::{AdapterReport, adapter_reports, automatic, was_opened};

use self::buffers::Buffers;
use super::error::RenderError;
use crate::render::kernel::job::Job;
use crate::render::kernel::params::{FILL_ROWS, pixels_per_word};

/// The shader, one file for all kernels of a shadowgraph.
pub(crate) const SHADER: &str = include_str!("../../../shaders/shadowgraph.wgsl");

/// Invocations of a workgroup along a row, as in the shader.
const GROUP: u32 = 64;

/// Which kernels to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Work {
    /// A frame: flat fields, then edges.
    Frame,
    /// One constant in every word: the write floor.
    Constant,
}

/// A device with its kernels.
pub(crate) struct Gpu {
    info: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    bindings: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    mappable: bool,
    pipelines: BTreeMap<Variant, Pipelines>,
    buffers: Option<Buffers>,
    failure: Arc<Mutex<Option<String>>>,
    frames_left: Option<u64>,
    largest_bytes: u64,
}

/// Values of the pipeline constants, in the order of [`OVERRIDES`].
type Variant = [u32; 8];

/// Names of the pipeline constants in the shader: pixels per word, fixed pattern, overlapping
/// bands, uneven light, stacked tables, profiles, nodes over a pixel, whether the edge-spread
/// tables lie in a uniform.
const OVERRIDES: [&str; 8] = [
    "pixels_per_word",
    "with_pattern",
    "with_overlap",
    "with_light",
    "with_stack",
    "with_profiles",
    "nodes",
    "esf_in_uniform",
];

fn variant(job: &Job<'_>) -> Variant {
    let p = &job.params;
    let (stack, profiles) = (u32::from(job.stacked), u32::from(!job.profiles.is_empty()));
    let small = u32::from(job.esf.segments.len() <= buffers::ESF_UNIFORM_SEGMENTS);
    [
        pixels_per_word(job.format),
        p.pixels.pattern,
        p.pixels.overlap,
        p.light.kind,
        stack,
        profiles,
        p.size.nodes,
        small,
    ]
}

struct Pipelines {
    shade: wgpu::ComputePipeline,
    fill: wgpu::ComputePipeline,
    band: wgpu::ComputePipeline,
    constant: wgpu::ComputePipeline,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gpu").field("adapter", &self.info.name).finish_non_exhaustive()
    }
}

/// The graphics interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Api {
    /// Vulkan.
    Vulkan,
    /// OpenGL (ES).
    Gl,
}

impl Gpu {
    /// Opens the best adapter of the interface given, hardware before software.
    ///
    /// # Errors
    /// When there is none, or the device cannot be opened or refuses the kernels.
    pub(crate) fn open(api: Api) -> Result<Self, RenderError> {
        Self::on(&adapters::best(api == Api::Gl)?)
    }

    /// Opens the best hardware adapter: Vulkan's, or OpenGL's where Vulkan offers no adapter at
    /// all; `None` where there is no hardware.
    ///
    /// # Errors
    /// When its device cannot be opened or refuses the kernels.
    pub(crate) fn open_hardware() -> Result<Option<Self>, RenderError> {
        adapters::hardware().map(|adapter| Self::on(&adapter)).transpose()
    }

    fn on(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        // Integrated and software adapters share the CPU's memory: reading the image in place saves
        // a copy.
        let unified = matches!(info.device_type, wgpu::DeviceType::Cpu | wgpu::DeviceType::IntegratedGpu);
        let mappable = unified && adapter.features().contains(wgpu::Features::MAPPABLE_PRIMARY_BUFFERS);
        let features =
            if mappable { wgpu::Features::MAPPABLE_PRIMARY_BUFFERS } else { wgpu::Features::empty() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("shadowgauge"),
            required_features: features,
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|e| RenderError::Device { what: e.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        watch(&device, &failure);
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("shadowgraph"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let bindings = buffers::layout(&device);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("shadowgraph"),
            bind_group_layouts: &[Some(&bindings)],
            immediate_size: 0,
        });
        if let Some(e) = pollster::block_on(scope.pop()) {
            return Err(RenderError::Device { what: e.to_string() });
        }
        let (pipelines, buffers) = (BTreeMap::new(), None);
        let limits = device.limits();
        let largest_bytes = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        Ok(Self {
            largest_bytes,
            info,
            device,
            queue,
            module,
            bindings,
            layout,
            mappable,
            pipelines,
            buffers,
            failure,
            frames_left: None,
        })
    }

    /// The adapter in use.
    pub(crate) fn info(&self) -> &wgpu::AdapterInfo {
        &self.info
    }

    /// Fault injection: the device is destroyed after `frames` more frames.
    pub(crate) fn lose_after(&mut self, frames: u64) {
        self.frames_left = Some(frames);
    }

    /// Fault injection: the adapter has no buffer of more than `bytes`.
    pub(crate) fn limit_buffers(&mut self, bytes: u64) {
        self.largest_bytes = self.largest_bytes.min(bytes);
    }

    /// Whether the adapter can hold the job.
    ///
    /// # Errors
    /// Names the size that it needs and the adapter's limit.
    pub(crate) fn holds(&self, job: &Job<'_>) -> Result<(), RenderError> {
        let needed = buffers::largest_bytes(job);
        if needed <= self.largest_bytes {
            return Ok(());
        }
        let (rows, columns) = (job.params.size.rows, job.params.size.columns);
        let most = self.largest_bytes;
        let what = format!(
            "a frame of {rows} x {columns} pixels needs a buffer of {needed} bytes, the adapter's largest has {most}"
        );
        Err(RenderError::TooLarge { what })
    }

    /// Runs the job's kernels and passes the packed words to `read`.
    ///
    /// # Errors
    /// When the device refuses the job or is lost.
    pub(crate) fn run<R>(
        &mut self,
        job: &Job<'_>,
        work: Work,
        read: impl FnOnce(&[u32]) -> R,
    ) -> Result<R, RenderError> {
        match &mut self.frames_left {
            Some(0) => self.device.destroy(),
            Some(left) => *left -= 1,
            None => {}
        }
        self.prepare(job)?;
        let Some(buffers) = &self.buffers else {
            return Err(RenderError::Device { what: "no buffers".into() });
        };
        buffers.upload(&self.queue, job);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.encode(&mut encoder, buffers, job, work);
        buffers.copy_out(&mut encoder);
        self.queue.submit([encoder.finish()]);
        self.check_device()?;
        let result = buffers.read(&self.device, read);
        self.check_device()?;
        result
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder, buffers: &Buffers, job: &Job<'_>, work: Work) {
        let Some(pipelines) = self.pipelines.get(&variant(job)) else { return };
        let groups = job.params.size.words.div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, &buffers.group, &[]);
        match work {
            Work::Constant => {
                pass.set_pipeline(&pipelines.constant);
                pass.dispatch_workgroups(groups, job.params.size.rows, 1);
            }
            Work::Frame => {
                let dark = job.params.dark.steps;
                if dark > 0 {
                    pass.set_pipeline(&pipelines.shade);
                    pass.dispatch_workgroups(groups, dark, 1);
                }
                pass.set_pipeline(&pipelines.fill);
                pass.dispatch_workgroups(groups, job.params.size.rows.div_ceil(FILL_ROWS) - dark, 1);
                pass.set_pipeline(&pipelines.band);
                pass.dispatch_workgroups(groups, 2 * job.params.edge.band_rows, 1);
            }
        }
    }

    /// Kernels for the job's packing, buffers for its size.
    fn prepare(&mut self, job: &Job<'_>) -> Result<(), RenderError> {
        let variant = variant(job);
        let fits = self.buffers.as_ref().is_some_and(|b| b.fits(job));
        if fits && self.pipelines.contains_key(&variant) {
            return Ok(());
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        if !fits {
            self.buffers = Some(Buffers::new(&self.device, &self.bindings, job, self.mappable));
        }
        let pipelines = Pipelines {
            shade: self.pipeline("shade", variant),
            fill: self.pipeline("fill", variant),
            band: self.pipeline("band", variant),
            constant: self.pipeline("constant", variant),
        };
        self.pipelines.insert(variant, pipelines);
        let errors = [pollster::block_on(memory.pop()), pollster::block_on(scope.pop())];
        if let Some(e) = errors.into_iter().flatten().next() {
            self.buffers = None;
            return Err(RenderError::Device { what: e.to_string() });
        }
        Ok(())
    }

    fn pipeline(&self, entry: &str, variant: Variant) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&self.layout),
            module: &self.module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &std::array::from_fn::<_, 8, _>(|i| (OVERRIDES[i], f64::from(variant[i]))),
                ..Default::default()
            },
            cache: None,
        })
    }

    fn check_device(&self) -> Result<(), RenderError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(()), |what| Err(RenderError::Device { what }))
    }
}

/// Stores failures outside error scopes, so that they become errors and not panics.
fn watch(device: &wgpu::Device, failure: &Arc<Mutex<Option<String>>>) {
    let keep = |slot: &Mutex<Option<String>>, what: String| {
        slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
    };
    let slot = Arc::clone(failure);
    device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| keep(&slot, e.to_string())));
    let slot = Arc::clone(failure);
    device.set_device_lost_callback(move |reason, what| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            keep(&slot, format!("device lost: {what}"));
        }
    });
}
