//! `etendue convert`: what it refuses, what it writes, and that the picture stays the same.

use crate::Bench;

const QUICK: [&str; 3] = ["--width", "24", "--quiet"];

/// The picture of a scene, in red, green and blue whatever its format.
fn render(bench: &Bench, scene: &str, out: &str, spp: &str) {
    bench.good(&[&["render", scene, "--rgb", "-o", out, "--spp", spp], &QUICK[..]].concat());
}

/// How far two pictures are from each other: the means of the whole and of the worst of 3 × 3 blocks, relative. Blocks darker than a
/// twentieth of the mean do not count.
fn distance(bench: &Bench, a: &str, b: &str) -> [f64; 2] {
    let pictures = [a, b].map(|name| bench.picture(name).image);
    let (w, h) = (pictures[0].width(), pictures[0].height());
    assert_eq!((w, h), (pictures[1].width(), pictures[1].height()));
    let mean = |image: &etendue_image::Image, xs: std::ops::Range<usize>, ys: std::ops::Range<usize>| {
        let n = (xs.len() * ys.len() * 3) as f64;
        let pixels = ys.flat_map(|y| xs.clone().map(move |x| (x, y)));
        pixels.map(|(x, y)| image.pixel(x, y)[..3].iter().map(|v| f64::from(*v)).sum::<f64>()).sum::<f64>() / n
    };
    let whole = mean(&pictures[0], 0..w, 0..h);
    let relative = |xs: std::ops::Range<usize>, ys: std::ops::Range<usize>| {
        let [a, b] = [0, 1].map(|i| mean(&pictures[i], xs.clone(), ys.clone()));
        if a < 0.05 * whole { 0.0 } else { (b / a - 1.0).abs() }
    };
    let cut = |i: usize, n: usize| i * n / 3..(i + 1) * n / 3;
    let blocks = (0..9).map(|k| relative(cut(k % 3, w), cut(k / 3, h)));
    [relative(0..w, 0..h), blocks.fold(0.0, f64::max)]
}

#[test]
fn wrong_names_and_files_of_others_are_refused() {
    let bench = Bench::new();
    bench.bad(2, &["convert", "furnace", "x.xnl"]).says(&["scenes ending in .xnl are not written", "did you mean `.xml`?"]);
    bench.bad(2, &["convert", "furnace", "x"]).says(&["no ending", "--to"]);
    bench.bad(2, &["convert", "furnace", "x.xml", "--to", "blender"]).says(&["expected mitsuba or pbrt"]);
    bench.bad(1, &["convert", "no-such-scene", "x.xml"]).says(&["no file and no built-in scene is called `no-such-scene`"]);
    bench.write("bad.xml", "<scene version=\"3.0.0\"><shape type=\"spere\"/></scene>");
    bench.bad(1, &["convert", "bad.xml", "x.xml"]).says(&["bad.xml:1:37: error: unknown shape `spere`"]);
    bench.good(&["convert", "furnace", "a.xml"]);
    bench.bad(2, &["convert", "a.xml", "./a.xml"]).says(&["written over itself"]);
    bench.bad(1, &["convert", "furnace", "none/a.xml"]).says(&["cannot write none/a.xml"]);

    // What étendue wrote it may write again; what it did not, by force only.
    bench.good(&["convert", "veach-mis", "a.xml"]);
    bench.write("theirs.xml", "<scene version=\"3.0.0\"/>");
    bench.bad(1, &["convert", "furnace", "theirs.xml"]).says(&["étendue did not write it", "--force"]);
    assert_eq!(bench.read("theirs.xml"), b"<scene version=\"3.0.0\"/>");
    bench.good(&["convert", "furnace", "theirs.xml", "--force"]);
    std::fs::create_dir(bench.path("b.xml-files")).unwrap();
    bench.write("b.xml-files/cornell-floor.ply", "theirs");
    bench.bad(1, &["convert", "cornell-box", "b.xml"]).says(&["cornell-floor.ply is there already"]);
    assert!(!bench.has("b.xml"));
}

