//! Pictures that must be made anew: turned over, multiplied, or textures that a format does not know evaluated over the unit square.

use super::constants::{folded, rgb};
use super::look::{child, flag, float, get, matrix, text};
use etendue_description::{Description, NodeId, Value};
use etendue_image::{Depth, ExrSamples, Format, Image, Picture, SaveOptions};
use glam::{DMat4, DVec2, DVec3, Vec3};
use std::path::Path;

/// Linear Rec.709, or code values where a picture is raw, row by row from the top.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Vec3>,
}

impl Pixels {
    /// A picture of this size by its texels' columns and rows.
    pub fn make(width: usize, height: usize, texel: impl Fn(usize, usize) -> Vec3) -> Self {
        let texels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
        Self { width, height, texels }
    }

    /// The picture of a file, as light; `None` where it is none of a colour or of grey.
    pub fn read(d: &Description, path: &Path) -> Option<Self> {
        let image = open(d, path)?;
        Self::from_image(&image.into_linear(), None)
    }

    /// The picture of a `bitmap` node, in the way that the node asks for.
    pub fn of(d: &Description, id: NodeId) -> Option<Self> {
        let node = d.node(id);
        let Some(Value::Path(path)) = get(node, "filename").filter(|_| node.model.value == "bitmap") else { return None };
        let image = open(d, path)?;
        let whole = matches!(image.encoding().depth, Depth::Unorm8 | Depth::Unorm16);
        let gamma = float(node, "gamma").filter(|_| whole);
        // A number is alpha, where a picture has any.
        let alpha = image.channel("A").filter(|a| flag(node, "number", false) && image.pixels().any(|p| p[*a] != 1.0));
        if flag(node, "raw", false) {
            return Self::from_image(&image, alpha);
        }
        match gamma {
            Some(gamma) => Self::from_image(&image, alpha).map(|p| p.map(|t| t.powf(gamma as f32))),
            None => Self::from_image(&image.into_linear(), alpha),
        }
    }

    fn from_image(image: &Image, one: Option<usize>) -> Option<Self> {
        let places = match (one, image.channel("R"), image.channel("G"), image.channel("B")) {
            (Some(one), ..) => [one; 3],
            (_, Some(r), Some(g), Some(b)) => [r, g, b],
            _ => [image.channel("Y").or((image.channel_count() == 1).then_some(0))?; 3],
        };
        let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
        let texels = image.pixels().map(|p| Vec3::from(places.map(|i| finite(p[i])))).collect();
        Some(Self { width: image.width(), height: image.height(), texels })
    }

    pub fn texel(&self, x: usize, y: usize) -> Vec3 {
        self.texels[y * self.width + x]
    }

    /// The same, upside down.
    pub fn turned(&self) -> Self {
        Self::make(self.width, self.height, |x, y| self.texel(x, self.height - 1 - y))
    }

    pub fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Self {
        self.texels.iter_mut().for_each(|t| *t = f(*t));
        self
    }

    pub fn mean(&self) -> DVec3 {
        self.texels.iter().map(|t| t.as_dvec3()).sum::<DVec3>() / self.texels.len().max(1) as f64
    }

    /// EXR of single precision; nothing where the picture is too large for one.
    pub fn exr(&self) -> Vec<u8> {
        let data = self.texels.iter().flat_map(|t| t.to_array()).collect();
        let options = SaveOptions { exr: ExrSamples::Float, ..SaveOptions::default() };
        let image = Image::rgb(self.width, self.height, data).map(Picture::from);
        image.and_then(|picture| etendue_image::encode(&picture, Format::Exr, &options)).unwrap_or_default()
    }

    /// The value at (u, v), v from the top, by the texture's way of looking it up.
    fn at(&self, uv: DVec2, wrap: &str, nearest: bool) -> Vec3 {
        let size = [self.width as i64, self.height as i64];
        let texel = |x: i64, y: i64| {
            let mut out = [0usize; 2];
            for (k, i) in [x, y].into_iter().enumerate() {
                let n = size[k];
                out[k] = match wrap {
                    "black" if !(0..n).contains(&i) => return Vec3::ZERO,
                    "clamp" | "black" => i.clamp(0, n - 1),
                    "mirror" => {
                        let m = i.rem_euclid(2 * n);
                        m.min(2 * n - 1 - m)
                    }
                    _ => i.rem_euclid(n),
                } as usize;
            }
            self.texel(out[0], out[1])
        };
        let p = uv * DVec2::new(size[0] as f64, size[1] as f64);
        if nearest {
            return texel(p.x.floor() as i64, p.y.floor() as i64);
        }
        let q = p - 0.5;
        let (x, y) = (q.x.floor(), q.y.floor());
        let (s, t) = ((q.x - x) as f32, (q.y - y) as f32);
        let (x, y) = (x as i64, y as i64);
        texel(x, y).lerp(texel(x + 1, y), s).lerp(texel(x, y + 1).lerp(texel(x + 1, y + 1), s), t)
    }
}

/// The file of a `bitmap` node.
pub(super) fn of_bitmap(d: &Description, id: NodeId) -> Option<&Path> {
    match get(d.node(id), "filename") {
        Some(Value::Path(path)) if d.node(id).model.value == "bitmap" => Some(path),
        _ => None,
    }
}

/// What a file holds, decoded no further.
fn open(d: &Description, path: &Path) -> Option<Image> {
    match d.assets.files.get(path) {
        Some(bytes) => etendue_image::decode(bytes, Format::of_path(path)).ok().map(|p| p.image),
        None => etendue_image::load(path).ok(),
    }
}

