//! Does the crate work on a device of its own and on the host's, and does it fail with errors, never panics?

#[path = "../../tests/common/gpu.rs"]
mod common;

use common::{announce, gpu_required, shared, skip};
use glam::Vec4;
use twinlight_gpu::{Arithmetic, Gpu, GpuBuffer, GpuError, GpuOptions, Variant, wgpu};
use twinlight_kernels::passes::elements::*;

/// A device for one test alone.
fn own() -> Option<Gpu> {
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => Some(gpu),
        Err(e) => {
            skip(&e.to_string());
            None
        }
    }
}

/// What a renderer would bring along: a device with these features, and default limits changed by `limit`.
fn host(
    wanted: wgpu::Features,
    limit: impl FnOnce(&mut wgpu::Limits),
) -> Option<(wgpu::Device, wgpu::Queue)> {
    let Some(adapter) = twinlight_gpu::adapters().into_iter().next() else {
        skip("the system has no adapter");
        return None;
    };
    let mut limits = wgpu::Limits::default();
    limit(&mut limits);
    let request = wgpu::DeviceDescriptor {
        label: Some("host"),
        required_features: adapter.features() & wanted,
        required_limits: limits,
        ..Default::default()
    };
    Some(pollster::block_on(adapter.request_device(&request)).expect("default limits"))
}

fn vectors(count: usize) -> Vec<Vec4> {
    (0..count).map(|i| Vec4::new(i as f32, 0.5 * i as f32, -1.0, 1.0)).collect()
}

fn add(
    gpu: &mut Gpu,
    a: &GpuBuffer<Vec4>,
    b: &GpuBuffer<Vec4>,
    sum: &mut GpuBuffer<Vec4>,
) -> Result<(), GpuError> {
    let items = sum.len() as u32;
    gpu.add_radiance(&AddParams::default(), a, b, sum, items)
}

#[test]
fn the_probe_says_which_modules_are_strict() {
    let Some(shared) = shared() else { return };
    match shared.probe.strict_variant() {
        Ok(variant) => {
            assert_ne!(variant, Variant::Fast);
            let native = shared.probe.division && shared.probe.square_root;
            assert_eq!(variant == Variant::StrictNative, native);
            let strict = GpuOptions { arithmetic: Arithmetic::Strict, ..Default::default() };
            let gpu = Gpu::new(&strict).expect("the probe said so");
            assert_eq!(gpu.variant(), variant);
            assert_eq!(gpu.probe(), Some(&shared.probe), "the probe changes from run to run");
        }
        Err(reason) => announce(&format!("no strict arithmetic on {}: {reason}", shared.gpu.adapter().name)),
    }
}

#[test]
fn a_host_device_and_its_buffers_are_adopted() {
    let Some((device, queue)) = host(wgpu::Features::empty(), |_| {}) else { return };
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let raw = |label| {
        let size = 16 * 100;
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let (host_input, host_output) = (raw("host input"), raw("host output"));
    let input = vectors(100);
    queue.write_buffer(&host_input, 0, bytemuck::cast_slice(&input));
    let mut gpu = Gpu::from_device(device.clone(), queue.clone(), Arithmetic::Fast).expect("default limits");
    let a = GpuBuffer::from_wgpu(host_input, 100);
    let b = gpu.upload("ones", &[Vec4::ONE; 100]).unwrap();
    let mut sum = GpuBuffer::from_wgpu(host_output.clone(), 100);
    add(&mut gpu, &a, &b, &mut sum).unwrap();
    gpu.submit().unwrap();
    // Read by the host, through a second handle of its own: no download through the crate's buffer.
    let again: GpuBuffer<Vec4> = GpuBuffer::from_wgpu(host_output, 100);
    let mut reader = Gpu::from_device(device, queue, Arithmetic::Fast).unwrap();
    let expected: Vec<Vec4> = input.iter().map(|v| *v + Vec4::ONE).collect();
    assert_eq!(reader.download(&again).unwrap(), expected);
}

#[test]
fn strict_arithmetic_is_refused_on_a_host_device_that_changes_shaders() {
    let Some((device, queue)) = host(wgpu::Features::empty(), |_| {}) else { return };
    let error = Gpu::from_device(device, queue, Arithmetic::Strict).err().expect("no passthrough feature");
    assert!(matches!(&error, GpuError::NotStrict { .. }), "{error}");
    assert!(error.to_string().contains("passthrough"), "{error}");
}

#[test]
fn a_host_device_with_passthrough_gives_strict_arithmetic() {
    let Some((device, queue)) = host(wgpu::Features::PASSTHROUGH_SHADERS, |_| {}) else { return };
    if !device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS) {
        announce("SKIPPED: this adapter has no shader passthrough");
        return;
    }
    let gpu = Gpu::from_device(device, queue, Arithmetic::Strict).expect("strict");
    assert!(gpu.probe().is_some_and(|p| p.elementary));
    // As every Vulkan driver that these tests were run on has the property that keeps NaN apart.
    if gpu_required() {
        assert!(gpu.probe().is_some_and(|p| p.specials), "{:?}", gpu.probe());
    }
}

#[test]
fn a_device_with_too_few_bindings_is_refused() {
    let few = |limits: &mut wgpu::Limits| limits.max_storage_buffers_per_shader_stage = 4;
    let Some((device, queue)) = host(wgpu::Features::empty(), few) else { return };
    let error = Gpu::from_device(device, queue, Arithmetic::Fast).err().expect("four buffers are too few");
    assert!(matches!(error, GpuError::LimitTooSmall { allowed: 4, .. }), "{error}");
}

