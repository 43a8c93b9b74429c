//! pbrt-v4 scenes: what they become, and what is said about mistakes in them.

mod common;

use common::{lines, with_files, word};
use etendue_description::{Description, Kind, Node, SpectrumValue, Value};
use etendue_formats::{ReadOptions, read_str};
use glam::{DVec3, Vec3};
use std::io::Write as _;

fn said(text: &str) -> Vec<String> {
    lines(&read_str("s.pbrt", text, &ReadOptions::default()))
}

/// What is said about a world of these lines; the first is line 2.
fn world(body: &str) -> Vec<String> {
    said(&format!("WorldBegin\n{body}\n"))
}

fn good(text: &str) -> Description {
    let result = read_str("s.pbrt", text, &ReadOptions::default());
    assert_eq!(lines(&result), Vec::<String>::new());
    result.0
}

fn good_world(body: &str) -> Description {
    good(&format!("WorldBegin\n{body}\n"))
}

fn nodes<'a>(description: &'a Description, kind: Kind, model: &str) -> Vec<&'a Node> {
    description.nodes.iter().filter(|n| n.kind == kind && n.model.value == model).collect()
}

fn value<'a>(node: &'a Node, name: &str) -> &'a Value {
    &node.params.iter().find(|p| p.name.value == name).unwrap_or_else(|| panic!("no `{name}` in {node:?}")).value.value
}

fn child<'a>(description: &'a Description, node: &Node, kind: Kind) -> &'a Node {
    let mut nodes =
        node.params.iter().filter_map(|p| if let Value::Node(id) = p.value.value { Some(description.node(id)) } else { None });
    nodes.find(|n| n.kind == kind).unwrap_or_else(|| panic!("no {} in {node:?}", kind.name()))
}

fn place(node: &Node, p: DVec3) -> DVec3 {
    let Value::Transform(t) = value(node, "to_world") else { panic!("no transform") };
    t.point_f64(p)
}

// ---- what scenes become

#[test]
fn transforms_compose_and_blocks_restore_them() {
    let scene = good_world(
        "Translate 1 2 3\nAttributeBegin\n  Scale 2 2 2 Rotate 90 0 0 1\n  Shape \"sphere\"\nAttributeEnd\nShape \"sphere\"\n\
         CoordinateSystem \"here\"\nIdentity Transform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]\nShape \"sphere\"\n\
         CoordSysTransform \"here\" ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  1 0 0 1]\nShape \"sphere\"",
    );
    let spheres = nodes(&scene, Kind::Shape, "sphere");
    let at: Vec<DVec3> = spheres.iter().map(|s| place(s, DVec3::X)).collect();
    let expected = [(1.0, 4.0, 3.0), (2.0, 2.0, 3.0), (8.0, 8.0, 9.0), (3.0, 2.0, 3.0)].map(DVec3::from);
    for (got, want) in at.iter().zip(expected) {
        assert!((*got - want).length() < 1e-12, "{at:?}");
    }
}

#[test]
fn cameras_look_along_their_z_and_x_is_mirrored() {
    let scene = good(
        "LookAt 1 2 3  1 2 9  0 1 0\nCamera \"perspective\" \"float fov\" 40\nFilm \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100\nWorldBegin",
    );
    let camera = nodes(&scene, Kind::Sensor, "perspective")[0];
    assert!((place(camera, DVec3::Z) - DVec3::new(1.0, 2.0, 4.0)).length() < 1e-9);
    // pbrt: up × ahead = x is to the right; ours is to the left.
    assert!((place(camera, DVec3::X) - DVec3::new(0.0, 2.0, 3.0)).length() < 1e-9);
    // The angle is that of the shorter side.
    let Value::Float(fov) = value(camera, "fov") else { panic!("no fov") };
    let expected = 2.0 * (2.0 * 20f64.to_radians().tan()).atan().to_degrees();
    assert!((fov - expected).abs() < 1e-9, "{fov} {expected}");
    let lens = good("Scale 2 2 2 Camera \"perspective\" \"float lensradius\" .5 \"float focaldistance\" 4\nWorldBegin");
    // Lengths are those of the camera, whose unit is half of the world's.
    assert_eq!(value(nodes(&lens, Kind::Sensor, "thinlens")[0], "aperture_radius"), &Value::Float(0.25));
}

