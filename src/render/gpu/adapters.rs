//! The available adapters, and the choice among them.
//!
//! OpenGL's and Vulkan's libraries are not opened by one process: Mesa's thread-local destructors
//! freed the same memory twice at exit about once in 200 runs that had opened both.

use std::sync::atomic::{AtomicBool, Ordering};

use super::super::error::RenderError;

/// An adapter as listed by `doctor`.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct AdapterReport {
    /// Name from the driver.
    pub name: String,
    /// `vulkan`, `gl` or another API.
    pub backend: String,
    /// `cpu` (software), `integrated`, `discrete`, `virtual` or `other`.
    pub kind: String,
    /// Driver and its version.
    pub driver: String,
}

impl AdapterReport {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            backend: info.backend.to_string(),
            kind: kind(info.device_type).into(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
            name: info.name,
        }
    }

    /// Whether this is a graphics processor, not a software rasteriser. An adapter whose kind its
    /// driver does not state (`other`) does not count as one.
    pub(crate) fn is_hardware(&self) -> bool {
        let known = ["discrete", "integrated", "virtual"].contains(&self.kind.as_str());
        known && !SOFTWARE_NAMES.iter().any(|name| self.name.to_lowercase().contains(name))
    }

    /// Order of preference: discrete before integrated before virtual before the rest.
    fn rank(&self) -> usize {
        ["discrete", "integrated", "virtual", "other"].iter().position(|k| *k == self.kind).unwrap_or(4)
    }
}

/// Software rasterisers by name, in lower case: some of their OpenGL drivers state another kind
/// than `cpu`.
const SOFTWARE_NAMES: [&str; 6] =
    ["llvmpipe", "lavapipe", "softpipe", "swiftshader", "swrast", "basic render"];

/// The adapter that `auto` chooses among those of one interface: the best hardware, or none. A
/// software adapter costs 2.4 times the CPU time of the CPU twin and twice its memory for the same
/// frame, so that it is chosen only where Vulkan or OpenGL is requested by name.
pub(crate) fn automatic(adapters: &[AdapterReport]) -> Option<usize> {
    best_of(adapters, AdapterReport::is_hardware)
}

/// The first of the best among the adapters that `wanted` admits.
fn best_of(adapters: &[AdapterReport], wanted: impl Fn(&AdapterReport) -> bool) -> Option<usize> {
    let admitted = adapters.iter().enumerate().filter(|(_, a)| wanted(a));
    admitted.min_by_key(|(index, a)| (!a.is_hardware(), a.rank(), *index)).map(|(index, _)| index)
}

/// Every adapter that Vulkan offers, or OpenGL with `gl`, best first. A process uses only one of
/// the two.
pub(crate) fn adapter_reports(gl: bool) -> Vec<AdapterReport> {
    let mut reports: Vec<_> = offered(backends(gl)).iter().map(AdapterReport::of).collect();
    reports.sort_by_key(|a| (!a.is_hardware(), a.rank()));
    reports
}

fn backends(gl: bool) -> wgpu::Backends {
    if gl { wgpu::Backends::GL } else { wgpu::Backends::VULKAN }
}

/// The best adapter of an interface: hardware before software.
pub(super) fn best(gl: bool) -> Result<wgpu::Adapter, RenderError> {
    let wanted = if gl { "GL" } else { "Vulkan" };
    let none = || RenderError::NoAdapter { wanted, why: "no driver offers one that can compute".into() };
    take(offered(backends(gl)), |reports| best_of(reports, |_| true)).ok_or_else(none)
}

/// The hardware adapter that `auto` chooses: Vulkan's; OpenGL's only where Vulkan offers no adapter
/// at all.
pub(super) fn hardware() -> Option<wgpu::Adapter> {
    let vulkan = offered(wgpu::Backends::VULKAN);
    let adapters = if vulkan.is_empty() { offered(wgpu::Backends::GL) } else { vulkan };
    take(adapters, automatic)
}

fn take(
    mut adapters: Vec<wgpu::Adapter>,
    choose: impl Fn(&[AdapterReport]) -> Option<usize>,
) -> Option<wgpu::Adapter> {
    let reports: Vec<_> = adapters.iter().map(AdapterReport::of).collect();
    choose(&reports).map(|index| adapters.swap_remove(index))
}

/// Whether any driver was opened by this process.
static OPENED: AtomicBool = AtomicBool::new(false);

/// Whether this process has opened a graphics driver: its libraries' destructors are not safe to
/// run at exit.
pub(crate) fn was_opened() -> bool {
    OPENED.load(Ordering::Relaxed)
}

fn offered(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    OPENED.store(true, Ordering::Relaxed);
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.retain(can_compute);
    adapters
}

/// The kernels need compute shaders and six storage buffers.
fn can_compute(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        && adapter.limits().max_storage_buffers_per_shader_stage >= 6
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

#[cfg(test)]
mod tests {
    use super::{AdapterReport, automatic, best_of};

    fn adapter(name: &str, kind: &str) -> AdapterReport {
        let [backend, driver] = ["vulkan", "made up"].map(String::from);
        AdapterReport { name: name.into(), kind: kind.into(), backend, driver }
    }

    #[test]
    fn auto_takes_the_best_hardware_and_never_software() {
        let llvmpipe = adapter("llvmpipe (LLVM 15.0.6, 256 bits)", "cpu");
        let uhd = adapter("Intel(R) UHD Graphics 630", "integrated");
        let rtx = adapter("NVIDIA RTX A2000", "discrete");
        let venus = adapter("Virtio-GPU Venus (AMD Radeon)", "virtual");
        let cases: [(&[&AdapterReport], Option<usize>); 8] = [
            (&[], None),
            (&[&llvmpipe], None),
            (&[&llvmpipe, &uhd], Some(1)),
            (&[&uhd, &llvmpipe, &rtx], Some(2)),
            (&[&venus, &llvmpipe], Some(0)),
            (&[&venus, &uhd], Some(1)),
            (&[&rtx, &rtx], Some(0)),
            (&[&llvmpipe, &llvmpipe], None),
        ];
        for (list, wanted) in cases {
            let list: Vec<AdapterReport> = list.iter().map(|a| (*a).clone()).collect();
            assert_eq!(automatic(&list), wanted, "{list:?}");
        }
    }

    #[test]
    fn software_under_another_kind_is_known_by_its_name() {
        for name in ["SwiftShader Device (LLVM 10.0.0)", "Microsoft Basic Render Driver", "softpipe"] {
            for kind in ["other", "virtual", "integrated", "cpu"] {
                assert_eq!(automatic(&[adapter(name, kind)]), None, "{name} as {kind}");
            }
        }
        assert_eq!(automatic(&[adapter("a driver that states no kind", "other")]), None);
    }

    #[test]
    fn an_interface_asked_for_by_name_offers_its_software_last() {
        let list = [adapter("llvmpipe", "cpu"), adapter("unknown", "other"), adapter("gpu", "integrated")];
        assert_eq!(best_of(&list, |_| true), Some(2));
        assert_eq!(best_of(&list[..2], |_| true), Some(1));
        assert_eq!(best_of(&list[..1], |_| true), Some(0));
    }
}
