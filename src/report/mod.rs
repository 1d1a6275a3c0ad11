//! How far apart are two results, and what did it cost?

pub mod agreement;
pub mod error;
pub mod halves;
pub mod machine;
pub mod pareto;
