//! Meshes and grids, well-formed and not.

use etendue_description::{AttributeKind, MeshData};
use etendue_formats::mesh::{FileError, Place, obj, ply, serialized, vol};
use glam::{Vec2, Vec3};
use std::io::Write as _;

fn place(error: &FileError) -> String {
    match &error.place {
        Place::File => error.message.clone(),
        Place::Byte(at) => format!("byte {at}: {}", error.message),
        Place::Line { number, text, word } => format!("{number}:{} `{}`: {}", word.start + 1, &text[word.clone()], error.message),
    }
}

fn places(errors: Vec<FileError>) -> Vec<String> {
    errors.iter().map(place).collect()
}

fn obj_ok(text: &str) -> MeshData {
    let loaded = obj::read(text.as_bytes(), false).unwrap();
    assert_eq!(loaded.warnings, Vec::<String>::new());
    loaded.mesh
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_corners_share_vertices() {
    let mesh = obj_ok(&format!("{SQUARE}vt 0 0.25\nvt 1 0\nvn 0 0 2\nf 1/1/1 2/2/1 3/1/1 4/1/1\nf 1/1/1 3/2/1 4/1/1\n"));
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 4, 3]]);
    assert_eq!(mesh.positions[4], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!((mesh.uvs[0], mesh.uvs[4]), (Vec2::new(0.0, 0.25), Vec2::new(1.0, 0.0)));
    assert_eq!(mesh.normals, [Vec3::Z; 5]);
    let flipped = obj::read(format!("{SQUARE}vt 0 0.25\nf 1/1 2/1 3/1\n").as_bytes(), true).unwrap();
    assert_eq!(flipped.mesh.uvs[0].y, 0.75);
    assert!(flipped.mesh.normals.is_empty());
}

#[test]
fn obj_as_people_write_it() {
    let plain = obj_ok(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    let variants = [
        format!("{SQUARE}f -4 -3 -2 -1"),
        format!("f 1 2 3 4\n{SQUARE}"),
        format!("# x\r\n{}f 1 2 \\\r\n 3 \\\r\n 4\r\n", SQUARE.replace('\n', "\r\n")),
        format!("mtllib a.mtl\no q\ng a b\n{SQUARE}usemtl m\ns off\nl 1 2\np 1\nvp 0.1\n  f\t1 2   3 4  \n"),
        SQUARE.replace("\n", " 1.0 0.5 0.25\n") + "f 1// 2// 3// 4//",
        format!("{SQUARE}vt 0.5\nvn 0 0 0\nvn 1 nan 0\nf 1 2 3 4\n"),
        "v 0 0 0\nv +1 0e0 -0.0\nv 1. 1.0e+0 0\nv 0 .1E1 0\nf +1 2 3 4".to_owned(),
    ];
    for text in variants {
        let mesh = MeshData { groups: Vec::new(), ..obj_ok(&text) };
        assert_eq!(mesh, plain, "{text}");
    }
}

#[test]
fn obj_groups_name_runs_of_triangles() {
    let text = format!(
        "{SQUARE}f 1 2 3\no room\ng floor\nf 1 2 3 4\nf 1 1 3\ng empty\ng  the  ceiling \nf 4 3 2 1\ng the  ceiling\nf 1 2 3\n"
    );
    let loaded = obj::read(text.as_bytes(), false).unwrap();
    let groups: Vec<_> = loaded.mesh.groups.iter().map(|g| (g.name.as_str(), g.first)).collect();
    assert_eq!(groups, [("floor", 1), ("the  ceiling", 3)]);
    assert!(loaded.warnings[0].starts_with("1 of 7 triangles have no area and are left out: 3 "), "{:?}", loaded.warnings);
}

#[test]
fn obj_mistakes() {
    let said = |more: &str| places(obj::read(format!("{SQUARE}{more}").as_bytes(), false).unwrap_err());
    assert_eq!(
        said("f 1 2 9\nf 0 1 2\nf 1 2 -5\n"),
        [
            "5:7 `9`: vertex 9 does not exist, there are 4",
            "6:3 `0`: vertex 0 does not exist, indices begin with 1",
            "7:7 `-5`: vertex -5 does not exist, there are 4",
        ]
    );
    assert_eq!(said("f 1/1 2/1 3/1\n"), ["5:5 `1`: texture coordinate 1 does not exist, there are 0"]);
    assert_eq!(said("vt 0 0\nf 1/1 2/1 3/2\n"), ["6:13 `2`: texture coordinate 2 does not exist, there are 1"]);
    assert_eq!(said("f 1//1 2//1 3//7\n")[0], "5:6 `1`: normal 1 does not exist, there are 0");
    assert_eq!(
        said("f 1 2 99999999999999999999\n"),
        ["5:7 `99999999999999999999`: vertex 9223372036854775807 does not exist, there are 4"]
    );
    assert_eq!(said("f 1 2 3.5\n"), ["5:7 `3.5`: `3.5` is no corner of a face, expected v, v/vt, v//vn or v/vt/vn"]);
    assert_eq!(
        said("v 1 2\nv 1 2 3x\nv 1 inf 3\nv 1e39 0 0\nvn 1 2\n"),
        [
            "5:1 `v 1 2`: a number is missing: a vertex has 3",
            "6:7 `3x`: `3x` is no number",
            "7:5 `inf`: `inf` is no finite number",
            "8:3 `1e39`: `1e39` is no finite number",
            "9:1 `vn 1 2`: a number is missing: a normal has 3",
        ]
    );
    assert_eq!(places(obj::read(b"<html>", false).unwrap_err()), ["no line gives a vertex (`v x y z`); is this an OBJ file?"]);
    assert_eq!(said(&"f 1 2 9\n".repeat(100)).len(), 20);
    // The place stays right in a line that goes on in the next.
    assert_eq!(said("f 1 \\\n 2 7\n"), ["6:4 `7`: vertex 7 does not exist, there are 4"]);
}

fn ply_text(vertex: &str, rows: [&str; 4], face: &str, faces: &str) -> String {
    let count = faces.lines().count();
    let head =
        "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n";
    let rows: String = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].iter().zip(rows).map(|(p, row)| format!("{p} {row}\n")).collect();
    format!("{head}{vertex}element face {count}\nproperty list uchar int vertex_indices\n{face}end_header\n{rows}{faces}")
}

