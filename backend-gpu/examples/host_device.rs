//! Runs one pass on a device and a buffer that the host renderer owns: `cargo run -p twinlight-gpu --example host_device`.

use glam::Vec4;
use std::error::Error;
use twinlight_gpu::{Arithmetic, Gpu, GpuBuffer, wgpu};
use twinlight_kernels::passes::elements::ReduceParams;

fn main() -> Result<(), Box<dyn Error>> {
    // What a renderer has anyway: its device, queue and a buffer.
    let adapter =
        twinlight_gpu::adapters().into_iter().next().ok_or("no GPU adapter: install a Vulkan driver")?;
    let request = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&request))?;
    let values: Vec<Vec4> = (0..8).map(|i| Vec4::splat(i as f32)).collect();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("the host's vectors"),
        size: 8 * 16,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&values));

    let mut gpu = Gpu::from_device(device, queue, Arithmetic::Fast)?;
    let values = GpuBuffer::from_wgpu(buffer, 8);
    let mut sums = gpu.alloc("sums", 1)?;
    gpu.reduce_sum(&ReduceParams { count: 8, ..Default::default() }, &values, &mut sums, 1)?;
    println!("{} on {}", gpu.download::<Vec4>(&sums)?[0].x, twinlight_gpu::describe(gpu.adapter()));
    Ok(())
}
