//! Data too large for parameters: triangle meshes, voxel grids and measured materials, checked when they were read.

use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The meshes and grids of a description. A file named twice is read once.
#[derive(Clone, Debug, Default)]
pub struct Assets {
    /// Triangle meshes.
    pub meshes: Vec<Arc<MeshData>>,
    /// Voxel grids.
    pub grids: Vec<Arc<GridData>>,
    /// Measured materials.
    pub measured: Vec<Arc<MeasuredData>>,
    /// Files that came with the scene's text and lie on no disk: a [`crate::Value::Path`] is looked up here first.
    pub files: BTreeMap<PathBuf, Arc<[u8]>>,
}

/// A triangle mesh in its own coordinates. Every index is in range and every position finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// The file it came from.
    pub path: PathBuf,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals; empty where the file has none. A vertex to which the file gave no usable one has that of the faces around it.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; empty where the file has none.
    pub uvs: Vec<Vec2>,
    /// Triangles; those without area are left out.
    pub indices: Vec<[u32; 3]>,
    /// Named per-vertex or per-face data.
    pub attributes: Vec<Attribute>,
    /// Runs of triangles that the file names, in order; of one name there may be several. Triangles before the first have none.
    pub groups: Vec<Group>,
}

impl MeshData {
    /// The square [-1, 1]² at z = 0 with normal +z and texture coordinates from 0 to 1.
    pub fn rectangle() -> Self {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        Self {
            positions: corners.map(|uv| (2.0 * uv - 1.0).extend(0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            uvs: corners.to_vec(),
            indices: vec![[0, 1, 2], [2, 3, 0]],
            ..Self::default()
        }
    }

    /// The cube [-1, 1]³ with normals outwards; each face has texture coordinates from 0 to 1.
    pub fn cube() -> Self {
        // A face by its normal and the directions in which u and v grow.
        const FACES: [[Vec3; 3]; 6] = [
            [Vec3::NEG_Y, Vec3::Z, Vec3::X],
            [Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z],
            [Vec3::X, Vec3::Y, Vec3::NEG_Z],
            [Vec3::Z, Vec3::Y, Vec3::X],
            [Vec3::NEG_X, Vec3::Y, Vec3::Z],
            [Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X],
        ];
        let mut cube = Self::default();
        for (face, [n, u, v]) in FACES.into_iter().enumerate() {
            for uv in [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO] {
                cube.positions.push(n + u * (2.0 * uv.x - 1.0) + v * (2.0 * uv.y - 1.0));
                cube.normals.push(n);
                cube.uvs.push(uv);
            }
            let first = 4 * face as u32;
            cube.indices.extend([[0, 1, 2], [3, 0, 2]].map(|t: [u32; 3]| t.map(|i| first + i)));
        }
        cube
    }
}

/// A named run of triangles, up to where the next begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The name.
    pub name: String,
    /// The first triangle.
    pub first: u32,
}

/// Named data on a mesh's vertices or faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// The name, with its `vertex_` or `face_` prefix.
    pub name: String,
    /// What it lies on.
    pub kind: AttributeKind,
    /// Numbers per vertex or face: 1 or 3.
    pub channels: usize,
    /// The numbers, `channels` for each vertex or face.
    pub data: Vec<f32>,
}

/// What an attribute lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeKind {
    /// Interpolated over each face.
    Vertex,
    /// Constant on each face.
    Face,
}

/// A regular grid of numbers, x fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridData {
    /// The file it came from.
    pub path: PathBuf,
    /// Voxels along x, y, z.
    pub size: [usize; 3],
    /// Numbers per voxel.
    pub channels: usize,
    /// The grid's box in its own coordinates.
    pub bounds: etendue_numerics::Bounds3,
    /// The numbers.
    pub data: Vec<f32>,
}

/// Numbers on a grid, row by row; where there are several grids one behind the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableData {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The numbers.
    pub values: Vec<f32>,
}

/// A measured material, in the coordinates of its microfacets [Dupuy, Jakob 2018]. All sizes agree, and all numbers are finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredData {
    /// The file it came from.
    pub path: PathBuf,
    /// Azimuths of the given direction, rising.
    pub phi: Vec<f32>,
    /// Elevations of it, rising.
    pub theta: Vec<f32>,
    /// Wavelengths of `spectra`, nm, rising; none where it holds red, green and blue.
    pub wavelengths: Vec<f32>,
    /// Density of normals.
    pub ndf: TableData,
    /// The area that they show.
    pub sigma: TableData,
    /// Density of the normals that are seen, by azimuth and elevation.
    pub vndf: TableData,
    /// What they reflect, likewise.
    pub luminance: TableData,
    /// The same by channel.
    pub spectra: TableData,
    /// Whether `ndf` and `sigma` are still to be multiplied with.
    pub jacobian: bool,
}
