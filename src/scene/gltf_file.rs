//! Which triangles does a glTF file hold, in world space?

use super::bvh::{MAX_COORDINATE, MAX_TRIANGLES};
use super::gltf_accessor::{Buffers, read_file};
use super::gltf_material::{self, Coordinates, Loaded};
use super::gltf_node::{self, Placed};
use super::gltf_pose::{Placement, Pose};
use super::gltf_texture::{Textures, numbered};
use super::{Dropped, Scene};
use crate::error::{SceneError, one_line};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use gltf::Semantic;
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use twinlight_kernels::passes::scene::Triangle;

/// Opens a `.glb` or `.gltf` file at a moment: its default scene, or the first where none is named.
pub fn open(path: &Path, seconds: f64) -> Result<Scene, SceneError> {
    let bytes =
        read_file(path).map_err(|reason| SceneError::Read { path: one_line(path.display()), reason })?;
    read(bytes, path, seconds)
}

/// Reads a file's bytes; `path` names it, and other files are looked for beside it.
pub fn read(bytes: Vec<u8>, path: &Path, seconds: f64) -> Result<Scene, SceneError> {
    let format = |reason: String| SceneError::Format { path: one_line(path.display()), reason };
    let gltf::Gltf { document, blob } = parse(&bytes).map_err(format)?;
    drop(bytes);
    let buffers = Buffers::read(&document, blob, path)?;
    let chosen = document.default_scene().or_else(|| document.scenes().next());
    let chosen = chosen.ok_or_else(|| format("it has no scene".into()))?;
    let pose = Pose::at(&document, &buffers, seconds).map_err(format)?;
    let nodes = gltf_node::walk(&document, &chosen, &pose)?;
    let worlds = nodes.iter().map(|placed| (placed.node.index(), placed.world)).collect();
    let mut scene = Scene {
        name: path.file_stem().map(|name| one_line(name.to_string_lossy())).unwrap_or_default(),
        ..Scene::default()
    };
    if pose.partial {
        scene.warnings.push("animation 0: morph targets are ignored".into());
    }
    let materials = materials(&document, &buffers, path, &nodes, &mut scene)?;
    for placed in &nodes {
        add_mesh(&buffers, placed, &worlds, &materials, &mut scene)?;
        scene.lights.extend(placed.light()?);
        if scene.camera.is_none() {
            scene.camera = placed.camera(&document, &mut scene.warnings)?;
        }
    }
    let mut spheres = vec![];
    for (character, placed) in nodes.iter().enumerate() {
        let Some(extras) = placed.node.extras() else { continue };
        let own = super::proxies::from_extras(extras.get(), &placed.world);
        let own = own.map_err(|reason| placed.error(&reason))?;
        spheres.extend(own.into_iter().map(|(centre, radius)| (centre, radius, character as u32)));
    }
    scene.add_proxies(&spheres)?;
    if scene.triangles.is_empty() {
        let Dropped { zero_area, points_and_lines, .. } = scene.dropped;
        return Err(SceneError::Empty {
            path: one_line(path.display()),
            dropped: format!(
                "left out: {zero_area} triangles of no area, {points_and_lines} primitives of points or lines"
            ),
        });
    }
    Ok(scene)
}

/// Parses and validates the document.
fn parse(bytes: &[u8]) -> Result<gltf::Gltf, String> {
    if bytes.starts_with(b"glTF") {
        // The parser subtracts the header's size from the length without looking.
        let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        match length {
            Some(length) if length >= 12 && length as usize <= bytes.len() => {}
            Some(length) => return Err(format!("{} bytes where the header says {length}", bytes.len())),
            None => return Err("the header is cut off".into()),
        }
    } else if bytes.iter().find(|b| !b.is_ascii_whitespace()) != Some(&b'{') {
        return Err("it starts neither with glTF nor with {".into());
    }
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes).map_err(one_line)?;
    let json = document.into_json();
    // The validation looks at these accessors without looking whether they exist.
    let positions = Checked::Valid(Semantic::Positions);
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    if let Some(bad) = primitives
        .filter_map(|primitive| primitive.attributes.get(&positions))
        .find(|accessor| accessor.value() >= json.accessors.len())
    {
        return Err(format!("a POSITION is accessor {bad}, which does not exist"));
    }
    // Nor at what animations move.
    for target in json.animations.iter().flat_map(|a| &a.channels).map(|channel| &channel.target) {
        if target.node.value() >= json.nodes.len() {
            return Err(format!("an animation moves node {}, which does not exist", target.node.value()));
        }
        if matches!(target.path, Checked::Invalid) {
            return Err("an animation moves what is neither translation, rotation, scale nor weights".into());
        }
    }
    let document = gltf::Document::from_json(json).map_err(|e| match e {
        gltf::Error::Validation(faults) => {
            let first = faults.first().map(|(path, fault)| format!("{path} {fault}")).unwrap_or_default();
            format!("{} faults, the first: {}", faults.len(), one_line(first))
        }
        other => one_line(other),
    })?;
    Ok(gltf::Gltf { document, blob })
}

