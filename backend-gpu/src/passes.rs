//! How is each pass of the list dispatched on the GPU?

use crate::{Gpu, GpuBuffer, GpuError};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::info;

macro_rules! dispatchers {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Gpu {
            $(
                $(#[$doc])*
                ///
                /// Recorded now, run when submitted. A map pass writes one value per item; a scatter pass
                /// accumulates into the output, which must be cleared first unless sums shall go on.
                pub fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &GpuBuffer<$element>,)*
                    $output: &mut GpuBuffer<$out>,
                    items: u32,
                ) -> Result<(), GpuError> {
                    self.run(
                        &info::$name,
                        bytemuck::bytes_of(params),
                        &[$($input.raw(),)*],
                        $output.raw(),
                        items,
                    )
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(dispatchers);
