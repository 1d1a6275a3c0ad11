//! What do tests of both backends share?

pub mod draw;
pub mod gpu;
