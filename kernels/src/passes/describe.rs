//! What does a dispatcher have to know of each pass?

use crate::for_each_pass;
use crate::layout::{Element, Field};

/// How work items write their output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value at the item's own index.
    Map,
    /// Integer accumulation anywhere.
    Scatter,
}

/// How far the fast GPU result of a pass may lie from the strict one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// The same bits (±0 equal): integer passes.
    Exact,
    /// Each float within `relative`·|strict| + `absolute`, but for a share `flips` of the elements.
    Relative {
        /// Allowed relative difference.
        relative: f32,
        /// Allowed absolute difference.
        absolute: f32,
        /// Share of elements that may differ by any amount because a comparison went the other way.
        flips: f32,
    },
}

/// What binds to one binding of a pass.
#[derive(Clone, Copy, Debug)]
pub struct BindingInfo {
    /// Binding number in descriptor set 0; binding 0 is the [`super::Launch`] block.
    pub binding: u32,
    /// The argument's name.
    pub name: &'static str,
    /// The element type's name.
    pub element: &'static str,
    /// Bytes of one element.
    pub stride: u32,
    /// The element's members.
    pub fields: &'static [Field],
}

/// What a dispatcher has to know of a pass.
#[derive(Clone, Copy, Debug)]
pub struct PassInfo {
    /// The name of the function and of the SPIR-V entry point.
    pub name: &'static str,
    /// How it writes.
    pub shape: Shape,
    /// Bytes of the parameter struct.
    pub params_size: u32,
    /// Its inputs in order of binding.
    pub inputs: &'static [BindingInfo],
    /// Its output, the last binding.
    pub output: BindingInfo,
    /// The tolerance of the fast mode.
    pub tolerance: Tolerance,
}

/// How long one run of a pass took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassTiming {
    /// The pass.
    pub pass: &'static str,
    /// The part of a technique that it ran for, empty outside of any.
    pub stage: &'static str,
    /// Its work items.
    pub items: u32,
    /// Bytes of the buffers bound to it.
    pub bytes: u64,
    /// Wall time on the CPU, device time on a GPU; NaN where the device has no timestamps.
    pub nanoseconds: f64,
}

const fn binding_info<T: Element>(binding: u32, name: &'static str) -> BindingInfo {
    BindingInfo {
        binding,
        name,
        element: T::NAME,
        stride: core::mem::size_of::<T>() as u32,
        fields: T::FIELDS,
    }
}

macro_rules! shape {
    (map) => {
        Shape::Map
    };
    (scatter) => {
        Shape::Scatter
    };
}

macro_rules! describe {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out_element:ty, $tolerance:expr;)*) => {
        /// The description of each pass, under the pass's name.
        #[allow(non_upper_case_globals)]
        pub mod info {
            use super::*;
            use crate::passes::elements::*;
            $(
                $(#[$doc])*
                pub const $name: PassInfo = PassInfo {
                    name: stringify!($name),
                    shape: shape!($shape),
                    params_size: core::mem::size_of::<$params>() as u32,
                    inputs: &[$(binding_info::<$element>($binding, stringify!($input)),)*],
                    output: binding_info::<$out_element>($out_binding, stringify!($output)),
                    tolerance: $tolerance,
                };
            )*
        }

        /// Every pass, in the order of the list.
        pub const PASSES: &[PassInfo] = &[$(info::$name,)*];
    };
}

for_each_pass!(describe);
