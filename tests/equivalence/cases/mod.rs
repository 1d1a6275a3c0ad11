//! On which inputs is each pass compared?

mod arrays;
mod evaluate;
mod scene;
mod spherical;
mod proxies;
mod visibility;

pub use arrays::*;
pub use evaluate::*;
pub use scene::*;
pub use spherical::*;
pub use proxies::*;
pub use visibility::*;
