//! How fast files are read: 1 M triangles as OBJ and as PLY (text and binary), and a scene of 20,000 objects.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use etendue_formats::{ReadOptions, mesh, read_str};
use std::fmt::Write as _;
use std::hint::black_box;

/// Quads along one side of the bumpy sheet; two triangles each.
const SIDE: usize = 708;

/// The sheet's vertices: position and texture coordinate.
fn vertices() -> impl Iterator<Item = ([f32; 3], [f32; 2])> {
    (0..=SIDE).flat_map(|j| {
        (0..=SIDE).map(move |i| {
            let (u, v) = (i as f32 / SIDE as f32, j as f32 / SIDE as f32);
            ([u * 10.0 - 5.0, 0.3 * (u * 40.0).sin() * (v * 40.0).cos(), v * 10.0 - 5.0], [u, v])
        })
    })
}

/// The sheet's triangles, counted from 0.
fn triangles() -> impl Iterator<Item = [usize; 3]> {
    (0..SIDE).flat_map(|j| {
        (0..SIDE).flat_map(move |i| {
            let a = j * (SIDE + 1) + i;
            let (b, c, d) = (a + 1, a + SIDE + 1, a + SIDE + 2);
            [[a, c, b], [b, c, d]]
        })
    })
}

fn obj() -> Vec<u8> {
    let mut text = String::new();
    for ([x, y, z], [u, v]) in vertices() {
        let _ = writeln!(text, "v {x:.6} {y:.6} {z:.6}\nvt {u:.6} {v:.6}\nvn {:.6} {:.6} {:.6}", y * 0.1, 0.9, x * 0.1);
    }
    for t in triangles() {
        let [a, b, c] = t.map(|i| i + 1);
        let _ = writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}");
    }
    text.into_bytes()
}

fn ply(ascii: bool) -> Vec<u8> {
    let (points, faces) = ((SIDE + 1) * (SIDE + 1), SIDE * SIDE * 2);
    let format = if ascii { "ascii" } else { "binary_little_endian" };
    let mut out = format!(
        "ply\nformat {format} 1.0\nelement vertex {points}\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
         property float v\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for (p, uv) in vertices() {
        if ascii {
            out.extend(format!("{} {} {} {} {}\n", p[0], p[1], p[2], uv[0], uv[1]).bytes());
        } else {
            out.extend(p.iter().chain(&uv).flat_map(|x| x.to_le_bytes()));
        }
    }
    for [a, b, c] in triangles() {
        if ascii {
            out.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            out.push(3);
            out.extend([a, b, c].iter().flat_map(|&i| (i as u32).to_le_bytes()));
        }
    }
    out
}

fn xml() -> String {
    let mut text = String::from("<scene version=\"3.0.0\">\n<default name=\"r\" value=\"0.5\"/>\n");
    for i in 0..10_000 {
        let _ = writeln!(
            text,
            "    <shape type=\"sphere\" id=\"s{i}\">\n        <float name=\"radius\" value=\"$r\"/>\n        <transform name=\"to_world\">\n            \
             <translate x=\"{i}\" y=\"0.25\"/>\n            <rotate y=\"1\" angle=\"30\"/>\n        </transform>\n        \
             <bsdf type=\"diffuse\">\n            <rgb name=\"reflectance\" value=\"0.1, 0.2, 0.3\"/>\n        </bsdf>\n    </shape>"
        );
    }
    text + "</scene>\n"
}

fn meshes(c: &mut Criterion) {
    let mut group = c.benchmark_group("mesh 1 M triangles");
    group.sample_size(10);
    for (name, bytes) in [("obj", obj()), ("ply ascii", ply(true)), ("ply binary", ply(false))] {
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(name, |b| {
            b.iter(|| match name {
                "obj" => mesh::obj::read(black_box(&bytes), true).map(|l| l.mesh.indices.len()),
                _ => mesh::ply::read(black_box(&bytes), false).map(|l| l.mesh.indices.len()),
            })
        });
    }
    group.finish();
}

fn scenes(c: &mut Criterion) {
    let text = xml();
    let mut group = c.benchmark_group("scene");
    group.sample_size(10).throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("xml 20,000 objects", |b| {
        b.iter(|| read_str("bench.xml", black_box(&text), &ReadOptions::default()).0.nodes.len())
    });
    group.finish();
}

criterion_group!(benches, meshes, scenes);
criterion_main!(benches);
