//! What does a renderer say when its device is lost in the middle of a frame, or allows too little?

#[path = "common/mod.rs"]
mod common;

use common::gpu::skip;
use std::time::Duration;
use twinlight::backend::{Arithmetic, BackendError, Gpu, GpuError};
use twinlight::picture::Picture;
use twinlight::plan::{Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::Scene;
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::soft_gi::SoftGi;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Job, View};
use twinlight_gpu::{GpuOptions, adapters, wgpu};

fn techniques() -> [Technique; 6] {
    [
        Technique::Direct,
        Technique::AmbientOcclusion,
        Technique::SoftGi(SoftGi::default()),
        Technique::VisibilityFilter(VisibilityFilter { proxies: 4000, light_map: 64, ..Default::default() }),
        Technique::VoxelCones(VoxelCones { resolution: 32, light_map: 64, ..Default::default() }),
        Technique::LayeredRsm(LayeredRsm { resolution: 32, map: 64, ..Default::default() }),
    ]
}

fn render(gpu: Gpu, technique: &Technique, side: u32) -> Result<Picture, BackendError> {
    let name = if matches!(technique, Technique::SoftGi(_)) { "spheres" } else { "cornell-box" };
    let scene = Scene::open(name).expect("built in");
    let view = View::new(&scene.view(), side, side).expect("a view");
    let mut renderer = Renderer::new(gpu, scene)?;
    let plan = renderer.plan(&Request::new(technique.clone(), view, Job::default())).expect("a plan");
    renderer.render(&plan).map(|frame| frame.rendered.picture)
}

/// Errors are one line that says what to do.
fn check(error: &BackendError) {
    let text = error.to_string();
    assert!(!text.contains('\n') && text.len() > 20 && text.len() < 500, "{text}");
    assert!(text.contains("CPU backend"), "{text}");
}

#[test]
fn a_device_that_is_lost_in_the_middle_of_a_frame_is_an_error() {
    for technique in techniques() {
        let mut lost = Vec::new();
        // From at once to after most of the passes.
        for milliseconds in [0, 1, 5, 20, 60, 150] {
            let gpu = match Gpu::new(&GpuOptions::default()) {
                Ok(gpu) => gpu,
                Err(e) => return skip(&e.to_string()),
            };
            let device = gpu.device().clone();
            let end = std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(milliseconds));
                device.destroy();
            });
            match render(gpu, &technique, 128) {
                // It was quicker.
                Ok(_) => {}
                Err(e) => {
                    assert!(
                        matches!(e, BackendError::Gpu(GpuError::DeviceLost { .. })),
                        "{}: {e:?}",
                        technique.name()
                    );
                    check(&e);
                    lost.push(milliseconds);
                }
            }
            end.join().expect("the device is destroyed");
        }
        println!("{}: lost after {lost:?} ms", technique.name());
        assert!(lost.iter().any(|&m| m > 0), "{}: no frame was lost once it had begun", technique.name());
    }
}

/// A host's device with changed limits.
fn host(change: impl Fn(&mut wgpu::Limits)) -> Option<Result<Gpu, GpuError>> {
    let adapter = adapters().into_iter().next().or_else(|| {
        skip("there is no adapter");
        None
    })?;
    let mut limits = adapter.limits();
    change(&mut limits);
    let request = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&request)).expect("a device with less");
    Some(Gpu::from_device(device, queue, Arithmetic::Fast))
}

#[test]
fn a_device_that_allows_too_little_is_an_error() {
    for technique in techniques() {
        let Some(gpu) = host(|l| {
            l.max_storage_buffer_binding_size = 1 << 16;
        }) else {
            return;
        };
        let error = render(gpu.expect("a device"), &technique, 256).expect_err("64 KiB are too little");
        assert!(matches!(error, BackendError::Gpu(GpuError::LimitTooSmall { .. })), "{error:?}");
        check(&error);
        // Negative control.
        let gpu = host(|_| ()).expect("an adapter");
        render(gpu.expect("a device"), &technique, 64).expect("the adapter's own limits are enough");
    }
    let Some(gpu) = host(|l| l.max_compute_workgroups_per_dimension = 16) else { return };
    // 16 × 16 workgroups of 64 items hold 128 × 128 pixels and no more.
    let error = render(gpu.expect("a device"), &Technique::Direct, 256).expect_err("too few workgroups");
    assert!(matches!(error, BackendError::Gpu(GpuError::LimitTooSmall { .. })), "{error:?}");
    check(&error);
    let Some(gpu) = host(|l| {
        (l.max_buffer_size, l.max_storage_buffer_binding_size, l.max_uniform_buffer_binding_size) =
            (4096, 4096, 4096);
    }) else {
        return;
    };
    let error = BackendError::from(gpu.err().expect("no room for parameters"));
    assert!(matches!(error, BackendError::Gpu(GpuError::LimitTooSmall { .. })), "{error:?}");
    check(&error);
}

#[test]
fn how_workgroups_are_laid_out_does_not_matter() {
    for technique in techniques() {
        let with = |most: u32| {
            let gpu = host(|l| {
                l.max_compute_workgroups_per_dimension = l.max_compute_workgroups_per_dimension.min(most)
            })?;
            Some(render(gpu.expect("a device"), &technique, 96).expect("a picture").pixels)
        };
        let Some(usual) = with(u32::MAX) else { return };
        // Rows of 50 and of 100 workgroups instead of one row.
        for most in [50, 100] {
            assert!(with(most).as_ref() == Some(&usual), "{}: rows of {most} workgroups", technique.name());
        }
    }
}
