//! What is a typed buffer on the GPU?

use crate::{Gpu, GpuError};
use bytemuck::Pod;
use std::marker::PhantomData;

/// A typed storage buffer.
#[derive(Debug)]
pub struct GpuBuffer<T> {
    pub(crate) raw: RawBuffer,
    element: PhantomData<T>,
}

/// A storage buffer without its element type.
#[derive(Debug, Clone)]
pub(crate) struct RawBuffer {
    pub(crate) buffer: wgpu::Buffer,
    /// Number of elements; the buffer itself is never empty, because an empty one cannot be bound.
    pub(crate) len: usize,
    pub(crate) bytes: u64,
}

impl<T: Pod> GpuBuffer<T> {
    /// Adopts the host's buffer of `len` elements; it must have the usages STORAGE, COPY_SRC and COPY_DST.
    pub fn from_wgpu(buffer: wgpu::Buffer, len: usize) -> Self {
        let bytes = (len * size_of::<T>()) as u64;
        Self { raw: RawBuffer { buffer, len, bytes }, element: PhantomData }
    }

    /// The wgpu buffer, for the host's own passes.
    pub fn wgpu(&self) -> &wgpu::Buffer {
        &self.raw.buffer
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.raw.len
    }

    /// True for a buffer without elements.
    pub fn is_empty(&self) -> bool {
        self.raw.len == 0
    }

    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        self.raw.bytes
    }

    pub(crate) fn raw(&self) -> &RawBuffer {
        &self.raw
    }
}

impl Gpu {
    /// A buffer of `len` zeros.
    pub fn alloc<T: Pod>(&mut self, label: &str, len: usize) -> Result<GpuBuffer<T>, GpuError> {
        let bytes = len as u64 * size_of::<T>() as u64;
        self.check_size(label, bytes)?;
        let size = bytes.max(size_of::<T>() as u64).max(16);
        let buffer = self.scoped(label, |gpu| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let stage = self.timestamps.stage();
        if let Some(list) = &mut self.allocations {
            list.push((stage, label.to_owned(), bytes));
        }
        Ok(GpuBuffer { raw: RawBuffer { buffer, len, bytes }, element: PhantomData })
    }

    /// A buffer that holds a copy of `data`.
    pub fn upload<T: Pod>(&mut self, label: &str, data: &[T]) -> Result<GpuBuffer<T>, GpuError> {
        let buffer = self.alloc(label, data.len())?;
        if !data.is_empty() {
            self.scoped(label, |gpu| {
                gpu.queue.write_buffer(&buffer.raw.buffer, 0, bytemuck::cast_slice(data))
            })?;
        }
        Ok(buffer)
    }

    /// Overwrites the first `data.len()` elements after everything recorded so far; data beyond the buffer is dropped.
    pub fn write<T: Pod>(&mut self, buffer: &mut GpuBuffer<T>, data: &[T]) -> Result<(), GpuError> {
        // A queue write runs before the next submission: what is recorded must be submitted first.
        self.submit()?;
        let data = &data[..data.len().min(buffer.raw.len)];
        if data.is_empty() {
            return Ok(());
        }
        self.scoped("a buffer write", |gpu| {
            gpu.queue.write_buffer(&buffer.raw.buffer, 0, bytemuck::cast_slice(data))
        })
    }

    /// Sets every element to zero, in order with the passes.
    pub fn clear<T: Pod>(&mut self, buffer: &mut GpuBuffer<T>) -> Result<(), GpuError> {
        self.encoder().clear_buffer(&buffer.raw.buffer, 0, None);
        Ok(())
    }

    /// A copy of the buffer's elements, after everything recorded so far.
    pub fn download<T: Pod>(&mut self, buffer: &GpuBuffer<T>) -> Result<Vec<T>, GpuError> {
        if buffer.is_empty() {
            self.submit()?;
            return Ok(Vec::new());
        }
        let size = buffer.raw.bytes.next_multiple_of(4);
        let staging = self.scoped("a download", |gpu| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("download"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        })?;
        self.encoder().copy_buffer_to_buffer(&buffer.raw.buffer, 0, &staging, 0, size);
        self.submit()?;
        let bytes = self.read_mapped(&staging)?;
        // The mapping's alignment need not be T's.
        Ok(bytemuck::pod_collect_to_vec(&bytes[..buffer.raw.bytes as usize]))
    }

    /// Waits for the device, then reads a mappable buffer.
    pub(crate) fn read_mapped(&mut self, staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        // On a device that is gone this is a validation error, which outside a scope would be a panic.
        self.scoped("a download", |_| {
            staging.map_async(wgpu::MapMode::Read, .., move |result| {
                let _ = sender.send(result);
            });
        })?;
        self.wait()?;
        match receiver.recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(self.lost("a download", e)),
            Err(e) => return Err(self.lost("a download", e)),
        }
        let view = staging.get_mapped_range(..).map_err(|e| self.lost("a download", e))?;
        let bytes = view.to_vec();
        drop(view);
        staging.unmap();
        Ok(bytes)
    }

    fn check_size(&self, label: &str, bytes: u64) -> Result<(), GpuError> {
        let limits = &self.limits;
        let allowed = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > allowed {
            return Err(GpuError::LimitTooSmall {
                what: format!("buffer '{label}' (bytes)"),
                needed: bytes,
                allowed,
            });
        }
        Ok(())
    }
}
