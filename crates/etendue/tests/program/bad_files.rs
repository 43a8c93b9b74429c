//! Files with mistakes: one clear message each with file, line, column, the word at fault and the nearest good one; exit status 1, no
//! panic, no picture.

use crate::Bench;

/// A scene without a mistake.
const GOOD: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="16"/>
            <integer name="height" value="16"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="white">
        <rgb name="reflectance" value="0.5"/>
    </bsdf>
    <shape type="sphere">
        <ref id="white"/>
        <emitter type="area"><rgb name="radiance" value="1"/></emitter>
    </shape>
</scene>
"#;

/// The good scene with one thing replaced.
fn with(old: &str, new: &str) -> String {
    assert!(GOOD.contains(old), "{old}");
    GOOD.replacen(old, new, 1)
}

/// The good scene with a mesh in place of its sphere.
fn with_mesh(kind: &str, file: &str) -> String {
    with(r#"<shape type="sphere">"#, &format!(r#"<shape type="{kind}"><string name="filename" value="{file}"/>"#))
}

/// Renders `scene`, expects a refusal with these words and no picture.
#[track_caller]
fn refused(bench: &Bench, scene: &str, words: &[&str]) {
    bench.write("scene.xml", scene);
    let said = bench.bad(1, &["render", "scene.xml", "-o", "picture.exr", "--spp", "1"]);
    said.says(words);
    assert!(!bench.has("picture.exr"), "a picture was written");
    assert!(!bench.files().iter().any(|f| f.ends_with(".part")), "{:?}", bench.files());
}

#[test]
fn the_good_scene_is_good() {
    let bench = Bench::new();
    bench.write("scene.xml", GOOD);
    bench.good(&["render", "scene.xml", "-o", "picture.exr", "--spp", "1"]);
    assert!(bench.has("picture.exr"));
}

#[test]
fn names_that_nothing_has() {
    let bench = Bench::new();
    refused(&bench, &with("\"sphere\"", "\"spere\""), &["scene.xml:13:18: error: unknown shape `spere`", "did you mean `sphere`?"]);
    refused(&bench, &with("\"diffuse\"", "\"difuse\""), &["scene.xml:10:17: error: ", "`difuse`", "did you mean `diffuse`?"]);
    refused(&bench, &with("\"path\"", "\"pth\""), &["scene.xml:2:23: error: ", "`pth`", "did you mean `path`?"]);
    refused(
        &bench,
        &with("reflectance", "reflectence"),
        &["scene.xml:11:20: error: ", "`reflectence`", "did you mean `reflectance`?"],
    );
    refused(
        &bench,
        &with("<ref id=\"white\"/>", "<ref id=\"whit\"/>"),
        &["scene.xml:14:18: error: ", "`whit`", "did you mean `white`?"],
    );
    refused(&bench, &with("<shape", "<shap"), &["scene.xml:", "error: "]);
}

#[test]
fn values_of_a_wrong_type_or_range() {
    let bench = Bench::new();
    let width = r#"<integer name="width" value="16"/>"#;
    refused(
        &bench,
        &with(width, r#"<string name="width" value="16"/>"#),
        &["scene.xml:6:41: error: `width` of `hdrfilm` is a string"],
    );
    refused(&bench, &with(width, r#"<integer name="width" value="wide"/>"#), &["scene.xml:6:42: error: `wide` is no whole number"]);
    for absurd in ["0", "2147483300", "-5"] {
        let film = format!(r#"<integer name="width" value="{absurd}"/>"#);
        refused(&bench, &with(width, &film), &["scene.xml:6:42: error: `width` of `hdrfilm`", absurd, "expected 1 to"]);
    }
    let filter = r#"<film type="hdrfilm"><rfilter type="tent"><float name="radius" value="2147483300"/></rfilter>"#;
    refused(&bench, &with(r#"<film type="hdrfilm">"#, filter), &["scene.xml:5:79: error: `radius` of `tent`", "2147483300", "32"]);
    refused(&bench, &with(r#"value="0.5"/>"#, r#"value="nan"/>"#), &["scene.xml:11:40: error: ", "`nan`"]);
}

#[test]
fn xml_that_is_broken() {
    let bench = Bench::new();
    refused(&bench, &with(r#"id="white">"#, r#"id="white>"#), &["scene.xml:10:29: error: ", "`id`", "quote"]);
    refused(&bench, &with("</sensor>", ""), &["scene.xml:3:5: error: `<sensor>` is never closed"]);
    refused(&bench, "", &["scene.xml:1:1: error: "]);
    refused(&bench, "\u{0}\u{1}binary", &["scene.xml:1:1: error: "]);
    refused(&bench, &with("3.0.0", "0.5.0"), &["scene.xml:1:17: error: ", "upgrade"]);
    refused(&bench, &"<shape type=\"sphere\">".repeat(100_000), &["scene.xml:", "error: "]);
}

#[test]
fn circles() {
    let bench = Bench::new();
    let circle = with(r#"<rgb name="reflectance" value="0.5"/>"#, r#"<ref id="white"/>"#);
    refused(&bench, &circle, &["scene.xml:11:18: error: `white` contains itself"]);
    refused(
        &bench,
        &with("<integrator", "<include filename=\"scene.xml\"/><integrator"),
        &["scene.xml:2:24: error: `scene.xml` includes itself"],
    );
}

#[test]
fn files_that_are_missing_or_something_else() {
    let bench = Bench::new();
    bench.write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.write("text.png", "this is no picture\n");
    refused(
        &bench,
        &with_mesh("obj", "bal.obj"),
        &["scene.xml:13:54: error: there is no file `bal.obj`", "did you mean `ball.obj`?"],
    );
    let texture = r#"<texture type="bitmap" name="reflectance"><string name="filename" value="text.png"/></texture>"#;
    refused(
        &bench,
        &with(r#"<rgb name="reflectance" value="0.5"/>"#, texture),
        &["scene.xml:11:82: error: ", "text.png", "no picture"],
    );
    bench.bad(1, &["render", "nothing.xml"]).says(&["nothing.xml"]);
    bench.bad(1, &["render", "cornel-box"]).says(&["did you mean `cornell-box`?"]);
    bench.bad(1, &["render", "ball.obj"]).says(&["ball.obj", "mesh"]);
    bench.bad(1, &["info", "nothing.xml"]);
}

#[test]
fn meshes_with_mistakes() {
    let bench = Bench::new();
    bench.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    refused(&bench, &with_mesh("obj", "index.obj"), &["index.obj:4:7: error: vertex 4 does not exist", "scene.xml:13:54"]);
    bench.write("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    refused(&bench, &with_mesh("obj", "nan.obj"), &["nan.obj:2:5: error: `nan`"]);
    let ply = |vertex: &str, face: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0\n{vertex}\n0 1 0\n{face}\n"
        )
    };
    bench.write("inf.ply", ply("1 inf 0", "3 0 1 2"));
    refused(&bench, &with_mesh("ply", "inf.ply"), &["inf.ply:11:3: error: ", "inf"]);
    bench.write("index.ply", ply("1 0 0", "3 0 1 7"));
    refused(&bench, &with_mesh("ply", "index.ply"), &["index.ply:13:7: error: vertex 7 does not exist"]);
    bench.write("short.ply", &ply("1 0 0", "3 0 1 2")[..150]);
    refused(&bench, &with_mesh("ply", "short.ply"), &["short.ply", "error: "]);
    bench.write("empty.serialized", "");
    refused(&bench, &with_mesh("serialized", "empty.serialized"), &["empty.serialized", "error: "]);
}

/// What is odd but can be rendered is rendered, and told.
#[test]
fn zero_normals_and_zero_areas_are_harmless() {
    let bench = Bench::new();
    bench.write("odd.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\nf 1 1 2\n");
    bench.write("scene.xml", with_mesh("obj", "odd.obj"));
    let said = bench.good(&["render", "scene.xml", "-o", "picture.exr", "--spp", "4"]);
    said.says(&["scene.xml:13:54: warning: ", "no area", "normals"]);
    assert!(bench.picture("picture.exr").image.data().iter().all(|x| x.is_finite()));
    assert!(bench.picture("picture.exr").image.data().iter().any(|x| *x > 0.9), "the lamp is seen");
}

/// Two mistakes that reading finds, two that compiling finds: all are told, and nothing that merely follows from them.
#[test]
fn all_mistakes_are_told_in_one_go() {
    let bench = Bench::new();
    let scene = with("reflectance", "reflectence").replace("\"sphere\"", "\"spere\"");
    refused(&bench, &scene, &["scene.xml:11:20: error: ", "scene.xml:13:18: error: "]);
    let scene = scene.replace("<ref id=\"white\"/>", "<ref id=\"whit\"/>").replace("value=\"16\"", "value=\"x\"");
    bench.write("scene.xml", &scene);
    let said = bench.bad(1, &["render", "scene.xml"]);
    said.says(&["scene.xml:6:42: error: ", "scene.xml:7:43: error: ", "scene.xml:14:18: error: ", "scene.xml:11:20: error: "]);
    assert_eq!(said.err.matches("error: ").count(), 4, "{}", said.err);
    assert_eq!(bench.files(), ["scene.xml"]);
}

#[test]
fn media_are_refused_in_words() {
    let bench = Bench::new();
    let scene = with("<emitter", r#"<medium type="homogeneous" name="interior"/><emitter"#);
    refused(&bench, &scene, &["scene.xml:15:", "media", "cannot be rendered yet"]);
}

#[test]
fn parameters_of_the_command_line() {
    let bench = Bench::new();
    let scene = with("<integrator", "<default name=\"size\" value=\"8\"/><integrator").replace("value=\"16\"", "value=\"$size\"");
    bench.write("scene.xml", &scene);
    bench.good(&["render", "scene.xml", "-o", "a.exr", "--spp", "1", "-D", "size=5"]);
    assert_eq!(bench.picture("a.exr").image.width(), 5);
    bench.bad(1, &["render", "scene.xml", "-D", "sise=5"]).says(&["`sise`", "size"]);
    bench.bad(1, &["render", "scene.xml", "-D", "size=x"]).says(&["`x` is no whole number"]);
    bench.bad(2, &["render", "scene.xml", "-D", "size"]).says(&["NAME=VALUE"]);
}
