//! How is each pass of the list dispatched over threads?

use crate::buffer::AtomicView;
use crate::{Cpu, CpuBuffer, CpuError};
use rayon::prelude::*;
use std::time::Instant;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{self, info};

/// Items below which splitting a pass costs more than it gains.
const MIN_ITEMS: usize = 64;

macro_rules! dispatcher {
    ($(#[$doc:meta])* map $name:ident($params:ty; $($input:ident: $element:ty),*) -> $output:ident: $out:ty) => {
        $(#[$doc])*
        ///
        /// One value of the output per item; `items` may be smaller than the output.
        pub fn $name(
            &mut self,
            params: &$params,
            $($input: &CpuBuffer<$element>,)*
            $output: &mut CpuBuffer<$out>,
            items: u32,
        ) -> Result<(), CpuError> {
            let start = Instant::now();
            let bytes = $output.bytes() $(+ $input.bytes())*;
            let capacity = $output.len();
            if items as usize > capacity {
                return Err(CpuError::TooManyItems { pass: stringify!($name), items, capacity });
            }
            $(let $input = $input.as_slice();)*
            let values = &mut $output.values[..items as usize];
            self.pool.install(|| {
                values.par_iter_mut().enumerate().with_min_len(MIN_ITEMS).for_each(|(index, value)| {
                    *value = passes::$name(index as u32, params, $($input),*);
                });
            });
            self.record(&info::$name, items, bytes, start.elapsed());
            Ok(())
        }
    };
    ($(#[$doc:meta])* scatter $name:ident($params:ty; $($input:ident: $element:ty),*) -> $output:ident: $out:ty) => {
        $(#[$doc])*
        ///
        /// Accumulates into the output; clear it first unless sums shall go on.
        pub fn $name(
            &mut self,
            params: &$params,
            $($input: &CpuBuffer<$element>,)*
            $output: &mut CpuBuffer<$out>,
            items: u32,
        ) -> Result<(), CpuError> {
            let start = Instant::now();
            let bytes = $output.bytes() $(+ $input.bytes())*;
            $(let $input = $input.as_slice();)*
            let view = AtomicView::new(&mut $output.values);
            self.pool.install(|| {
                (0..items).into_par_iter().with_min_len(MIN_ITEMS).for_each(|index| {
                    let mut output = view;
                    passes::$name(index, params, $($input,)* &mut output);
                });
            });
            self.record(&info::$name, items, bytes, start.elapsed());
            Ok(())
        }
    };
}

macro_rules! dispatchers {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Cpu {
            $(dispatcher! { $(#[$doc])* $shape $name($params; $($input: $element),*) -> $output: $out })*
        }
    };
}

twinlight_kernels::for_each_pass!(dispatchers);
