//! A solution as tables and meshes for other programs.
//!
//! | ending | holds |
//! | --- | --- |
//! | `.csv` | a row a patch: shape, side, centroid, area, normal, ρ, Be, B and H in W/m², illuminance in lux |
//! | `.ply` | corners of patches with normal, B and H in W/m², illuminance, and a colour for display |
//! | `.vtu` | the same for ParaView: means as data of cells, values at corners as data of points |
//! | `.glb` | the same as glTF: radiance as colours of corners, or as a lightmap |
//!
//! Patches are flat here: those of round shapes are given by their corners. Illuminance is K (0.2126 R + 0.7152 G + 0.0722 B) of H.

use super::glb;
use crate::load::Loaded;
use crate::surfaces;
use etendue_radiosity::patch::Side;
use etendue_radiosity::solve::rgb;
use etendue_radiosity::{Field, Solved};
use glam::DVec3;
use std::fmt::Write;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

/// K, lm/W, unless the user says otherwise.
pub const LUMINOUS_EFFICACY: f64 = 683.002;

/// The endings that [`write()`] knows.
pub const ENDINGS: [&str; 4] = ["csv", "ply", "vtu", "glb"];

/// Photometric weight of linear Rec.709.
pub fn luminance(x: DVec3) -> f64 {
    x.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The corners of patches with what they carry; no corner is shared, so nothing bleeds over an edge.
pub(super) struct Corners {
    pub points: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    /// B there, W/m².
    pub b: Vec<DVec3>,
    /// H there, W/m².
    pub h: Vec<DVec3>,
    /// For each patch its first corner, and how many it has.
    pub patches: Vec<(u32, u32)>,
}

/// H of all patches, W/m².
pub fn irradiance(solved: &Solved) -> Vec<DVec3> {
    solved.equation().irradiance(&solved.solution.b)
}

impl Corners {
    pub(super) fn new(loaded: &Loaded, solved: &Solved, h: &[DVec3]) -> Self {
        let patches = &solved.patches;
        let vertices = patches.vertices(&loaded.scene);
        let field = Field::new(patches, &vertices, h);
        let mut corners = Self { points: Vec::new(), normals: Vec::new(), b: Vec::new(), h: Vec::new(), patches: Vec::new() };
        for (i, patch) in patches.patches.iter().enumerate() {
            let mut around: Vec<u32> = vertices.corners[i].iter().copied().filter(|v| *v != u32::MAX).collect();
            // Counter-clockwise as seen from the patch's side.
            let at = |k: usize| vertices.points[around[k] as usize];
            if (at(1) - at(0)).cross(at(2) - at(0)).dot(patch.n) < 0.0 {
                around.reverse();
            }
            corners.patches.push((corners.points.len() as u32, around.len() as u32));
            for v in around {
                let h = field.at_vertices()[v as usize];
                corners.points.push(vertices.points[v as usize]);
                corners.normals.push(vertices.normals[v as usize]);
                corners.h.push(h);
                corners.b.push(rgb(patch.be) + rgb(patch.rho) * h);
            }
        }
        corners
    }
}

/// The bytes of a file with one of [`ENDINGS`]; `efficacy` is K.
pub fn write(loaded: &Loaded, solved: &Solved, ending: &str, efficacy: f64, lightmap: bool) -> Result<Vec<u8>, String> {
    let h = irradiance(solved);
    match ending {
        "csv" => Ok(csv(loaded, solved, &h, efficacy).into_bytes()),
        "ply" => Ok(ply(&Corners::new(loaded, solved, &h), efficacy)),
        "vtu" => vtu(solved, &Corners::new(loaded, solved, &h), &h, efficacy),
        "glb" => glb::write(&Corners::new(loaded, solved, &h), lightmap),
        _ => Err(format!("a solution is written to .{}, not to .{ending}", ENDINGS.join(", ."))),
    }
}

/// The lightmap of a `.glb` in floating point: radiance, W/(m² sr), linear Rec.709.
pub fn lightmap(loaded: &Loaded, solved: &Solved) -> Result<etendue_image::Image, String> {
    glb::lightmap(&Corners::new(loaded, solved, &irradiance(solved)))
}

fn csv(loaded: &Loaded, solved: &Solved, h: &[DVec3], efficacy: f64) -> String {
    let three = |name: &str| format!("{name}_r,{name}_g,{name}_b");
    let mut text = format!(
        "patch,shape,side,x_m,y_m,z_m,area_m2,nx,ny,nz,{},{},{},{},illuminance_lx_at_{efficacy}_lm_per_W\n",
        three("reflectance"),
        three("emission_W_per_m2"),
        three("radiosity_W_per_m2"),
        three("irradiance_W_per_m2")
    );
    for (i, p) in solved.patches.patches.iter().enumerate() {
        let object = &solved.patches.objects[p.object as usize];
        let shape = surfaces::name(loaded, object.surface);
        let shape = if shape.contains([',', '"', '\n']) { format!("\"{}\"", shape.replace('"', "\"\"")) } else { shape };
        let side = if p.side == Side::Front { "front" } else { "back" };
        let _ = write!(text, "{i},{shape},{side}");
        let numbers = [p.p.to_array().as_slice(), &[p.area], &p.n.to_array()].concat();
        let light = [rgb(p.rho), rgb(p.be), solved.solution.b[i], h[i]].map(|x| x.to_array()).concat();
        for x in numbers.iter().chain(&light).chain([&(efficacy * luminance(h[i]))]) {
            let _ = write!(text, ",{x}");
        }
        text.push('\n');
    }
    text
}

/// A colour for display of radiance L: sRGB, of which white is `white`.
pub(super) fn display(b: DVec3, white: f64) -> [u8; 3] {
    let l = b / white.max(f64::MIN_POSITIVE);
    l.to_array().map(|x| (etendue_image::linear_to_srgb(x.clamp(0.0, 1.0) as f32) * 255.0).round() as u8)
}

/// The radiosity that is shown as white: no more than one corner in 200 is brighter.
pub(super) fn white(b: &[DVec3]) -> f64 {
    let mut all: Vec<f64> = b.iter().map(|b| b.max_element()).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len().saturating_sub(1 + all.len() / 200)).copied().filter(|w| *w > 0.0).unwrap_or(1.0)
}