#[test]
fn ply_ascii() {
    let text = ply_text(
        "property float s\nproperty float t\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n",
        ["0 0.25 0 0 2 10 20 30"; 4],
        "property float weight_0\n",
        "4 0 1 2 3 0.5\n3 0 1 2 0.75\n",
    );
    let mesh = ply::read(text.as_bytes(), true).unwrap().mesh;
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!((mesh.uvs[3], mesh.normals[3]), (Vec2::new(0.0, 0.75), Vec3::Z));
    let names: Vec<_> = mesh.attributes.iter().map(|a| (a.name.as_str(), a.kind, a.channels)).collect();
    assert_eq!(names, [("vertex_color", AttributeKind::Vertex, 3), ("face_weight", AttributeKind::Face, 1)]);
    assert_eq!(mesh.attributes[0].data[..6], [10.0, 20.0, 30.0, 10.0, 20.0, 30.0]);
    // Each triangle has what its polygon had.
    assert_eq!(mesh.attributes[1].data, [0.5, 0.5, 0.75]);
}

/// The same mesh in binary.
fn ply_binary(big: bool, count: u32) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement edge 1\nproperty list int short ends\nelement vertex {count}\nproperty double x\nproperty float y\n\
         property short z\nproperty uchar flag\nelement face 2\nproperty uchar skip\nproperty list ushort uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |le: &[u8]| if big { out.extend(le.iter().rev()) } else { out.extend(le) };
    put(&2i32.to_le_bytes());
    put(&7i16.to_le_bytes());
    put(&8i16.to_le_bytes());
    for (x, y, z) in [(0.0f64, 0.0f32, 0i16), (1.0, 0.0, 0), (1.0, 1.0, 0), (0.0, 1.0, -3)] {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&z.to_le_bytes());
        put(&[9]);
    }
    for face in [&[0u32, 1, 2, 3][..], &[2, 1, 0]] {
        put(&[1]);
        put(&(face.len() as u16).to_le_bytes());
        face.iter().for_each(|i| put(&i.to_le_bytes()));
    }
    out
}

#[test]
fn ply_binary_of_either_order() {
    for big in [false, true] {
        let loaded = ply::read(&ply_binary(big, 4), false).unwrap();
        assert_eq!(loaded.warnings, Vec::<String>::new());
        assert_eq!(loaded.mesh.indices, [[0, 1, 2], [0, 2, 3], [2, 1, 0]]);
        assert_eq!(loaded.mesh.positions[3], Vec3::new(0.0, 1.0, -3.0));
    }
}

