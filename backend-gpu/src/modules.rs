//! Which SPIR-V module belongs to a pass?

/// How a SPIR-V module computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variant {
    /// `NoContraction` everywhere, division and square root in software: right on any conforming device.
    Strict,
    /// `NoContraction` everywhere, the device's division and square root: where the probe finds them correctly rounded.
    StrictNative,
    /// The driver's functions, contraction allowed.
    Fast,
}

macro_rules! modules {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        /// The SPIR-V of a pass, little-endian words; none for a name that is not in the list.
        pub fn module(variant: Variant, pass: &str) -> Option<&'static [u8]> {
            match (variant, pass) {
                $(
                    (Variant::Strict, stringify!($name)) =>
                        Some(include_bytes!(concat!("../spirv/strict/", stringify!($name), ".spv"))),
                    (Variant::StrictNative, stringify!($name)) =>
                        Some(include_bytes!(concat!("../spirv/strict-native/", stringify!($name), ".spv"))),
                    (Variant::Fast, stringify!($name)) =>
                        Some(include_bytes!(concat!("../spirv/fast/", stringify!($name), ".spv"))),
                )*
                _ => None,
            }
        }
    };
}

twinlight_kernels::for_each_pass!(modules);
