//! Where do the nodes of a glTF file stand, and which lights and cameras do they carry?

use super::gltf_pose::Pose;
use super::gltf_texture::numbered;
use super::{Camera, MAX_VALUE, light};
use crate::error::SceneError;
use glam::{DMat4, DVec3, Vec3};
use gltf::khr_lights_punctual::Kind;
use twinlight_kernels::passes::scene::Light;

/// A node with the transformation from its space to the world.
pub struct Placed<'a> {
    /// The node.
    pub node: gltf::Node<'a>,
    /// Node space to world space, finite.
    pub world: DMat4,
}

/// Returns all nodes of a scene in a pose, parents first, in the order of the file.
pub fn walk<'a>(
    document: &gltf::Document,
    scene: &gltf::Scene<'a>,
    pose: &Pose,
) -> Result<Vec<Placed<'a>>, SceneError> {
    let mut visited = vec![false; document.nodes().len()];
    let mut placed = vec![];
    let mut stack: Vec<(gltf::Node<'a>, DMat4)> = scene.nodes().map(|n| (n, DMat4::IDENTITY)).collect();
    stack.reverse();
    while let Some((node, parent)) = stack.pop() {
        let error = |reason: &str| SceneError::Value { what: name(&node), reason: reason.into() };
        match visited.get_mut(node.index()) {
            Some(visited) if !*visited => *visited = true,
            _ => return Err(error("it is reached twice; the nodes must form a tree")),
        }
        let world = parent * pose.local(&node);
        if !world.is_finite() {
            return Err(error("its transformation is not finite"));
        }
        let from = stack.len();
        stack.extend(node.children().map(|child| (child, world)));
        stack[from..].reverse();
        placed.push(Placed { node, world });
    }
    Ok(placed)
}

fn name(node: &gltf::Node) -> String {
    format!("node {}", numbered(node.index(), node.name()))
}

impl Placed<'_> {
    /// An error about this node.
    pub(super) fn error(&self, reason: &str) -> SceneError {
        SceneError::Value { what: name(&self.node), reason: reason.into() }
    }

    /// Position of the node's origin.
    fn origin(&self) -> Vec3 {
        self.world.w_axis.truncate().as_vec3()
    }

    /// Unit direction of a local axis in the world.
    fn direction(&self, axis: DVec3) -> Result<DVec3, SceneError> {
        let direction = self.world.transform_vector3(axis).try_normalize();
        direction.ok_or_else(|| self.error("its light or camera has no direction: the scale is 0"))
    }

    /// Returns the node's light: candela and lux of KHR_lights_punctual are taken as W/sr and W/m², number by number.
    ///
    /// A `range` is ignored.
    pub fn light(&self) -> Result<Option<Light>, SceneError> {
        let Some(source) = self.node.light() else { return Ok(None) };
        let intensity = Vec3::from(source.color()) * source.intensity();
        if !intensity.to_array().iter().all(|x| (0.0..=MAX_VALUE).contains(x)) {
            return Err(self.error("its light's intensity is negative, not finite or beyond 1e18"));
        }
        let position = self.origin();
        if !position.to_array().iter().all(|x| x.abs() <= MAX_VALUE) {
            return Err(self.error("its light's position is not finite or beyond 1e18 m"));
        }
        let forward = || self.direction(DVec3::NEG_Z).map(|d| d.as_vec3());
        Ok(Some(match source.kind() {
            Kind::Point => light::point(position, intensity),
            Kind::Directional => light::sun(forward()?, intensity),
            Kind::Spot { inner_cone_angle: inner, outer_cone_angle: outer } => {
                if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= std::f32::consts::PI) {
                    return Err(self.error("its spot's cone angles are not 0 <= inner <= outer"));
                }
                light::spot(position, forward()?, intensity, inner, outer)
            }
        }))
    }

    /// Returns the node's camera; an orthographic one is told in `warnings` and ignored.
    pub fn camera(
        &self,
        document: &gltf::Document,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Camera>, SceneError> {
        let Some(camera) = self.node.camera() else { return Ok(None) };
        // Through the parsed JSON: the crate's accessor trusts that the projection fits the type.
        let json = document.as_json().cameras.get(camera.index());
        let Some(perspective) = json.and_then(|c| c.perspective.as_ref()) else {
            warnings.push(format!("{}: its orthographic camera is ignored", name(&self.node)));
            return Ok(None);
        };
        let eye = self.origin();
        // Far enough that adding it to the eye keeps its digits.
        let distance = f64::from(eye.abs().max_element().max(1.0));
        let target = (eye.as_dvec3() + self.direction(DVec3::NEG_Z)? * distance).as_vec3();
        let up = self.direction(DVec3::Y)?.as_vec3();
        let camera = Camera { eye, target, up, fov: perspective.yfov.to_degrees() };
        camera.frame().map_err(|e| self.error(&e.to_string()))?;
        Ok(Some(camera))
    }
}
