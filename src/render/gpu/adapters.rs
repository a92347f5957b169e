//! Which adapters there are and which one to take.

use super::super::error::RenderError;

/// An adapter as `doctor` shows it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct AdapterReport {
    /// Name the driver gives.
    pub name: String,
    /// `vulkan`, `gl` or another API.
    pub backend: String,
    /// `cpu` (software), `integrated`, `discrete`, `virtual` or `other`.
    pub kind: String,
    /// Driver and its version.
    pub driver: String,
}

/// Every adapter that Vulkan and GL offer, best first.
pub fn adapter_reports() -> Vec<AdapterReport> {
    sorted(wgpu::Backends::VULKAN | wgpu::Backends::GL)
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            AdapterReport {
                backend: info.backend.to_string(),
                kind: kind(info.device_type).into(),
                driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
                name: info.name,
            }
        })
        .collect()
}

/// The best adapter: hardware before software, Vulkan before GL.
pub(super) fn best(backends: wgpu::Backends, wanted: &'static str) -> Result<wgpu::Adapter, RenderError> {
    sorted(backends)
        .into_iter()
        .next()
        .ok_or_else(|| RenderError::NoAdapter { wanted, why: "no driver offers one that can compute".into() })
}

fn sorted(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(can_compute);
    adapters.sort_by_key(|a| {
        let info = a.get_info();
        (rank(info.device_type), u8::from(info.backend != wgpu::Backend::Vulkan))
    });
    adapters
}

/// Six storage buffers and compute shaders are what the kernels need.
fn can_compute(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        && adapter.limits().max_storage_buffers_per_shader_stage >= 6
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn kind(kind: wgpu::DeviceType) -> &'static str {
    match kind {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Other => "other",
        wgpu::DeviceType::Cpu => "cpu",
    }
}
