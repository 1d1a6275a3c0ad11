//! How does one pass get its pipeline, its parameters and its place in the command stream?

use crate::buffer::RawBuffer;
use crate::float_controls::preserve;
use crate::{Gpu, GpuError, Variant, modules};
use std::borrow::Cow;
use twinlight_kernels::passes::PassInfo;

/// Bytes of parameters that one submission can hold.
pub(crate) const ARENA_BYTES: u64 = 256 * 1024;
/// Invocations in a workgroup; the entry points say the same.
const WORKGROUP: u32 = 64;
/// Bytes of the launch header before the parameters.
const HEADER: usize = 16;

pub(crate) struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// The parameters of the passes recorded since the last submission.
pub(crate) struct Arena {
    buffer: wgpu::Buffer,
    data: Vec<u8>,
    alignment: usize,
}

impl Arena {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("parameters"),
            size: ARENA_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let alignment = device.limits().min_uniform_buffer_offset_alignment.max(16) as usize;
        Self { buffer, data: Vec::new(), alignment }
    }

    /// The offset at which a launch was put, or none when the arena is full.
    fn push(&mut self, items: u32, row: u32, params: &[u8]) -> Option<u64> {
        let offset = self.data.len().next_multiple_of(self.alignment);
        if (offset + HEADER + params.len()) as u64 > ARENA_BYTES {
            return None;
        }
        self.data.resize(offset, 0);
        self.data.extend_from_slice(bytemuck::cast_slice(&[items, row, 0u32, 0u32]));
        self.data.extend_from_slice(params);
        Some(offset as u64)
    }
}

/// Workgroups in x and y for `items`, and invocations per row.
fn grid(items: u32, most: u32) -> (u32, u32, u32) {
    let groups = items.div_ceil(WORKGROUP).max(1);
    let x = groups.min(most);
    (x, groups.div_ceil(x), x * WORKGROUP)
}

