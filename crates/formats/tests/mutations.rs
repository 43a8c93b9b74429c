//! No file makes a reader panic, and what a reader accepts keeps its promises: small good files, broken at random.
//!
//! `PROPTEST_CASES=1000000 cargo test --release -p etendue-formats --test mutations` searches longer.

use etendue_description::MeshData;
use etendue_formats::measured;
use etendue_formats::mesh::{Loaded, obj, ply, serialized, vol};
use etendue_formats::{ReadOptions, read_str, xml};
use proptest::prelude::*;
use std::path::PathBuf;

/// The small good files of a format, which are the fuzzers' as well.
fn corpus(format: &str) -> Vec<Vec<u8>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(format);
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// A way to break a file; places are taken modulo its length.
#[derive(Clone, Debug)]
enum Edit {
    Put(usize, u8),
    Insert(usize, String),
    Bytes(usize, [u8; 4]),
    Delete(usize, usize),
    Repeat(usize, usize),
    Cut(usize),
}

fn edits(words: &'static [&'static str]) -> impl Strategy<Value = (usize, Vec<Edit>)> {
    let at = 0..100_000usize;
    let edit = prop_oneof![
        (at.clone(), any::<u8>()).prop_map(|(i, b)| Edit::Put(i, b)),
        (at.clone(), prop::sample::select(words)).prop_map(|(i, w)| Edit::Insert(i, w.to_owned())),
        (
            at.clone(),
            prop::sample::select(vec![[255; 4], [0; 4], [0, 0, 0, 128], [255, 255, 255, 127], [0, 0, 192, 127], [1, 0, 0, 0]])
        )
            .prop_map(|(i, b)| Edit::Bytes(i, b)),
        (at.clone(), 1..20usize).prop_map(|(i, n)| Edit::Delete(i, n)),
        (at.clone(), 1..40usize).prop_map(|(i, n)| Edit::Repeat(i, n)),
        at.prop_map(Edit::Cut),
    ];
    (0..100usize, prop::collection::vec(edit, 1..6))
}

fn broken(corpus: &[Vec<u8>], (seed, edits): (usize, Vec<Edit>)) -> Vec<u8> {
    let mut bytes = corpus[seed % corpus.len()].clone();
    for edit in edits {
        let n = bytes.len() + 1;
        match edit {
            Edit::Put(i, b) => {
                if let Some(byte) = bytes.get_mut(i % n) {
                    *byte = b;
                }
            }
            Edit::Insert(i, word) => drop(bytes.splice(i % n..i % n, word.into_bytes())),
            Edit::Bytes(i, four) => {
                let at = i % n;
                let end = (at + 4).min(bytes.len());
                bytes.splice(at..end, four);
            }
            Edit::Delete(i, len) => drop(bytes.drain(i % n..(i % n + len).min(n - 1))),
            Edit::Repeat(i, len) => {
                let piece = bytes[i % n..(i % n + len).min(n - 1)].to_vec();
                bytes.splice(i % n..i % n, piece);
            }
            Edit::Cut(i) => bytes.truncate(i % n),
        }
    }
    bytes
}

/// What readers promise of a mesh.
fn check(Loaded { mesh, .. }: Loaded) -> Result<(), TestCaseError> {
    let MeshData { positions, normals, uvs, indices, attributes, .. } = mesh;
    let n = positions.len();
    prop_assert!(positions.iter().all(|p| p.is_finite()));
    prop_assert!(normals.is_empty() || normals.len() == n);
    prop_assert!(normals.iter().all(|v| (v.length() - 1.0).abs() < 1e-4));
    prop_assert!(uvs.is_empty() || uvs.len() == n);
    prop_assert!(uvs.iter().all(|t| t.is_finite()));
    prop_assert!(indices.iter().flatten().all(|&i| (i as usize) < n));
    for a in attributes {
        let count = if a.kind == etendue_description::AttributeKind::Vertex { n } else { indices.len() };
        prop_assert_eq!(a.data.len(), count * a.channels);
        prop_assert!(a.data.iter().all(|x| x.is_finite()));
    }
    Ok(())
}