#[test]
fn integrators_films_filters_and_samplers() {
    for (theirs, ours) in [
        ("volpath", "path"),
        ("path", "path"),
        ("simplepath", "path-nee"),
        ("randomwalk", "random-walk"),
        ("lightpath", "ptracer"),
        ("bdpt", "bidirectional"),
        ("mlt", "metropolis"),
        ("sppm", "photon-map"),
    ] {
        let scene = good(&format!("Integrator \"{theirs}\" \"integer maxdepth\" 7\nWorldBegin"));
        assert_eq!(value(nodes(&scene, Kind::Integrator, ours)[0], "max_depth"), &Value::Integer(8), "{theirs}");
    }
    let scene = good(
        "Film \"gbuffer\" \"integer xresolution\" [ 10 ] \"integer pixelbounds\" [2 5 1 4]\nPixelFilter \"mitchell\" \"float B\" 0.2\n\
         Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5\nWorldBegin",
    );
    let film = nodes(&scene, Kind::Film, "hdrfilm")[0];
    assert_eq!(value(film, "crop_offset_x"), &Value::Integer(2));
    assert_eq!(value(film, "crop_height"), &Value::Integer(3));
    assert_eq!(value(nodes(&scene, Kind::Sampler, "independent")[0], "sample_count"), &Value::Integer(15));
    assert_eq!(value(nodes(&scene, Kind::Filter, "mitchell")[0], "B"), &Value::Float(0.2));
    // The default depth, within the layers.
    let aov = nodes(&scene, Kind::Integrator, "aov")[0];
    assert_eq!(value(child(&scene, aov, Kind::Integrator), "max_depth"), &Value::Integer(6));
}

#[test]
fn meshes_stay_as_they_are() {
    let scene = good_world(
        "Shape \"trianglemesh\" # a comment \" [\n  \"point3 P\" [0 0 0 1 0 0 0 1 0 1. +1. .5e1]\"integer indices\"[0 1 2 1 3 2]\n \
         \"point2 uv\" [0 0 1 0 0 1 1 1] \"normal N\" [0 0 2 0 0 1 0 0 1 0 0 1]",
    );
    let mesh = &scene.assets.meshes[0];
    assert_eq!(mesh.positions[3], Vec3::new(1.0, 1.0, 5.0));
    assert_eq!(mesh.indices, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!((mesh.uvs.len(), mesh.normals[0]), (4, Vec3::Z));
    // A single triangle needs no indices.
    assert_eq!(good_world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]").assets.meshes[0].indices, [[0, 1, 2]]);
    let patch = good_world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]");
    assert_eq!(patch.assets.meshes[0].indices.len(), 2);
    assert!(patch.assets.meshes[0].normals.iter().all(|n| *n == Vec3::Z));
    let bent = good_world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]");
    assert!(bent.assets.meshes[0].indices.len() >= 32);
}

#[test]
fn materials_and_their_roughness() {
    let scene = good_world(
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" 0.25\nShape \"sphere\"\n\
         Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"\nShape \"sphere\"\n\
         Material \"conductor\" \"rgb reflectance\" [.1 .2 .3] \"float uroughness\" .0009 \"float vroughness\" 0 \"bool remaproughness\" false\n\
         Shape \"sphere\"",
    );
    let gold = nodes(&scene, Kind::Bsdf, "roughconductor")[0];
    assert_eq!(value(gold, "material"), &Value::String("Au".to_owned()));
    assert_eq!(value(gold, "alpha_u"), &Value::Float(0.5));
    assert_eq!(value(gold, "masking"), &Value::String("correlated".to_owned()));
    assert_eq!(nodes(&scene, Kind::Bsdf, "twosided").len(), 2);
    assert_eq!(value(nodes(&scene, Kind::Bsdf, "dielectric")[0], "int_ior"), &Value::String("glass-BK7".to_owned()));
    assert_eq!(value(nodes(&scene, Kind::Bsdf, "conductor")[0], "reflectance"), &Value::Rgb([0.1, 0.2, 0.3]));
}

#[test]
fn names_may_come_before_what_they_name() {
    let scene = good_world(
        "NamedMaterial \"late\"\nShape \"sphere\"\nMakeNamedMaterial \"late\" \"string type\" \"diffuse\" \"texture reflectance\" \"t\"\n\
         Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]\n\
         MakeNamedMaterial \"both\" \"string type\" \"mix\" \"string materials\" [\"late\" \"late\"] \"float amount\" .25",
    );
    let sphere = nodes(&scene, Kind::Shape, "sphere")[0];
    let two_sided = child(&scene, sphere, Kind::Bsdf);
    let diffuse = child(&scene, two_sided, Kind::Bsdf);
    assert_eq!(value(child(&scene, diffuse, Kind::Texture), "value"), &Value::Rgb([0.1, 0.2, 0.3]));
    assert_eq!(value(nodes(&scene, Kind::Bsdf, "blendbsdf")[0], "weight"), &Value::Float(0.25));
}

