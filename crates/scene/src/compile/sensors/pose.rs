//! Where cameras and directed lights stand, and how wide they see or shine.

use crate::compile::Compiler;
use etendue_description::Params;
use etendue_numerics::{Frame, Vec3};
use glam::{DMat3, DVec3};

/// Diagonal of the film that focal lengths are told for, 36 × 24 mm.
const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_87;

/// How far lengths and angles may stray from those of a plain rotation.
const TOLERANCE: f64 = 1e-3;

/// What becomes of scales in `to_world`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::compile) enum Scales {
    /// Lengths along the axes do not matter.
    TakeOut,
    /// A camera: one scale for all axes is taken out with a warning, more are refused.
    Tell,
}

impl<'a> Compiler<'a> {
    /// The place and the orthonormal axes (of either hand) that `to_world` gives; `None` where it bends or shears, which has been told.
    pub(in crate::compile) fn pose(&mut self, params: &mut Params<'a>, scales: Scales) -> Option<(Vec3, Frame)> {
        let transform = params.transform(self.diagnostics, "to_world");
        let span = params.span_of("to_world");
        if !transform.is_affine() {
            self.diagnostics.error(span, "this `to_world` is projective: its last row must be 0 0 0 1");
            return None;
        }
        let matrix = transform.matrix();
        let axes = DMat3::from_mat4(matrix);
        let lengths = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
        let [x, y, z] = [axes.x_axis / lengths.x, axes.y_axis / lengths.y, axes.z_axis / lengths.z];
        let model = &params.node.model.value;
        if x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) > TOLERANCE {
            let text = format!("`to_world` of `{model}` shears: the images of its axes are not at right angles");
            self.diagnostics.error(span, text).help("only rotations, translations and reflections have a meaning here");
            return None;
        }
        if scales == Scales::Tell {
            let (low, high) = (lengths.min_element(), lengths.max_element());
            if high > low * (1.0 + TOLERANCE) {
                let text =
                    format!("`to_world` of `{model}` scales its axes by {:.4}, {:.4} and {:.4}", lengths.x, lengths.y, lengths.z);
                self.diagnostics
                    .error(span, text)
                    .help("a camera cannot be stretched: give the field of view by `fov` and the film's size");
                return None;
            }
            if (high - 1.0).abs() > TOLERANCE {
                self.diagnostics.warning(span, format!("`to_world` of `{model}` scales by {high:.4}; the scale is taken out"));
            }
        }

        // Exactly orthogonal, z first: it is where cameras and lights look.
        let y = (y - z * y.dot(z)).normalize();
        let x = (x - z * x.dot(z) - y * x.dot(y)).normalize();
        let frame = Frame { s: x.as_vec3().normalize(), t: y.as_vec3().normalize(), n: z.as_vec3().normalize() };
        Some((matrix.w_axis.truncate().as_vec3(), frame))
    }

    /// tan(fov_x / 2) by `fov` and `fov_axis`, or by `focal_length`; `aspect` is width over height.
    pub(in crate::compile) fn tan_half_fov(&mut self, params: &mut Params<'a>, aspect: f64) -> f64 {
        let axes = ["x", "y", "diagonal", "smaller", "larger"];
        let axis = params.choice(self.diagnostics, "fov_axis", &axes);
        let fov = params.float_opt(self.diagnostics, "fov");
        let diagonal = self.focal_length(params);
        if fov.is_some() && params.has("focal_length") {
            let text = "both `fov` and `focal_length` are given: they say the same thing";
            self.diagnostics.error(params.span_of("focal_length"), text);
        }

        // Half the film at distance 1, along the axis that the angle is told for.
        let (tan, axis) = match fov {
            None => (0.5 * diagonal, 2),
            Some(degrees) if degrees > 0.0 && degrees < 180.0 => ((0.5 * degrees.to_radians()).tan(), axis),
            Some(degrees) => {
                let text =
                    format!("`fov` of `{}` is {degrees}, expected more than 0 and less than 180 degrees", params.node.model.value);
                self.diagnostics.error(params.span_of("fov"), text);
                return 1.0;
            }
        };
        match axes[axis] {
            "y" => tan * aspect,
            "diagonal" => tan / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
            "smaller" if aspect > 1.0 => tan * aspect,
            "larger" if aspect <= 1.0 => tan * aspect,
            _ => tan,
        }
    }

    /// The film's diagonal over the focal length, both in mm: `50mm` where nothing is said.
    fn focal_length(&mut self, params: &mut Params<'a>) -> f64 {
        let text = params.string_opt(self.diagnostics, "focal_length").unwrap_or("50mm");
        let number = text.trim().trim_end_matches("mm").trim_end().parse::<f64>();
        let length = number.ok().filter(|mm| *mm > 0.0 && mm.is_finite());
        if length.is_none() {
            let message = format!("`focal_length` of `{}` is `{text}`, expected a length such as `50mm`", params.node.model.value);
            self.diagnostics.error(params.span_of("focal_length"), message);
        }
        FILM_DIAGONAL_MM / length.unwrap_or(50.0)
    }
}
