//! What does the GPU call? One compute entry point per pass of the list, each only unpacking its item.
#![no_std]

use glam::UVec3;
use spirv_std::arch::{atomic_i_add, atomic_or, atomic_u_max, atomic_u_min};
use spirv_std::memory::{Scope, Semantics};
use spirv_std::spirv;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{self, Accumulate, Launch};

/// A storage buffer that threads add to at once.
struct AtomicBuffer<'a> {
    cells: &'a mut [u32],
    /// 0 at run time. Or-ed to each value: naga rejects an atomic whose value comes straight from a loop before it.
    zero: u32,
}

const SCOPE: u32 = Scope::QueueFamily as u32;
const RELAXED: u32 = Semantics::NONE.bits();

macro_rules! atomic {
    ($($method:ident = $operation:ident;)*) => {$(
        #[inline]
        fn $method(&mut self, index: u32, value: u32) {
            if (index as usize) < self.cells.len() {
                // SAFETY: the index is inside; atomics on a storage buffer are sound from any invocation.
                unsafe { $operation::<u32, SCOPE, RELAXED>(&mut self.cells[index as usize], value | self.zero) };
            }
        }
    )*};
}

impl Accumulate for AtomicBuffer<'_> {
    atomic! {
        add = atomic_i_add;
        or = atomic_or;
        min = atomic_u_min;
        max = atomic_u_max;
    }
}

macro_rules! entry_point {
    (map $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out_element:ty) => {
        #[spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(uniform, descriptor_set = 0, binding = 0)] launch: &Launch<$params>,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $binding)] $input: &[$element],)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = $out_binding)] $output: &mut [$out_element],
        ) {
            let index = launch.index(id);
            if index < launch.items {
                $output[index as usize] = passes::$name(index, &launch.params, $($input),*);
            }
        }
    };
    (scatter $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out_element:ty) => {
        #[spirv(compute(threads(64)))]
        pub fn $name(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(uniform, descriptor_set = 0, binding = 0)] launch: &Launch<$params>,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $binding)] $input: &[$element],)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = $out_binding)] $output: &mut [$out_element],
        ) {
            let index = launch.index(id);
            if index < launch.items {
                let mut output = AtomicBuffer { cells: $output, zero: launch.zero };
                passes::$name(index, &launch.params, $($input,)* &mut output);
            }
        }
    };
}

macro_rules! entry_points {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out_element:ty, $tolerance:expr;)*) => {
        $(entry_point! {
            $shape $name($params; $($binding $input: $element),*) -> $out_binding $output: $out_element
        })*
    };
}

twinlight_kernels::for_each_pass!(entry_points);