#[test]
fn after_the_device_is_gone_every_call_is_an_error() {
    let Some(mut gpu) = own() else { return };
    let a = gpu.upload("a", &vectors(10)).unwrap();
    let b = gpu.upload("b", &vectors(10)).unwrap();
    let mut sum = gpu.alloc("sum", 10).unwrap();
    add(&mut gpu, &a, &b, &mut sum).unwrap();
    gpu.finish().unwrap();
    gpu.device().destroy();
    let _ = gpu.device().poll(wgpu::PollType::wait_indefinitely());
    let results = [
        gpu.alloc::<Vec4>("after", 10).map(|_| ()),
        gpu.upload("after", &vectors(10)).map(|_| ()),
        gpu.write(&mut sum, &vectors(10)),
        add(&mut gpu, &a, &b, &mut sum).and_then(|()| gpu.finish()),
        gpu.download(&sum).map(|_| ()),
        gpu.clear(&mut sum).and_then(|()| gpu.finish()),
        gpu.run_probe().map(|_| ()),
    ];
    for (call, result) in results.into_iter().enumerate() {
        let error = result.err().unwrap_or_else(|| panic!("call {call} succeeded on a device that is gone"));
        assert!(matches!(error, GpuError::DeviceLost { .. }), "call {call}: {error:?}");
    }
}

#[test]
fn a_buffer_beyond_the_limits_is_refused_before_it_is_allocated() {
    let Some(mut gpu) = own() else { return };
    let limits = gpu.device().limits();
    let allowed = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    let error = gpu.alloc::<u32>("huge", (allowed / 4 + 1) as usize).expect_err("beyond the limit");
    assert!(matches!(error, GpuError::LimitTooSmall { .. }), "{error}");
    assert!(
        error.to_string().contains("huge") && error.to_string().contains(&allowed.to_string()),
        "{error}"
    );
}

#[test]
fn more_items_than_the_output_holds_are_refused() {
    let Some(mut gpu) = own() else { return };
    let a = gpu.upload("a", &vectors(11)).unwrap();
    let mut sum = gpu.alloc("sum", 10).unwrap();
    let error = gpu.add_radiance(&AddParams::default(), &a, &a, &mut sum, 11).expect_err("11 > 10");
    assert!(
        matches!(error, GpuError::TooManyItems { pass: "add_radiance", items: 11, capacity: 10 }),
        "{error}"
    );
    gpu.add_radiance(&AddParams::default(), &a, &a, &mut sum, 0).unwrap();
    assert_eq!(gpu.download(&sum).unwrap(), [Vec4::ZERO; 10]);
}

#[test]
fn empty_buffers_can_be_made_read_and_bound() {
    let Some(mut gpu) = own() else { return };
    let empty = gpu.upload::<Vec4>("empty", &[]).unwrap();
    assert!(empty.is_empty());
    assert_eq!(gpu.download(&empty).unwrap(), []);
    let mut sum = gpu.alloc("sum", 1).unwrap();
    gpu.reduce_sum(&ReduceParams::default(), &empty, &mut sum, 1).unwrap();
    assert_eq!(gpu.download(&sum).unwrap(), [Vec4::ZERO]);
}

#[test]
fn pipelines_exist_only_for_passes_that_ran() {
    let Some(mut gpu) = own() else { return };
    assert_eq!(gpu.pipeline_count(), 0);
    let a = gpu.upload("a", &vectors(10)).unwrap();
    let mut sum = gpu.alloc("sum", 10).unwrap();
    for _ in 0..2 {
        add(&mut gpu, &a, &a, &mut sum).unwrap();
        assert_eq!(gpu.pipeline_count(), 1);
    }
}

#[test]
fn one_frame_may_hold_more_passes_than_the_parameter_arena() {
    let Some(mut gpu) = own() else { return };
    let ones = gpu.upload("ones", &[Vec4::ONE; 3]).unwrap();
    let mut even = gpu.alloc("even", 3).unwrap();
    let mut odd = gpu.alloc("odd", 3).unwrap();
    const ROUNDS: usize = 900;
    for _ in 0..ROUNDS {
        add(&mut gpu, &even, &ones, &mut odd).unwrap();
        add(&mut gpu, &odd, &ones, &mut even).unwrap();
    }
    assert_eq!(gpu.download(&even).unwrap(), [Vec4::splat(2.0 * ROUNDS as f32); 3]);
    let timings = gpu.take_timings().unwrap();
    assert_eq!(timings.len(), 2 * ROUNDS);
    assert!(timings.iter().all(|t| t.pass == "add_radiance" && t.items == 3 && t.bytes == 3 * 48));
}

#[test]
fn a_launch_may_have_more_items_than_one_row_of_workgroups() {
    let Some(mut gpu) = own() else { return };
    let count = 65_535 * 64 + 1000u32;
    let values: Vec<u32> = (0..count).collect();
    let within = gpu.upload("within", &values).unwrap();
    let offsets = gpu.upload("offsets", &vec![5; count.div_ceil(32) as usize]).unwrap();
    let mut scanned = gpu.alloc("scanned", count as usize).unwrap();
    gpu.add_block_offsets(
        &ScanParams { count, ..Default::default() },
        &within,
        &offsets,
        &mut scanned,
        count,
    )
    .unwrap();
    let got = gpu.download(&scanned).unwrap();
    assert!(got.iter().enumerate().all(|(i, &v)| v == i as u32 + 5), "some item was lost or run as another");
}
