//! What is asked of a technique, and what does it hand back?

use crate::backend::{Backend, BackendError, BufferElement};
use crate::picture::Picture;
use std::collections::BTreeMap;
use twinlight_kernels::layout::WordKind;
use twinlight_kernels::passes::PassTiming;

/// Which light goes into a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightPart {
    /// All of it.
    #[default]
    All,
    /// Straight from the sources, emission and background.
    Direct,
    /// By way of other surfaces.
    Indirect,
}

/// How light that was gathered at fewer pixels becomes that of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Upsampling {
    /// By place, depth and normal: edges stay sharp.
    #[default]
    Bilateral,
    /// By place: light bleeds over edges.
    Bilinear,
    /// From the nearest.
    Nearest,
}

impl Upsampling {
    /// The kernels' number of it.
    pub(super) fn number(self) -> u32 {
        use twinlight_kernels::passes::upsample::{BILATERAL, BILINEAR, NEAREST};
        match self {
            Self::Bilateral => BILATERAL,
            Self::Bilinear => BILINEAR,
            Self::Nearest => NEAREST,
        }
    }
}

/// Settings that every technique shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Rays per pixel of the passes that trace rays all around.
    pub rays: u32,
    /// Seed of their directions.
    pub seed: u32,
    /// λ of the occlusion's falloff 1/(1 + λ r), 1/m.
    pub falloff: f32,
    /// Distance beyond which nothing occludes, metres.
    pub reach: f32,
    /// Which light goes into the picture.
    pub light: LightPart,
    /// How gathered light is spread over the pixels.
    pub upsampling: Upsampling,
    /// Names of the buffers to keep as pictures.
    pub dumps: Vec<String>,
    /// Count values that are not finite in every buffer.
    pub check_finite: bool,
}

impl Default for Job {
    fn default() -> Self {
        Self {
            rays: 64,
            seed: 1,
            falloff: 0.0,
            reach: 1.0e30,
            light: LightPart::All,
            upsampling: Upsampling::default(),
            dumps: Vec::new(),
            check_finite: false,
        }
    }
}

/// Values of a buffer that are not finite.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NonFinite {
    /// The buffer.
    pub buffer: String,
    /// How many of its floats are NaN or ±∞.
    pub count: u64,
}

/// A picture with all that is known about how it came to be.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Linear radiance.
    pub picture: Picture,
    /// The passes that ran.
    pub timings: Vec<PassTiming>,
    /// Buffers asked for, as pictures.
    pub dumps: BTreeMap<String, Picture>,
    /// One entry per buffer, when asked for.
    pub non_finite: Vec<NonFinite>,
}

/// Looks into the buffers of a running technique.
pub struct Inspection<'a> {
    job: &'a Job,
    width: u32,
    height: u32,
    muted: bool,
    dumps: BTreeMap<String, Picture>,
    non_finite: BTreeMap<String, u64>,
}

impl<'a> Inspection<'a> {
    /// Begins with nothing seen, for pictures of this size.
    pub fn new(job: &'a Job, width: u32, height: u32) -> Self {
        Self { job, width, height, muted: false, dumps: BTreeMap::new(), non_finite: BTreeMap::new() }
    }

    /// Counts what is not finite in a buffer, if that was asked for.
    pub fn check<B: Backend, T: BufferElement>(
        &mut self,
        backend: &mut B,
        name: &str,
        buffer: &B::Buffer<T>,
    ) -> Result<(), BackendError> {
        if !self.job.check_finite {
            return Ok(());
        }
        let values = backend.read_result(buffer)?;
        *self.non_finite.entry(name.to_owned()).or_default() += count_non_finite(&values);
        Ok(())
    }

    /// Keeps a buffer as a picture, if that was asked for; the band begins at `first_pixel`.
    pub fn dump<B: Backend, T: BufferElement>(
        &mut self,
        backend: &mut B,
        name: &str,
        buffer: &B::Buffer<T>,
        first_pixel: u32,
        colour: impl Fn(&T) -> glam::Vec3,
    ) -> Result<(), BackendError> {
        if !self.wants(name) {
            return Ok(());
        }
        let values = backend.read_result(buffer)?;
        let (width, height) = (self.width, self.height);
        let picture = self.dumps.entry(name.to_owned()).or_insert_with(|| Picture::new(width, height));
        for (pixel, value) in picture.pixels[first_pixel as usize..].iter_mut().zip(&values) {
            *pixel = colour(value);
        }
        Ok(())
    }

    /// Keeps a band of grey values, if there are any and the picture was asked for.
    pub fn keep_band(&mut self, name: &str, first_pixel: u32, values: &[f32]) {
        if values.is_empty() || !self.wants(name) {
            return;
        }
        let (width, height) = (self.width, self.height);
        let picture = self.dumps.entry(name.to_owned()).or_insert_with(|| Picture::new(width, height));
        for (pixel, &value) in picture.pixels[first_pixel as usize..].iter_mut().zip(values) {
            *pixel = glam::Vec3::splat(value);
        }
    }

    /// Whether any buffer is looked into.
    pub(super) fn looks(&self) -> bool {
        self.job.check_finite || !self.job.dumps.is_empty()
    }

    /// Whether a buffer is asked for as a picture.
    pub fn wants(&self, name: &str) -> bool {
        !self.muted && self.job.dumps.iter().any(|d| d == name)
    }

    /// Whether a picture of this name is kept already.
    pub fn has(&self, name: &str) -> bool {
        self.dumps.contains_key(name)
    }

    /// Keeps a picture of its own size, if it was asked for.
    pub fn keep(&mut self, name: &str, picture: impl FnOnce() -> Picture) {
        if self.wants(name) {
            self.dumps.insert(name.to_owned(), picture());
        }
    }

    /// Does work whose buffers are not those of the picture: it keeps none.
    pub fn without_dumps<R>(&mut self, work: impl FnOnce(&mut Self) -> R) -> R {
        let before = std::mem::replace(&mut self.muted, true);
        let result = work(self);
        self.muted = before;
        result
    }

    /// Puts the picture together with what was seen.
    pub fn finish(self, picture: Picture, timings: Vec<PassTiming>) -> Rendered {
        let non_finite =
            self.non_finite.into_iter().map(|(buffer, count)| NonFinite { buffer, count }).collect();
        Rendered { picture, timings, dumps: self.dumps, non_finite }
    }
}

/// How many floats of the elements are NaN or ±∞.
fn count_non_finite<T: BufferElement>(values: &[T]) -> u64 {
    let words = size_of::<T>() / 4;
    let mut is_float = vec![false; words];
    for field in T::FIELDS.iter().filter(|f| f.kind == WordKind::Float) {
        let first = field.offset as usize / 4;
        is_float[first..first + field.words as usize].fill(true);
    }
    let all: &[f32] = bytemuck::cast_slice(values);
    all.chunks_exact(words)
        .map(|element| {
            element.iter().zip(&is_float).filter(|&(x, &float)| float && !x.is_finite()).count() as u64
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinlight_kernels::geometry::bvh::Hit;

    #[test]
    fn only_floats_are_counted() {
        let mut hits = [Hit { t: 1.0, u: 0.5, v: 0.25, triangle: u32::MAX }; 4];
        assert_eq!(count_non_finite(&hits), 0, "an index that would be NaN as a float is no float");
        hits[2].v = f32::NAN;
        hits[3].t = f32::NEG_INFINITY;
        assert_eq!(count_non_finite(&hits), 2);
    }
}
