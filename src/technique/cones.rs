//! How do cones go through voxels, of whatever kind?

use crate::error::SettingsError;
use twinlight_kernels::cone::{diameter, mip_level};
use twinlight_kernels::passes::elements::ConeParams;
use twinlight_kernels::sampling::hemisphere::cone;

/// Some devices end all loops of a work item after 65 535 rounds, and say nothing.
pub(super) const MAX_ROUNDS: u32 = 65_000;
/// The tangent of the half angle of the narrowest specular lobe's cone.
const NARROWEST_LOBE: f32 = 0.0625;

/// The knobs of cones through voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Cones {
    /// Cones over the hemisphere, 1 to 64. The error by their width falls with their number, cost rises with it.
    pub count: u32,
    /// Half angle of the diffuse cones in degrees, 0.5 to 85; if none, that of the set: 30 for six.
    pub half_angle: Option<f32>,
    /// Half angle of the specular cone in degrees; if none, that of the surface's lobe.
    pub specular_half_angle: Option<f32>,
    /// Step as a share of the width of the voxels sampled, ¹⁄₆₄ to 64. Longer steps are cheaper; transmittance does not change.
    pub step: f32,
    /// Voxels' width as a share of the cone's, 0.1 to 4. Narrower ones blur less, and cost more steps.
    pub width: f32,
    /// Where cones start, in voxels of the finest level, 0 to 16.
    pub start: f32,
    /// Half voxels over a surface within which voxels do not count for its own cones, 0 to 4: what would shadow itself.
    pub clearance: f32,
    /// Whether each of 4 × 4 pixels turns its cones another way, and each pixel takes the mean over its neighbours on about the same
    /// plane: sixteen times the directions for a pass more, at the price of detail finer than these pixels.
    pub interleave: bool,
    /// Share of a cone that may be left unseen, 0 to 0.5: the error by it is at most this.
    pub cutoff: f32,
}

impl Default for Cones {
    fn default() -> Self {
        Self {
            count: 16,
            half_angle: None,
            specular_half_angle: None,
            step: 1.0,
            width: 0.5,
            start: 1.0,
            clearance: 2.0,
            interleave: true,
            cutoff: 0.01,
        }
    }
}

/// Tangent of a half angle in degrees, or 0 for none: the passes then take their own.
pub(super) fn tangent(degrees: Option<f32>) -> f32 {
    degrees.map_or(0.0, |d| d.to_radians().tan())
}

impl Cones {
    /// What the passes need to know of these knobs.
    pub(super) fn params(&self) -> ConeParams {
        ConeParams {
            cones: self.count,
            tangent: tangent(self.half_angle),
            width: self.width,
            step: self.step,
            start: self.start,
            clearance: self.clearance,
            cutoff: self.cutoff,
            falloff: 0.0,
            reach: 1.0e9,
            ..Default::default()
        }
    }

    /// Rounds of loops that `count` cones of a pixel take through 2^depth voxels, and its specular cone, at most; each step
    /// takes `per_step`, each cone at its end `per_cone`.
    pub(super) fn rounds(&self, depth: u32, count: u32, per_step: u32, per_cone: u32) -> u32 {
        let own = self.half_angle.map_or(cone(count, 0, 0.0).tangent, |d| d.to_radians().tan());
        let specular = self.specular_half_angle.map_or(NARROWEST_LOBE, |d| d.to_radians().tan());
        let of = |cones: u32, tangent: f32| {
            cones.saturating_mul(per_step.saturating_mul(self.steps(depth, tangent)) + per_cone)
        };
        of(count, own).max(of(1, specular))
    }

    /// Steps of the longest cone through the scene.
    fn steps(&self, depth: u32, tangent: f32) -> u32 {
        let end = 1.74 * (1u32 << depth) as f32 * (1.0 + 2.0 * tangent * self.width) + 1.0;
        let (mut t, mut steps) = (self.start, 0);
        while t < end && steps < MAX_ROUNDS {
            let level = mip_level(diameter(t, tangent) * self.width, depth as f32);
            t += level.exp2() * self.step;
            steps += 1;
        }
        steps
    }

    /// Refuses what is out of range.
    ///
    /// # Errors
    /// The first knob that is, with its range.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        in_range("cones", self.count as f32, 1.0, 64.0)?;
        in_range("half-angle", self.half_angle.unwrap_or(1.0), 0.5, 85.0)?;
        in_range("specular-half-angle", self.specular_half_angle.unwrap_or(1.0), 0.5, 85.0)?;
        in_range("step", self.step, 1.0 / 64.0, 64.0)?;
        in_range("voxel-width", self.width, 0.1, 4.0)?;
        in_range("start", self.start, 0.0, 16.0)?;
        in_range("clearance", self.clearance, 0.0, 4.0)?;
        in_range("cutoff", self.cutoff, 0.0, 0.5)
    }
}

/// Refuses more rounds than devices do.
pub(super) fn check_rounds(rounds: u32) -> Result<(), SettingsError> {
    if rounds <= MAX_ROUNDS {
        return Ok(());
    }
    let reason = format!(
        "cones take {rounds} rounds of loops a pixel, over {MAX_ROUNDS}; longer steps, or fewer or wider cones"
    );
    Err(SettingsError { knob: "step", reason })
}

/// Refuses a knob outside its range.
pub(super) fn in_range(knob: &'static str, value: f32, low: f32, high: f32) -> Result<(), SettingsError> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(SettingsError { knob, reason: format!("{value} is not from {low} to {high}") })
}
