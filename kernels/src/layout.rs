//! How is a buffer element laid out, so that host and device can be compared?

/// What a 32-bit word of a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordKind {
    /// An IEEE binary32 number.
    Float,
    /// An unsigned integer, index or set of bits: compared exactly.
    Unsigned,
}

/// One member of a buffer element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// The member's name.
    pub name: &'static str,
    /// Byte offset in the element.
    pub offset: u32,
    /// Number of 32-bit words.
    pub words: u32,
    /// What the words hold.
    pub kind: WordKind,
}

/// A type that a member of a buffer element may have.
pub trait Member {
    /// Number of 32-bit words.
    const WORDS: u32;
    /// What the words hold.
    const KIND: WordKind;
}

/// A type whose arrays fill storage buffers and parameter blocks.
pub trait Element: Copy {
    /// The type's name.
    const NAME: &'static str;
    /// Its members in order; they cover every byte.
    const FIELDS: &'static [Field];
}

macro_rules! members {
    ($($ty:ty: $words:expr, $kind:ident;)*) => {$(
        impl Member for $ty {
            const WORDS: u32 = $words;
            const KIND: WordKind = WordKind::$kind;
        }
        impl Element for $ty {
            const NAME: &'static str = stringify!($ty);
            const FIELDS: &'static [Field] =
                &[Field { name: "value", offset: 0, words: $words, kind: WordKind::$kind }];
        }
    )*};
}

members! {
    f32: 1, Float;
    u32: 1, Unsigned;
    glam::Vec4: 4, Float;
    glam::UVec4: 4, Unsigned;
    glam::Mat4: 16, Float;
}

/// Declares a buffer element or parameter block: `repr(C)`, `Pod`, with its [`Element`] description.
///
/// Members may be `f32`, `u32`, `Vec4`, `UVec4` and `Mat4`; sizes must be multiples of 16 bytes (checked when
/// compiling) and padding must be named.
#[macro_export]
macro_rules! gpu_struct {
    ($($(#[$meta:meta])* pub struct $Name:ident {
        $($(#[$field_meta:meta])* pub $field:ident: $ty:ty,)*
    })*) => {$(
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy)]
        #[cfg_attr(
            not(target_arch = "spirv"),
            derive(Debug, Default, PartialEq, $crate::bytemuck::Pod, $crate::bytemuck::Zeroable)
        )]
        #[cfg_attr(not(target_arch = "spirv"), bytemuck(crate = "bytemuck"))]
        pub struct $Name { $($(#[$field_meta])* pub $field: $ty,)* }

        impl $crate::layout::Element for $Name {
            const NAME: &'static str = stringify!($Name);
            const FIELDS: &'static [$crate::layout::Field] = &[$($crate::layout::Field {
                name: stringify!($field),
                offset: core::mem::offset_of!($Name, $field) as u32,
                words: <$ty as $crate::layout::Member>::WORDS,
                kind: <$ty as $crate::layout::Member>::KIND,
            },)*];
        }

        const _: () = assert!(
            core::mem::size_of::<$Name>() % 16 == 0,
            concat!(stringify!($Name), " must be a multiple of 16 bytes")
        );
    )*};
}
