//! `--per-light`: a picture for each light, and their sum.

use super::Bench;

const SCENE: &str = r#"<scene version="3.0.0">
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 2, -4" target="0, 0.5, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="16"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform></shape>
    <shape type="sphere" id="lamp"><point name="center" value="0, 1, 0"/><float name="radius" value="0.4"/>
        <emitter type="area"><rgb name="radiance" value="2, 1, 0.5"/></emitter></shape>
    <emitter type="point" id="key.light"><point name="position" value="1, 2, -1"/></emitter>
    <emitter type="constant"><rgb name="radiance" value="0.1, 0.2, 0.3"/></emitter>
    <emitter type="constant"><rgb name="radiance" value="0.05"/></emitter>
</scene>"#;

#[test]
fn a_layer_or_a_file_for_each_light() {
    let bench = Bench::new();
    bench.write("s.xml", SCENE);
    let arguments =
        ["render", "s.xml", "--spp", "8", "--per-light", "--aov", "depth", "-o", "a.exr", "-o", "a.png", "--stats", "a.json"];
    bench.good(&arguments).says(&["light 2 of 4: key_light"]);
    let lights = ["lamp", "key_light", "constant", "constant-2"];
    let mut files = vec!["a.exr".to_owned(), "a.png".to_owned(), "a.json".to_owned(), "s.xml".to_owned()];
    files.extend(lights.iter().map(|l| format!("a.{l}.png")));
    files.sort();
    assert_eq!(bench.files(), files);

    // The picture is the sum, to the bit.
    let picture = bench.picture("a.exr");
    let names: Vec<_> = picture.layers.iter().map(|l| l.name.as_str()).collect();
    let mut expected = lights.to_vec();
    expected.push("depth");
    expected.sort_unstable();
    assert_eq!(names, expected);
    let layer = |name: &str| picture.layer(name).expect("a layer").data();
    for (i, all) in picture.image.data().iter().enumerate() {
        let sum = lights.iter().skip(1).fold(layer("lamp")[i], |sum, light| sum + layer(light)[i]);
        assert_eq!(sum.to_bits(), all.to_bits());
    }
    let stats = bench.json("a.json");
    for (i, light) in lights.iter().enumerate() {
        assert_eq!(stats["lights"][i]["name"], *light);
        assert!(stats["lights"][i]["mean"][2].as_f64().is_some_and(|m| m > 0.0));
    }
    assert_eq!(stats["paths"], 4 * 8 * 20 * 16);

    // And nearly what all make together.
    bench.good(&["render", "s.xml", "--spp", "64", "-o", "b.exr"]);
    let mean = |name: &str| bench.picture(name).image.data().iter().map(|x| f64::from(*x)).sum::<f64>();
    assert!((mean("a.exr") / mean("b.exr") - 1.0).abs() < 0.02);
}

#[test]
fn what_has_no_lights_to_tell_apart() {
    let bench = Bench::new();
    bench.write("s.xml", SCENE);
    bench.write("dark.xml", r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere"/></scene>"#);
    bench.bad(1, &["render", "dark.xml", "--per-light"]).says(&["no lights"]);
    bench.bad(1, &["render", "s.xml", "--per-light", "--solver", "depth"]).says(&["shows no light"]);
    bench.bad(1, &["render", "s.xml", "--per-light", "--solver", "whitted", "--param", "ambient=1"]).says(&["belongs to no light"]);
    bench.bad(2, &["render", "s.xml", "--per-light", "--checkpoint", "c"]).says(&["cannot be used with"]);
    let lamp = SCENE.replace("key.light", "depth");
    bench.write("named.xml", lamp);
    bench.bad(1, &["render", "named.xml", "--per-light", "--aov", "depth"]).says(&["two layers", "`depth`"]);
}
