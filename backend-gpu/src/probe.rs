//! Does this device compute as the CPU does?

use crate::{Gpu, GpuError, Variant};
use twinlight_kernels::passes::elementary::{evaluate_elementary, function};
use twinlight_kernels::passes::elements::{DigitParams, ElementaryParams};
use twinlight_kernels::passes::sort::{DIGITS, SORT_BLOCK};

/// How a device rounds f32 to 16 bits; Vulkan leaves it open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HalfRounding {
    /// To the nearest, ties to even.
    Nearest,
    /// Toward zero.
    TowardZero,
    /// Neither.
    Other,
}

/// What a device does with floats, found by running the elementary functions on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Probe {
    /// SPIR-V reaches the driver unchanged.
    pub passthrough: bool,
    /// (x + y) − x is not simplified when decorated with `NoContraction`.
    pub sums_kept: bool,
    /// x·y + x is rounded twice when decorated with `NoContraction`.
    pub products_rounded: bool,
    /// The device's own division is correctly rounded.
    pub division: bool,
    /// The device's own square root is correctly rounded.
    pub square_root: bool,
    /// Denormal results of multiplication are kept (either way is fine for strict kernels).
    pub denormals: bool,
    /// floor and conversion to integers are exact.
    pub conversions: bool,
    /// Integer atomics lose no addition; every scatter pass rests on them.
    pub atomics: bool,
    /// Rounding of f32 to 16 bits; no kernel converts that way.
    pub half: HalfRounding,
    /// Every elementary function gives the CPU's bits, with division and square root in software.
    pub elementary: bool,
    /// The same for NaN and infinities. Pictures do not need it, as they have none.
    pub specials: bool,
}

impl Probe {
    /// The modules that give the CPU's bits on this device, or why none do.
    pub fn strict_variant(&self) -> Result<Variant, String> {
        let needs = [
            (self.passthrough, "it does not load SPIR-V unchanged (no shader passthrough)"),
            (self.sums_kept, "it re-associates decorated sums"),
            (self.products_rounded, "it contracts decorated products"),
            (self.conversions, "floor or conversion to integers is not exact"),
            (self.atomics, "its integer atomics lose additions"),
            (self.elementary, "the elementary functions differ from the CPU's"),
        ];
        for (holds, reason) in needs {
            if !holds {
                return Err(reason.into());
            }
        }
        Ok(if self.division && self.square_root { Variant::StrictNative } else { Variant::Strict })
    }
}

/// Hard pairs: mantissas near 1, near 2 and near each other, over moderate exponents.
fn pairs() -> (Vec<f32>, Vec<f32>) {
    let mut state = 0x2545_F491u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    let mut x = Vec::new();
    let mut y = Vec::new();
    for i in 0..4096u32 {
        let a = next() & 0x007F_FFFF;
        let b = match i % 4 {
            0 => next() & 0x007F_FFFF,
            1 => 0x007F_FFFF - (next() & 0xFF),
            2 => (a + (next() & 3)) & 0x007F_FFFF,
            _ => next() & 0xFF,
        };
        let exponent = |r: u32| 110 + (r % 34);
        x.push(f32::from_bits(a | (exponent(next()) << 23) | (next() & 0x8000_0000)));
        y.push(f32::from_bits(b | (exponent(next()) << 23)));
    }
    x.push(0.0);
    y.push(1.5);
    (x, y)
}

/// Every pair of NaN, infinities and a few other numbers.
fn specials() -> (Vec<f32>, Vec<f32>) {
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, 1.0, -2.5, 1.0e30];
    values.iter().flat_map(|x| values.iter().map(move |y| (x, y))).unzip()
}

/// Equal bits, any NaN equal to any NaN, −0 equal to 0, results below 2⁻¹²⁶ equal to 0.
fn same(a: f32, b: f32) -> bool {
    let flush = |v: f32| if v.abs() < f32::MIN_POSITIVE { 0.0 } else { v };
    (a.is_nan() && b.is_nan()) || flush(a) == flush(b)
}

