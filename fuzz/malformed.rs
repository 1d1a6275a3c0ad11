//! Which glTF files are almost right? One that uses all that is read, and every change of one thing in it.

use serde_json::{Value, json};

/// Bytes of the document's buffer: three vertices, a skin, an animation.
fn buffer() -> Vec<u8> {
    let mut bytes = vec![];
    let mut floats = |numbers: &[f32]| numbers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]); // 0: positions
    floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]); // 36: normals
    floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]); // 72: texture coordinates
    floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]); // 96: weights
    floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]); // 144: bind
    floats(&[0.0, 0.5, 1.0]); // 208: times
    floats(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]); // 220: translations
    floats(&[0.5, 0.5, 0.5]); // 256: the value of a sparse accessor
    bytes.extend([0u8; 12]); // 268: joints
    [0u16, 1, 2, 0].iter().for_each(|i| bytes.extend(i.to_le_bytes())); // 280: indices
    [2u16, 0].iter().for_each(|i| bytes.extend(i.to_le_bytes())); // 288: places of a sparse accessor
    bytes.extend(PNG); // 292
    bytes
}

/// A picture of one grey pixel.
const PNG: [u8; 69] = [
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0, 144,
    119, 83, 222, 0, 0, 0, 12, 73, 68, 65, 84, 120, 156, 99, 104, 104, 104, 0, 0, 3, 4, 1, 129, 75, 211, 210,
    16, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

/// The document that goes with it.
fn document() -> Value {
    let size = buffer().len();
    let view =
        |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let of = |view: usize, component: u32, count: usize, kind: &str| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let mut positions = of(0, 5126, 3, "VEC3");
    (positions["min"], positions["max"]) = (json!([0.0, 0.0, 0.0]), json!([1.0, 1.0, 0.0]));
    let mut times = of(5, 5126, 3, "SCALAR");
    (times["min"], times["max"]) = (json!([0.0]), json!([1.0]));
    let sparse = json!({"bufferView": 0, "componentType": 5126, "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.5], "count": 3, "type": "VEC3", "sparse": {
        "count": 1, "indices": {"bufferView": 9, "componentType": 5123}, "values": {"bufferView": 7}}});
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_emissive_strength"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 5.0, "color": [1.0, 0.5, 0.25], "range": 10.0},
            {"type": "spot", "intensity": 5.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
            {"type": "directional", "intensity": 2.0},
        ]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 2, 3, 4, 5]}],
        "nodes": [
            {"mesh": 0, "skin": 0, "children": [1], "extras": {"spheres": [[0.0, 0.5, 0.0, 0.25]]}},
            {"rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 1.0, 1.0], "translation": [0.0, 0.0, 0.0], "mesh": 1},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.0, 2.0, 2.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 1}},
             "matrix": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 3.0, 1.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 2}}},
            {"camera": 0, "translation": [0.3, 0.3, 2.0]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.0}}],
        "meshes": [
            {"name": "part", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2,
                "JOINTS_0": 7, "WEIGHTS_0": 3}, "indices": 8, "material": 0}]},
            {"name": "strip", "primitives": [{"attributes": {"POSITION": 9}, "mode": 5},
                {"attributes": {"POSITION": 0}, "mode": 6, "material": 1}]},
        ],
        "skins": [{"joints": [1], "inverseBindMatrices": 4}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
            "samplers": [{"input": 5, "output": 6, "interpolation": "LINEAR"}]}],
        "materials": [
            {"name": "grey", "pbrMetallicRoughness": {"metallicFactor": 0.5, "roughnessFactor": 0.5,
                "baseColorFactor": [0.8, 0.8, 0.8, 1.0],
                "baseColorTexture": {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
                    {"offset": [0.5, 0.0], "scale": [2.0, 2.0], "rotation": 0.1}}},
                "metallicRoughnessTexture": {"index": 0}}},
            {"emissiveFactor": [1.0, 1.0, 1.0], "emissiveTexture": {"index": 0}, "alphaMode": "MASK", "alphaCutoff": 0.5,
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}}},
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{}],
        "images": [{"bufferView": 10, "mimeType": "image/png"}],
        "accessors": [positions, of(1, 5126, 3, "VEC3"), of(2, 5126, 3, "VEC2"), of(3, 5126, 3, "VEC4"),
            of(4, 5126, 1, "MAT4"), times, of(6, 5126, 3, "VEC3"), of(8, 5121, 3, "VEC4"),
            of(11, 5123, 3, "SCALAR"), sparse],
        "bufferViews": [view(0, 36), view(36, 36), view(72, 24), view(96, 48), view(144, 64), view(208, 12),
            view(220, 36), view(256, 12), view(268, 12), view(288, 4), view(292, PNG.len()), view(280, 8)],
        "buffers": [{"byteLength": size}],
    })
}

