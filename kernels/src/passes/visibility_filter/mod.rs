//! Which work items make up the visibility filter (Chen et al. 2014, VF)?
//!
//! [`proxy`] scatters disc-shaped point proxies over the triangles, [`grid`] sorts them into voxels and sums up what
//! a voxel sends out, [`march`] finds the voxels that rays of a coarse pixel meet first, [`list`] joins the lists of
//! neighbouring pixels, [`gather_voxels`] and [`gather_reflection`] add up their light at finer pixels, [`view`] draws the
//! proxies themselves.

pub mod gather_reflection;
pub mod gather_voxels;
pub mod gloss;
pub mod grid;
pub mod list;
pub mod march;
mod merged_lists;
pub mod proxy;
mod seen;
pub mod view;
