//! Sums vectors on all cores with one pass: `cargo run -p twinlight-cpu --example reduce`.

use glam::Vec4;
use twinlight_cpu::{Cpu, CpuError};
use twinlight_kernels::passes::elements::ReduceParams;

fn main() -> Result<(), CpuError> {
    let mut cpu = Cpu::new(None)?;
    let values: Vec<Vec4> = (0..64).map(|i| Vec4::splat(i as f32)).collect();
    let mut values = cpu.upload("values", &values)?;
    let mut count = 64u32;
    while count > 1 {
        let blocks = count.div_ceil(8);
        let mut sums = cpu.alloc("sums", blocks as usize)?;
        cpu.reduce_sum(&ReduceParams { count, ..Default::default() }, &values, &mut sums, blocks)?;
        (values, count) = (sums, blocks);
    }
    println!("{} on {} threads", cpu.download(&values)[0].x, cpu.threads());
    Ok(())
}
