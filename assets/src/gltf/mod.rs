//! glTF models that show, each, one part of the format.

mod file;
mod shapes;

use serde_json::{Value, json};
use texmap_math::deterministic_f64::{cos, sin};

use self::file::Buffer;
use crate::picture::{Picture, Rgba};

/// Name below `assets/gltf/` and content of every file.
pub(crate) fn files() -> Vec<(String, Vec<u8>)> {
    let (plates, plates_bytes) = plates();
    let named = [
        ("box.glb", cube()),
        ("plates.gltf", plates.into_bytes()),
        ("plates.bin", plates_bytes),
        ("leaf card.png", card().png()),
        ("mirrored.glb", mirrored()),
        ("tangents.glb", tangents()),
        ("bent.glb", shapes::bent()),
        ("sparse.gltf", shapes::sparse()),
        ("quantized.glb", quantized()),
        ("two_uv.glb", two_uv()),
        ("instances.glb", instances()),
        ("materials.glb", shapes::materials()),
        ("webp.glb", webp()),
    ];
    named.map(|(name, bytes)| (name.to_owned(), bytes)).into()
}

/// A letter that is the same neither mirrored nor upside down, on a checker whose upper left corner is red.
fn letter() -> Picture {
    let mut picture = Picture::from_fn(64, 64, |x, y| match (x / 16 + y / 16) % 2 {
        _ if x < 16 && y < 16 => [220, 40, 40, 255],
        0 => [235, 230, 215, 255],
        _ => [120, 150, 190, 255],
    });
    picture.text(16, 8, 6, [25, 25, 40, 255], "F");
    picture
}

/// A green disc whose alpha falls from its middle to its edge.
fn card() -> Picture {
    Picture::from_fn(64, 64, |x, y| {
        let (dx, dy) = (2 * x as i32 - 63, 2 * y as i32 - 63);
        let alpha = 255 - (dx * dx + dy * dy) * 255 / (63 * 63);
        [40, 160, 70, alpha.max(0) as u8]
    })
}

/// Bumps as normals, green up.
fn bumps() -> Picture {
    Picture::from_fn(32, 32, |x, y| {
        let (dx, dy) = (2.0 * f64::from(x) - 31.0, 2.0 * f64::from(y) - 31.0);
        let inside = dx * dx + dy * dy < 26.0 * 26.0;
        let (nx, ny) = if inside {
            (dx / 31.0, -dy / 31.0)
        } else {
            (0.0, 0.0)
        };
        let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
        let code = |n: f64| (127.5 * n + 127.5 + 0.5) as u8;
        [code(nx), code(ny), code(nz), 255]
    })
}

fn plain(color: Rgba) -> Picture {
    Picture::from_fn(4, 4, |_, _| color)
}

/// The four corners of a square of side 1 around the origin, facing +Z, counter-clockwise from the lower left.
const SQUARE: [[f32; 3]; 4] = [
    [-0.5, -0.5, 0.0],
    [0.5, -0.5, 0.0],
    [0.5, 0.5, 0.0],
    [-0.5, 0.5, 0.0],
];
const SQUARE_UV: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
const SQUARE_INDICES: [u16; 6] = [0, 1, 2, 0, 2, 3];

fn square(buffer: &mut Buffer) -> (Value, usize) {
    let attributes = json!({
        "POSITION": buffer.floats(&SQUARE),
        "NORMAL": buffer.floats(&[[0.0, 0.0, 1.0]; 4]),
        "TEXCOORD_0": buffer.floats(&SQUARE_UV),
    });
    (attributes, buffer.indices(&SQUARE_INDICES))
}

/// A box with a letter on each side, a camera and no normals.
fn cube() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for side in 0..6 {
        let first = positions.len() as u16;
        for (p, uv) in SQUARE.iter().zip(SQUARE_UV) {
            let [x, y, z] = [p[0], p[1], 0.5];
            positions.push(match side {
                0 => [x, y, z],
                1 => [-x, y, -z],
                2 => [z, y, -x],
                3 => [-z, y, x],
                4 => [x, z, -y],
                _ => [x, -z, y],
            });
            uvs.push(uv);
        }
        indices.extend(SQUARE_INDICES.map(|i| first + i));
    }
    let attributes =
        json!({"POSITION": buffer.floats(&positions), "TEXCOORD_0": buffer.floats(&uvs)});
    let indices = buffer.indices(&indices);
    let picture = buffer.view(&letter().png());
    buffer.glb(json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "box", "mesh": 0},
            {"name": "eye", "camera": 0, "translation": [0.0, 0.0, 3.0]},
        ],
        "meshes": [{"name": "box", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "letters", "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.6,
        }}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": picture, "mimeType": "image/png", "name": "letter"}],
        "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.0}}],
    }))
}