/// A binary glTF file of a document's text and its buffer.
pub fn binary(text: &str, buffer: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (text, buffer) = (padded(text.as_bytes(), b' '), padded(buffer, 0));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + text.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", buffer)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// The file that is right.
pub fn right() -> Vec<u8> {
    binary(&document().to_string(), &buffer())
}

/// JSON pointers of everything in a value.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            for (key, member) in members {
                let own = format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
                all.push(own.clone());
                pointers(member, &own, all);
            }
        }
        Value::Array(members) => {
            for (i, member) in members.iter().enumerate() {
                let own = format!("{at}/{i}");
                all.push(own.clone());
                pointers(member, &own, all);
            }
        }
        _ => {}
    }
}

/// Takes out what is at a pointer.
fn remove(document: &mut Value, pointer: &str) {
    let Some((parent, key)) = pointer.rsplit_once('/') else { return };
    match document.pointer_mut(parent) {
        Some(Value::Object(members)) => drop(members.remove(key)),
        Some(Value::Array(members)) => {
            if let Ok(i) = key.parse::<usize>() {
                members.remove(i);
            }
        }
        _ => {}
    }
}

/// Every file with one change, with what was changed.
pub fn all() -> Vec<(String, Vec<u8>)> {
    let (whole, bytes) = (document(), buffer());
    let mut files = vec![];
    let mut places = vec![];
    pointers(&whole, "", &mut places);
    let values = || {
        [
            json!(null),
            json!(-1),
            json!(0),
            json!(1),
            json!(2),
            json!(7),
            json!(255),
            json!(65_537),
            json!(4_294_967_295_u64),
            json!(u64::MAX),
            json!(1e38),
            json!(-1e38),
            json!(1e300),
            json!(1e-45),
            json!(0.5),
            json!(""),
            json!("a\nb"),
            json!("../../x"),
            json!("data:,"),
            json!([]),
            json!([0]),
            json!([[[]]]),
            json!({}),
            json!(true),
        ]
    };
    for place in &places {
        let mut less = whole.clone();
        remove(&mut less, place);
        files.push((format!("without {place}"), binary(&less.to_string(), &bytes)));
        for value in values() {
            let mut other = whole.clone();
            let Some(at) = other.pointer_mut(place) else { continue };
            *at = value.clone();
            files.push((format!("{place} = {value}"), binary(&other.to_string(), &bytes)));
        }
        // Numbers that JSON has, but no float.
        let mut other = whole.clone();
        if let Some(at) = other.pointer_mut(place).filter(|at| at.is_number()) {
            *at = json!("@");
            let text = other.to_string().replace("\"@\"", "1e9999");
            files.push((format!("{place} = 1e9999"), binary(&text, &bytes)));
        }
    }
    let text = whole.to_string();
    for at in (0..bytes.len() - PNG.len()).step_by(4) {
        for value in [
            0u32,
            1,
            0x3F80_0000,
            0x7F7F_FFFF,
            0x7F80_0000,
            0xFF80_0000,
            0x7FC0_0001,
            0xFFFF_FFFF,
            0x5E00_0000,
        ] {
            let mut other = bytes.clone();
            other[at..at + 4].copy_from_slice(&value.to_le_bytes());
            files.push((format!("word {value:#010x} at byte {at}"), binary(&text, &other)));
        }
    }
    for at in bytes.len() - PNG.len()..bytes.len() {
        let mut other = bytes.clone();
        other[at] ^= 0xFF;
        files.push((format!("another byte {at} of the picture"), binary(&text, &other)));
    }
    let right = right();
    for length in (0..right.len()).step_by(37) {
        files.push((format!("{length} bytes of it"), right[..length].to_vec()));
    }
    for at in 0..28 {
        for value in [0, 1, 127, 255] {
            let mut other = right.clone();
            other[at] = value;
            files.push((format!("byte {at} = {value}"), other));
        }
    }
    files
}
