//! Form factors as files.
//!
//! | ending | what |
//! | --- | --- |
//! | `.json` | all: shapes, patches, factors between shapes and between patches, the repair |
//! | `.csv` | a line for each pair of patches: numbers, shapes, F, its standard error |
//! | `.mtx` | F as a coordinate matrix of Matrix Market, rows and columns from 1 |
//! | `.npz` | F for `scipy.sparse.load_npz` (CSR, f64), and `standard_error`, `area`, `escaped`, `absorbed` beside it for `numpy.load` |

use super::ShapeFactors;
use etendue_image::write_atomically;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{self, Cursor, Write as _};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// The endings that [`write()`] knows.
pub const ENDINGS: [&str; 4] = ["json", "csv", "mtx", "npz"];

/// Writes a file of the kind that its ending names.
pub fn write(shapes: &ShapeFactors, path: &Path) -> io::Result<()> {
    let bytes = match path.extension().and_then(|e| e.to_str()) {
        Some("json") => serde_json::to_vec(&json(shapes, true)).map_err(io::Error::other)?,
        Some("csv") => csv(shapes).into_bytes(),
        Some("mtx") => matrix_market(shapes).into_bytes(),
        Some("npz") => npz(shapes)?,
        _ => return Err(io::Error::new(io::ErrorKind::InvalidInput, "the name ends in none of .json, .csv, .mtx, .npz")),
    };
    write_atomically(path, &bytes)
}

/// All of it; `patches` says whether with every pair of patches, or with shapes alone.
pub fn json(shapes: &ShapeFactors, patches: bool) -> Value {
    let (cut, f) = (&shapes.patches, &shapes.factors);
    let area = |k: usize| -> f64 { cut.objects[k].patches.clone().map(|i| cut.get(i).area).sum() };
    let names = shapes.names.iter().enumerate();
    let objects: Vec<Value> =
        names.map(|(k, name)| json!({"name": name, "area": area(k), "patches": cut.objects[k].patches.len()})).collect();
    let mean_lost = |lost: &[f64]| {
        let areas = cut.patches.iter().map(|p| p.area);
        lost.iter().zip(areas.clone()).map(|(l, a)| l * a).sum::<f64>() / areas.sum::<f64>()
    };
    let repair = shapes.repair.map(|r| {
        json!({
            "closed": r.closed, "sweeps": r.sweeps,
            "closure_error_before": r.closure_before, "closure_error_after": r.closure_after,
            "reciprocity_error_before": r.reciprocity_before,
            "moved_by_symmetry": r.moved_by_symmetry, "moved_by_noise": r.moved_by_noise, "moved_by_scaling": r.moved_by_scaling,
        })
    });
    let (chi_square, pairs, largest_z) = shapes.reciprocity;
    let mut all = json!({
        "method": shapes.method,
        "shapes": objects,
        "between_shapes": between(shapes),
        "escaped": mean_lost(&f.escaped), "absorbed_by_backs": mean_lost(&f.absorbed),
        "reciprocity": {"chi_square": chi_square, "pairs": pairs, "largest_z": largest_z},
        "repair": repair,
        "defects": shapes.defects,
        "warnings": shapes.warnings,
    });
    if patches {
        let xyz = |v: etendue_numerics::DVec3| v.to_array();
        let patch = |i: usize| {
            let p = &cut.patches[i];
            json!({
                "shape": p.object, "facets": cut.triangles_of(i as u32), "front": p.side == etendue_radiosity::Side::Front,
                "area": p.area, "centroid": xyz(p.p), "normal": xyz(p.n), "escaped": f.escaped[i], "absorbed_by_backs": f.absorbed[i],
            })
        };
        let entries = |i: usize| f.row(i).map(move |(j, x)| json!([i, j, x, f.error(i, j)]));
        all["patches"] = (0..cut.len()).map(patch).collect();
        all["factors"] = (0..cut.len()).flat_map(entries).collect();
    }
    all
}

