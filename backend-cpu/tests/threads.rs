//! Do passes over real threads write what one thread writes? Small enough for Miri and for sanitizers.

use twinlight_cpu::Cpu;
use twinlight_kernels::passes::elements::{AddParams, DigitParams, ScanParams};

/// Items of a launch: several chunks of the threads, few for an interpreter.
const ITEMS: u32 = if cfg!(miri) { 200 } else { 20_000 };

fn sorted(threads: usize) -> Vec<u32> {
    let mut cpu = Cpu::new(Some(threads)).unwrap();
    let items: Vec<u32> = (0..ITEMS).flat_map(|i| [i.wrapping_mul(0x9E37_79B9) >> 28, i]).collect();
    let blocks = ITEMS.div_ceil(twinlight_kernels::passes::sort::SORT_BLOCK);
    let params = DigitParams { count: ITEMS, blocks, ..Default::default() };
    let items = cpu.upload("items", &items).unwrap();
    let mut counts = cpu.alloc("counts", 16 * blocks as usize).unwrap();
    cpu.count_digits(&params, &items, &mut counts, ITEMS).unwrap();
    let mut offsets = cpu.download(&counts);
    let mut sum = 0;
    for x in &mut offsets {
        (*x, sum) = (sum, sum + *x);
    }
    let offsets = cpu.upload("offsets", &offsets).unwrap();
    let mut places = cpu.alloc("places", 2 * ITEMS as usize).unwrap();
    cpu.place_by_digit(&params, &items, &offsets, &mut places, ITEMS).unwrap();
    cpu.download(&places)
}

#[test]
fn scattered_words_are_those_of_one_thread() {
    let one = sorted(1);
    assert!(one.chunks_exact(2).map(|pair| pair[0]).is_sorted());
    for threads in [2, 4] {
        assert_eq!(sorted(threads), one, "{threads} threads");
    }
}

#[test]
fn mapped_words_are_those_of_one_thread() {
    let run = |threads: usize| {
        let mut cpu = Cpu::new(Some(threads)).unwrap();
        let values: Vec<u32> = (0..ITEMS).map(|i| i % 7).collect();
        let values = cpu.upload("values", &values).unwrap();
        let mut sums = cpu.alloc("sums", ITEMS as usize).unwrap();
        let params = ScanParams { count: ITEMS, ..Default::default() };
        cpu.scan_blocks(&params, &values, &mut sums, ITEMS).unwrap();
        let (a, b) = (vec![glam::Vec4::ONE; ITEMS as usize], vec![glam::Vec4::splat(0.1); ITEMS as usize]);
        let (a, b) = (cpu.upload("a", &a).unwrap(), cpu.upload("b", &b).unwrap());
        let mut sum = cpu.alloc("sum", ITEMS as usize).unwrap();
        cpu.add_radiance(&AddParams::default(), &a, &b, &mut sum, ITEMS).unwrap();
        (cpu.download(&sums), cpu.download(&sum))
    };
    assert_eq!(run(1), run(4));
}

/// For sanitizers and Miri, which must object to it: `cargo test … -- --ignored`.
#[test]
#[ignore = "a race on purpose"]
fn a_race_on_purpose() {
    static mut CELL: u32 = 0;
    let add = || {
        for _ in 0..100 {
            let cell = &raw mut CELL;
            // SAFETY: none: two threads write at once. Tools that look for races are tried on it, nothing else runs it.
            // Volatile, or nobody would have to write what nobody reads.
            unsafe { cell.write_volatile(cell.read_volatile() + 1) };
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(add);
        scope.spawn(add);
    });
}