#[test]
fn defaults_of_attributes_yield_to_what_is_given() {
    let scene = good_world(
        "AttributeBegin\nAttribute \"shape\" \"float radius\" 2 \"float alpha\" .5\nAttribute \"material\" \"rgb reflectance\" [1 0 0]\n\
         Material \"diffuse\"\nShape \"sphere\"\nShape \"sphere\" \"float radius\" 3\nAttributeEnd\nShape \"sphere\"",
    );
    let radii: Vec<_> = nodes(&scene, Kind::Shape, "sphere").iter().map(|s| value(s, "radius").clone()).collect();
    assert_eq!(radii, [Value::Float(2.0), Value::Float(3.0), Value::Float(1.0)]);
    assert_eq!(nodes(&scene, Kind::Bsdf, "mask").len(), 1);
    assert_eq!(value(nodes(&scene, Kind::Bsdf, "diffuse")[0], "reflectance"), &Value::Rgb([1.0, 0.0, 0.0]));
}

#[test]
fn instances_show_objects() {
    let scene = good_world(
        "ObjectBegin \"o\"\n Translate 0 0 1 Shape \"sphere\" Shape \"disk\"\nObjectEnd\nTranslate 5 0 0\nObjectInstance \"o\"\nObjectInstance \"o\"",
    );
    let group = nodes(&scene, Kind::Shape, "shapegroup")[0];
    assert_eq!(group.params.len(), 2);
    let instances = nodes(&scene, Kind::Shape, "instance");
    assert_eq!(instances.len(), 2);
    assert_eq!(place(instances[0], DVec3::ZERO), DVec3::new(5.0, 0.0, 0.0));
    assert_eq!(place(nodes(&scene, Kind::Shape, "sphere")[0], DVec3::ZERO), DVec3::Z);
}

#[test]
fn light_has_the_luminance_of_its_scale() {
    let rgb = |body: &str| {
        let scene = good_world(body);
        let emitter = scene.nodes.iter().find(|n| n.kind == Kind::Emitter).expect("an emitter").clone();
        emitter.params[0].value.value.clone()
    };
    assert_eq!(rgb("LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2"), Value::Rgb([2.0, 4.0, 6.0]));
    assert_eq!(rgb("LightSource \"point\" \"float scale\" 3"), Value::Rgb([3.0; 3]));
    let Value::Rgb([r, ..]) = rgb("LightSource \"point\" \"float power\" 4") else { panic!("no rgb") };
    assert!((r - 1.0 / std::f64::consts::PI).abs() < 1e-12);
    // Whatever the numbers of a spectrum, its luminance is 1.
    let spectra = ["\"blackbody L\" 3000", "\"spectrum L\" [400 1 700 5]", "\"spectrum L\" [400 10 700 50]"];
    let [hot, low, high] = spectra.map(|l| rgb(&format!("LightSource \"infinite\" {l}")));
    assert!(matches!(hot, Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale }) if kelvin == 3000.0 && scale > 0.0));
    let last = |v: &Value| if let Value::Spectrum(SpectrumValue::Samples(s)) = v { s[1].1 } else { f64::NAN };
    assert!((last(&low) / last(&high) - 1.0).abs() < 1e-9, "{low:?} {high:?}");
    // The film's exposure.
    let scene =
        good("Film \"rgb\" \"float iso\" 200\nCamera \"perspective\" \"float shutterclose\" 3\nWorldBegin LightSource \"distant\"");
    assert_eq!(value(nodes(&scene, Kind::Emitter, "directional")[0], "irradiance"), &Value::Rgb([6.0; 3]));
}

#[test]
fn shapes_of_an_area_light_shine() {
    let scene = good_world(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 2 1] \"bool twosided\" \"true\"\nShape \"disk\"\nAttributeEnd\nShape \"sphere\"",
    );
    let light = child(&scene, nodes(&scene, Kind::Shape, "disk")[0], Kind::Emitter);
    assert_eq!((value(light, "radiance"), value(light, "two_sided")), (&Value::Rgb([3.0, 2.0, 1.0]), &Value::Bool(true)));
    assert_eq!(nodes(&scene, Kind::Emitter, "area").len(), 1);
}