#[test]
fn ply_mistakes() {
    let said = |text: &str| places(ply::read(text.as_bytes(), false).unwrap_err()).remove(0);
    let rows = ["1", "2", "3", "4"];
    let good = ply_text("property float q\n", rows, "", "3 0 1 2\n");
    assert!(ply::read(good.as_bytes(), false).is_ok());
    assert_eq!(said("solid x"), "the file does not begin with `ply`");
    assert_eq!(said("ply\nformat ascii 1.0\n"), "the header never ends: `end_header` is missing");
    assert_eq!(
        said(&good.replace("ascii", "asci")),
        "2:8 `asci`: `asci` is no PLY format, expected ascii, binary_little_endian or binary_big_endian"
    );
    assert_eq!(said(&good.replace("double z", "real z")), "7:10 `real`: `real` is no PLY type, expected float, int, uchar, ...");
    assert_eq!(
        said(&good.replace("property float x", "property float y")),
        "6:1 `property float y`: element `vertex` has property `y` twice"
    );
    assert_eq!(said(&good.replace("vertex 4", "vertex -4")), "4:16 `-4`: `-4` is no count");
    assert_eq!(
        said(&good.replace("element face", "element faces")),
        "the header names no element `face`; point clouds and triangle strips are not read"
    );
    assert_eq!(
        said(&good.replace("3 0 1 2", "3 0 1 4")),
        "16:7 `4`: vertex 4 does not exist, there are 4, counted from 0 (face 0 of 1, counted from 0)"
    );
    assert_eq!(
        said(&good.replace("3 0 1 2", "3 0 1 -1")),
        "16:7 `-1`: vertex -1 does not exist, there are 4, counted from 0 (face 0 of 1, counted from 0)"
    );
    assert_eq!(said(&good.replace("1 0 0 2", "1 zero 0 2")), "13:3 `zero`: `zero` is no number (vertex 1 of 4, counted from 0)");
    assert_eq!(
        said(&good.replace("1 0 0 2", "1 nan 0 2")),
        "13:3 `nan`: this vertex is not finite: NaN (vertex 1 of 4, counted from 0)"
    );
    assert_eq!(
        said(&good.replace("3 0 1 2", "999 0 1 2")),
        "16:1 `999`: a list of 999 does not fit into the file (face 0 of 1, counted from 0)"
    );
    assert_eq!(
        said(good.trim_end_matches("1 2\n")),
        format!("byte {}: the file ends too early (face 0 of 1, counted from 0)", good.len() - 4)
    );
    assert_eq!(
        said(&good.replace("vertex 4", "vertex 4000000000000")),
        "the header promises 4000000000000 of element `vertex`, at least 32000000000000 bytes, and 40 bytes follow"
    );

    let bytes = ply_binary(false, 4);
    let start = bytes.len() - 2 * 3 - 7 * 4 - 4 * 15;
    let cut = places(ply::read(&bytes[..bytes.len() - 1], false).unwrap_err());
    assert_eq!(cut, [format!("byte {}: the file ends too early (face 1 of 2, counted from 0)", bytes.len() - 1)]);
    let many = places(ply::read(&ply_binary(false, 4_000_000_000), false).unwrap_err());
    assert!(many[0].contains("promises 4000000000 of element `vertex`, at least 60000000000 bytes"), "{}", many[0]);
    let mut strange = bytes.clone();
    strange[start + 15..start + 23].copy_from_slice(&f64::INFINITY.to_le_bytes());
    assert_eq!(
        places(ply::read(&strange, false).unwrap_err()),
        [format!("byte {}: vertex 1 is not finite: [inf, 0, 0]", start + 15)]
    );
    let mut longer = bytes;
    longer.extend([0; 5]);
    assert_eq!(ply::read(&longer, false).unwrap().warnings, ["5 bytes behind the last element are left aside"]);
}

/// Meshes of one triangle at heights `z`, in one file.
fn serialized_file(version: u16, double: bool, z: &[f64]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut offsets = Vec::new();
    for z in z {
        offsets.push(out.len() as u64);
        let mut data = (if double { 0x2000u32 } else { 0x1000 } | 0x1 | 0x2 | 0x8).to_le_bytes().to_vec();
        if version == 4 {
            data.extend(b"tri\0");
        }
        data.extend(3u64.to_le_bytes());
        data.extend(1u64.to_le_bytes());
        let positions = [0.0, 0.0, *z, 1.0, 0.0, *z, 0.0, 1.0, *z];
        let floats = positions.into_iter().chain([0.0, 0.0, 1.0].repeat(3)).chain([0.25; 6]).chain([0.5; 9]);
        floats.for_each(|x| if double { data.extend(x.to_le_bytes()) } else { data.extend((x as f32).to_le_bytes()) });
        [0u32, 1, 2].iter().for_each(|i| data.extend(i.to_le_bytes()));
        out.extend([0x1C, 0x04]);
        out.extend(version.to_le_bytes());
        let mut encoder = flate2::write::ZlibEncoder::new(&mut out, flate2::Compression::fast());
        encoder.write_all(&data).unwrap();
        encoder.finish().unwrap();
    }
    let count = offsets.len() as u32;
    for offset in offsets {
        if version == 4 { out.extend(offset.to_le_bytes()) } else { out.extend((offset as u32).to_le_bytes()) }
    }
    out.extend(count.to_le_bytes());
    out
}

