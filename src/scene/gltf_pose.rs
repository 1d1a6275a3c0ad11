//! Where do a glTF file's animations and skins put its nodes and vertices at a moment?

use super::gltf_accessor::Buffers;
use super::gltf_node::Placed;
use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf::Semantic;
use gltf::animation::{Interpolation, Property};
use std::collections::HashMap;

/// Translation, rotation and scale of the nodes that an animation moves.
#[derive(Default)]
pub struct Pose {
    moved: HashMap<usize, (DVec3, DQuat, DVec3)>,
    /// Whether some of the animation was left out.
    pub partial: bool,
}

impl Pose {
    /// The file's first animation at `seconds`, over and over; nothing moves without an animation.
    ///
    /// # Errors
    /// What is wrong with the animation.
    pub fn at(document: &gltf::Document, buffers: &Buffers, seconds: f64) -> Result<Self, String> {
        let mut pose = Self::default();
        let Some(animation) = document.animations().next() else { return Ok(pose) };
        let mut channels = vec![];
        let mut length = 0.0f64;
        for channel in animation.channels() {
            let sampler = channel.sampler();
            let times: Vec<f64> =
                buffers.vectors::<1>(&sampler.input())?.into_iter().map(|[t]| f64::from(t)).collect();
            let rising = times.windows(2).all(|w| w[0] < w[1]) && times.iter().all(|t| t.is_finite());
            if times.is_empty() || !rising {
                return Err("animation 0: its times do not rise".into());
            }
            length = length.max(times[times.len() - 1]);
            channels.push((channel, times));
        }
        let seconds = if length > 0.0 { seconds.rem_euclid(length) } else { 0.0 };
        for (channel, times) in channels {
            pose.move_node(buffers, &channel, &times, seconds)?;
        }
        Ok(pose)
    }

    fn move_node(
        &mut self,
        buffers: &Buffers,
        channel: &gltf::animation::Channel,
        times: &[f64],
        seconds: f64,
    ) -> Result<(), String> {
        let (node, sampler) = (channel.target().node(), channel.sampler());
        let output = sampler.output();
        let values: Vec<DVec4> = match channel.target().property() {
            Property::Rotation => {
                buffers.vectors::<4>(&output)?.into_iter().map(|v| glam::Vec4::from(v).as_dvec4()).collect()
            }
            Property::Translation | Property::Scale => buffers
                .vectors::<3>(&output)?
                .into_iter()
                .map(|v| glam::Vec3::from(v).as_dvec3().extend(0.0))
                .collect(),
            Property::MorphTargetWeights => {
                self.partial = true;
                return Ok(());
            }
        };
        let cubic = sampler.interpolation() == Interpolation::CubicSpline;
        if values.len() != times.len() * if cubic { 3 } else { 1 } || values.iter().any(|v| !v.is_finite()) {
            return Err("animation 0: its values are not finite or not as many as its times".into());
        }
        let turn = channel.target().property() == Property::Rotation;
        let value = interpolated(times, &values, sampler.interpolation(), turn, seconds);
        let own = self.moved.entry(node.index()).or_insert_with(|| {
            let (t, r, s) = node.transform().decomposed();
            let [t, s] = [t, s].map(|v| glam::Vec3::from(v).as_dvec3());
            (t, DQuat::from_array(r.map(f64::from)), s)
        });
        match channel.target().property() {
            Property::Translation => own.0 = value.truncate(),
            Property::Scale => own.2 = value.truncate(),
            _ => own.1 = DQuat::from_vec4(value),
        }
        Ok(())
    }

    /// The transformation from a node's space to its parent's.
    pub fn local(&self, node: &gltf::Node) -> DMat4 {
        match self.moved.get(&node.index()) {
            Some(&(t, r, s)) => DMat4::from_scale_rotation_translation(s, r.normalize(), t),
            None => DMat4::from_cols_array_2d(&node.transform().matrix().map(|c| c.map(f64::from))),
        }
    }
}

/// The value at a time, held before the first and after the last.
fn interpolated(times: &[f64], values: &[DVec4], kind: Interpolation, turn: bool, at: f64) -> DVec4 {
    let next = times.partition_point(|&t| t <= at).clamp(1, times.len().max(2) - 1).min(times.len() - 1);
    let before = next.saturating_sub(1);
    let span = times[next] - times[before];
    let u = if span > 0.0 { ((at - times[before]) / span).clamp(0.0, 1.0) } else { 0.0 };
    match kind {
        Interpolation::Step => values[if u >= 1.0 { next } else { before }],
        Interpolation::Linear if turn => {
            let [a, b] = [before, next].map(|i| DQuat::from_vec4(values[i]).normalize());
            DVec4::from(a.slerp(b, u))
        }
        Interpolation::Linear => values[before].lerp(values[next], u),
        Interpolation::CubicSpline => {
            // Three values a key: the tangent before, the value, the tangent after.
            let (p0, m0) = (values[3 * before + 1], values[3 * before + 2] * span);
            let (p1, m1) = (values[3 * next + 1], values[3 * next] * span);
            let (u2, u3) = (u * u, u * u * u);
            p0 * (2.0 * u3 - 3.0 * u2 + 1.0)
                + m0 * (u3 - 2.0 * u2 + u)
                + p1 * (3.0 * u2 - 2.0 * u3)
                + m1 * (u3 - u2)
        }
    }
}

