//! What may a driver assume of NaN, infinities and the sign of zero in strict modules? Nothing, where it lets itself be told.
//!
//! Without `SignedZeroInfNanPreserve` comparisons, minima and selections may be turned around as if there were no NaN: NVIDIA's compiler
//! does. The mode needs a property of the device, so that modules declare it as they are loaded.

const HEADER: usize = 5;
const OP_ENTRY_POINT: u32 = 15;
const OP_EXECUTION_MODE: u32 = 16;
const OP_CAPABILITY: u32 = 17;
const CAPABILITY: u32 = 4466;
const MODE: u32 = 4461;

/// Whether modules for this device may declare the mode for 32-bit floats.
#[cfg(not(any(target_vendor = "apple", target_arch = "wasm32")))]
pub(crate) fn may_preserve(device: &wgpu::Device) -> bool {
    use ash::vk;
    // SAFETY: the device outlives the guard, and only its properties are read.
    let Some(hal) = (unsafe { device.as_hal::<wgpu::hal::api::Vulkan>() }) else { return false };
    let (shared, physical) = (hal.shared_instance(), hal.raw_physical_device());
    let instance = shared.raw_instance();
    // SAFETY: the handle is that of the instance's own device.
    let version = unsafe { instance.get_physical_device_properties(physical) }.api_version;
    // The property is of 1.2, and so is what the modules are built for.
    if version.min(shared.instance_api_version()) < vk::API_VERSION_1_2 {
        return false;
    }
    let mut controls = vk::PhysicalDeviceFloatControlsProperties::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut controls);
    // SAFETY: as above; instances from 1.1 on have the call.
    unsafe { instance.get_physical_device_properties2(physical, &mut all) };
    controls.shader_signed_zero_inf_nan_preserve_float32 == vk::TRUE
}

/// Metal and browsers take no SPIR-V.
#[cfg(any(target_vendor = "apple", target_arch = "wasm32"))]
pub(crate) fn may_preserve(_device: &wgpu::Device) -> bool {
    false
}

/// Returns the module (SPIR-V 1.4 or later, one entry point) with `SignedZeroInfNanPreserve 32` declared; as it is where it cannot be read.
pub(crate) fn preserve(words: &[u32]) -> Vec<u32> {
    let (mut capabilities, mut modes, mut entry) = (0, 0, None);
    let mut at = HEADER;
    while let Some(&word) = words.get(at) {
        let (opcode, count) = (word & 0xFFFF, (word >> 16) as usize);
        if count == 0 || at + count > words.len() {
            return words.to_vec();
        }
        match opcode {
            OP_CAPABILITY => capabilities = at + count,
            OP_ENTRY_POINT => (modes, entry) = (at + count, words.get(at + 2)),
            OP_EXECUTION_MODE => modes = at + count,
            _ => {}
        }
        at += count;
    }
    let Some(&entry) = entry.filter(|_| capabilities > 0) else { return words.to_vec() };
    let mut out = words[..capabilities].to_vec();
    out.extend([(2 << 16) | OP_CAPABILITY, CAPABILITY]);
    out.extend(&words[capabilities..modes]);
    out.extend([(4 << 16) | OP_EXECUTION_MODE, entry, MODE, 32]);
    out.extend(&words[modes..]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Variant, module};
    use std::process::Command;
    use twinlight_kernels::passes::PASSES;

    fn words(variant: Variant, pass: &str) -> Vec<u32> {
        bytemuck::pod_collect_to_vec(module(variant, pass).unwrap())
    }

    #[test]
    fn every_strict_module_gets_the_mode_once_and_in_its_place() {
        for variant in [Variant::Strict, Variant::StrictNative] {
            for pass in PASSES {
                let before = words(variant, pass.name);
                let after = preserve(&before);
                assert_eq!(after.len(), before.len() + 6, "{}", pass.name);
                let mode: Vec<_> = after.windows(2).enumerate().filter(|w| w.1 == [MODE, 32]).collect();
                // In the words of one OpExecutionMode, right after another.
                let [(at, _)] = mode[..] else { panic!("{}: {mode:?}", pass.name) };
                assert_eq!(after[at - 2], (4 << 16) | OP_EXECUTION_MODE, "{}", pass.name);
                assert_eq!(after[at - 8] & 0xFFFF, OP_EXECUTION_MODE, "{}: LocalSize x y z", pass.name);
            }
        }
        assert_eq!(preserve(&[1, 2, 3]), [1, 2, 3]);
        assert_eq!(preserve(&[0, 0, 0, 0, 0, 0]), [0; 6], "an instruction without words");
    }

    #[test]
    fn modules_with_the_mode_are_valid() {
        if Command::new("spirv-val").arg("--version").output().is_err() {
            eprintln!("SKIPPED: spirv-val is not installed (Debian: apt-get install spirv-tools)");
            return;
        }
        let folder = std::env::temp_dir().join(format!("twinlight-modes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let valid = |words: &[u32]| {
            let file = folder.join("module.spv");
            std::fs::write(&file, bytemuck::cast_slice::<u32, u8>(words)).unwrap();
            let ran =
                Command::new("spirv-val").args(["--target-env", "vulkan1.2"]).arg(&file).output().unwrap();
            ran.status.success()
        };
        for (pass, variant) in PASSES.iter().flat_map(|p| [(p, Variant::Strict), (p, Variant::StrictNative)])
        {
            assert!(valid(&preserve(&words(variant, pass.name))), "{} {variant:?}", pass.name);
        }
        // Negative control: the mode without its capability.
        let mut spoilt = preserve(&words(Variant::Strict, "upsample"));
        let at = spoilt.windows(2).position(|w| w == [(2 << 16) | OP_CAPABILITY, CAPABILITY]).unwrap();
        spoilt.drain(at..at + 2);
        assert!(!valid(&spoilt));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
