//! The eye of LDR-FLIP [Andersson et al. 2020, §4]: contrast sensitivity, colour distance, edges and points.
//!
//! All filters are Gaussians, or Gaussians times a polynomial of one coordinate, so each runs as a filter of rows and one of
//! columns. At the border the outermost pixel goes on.

use super::{PIXELS_PER_DEGREE, Plane3};

/// The exponent of the colour difference, and of the feature difference.
const Q_C: f32 = 0.7;
const Q_F: f32 = 0.5;
/// Distances up to p_c of the largest take up p_t of the range of ΔC.
const P_C: f32 = 0.4;
const P_T: f32 = 0.95;
/// The width of the feature detectors in degrees.
const W: f32 = 0.082;
/// Contrast sensitivity: sums of a √(π/b) exp(-π² d² / b), d in degrees, for achromatic, red-green, blue-yellow.
const SENSITIVITY: [&[(f32, f32)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// Linear Rec.709 to XYZ, from the primaries and white of [IEC 61966-2-1].
const TO_XYZ: [[f32; 3]; 3] =
    [[0.412_390_8, 0.357_584_3, 0.180_480_8], [0.212_639, 0.715_168_7, 0.072_192_3], [0.019_330_8, 0.119_194_8, 0.950_532_2]];
const FROM_XYZ: [[f32; 3]; 3] =
    [[3.240_97, -1.537_383_2, -0.498_610_8], [-0.969_243_6, 1.875_967_5, 0.041_555_1], [0.055_630_1, -0.203_977, 1.056_971_5]];

/// The kernels, made once.
pub(super) struct Eye {
    /// For each opponent channel: weight and Gaussian.
    sensitivity: [Vec<(f32, Vec<f32>)>; 3],
    /// The Gaussian across a feature, and its first and second derivative along it.
    across: Vec<f32>,
    edge: Vec<f32>,
    point: Vec<f32>,
    /// The largest colour distance, that of green and blue.
    farthest: f32,
}

impl Eye {
    pub fn new() -> Self {
        let broadest = 0.04f32;
        let radius = (3.0 * (broadest / (2.0 * std::f32::consts::PI.powi(2))).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
        let sensitivity = SENSITIVITY.map(|terms| {
            let gaussian = |b: f32| -> Vec<f32> {
                let degrees = |x: i32| x as f32 / PIXELS_PER_DEGREE;
                (-radius..=radius).map(|x| (-(std::f32::consts::PI * degrees(x)).powi(2) / b).exp()).collect()
            };
            let terms: Vec<_> = terms.iter().map(|&(a, b)| (a * (std::f32::consts::PI / b).sqrt(), gaussian(b))).collect();
            let total: f32 = terms.iter().map(|(w, g)| w * g.iter().sum::<f32>().powi(2)).sum();
            terms.into_iter().map(|(w, g)| (w / total, g)).collect()
        });

        let sigma = 0.5 * W * PIXELS_PER_DEGREE;
        let radius = (3.0 * sigma).ceil() as i32;
        let kernel = |f: &dyn Fn(f32) -> f32| -> Vec<f32> {
            let values = (-radius..=radius).map(|x| f(x as f32) * (-(x as f32).powi(2) / (2.0 * sigma * sigma)).exp());
            values.collect()
        };
        // The white parts of a detector add up to 1, and so do the black ones.
        let balanced = |k: Vec<f32>| -> Vec<f32> {
            let sum = |sign: f32| k.iter().map(|v| (v * sign).max(0.0)).sum::<f32>();
            let (plus, minus) = (sum(1.0), sum(-1.0));
            k.iter().map(|v| v / if *v > 0.0 { plus } else { minus.max(f32::MIN_POSITIVE) }).collect()
        };
        let across = balanced(kernel(&|_| 1.0));
        let edge = balanced(kernel(&|x| -x));
        let point = balanced(kernel(&|x| x * x / (sigma * sigma) - 1.0));
        let farthest = distance(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(Q_C);
        Eye { sensitivity, across, edge, point, farthest }
    }

    /// ΔE of every pixel of two pictures in linear Rec.709 within [0, 1].
    pub fn difference(&self, x: &Plane3, r: &Plane3) -> Vec<f32> {
        let (seen_x, seen_r) = (self.see(x), self.see(r));
        let pixels = seen_x.into_iter().zip(seen_r);
        pixels.map(|(x, r)| self.colour(x.lab, r.lab).powf(1.0 - feature(&x, &r))).collect()
    }

    /// What the eye makes of a picture.
    fn see(&self, picture: &Plane3) -> Vec<Seen> {
        let (w, h) = (picture.width, picture.height);
        let opponent = picture.map(opponent);
        let channel = |c: usize| Field { w, h, v: opponent.rgb.iter().map(|p| p[c]).collect() };
        let blurred: [Field; 3] = [0, 1, 2].map(|c| {
            let source = channel(c);
            let mut sum = Field { w, h, v: vec![0.0; w * h] };
            for (weight, gaussian) in &self.sensitivity[c] {
                let part = source.filter(gaussian, gaussian);
                sum.v.iter_mut().zip(&part.v).for_each(|(s, p)| *s += weight * p);
            }
            sum
        });
        let y = Field { w, h, v: opponent.rgb.iter().map(|p| (p[0] + 16.0) / 116.0).collect() };
        let length = |k: &[f32]| -> Vec<f32> {
            let (dx, dy) = (y.filter(k, &self.across), y.filter(&self.across, k));
            dx.v.iter().zip(&dy.v).map(|(a, b)| a.hypot(*b)).collect()
        };
        let (edge, point) = (length(&self.edge), length(&self.point));
        let seen = |i: usize| {
            let rgb = from_opponent([0, 1, 2].map(|c| blurred[c].v[i]));
            Seen { lab: hunt_lab(rgb.map(|v| v.clamp(0.0, 1.0))), edge: edge[i], point: point[i] }
        };
        (0..w * h).map(seen).collect()
    }

    /// ΔC: the colour distance, compressed and spread over [0, 1].
    fn colour(&self, x: [f32; 3], r: [f32; 3]) -> f32 {
        let (d, knee) = (distance(x, r).powf(Q_C), P_C * self.farthest);
        if d < knee { P_T * d / knee } else { (P_T + (d - knee) / (self.farthest - knee) * (1.0 - P_T)).min(1.0) }
    }
}

/// A pixel as it is seen: its colour after the blur, the strength of edges and points before it.
struct Seen {
    lab: [f32; 3],
    edge: f32,
    point: f32,
}

/// ΔF: the larger change of an edge's or a point's strength, each at most √2.
fn feature(x: &Seen, r: &Seen) -> f32 {
    let change = (x.edge - r.edge).abs().max((x.point - r.point).abs());
    (change * std::f32::consts::FRAC_1_SQRT_2).min(1.0).powf(Q_F)
}

/// A plane of numbers.
struct Field {
    w: usize,
    h: usize,
    v: Vec<f32>,
}

impl Field {
    /// Correlated with one kernel along the rows, and with another along the columns.
    fn filter(&self, along_x: &[f32], along_y: &[f32]) -> Field {
        let Field { w, h, .. } = *self;
        let rx = along_x.len() / 2;
        let mut rows = vec![0.0f32; w * h];
        let mut padded = vec![0.0f32; w + 2 * rx];
        for (out, row) in rows.chunks_exact_mut(w).zip(self.v.chunks_exact(w)) {
            padded[..rx].fill(row[0]);
            padded[rx..rx + w].copy_from_slice(row);
            padded[rx + w..].fill(row[w - 1]);
            for (k, shifted) in along_x.iter().zip(padded.windows(w)) {
                out.iter_mut().zip(shifted).for_each(|(o, v)| *o += k * v);
            }
        }
        let mut v = vec![0.0f32; w * h];
        for (y, out) in v.chunks_exact_mut(w).enumerate() {
            for (i, k) in along_y.iter().enumerate() {
                let source = (y + i).saturating_sub(along_y.len() / 2).min(h - 1);
                out.iter_mut().zip(&rows[source * w..][..w]).for_each(|(o, v)| *o += k * v);
            }
        }
        Field { w, h, v }
    }
}

fn transform(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// XYZ in units of the white, R = G = B = 1.
fn relative(rgb: [f32; 3]) -> [f32; 3] {
    let (white, xyz) = (transform(&TO_XYZ, [1.0; 3]), transform(&TO_XYZ, rgb));
    [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]]
}

/// Y Cx Cz: L\*a\*b\* with its cube roots left out.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`opponent`].
fn from_opponent([yy, cx, cz]: [f32; 3]) -> [f32; 3] {
    let white = transform(&TO_XYZ, [1.0; 3]);
    let y = (yy + 16.0) / 116.0;
    transform(&FROM_XYZ, [(y + cx / 500.0) * white[0], y * white[1], (y - cz / 200.0) * white[2]])
}

/// L\*a\*b\* with a\*, b\* scaled by L\*/100: colours are seen less in the dark [Hunt 1952].
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    let delta = 6.0f32 / 29.0;
    let root = |t: f32| if t > delta.powi(3) { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 };
    let [x, y, z] = relative(rgb).map(root);
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// HyAB: city block between lightness and colour, Euclid within the colour [Abasi et al. 2020].
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}
