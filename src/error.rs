//! What can go wrong with a scene, and what should be done about it?

use std::fmt::Display;

/// Why a scene, light, camera or environment could not be used: one line with what, where and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file could not be read.
    #[error("cannot read {path}: {reason}; check the path and its permissions")]
    Read {
        /// The file.
        path: String,
        /// What the operating system says.
        reason: String,
    },
    /// Neither a file nor a built-in scene.
    #[error("no scene {name:?}: give a .glb or .gltf file or one of cornell-box, cornell-glossy, spheres")]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A file is not the format that it should be.
    #[error(
        "{path} is not usable: {reason}; export it again as glTF 2.0 and run it through the glTF validator"
    )]
    Format {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// A primitive's data is wrong.
    #[error("mesh {mesh}, primitive {primitive}: {reason}; correct the mesh and export it again")]
    Geometry {
        /// The mesh's index, with its name where it has one.
        mesh: String,
        /// Index of the primitive in the mesh.
        primitive: usize,
        /// What is wrong.
        reason: String,
    },
    /// Spheres cannot be fitted.
    #[error("--fit-spheres: {reason}; close the meshes, faces outward, or give --sphere")]
    Proxies {
        /// Why.
        reason: String,
    },
    /// A node, light, material or camera of a file has an impossible value.
    #[error("{what}: {reason}; correct it and export the file again")]
    Value {
        /// Which one.
        what: String,
        /// What is wrong.
        reason: String,
    },
    /// A texture could not be used.
    #[error("image {image}: {reason}; use PNG or JPEG of at most 32768 pixels a side")]
    Texture {
        /// The image's index, with its name where it has one.
        image: String,
        /// What is wrong.
        reason: String,
    },
    /// Nothing is left to render.
    #[error(
        "{path} has no triangles to render ({dropped}); check which scene of the file is the default one"
    )]
    Empty {
        /// The file.
        path: String,
        /// What was left out.
        dropped: String,
    },
    /// More than the buffers can address.
    #[error("{what}: {count} is more than the limit of {limit}; reduce the scene")]
    TooLarge {
        /// What is too large.
        what: String,
        /// How much there is.
        count: u64,
        /// How much there may be.
        limit: u64,
    },
    /// A camera that does not define a picture.
    #[error("camera: {reason}")]
    Camera {
        /// What is wrong and what to do.
        reason: String,
    },
    /// An option's text that can't be understood.
    #[error("{option} {text:?}: {reason}; the form is {expected}")]
    Text {
        /// The option.
        option: &'static str,
        /// What was given.
        text: String,
        /// What is wrong.
        reason: String,
        /// The right form.
        expected: &'static str,
    },
    /// An environment map that can't be used.
    #[error("environment {path}: {reason}; use an equirectangular .hdr or .exr of finite radiances")]
    Environment {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
}

/// A knob of a technique that is out of range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--{knob}: {reason}")]
pub struct SettingsError {
    /// The knob, named as on the command line.
    pub knob: &'static str,
    /// What is wrong, with the range.
    pub reason: String,
}

/// The beginning of a text: all of a long one would hide the message.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    text.chars().take(most).collect()
}

/// Returns the text of `value` on one line.
pub(crate) fn one_line(value: impl Display) -> String {
    value.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
