//! Loading at full size: 100 MB of scene text, of ASCII and of binary PLY, a mesh of a million triangles, and 100,000 curves.
//!
//! `cargo bench -p etendue --bench loading [-- FOLDER [ROUNDS]]` makes the files (some 400 MB) in FOLDER, a temporary one by default, and loads each in a process of its own, so that
//! its peak of memory is its own. It tells, of the median of ROUNDS (3) by the wall's clock: MB and MB/s read, seconds of the tree and for a million triangles, the processor's
//! seconds for all of it (Linux), and the peak.
#![allow(clippy::print_stdout, missing_docs)]

use etendue::{LoadOptions, load, memory};
use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const MB: u64 = 1_000_000;

/// A bumpy sheet of `side` × `side` quads: its vertices with texture coordinates, and its triangles.
struct Sheet {
    side: usize,
}

impl Sheet {
    fn vertices(&self) -> impl Iterator<Item = ([f32; 3], [f32; 2])> + '_ {
        let at = |i: usize| i as f32 / self.side as f32;
        (0..=self.side).flat_map(move |j| {
            (0..=self.side).map(move |i| {
                let (u, v) = (at(i), at(j));
                ([u * 10.0 - 5.0, 0.3 * (u * 40.0).sin() * (v * 40.0).cos(), v * 10.0 - 5.0], [u, v])
            })
        })
    }

    fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        (0..self.side * self.side).flat_map(move |k| {
            let a = k / self.side * (self.side + 1) + k % self.side;
            let (b, c, d) = (a + 1, a + self.side + 1, a + self.side + 2);
            [[a, c, b], [b, c, d]]
        })
    }
}

type Out = BufWriter<std::fs::File>;

fn file(path: &Path, write: impl FnOnce(&mut Out) -> std::io::Result<()>) {
    if path.exists() {
        return;
    }
    let mut out = BufWriter::new(std::fs::File::create(path).expect("a file"));
    write(&mut out).and_then(|()| out.flush()).expect("room on the disk");
}

fn ply(out: &mut Out, ascii: bool, sheet: &Sheet) -> std::io::Result<()> {
    let format = if ascii { "ascii" } else { "binary_little_endian" };
    let (points, faces) = ((sheet.side + 1) * (sheet.side + 1), 2 * sheet.side * sheet.side);
    write!(
        out,
        "ply\nformat {format} 1.0\nelement vertex {points}\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
         property float v\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for (p, uv) in sheet.vertices() {
        if ascii {
            writeln!(out, "{} {} {} {} {}", p[0], p[1], p[2], uv[0], uv[1])?;
        } else {
            p.iter().chain(&uv).try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        }
    }
    for [a, b, c] in sheet.triangles() {
        if ascii {
            writeln!(out, "3 {a} {b} {c}")?;
        } else {
            out.write_all(&[3])?;
            [a, b, c].iter().try_for_each(|i| out.write_all(&(*i as u32).to_le_bytes()))?;
        }
    }
    Ok(())
}

/// Meshes as lists of numbers, as exporters write them, until there are so many bytes.
fn text(out: &mut Out, bytes: u64) -> std::io::Result<()> {
    let sheet = Sheet { side: 200 };
    let (mut written, mut k) = (0, 0);
    out.write_all(b"WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [ 0.4 0.5 0.6 ]\n")?;
    while written < bytes {
        let mut shape = format!("AttributeBegin\n    Translate {k} 0 0\n    Shape \"trianglemesh\"\n        \"point2 uv\" [ ");
        for (_, uv) in sheet.vertices() {
            let _ = write!(shape, "{:.6} {:.6} ", uv[0], uv[1]);
        }
        shape += "]\n        \"normal N\" [ ";
        for (p, _) in sheet.vertices() {
            let _ = write!(shape, "{:.6} {:.6} {:.6} ", 0.1 * p[1], 0.9, 0.1 * p[0]);
        }
        shape += "]\n        \"point3 P\" [ ";
        for (p, _) in sheet.vertices() {
            let _ = write!(shape, "{:.6} {:.6} {:.6} ", p[0], p[1], p[2]);
        }
        shape += "]\n        \"integer indices\" [ ";
        for [a, b, c] in sheet.triangles() {
            let _ = write!(shape, "{a} {b} {c} ");
        }
        shape += "]\nAttributeEnd\n";
        out.write_all(shape.as_bytes())?;
        written += shape.len() as u64;
        k += 11;
    }
    Ok(())
}

fn curves(out: &mut Out, count: usize) -> std::io::Result<()> {
    out.write_all(b"WorldBegin\nMaterial \"hair\" \"float eumelanin\" 1.3\n")?;
    for i in 0..count {
        let (x, z) = ((i % 317) as f32 * 0.01, (i / 317) as f32 * 0.01);
        let lean = 0.02 * ((i * 7) % 11) as f32;
        writeln!(
            out,
            "Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [ {x:.4} 0 {z:.4}  {x:.4} 0.1 {z:.4}  {:.4} 0.2 {z:.4}  {:.4} 0.3 {:.4} ] \"float width0\" 0.002 \"float width1\" 0.0005",
            x + 0.5 * lean,
            x + lean,
            z + 0.05
        )?;
    }
    Ok(())
}

/// A scene around a mesh.
fn around(folder: &Path, mesh: &str) -> PathBuf {
    let path = folder.join(mesh).with_extension("pbrt");
    file(&path, |out| writeln!(out, "WorldBegin Shape \"plymesh\" \"string filename\" \"{mesh}\""));
    path
}

/// Seconds of the processor that this process has taken.
fn processor() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    // utime and stime, in hundredths of a second.
    Some(fields.get(11..13)?.iter().filter_map(|x| x.parse::<f64>().ok()).sum::<f64>() / 100.0)
}