/// Four plates of one picture in a file of its own: opaque, cut out, blended, and blended without light.
fn plates() -> (String, Vec<u8>) {
    let mut buffer = Buffer::default();
    let (attributes, indices) = square(&mut buffer);
    let material = |name: &str, more: Value| {
        let mut material = json!({"name": name, "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicFactor": 0.0,
        }});
        for (key, value) in more.as_object().into_iter().flatten() {
            material[key] = value.clone();
        }
        material
    };
    let materials = [
        material("opaque", json!({})),
        material(
            "mask",
            json!({"alphaMode": "MASK", "alphaCutoff": 0.75, "doubleSided": true}),
        ),
        material("blend", json!({"alphaMode": "BLEND", "doubleSided": true})),
        material(
            "unlit",
            json!({"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}}),
        ),
    ];
    let meshes = (0..4).map(
        |m| json!({"primitives": [{"attributes": attributes, "indices": indices, "material": m}]}),
    );
    let meshes: Vec<Value> = meshes.collect();
    let nodes =
        (0..4).map(|n| json!({"mesh": n, "translation": [1.2 * f64::from(n) - 1.8, 0.0, 0.0]}));
    let nodes: Vec<Value> = nodes.collect();
    buffer.document(
        json!({
            "extensionsUsed": ["KHR_materials_unlit"],
            "scenes": [{"nodes": [0, 1, 2, 3]}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "textures": [{"source": 0, "sampler": 0}],
            "samplers": [{"wrapS": 33071, "wrapT": 33071}],
            "images": [{"uri": "leaf%20card.png"}],
        }),
        Some("plates.bin"),
    )
}

/// One plate with a letter and bumps, and its mirror image by a node of negative scale; neither has a back.
fn mirrored() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (attributes, indices) = square(&mut buffer);
    let pictures = [letter(), bumps()].map(|picture| buffer.view(&picture.png()));
    let images = pictures.map(|view| json!({"bufferView": view, "mimeType": "image/png"}));
    buffer.glb(json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "plain", "mesh": 0, "translation": [-0.6, 0.0, 0.0]},
            {"name": "mirror", "scale": [-1.0, 1.0, 1.0], "children": [2]},
            {"name": "mirrored", "mesh": 0, "translation": [-0.6, 0.0, 0.0]},
        ],
        "meshes": [{"name": "plate", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "bumps", "normalTexture": {"index": 1, "scale": 0.8}, "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.4,
        }}],
        "textures": [{"source": 0}, {"source": 1}],
        "images": images,
    }))
}

