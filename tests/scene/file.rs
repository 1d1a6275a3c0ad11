//! How does a test make a glTF file that is right but for one thing?

#[path = "../../fuzz/malformed.rs"]
pub mod generator;

use base64::Engine;
use serde_json::{Value, json};
use twinlight::error::SceneError;
use twinlight::scene::Scene;

/// A file with one triangle, to be changed by a test: positions at 0, normals at 36, coordinates at 72, indices at 96.
pub struct File {
    json: Value,
    bytes: Vec<u8>,
}

impl File {
    pub fn new() -> Self {
        let mut bytes = vec![];
        let numbers: [f32; 24] = [
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
            0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, // normals
            0.0, 0.0, 1.0, 0.0, 0.0, 1.0, // texture coordinates
        ];
        numbers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        [0u16, 1, 2, 0].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"name": "part", "primitives": [{
                "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0
            }]}],
            "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0.0}}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                 "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]},
                {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"},
                {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 3, "type": "VEC2"},
                {"bufferView": 0, "byteOffset": 96, "componentType": 5123, "count": 3, "type": "SCALAR"},
            ],
            "bufferViews": [{"buffer": 0, "byteLength": 104}],
        });
        Self { json, bytes }
    }

    /// Replaces or adds what is at a JSON pointer.
    pub fn set(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = self.json.pointer_mut(parent).unwrap();
        match parent.as_array_mut() {
            Some(array) => array[key.parse::<usize>().unwrap()] = value,
            None => parent[key] = value,
        }
        self
    }

    pub fn float(mut self, offset: usize, value: f32) -> Self {
        self.bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        self
    }

    pub fn index(mut self, place: usize, value: u16) -> Self {
        self.bytes[96 + 2 * place..98 + 2 * place].copy_from_slice(&value.to_le_bytes());
        self
    }

    /// Embeds a picture as image 0 and texture 0.
    pub fn picture(self, picture: image::DynamicImage) -> Self {
        let mut png = std::io::Cursor::new(vec![]);
        picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let text = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
        self.set("/images", json!([{"uri": format!("data:image/png;base64,{text}")}]))
            .set("/textures", json!([{"source": 0}]))
    }

    /// Adds `count` elements of f32 as the next accessor.
    pub fn append(mut self, kind: &str, count: usize, numbers: &[f32]) -> Self {
        let offset = self.bytes.len();
        numbers.iter().for_each(|n| self.bytes.extend(n.to_le_bytes()));
        let accessor = json!({"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": count, "type": kind});
        self.json["accessors"].as_array_mut().unwrap().push(accessor);
        self.json["bufferViews"][0]["byteLength"] = json!(self.bytes.len());
        self
    }

    /// Opens it as .gltf with an embedded buffer.
    pub fn open(self) -> Result<Scene, SceneError> {
        self.open_at(0.0)
    }

    /// Opens it as it is at a moment.
    pub fn open_at(mut self, seconds: f64) -> Result<Scene, SceneError> {
        if self.json.get("buffers").is_none() {
            let text = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
            let uri = format!("data:application/octet-stream;base64,{text}");
            self.json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("test.gltf");
        std::fs::write(&path, self.json.to_string()).unwrap();
        Scene::open_at(path.to_str().unwrap(), seconds)
    }
}

/// Writes a file of that name and opens it.
pub fn open_bytes(bytes: &[u8], name: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Scene::open(path.to_str().unwrap())
}

/// A binary file of the plain scene.
pub fn binary() -> Vec<u8> {
    let File { mut json, bytes } = File::new();
    json["buffers"] = json!([{"byteLength": bytes.len()}]);
    generator::binary(&json.to_string(), &bytes)
}
