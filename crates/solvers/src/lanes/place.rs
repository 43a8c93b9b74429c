//! Where the vertices are, on lanes: `Scene::interaction`, as far as Lambert's surfaces ask.

use super::vertices::Vertices;
use etendue_numerics::wide;
use etendue_scene::SurfaceFrame;

/// Makes points and frames of triangles and barycentrics.
pub(super) struct Place<'a>(pub &'a mut Vertices);

impl wide::Job for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let v = self.0;
        for i in 0..v.lanes() {
            let (triangle, bary) = v.triangle(i);
            let (here, found) = (v.surface(i), triangle.surface(bary));
            v.set_surface(i, &choose(v.is_placed(i), here, found));
        }
        for i in 0..v.lanes() {
            let ns = v.ns.get(i);
            let cos = ns.dot(v.wo.get(i));
            v.from_n.set(i, if cos < 0.0 { -ns } else { ns });
            v.is_turned[i] = v.two_sided[i] & u32::from(cos < 0.0);
        }
    }
}

#[inline(always)]
fn choose(first: bool, a: SurfaceFrame, b: SurfaceFrame) -> SurfaceFrame {
    let pick = |a, b| if first { a } else { b };
    let (p, p_error, n) = (pick(a.p, b.p), pick(a.p_error, b.p_error), pick(a.n, b.n));
    let mut shading = b.shading;
    (shading.s, shading.t, shading.n) =
        (pick(a.shading.s, b.shading.s), pick(a.shading.t, b.shading.t), pick(a.shading.n, b.shading.n));
    SurfaceFrame { p, p_error, n, shading }
}
