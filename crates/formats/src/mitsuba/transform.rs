//! `<transform>`: maps of space, each applied after those above it.

use super::attributes::Attributes;
use super::text::Text;
use super::{File, Parent, Reader};
use crate::xml::ElementId;
use etendue_description::{Param, Spanned, Value};
use etendue_numerics::Transform;
use glam::{DMat3, DMat4, DVec3};

impl Reader<'_> {
    /// `<transform name>` with its steps.
    pub(super) fn transform(&mut self, file: &File, id: ElementId, mut attributes: Attributes, parent: Parent) {
        let name = attributes.required("name");
        attributes.finish(self);
        let mut whole = DMat4::IDENTITY;
        let mut sound = true;
        for child in file.document.children(id) {
            let step = Attributes::new(self, file, child);
            let place = file.span(&file.document.element(child).tag);
            let Some(matrix) = self.step(step) else {
                sound = false;
                continue;
            };
            // A step that cannot be undone spoils the whole, and is easier to mend where it stands.
            if Transform::new(matrix).is_none() {
                self.diagnostics
                    .error(place, format!("this `<{}>` flattens space or is not finite", file.name(child)))
                    .help("a transform must have an inverse");
                sound = false;
            }
            whole = matrix * whole;
            self.no_children(file, child);
        }
        self.stray_text(file, id);
        let Some(name) = name.filter(|_| sound) else { return };
        let span = file.span(&file.document.element(id).tag);
        match Transform::new(whole) {
            Some(transform) => {
                let value = Spanned::new(Value::Transform(Box::new(transform)), span);
                self.give(parent, Param { name: Spanned::new(name.value, name.span), value });
            }
            None => {
                self.diagnostics.error(span, "this transform as a whole flattens space or is not finite");
            }
        }
    }

    /// The matrix of one step.
    fn step(&mut self, mut attributes: Attributes) -> Option<DMat4> {
        let name = attributes.element.clone();
        let matrix = match name.as_str() {
            "translate" => self.axes(&mut attributes, 0.0).map(DMat4::from_translation),
            "scale" => self.axes(&mut attributes, 1.0).map(DMat4::from_scale),
            "rotate" => self.rotate(&mut attributes),
            "lookat" => self.look_at(&mut attributes),
            "matrix" => attributes.required("value").and_then(|text| self.matrix(&text)),
            _ => {
                let known = ["translate", "rotate", "scale", "lookat", "matrix"];
                let error = self.diagnostics.error(attributes.span, format!("`<{name}>` is no step of a transform"));
                match etendue_description::nearest(&name, known) {
                    Some(near) => error.help(format!("did you mean `<{near}>`?")),
                    None => error.help("known are: translate, rotate, scale, lookat, matrix"),
                };
                return None;
            }
        };
        attributes.finish(self);
        matrix
    }

    /// `x`, `y`, `z`, each with a default, or `value` with one or three numbers.
    fn axes(&mut self, attributes: &mut Attributes, default: f64) -> Option<DVec3> {
        if attributes.has("value") {
            let value = attributes.optional("value")?;
            return value.one_or_three(&mut self.diagnostics).map(DVec3::from);
        }
        let mut axis = |name| {
            let absent = !attributes.has(name);
            match attributes.optional(name) {
                Some(text) => text.float(&mut self.diagnostics, true),
                None => absent.then_some(default),
            }
        };
        let (x, y, z) = (axis("x"), axis("y"), axis("z"));
        Some(DVec3::new(x?, y?, z?))
    }

    /// By an angle in degrees around an axis, counterclockwise for whom the axis points at.
    fn rotate(&mut self, attributes: &mut Attributes) -> Option<DMat4> {
        let angle = attributes.required("angle").and_then(|text| text.float(&mut self.diagnostics, true));
        let axis = self.axes(attributes, 0.0)?;
        let length = axis.length();
        let Some(axis) = axis.try_normalize() else {
            self.diagnostics
                .error(attributes.span, "the axis of this `<rotate>` is zero")
                .help("such as <rotate y=\"1\" angle=\"90\"/>");
            return None;
        };
        if (length - 1.0).abs() > 1e-3 {
            let text = format!(
                "the axis of this `<rotate>` has length {length:.4} and is made a unit vector; Mitsuba 3 takes it as it is"
            );
            self.diagnostics
                .warning(attributes.span, text)
                .help("the picture differs from Mitsuba's, whose map is no rotation then");
        }
        Some(rotation(axis, angle?.to_radians()))
    }

    /// From a camera's coordinates (z ahead, y up, x left) into the world.
    fn look_at(&mut self, attributes: &mut Attributes) -> Option<DMat4> {
        let mut point = |text: Option<Text>| text.and_then(|text| self.triple(&text));
        let origin = point(attributes.required("origin"));
        let target = point(attributes.required("target"));
        let absent = !attributes.has("up");
        let up = attributes.optional("up").and_then(|text| point(Some(text)));
        let up = if absent { Some(DVec3::ZERO) } else { up };
        let (origin, target, up) = (origin?, target?, up?);
        let Some(ahead) = (target - origin).try_normalize() else {
            self.diagnostics.error(attributes.span, "origin and target of this `<lookat>` are the same point");
            return None;
        };
        let up = if up == DVec3::ZERO { perpendicular(ahead) } else { up };
        let Some(left) = up.cross(ahead).try_normalize().filter(|_| up.normalize().cross(ahead).length() > 1e-12) else {
            self.diagnostics
                .error(attributes.span, "`up` of this `<lookat>` points along the line from origin to target")
                .help("any other direction will do");
            return None;
        };
        let up = ahead.cross(left);
        Some(DMat4::from_cols(left.extend(0.0), up.extend(0.0), ahead.extend(0.0), origin.extend(1.0)))
    }

    fn triple(&mut self, text: &Text) -> Option<DVec3> {
        let numbers = text.floats(&mut self.diagnostics)?;
        match numbers[..] {
            [x, y, z] => Some(DVec3::new(x, y, z)),
            _ => {
                text.mistake(&mut self.diagnostics, format!("expected three numbers, found {}", numbers.len()));
                None
            }
        }
    }

    /// Sixteen or nine numbers, row by row.
    fn matrix(&mut self, text: &Text) -> Option<DMat4> {
        let numbers = text.floats(&mut self.diagnostics)?;
        if let Ok(rows) = <[f64; 16]>::try_from(numbers.as_slice()) {
            return Some(DMat4::from_cols_array(&rows).transpose());
        }
        if let Ok(rows) = <[f64; 9]>::try_from(numbers.as_slice()) {
            return Some(DMat4::from_mat3(DMat3::from_cols_array(&rows).transpose()));
        }
        text.mistake(&mut self.diagnostics, format!("a matrix has 16 numbers, or 9, found {}", numbers.len()));
        None
    }
}

/// Rodrigues' rotation around a unit axis.
fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    let (sin, cos) = libm::sincos(angle);
    let rotate = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat4::from_mat3(DMat3::from_cols(rotate(DVec3::X), rotate(DVec3::Y), rotate(DVec3::Z)))
}

/// A unit vector perpendicular to a unit vector, the first of the basis of [Duff et al. 2017], as Mitsuba chooses it.
fn perpendicular(n: DVec3) -> DVec3 {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x)
}
