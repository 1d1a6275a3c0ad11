//! How long did each pass take on the device?

use crate::{Gpu, GpuError};
use twinlight_kernels::passes::PassTiming;

/// Passes that one query set can time.
const CAPACITY: u32 = 512;

/// Timestamp queries around each pass, where the device has them.
pub(crate) struct Timestamps {
    queries: Option<wgpu::QuerySet>,
    resolved: Option<wgpu::Buffer>,
    /// Nanoseconds per tick.
    period: f64,
    /// The part of a technique that the next passes belong to.
    stage: &'static str,
    /// Passes recorded since the last submission.
    current: Vec<PassTiming>,
    /// Submitted passes with the buffer that will hold their ticks.
    pending: Vec<(Vec<PassTiming>, Option<wgpu::Buffer>)>,
}

impl Timestamps {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let have = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = have.then(|| {
            device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * CAPACITY,
            })
        });
        let resolved = have.then(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass timestamps"),
                size: u64::from(CAPACITY) * 16,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        });
        Self {
            queries,
            resolved,
            period: f64::from(queue.get_timestamp_period()),
            stage: "",
            current: Vec::new(),
            pending: Vec::new(),
        }
    }

    pub(crate) fn stage(&self) -> &'static str {
        self.stage
    }

    pub(crate) fn full(&self) -> bool {
        self.current.len() >= CAPACITY as usize
    }

    /// Notes a pass and returns its slot.
    pub(crate) fn begin(&mut self, pass: &'static str, items: u32, bytes: u64) -> Option<u32> {
        let stage = self.stage;
        self.current.push(PassTiming { pass, stage, items, bytes, nanoseconds: f64::NAN });
        self.queries.as_ref().map(|_| self.current.len() as u32 - 1)
    }

    pub(crate) fn writes(&self, slot: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.queries.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(2 * slot),
            end_of_pass_write_index: Some(2 * slot + 1),
        })
    }

    /// Copies the ticks of the passes recorded so far to a buffer that can be read later.
    pub(crate) fn resolve(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) {
        if self.current.is_empty() {
            return;
        }
        let count = self.current.len() as u32;
        let readback = match (&self.queries, &self.resolved) {
            (Some(queries), Some(resolved)) => {
                let readback = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("pass timestamps"),
                    size: u64::from(count) * 16,
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                });
                encoder.resolve_query_set(queries, 0..2 * count, resolved, 0);
                encoder.copy_buffer_to_buffer(resolved, 0, &readback, 0, u64::from(count) * 16);
                Some(readback)
            }
            _ => None,
        };
        self.pending.push((std::mem::take(&mut self.current), readback));
        // Nobody asked for a long time: the oldest are dropped so that memory stays flat.
        if self.pending.len() > 4096 {
            self.pending.drain(..2048);
        }
    }
}

impl Gpu {
    /// Names the part of a technique that the passes from here on belong to, for their timings.
    pub fn set_stage(&mut self, stage: &'static str) {
        self.timestamps.stage = stage;
    }

    /// The timings of the passes since the last call, in order, after everything recorded has run.
    ///
    /// Nanoseconds are NaN where the device has no timestamps.
    pub fn take_timings(&mut self) -> Result<Vec<PassTiming>, GpuError> {
        self.finish()?;
        let mut all = Vec::new();
        for (mut passes, readback) in std::mem::take(&mut self.timestamps.pending) {
            if let Some(buffer) = readback {
                let bytes = self.read_mapped(&buffer)?;
                let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
                for (i, pass) in passes.iter_mut().enumerate() {
                    pass.nanoseconds =
                        ticks[2 * i + 1].saturating_sub(ticks[2 * i]) as f64 * self.timestamps.period;
                }
            }
            all.extend(passes);
        }
        Ok(all)
    }
}
