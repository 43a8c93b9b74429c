//! Scenes that are read, written and read again say the same.

mod compare;
mod corpus;

use compare::{same, tokens};
use etendue_description::{Description, Kind, Severity};
use etendue_formats::ReadOptions;
use etendue_formats::write::{Fate, Target, WriteOptions, Written, write};
use std::path::{Path, PathBuf};

/// A description without mistakes.
fn read(path: &Path) -> Description {
    let (description, diagnostics) = etendue_formats::read(path, &ReadOptions::default());
    assert_eq!(diagnostics.count(Severity::Error), 0, "{}", diagnostics.render(&description.sources));
    description
}

/// A folder with the files that scenes of the corpus name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in corpus::files() {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

/// Writes a description into a folder of its own.
fn written(d: &Description, target: Target, folder: &Path, own_words: bool) -> (PathBuf, Written) {
    std::fs::create_dir_all(folder).unwrap();
    let out = folder.join(if target == Target::Pbrt { "out.pbrt" } else { "out.xml" });
    let options = WriteOptions { out: out.clone(), source: "test".to_owned(), own_words, copy: false };
    let written = write(d, target, &options).unwrap();
    let again = write(d, target, &options).unwrap();
    assert!(written.text == again.text && written.files == again.files, "the same description gives the same bytes");
    for (path, bytes) in &written.files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    std::fs::write(&out, &written.text).unwrap();
    (out, written)
}

/// Everything that was said to be less than kept.
fn losses(written: &Written) -> Vec<String> {
    let of = |fate| written.notes.by_fate(fate).map(move |n| format!("{} {}: {}", n.fate.name(), n.what, n.how));
    of(Fate::Approximated).chain(of(Fate::Dropped)).collect()
}

#[test]
fn mitsuba_scenes_come_back_as_they_were() {
    let folder = folder();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&scenes).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "xml") && !p.to_string_lossy().contains("-room"));
    files.sort();
    assert!(files.len() >= 8);
    let own = folder.path().join("all.xml");
    std::fs::write(&own, corpus::MITSUBA).unwrap();
    files.push(own);
    for file in files {
        let before = read(&file);
        for own_words in [false, true] {
            let (out, written) = written(&before, Target::Mitsuba, &folder.path().join("out"), own_words);
            assert_eq!(losses(&written), Vec::<String>::new(), "{}", file.display());
            same(&tokens(&before), &tokens(&read(&out)), 0.0, &file.display().to_string());
        }
    }
}

#[test]
fn pbrt_scenes_come_back_as_they_were() {
    let folder = folder();
    for (i, text) in corpus::pbrt_scenes().iter().enumerate() {
        let file = folder.path().join(format!("scene-{i}.pbrt"));
        std::fs::write(&file, text).unwrap();
        let before = read(&file);
        let (out, written) = written(&before, Target::Pbrt, &folder.path().join("out"), false);
        assert_eq!(losses(&written), Vec::<String>::new(), "{text}");
        same(&tokens(&before), &tokens(&read(&out)), 1e-12, &written.text);
        // What is written of what was written is the same, but for roundings of inverses.
        let (again, _) = self::written(&read(&out), Target::Pbrt, &folder.path().join("out"), false);
        same(&tokens(&before), &tokens(&read(&again)), 1e-11, text);
    }
}

/// The words of pbrt that Mitsuba does not have survive as étendue's own.
#[test]
fn pbrt_scenes_pass_through_mitsuba_in_our_own_words() {
    let folder = folder();
    for (i, text) in corpus::pbrt_scenes().iter().enumerate() {
        let file = folder.path().join(format!("scene-{i}.pbrt"));
        std::fs::write(&file, text).unwrap();
        let before = read(&file);
        let (xml, _) = written(&before, Target::Mitsuba, &folder.path().join("out"), true);
        let between = read(&xml);
        let (back, written) = written(&between, Target::Pbrt, &folder.path().join("out"), true);
        assert_eq!(losses(&written), Vec::<String>::new(), "{text}");
        same(&tokens(&before), &tokens(&read(&back)), 1e-11, text);
    }
}

