//! A solution as binary glTF 2.0: one mesh, not lit again (`KHR_materials_unlit`).
//!
//! - with colours of corners: `COLOR_0`, linear radiance relative to white;
//! - with a lightmap: `TEXCOORD_1` leads into an atlas of 4 x 4 texels a patch. The four in the middle are its corners, so that the texture's own
//!   bilinear filter is the field's interpolation; those around repeat them, so that no filter reaches a neighbour's light.
//!
//! `asset.extras` tells the radiance that white stands for. The lightmap within is for display, 8 bits; [`lightmap`] is the same in floating point,
//! in W/(m² sr) and without a limit.

use super::export::{Corners, display, white};
use etendue_image::{Encoding, Format, Image, Picture, SaveOptions, encode};
use glam::{DVec3, Vec2};
use serde_json::{Value, json};

/// Texels of a patch's tile along a side.
const TILE: usize = 4;

/// The binary chunk in the making, and the views of it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// The number of a new view of `bytes`.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// The number of a new accessor of floats.
    fn floats<const N: usize>(&mut self, x: &[[f32; N]], bounds: bool) -> usize {
        let bytes: Vec<u8> = x.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let mut accessor = json!({ "bufferView": view, "componentType": FLOAT, "count": x.len(), "type": kind });
        if bounds {
            let of = |f: fn(f32, f32) -> f32| (0..N).map(|c| x.iter().map(|p| p[c]).reduce(f)).collect::<Vec<_>>();
            accessor["min"] = json!(of(f32::min));
            accessor["max"] = json!(of(f32::max));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn indices(&mut self, x: &[u32]) -> usize {
        let bytes: Vec<u8> = x.iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": x.len(), "type": "SCALAR" }));
        self.accessors.len() - 1
    }
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINEAR: u32 = 9729;
const CLAMP_TO_EDGE: u32 = 33071;

/// The file.
pub(super) fn write(corners: &Corners, lightmap: bool) -> Result<Vec<u8>, String> {
    let white = white(&corners.b);
    let mut buffer = Buffer::default();
    let three = |x: &[DVec3]| x.iter().map(|x| x.as_vec3().to_array()).collect::<Vec<_>>();
    let mut attributes = json!({
        "POSITION": buffer.floats(&three(&corners.points), true),
        "NORMAL": buffer.floats(&three(&corners.normals), false),
    });
    let mut triangles = Vec::new();
    for (first, count) in &corners.patches {
        (1..count - 1).for_each(|k| triangles.extend([*first, first + k, first + k + 1]));
    }
    let indices = buffer.indices(&triangles);
    let mut material = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        "extensions": { "KHR_materials_unlit": {} },
    });
    let mut root = json!({});
    if lightmap {
        let atlas = Atlas::new(corners);
        // Both sets are the lightmap's: there is no other texture, and readers of old want a first set.
        let uv = buffer.floats(&atlas.uv, false);
        attributes["TEXCOORD_0"] = uv.into();
        attributes["TEXCOORD_1"] = uv.into();
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0, "texCoord": 1 });
        let image = buffer.view(&atlas.png(white)?, None);
        root["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
        root["samplers"] = json!([{ "magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE }]);
        root["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    } else {
        let relative = |b: &DVec3| (*b / white).clamp(DVec3::ZERO, DVec3::ONE).as_vec3().to_array();
        attributes["COLOR_0"] = buffer.floats(&corners.b.iter().map(relative).collect::<Vec<_>>(), false).into();
    }
    root["asset"] = json!({
        "version": "2.0",
        "generator": crate::picture::software(),
        "extras": { "whiteRadiance_W_per_m2_sr": white / std::f64::consts::PI },
    });
    root["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    root["scene"] = json!(0);
    root["scenes"] = json!([{ "nodes": [0] }]);
    root["nodes"] = json!([{ "mesh": 0 }]);
    root["meshes"] = json!([{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0, "mode": 4 }] }]);
    root["materials"] = json!([material]);
    root["accessors"] = buffer.accessors.into();
    root["bufferViews"] = buffer.views.into();
    root["buffers"] = json!([{ "byteLength": buffer.bytes.len() }]);
    container(&root, &buffer.bytes)
}

/// The lightmap by itself: radiance L = B/π, W/(m² sr), linear Rec.709, for the same second UV set.
pub(super) fn lightmap(corners: &Corners) -> Result<Image, String> {
    let atlas = Atlas::new(corners);
    let radiance = atlas.texels.iter().flat_map(|b| (*b / std::f64::consts::PI).as_vec3().to_array()).collect();
    Image::rgb(atlas.side, atlas.side, radiance).map_err(|e| e.to_string())
}

/// Header, JSON chunk, binary chunk.
fn container(root: &Value, binary: &[u8]) -> Result<Vec<u8>, String> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + binary.len())
        .map_err(|_| "the mesh is larger than 4 GiB, which a .glb cannot hold".to_owned())?;
    let word = |x: usize| (x as u32).to_le_bytes();
    let head = [*b"glTF", word(2), length.to_le_bytes(), word(text.len()), *b"JSON"].concat();
    Ok([head, text, word(binary.len()).to_vec(), b"BIN\0".to_vec(), binary.to_vec()].concat())
}

/// The lightmap.
struct Atlas {
    /// Texels along a side.
    side: usize,
    /// B, W/m².
    texels: Vec<DVec3>,
    /// Of each corner.
    uv: Vec<[f32; 2]>,
}

impl Atlas {
    fn new(corners: &Corners) -> Self {
        let columns = (corners.patches.len() as f64).sqrt().ceil().max(1.0) as usize;
        let side = columns * TILE;
        let mut atlas = Self { side, texels: vec![DVec3::ZERO; side * side], uv: vec![[0.0; 2]; corners.points.len()] };
        for (i, (first, count)) in corners.patches.iter().enumerate() {
            let (left, top) = (i % columns * TILE, i / columns * TILE);
            let b = |k: usize| corners.b[*first as usize + k];
            // Corners lie around the tile: a triangle's fourth is where its plane goes on to.
            let around =
                if *count == 4 { [b(0), b(1), b(2), b(3)] } else { [b(0), b(1), (b(1) + b(2) - b(0)).max(DVec3::ZERO), b(2)] };
            let [p, q, r, s] = around;
            for y in 0..TILE {
                for x in 0..TILE {
                    let row = if y < TILE / 2 { [p, q] } else { [s, r] };
                    atlas.texels[(top + y) * side + left + x] = row[usize::from(x >= TILE / 2)];
                }
            }
            let places: &[[usize; 2]] = if *count == 4 { &[[1, 1], [2, 1], [2, 2], [1, 2]] } else { &[[1, 1], [2, 1], [1, 2]] };
            for (k, place) in places.iter().enumerate() {
                let texel = Vec2::new((left + place[0]) as f32, (top + place[1]) as f32) + 0.5;
                atlas.uv[*first as usize + k] = (texel / side as f32).to_array();
            }
        }
        atlas
    }

    /// For a display: sRGB, of which white is `white`.
    fn png(&self, white: f64) -> Result<Vec<u8>, String> {
        let shown = self.texels.iter().flat_map(|b| display(*b, white)).map(|x| f32::from(x) / 255.0).collect();
        let image = Image::rgb(self.side, self.side, shown).map_err(|e| e.to_string())?.with_encoding(Encoding::SRGB);
        encode(&Picture::from(image), Format::Png, &SaveOptions::default()).map_err(|e| e.to_string())
    }
}