/// Materials by index in the file; `None` is the one of primitives that name none.
type Materials = BTreeMap<Option<usize>, (u32, Option<Coordinates>)>;

/// Converts the materials that the nodes' meshes use, with their textures.
fn materials(
    document: &gltf::Document,
    buffers: &Buffers,
    path: &Path,
    nodes: &[Placed],
    scene: &mut Scene,
) -> Result<Materials, SceneError> {
    let mut used = BTreeMap::new();
    for mesh in nodes.iter().filter_map(|placed| placed.node.mesh()) {
        for material in mesh.primitives().map(|primitive| primitive.material()) {
            used.insert(material.index(), material);
        }
    }
    let wanted = used.values().flat_map(gltf_material::images);
    let textures = Textures::read(document, buffers, path, wanted)?;
    let mut materials = Materials::new();
    for (index, source) in used {
        let Loaded { material, texture_coordinates } =
            gltf_material::convert(&source, &textures, &mut scene.warnings)?;
        materials.insert(index, (scene.materials.len() as u32, texture_coordinates));
        scene.materials.push(material);
    }
    scene.texels = textures.texels;
    Ok(materials)
}

/// Adds the triangles of a node's mesh.
fn add_mesh(
    buffers: &Buffers,
    placed: &Placed,
    worlds: &HashMap<usize, DMat4>,
    materials: &Materials,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let Some(mesh) = placed.node.mesh() else { return Ok(()) };
    let mesh_name = numbered(mesh.index(), mesh.name());
    for primitive in mesh.primitives() {
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            scene.dropped.points_and_lines += 1;
            continue;
        }
        let error = |reason: String| SceneError::Geometry {
            mesh: mesh_name.clone(),
            primitive: primitive.index(),
            reason,
        };
        let (material, coordinates) =
            materials.get(&primitive.material().index()).copied().unwrap_or_default();
        let placement = Placement::of(buffers, &primitive, placed, worlds).map_err(error)?;
        if primitive.get(&Semantic::Joints(1)).is_some() {
            scene.warnings.push(format!("mesh {mesh_name}: joints beyond four of a vertex are ignored"));
        }
        let vertices = Vertices::read(buffers, &primitive, &placement, coordinates).map_err(error)?;
        if coordinates.is_some() && vertices.coordinates.is_none() {
            scene.warnings.push(format!(
                "mesh {mesh_name}, primitive {}: no texture coordinates, 0 is used",
                primitive.index()
            ));
        }
        let corners = corners(buffers, &primitive, vertices.positions.len()).map_err(error)?;
        if scene.triangles.len() + corners.len() > MAX_TRIANGLES {
            return Err(SceneError::TooLarge {
                what: "triangles".into(),
                count: (scene.triangles.len() + corners.len()) as u64,
                limit: MAX_TRIANGLES as u64,
            });
        }
        scene.triangles.reserve(corners.len());
        for [a, b, c] in corners {
            let corners = if placement.is_mirrored(a as usize) { [a, c, b] } else { [a, b, c] };
            match vertices.triangle(corners.map(|i| i as usize), material, &mut scene.dropped) {
                Some(triangle) => scene.triangles.push(triangle),
                None => scene.dropped.zero_area += 1,
            }
        }
    }
    Ok(())
}

/// Returns the vertices of each triangle, every index checked against `count`.
fn corners(buffers: &Buffers, primitive: &gltf::Primitive, count: usize) -> Result<Vec<[u32; 3]>, String> {
    let indices = match primitive.indices() {
        Some(accessor) => buffers.indices(&accessor)?,
        None => (0..u32::try_from(count).map_err(|_| "too many vertices")?).collect(),
    };
    if let Some(bad) = indices.iter().find(|&&i| i as usize >= count) {
        return Err(format!("index {bad} is beyond its {count} vertices"));
    }
    Ok(match primitive.mode() {
        Mode::TriangleStrip => {
            let turned =
                |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let rest = indices.get(1..).unwrap_or(&[]);
            rest.windows(2).map(|w| [w[0], w[1], indices[0]]).collect()
        }
        _ if indices.len() % 3 != 0 => {
            return Err(format!("{} indices do not make triangles", indices.len()));
        }
        _ => indices.chunks_exact(3).map(|w| [w[0], w[1], w[2]]).collect(),
    })
}