#[test]
fn serialized_meshes() {
    for (version, double) in [(3, false), (4, true), (4, false)] {
        let file = serialized_file(version, double, &[1.0, 2.0, 3.0]);
        for i in 0..3 {
            let mesh = serialized::read(&file, i).unwrap().mesh;
            assert_eq!(mesh.positions[1], Vec3::new(1.0, 0.0, i as f32 + 1.0));
            assert_eq!((mesh.normals[2], mesh.uvs[0], &mesh.indices[..]), (Vec3::Z, Vec2::splat(0.25), &[[0, 1, 2]][..]));
            assert_eq!((mesh.attributes[0].name.as_str(), mesh.attributes[0].data[8]), ("vertex_color", 0.5));
        }
    }
}

#[test]
fn serialized_mistakes() {
    let file = serialized_file(4, false, &[1.0, f64::NAN]);
    let said = |bytes: &[u8], i: usize| places(serialized::read(bytes, i).unwrap_err()).remove(0);
    assert_eq!(said(&file, 2), "mesh 2 does not exist, the file has 2, counted from 0");
    assert!(said(&file, 1).contains("vertex 0 of the mesh that begins here is not finite"));
    assert_eq!(said(b"\x1C", 0), "byte 0: the file ends before the head of the mesh");
    assert_eq!(said(b"ply\n", 0), "byte 0: no serialized mesh begins here (0x041C expected)");
    assert_eq!(said(&[0x1C, 4, 9, 0, 0], 0), "byte 2: version 9 is not known, expected 3 or 4");
    assert!(said(&file[..40], 0).contains("byte 0: "));
    let mut wrong = file.clone();
    let end = wrong.len();
    wrong[end - 12..end - 4].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(
        said(&wrong, 1),
        format!("byte {}: the table puts mesh 1 at byte {}, behind the end of the file", end - 4, u64::MAX)
    );
    wrong[end - 4..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(said(&wrong, 1).contains("the table of 4294967295 meshes does not fit"));
    // A head that promises more than deflate can hold.
    let mut out = vec![0x1C, 0x04, 4, 0];
    let mut encoder = flate2::write::ZlibEncoder::new(&mut out, flate2::Compression::fast());
    encoder.write_all(&[&0x1000u32.to_le_bytes()[..], b"\0", &0xFFFF_FFFFu64.to_le_bytes(), &1u64.to_le_bytes()].concat()).unwrap();
    encoder.finish().unwrap();
    assert!(said(&out, 0).contains("the positions should take 51539607540 bytes"));
}

fn grid_file(size: [i32; 3], channels: i32, data: &[f32]) -> Vec<u8> {
    let mut out = b"VOL\x03".to_vec();
    [1, size[0], size[1], size[2], channels].iter().for_each(|i: &i32| out.extend(i.to_le_bytes()));
    [0.0, 0.0, 0.0, 1.0, 2.0, 3.0].iter().for_each(|x: &f32| out.extend(x.to_le_bytes()));
    data.iter().for_each(|x| out.extend(x.to_le_bytes()));
    out
}

#[test]
fn grids() {
    let grid = vol::read(&grid_file([2, 1, 3], 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0])).unwrap();
    assert_eq!((grid.size, grid.channels, grid.bounds.max), ([2, 1, 3], 1, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(grid.data, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let said = |bytes: &[u8]| places(vol::read(bytes).unwrap_err()).remove(0);
    let cut = grid_file([2, 1, 3], 3, &[0.0; 17]);
    assert_eq!(said(&cut), "byte 48: 2 x 1 x 3 cells of 3 channels take 72 bytes, and 68 bytes follow");
    assert_eq!(
        said(&grid_file([i32::MAX; 3], 6, &[])).split(" cells").next(),
        Some("byte 48: 2147483647 x 2147483647 x 2147483647")
    );
    assert_eq!(said(&grid_file([2, 0, 3], 1, &[])), "byte 12: the grid has 0 cells along y, expected at least 1");
    assert_eq!(said(&grid_file([2, 2, -3], 1, &[])), "byte 16: the grid has -3 cells along z, expected at least 1");
    assert_eq!(said(&grid_file([1, 1, 1], 2, &[])), "byte 20: the grid has 2 channels, expected 1, 3 or 6");
    assert_eq!(said(&grid_file([1, 1, 2], 1, &[1.0, f32::NAN])), "byte 52: the grid holds a number that is not finite: NaN");
    assert_eq!(said(b"VOL\x03"), "byte 4: the file ends within its header of 48 bytes");
    assert_eq!(said(b"vol"), "the file does not begin with `VOL`");
}
