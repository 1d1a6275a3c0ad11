//! Which device runs the passes, and what may be asked of it?

use crate::dispatch::{ARENA_BYTES, Arena, Pipeline};
use crate::float_controls::may_preserve;
use crate::timing::Timestamps;
use crate::{Arithmetic, GpuError, Probe, Variant};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use twinlight_kernels::passes::PASSES;

/// Which device to open and how to compute on it.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the adapter's name, in any case; otherwise the one that the system prefers.
    pub adapter: Option<String>,
    /// The arithmetic of the shaders.
    pub arithmetic: Arithmetic,
}

/// Runs passes on a wgpu device.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) limits: wgpu::Limits,
    pub(crate) variant: Variant,
    pub(crate) pipelines: HashMap<&'static str, Pipeline>,
    pub(crate) encoder: Option<wgpu::CommandEncoder>,
    pub(crate) arena: Arena,
    pub(crate) timestamps: Timestamps,
    pub(crate) allocations: Option<Vec<(&'static str, String, u64)>>,
    pub(crate) lost: Arc<Mutex<Option<String>>>,
    /// Strict modules declare that NaN, infinities and the sign of zero matter.
    pub(crate) preserves: bool,
    adapter: wgpu::AdapterInfo,
    probe: Option<Probe>,
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    wgpu::Instance::new(descriptor)
}

/// Every adapter of the system.
pub fn adapters() -> Vec<wgpu::Adapter> {
    pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()))
}

/// The adapter's name, kind and driver in one line.
pub fn describe(info: &wgpu::AdapterInfo) -> String {
    format!(
        "{} ({:?}, {:?}, {} {})",
        info.name, info.device_type, info.backend, info.driver, info.driver_info
    )
}

fn choose(wanted: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    let all = adapters();
    let names: Vec<String> = all.iter().map(|a| a.get_info().name).collect();
    let rank = |a: &wgpu::Adapter| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Cpu => 3,
        wgpu::DeviceType::Other => 4,
    };
    all.into_iter()
        .filter(|a| wanted.is_none_or(|w| a.get_info().name.to_lowercase().contains(&w.to_lowercase())))
        .min_by_key(rank)
        .ok_or_else(|| GpuError::NoAdapter {
            wanted: wanted.map(str::to_owned),
            available: if names.is_empty() {
                "the system has none".into()
            } else {
                format!("the system has {}", names.join(", "))
            },
        })
}

