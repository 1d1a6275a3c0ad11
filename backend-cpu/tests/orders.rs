//! Does a scatter pass give the same bits in every order in which its threads may run?
//!
//! loom runs the kernels over its own atomics in all orders that the memory model allows, with the orderings that the backend uses.

use loom::sync::Arc;
use loom::sync::atomic::{AtomicU32, Ordering};
use loom::thread;
use std::sync::Mutex;
use twinlight_kernels::passes::elements::{CompactParams, DigitParams};
use twinlight_kernels::passes::{Accumulate, compact_indices, count_digits};

/// The backend's view of an output, over loom's atomics.
struct Modelled(Arc<Vec<AtomicU32>>);

macro_rules! atomic {
    ($($method:ident = $operation:ident;)*) => {$(
        fn $method(&mut self, index: u32, value: u32) {
            if let Some(cell) = self.0.get(index as usize) {
                cell.$operation(value, Ordering::Relaxed);
            }
        }
    )*};
}

impl Accumulate for Modelled {
    atomic! { add = fetch_add; or = fetch_or; min = fetch_min; max = fetch_max; }
}

/// A view that reads and writes in two steps: what an accumulation must not be.
struct Racing(Arc<Vec<AtomicU32>>);

macro_rules! torn {
    ($($method:ident = $operation:expr;)*) => {$(
        fn $method(&mut self, index: u32, value: u32) {
            if let Some(cell) = self.0.get(index as usize) {
                let operation: fn(u32, u32) -> u32 = $operation;
                cell.store(operation(cell.load(Ordering::Relaxed), value), Ordering::Relaxed);
            }
        }
    )*};
}

impl Accumulate for Racing {
    torn! { add = u32::wrapping_add; or = |a, b| a | b; min = u32::min; max = u32::max; }
}

/// All outputs that two threads can leave, each with every other item of `items`.
fn outcomes<A: Accumulate + 'static>(
    cells: usize,
    items: u32,
    view: fn(Arc<Vec<AtomicU32>>) -> A,
    item: impl Fn(u32, &mut A) + Copy + Send + Sync + 'static,
) -> Vec<Vec<u32>> {
    let seen = std::sync::Arc::new(Mutex::new(Vec::new()));
    let kept = seen.clone();
    loom::model(move || {
        let output = Arc::new((0..cells).map(|_| AtomicU32::new(0)).collect::<Vec<_>>());
        let other = output.clone();
        let handle =
            thread::spawn(move || (1..items).step_by(2).for_each(|i| item(i, &mut view(other.clone()))));
        (0..items).step_by(2).for_each(|i| item(i, &mut view(output.clone())));
        handle.join().unwrap();
        let values: Vec<u32> = output.iter().map(|c| c.load(Ordering::Relaxed)).collect();
        let mut all = kept.lock().unwrap();
        if !all.contains(&values) {
            all.push(values);
        }
    });
    seen.lock().unwrap().clone()
}

fn digits<A: Accumulate>(index: u32, output: &mut A) {
    // Items (key, value) of one block; most have the same digit: threads meet in its cell.
    let params = DigitParams { count: 4, blocks: 1, ..Default::default() };
    count_digits(index, &params, &[1, 0, 1, 0, 0, 0, 1, 0], output);
}

fn flags<A: Accumulate>(index: u32, output: &mut A) {
    let params = CompactParams { count: 4, ..Default::default() };
    compact_indices(index, &params, &[1, 0, 1, 1], &[0, 1, 1, 2], output);
}

fn operations<A: Accumulate>(index: u32, output: &mut A) {
    output.add(0, index + 1);
    output.or(1, 1 << index);
    output.max(2, 10 + index);
    output.add(99, 1);
}

#[test]
fn every_order_gives_the_same_bits() {
    assert_eq!(outcomes(3, 2, Modelled, operations), [vec![3, 3, 11]]);
    assert_eq!(outcomes(3, 3, Modelled, flags), [vec![0, 2, 0]]);
    assert_eq!(outcomes(2, 4, Modelled, digits), [vec![1, 3]]);
}

#[test]
fn a_race_would_be_seen() {
    assert!(outcomes(3, 2, Racing, operations).len() > 1);
    assert!(outcomes(2, 2, Racing, digits).len() > 1);
}
