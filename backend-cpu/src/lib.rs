//! How do passes run on the CPU? Over rayon, with the same bits for any number of threads.
//!
//! ```
//! use twinlight_cpu::Cpu;
//! use twinlight_kernels::passes::elements::ReduceParams;
//! let mut cpu = Cpu::new(None)?;
//! let values = cpu.upload("values", &[glam::Vec4::ONE; 8])?;
//! let mut sum = cpu.alloc("sum", 1)?;
//! cpu.reduce_sum(&ReduceParams { count: 8, ..Default::default() }, &values, &mut sum, 1)?;
//! assert_eq!(cpu.download(&sum)[0].x, 8.0);
//! # Ok::<(), twinlight_cpu::CpuError>(())
//! ```

mod buffer;
mod passes;

pub use buffer::CpuBuffer;

use bytemuck::{Pod, Zeroable};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use twinlight_kernels::passes::{PassInfo, PassTiming};

/// What can go wrong on the CPU backend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CpuError {
    /// The system would not give the memory.
    #[error("out of memory: buffer '{label}' needs {bytes} bytes; use a smaller size or resolution")]
    OutOfMemory {
        /// The buffer's label.
        label: String,
        /// Its size.
        bytes: u64,
    },
    /// A launch asks for more items than its output holds.
    #[error("pass {pass}: {items} items, but the output holds {capacity}")]
    TooManyItems {
        /// The pass.
        pass: &'static str,
        /// Items asked for.
        items: u32,
        /// Elements of the output.
        capacity: usize,
    },
    /// The thread pool could not be made.
    #[error("cannot start the worker threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

std::thread_local! {
    static RESERVES: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Whether this thread is asking for a buffer's memory, and bears a refusal: for allocators that end the process otherwise.
pub fn bears_refusal() -> bool {
    RESERVES.with(std::cell::Cell::get)
}

/// Stage, label and bytes of a buffer.
type Made = (&'static str, String, u64);

/// Runs passes over a pool of threads and keeps their timings.
pub struct Cpu {
    pool: rayon::ThreadPool,
    timings: Vec<PassTiming>,
    stage: &'static str,
    allocations: Mutex<Option<Vec<Made>>>,
}

impl Cpu {
    /// Starts `threads` worker threads, or one per core.
    pub fn new(threads: Option<usize>) -> Result<Self, CpuError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build()?;
        Ok(Self { pool, timings: Vec::new(), stage: "", allocations: Mutex::new(None) })
    }

    /// Number of worker threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs a closure inside the pool, for work that is not a pass.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// A buffer that holds a copy of `data`.
    pub fn upload<T: Pod>(&self, label: &str, data: &[T]) -> Result<CpuBuffer<T>, CpuError> {
        let mut values = self.reserve(label, data.len())?;
        values.extend_from_slice(data);
        Ok(CpuBuffer { values })
    }

    /// A buffer of `len` zeros.
    pub fn alloc<T: Pod>(&self, label: &str, len: usize) -> Result<CpuBuffer<T>, CpuError> {
        let mut values = self.reserve(label, len)?;
        values.resize(len, T::zeroed());
        Ok(CpuBuffer { values })
    }

    /// Sets every element to zero.
    pub fn clear<T: Pod>(&self, buffer: &mut CpuBuffer<T>) {
        buffer.values.fill(T::zeroed());
    }

    /// Overwrites the first `data.len()` elements; data beyond the buffer is dropped.
    pub fn write<T: Pod>(&self, buffer: &mut CpuBuffer<T>, data: &[T]) {
        let len = data.len().min(buffer.values.len());
        buffer.values[..len].copy_from_slice(&data[..len]);
    }

    /// A copy of the buffer's elements.
    pub fn download<T: Pod>(&self, buffer: &CpuBuffer<T>) -> Vec<T> {
        buffer.values.clone()
    }

    /// The timings since the last call, in order of execution.
    pub fn take_timings(&mut self) -> Vec<PassTiming> {
        std::mem::take(&mut self.timings)
    }

    /// Names the part of a technique that the passes from here on belong to, for their timings.
    pub fn set_stage(&mut self, stage: &'static str) {
        self.stage = stage;
    }

    /// Begins to list every buffer that is made, or ends it and forgets them.
    pub fn log_allocations(&mut self, on: bool) {
        self.allocations = Mutex::new(on.then(Vec::new));
    }

    /// The buffers made since the last call, while they are listed: stage, label and bytes of each, in order.
    pub fn take_allocations(&mut self) -> Vec<(&'static str, String, u64)> {
        let list = self.allocations.get_mut().unwrap_or_else(PoisonError::into_inner);
        list.as_mut().map(std::mem::take).unwrap_or_default()
    }

    fn reserve<T: Zeroable>(&self, label: &str, len: usize) -> Result<Vec<T>, CpuError> {
        let bytes = len as u64 * size_of::<T>() as u64;
        let mut values = Vec::new();
        RESERVES.set(true);
        let reserved = values.try_reserve_exact(len);
        RESERVES.set(false);
        reserved.map_err(|_| CpuError::OutOfMemory { label: label.to_owned(), bytes })?;
        if let Some(list) = self.allocations.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            list.push((self.stage, label.to_owned(), bytes));
        }
        Ok(values)
    }

    fn record(&mut self, pass: &'static PassInfo, items: u32, bytes: u64, time: Duration) {
        let (stage, nanoseconds) = (self.stage, time.as_nanos() as f64);
        self.timings.push(PassTiming { pass: pass.name, stage, items, bytes, nanoseconds });
    }
}