#[test]
fn files_are_included_unpacked_and_found() {
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gz.write_all(b"Translate 1 0 0 Shape \"sphere\"").unwrap();
    let gz = gz.finish().unwrap();
    let options = with_files(&[("geo/part.pbrt.gz", &gz), ("geo/other.pbrt", b"Include \"part.pbrt.gz\" Shape \"disk\"")]);
    let read = read_str("s.pbrt", "WorldBegin Import \"geo/part.pbrt.gz\" Include \"geo/other.pbrt\" Shape \"cylinder\"", &options);
    assert_eq!(lines(&read), Vec::<String>::new());
    let spheres = nodes(&read.0, Kind::Shape, "sphere");
    // What an import does to the state ends with it; what an include does stays.
    assert!(spheres.iter().all(|s| place(s, DVec3::ZERO) == DVec3::X));
    assert_eq!(place(nodes(&read.0, Kind::Shape, "cylinder")[0], DVec3::ZERO), DVec3::X);
}

#[test]
fn media_are_kept_and_named() {
    let scene = good_world(
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 2 3]\nAttributeBegin MediumInterface \"fog\" \"\"\nMaterial \"interface\"\n\
         Shape \"sphere\" AttributeEnd",
    );
    let medium = child(&scene, nodes(&scene, Kind::Shape, "sphere")[0], Kind::Medium);
    assert_eq!(value(medium, "sigma_s"), &Value::Rgb([1.0, 2.0, 3.0]));
}

#[test]
fn curves_and_subdivision_surfaces_become_meshes() {
    let scene = good_world(
        "Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 0.2\n\
         Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [1 0 0 -1 1 0 -1 -1 0 0 0 1] \"integer indices\" [0 1 2 0 3 1 1 3 2 2 3 0]",
    );
    let tube = &scene.assets.meshes[0];
    assert!(tube.positions.iter().all(|p| (p.truncate().y.hypot(p.z) - 0.1).abs() < 1e-6 && (0.0..=3.0).contains(&p.x)));
    assert_eq!(scene.assets.meshes[1].indices.len(), 64);
}

/// The fuzzers' seeds say nothing but what they must.
#[test]
fn the_corpus_is_good() {
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/pbrt");
    for name in ["room.pbrt", "shapes.pbrt"] {
        let said = lines(&etendue_formats::read(&folder.join(name), &ReadOptions::default()));
        assert!(said.iter().all(|line| line.contains("warning: ")), "{said:?}");
    }
}

// ---- mistakes

#[test]
fn words_that_are_no_words() {
    assert_eq!(said(""), ["s.pbrt:1:1 error: the scene has no `WorldBegin`: nothing is in it"]);
    assert_eq!(
        world("Shap \"sphere\"\nShape \"sphre\"\nShape \"sphere\" \"float radios\" 2"),
        [
            "s.pbrt:2:1 error: unknown directive `Shap` | did you mean `Shape`?",
            "s.pbrt:3:8 error: unknown shape `sphre` | did you mean `sphere`?",
            "s.pbrt:4:17 error: unknown parameter `radios` of shape `sphere` | did you mean `radius`?",
        ]
    );
    assert_eq!(
        world("Material \"difuse\"\nMaterial \"matte\"\nLightSource \"pont\""),
        [
            "s.pbrt:2:11 error: unknown material `difuse` | did you mean `diffuse`?",
            "s.pbrt:3:11 error: the material `matte` is refused: in pbrt-v4 it is `diffuse` with `reflectance`",
            "s.pbrt:4:14 error: unknown light `pont` | did you mean `point`?",
        ]
    );
    assert_eq!(
        world("Shape \"sphere\" \"flaot radius\" 1 \"radius\" 2 \"color a\" [1 1 1]"),
        [
            "s.pbrt:2:17 error: unknown type `flaot` of a parameter | did you mean `float`?",
            "s.pbrt:2:34 error: \"radius\" declares no parameter | a parameter is declared by \"type name\", such as \"float radius\"",
            "s.pbrt:2:45 error: the type `color` is one of pbrt-v3 | in pbrt-v4 it is `rgb`",
            "s.pbrt:2:45 error: unknown parameter `a` of shape `sphere`",
        ]
    );
    assert_eq!(
        world("ColorSpace \"sRBG\""),
        ["s.pbrt:2:13 error: unknown colour space `sRBG` | did you mean `srgb`? | known: srgb, dci-p3, rec2020, aces2065-1"]
    );
    assert_eq!(
        said("Option \"bool disablepixelgitter\" true\nWorldBegin"),
        ["s.pbrt:1:9 error: unknown option `disablepixelgitter` | did you mean `disablepixeljitter`?"]
    );
}