impl Gpu {
    /// Opens a device.
    ///
    /// For [`Arithmetic::Strict`] the device is probed: it must load SPIR-V unchanged and give the CPU's bits.
    pub fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        let adapter = choose(options.adapter.as_deref())?;
        let info = adapter.get_info();
        let useful = wgpu::Features::PASSTHROUGH_SHADERS | wgpu::Features::TIMESTAMP_QUERY;
        let request = wgpu::DeviceDescriptor {
            label: Some("twinlight"),
            required_features: adapter.features() & useful,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&request))
            .map_err(|e| GpuError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        let lost = Arc::new(Mutex::new(None));
        let seen = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            *seen.lock().unwrap_or_else(|e| e.into_inner()) = Some(format!("{reason:?}: {message}"));
        });
        let mut gpu = Self::assemble(device, queue, lost)?;
        gpu.set_arithmetic(options.arithmetic)?;
        Ok(gpu)
    }

    /// Runs on the host's device and queue.
    ///
    /// The device needs `max_storage_buffers_per_shader_stage` ≥ 8, for strict arithmetic also the feature
    /// `PASSTHROUGH_SHADERS`, and for timings `TIMESTAMP_QUERY`.
    pub fn from_device(
        device: wgpu::Device,
        queue: wgpu::Queue,
        arithmetic: Arithmetic,
    ) -> Result<Self, GpuError> {
        let mut gpu = Self::assemble(device, queue, Arc::new(Mutex::new(None)))?;
        gpu.set_arithmetic(arithmetic)?;
        Ok(gpu)
    }

    fn assemble(
        device: wgpu::Device,
        queue: wgpu::Queue,
        lost: Arc<Mutex<Option<String>>>,
    ) -> Result<Self, GpuError> {
        let limits = device.limits();
        let needed = PASSES.iter().map(|p| p.inputs.len() as u32 + 1).max().unwrap_or(0);
        if limits.max_storage_buffers_per_shader_stage < needed {
            return Err(GpuError::LimitTooSmall {
                what: "storage buffers per shader stage".into(),
                needed: u64::from(needed),
                allowed: u64::from(limits.max_storage_buffers_per_shader_stage),
            });
        }
        if limits.max_buffer_size < ARENA_BYTES {
            return Err(GpuError::LimitTooSmall {
                what: "the passes' parameters (bytes)".into(),
                needed: ARENA_BYTES,
                allowed: limits.max_buffer_size,
            });
        }
        let arena = Arena::new(&device);
        let timestamps = Timestamps::new(&device, &queue);
        let adapter = device.adapter_info();
        let preserves = may_preserve(&device);
        Ok(Self {
            preserves,
            limits,
            variant: Variant::Fast,
            pipelines: HashMap::new(),
            encoder: None,
            arena,
            timestamps,
            allocations: None,
            lost,
            adapter,
            probe: None,
            device,
            queue,
        })
    }

    fn set_arithmetic(&mut self, arithmetic: Arithmetic) -> Result<(), GpuError> {
        if arithmetic == Arithmetic::Fast {
            return Ok(());
        }
        let probe = self.run_probe()?;
        let variant = probe
            .strict_variant()
            .map_err(|reason| GpuError::NotStrict { adapter: self.adapter.name.clone(), reason })?;
        self.probe = Some(probe);
        self.set_variant(variant);
        Ok(())
    }

    /// Switches to another set of modules, whatever the probe said; for tests and measurements.
    pub fn set_variant(&mut self, variant: Variant) {
        if variant != self.variant {
            self.pipelines.clear();
            self.variant = variant;
        }
    }

    /// The modules in use.
    pub fn variant(&self) -> Variant {
        self.variant
    }

    /// True when the device loads SPIR-V unchanged.
    pub fn has_passthrough(&self) -> bool {
        self.device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS)
    }

    /// What the start-up probe found, when strict arithmetic was asked for.
    pub fn probe(&self) -> Option<&Probe> {
        self.probe.as_ref()
    }

    /// The adapter behind the device.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.adapter
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The wgpu queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Number of pipelines created so far: effects that nobody called for have none.
    pub fn pipeline_count(&self) -> usize {
        self.pipelines.len()
    }

    /// The passes that have a pipeline, sorted by name.
    pub fn pipeline_names(&self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.pipelines.keys().copied().collect();
        names.sort_unstable();
        names
    }

    /// Drops all pipelines: they are made again when a pass first needs its own.
    pub fn forget_pipelines(&mut self) {
        self.pipelines.clear();
    }

    /// Begins to list every buffer that is made, or ends it and forgets them.
    pub fn log_allocations(&mut self, on: bool) {
        self.allocations = on.then(Vec::new);
    }

    /// The buffers made since the last call, while they are listed: stage, label and bytes of each, in order. An empty
    /// one takes 16 bytes.
    pub fn take_allocations(&mut self) -> Vec<(&'static str, String, u64)> {
        self.allocations.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Runs a call and turns wgpu's complaints into an error.
    pub(crate) fn scoped<R>(&self, what: &str, call: impl FnOnce(&Self) -> R) -> Result<R, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = call(self);
        let faults = [validation, internal, memory].map(|scope| pollster::block_on(scope.pop()));
        if let Some(fault) = faults.into_iter().flatten().next() {
            return Err(match fault {
                wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { what: what.to_owned() },
                other => self.lost_or(what, other.to_string()),
            });
        }
        // Calls on a device that is gone raise nothing: wgpu reports the loss to its callback alone.
        if self.is_lost() {
            return Err(self.lost(what, "gone"));
        }
        Ok(result)
    }

    fn is_lost(&self) -> bool {
        self.lost.lock().unwrap_or_else(|e| e.into_inner()).is_some()
    }

    fn lost_or(&self, what: &str, reason: String) -> GpuError {
        // The callback runs when nothing is left in the queue: the loss is the reason of all faults that follow it.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        let lost = self.lost.lock().unwrap_or_else(|e| e.into_inner()).clone();
        match lost {
            Some(why) => GpuError::DeviceLost { what: what.to_owned(), reason: why },
            None => GpuError::Refused { what: what.to_owned(), reason: one_line(&reason) },
        }
    }

    pub(crate) fn lost(&self, what: &str, error: impl std::fmt::Display) -> GpuError {
        let known = self.lost.lock().unwrap_or_else(|e| e.into_inner()).clone();
        GpuError::DeviceLost {
            what: what.to_owned(),
            reason: known.unwrap_or_else(|| one_line(&error.to_string())),
        }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
