//! On which inputs is each pass compared?

mod arrays;
mod evaluate;
mod layered;
mod proxies;
mod scene;
mod soft;
mod spherical;
mod visibility;
mod voxel_light;
mod voxelised;
mod voxels;

pub use arrays::*;
pub use evaluate::*;
pub use layered::*;
pub use proxies::*;
pub use scene::*;
pub use soft::*;
pub use spherical::*;
pub use visibility::*;
pub use voxel_light::*;
pub use voxels::*;
