//! A piece of the film that one thread fills: samples go through the reconstruction filter in f32, in a fixed order, and are then
//! merged into the film's exact sums.

use crate::film::FilmShape;
use crate::sums::NonFinite;
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Spectrum, Vec2, Vec4};

/// Entries of the tabulated kernel; linear between them.
const TABLE: usize = 256;

/// The reconstruction kernel, tabulated over its radius.
#[derive(Clone, Debug)]
pub(crate) struct KernelTable {
    pub(crate) radius: f32,
    is_box: bool,
    /// Pixels beyond a sample's own that it may reach.
    border: i32,
    /// Entries per pixel.
    density: f32,
    values: Vec<f32>,
}

impl KernelTable {
    pub(crate) fn new(kernel: &Kernel) -> Self {
        let radius = kernel.radius();
        let at = |i: usize| kernel.eval(radius * (i as f32 / TABLE as f32).min(1.0));
        let is_box = matches!(kernel, Kernel::Box { radius } if *radius == 0.5);
        let border = if is_box { 0 } else { (radius - 0.5).ceil().max(0.0) as i32 };
        Self { radius, is_box, border, density: TABLE as f32 / radius, values: (0..TABLE + 2).map(at).collect() }
    }

    #[inline]
    pub(crate) fn eval(&self, x: f32) -> f32 {
        let s = x.abs() * self.density;
        if s >= TABLE as f32 {
            return 0.0;
        }
        let i = s as i32 as usize;
        let t = s - i as f32;
        self.values[i] * (1.0 - t) + self.values[i + 1] * t
    }

    /// Pixels beyond a sample's own that its kernel may reach.
    #[inline]
    pub(crate) fn border(&self) -> i32 {
        self.border
    }
}

/// Sums over the pixels of a rectangle and a border around it.
#[derive(Clone, Debug)]
pub struct Tile {
    kernel: KernelTable,
    shape: FilmShape,
    /// First pixel, border included; may be negative.
    pub(crate) origin: [i32; 2],
    /// Size, border included.
    pub(crate) size: [i32; 2],
    /// (Σ k L, Σ k) of each pixel, rows after one another.
    pub(crate) sums: Vec<Vec4>,
    pub(crate) dropped: Vec<NonFinite>,
    pub(crate) dropped_count: u64,
}

impl Tile {
    pub(crate) fn new(kernel: KernelTable, shape: FilmShape) -> Self {
        Self { kernel, shape, origin: [0; 2], size: [0; 2], sums: Vec::new(), dropped: Vec::new(), dropped_count: 0 }
    }

    /// Empties the tile and lays it over the pixels [x0, x1) × [y0, y1) of the film.
    pub fn begin(&mut self, [x0, y0]: [u32; 2], [x1, y1]: [u32; 2]) {
        let border = self.kernel.border();
        self.origin = [x0 as i32 - border, y0 as i32 - border];
        self.size = [(x1 - x0) as i32 + 2 * border, (y1 - y0) as i32 + 2 * border];
        self.sums.clear();
        self.sums.resize((self.size[0] * self.size[1]) as usize, Vec4::ZERO);
        self.dropped.clear();
        self.dropped_count = 0;
    }

    /// (Σ k L, Σ k) of each pixel that it has a part of, within the film.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = ([u32; 2], Vec4)> {
        let ([width, height], [x0, y0], [columns, rows]) = (self.shape.size.map(|n| n as i32), self.origin, self.size);
        let within = move |[x, y]: [i32; 2]| (0..width).contains(&x) && (0..height).contains(&y);
        let places = (y0..y0 + rows).flat_map(move |y| (x0..x0 + columns).map(move |x| [x, y]));
        places.zip(&self.sums).filter(move |(at, _)| within(*at)).map(|(at, sum)| (at.map(|n| n as u32), *sum))
    }

    /// Adds the radiance `l` seen at `position` (pixels from the film's corner, within the tile's rectangle). A value that is not finite
    /// is dropped and counted; `sample` says which one it was.
    #[inline]
    pub fn add(&mut self, position: Vec2, l: Spectrum, sample: u32) {
        self.add_weighted(position, l, 1.0, sample);
    }

    /// The same for a sample that counts `weight` times.
    #[inline]
    pub fn add_weighted(&mut self, position: Vec2, l: Spectrum, weight: f32, sample: u32) {
        if !l.is_finite() {
            self.drop_sample(position, sample);
            return;
        }
        let [r, g, b] = l.to_rgb();
        let value = weight * Vec4::new(r, g, b, 1.0);
        let local = position - Vec2::new(self.origin[0] as f32, self.origin[1] as f32);
        if self.kernel.is_box {
            let (x, y) = ((local.x as i32).clamp(0, self.size[0] - 1), (local.y as i32).clamp(0, self.size[1] - 1));
            self.sums[(y * self.size[0] + x) as usize] += value;
            return;
        }
        self.add_filtered(local, value);
    }

    fn add_filtered(&mut self, local: Vec2, value: Vec4) {
        let radius = self.kernel.radius;
        // Pixel i has its centre at i + 1/2; those with |i + 1/2 - s| < radius are reached.
        let range = |s: f32, n: i32| (ceil(s - 0.5 - radius).max(0), floor(s - 0.5 + radius).min(n - 1));
        let ((x0, x1), (y0, y1)) = (range(local.x, self.size[0]), range(local.y, self.size[1]));
        let mut weights = [0.0f32; 32];
        let count = (x1 - x0 + 1).clamp(0, 32) as usize;
        for (i, w) in weights[..count].iter_mut().enumerate() {
            *w = self.kernel.eval((x0 + i as i32) as f32 + 0.5 - local.x);
        }
        for y in y0..=y1 {
            let row = self.kernel.eval(y as f32 + 0.5 - local.y);
            let start = (y * self.size[0] + x0) as usize;
            for (sum, w) in self.sums[start..start + count].iter_mut().zip(&weights) {
                *sum += value * (w * row);
            }
        }
    }

    #[cold]
    fn drop_sample(&mut self, position: Vec2, sample: u32) {
        self.dropped_count += 1;
        if self.dropped.len() < NonFinite::KEPT {
            let pixel = [position.x as u32, position.y as u32].map(|p| p.min(self.shape.size[0].max(self.shape.size[1])));
            self.dropped.push(NonFinite { pixel, sample });
        }
    }
}

/// The least whole number not below x, of numbers that are not huge: without a call.
#[inline(always)]
fn ceil(x: f32) -> i32 {
    let whole = x as i32;
    whole.saturating_add(i32::from(x > whole as f32))
}

/// The greatest whole number not above x.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let whole = x as i32;
    whole.saturating_sub(i32::from(x < whole as f32))
}