impl Gpu {
    /// The command encoder of this frame.
    pub(crate) fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        let device = &self.device;
        self.encoder.get_or_insert_with(|| {
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("twinlight") })
        })
    }

    /// Records one pass.
    pub(crate) fn run(
        &mut self,
        pass: &'static PassInfo,
        params: &[u8],
        inputs: &[&RawBuffer],
        output: &RawBuffer,
        items: u32,
    ) -> Result<(), GpuError> {
        if pass.shape == twinlight_kernels::passes::Shape::Map && items as usize > output.len {
            return Err(GpuError::TooManyItems { pass: pass.name, items, capacity: output.len });
        }
        if items == 0 {
            return Ok(());
        }
        self.ensure_pipeline(pass)?;
        let (x, y, row) = grid(items, self.limits.max_compute_workgroups_per_dimension.min(0x00FF_FFFF));
        if y > self.limits.max_compute_workgroups_per_dimension {
            return Err(GpuError::LimitTooSmall {
                what: format!("pass {} (workgroups)", pass.name),
                needed: u64::from(x) * u64::from(y),
                allowed: u64::from(self.limits.max_compute_workgroups_per_dimension).pow(2),
            });
        }
        if self.timestamps.full() {
            self.submit()?;
        }
        let offset = match self.arena.push(items, row, params) {
            Some(offset) => offset,
            None => {
                self.submit()?;
                self.arena.push(items, row, params).unwrap_or(0)
            }
        };
        let group = self.bind(pass, inputs, output, offset, (HEADER + params.len()) as u64)?;
        let bytes = inputs.iter().map(|b| b.bytes).sum::<u64>() + output.bytes;
        let slot = self.timestamps.begin(pass.name, items, bytes);
        self.encoder();
        let (Some(encoder), Some(pipeline)) = (self.encoder.as_mut(), self.pipelines.get(pass.name)) else {
            return Ok(());
        };
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(pass.name),
            timestamp_writes: slot.and_then(|s| self.timestamps.writes(s)),
        });
        compute.set_pipeline(&pipeline.pipeline);
        compute.set_bind_group(0, &group, &[]);
        compute.dispatch_workgroups(x, y, 1);
        Ok(())
    }

    fn bind(
        &self,
        pass: &PassInfo,
        inputs: &[&RawBuffer],
        output: &RawBuffer,
        offset: u64,
        size: u64,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let mut entries = vec![wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &self.arena.buffer,
                offset,
                size: wgpu::BufferSize::new(size),
            }),
        }];
        for (info, raw) in pass.inputs.iter().zip(inputs).chain([(&pass.output, &output)]) {
            entries.push(wgpu::BindGroupEntry {
                binding: info.binding,
                resource: raw.buffer.as_entire_binding(),
            });
        }
        let layout = &self.pipelines[pass.name].layout;
        self.scoped(pass.name, |gpu| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(pass.name),
                layout,
                entries: &entries,
            })
        })
    }

    fn ensure_pipeline(&mut self, pass: &'static PassInfo) -> Result<(), GpuError> {
        if !self.pipelines.contains_key(pass.name) {
            let pipeline = self.scoped(pass.name, |gpu| gpu.create_pipeline(pass))?;
            self.pipelines.insert(pass.name, pipeline);
        }
        Ok(())
    }

    fn create_pipeline(&self, pass: &PassInfo) -> Pipeline {
        let storage = |binding: u32, read_only: bool| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let mut entries = vec![wgpu::BindGroupLayoutEntry {
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            ..storage(0, true)
        }];
        entries.extend(pass.inputs.iter().map(|b| storage(b.binding, true)));
        entries.push(storage(pass.output.binding, false));
        let layout = self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(pass.name),
            entries: &entries,
        });
        let pipeline_layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(pass.name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(pass.name),
            layout: Some(&pipeline_layout),
            module: &self.load(pass),
            entry_point: Some(pass.name),
            compilation_options: Default::default(),
            cache: None,
        });
        Pipeline { pipeline, layout }
    }

    fn load(&self, pass: &PassInfo) -> wgpu::ShaderModule {
        let bytes = modules::module(self.variant, pass.name).unwrap_or_default();
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        if self.variant == Variant::Fast {
            // Through naga: the one path that every platform has.
            return self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(pass.name),
                source: wgpu::ShaderSource::SpirV(Cow::Owned(words)),
            });
        }
        let words = if self.preserves { preserve(&words) } else { words };
        let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
            label: Some(pass.name),
            entry_points: Cow::Owned(vec![wgpu::PassthroughShaderEntryPoint {
                name: Cow::Borrowed(pass.name),
                workgroup_size: (WORKGROUP, 1, 1),
            }]),
            spirv: Some(Cow::Owned(words)),
            ..Default::default()
        };
        // SAFETY: the module is one of the committed ones: valid by spirv-val (with the mode too), its bindings those of the layout
        // made from the same list, and its accesses checked against the bound lengths.
        unsafe { self.device.create_shader_module_passthrough(descriptor) }
    }

    /// Hands everything recorded so far to the device.
    pub fn submit(&mut self) -> Result<(), GpuError> {
        let Some(mut encoder) = self.encoder.take() else { return Ok(()) };
        self.timestamps.resolve(&self.device, &mut encoder);
        let data = std::mem::take(&mut self.arena.data);
        self.scoped("a submission", |gpu| {
            if !data.is_empty() {
                gpu.queue.write_buffer(&gpu.arena.buffer, 0, &data);
            }
            gpu.queue.submit([encoder.finish()]);
        })
    }

    /// Submits and waits until the device is idle.
    pub fn finish(&mut self) -> Result<(), GpuError> {
        self.submit()?;
        self.wait()
    }

    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        match self.device.poll(wgpu::PollType::wait_indefinitely()) {
            Ok(_) => match self.lost.lock().unwrap_or_else(|e| e.into_inner()).clone() {
                Some(reason) => Err(GpuError::DeviceLost { what: "a submission".into(), reason }),
                None => Ok(()),
            },
            Err(e) => Err(self.lost("a submission", e)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::grid;

    #[test]
    fn the_grid_covers_every_item_once() {
        for items in [1u32, 63, 64, 65, 4_194_240, 4_194_241, 100_000_000] {
            let (x, y, row) = grid(items, 65_535);
            assert!(x <= 65_535 && y <= 65_535);
            assert_eq!(row, x * 64);
            assert!(u64::from(row) * u64::from(y) >= u64::from(items), "{items}");
            assert!(u64::from(row) * u64::from(y - 1) < u64::from(items), "{items}: a row too many");
        }
    }
}