#[test]
fn what_became_of_everything_is_told() {
    let bench = Bench::new();
    let said = bench.good(&["convert", "ajar", "ajar.pbrt"]);
    assert!(said.out.contains("kept") && said.out.contains("GGX: pbrt has no other"), "{}", said.out);
    assert!(said.err.contains("wrote ajar.pbrt"), "{}", said.err);
    let json: serde_json::Value =
        serde_json::from_str(&bench.good(&["convert", "ajar", "ajar.txt", "--to", "pbrt", "--json"]).out).unwrap();
    assert_eq!(json["format"], "pbrt");
    assert_eq!(json["files"][0], "ajar.txt");
    assert!(json["kept"].as_array().unwrap().iter().any(|n| n["what"] == "shape `cube`" && n["count"] == 11), "{json}");
    let how = "GGX: pbrt has no other";
    let ggx = json["approximated"].as_array().unwrap().iter().find(|n| n["how"] == how).expect("it is told");
    assert_eq!(ggx["places"][0], "ajar.xml:124:9");
    // The same scene gives the same bytes.
    bench.good(&["convert", "ajar", "again.pbrt"]);
    let without_name = |name: &str| String::from_utf8(bench.read(name)).unwrap().replace("again", "ajar");
    assert_eq!(without_name("ajar.pbrt"), without_name("again.pbrt"));
}

#[test]
fn built_in_scenes_look_the_same_in_every_format() {
    let bench = Bench::new();
    for scene in ["cornell-box", "caustic-seen", "many-lights"] {
        bench.good(&["convert", scene, "a.xml"]);
        bench.good(&["convert", "a.xml", "b.pbrt"]);
        bench.good(&["convert", "b.pbrt", "c.xml"]);
        render(&bench, scene, "original.exr", "8");
        render(&bench, "a.xml", "a.exr", "8");
        assert_eq!(bench.bits("original.exr"), bench.bits("a.exr"), "{scene}");
        for (file, picture) in [("b.pbrt", "b.exr"), ("c.xml", "c.exr")] {
            // The same numbers but for roundings, from the same random ones.
            render(&bench, file, picture, "8");
            let [mean, block] = distance(&bench, "original.exr", picture);
            assert!(mean < 1e-3 && block < 1e-2, "{scene} as {file}: {mean} {block}");
        }
    }
}

const PBRT: &str = r#"LookAt 0 2.5 4  0 .6 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 48 "integer yresolution" 36
WorldBegin
LightSource "infinite" "rgb L" [.4 .5 .6]
LightSource "distant" "blackbody L" 4000 "float scale" 2 "point3 from" [1 2 1] "point3 to" [0 0 0]
Texture "board" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 4 "rgb tex1" [.7 .6 .5] "rgb tex2" [.2 .2 .3]
Texture "marble" "spectrum" "marble" "float scale" 3
MakeNamedMaterial "floor" "string type" "coateddiffuse" "texture reflectance" "board" "float roughness" .2
Material "coateddiffuse" "rgb reflectance" [.8 .3 .1] "float roughness" 0
AttributeBegin Translate -1 .6 0 Shape "sphere" "float radius" .6 AttributeEnd
NamedMaterial "floor"
Shape "trianglemesh" "point3 P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3] "point2 uv" [0 0 1 0 1 1 0 1] "integer indices" [0 2 1 0 3 2]
Material "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" .1
AttributeBegin Translate 1 .6 0 Scale -1 1 1 Shape "sphere" "float radius" .6 AttributeEnd
Material "diffuse" "texture reflectance" "marble"
AttributeBegin Translate 0 .5 1 Rotate 30 0 1 0 Scale .4 .4 .4
AreaLightSource "diffuse" "rgb L" [2 2 1]
Shape "trianglemesh" "point3 P" [-1 0 0  1 0 0  0 1 .2] AttributeEnd
"#;