impl Gpu {
    /// Runs the probe; leaves the modules in use as they were.
    pub fn run_probe(&mut self) -> Result<Probe, GpuError> {
        let mut probe = Probe {
            passthrough: self.has_passthrough(),
            sums_kept: false,
            products_rounded: false,
            division: false,
            square_root: false,
            denormals: false,
            conversions: false,
            atomics: self.atomics_are_exact()?,
            half: self.half_rounding()?,
            elementary: false,
            specials: false,
        };
        if !probe.passthrough {
            return Ok(probe);
        }
        let before = self.variant();
        self.set_variant(Variant::StrictNative);
        probe.division = self.agrees(function::DIV)?;
        probe.square_root = self.agrees(function::SQRT)?;
        self.set_variant(Variant::Strict);
        probe.sums_kept = self.agrees(function::ADD_SUBTRACT)?;
        probe.products_rounded = self.agrees(function::MULTIPLY_ADD)?;
        probe.conversions = self.agrees(function::FLOOR)? && self.agrees(function::TO_INTEGER)?;
        (probe.elementary, probe.specials) = (true, true);
        for f in function::EXP2..=function::DIV {
            probe.elementary &= self.agrees(f)?;
            probe.specials &= self.agrees_on(f, &specials())?;
        }
        probe.denormals = self.evaluate(function::MULTIPLY, &[1.0e-20], &[1.0e-20])?[0] != 0.0;
        self.set_variant(before);
        self.take_timings()?;
        Ok(probe)
    }

    /// Counts 4096 digits, all into few cells, with the scatter pass that does it for the sort.
    fn atomics_are_exact(&mut self) -> Result<bool, GpuError> {
        let pairs: Vec<u32> = (0..4096).flat_map(|i| [i % 3, i]).collect();
        let blocks = 4096 / SORT_BLOCK;
        let items = self.upload("probe pairs", &pairs)?;
        let mut counts = self.alloc("probe counts", (DIGITS * blocks) as usize)?;
        let params = DigitParams { count: 4096, blocks, ..Default::default() };
        self.count_digits(&params, &items, &mut counts, 4096)?;
        let counts = self.download(&counts)?;
        let of_digit =
            |d: u32| counts[(d * blocks) as usize..((d + 1) * blocks) as usize].iter().sum::<u32>();
        Ok((of_digit(0), of_digit(1), of_digit(2)) == (1366, 1365, 1365)
            && counts.iter().sum::<u32>() == 4096)
    }

    /// Packs numbers beside and between two halves.
    fn half_rounding(&mut self) -> Result<HalfRounding, GpuError> {
        const SOURCE: &str = "@group(0) @binding(0) var<storage, read_write> cells: array<u32>;
            @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                cells[id.x] = pack2x16float(vec2<f32>(bitcast<f32>(cells[id.x]), 0.0));
            }";
        // In units of the last place of 1 as a half: just above a half, a tie to even, a tie to odd, all of it.
        let steps = [0.501f32, 0.5, 1.5, 1.0];
        let inputs: Vec<u32> = steps.iter().map(|s| (1.0 + s / 1024.0).to_bits()).collect();
        let cells = self.upload("probe halves", &inputs)?;
        let group = self.scoped("the probe of halves", |gpu| {
            let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("probe halves"),
                source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
            });
            let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("probe halves"),
                layout: None,
                module: &module,
                entry_point: Some("main"),
                compilation_options: Default::default(),
                cache: None,
            });
            let group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("probe halves"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: cells.wgpu().as_entire_binding() }],
            });
            (pipeline, group)
        })?;
        {
            let mut pass = self.encoder().begin_compute_pass(&Default::default());
            pass.set_pipeline(&group.0);
            pass.set_bind_group(0, &group.1, &[]);
            pass.dispatch_workgroups(steps.len() as u32, 1, 1);
        }
        let one = 0x3C00;
        Ok(match self.download(&cells)?[..] {
            [a, b, c, d] if [a, b, c, d] == [one + 1, one, one + 2, one + 1] => HalfRounding::Nearest,
            [a, b, c, d] if [a, b, c, d] == [one, one, one + 1, one + 1] => HalfRounding::TowardZero,
            _ => HalfRounding::Other,
        })
    }

    fn agrees(&mut self, which: u32) -> Result<bool, GpuError> {
        self.agrees_on(which, &pairs())
    }

    fn agrees_on(&mut self, which: u32, (x, y): &(Vec<f32>, Vec<f32>)) -> Result<bool, GpuError> {
        let params = ElementaryParams { function: which, ..Default::default() };
        let got = self.evaluate(which, x, y)?;
        Ok(got.iter().enumerate().all(|(i, &g)| same(g, evaluate_elementary(i as u32, &params, x, y))))
    }

    fn evaluate(&mut self, which: u32, x: &[f32], y: &[f32]) -> Result<Vec<f32>, GpuError> {
        let params = ElementaryParams { function: which, ..Default::default() };
        let (bx, by) = (self.upload("probe x", x)?, self.upload("probe y", y)?);
        let mut out = self.alloc("probe result", x.len())?;
        self.evaluate_elementary(&params, &bx, &by, &mut out, x.len() as u32)?;
        self.download(&out)
    }
}