/// Loads one file, and tells in numbers: seconds read, seconds built, triangles, processor's seconds, bytes at the peak.
fn child(path: &str) {
    let loaded = load(path, &LoadOptions::default()).unwrap_or_else(|why| panic!("{why}"));
    let triangles = loaded.scene.triangles;
    println!(
        "{} {} {triangles} {} {}",
        loaded.read_time.as_secs_f64(),
        loaded.build_time.as_secs_f64(),
        processor().unwrap_or(f64::NAN),
        memory::peak()
    );
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if let [word, path] = &args[..]
        && word == "--load"
    {
        return child(path);
    }
    let (folder, _temporary) = match args.first() {
        Some(folder) => (PathBuf::from(folder), None),
        None => {
            let folder = tempfile::tempdir().expect("a folder");
            (folder.path().to_owned(), Some(folder))
        }
    };
    std::fs::create_dir_all(&folder).expect("a folder");
    let rounds: usize = args.get(1).and_then(|n| n.parse().ok()).unwrap_or(3);

    let begun = Instant::now();
    file(&folder.join("text.pbrt"), |out| text(out, 100 * MB));
    file(&folder.join("binary.ply"), |out| ply(out, false, &Sheet { side: 1414 }));
    file(&folder.join("ascii.ply"), |out| ply(out, true, &Sheet { side: 1050 }));
    file(&folder.join("million.ply"), |out| ply(out, false, &Sheet { side: 707 }));
    file(&folder.join("curves.pbrt"), |out| curves(out, 100_000));
    println!("files made in {:.1} s", begun.elapsed().as_secs_f64());

    println!("| file | MB | M triangles | read s | MB/s | tree s | tree s per M | processor s | peak MB |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (name, scene) in [
        ("text.pbrt", folder.join("text.pbrt")),
        ("binary.ply", around(&folder, "binary.ply")),
        ("ascii.ply", around(&folder, "ascii.ply")),
        ("million.ply", around(&folder, "million.ply")),
        ("curves.pbrt", folder.join("curves.pbrt")),
    ] {
        let bytes = std::fs::metadata(folder.join(name)).map_or(0, |m| m.len()) as f64 / MB as f64;
        let mut runs: Vec<Vec<f64>> = (0..rounds.max(1))
            .map(|_| {
                let mut command = Command::new(std::env::current_exe().expect("this program"));
                let out = command.args(["--load", &scene.to_string_lossy()]).output().expect("a process");
                let told = String::from_utf8_lossy(&out.stdout).into_owned();
                let numbers: Vec<f64> = told.split_whitespace().filter_map(|x| x.parse().ok()).collect();
                assert!(numbers.len() == 5, "{name}: {}", String::from_utf8_lossy(&out.stderr));
                numbers
            })
            .collect();
        runs.sort_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
        let [read, build, triangles, processor, peak] = runs[runs.len() / 2][..] else { continue };
        let millions = triangles / 1e6;
        println!(
            "| {name} | {bytes:.0} | {millions:.2} | {read:.2} | {:.0} | {build:.2} | {:.2} | {processor:.2} | {:.0} |",
            bytes / read,
            build / millions,
            peak / MB as f64
        );
    }
}
