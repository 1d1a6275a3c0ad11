//! Which work items run over buffers?

pub mod scene;