fn ply(corners: &Corners, efficacy: f64) -> Vec<u8> {
    let white = white(&corners.b);
    let mut head = format!("ply\nformat binary_little_endian 1.0\ncomment B and H in W/m2, illuminance in lx at {efficacy} lm/W\n");
    let _ = writeln!(head, "element vertex {}", corners.points.len());
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        let _ = writeln!(head, "property float {name}");
    }
    for name in ["red", "green", "blue"] {
        let _ = writeln!(head, "property uchar {name}");
    }
    for name in ["radiosity", "irradiance"].iter().flat_map(|n| ["r", "g", "b"].map(|c| format!("{n}_{c}"))) {
        let _ = writeln!(head, "property float {name}");
    }
    let _ = write!(
        head,
        "property float illuminance\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        corners.patches.len()
    );
    let mut bytes = head.into_bytes();
    let floats = |bytes: &mut Vec<u8>, x: &[f64]| x.iter().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
    for k in 0..corners.points.len() {
        floats(&mut bytes, &corners.points[k].to_array());
        floats(&mut bytes, &corners.normals[k].to_array());
        bytes.extend(display(corners.b[k], white));
        floats(&mut bytes, &corners.b[k].to_array());
        floats(&mut bytes, &corners.h[k].to_array());
        floats(&mut bytes, &[efficacy * luminance(corners.h[k])]);
    }
    for (first, count) in &corners.patches {
        bytes.push(*count as u8);
        (*first..first + count).for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

fn vtu(solved: &Solved, corners: &Corners, h: &[DVec3], efficacy: f64) -> Result<Vec<u8>, String> {
    let vectors = |name: &str, x: &mut dyn Iterator<Item = DVec3>| {
        Attribute::scalars(name, 3).with_data(x.flat_map(|x| x.as_vec3().to_array()).collect::<Vec<f32>>())
    };
    let scalars = |name: &str, x: Vec<f32>| Attribute::scalars(name, 1).with_data(x);
    let lux = |h: &[DVec3]| h.iter().map(|h| (efficacy * luminance(*h)) as f32).collect::<Vec<f32>>();
    let patches = &solved.patches.patches;
    let data = Attributes {
        point: vec![
            vectors("radiosity W/m2", &mut corners.b.iter().copied()),
            vectors("irradiance W/m2", &mut corners.h.iter().copied()),
            scalars("illuminance lx", lux(&corners.h)),
        ],
        cell: vec![
            vectors("reflectance", &mut patches.iter().map(|p| rgb(p.rho))),
            vectors("emission W/m2", &mut patches.iter().map(|p| rgb(p.be))),
            vectors("radiosity W/m2", &mut solved.solution.b.iter().copied()),
            vectors("irradiance W/m2", &mut h.iter().copied()),
            scalars("illuminance lx", lux(h)),
            scalars("area m2", patches.iter().map(|p| p.area as f32).collect()),
        ],
    };
    let connectivity = (0..corners.points.len() as u64).collect();
    let offsets = corners.patches.iter().map(|(first, count)| u64::from(first + count)).collect();
    let types = corners.patches.iter().map(|(_, n)| if *n == 3 { CellType::Triangle } else { CellType::Quad }).collect();
    let points: Vec<f32> = corners.points.iter().flat_map(|p| p.as_vec3().to_array()).collect();
    let cells = Cells { cell_verts: VertexNumbers::XML { connectivity, offsets }, types };
    let grid = Vtk {
        version: Version::new_xml(1, 0),
        title: format!("radiosity, K = {efficacy} lm/W"),
        byte_order: ByteOrder::LittleEndian,
        data: DataSet::inline(UnstructuredGridPiece { points: points.into(), cells, data }),
        file_path: None,
    };
    let mut bytes = Vec::new();
    grid.write_xml(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}