/// A primitive's vertices in world space.
struct Vertices {
    positions: Vec<Vec3>,
    /// Unit length, or 0 where the face's normal is to be used.
    normals: Option<Vec<Vec3>>,
    coordinates: Option<Vec<Vec2>>,
}

impl Vertices {
    fn read(
        buffers: &Buffers,
        primitive: &gltf::Primitive,
        placement: &Placement,
        coordinates: Option<Coordinates>,
    ) -> Result<Self, String> {
        let accessor = primitive.get(&Semantic::Positions).ok_or("it has no POSITION")?;
        let mut positions = vec![];
        for (i, p) in buffers.vectors::<3>(&accessor)?.into_iter().enumerate() {
            let p = placement.matrix(i).transform_point3(Vec3::from(p).as_dvec3()).as_vec3();
            if !(p.is_finite() && p.abs().max_element() <= MAX_COORDINATE) {
                return Err(format!(
                    "the position of vertex {i} is not finite or beyond {MAX_COORDINATE:e} m"
                ));
            }
            positions.push(p);
        }
        let count = positions.len();
        if let Placement::Skinned(all) = placement
            && all.len() != count
        {
            return Err(format!("{count} positions but {} joints", all.len()));
        }
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => Some(normals(buffers.vectors::<3>(&accessor)?, placement)?),
            None => None,
        };
        let coordinates = match coordinates {
            Some(Coordinates { set, map }) => match primitive.get(&Semantic::TexCoords(set)) {
                Some(accessor) => Some(mapped(buffers.vectors::<2>(&accessor)?, map)?),
                None => None,
            },
            None => None,
        };
        let lengths = [normals.as_ref().map(Vec::len), coordinates.as_ref().map(Vec::len)];
        if let Some(other) = lengths.into_iter().flatten().find(|&length| length != count) {
            return Err(format!("{count} positions but {other} normals or texture coordinates"));
        }
        Ok(Self { positions, normals, coordinates })
    }

    /// Returns one triangle, or nothing where it has no area.
    fn triangle(&self, corners: [usize; 3], material: u32, dropped: &mut Dropped) -> Option<Triangle> {
        let p = corners.map(|i| self.positions[i]);
        // In f64, where neither 1e-38 nor 1e18 m squared leaves the range.
        let d = p.map(|p| p.as_dvec3());
        let face = (d[1] - d[0]).cross(d[2] - d[0]);
        if face == DVec3::ZERO {
            return None;
        }
        let face = face.normalize_or(DVec3::Y).as_vec3();
        let n = corners.map(|i| match &self.normals {
            Some(normals) if normals[i] != Vec3::ZERO => normals[i],
            Some(_) => {
                dropped.zero_normals += 1;
                face
            }
            None => face,
        });
        let t = corners.map(|i| self.coordinates.as_ref().map_or(Vec2::ZERO, |all| all[i]));
        Some(Triangle {
            p0: p[0].extend(t[0].x),
            p1: p[1].extend(t[1].x),
            p2: p[2].extend(t[2].x),
            n0: n[0].extend(t[0].y),
            n1: n[1].extend(t[1].y),
            n2: n[2].extend(t[2].y),
            material,
            ..Triangle::default()
        })
    }
}

/// Transforms normals by the inverse transpose, through cofactors so that a flattened node still has some.
fn normals(local: Vec<[f32; 3]>, placement: &Placement) -> Result<Vec<Vec3>, String> {
    let cofactors = |i: usize| {
        let m = DMat3::from_mat4(placement.matrix(i));
        let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
    };
    let mut world = Vec::with_capacity(local.len());
    for (i, normal) in local.into_iter().enumerate() {
        let normal = Vec3::from(normal);
        if !normal.is_finite() {
            return Err(format!("the normal of vertex {i} is not finite"));
        }
        world.push((cofactors(i) * normal.as_dvec3()).try_normalize().unwrap_or(DVec3::ZERO).as_vec3());
    }
    Ok(world)
}

/// Applies a texture transform.
fn mapped(coordinates: Vec<[f32; 2]>, m: [f32; 6]) -> Result<Vec<Vec2>, String> {
    let mut all = Vec::with_capacity(coordinates.len());
    for (i, [u, v]) in coordinates.into_iter().enumerate() {
        let mapped = Vec2::new(m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]);
        if !mapped.is_finite() {
            return Err(format!("the texture coordinate of vertex {i} is not finite"));
        }
        all.push(mapped);
    }
    Ok(all)
}