/// Whatever Mitsuba cannot say, its file is one that is read without mistakes and in which no word is étendue's own.
#[test]
fn plain_mitsuba_files_hold_no_words_of_our_own() {
    const OWN: [&str; 20] = [
        "coateddiffuse",
        "coatedconductor",
        "diffusetransmission",
        "phong",
        "spherical",
        "goniometric",
        "trianglemesh",
        "product",
        "directionmix",
        "adjusted",
        "mapped",
        "bilerp",
        "dots",
        "fbm",
        "wrinkled",
        "windy",
        "marble",
        "path-nee",
        "bidirectional",
        "constant",
    ];
    let folder = folder();
    for (i, text) in corpus::pbrt_scenes().iter().enumerate() {
        let file = folder.path().join(format!("scene-{i}.pbrt"));
        std::fs::write(&file, text).unwrap();
        let (xml, written) = written(&read(&file), Target::Mitsuba, &folder.path().join("out"), false);
        let after = read(&xml);
        for node in &after.nodes {
            let own = OWN.contains(&node.model.value.as_str()) && node.kind != Kind::Emitter;
            assert!(!own, "{} in {}", node.model.value, written.text);
            for p in &node.params {
                let own = ["masking", "pbrt_uv", "number", "gamma", "remap_roughness", "two_sided", "power", "illuminance"]
                    .contains(&p.name.value.as_str());
                assert!(!own, "{} of {} in {}", p.name.value, node.model.value, written.text);
            }
        }
    }
}

#[test]
fn what_pbrt_cannot_say_is_told() {
    let folder = folder();
    let file = folder.path().join("all.xml");
    std::fs::write(&file, corpus::MITSUBA).unwrap();
    let (out, written) = written(&read(&file), Target::Pbrt, &folder.path().join("out"), false);
    read(&out);
    let said = losses(&written).join("\n");
    for words in [
        "approximated bsdf `plastic`: `coateddiffuse`",
        "approximated bsdf `principled`:",
        "approximated bsdf `roughconductor`, `distribution`: GGX: pbrt has no other",
        "approximated bsdf `diffuse`: reflects on its back, too",
        "approximated emitter `envmap`, `filename`: unfolded anew, onto a square",
        "approximated emitter `spot`, `falloff`: smooth",
        "approximated texture `mesh_attribute`: its mean",
        "approximated texture `bitmap`, `wrap_mode`: `repeat`",
        "dropped sensor `orthographic`: pbrt's scenes have one camera",
        "dropped bsdf `dielectric`, `specular_transmittance`",
        "dropped emitter `directionalarea`",
        "dropped shape `sdfgrid`",
    ] {
        assert!(said.contains(words), "{words} is not in\n{said}");
    }
}

#[test]
fn files_are_named_where_they_are_or_copied() {
    let folder = folder();
    let file = folder.path().join("scene.xml");
    let text = "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"quad.ply\"/>\
                <bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"bitmap\"><string name=\"filename\" value=\"grid.exr\"/>\
                </texture></bsdf></shape></scene>";
    std::fs::write(&file, text).unwrap();
    let d = read(&file);
    let out = folder.path().join("below/scene.xml");
    std::fs::create_dir_all(out.parent().unwrap()).unwrap();
    for (copy, quad, grid) in
        [(false, "\"../quad.ply\"", "\"../grid.exr\""), (true, "\"scene.xml-files/quad.ply\"", "\"scene.xml-files/grid.exr\"")]
    {
        let options = WriteOptions { out: out.clone(), copy, ..WriteOptions::default() };
        let written = write(&d, Target::Mitsuba, &options).unwrap();
        assert!(written.text.contains(quad) && written.text.contains(grid), "{}", written.text);
        assert_eq!(written.files.len(), if copy { 2 } else { 0 });
    }
}

#[test]
fn names_are_kept_and_none_is_given_twice() {
    let folder = folder();
    let file = folder.path().join("scene.pbrt");
    let text = "WorldBegin\nTexture \"wood\" \"float\" \"checkerboard\"\n\
                Texture \"wood\" \"spectrum\" \"checkerboard\"\n\
                MakeNamedMaterial \"wood\" \"string type\" \"conductor\" \"texture roughness\" \"wood\" \"texture reflectance\" \"wood\"\n\
                NamedMaterial \"wood\" Shape \"sphere\" Shape \"disk\"\nMaterial \"diffuse\" Shape \"sphere\" Shape \"disk\"\n\
                ObjectBegin \"lamp post\" Shape \"sphere\" ObjectEnd ObjectInstance \"lamp post\"";
    std::fs::write(&file, text).unwrap();
    let d = read(&file);
    let (xml, written) = written(&d, Target::Mitsuba, &folder.path().join("out"), false);
    assert!(written.text.contains("id=\"wood\"") && written.text.contains("id=\"wood-2\""), "{}", written.text);
    assert!(written.text.contains("<ref id=\"lamp post\"/>"), "{}", written.text);
    read(&xml);
    let (pbrt, written) = self::written(&d, Target::Pbrt, &folder.path().join("out"), false);
    let names =
        ["MakeNamedMaterial \"wood\"", "Texture \"wood\" \"float\"", "Texture \"wood\" \"spectrum\"", "ObjectBegin \"lamp post\""];
    assert!(names.iter().all(|name| written.text.contains(name)), "{}", written.text);
    read(&pbrt);
}
