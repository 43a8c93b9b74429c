//! Parameters of the materials that hold others.

use super::Compiler;
use super::models::FRACTION;
use crate::ids::MaterialId;
use crate::material::{Blend, BumpMap, Mask, Material, NormalMap, NormalOptions, TwoSided};
use crate::texture::{ColorSlot, Role, Texture};
use etendue_description::{Kind, Params};

impl<'a> Compiler<'a> {
    /// The nested materials, at least `least` and at most `most`; `None` where that is not so, which has been told.
    fn nested(&mut self, p: &mut Params<'a>, least: usize, most: usize) -> Option<Vec<MaterialId>> {
        let children = p.children(Kind::Bsdf);
        let wanted = match (least, most) {
            (1, 1) => "one nested material",
            (2, 2) => "two nested materials",
            _ => "one or two nested materials",
        };
        if !(least..=most).contains(&children.len()) {
            let span = children.get(most).map_or(p.span(), |(_, param)| param.value.span);
            let text = format!("`{}` needs {wanted}, not {}", p.node.model.value, children.len());
            self.diagnostics.error(span, text);
            return None;
        }
        children
            .iter()
            .map(|(id, _)| {
                let material = self.material(*id);
                // A nested material that failed has been told.
                self.material_of.get(id).copied().flatten().map(|_| material)
            })
            .collect()
    }

    pub(crate) fn at(&self, id: MaterialId) -> &Material {
        &self.materials[id.index()]
    }

    pub(super) fn mask(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let opacity = self.scalar(p, "opacity", 0.5, FRACTION);
        let nested = self.nested(p, 1, 1)?[0];
        Some(Mask::new(opacity, nested, self.at(nested)).into())
    }

    pub(super) fn blend(&mut self, p: &mut Params<'a>) -> Option<Material> {
        if !p.has("weight") {
            self.diagnostics.error(p.span(), "`blendbsdf` needs a `weight`");
        }
        let weight = self.scalar(p, "weight", 0.5, FRACTION);
        let nested = self.nested(p, 2, 2)?;
        let nested = [nested[0], nested[1]];
        Some(Blend::new(weight, nested, nested.map(|id| self.at(id))).into())
    }

    pub(super) fn two_sided(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let nested = self.nested(p, 1, 2)?;
        let nested = [nested[0], *nested.get(1).unwrap_or(&nested[0])];
        if nested.iter().any(|id| self.at(*id).events().transmits()) {
            self.diagnostics.error(p.span(), "`twosided` cannot hold a material that lets light through");
            return None;
        }
        Some(TwoSided::new(nested, nested.map(|id| self.at(id))).into())
    }

    fn normal_options(&mut self, p: &mut Params<'a>) -> Option<NormalOptions> {
        let flip = p.bool(self.diagnostics, "flip_invalid_normals", true);
        let soften = p.bool(self.diagnostics, "use_shadowing_function", true);
        let nested = self.nested(p, 1, 1)?[0];
        Some(NormalOptions::new(nested, self.at(nested), flip, soften))
    }

    pub(super) fn bump_map(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let scale = p.float(self.diagnostics, "scale", 1.0, f64::from(f32::MIN)..=f64::from(f32::MAX)) as f32;
        let options = self.normal_options(p);
        let textures = p.children(Kind::Texture);
        let [(height, _)] = textures[..] else {
            let span = textures.get(1).map_or(p.span(), |(_, param)| param.value.span);
            self.diagnostics.error(span, format!("`bumpmap` needs one nested texture, not {}", textures.len()));
            return None;
        };
        Some(BumpMap { height: self.texture(height, Role::Unbounded)?, scale, options: options? }.into())
    }

    pub(super) fn normal_map(&mut self, p: &mut Params<'a>) -> Option<Material> {
        let options = self.normal_options(p);
        if !p.has("normalmap") {
            self.diagnostics.error(p.span(), "`normalmap` needs a texture named `normalmap`");
            return None;
        }
        let span = p.span_of("normalmap");
        let normals = self.unbounded(p, "normalmap", 1.0);
        if let ColorSlot::Texture(id) = normals
            && let Texture::Bitmap(bitmap) = &self.textures[id.index()]
        {
            if bitmap.texels.is_grey() {
                self.diagnostics.error(span, "a normal map needs three channels; this picture is grey");
            } else if bitmap.texels.is_decoded() {
                let text = "the normals of this picture are decoded from sRGB before use";
                self.diagnostics.note(span, text).help("most normal maps want `raw` to be true");
            }
        }
        Some(NormalMap { normals, options: options? }.into())
    }
}