/// Four plates of bumps that look alike. Their coordinates are upright, upright with tangents, mirrored and turned by a quarter; the file
/// says the tangents of the last three. The pictures of bumps are the same under all of these.
fn tangents() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let mirrored = SQUARE_UV.map(|[u, v]| [1.0 - u, v]);
    // u grows upwards and v to the right.
    let turned = SQUARE_UV.map(|[u, v]| [1.0 - v, u]);
    let plates = [
        ("computed", SQUARE_UV, None),
        ("upright", SQUARE_UV, Some([1.0, 0.0, 0.0, 1.0])),
        ("mirrored", mirrored, Some([-1.0, 0.0, 0.0, -1.0])),
        ("turned", turned, Some([0.0, 1.0, 0.0, 1.0])),
    ];
    let indices = buffer.indices(&SQUARE_INDICES);
    let positions = buffer.floats(&SQUARE);
    let normals = buffer.floats(&[[0.0, 0.0, 1.0]; 4]);
    let meshes: Vec<Value> = plates
        .iter()
        .map(|(name, uvs, tangent)| {
            let mut attributes = json!({
                "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": buffer.floats(uvs),
            });
            if let Some(tangent) = tangent {
                attributes["TANGENT"] = buffer.floats(&[*tangent; 4]).into();
            }
            json!({"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]})
        })
        .collect();
    let nodes: Vec<Value> = (0..4)
        .map(|n| json!({"mesh": n, "translation": [1.1 * f64::from(n) - 1.65, 0.0, 0.0]}))
        .collect();
    let picture = buffer.view(&bumps().png());
    buffer.glb(json!({
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [{"name": "bumps", "normalTexture": {"index": 0}, "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.55, 0.3, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.4,
        }}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": picture, "mimeType": "image/png"}],
    }))
}

/// A plate in 16-bit integers, its attributes interleaved, and a turned texture.
fn quantized() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let mut bytes = Vec::new();
    for (p, uv) in SQUARE.iter().zip(SQUARE_UV) {
        let position = [p[0], p[1], 0.0].map(|x| (2.0 * x * 32767.0) as i16);
        bytes.extend(position.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0, 0]);
        bytes.extend([0_i8, 0, 127, 0].map(|n| n as u8));
        bytes.extend(uv.iter().flat_map(|x| ((x * 65535.0) as u16).to_le_bytes()));
    }
    let view = buffer.view(&bytes);
    buffer.set_stride(view, 16);
    let accessor = |offset: usize, component: u32, kind: &str| {
        json!({
            "bufferView": view, "byteOffset": offset, "componentType": component, "normalized": true, "count": 4, "type": kind,
        })
    };
    let mut position = accessor(0, 5122, "VEC3");
    (position["min"], position["max"]) = (json!([-32767, -32767, 0]), json!([32767, 32767, 0]));
    let attributes = json!({
        "POSITION": buffer.accessor(position),
        "NORMAL": buffer.accessor(accessor(8, 5120, "VEC3")),
        "TEXCOORD_0": buffer.accessor(accessor(12, 5123, "VEC2")),
    });
    let indices = buffer.view(&[0, 1, 2, 0, 2, 3]);
    let indices = buffer.accessor(
        json!({"bufferView": indices, "componentType": 5121, "count": 6, "type": "SCALAR"}),
    );
    let picture = buffer.view(&letter().png());
    buffer.glb(json!({
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_texture_transform"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [0.5, 0.5, 0.5]}],
        "meshes": [{"name": "plate", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "turned", "pbrMetallicRoughness": {"metallicFactor": 0.0, "baseColorTexture": {
            "index": 0, "extensions": {"KHR_texture_transform": {
                "offset": [0.0, 1.0], "rotation": std::f64::consts::FRAC_PI_2, "scale": [1.0, 1.0],
            }},
        }}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": picture, "mimeType": "image/png"}],
    }))
}

/// A plate whose colour and light read two sets of coordinates, with a sampler for each axis.
fn two_uv() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (mut attributes, indices) = square(&mut buffer);
    let wide = SQUARE_UV.map(|uv| uv.map(|x| 2.0 * x));
    attributes["TEXCOORD_1"] = buffer.floats(&wide).into();
    let lamp = Picture::from_fn(8, 8, |x, y| {
        if x < 4 && y < 4 {
            [255, 200, 90, 255]
        } else {
            [0, 0, 0, 255]
        }
    });
    let shade = plain([120, 180, 0, 255]);
    let pictures = [letter(), lamp, shade].map(|picture| buffer.view(&picture.png()));
    let images = pictures.map(|view| json!({"bufferView": view, "mimeType": "image/png"}));
    buffer.glb(json!({
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "plate", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{
            "name": "lamps",
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 2, "texCoord": 1}, "metallicFactor": 0.5,
            },
            "occlusionTexture": {"index": 2, "texCoord": 1, "strength": 0.5},
            "emissiveTexture": {"index": 1, "texCoord": 1},
            "emissiveFactor": [0.5, 0.5, 0.5],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}},
        }],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}, {"source": 2}],
        "samplers": [
            {"magFilter": 9728, "minFilter": 9984, "wrapS": 33071, "wrapT": 33648},
            {"magFilter": 9729, "minFilter": 9729, "wrapS": 10497, "wrapT": 33071},
        ],
        "images": images,
    }))
}

/// Nine instances of a plate, and the three kinds of lights.
fn instances() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (attributes, indices) = square(&mut buffer);
    let places: Vec<[f32; 3]> = (0..9_u16)
        .map(|i| [f32::from(i % 3) - 1.0, f32::from(i / 3) - 1.0, 0.0])
        .collect();
    let sizes: Vec<[f32; 3]> = (0..9_u16).map(|i| [0.4 + 0.06 * f32::from(i); 3]).collect();
    let turns: Vec<[f32; 4]> = (0..9)
        .map(|i| {
            let half = f64::from(i) * std::f64::consts::PI / 18.0;
            [0.0, 0.0, sin(half) as f32, cos(half) as f32]
        })
        .collect();
    let instancing = json!({
        "TRANSLATION": buffer.floats(&places), "SCALE": buffer.floats(&sizes), "ROTATION": buffer.floats(&turns),
    });
    buffer.glb(json!({
        "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_lights_punctual"],
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [
            {"name": "plates", "mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": instancing}}},
            {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "bulb", "translation": [-1.0, 1.0, 1.0], "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"name": "torch", "translation": [1.0, -1.0, 2.0], "extensions": {"KHR_lights_punctual": {"light": 2}}},
        ],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "directional", "intensity": 0.5},
            {"type": "point", "color": [1.0, 0.6, 0.2], "intensity": 1.5, "range": 4.0},
            {"type": "spot", "color": [0.4, 0.7, 1.0], "intensity": 12.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        ]}},
        "meshes": [{"name": "plate", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "white", "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.5}}],
    }))
}

/// The plate of the letter, whose picture is a WebP with a PNG for others.
fn webp() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (attributes, indices) = square(&mut buffer);
    let picture = letter();
    let grey = buffer.view(&plain([128, 128, 128, 255]).png());
    let webp = buffer.view(&picture.webp());
    buffer.glb(json!({
        "extensionsUsed": ["EXT_texture_webp"],
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "plate", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "materials": [{"name": "letter", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0}}],
        "textures": [{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}],
        "images": [
            {"bufferView": grey, "mimeType": "image/png"},
            {"bufferView": webp, "mimeType": "image/webp"},
        ],
    }))
}
