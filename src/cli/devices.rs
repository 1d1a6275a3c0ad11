//! `twinlight devices`: which GPUs are there, and can they run strict arithmetic?

use super::{Failure, print_out};
use crate::backend::{Gpu, GpuOptions};
use clap::Args;
use serde_json::{Value, json};
use twinlight_gpu::{HalfRounding, Probe, adapters, describe};

#[derive(Args)]
pub(crate) struct DevicesArguments {
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(a: &DevicesArguments) -> Result<(), Failure> {
    let mut list = Vec::new();
    let mut text = String::new();
    for adapter in adapters() {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let probe = Gpu::new(&GpuOptions { adapter: Some(info.name.clone()), ..Default::default() })
            .and_then(|mut gpu| gpu.run_probe());
        text += &format!("{}\n", describe(&info));
        text += &format!(
            "  storage buffers per stage {}, binding {} MiB, buffer {} MiB, workgroups {}\n",
            limits.max_storage_buffers_per_shader_stage,
            limits.max_storage_buffer_binding_size >> 20,
            limits.max_buffer_size >> 20,
            limits.max_compute_workgroups_per_dimension,
        );
        let (line, value) = match &probe {
            Ok(probe) => (probe_text(probe), probe_json(probe)),
            Err(e) => (format!("  does not open: {e}\n"), json!({ "error": e.to_string() })),
        };
        text += &line;
        list.push(json!({
            "name": info.name,
            "kind": format!("{:?}", info.device_type),
            "api": format!("{:?}", info.backend),
            "driver": format!("{} {}", info.driver, info.driver_info),
            "storage_buffers": limits.max_storage_buffers_per_shader_stage,
            "binding_bytes": limits.max_storage_buffer_binding_size,
            "buffer_bytes": limits.max_buffer_size,
            "probe": value,
        }));
    }
    if a.json {
        return print_out(&format!("{}\n", json!({ "adapters": list })));
    }
    if list.is_empty() {
        text = "no GPU adapter; install a Vulkan driver (Debian: mesa-vulkan-drivers). The CPU backend needs none.\n".into();
    }
    print_out(&text)
}

fn probe_text(p: &Probe) -> String {
    let yes = |b: bool| if b { "yes" } else { "no" };
    let strict = match p.strict_variant() {
        Ok(variant) => format!("yes ({variant:?} modules)"),
        Err(reason) => format!("no: {reason}"),
    };
    format!(
        "  strict arithmetic: {strict}\n  SPIR-V unchanged {}, sums kept {}, products rounded {}, division exact {}, \
         square root exact {}, denormals kept {}, conversions exact {}, integer atomics exact {}, halves rounded {}, elementary functions exact {}, \
         NaN and infinities as on the CPU {}\n",
        yes(p.passthrough),
        yes(p.sums_kept),
        yes(p.products_rounded),
        yes(p.division),
        yes(p.square_root),
        yes(p.denormals),
        yes(p.conversions),
        yes(p.atomics),
        half_text(p.half),
        yes(p.elementary),
        yes(p.specials)
    )
}

fn half_text(half: HalfRounding) -> &'static str {
    match half {
        HalfRounding::Nearest => "to nearest",
        HalfRounding::TowardZero => "toward zero",
        HalfRounding::Other => "otherwise",
    }
}

/// What a probe found out.
pub(crate) fn probe_json(p: &Probe) -> Value {
    json!({
        "strict": p.strict_variant().is_ok(),
        "passthrough": p.passthrough,
        "sums_kept": p.sums_kept,
        "products_rounded": p.products_rounded,
        "division": p.division,
        "square_root": p.square_root,
        "denormals": p.denormals,
        "conversions": p.conversions,
        "atomics": p.atomics,
        "half_rounding": half_text(p.half),
        "elementary": p.elementary,
        "specials": p.specials,
    })
}
