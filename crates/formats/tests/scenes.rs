//! What scenes say arrives as they say it.

mod common;

use common::{good, lines, scene, with_files};
use etendue_description::{Kind, NodeId, SpectrumValue, Value};
use etendue_formats::{ReadOptions, read, read_str};
use glam::{DMat4, DVec3, DVec4};

/// The values of the first object's parameters.
fn params(body: &str) -> Vec<(String, Value)> {
    let description = good(&scene(&format!("<shape type=\"s\">{body}</shape>")), &ReadOptions::default());
    description.nodes[0].params.iter().map(|p| (p.name.value.clone(), p.value.value.clone())).collect()
}

fn value(element: &str) -> Value {
    params(element).remove(0).1
}

#[test]
fn values_of_every_type() {
    assert_eq!(value("<boolean name=\"a\" value=\"TRUE\"/>"), Value::Bool(true));
    assert_eq!(value("<integer name=\"a\" value=\" -12 \"/>"), Value::Integer(-12));
    assert_eq!(value("<float name=\"a\" value=\"1e-3\"/>"), Value::Float(1e-3));
    assert_eq!(value("<float name=\"a\" value=\"inf\"/>"), Value::Float(f64::INFINITY));
    assert_eq!(value("<string name=\"a\" value=\"&lt;&#228;&#x7bb1;&gt; b\"/>"), Value::String("<ä箱> b".into()));
    assert_eq!(value("<point name=\"a\" x=\"1\" y=\"2\" z=\"3\"/>"), Value::Vector(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(value("<vector name=\"a\" value=\"1,2 , 3\"/>"), Value::Vector(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(value("<vector name=\"a\" value=\"2\"/>"), Value::Vector(DVec3::splat(2.0)));
    assert_eq!(value("<rgb name=\"a\" value=\"0.2,0.8,0.1 \"/>"), Value::Rgb([0.2, 0.8, 0.1]));
    assert_eq!(value("<rgb name=\"a\" value=\"0.5\"/>"), Value::Rgb([0.5; 3]));
    assert_eq!(value("<spectrum name=\"a\" value=\"0.5\"/>"), Value::Spectrum(SpectrumValue::Constant(0.5)));
    assert_eq!(
        value("<spectrum name=\"a\" value=\"400:0.1,500:0.2\"/>"),
        Value::Spectrum(SpectrumValue::Samples(vec![(400.0, 0.1), (500.0, 0.2)]))
    );
    let black = |scale| Value::Spectrum(SpectrumValue::Blackbody { kelvin: 5000.0, scale });
    assert_eq!(value("<blackbody name=\"a\" temperature=\"5000K\" scale=\"2\"/>"), black(2.0));
    assert_eq!(
        value("<spectrum name=\"a\" type=\"blackbody\"><float name=\"temperature\" value=\"5000\"/></spectrum>"),
        black(1.0)
    );
    let Value::Rgb([r, g, b]) = value("<rgb name=\"a\" value=\"#ff8000\"/>") else { panic!("no colour") };
    assert!(r == 1.0 && b == 0.0 && (g - 0.215_860_5).abs() < 1e-6, "{g}");
}

#[test]
fn transforms_apply_in_the_order_written() {
    let matrix = |steps: &str| match value(&format!("<transform name=\"t\">{steps}</transform>")) {
        Value::Transform(t) => t.matrix(),
        other => panic!("{other:?}"),
    };
    let near = |a: DMat4, b: DMat4| assert!(a.abs_diff_eq(b, 1e-12), "{a} {b}");
    let turn = DMat4::from_rotation_z(90f64.to_radians());
    near(
        matrix("<translate x=\"1\"/><rotate z=\"1\" angle=\"90\"/><scale value=\"2\"/>"),
        DMat4::from_scale(DVec3::splat(2.0)) * turn * DMat4::from_translation(DVec3::X),
    );
    near(matrix("<scale x=\"2\" z=\"3\"/>"), DMat4::from_scale(DVec3::new(2.0, 1.0, 3.0)));
    near(matrix("<matrix value=\"0 -1 0  1 0 0  0 0 1\"/>"), turn);
    let m = matrix("<matrix value=\"1 0 0 7, 0 1 0 8, 0 0 1 9, 0 0 0 1\"/>");
    near(m, DMat4::from_translation(DVec3::new(7.0, 8.0, 9.0)));
    near(matrix(""), DMat4::IDENTITY);
    // A camera looks along its z, its y is up, its x points left.
    let camera = matrix("<lookat origin=\"1 2 3\" target=\"1, 2, -5\" up=\"0 3 0.5\"/>");
    let columns = [DVec4::new(-1.0, 0.0, 0.0, 0.0), DVec4::Y, DVec4::new(0.0, 0.0, -1.0, 0.0), DVec4::new(1.0, 2.0, 3.0, 1.0)];
    near(camera, DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]));
    // Without `up` any will do, as long as the frame is one.
    let camera = matrix("<lookat origin=\"0 0 0\" target=\"1 2 3\"/>");
    assert!((camera.determinant() - 1.0).abs() < 1e-12 && (camera * camera.transpose()).abs_diff_eq(DMat4::IDENTITY, 1e-12));
}

#[test]
fn objects_nest_and_refer() {
    let text = scene(
        "<shape type=\"sphere\" id=\"ball\"><ref id=\"white\"/><bsdf type=\"mask\" name=\"second\"><ref name=\"inner\" id=\"w\"/></bsdf></shape>\
         <alias id=\"white\" as=\"w\"/><bsdf type=\"diffuse\" id=\"white\"/><ref id=\"white\"/>\
         <integrator type=\"path\"/><sensor type=\"a\"><film type=\"b\"><rfilter type=\"c\"/></film><sampler type=\"d\"/></sensor>\
         <emitter type=\"e\"/><texture type=\"f\"/><medium type=\"g\"><phase type=\"h\"/><volume type=\"i\"/></medium>",
    );
    let d = good(&text, &ReadOptions::default());
    let kinds: Vec<Kind> = d.nodes.iter().map(|n| n.kind).collect();
    use Kind::*;
    assert_eq!(kinds, [Shape, Bsdf, Bsdf, Integrator, Sensor, Film, Filter, Sampler, Emitter, Texture, Medium, Phase, Volume]);
    assert_eq!(d.top, [0, 2, 3, 4, 8, 9, 10].map(NodeId));
    let children: Vec<_> = d.nodes[0].params.iter().map(|p| (p.name.value.as_str(), p.value.value.clone())).collect();
    assert_eq!(children, [("", Value::Node(NodeId(2))), ("second", Value::Node(NodeId(1)))]);
    assert_eq!(d.nodes[1].params[0].value.value, Value::Node(NodeId(2)));
    assert_eq!(d.nodes[0].id.as_ref().map(|id| id.value.as_str()), Some("ball"));
    // Places: the model's word, the reference's id, the whole object.
    let source = d.sources.text(d.nodes[0].span.source);
    let at = |s: etendue_description::Span| &source[s.start as usize..s.end as usize];
    assert_eq!(at(d.nodes[0].model.span), "sphere");
    assert_eq!(at(d.nodes[0].params[0].value.span), "white");
    assert!(at(d.nodes[0].span).starts_with("<shape") && at(d.nodes[0].span).ends_with("</shape>"));
}

#[test]
fn parameters_fill_in() {
    let text = scene(
        "<default name=\"a\" value=\"1\"/><default name=\"ab\" value=\"$a.5\"/><default name=\"kind\" value=\"path\"/>\
         <integrator type=\"$kind\"><float name=\"x\" value=\"$ab\"/><string name=\"y\" value=\"$abc-\\$a-$a$a\"/></integrator>",
    );
    let values = |defines: &[(&str, &str)]| {
        let defines = defines.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        let d = good(&text, &ReadOptions { defines, ..ReadOptions::default() });
        let values: Vec<Value> = d.nodes[0].params.iter().map(|p| p.value.value.clone()).collect();
        (d.nodes[0].model.value.clone(), values)
    };
    assert_eq!(values(&[]), ("path".into(), vec![Value::Float(1.5), Value::String("1.5c-$a-11".into())]));
    assert_eq!(
        values(&[("a", "9"), ("a", "2"), ("kind", "direct")]),
        ("direct".into(), vec![Value::Float(2.5), Value::String("2.5c-$a-22".into())])
    );
}

#[test]
fn includes_share_parameters_paths_and_names() {
    let options = with_files(&[
        ("parts/lamp.xml", b"<scene version=\"3.0.0\"><default name=\"n\" value=\"3\"/><emitter type=\"$e\" id=\"lamp\"/></scene>"),
        ("parts/one.xml", b"<bsdf version=\"2.1.0\" type=\"diffuse\" id=\"one\"/>"),
        ("parts/pic.png", b"png"),
    ]);
    let text = scene(
        "<default name=\"e\" value=\"point\"/><path value=\"parts\"/><include filename=\"lamp.xml\"/>\
         <shape type=\"cube\"><integer name=\"i\" value=\"$n\"/><include filename=\"one.xml\" name=\"b\"/><ref id=\"lamp\"/></shape>\
         <texture type=\"bitmap\"><string name=\"filename\" value=\"pic.png\"/></texture>",
    );
    let d = good(&text, &options);
    let models: Vec<&str> = d.nodes.iter().map(|n| n.model.value.as_str()).collect();
    assert_eq!(models, ["point", "cube", "diffuse", "bitmap"]);
    let shape: Vec<_> = d.nodes[1].params.iter().map(|p| (p.name.value.as_str(), p.value.value.clone())).collect();
    assert_eq!(shape, [("i", Value::Integer(3)), ("b", Value::Node(NodeId(2))), ("", Value::Node(NodeId(0)))]);
    assert_eq!(d.nodes[3].params[0].value.value, Value::Path("parts/pic.png".into()));
    assert_eq!(&*d.assets.files[std::path::Path::new("parts/pic.png")], b"png");
}

#[test]
fn meshes_are_read_once_and_found_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let sub = folder.path().join("größe 箱");
    std::fs::create_dir(&sub).unwrap();
    std::fs::write(sub.join("tri angle.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n").unwrap();
    let shape =
        |more: &str| format!("<shape type=\"obj\"><string name=\"filename\" value=\"größe 箱/tri angle.obj\"/>{more}</shape>");
    let text = scene(&(shape("") + &shape("<boolean name=\"flip_tex_coords\" value=\"false\"/>") + &shape("")));
    // A mark at the beginning and Windows line ends change nothing.
    let file = folder.path().join("scène.xml");
    std::fs::write(&file, format!("\u{feff}{}", text.replace("><", ">\r\n<"))).unwrap();
    let result = read(&file, &ReadOptions::default());
    assert_eq!(lines(&result), Vec::<String>::new());
    let d = result.0;
    let meshes: Vec<_> = d.nodes.iter().map(|n| n.params[0].value.value.clone()).collect();
    assert_eq!(meshes, [Value::Mesh(0), Value::Mesh(1), Value::Mesh(0)]);
    assert_eq!((d.assets.meshes[0].uvs[0].y, d.assets.meshes[1].uvs[0].y), (0.75, 0.25));
    assert_eq!(d.assets.meshes[0].path, sub.join("tri angle.obj"));
}

#[test]
fn mistakes_in_meshes_point_into_them() {
    let options = with_files(&[
        ("bad.obj", b"# one\nv 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 9\nf 1 2 x\n"),
        ("bad.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_index\nend_header\nabcd"),
        ("flat.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nvn 0 0 0\nf 1 2 3\nf 1//1 2//1 4//1\n"),
        ("bad.spd", b"400 1\n# two\n500 one\n"),
    ]);
    let text = scene(
        "<shape type=\"obj\"><string name=\"filename\" value=\"bad.obj\"/><spectrum name=\"s\" filename=\"bad.spd\"/></shape>\n\
         <shape type=\"ply\"><string name=\"filename\" value=\"bad.ply\"/></shape>\n<shape type=\"obj\"><string name=\"filename\" value=\"flat.obj\"/></shape>\n\
         <shape type=\"serialized\"><string name=\"filename\" value=\"bad.ply\"/><integer name=\"shape_index\" value=\"-1\"/></shape>\n\
         <shape type=\"obj\"><string name=\"filename\" value=\"bat.obj\"/></shape>",
    );
    let result = read_str("s.xml", &text, &options);
    assert_eq!(
        lines(&result),
        [
            "bad.spd:3:5 error: `one` is no finite number",
            "s.xml:4:102 error: `shape_index` of `serialized` must be a whole number from 0",
            "s.xml:5:50 error: there is no file `bat.obj` | did you mean `bad.obj`? | looked in the working folder",
            "bad.obj:3:5 error: `nan` is no finite number",
            "bad.obj:5:7 error: vertex 9 does not exist, there are 3",
            "bad.obj:6:7 error: `x` is no corner of a face, expected v, v/vt, v//vn or v/vt/vn",
            "s.xml:2:50 error: `bad.ply`, byte 167: the header promises 9 of element `vertex`, at least 108 bytes, and 4 bytes follow",
            "s.xml:3:50 warning: `flat.obj`: 1 of 2 triangles have no area and are left out: 0 (from 0; those that stay are numbered without them)",
            "s.xml:3:50 warning: `flat.obj`: 3 vertex normals are zero or not finite; those of the faces around take their place",
            "s.xml:4:57 error: `bad.ply`, byte 0: no serialized mesh begins here (0x041C expected)",
        ]
    );
    let shown = result.1.render(&result.0.sources);
    assert!(shown.contains("3 | v 1 nan 0\n  |     ^^^\n") && shown.contains("the file is named here"), "{shown}");
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let names: Vec<String> = (0..40).map(|i| format!("m{i}.obj")).collect();
    let texts: Vec<String> =
        (0..40).map(|i| format!("v 0 0 {i}\nv 1 0 0\nv 0 1 0\n{}f 1 2 3\n", if i % 7 == 3 { "f 1 1 2\n" } else { "" })).collect();
    let files: Vec<(&str, &[u8])> = names.iter().zip(&texts).map(|(n, t)| (n.as_str(), t.as_bytes())).collect();
    let options = with_files(&files);
    let shape = |name: &String| format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>\n");
    let text = scene(&names.iter().map(shape).collect::<String>());
    let at = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (d, diagnostics) = pool.install(|| read_str("s.xml", &text, &options));
        let paths: Vec<_> = d.assets.meshes.iter().map(|m| (m.path.clone(), m.positions[0])).collect();
        (paths, diagnostics.render(&d.sources))
    };
    assert_eq!(at(1), at(4));
    assert_eq!(at(4).0.len(), 40);
}
