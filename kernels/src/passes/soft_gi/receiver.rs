//! Which proxies does a receiver meet, and how?

use super::SoftParams;
use super::cull::tile_of;
use crate::passes::surface::Surface;
use crate::sh::{self, Blocker};
use glam::{Vec3, Vec4};

/// A receiver, and where the list of its tile's proxies lies.
#[derive(Clone, Copy)]
pub(super) struct Receiver {
    position: Vec3,
    pub normal: Vec3,
    first: u32,
    /// How many proxies are in the list.
    pub count: u32,
}

impl Receiver {
    /// Receiver `index` at a surface.
    #[inline]
    pub(super) fn new(index: u32, params: &SoftParams, s: &Surface, starts: &[u32], counts: &[u32]) -> Self {
        let tile = tile_of(index, params);
        let (first, count) = (starts[tile as usize], counts[tile as usize]);
        Self { position: s.position.truncate(), normal: s.normal.truncate(), first, count }
    }

    /// The number of proxy `k` of the list.
    #[inline]
    pub(super) fn number(&self, k: u32, lists: &[u32]) -> u32 {
        lists[(self.first + k) as usize]
    }

    /// A proxy, centre and radius, as the receiver meets it.
    #[inline]
    pub(super) fn met(&self, params: &SoftParams, sphere: Vec4) -> Met {
        let blocker = sh::blocker(sphere.truncate(), sphere.w, self.position, self.normal, params.fade);
        Met { blocker, key: sh::occlusion_key(blocker.alpha) }
    }
}

/// A proxy as a receiver meets it.
#[derive(Clone, Copy)]
pub(super) struct Met {
    pub blocker: Blocker,
    /// The key of its size in tables.
    pub key: f32,
}

impl Met {
    /// How much it counts where those below the key `least` do not.
    #[inline]
    pub(super) fn weight(&self, least: f32) -> f32 {
        self.blocker.weight * sh::influence_weight(self.key, least, 2.0)
    }
}