#[test]
fn values_of_the_wrong_kind_and_number() {
    assert_eq!(
        world(
            "Shape \"sphere\" \"float radius\" [1 2]\nShape \"sphere\" \"string radius\" \"x\"\nShape \"sphere\" \"float radius\" x"
        ),
        [
            "s.pbrt:2:31 error: `radius` of shape `sphere` has 2 values, expected one value",
            "s.pbrt:3:17 error: `radius` of shape `sphere` is a string, expected float or integer",
            "s.pbrt:4:31 error: `x` is no number",
        ]
    );
    assert_eq!(
        world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 oops]\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1]"),
        [
            "s.pbrt:2:50 error: `oops` is no number",
            "s.pbrt:3:33 error: `P` of shape `trianglemesh` has 8 numbers, expected a multiple of 3",
        ]
    );
    assert_eq!(
        world("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"),
        ["s.pbrt:2:71 error: the index 3 names no vertex: there are 3, counted from 0"]
    );
    assert_eq!(
        world("Material \"diffuse\" \"rgb reflectance\" [1 2]"),
        ["s.pbrt:2:38 error: `reflectance` of material `diffuse` has 2 values, a colour has three"]
    );
    assert_eq!(
        world("Material \"diffuse\" \"spectrum reflectance\" [500 1 400 1]"),
        ["s.pbrt:2:43 error: wavelengths must rise: 400 nm follows 500 nm"]
    );
    assert_eq!(
        world("Scale 0 1 1"),
        ["s.pbrt:2:1 error: this step flattens space, has no direction, or is not finite | a transform must have an inverse"]
    );
    assert_eq!(world("Translate 1 2\nIdentity"), ["s.pbrt:2:1 error: 3 numbers must follow, found 2"]);
    assert_eq!(world("Shape \"sphere\" \"float radius\" 1e999"), ["s.pbrt:2:31 error: `1e999` is not finite"]);
    assert_eq!(
        world("Shape \"sphere\" \"bool radius\" [ 1 ]")[0],
        "s.pbrt:2:32 error: `1` is no truth value, expected true or false"
    );
    assert_eq!(world("Shape \"sphere\" \"integer levels\" 1.5")[0], "s.pbrt:2:33 error: `1.5` is no whole number");
}

#[test]
fn blocks_names_and_places() {
    assert_eq!(
        world("AttributeBegin\nShape \"sphere\""),
        ["s.pbrt:2:1 error: `AttributeBegin` is never closed | add `AttributeEnd`"]
    );
    assert_eq!(world("AttributeEnd"), ["s.pbrt:2:1 error: `AttributeEnd` closes nothing: no `AttributeBegin` is open here"]);
    assert_eq!(
        world("ObjectBegin \"a\"\nAttributeEnd\nObjectEnd"),
        ["s.pbrt:3:1 error: `AttributeEnd` closes nothing: `ObjectBegin` is open here"]
    );
    assert_eq!(
        world(
            "ObjectBegin \"tree\" ObjectEnd\nObjectInstance \"tre\"\nNamedMaterial \"wod\"\nMakeNamedMaterial \"wood\" \"string type\" \"diffuse\""
        ),
        [
            "s.pbrt:3:17 error: there is no object `tre` | did you mean `tree`?",
            "s.pbrt:4:16 error: there is no material `wod` | did you mean `wood`?",
        ]
    );
    assert_eq!(said("Shape \"sphere\"\nWorldBegin"), ["s.pbrt:1:1 error: `Shape` belongs behind `WorldBegin`"]);
    assert_eq!(world("Film \"rgb\""), ["s.pbrt:2:1 error: `Film` belongs before `WorldBegin`"]);
    assert_eq!(
        world("Texture \"a\" \"spectrum\" \"constant\"\nTexture \"a\" \"spectrum\" \"constant\""),
        ["s.pbrt:3:10 error: the spectrum texture `a` is defined twice"]
    );
    assert_eq!(
        world("Shape \"sphere\" \"float radius\" 1 \"float radius\" 2"),
        ["s.pbrt:2:34 warning: parameter `radius` is given twice: this one counts"]
    );
    assert_eq!(
        world("ActiveTransform EndTime Translate 1 0 0 ActiveTransform All\nShape \"sphere\""),
        ["s.pbrt:3:8 error: this shape moves: motion cannot be rendered yet | take out `ActiveTransform`, and it stands still"]
    );
    assert_eq!(said("Camera \"realistic\"\nWorldBegin").len(), 1);
    assert_eq!(
        said("Integrator \"ao\"\nWorldBegin"),
        ["s.pbrt:1:13 error: the integrator `ao` is refused: ambient occlusion is no light transport"]
    );
}