/// Entries between shapes.
fn between(shapes: &ShapeFactors) -> Vec<Value> {
    let mut entries = Vec::new();
    for (a, row) in shapes.between.iter().enumerate() {
        for (b, (f, error)) in row.iter().enumerate().filter(|(_, (f, _))| *f > 0.0) {
            entries.push(json!({"from": shapes.names[a], "to": shapes.names[b], "f": f, "standard_error": error}));
        }
    }
    entries
}

/// A line for each pair of patches.
pub fn csv(shapes: &ShapeFactors) -> String {
    let quoted =
        |name: &str| if name.contains([',', '"', '\n']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() };
    let names: Vec<String> = shapes.names.iter().map(|n| quoted(n)).collect();
    let name = |i: usize| &names[shapes.patches.patches[i].object as usize];
    let mut text = "from,to,from_shape,to_shape,form_factor,standard_error\n".to_owned();
    for i in 0..shapes.factors.len() {
        for (j, f) in shapes.factors.row(i) {
            // Writing to a text cannot fail.
            let _ = writeln!(text, "{i},{j},{},{},{f},{}", name(i), name(j), shapes.factors.error(i, j));
        }
    }
    text
}

/// The matrix for Matrix Market [Boisvert, Pozo, Remington 1996].
pub fn matrix_market(shapes: &ShapeFactors) -> String {
    let f = &shapes.factors;
    let mut text = "%%MatrixMarket matrix coordinate real general\n% form factors, row: from, column: to\n".to_owned();
    let _ = writeln!(text, "{} {} {}", f.len(), f.len(), f.matrix.rows.nnz());
    for i in 0..f.len() {
        for (j, x) in f.row(i) {
            let _ = writeln!(text, "{} {} {x:e}", i + 1, j + 1);
        }
    }
    text
}

/// The matrix for `scipy.sparse.load_npz`.
pub fn npz(shapes: &ShapeFactors) -> io::Result<Vec<u8>> {
    let f = &shapes.factors;
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut array = |name: &str, kind: &str, shape: &[usize], bytes: &[u8]| -> io::Result<()> {
        // Files of more than 4 GB say so in advance.
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(bytes.len() > 1 << 31);
        archive.start_file(format!("{name}.npy"), options).map_err(io::Error::other)?;
        archive.write_all(&npy_header(kind, shape))?;
        archive.write_all(bytes)
    };
    let doubles = |x: &mut dyn Iterator<Item = f64>| -> Vec<u8> { x.flat_map(f64::to_le_bytes).collect() };
    let (n, entries) = (f.len(), f.matrix.rows.nnz());
    let begins = f.matrix.rows.indptr();
    let begins: Vec<u8> = begins.raw_storage().iter().flat_map(|b| (*b as i64).to_le_bytes()).collect();
    let columns: Vec<u8> = f.matrix.rows.indices().iter().flat_map(|j| i64::from(*j).to_le_bytes()).collect();
    array("format", "|S3", &[], b"csr")?;
    array("shape", "<i8", &[2], &[(n as i64).to_le_bytes(), (n as i64).to_le_bytes()].concat())?;
    array("indptr", "<i8", &[n + 1], &begins)?;
    array("indices", "<i8", &[entries], &columns)?;
    array("data", "<f8", &[entries], &doubles(&mut (0..n).flat_map(|i| f.row(i).map(|(_, x)| x))))?;
    array("standard_error", "<f8", &[entries], &doubles(&mut (0..n).flat_map(|i| f.row(i).map(move |(j, _)| f.error(i, j)))))?;
    array("area", "<f8", &[n], &doubles(&mut shapes.patches.patches.iter().map(|p| p.area)))?;
    array("escaped", "<f8", &[n], &doubles(&mut f.escaped.iter().copied()))?;
    array("absorbed", "<f8", &[n], &doubles(&mut f.absorbed.iter().copied()))?;
    Ok(archive.finish().map_err(io::Error::other)?.into_inner())
}

/// The head of an array in NumPy's format, version 1.0: padded so that the data begin at a multiple of 64.
fn npy_header(kind: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut words = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", sizes.trim_end());
    while (words.len() + 11) % 64 != 0 {
        words.push(' ');
    }
    words.push('\n');
    [b"\x93NUMPY\x01\x00".as_slice(), &(words.len() as u16).to_le_bytes(), words.as_bytes()].concat()
}