const XML_WORDS: &[&str] = &[
    "<",
    ">",
    "/>",
    "</",
    "\"",
    "'",
    "=",
    "<!--",
    "-->",
    "<![CDATA[",
    "&lt;",
    "&#0;",
    "&",
    "$",
    "$r",
    "\\$",
    "ä",
    "箱",
    "\u{feff}",
    "\r\n",
    "nan",
    "1e999",
    "-0",
    "<ref id=\"a\"/>",
    "<include filename=\"s.xml\"/>",
    "<transform name=\"t\">",
    "<scene version=\"3.0.0\">",
    " id=\"a\"",
    " name=\"n\"",
    "400:1,",
    "#",
];
const PBRT_WORDS: &[&str] = &[
    "[",
    "]",
    "\"",
    "#",
    "\\",
    "\n",
    "Shape \"sphere\"",
    "AttributeBegin ",
    "AttributeEnd ",
    "ObjectEnd ",
    "WorldBegin ",
    "Include \"s.pbrt\" ",
    "Material \"\" ",
    "NamedMaterial \"wood\" ",
    "\"float radius\" ",
    "\"texture alpha\" \"t\" ",
    "\"point3 P\" [",
    "\"integer indices\" [ 0 1 2147483647 ]",
    "Scale 0 0 0 ",
    "ActiveTransform EndTime ",
    "-1 ",
    "1e38 ",
    "nan ",
    "99999999999 ",
    "ä箱",
];
const TEXT_WORDS: &[&str] = &[
    "nan",
    "-inf",
    "1e39",
    "0",
    "-1",
    "99999999999999999999",
    "/",
    "//",
    "\\\n",
    "\r\n",
    "f 1 2 3\n",
    "v 0 0 0\n",
    " ",
    "\n",
    "list ",
    "element face 1\n",
    "4294967295",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(1000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn scenes(edits in edits(XML_WORDS)) {
        let bytes = broken(&corpus("xml"), edits);
        let text = String::from_utf8_lossy(&bytes);
        let (description, diagnostics) = read_str("no-folder/s.xml", &text, &ReadOptions::default());
        // Every place must be one, and every node be there.
        let _ = diagnostics.render(&description.sources);
        let count = description.nodes.len();
        for param in description.nodes.iter().flat_map(|node| &node.params) {
            if let etendue_description::Value::Node(id) = param.value.value {
                prop_assert!((id.0 as usize) < count);
            }
        }
    }

    #[test]
    fn pbrt_scenes(edits in edits(PBRT_WORDS)) {
        let bytes = broken(&corpus("pbrt"), edits);
        let text = String::from_utf8_lossy(&bytes);
        let (description, diagnostics) = read_str("no-folder/s.pbrt", &text, &ReadOptions::default());
        let _ = diagnostics.render(&description.sources);
        let (nodes, meshes) = (description.nodes.len(), description.assets.meshes.len());
        for param in description.nodes.iter().flat_map(|node| &node.params) {
            match param.value.value {
                etendue_description::Value::Node(id) => prop_assert!((id.0 as usize) < nodes),
                etendue_description::Value::Mesh(i) => prop_assert!((i as usize) < meshes),
                _ => {}
            }
        }
        for mesh in &description.assets.meshes {
            check(Loaded { mesh: MeshData::clone(mesh), warnings: Vec::new() })?;
        }
    }

    #[test]
    fn xml_agrees_with_another_parser(edits in edits(XML_WORDS)) {
        let bytes = broken(&corpus("xml"), edits);
        let text = String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').to_owned();
        if let Ok(theirs) = roxmltree::Document::parse(&text) {
            let mut diagnostics = etendue_description::Diagnostics::default();
            let mut sources = etendue_description::Sources::default();
            let source = sources.add("a.xml", text.as_str());
            let ours = xml::parse(source, &text, &mut diagnostics);
            prop_assert!(diagnostics.is_empty(), "{}", diagnostics.render(&sources));
            compare(&text, &ours, ours.root().unwrap(), theirs.root_element())?;
        }
    }

    #[test]
    fn objs(edits in edits(TEXT_WORDS), flip: bool) {
        if let Ok(loaded) = obj::read(&broken(&corpus("obj"), edits), flip) {
            check(loaded)?;
        }
    }

    #[test]
    fn plys(edits in edits(TEXT_WORDS), flip: bool) {
        if let Ok(loaded) = ply::read(&broken(&corpus("ply"), edits), flip) {
            check(loaded)?;
        }
    }

    #[test]
    fn serialized_files(edits in edits(TEXT_WORDS), index in 0..3usize) {
        if let Ok(loaded) = serialized::read(&broken(&corpus("serialized"), edits), index) {
            check(loaded)?;
        }
    }

    #[test]
    fn grids(edits in edits(TEXT_WORDS)) {
        if let Ok(grid) = vol::read(&broken(&corpus("vol"), edits)) {
            prop_assert_eq!(grid.data.len(), grid.size.iter().product::<usize>() * grid.channels);
            prop_assert!(grid.data.iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn measured_materials(edits in edits(TEXT_WORDS)) {
        if let Ok(data) = measured::read(&broken(&corpus("bsdf"), edits)) {
            let grids = data.phi.len() * data.theta.len();
            let channels = if data.wavelengths.is_empty() { 3 } else { data.wavelengths.len() };
            for (table, n) in [(&data.ndf, 1), (&data.sigma, 1), (&data.vndf, grids), (&data.luminance, grids), (&data.spectra, grids * channels)] {
                prop_assert_eq!(table.values.len(), table.size[0] * table.size[1] * n);
                prop_assert!(table.values.iter().all(|x| x.is_finite()));
            }
        }
    }

    #[test]
    fn noise(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let text = String::from_utf8_lossy(&bytes);
        let (description, diagnostics) = read_str("no-folder/s.xml", &text, &ReadOptions::default());
        let _ = diagnostics.render(&description.sources);
        let (description, diagnostics) = read_str("no-folder/s.pbrt", &text, &ReadOptions::default());
        let _ = diagnostics.render(&description.sources);
        let _ = (obj::read(&bytes, true), ply::read(&bytes, true), serialized::read(&bytes, 0), vol::read(&bytes), measured::read(&bytes));
    }
}

#[test]
fn pbrt_scenes_cut_at_every_byte() {
    for bytes in corpus("pbrt") {
        for end in 0..bytes.len() {
            let text = String::from_utf8_lossy(&bytes[..end]);
            let (description, diagnostics) = read_str("no-folder/s.pbrt", &text, &ReadOptions::default());
            let _ = diagnostics.render(&description.sources);
        }
    }
}

#[test]
fn files_cut_at_every_byte() {
    // A binary PLY cut one byte before the end of its vertices was once read beyond its end.
    for bytes in ["xml", "obj", "ply", "serialized", "vol", "bsdf"].into_iter().flat_map(corpus) {
        for end in 0..bytes.len() {
            let cut = &bytes[..end];
            let text = String::from_utf8_lossy(cut);
            let (description, diagnostics) = read_str("no-folder/s.xml", &text, &ReadOptions::default());
            assert!(!diagnostics.render(&description.sources).is_empty() || end + 1 == bytes.len());
            let _ = (obj::read(cut, true), ply::read(cut, true), serialized::read(cut, 1), vol::read(cut), measured::read(cut));
        }
    }
}

/// The same elements, attributes and values in the same order.
fn compare(text: &str, ours: &xml::Document, id: xml::ElementId, theirs: roxmltree::Node) -> Result<(), TestCaseError> {
    // They know namespaces and take the prefix off.
    prop_assert_eq!(xml::slice(text, &ours.element(id).name).rsplit(':').next(), Some(theirs.tag_name().name()));
    prop_assert_eq!(ours.element(id).end as usize, theirs.range().end);
    prop_assert_eq!(ours.attributes(id).len(), theirs.attributes().len());
    for (a, b) in ours.attributes(id).iter().zip(theirs.attributes()) {
        prop_assert_eq!(a.value.start as usize..a.value.end as usize, b.range_value());
        // They turn line ends and tabs in values into blanks, as XML asks; readers of values take all blanks alike.
        let blanks = |s: &str| s.replace("\r\n", " ").replace(['\n', '\t', '\r'], " ");
        prop_assert_eq!(blanks(&a.text(text).0), blanks(b.value()));
    }
    let children: Vec<_> = ours.children(id).collect();
    prop_assert_eq!(children.len(), theirs.children().filter(|c| c.is_element()).count());
    for (a, b) in children.into_iter().zip(theirs.children().filter(|c| c.is_element())) {
        compare(text, ours, a, b)?;
    }
    Ok(())
}