/// A texture over (u, v) as a picture of the unit square; `None` where it lies in space or on the mesh.
pub(super) fn baked(d: &Description, id: NodeId) -> Option<Pixels> {
    let (mut pictures, mut size) = (std::collections::BTreeMap::new(), [64, 64]);
    gather(d, id, &mut pictures)?;
    for p in pictures.values() {
        size = [size[0].max(p.width), size[1].max(p.height)];
    }
    let look = Look { d, pictures };
    look.value(&Value::Node(id), DVec2::splat(0.5))?;
    let [w, h] = if look.pictures.is_empty() { [512, 512] } else { size };
    let at = |x: usize, y: usize| DVec2::new((x as f64 + 0.5) / w as f64, (y as f64 + 0.5) / h as f64);
    Some(Pixels::make(w, h, |x, y| look.value(&Value::Node(id), at(x, y)).unwrap_or_default()))
}

/// The mean of a texture, as far as it can be told.
pub(super) fn mean(d: &Description, value: &Value) -> Vec3 {
    let look = Look { d, pictures: std::collections::BTreeMap::new() };
    match folded(d, value) {
        Value::Node(id) => {
            if of_bitmap(d, id).is_some() {
                return Pixels::of(d, id).map_or(Vec3::splat(0.5), |p| p.mean().as_vec3());
            }
            let parts: Vec<Vec3> =
                d.node(id).params.iter().filter(|p| is_colour(&p.name.value)).map(|p| mean(d, &p.value.value)).collect();
            if parts.is_empty() { Vec3::splat(0.5) } else { parts.iter().sum::<Vec3>() / parts.len() as f32 }
        }
        constant => look.value(&constant, DVec2::ZERO).unwrap_or(Vec3::splat(0.5)),
    }
}

/// Parameters of textures that hold what the texture is made of.
fn is_colour(name: &str) -> bool {
    matches!(name, "a" | "b" | "color0" | "color1" | "inside" | "outside" | "v00" | "v01" | "v10" | "v11" | "texture" | "value")
}

type Pictures = std::collections::BTreeMap<NodeId, Pixels>;

/// Reads all pictures below a texture.
fn gather(d: &Description, id: NodeId, pictures: &mut Pictures) -> Option<()> {
    if of_bitmap(d, id).is_some() {
        pictures.insert(id, Pixels::of(d, id)?);
    }
    super::look::nodes_in(d.node(id)).try_for_each(|child| gather(d, child, pictures))
}

struct Look<'a> {
    d: &'a Description,
    pictures: Pictures,
}

impl Look<'_> {
    fn value(&self, value: &Value, uv: DVec2) -> Option<Vec3> {
        match folded(self.d, value) {
            Value::Node(id) => self.texture(id, uv),
            even => rgb(&even).map(|rgb| DVec3::from(rgb).as_vec3()),
        }
    }

    fn part(&self, id: NodeId, name: &str, default: f32, uv: DVec2) -> Option<Vec3> {
        get(self.d.node(id), name).map_or(Some(Vec3::splat(default)), |value| self.value(value, uv))
    }

    fn texture(&self, id: NodeId, uv: DVec2) -> Option<Vec3> {
        let node = self.d.node(id);
        if text(node, "mapping").is_some_and(|m| m != "uv") {
            return None;
        }
        let at = uv_of(matrix(node, "to_uv"), uv);
        match node.model.value.as_str() {
            "bitmap" => {
                let nearest = text(node, "filter_type") == Some("nearest");
                Some(self.pictures.get(&id)?.at(at, text(node, "wrap_mode").unwrap_or("repeat"), nearest))
            }
            "checkerboard" => {
                let half = |x: f64| x.rem_euclid(1.0) > 0.5;
                let name = if half(at.x) == half(at.y) { ("color0", 0.4) } else { ("color1", 0.2) };
                self.part(id, name.0, name.1, uv)
            }
            "product" => Some(self.part(id, "a", 1.0, uv)? * self.part(id, "b", 1.0, uv)?),
            "mix" => Some(self.part(id, "a", 0.0, uv)?.lerp(self.part(id, "b", 1.0, uv)?, self.part(id, "amount", 0.5, uv)?.x)),
            "adjusted" => {
                let inner = self.texture(child(node, "texture")?, uv)? * float(node, "scale").unwrap_or(1.0) as f32;
                Some((if flag(node, "invert", false) { 1.0 - inner } else { inner }).max(Vec3::ZERO))
            }
            "bilerp" => {
                let corner = |name, default| self.part(id, name, default, uv);
                let (s, t) = (at.x as f32, at.y as f32);
                Some(corner("v00", 0.0)?.lerp(corner("v10", 0.0)?, s).lerp(corner("v01", 1.0)?.lerp(corner("v11", 1.0)?, s), t))
            }
            _ => None,
        }
    }
}

/// 1/cosθ of the direction in which a projector throws the middle of a texel; `half` are the picture's half sizes at distance 1.
pub(super) fn slant([w, h]: [usize; 2], half: [f64; 2], x: usize, y: usize) -> f64 {
    let at = |i: usize, n: usize, half: f64| (2.0 * (i as f64 + 0.5) / n as f64 - 1.0) * half;
    DVec3::new(at(x, w, half[0]), at(y, h, half[1]), 1.0).length()
}

/// Where `to_uv` takes a point.
pub(super) fn uv_of(m: DMat4, uv: DVec2) -> DVec2 {
    m.x_axis.truncate().truncate() * uv.x + m.y_axis.truncate().truncate() * uv.y + m.w_axis.truncate().truncate()
}