#[test]
fn pbrt_scenes_look_the_same_as_mitsuba_scenes() {
    let bench = Bench::new();
    bench.write("in.pbrt", PBRT);
    render(&bench, "in.pbrt", "in.exr", "8");
    bench.good(&["convert", "in.pbrt", "own.xml", "--own-words"]);
    bench.good(&["convert", "own.xml", "back.pbrt"]);
    bench.good(&["convert", "in.pbrt", "same.pbrt"]);
    for file in ["own.xml", "back.pbrt", "same.pbrt"] {
        render(&bench, file, "out.exr", "8");
        let [mean, block] = distance(&bench, "in.exr", "out.exr");
        assert!(mean < 1e-3 && block < 1e-2, "{file}: {mean} {block}");
    }
    // Layers without thickness, GGX of another kind, marble in its mean colour: near, and told.
    let said = bench.good(&["convert", "in.pbrt", "plain.xml"]);
    assert!(said.out.contains("`roughplastic`") && said.out.contains("its mean colour"), "{}", said.out);
    render(&bench, "in.pbrt", "in.exr", "64");
    render(&bench, "plain.xml", "plain.exr", "64");
    let [mean, block] = distance(&bench, "in.exr", "plain.exr");
    assert!(mean < 0.02 && block < 0.06, "{mean} {block}");
}

const MITSUBA: &str = r#"<scene version="3.0.0"><integrator type="path"/>
<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world"><lookat origin="0, 2.5, 4" target="0, 0.6, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="36"/></film></sensor>
<emitter type="envmap"><string name="filename" value="sky.exr"/><transform name="to_world"><rotate y="1" angle="70"/></transform></emitter>
<emitter type="spot"><rgb name="intensity" value="30, 20, 10"/><transform name="to_world"><lookat origin="2, 4, 2" target="0, 0, 0" up="0, 0, 1"/></transform></emitter>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
  <bsdf type="twosided"><bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="wood.exr"/><transform name="to_uv"><scale x="2" y="3"/></transform></texture></bsdf></bsdf></shape>
<shape type="sphere"><point name="center" x="-1" y="0.6" z="0"/><float name="radius" value="0.6"/><bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.8, 0.3, 0.1"/></bsdf></shape>
<shape type="sphere"><point name="center" x="1" y="0.6" z="0"/><float name="radius" value="0.6"/><bsdf type="roughconductor"><string name="material" value="Al"/><float name="alpha" value="0.2"/><string name="distribution" value="ggx"/><rgb name="specular_reflectance" value="0.9, 0.6, 0.4"/></bsdf></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="30"/><translate x="0" y="0.3" z="1"/></transform>
  <bsdf type="mask"><float name="opacity" value="0.7"/><bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value="0.1"/><rgb name="diffuse_reflectance" value="0.1, 0.5, 0.2"/></bsdf></bsdf></bsdf></shape>
</scene>"#;

#[test]
fn mitsuba_scenes_look_the_same_as_pbrt_scenes() {
    let bench = Bench::new();
    let picture = |name: &str, w: usize, h: usize, f: &dyn Fn(f32, f32) -> [f32; 3]| {
        let texels = (0..w * h).flat_map(|i| f((i % w) as f32 / w as f32, (i / w) as f32 / h as f32)).collect();
        let image = etendue_image::Image::rgb(w, h, texels).unwrap();
        etendue_image::save(&bench.path(name), &image.into(), &etendue_image::SaveOptions::default()).unwrap();
    };
    picture("sky.exr", 64, 33, &|u, v| [0.4 + 0.3 * u, 0.5, (1.0 - v) * 1.5]);
    // Neither its mirror image nor itself upside down.
    picture("wood.exr", 16, 16, &|u, v| [0.8 * u, 0.8 * v * v, 0.3]);
    bench.write("in.xml", MITSUBA);
    bench.good(&["convert", "in.xml", "out.pbrt"]);
    render(&bench, "in.xml", "in.exr", "64");
    render(&bench, "out.pbrt", "out.exr", "64");
    let [mean, block] = distance(&bench, "in.exr", "out.exr");
    assert!(mean < 0.02 && block < 0.06, "{mean} {block}");
}
