//! Does the path tracer give what can be computed by hand?
//!
//! Means are compared within four of their own standard errors; each comparison also shows that it would notice a
//! planted fault.

#[path = "../support/mod.rs"]
mod support;

mod emission;
mod holes;
mod lights;
mod lobe;
mod run;
mod sky;
mod stages;
