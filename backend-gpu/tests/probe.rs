//! What does the start-up probe find on this device?
use twinlight_gpu::{Arithmetic, Gpu, GpuOptions};

#[test]
fn probe() {
    let mut gpu = Gpu::new(&GpuOptions::default()).unwrap();
    println!("{}", twinlight_gpu::describe(gpu.adapter()));
    println!("{:#?}", gpu.run_probe().unwrap());
    let gpu = Gpu::new(&GpuOptions { arithmetic: Arithmetic::Strict, ..Default::default() }).unwrap();
    println!("{:?}", gpu.variant());
}
