//! The current transform, and what changes it.

use super::Reader;
use super::tokens::{Token, Tokens};
use etendue_description::{SourceId, Span};
use etendue_numerics::Transform;
use glam::{DMat4, DVec3};

impl Reader<'_> {
    pub(super) fn step<const N: usize>(
        &mut self,
        t: &mut Tokens,
        source: SourceId,
        span: Span,
        make: impl Fn([f64; N]) -> Option<DMat4>,
    ) {
        let Some(numbers) = self.numbers::<N>(t, source, span) else { return };
        match make(numbers).filter(|m| Transform::new(*m).is_some()) {
            Some(m) => self.state.apply(m),
            None => {
                self.diagnostics
                    .error(span, "this step flattens space, has no direction, or is not finite")
                    .help("a transform must have an inverse");
            }
        }
    }

    pub(super) fn set_transform(&mut self, m: DMat4) {
        for i in 0..2 {
            if self.state.active[i] {
                self.state.ctm[i] = m;
            }
        }
    }

    pub(super) fn active_transform(&mut self, t: &mut Tokens, source: SourceId, span: Span) {
        let word = match t.peek() {
            Ok(Token::Word(r)) => {
                let _ = t.next();
                t.text[r].to_owned()
            }
            _ => String::new(),
        };
        self.state.active = match word.as_str() {
            "StartTime" => [true, false],
            "EndTime" => [false, true],
            "All" => [true, true],
            _ => {
                self.mistakes += 1;
                let _ = source;
                self.diagnostics.error(span, "`ActiveTransform` is followed by StartTime, EndTime or All");
                return;
            }
        };
    }

    /// The transform in force, of something that cannot move; `None` where it has no inverse, which is told.
    pub(super) fn still(&mut self, span: Span, what: &str) -> Option<Transform> {
        if self.state.moves() {
            let text = format!("{what} moves: motion cannot be rendered yet");
            self.diagnostics.error(span, text).help("take out `ActiveTransform`, and it stands still");
        }
        let transform = Transform::new(self.state.ctm[0]);
        if transform.is_none() {
            self.diagnostics.error(span, format!("the transform of {what} flattens space or is not finite"));
        }
        transform
    }
}

/// Rodrigues' rotation around a unit axis.
pub(super) fn rotation(axis: DVec3, angle: f64) -> DMat4 {
    DMat4::from_axis_angle(axis, angle)
}

/// From the world into the coordinates of a camera (x right, y up, z ahead) at `eye` that looks at `at`.
pub(super) fn look_at(eye: DVec3, at: DVec3, up: DVec3) -> Option<DMat4> {
    let ahead = (at - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(ahead).try_normalize()?;
    let up = ahead.cross(right);
    let to_world = DMat4::from_cols(right.extend(0.0), up.extend(0.0), ahead.extend(0.0), eye.extend(1.0));
    Some(to_world.inverse())
}