/// What carries a primitive's vertices to the world.
pub enum Placement {
    /// The same for all.
    Rigid(DMat4),
    /// One for each vertex, by its joints.
    Skinned(Vec<DMat4>),
}

impl Placement {
    /// That of a primitive of a node; a skin overrules the node's own place.
    ///
    /// # Errors
    /// What is wrong with the skin.
    pub fn of(
        buffers: &Buffers,
        primitive: &gltf::Primitive,
        placed: &Placed,
        worlds: &HashMap<usize, DMat4>,
    ) -> Result<Self, String> {
        let (joints, weights) = (primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0)));
        let (Some(skin), Some(joints), Some(weights)) = (placed.node.skin(), joints, weights) else {
            return Ok(Self::Rigid(placed.world));
        };
        let bind = match skin.inverse_bind_matrices() {
            Some(accessor) => Some(buffers.vectors::<16>(&accessor)?),
            None => None,
        };
        let mut matrices = vec![];
        for (i, joint) in skin.joints().enumerate() {
            let world = worlds.get(&joint.index()).ok_or("a joint of its skin is not in the scene")?;
            let inverse = match &bind {
                Some(all) => {
                    let m = all.get(i).ok_or("its skin has fewer matrices than joints")?;
                    DMat4::from_cols_array(&m.map(f64::from))
                }
                None => DMat4::IDENTITY,
            };
            matrices.push(*world * inverse);
        }
        let (joints, weights) = (buffers.vectors::<4>(&joints)?, buffers.vectors::<4>(&weights)?);
        if joints.len() != weights.len() {
            return Err(format!("{} joints but {} weights", joints.len(), weights.len()));
        }
        let mut all = Vec::with_capacity(joints.len());
        for (joints, weights) in joints.iter().zip(&weights) {
            let (mut sum, mut whole) = (DMat4::ZERO, 0.0);
            for (joint, &weight) in joints.iter().zip(weights) {
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err("a weight of its skin is negative or not finite".into());
                }
                if weight > 0.0 {
                    let matrix = matrices.get(*joint as usize);
                    let matrix = matrix.ok_or("a vertex names a joint that its skin does not have")?;
                    sum += *matrix * f64::from(weight);
                    whole += f64::from(weight);
                }
            }
            all.push(if whole > 0.0 { sum * (1.0 / whole) } else { placed.world });
        }
        Ok(Self::Skinned(all))
    }

    /// What carries vertex `i`.
    pub fn matrix(&self, i: usize) -> DMat4 {
        match self {
            Self::Rigid(world) => *world,
            Self::Skinned(all) => all.get(i).copied().unwrap_or(DMat4::IDENTITY),
        }
    }

    /// Whether faces turn over where vertex `i` is.
    pub fn is_mirrored(&self, i: usize) -> bool {
        self.matrix(i).determinant() < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_keys_and_beyond() {
        let times = [1.0, 2.0, 4.0];
        let values = [0.0, 10.0, 30.0].map(DVec4::splat);
        let linear = |t| interpolated(&times, &values, Interpolation::Linear, false, t).x;
        assert_eq!([0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(linear), [0.0, 0.0, 5.0, 10.0, 20.0, 30.0, 30.0]);
        let step = |t| interpolated(&times, &values, Interpolation::Step, false, t).x;
        assert_eq!([1.5, 2.0, 3.9, 4.0].map(step), [0.0, 10.0, 10.0, 30.0]);
        // A cubic whose tangents are those of a line is the line; those before the first and after the last do not count.
        let keys = [-7.0, 0.0, 10.0, 10.0, 10.0, 10.0, 10.0, 30.0, 99.0].map(DVec4::splat);
        let cubic = |t| interpolated(&times, &keys, Interpolation::CubicSpline, false, t).x;
        assert!((cubic(1.25) - 2.5).abs() < 1e-12 && (cubic(3.0) - 20.0).abs() < 1e-12);
        // Out of the first key at slope 6, into the second at 0: ½·0 + ⅛·6 + ½·10 half way.
        let bent = [0.0, 0.0, 6.0, 0.0, 10.0, -3.0].map(DVec4::splat);
        let half = interpolated(&[0.0, 1.0], &bent, Interpolation::CubicSpline, false, 0.5).x;
        assert!((half - 5.75).abs() < 1e-12, "{half}");
        let alone = interpolated(&[0.5], &bent[..3], Interpolation::CubicSpline, false, 2.0).x;
        assert_eq!(alone, 0.0);
        let one = interpolated(&[0.5], &[DVec4::ONE], Interpolation::Linear, false, 3.0);
        assert_eq!(one, DVec4::ONE);
        // Half of a quarter turn, though the second quaternion has the other sign.
        let turns = [DQuat::IDENTITY, -DQuat::from_rotation_y(1.0)].map(DVec4::from);
        let half = interpolated(&[0.0, 1.0], &turns, Interpolation::Linear, true, 0.5);
        assert!(DQuat::from_vec4(half).angle_between(DQuat::from_rotation_y(0.5)) < 1e-7);
    }
}