#[test]
fn spectra_that_are_not_there() {
    let glass = world("Material \"dielectric\" \"spectrum eta\" \"glass-BK8\"");
    assert!(glass[0].starts_with(
        "s.pbrt:2:39 error: the spectrum `glass-BK8` is not known here | did you mean `glass-BK7`? | known: metal-Ag-eta, "
    ));
    let camera = world("Material \"conductor\" \"spectrum eta\" \"nikon_d850_g\"");
    assert!(camera[0].starts_with("s.pbrt:2:38 error: `nikon_d850_g` is how a camera's sensor answers"), "{camera:?}");
}

/// Fibres have as many steps as they bend, and are seen from outside whatever the state says.
#[test]
fn fibres_are_tubes() {
    let scene = good_world(
        "Material \"hair\" \"float eumelanin\" 1 ReverseOrientation\n\
         Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 0.2\n\
         Shape \"curve\" \"string type\" \"cylinder\" \"point3 P\" [0 0 0 0 1 0 1 1 0 1 0 0] \"float width\" 0.01",
    );
    let [straight, bent] = [0, 1].map(|i| scene.assets.meshes[i].indices.len());
    assert!(straight == 2 * 12 && bent > 6 * straight, "{straight} {bent}");
    for shape in nodes(&scene, Kind::Shape, "trianglemesh") {
        assert_eq!(value(shape, "flip_normals"), &Value::Bool(false));
    }
}

#[test]
fn strings_and_lists_without_an_end() {
    assert_eq!(world("Shape \"sphere\nShape \"disk\""), ["s.pbrt:2:7 error: this string is missing its closing quote"]);
    assert_eq!(
        world("Shape \"sphere\" \"float radius\" [ 1\nShape \"disk\" \"float heigt\" 1"),
        [
            "s.pbrt:3:1 error: this list is missing its closing bracket before here",
            "s.pbrt:3:15 error: unknown parameter `heigt` of shape `disk` | did you mean `height`?",
        ]
    );
    let read = read_str("s.pbrt", "WorldBegin\nShape \"sphere\" \"float radius\" [ \"one\" ]", &ReadOptions::default());
    assert_eq!(word(&read), "one");
}

#[test]
fn files_that_include_themselves_or_are_not_there() {
    let options = with_files(&[("a.pbrt", b"Include \"b.pbrt\""), ("b.pbrt", b"\nInclude \"a.pbrt\"")]);
    let said = lines(&read_str("s.pbrt", "WorldBegin\nInclude \"a.pbrt\"\nInclude \"c.pbrt\"", &options));
    assert_eq!(
        said,
        [
            "b.pbrt:2:10 error: `a.pbrt` includes itself | `s.pbrt`, which includes `a.pbrt`, which includes `b.pbrt`, which includes `a.pbrt`",
            "s.pbrt:3:10 error: there is no file `c.pbrt` | did you mean `a.pbrt`? | looked in the working folder",
        ]
    );
    assert_eq!(world("Shape \"plymesh\""), ["s.pbrt:2:8 error: `plymesh` needs a `filename`"]);
}

#[test]
fn absurd_lengths_are_refused_quickly() {
    let begun = std::time::Instant::now();
    let long = "x".repeat(10_000_000);
    assert_eq!(world(&format!("Shape \"{long}\"")), ["s.pbrt:2:7 error: a string of 10000000 bytes; none is longer than 16384"]);
    assert_eq!(world(&long), ["s.pbrt:2:1 error: a word of 10000000 bytes; none is longer than 16384"]);
    let digits = "1".repeat(10_000_000);
    assert_eq!(world(&format!("Shape \"sphere\" \"float radius\" [{digits}]")).len(), 1);
    let deep = world(&"AttributeBegin ".repeat(1_000_000));
    assert_eq!(deep[0], "s.pbrt:2:15001 error: blocks are nested more than 1000 deep");
    let broken = world(&"oops \" ".repeat(1_000_000));
    assert!(broken.len() < 250, "{}", broken.len());
    // Far above what it takes, far below what a quadratic reader would.
    assert!(begun.elapsed().as_secs() < 60);
}
