//! The areas of a picture whose means are compared: blocks of a grid, and the whole.

use serde::Serialize;

/// Pixels that a block has across and down, at least: means of fewer are far from normal.
const LEAST: u32 = 4;

/// A partition of a picture into blocks of nearly equal size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Grid {
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// Blocks across and down.
    pub blocks: [u32; 2],
}

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Area {
    /// The whole picture.
    Picture,
    /// The block of this column and row, counted from the top left.
    Block(u32, u32),
}

impl Grid {
    /// 8 × 8.
    pub const BLOCKS: u32 = 8;

    /// At most `most` blocks across and down, fewer where they would be smaller than 4 pixels.
    pub fn new(size: [u32; 2], most: u32) -> Self {
        Self { size, blocks: size.map(|n| (n / LEAST).clamp(1, most.max(1))) }
    }

    /// The areas in the order of [`Grid::means`]: the picture, then its blocks, rows from the top.
    pub fn areas(&self) -> impl Iterator<Item = Area> + use<> {
        let [columns, rows] = self.blocks;
        let blocks = (0..rows).flat_map(move |y| (0..columns).map(move |x| Area::Block(x, y)));
        std::iter::once(Area::Picture).chain(blocks)
    }

    /// Number of areas.
    pub fn len(&self) -> usize {
        1 + (self.blocks[0] * self.blocks[1]) as usize
    }

    /// A grid has the whole picture at least.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// First pixel and one past the last.
    pub fn rectangle(&self, area: Area) -> ([u32; 2], [u32; 2]) {
        let edge = |axis: usize, i: u32| (u64::from(i) * u64::from(self.size[axis]) / u64::from(self.blocks[axis])) as u32;
        match area {
            Area::Picture => ([0, 0], self.size),
            Area::Block(x, y) => ([edge(0, x), edge(1, y)], [edge(0, x + 1), edge(1, y + 1)]),
        }
    }

    /// The means of the areas of a picture (rows from the top, as a film develops it); pixels that are missing count as black.
    pub fn means(&self, picture: &[[f32; 3]]) -> Vec<[f64; 3]> {
        let mean = |area: Area| {
            let ([x0, y0], [x1, y1]) = self.rectangle(area);
            let mut sum = [0.0f64; 3];
            for y in y0..y1 {
                for x in x0..x1 {
                    let pixel = picture.get(y as usize * self.size[0] as usize + x as usize).copied().unwrap_or_default();
                    sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += f64::from(p));
                }
            }
            let count = f64::from((x1 - x0) * (y1 - y0)).max(1.0);
            sum.map(|s| s / count)
        };
        self.areas().map(mean).collect()
    }
}

impl std::fmt::Display for Area {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Picture => f.write_str("picture"),
            Self::Block(x, y) => write!(f, "block ({x}, {y})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_each_pixel_once() {
        for size in [[64, 64], [37, 61], [9, 3], [1, 1]] {
            let grid = Grid::new(size, 8);
            let mut count = vec![0; (size[0] * size[1]) as usize];
            for area in grid.areas().skip(1) {
                let ([x0, y0], [x1, y1]) = grid.rectangle(area);
                (y0..y1).for_each(|y| (x0..x1).for_each(|x| count[(y * size[0] + x) as usize] += 1));
            }
            assert!(count.iter().all(|c| *c == 1), "{size:?}");
            assert_eq!(grid.areas().count(), grid.len());
        }
        assert_eq!(Grid::new([64, 64], 8).blocks, [8, 8]);
        assert_eq!(Grid::new([16, 9], 8).blocks, [4, 2]);
    }

    #[test]
    fn means_of_a_ramp() {
        let grid = Grid::new([8, 4], 8);
        let picture: Vec<[f32; 3]> = (0..32).map(|i| [(i % 8) as f32, 1.0, 0.0]).collect();
        assert_eq!(grid.means(&picture), [[3.5, 1.0, 0.0], [1.5, 1.0, 0.0], [5.5, 1.0, 0.0]]);
    }
}
