//! What `render` writes: files, layers, headers, numbers, and words.

use crate::Bench;

#[test]
fn nothing_said_is_the_cornell_box() {
    let bench = Bench::new();
    let said = bench.good(&["render", "--width", "16", "--spp", "2"]);
    assert_eq!(bench.files(), ["cornell-box.exr", "cornell-box.png"]);
    said.says(&["wrote cornell-box.exr and cornell-box.png", "16 x 16 pixels", "paths/s", "rays/s", "peak memory"]);
    assert!(!said.err.contains("100 %") && said.out.is_empty());
    let said = bench.good(&["render", "--width", "16", "--spp", "2", "--quiet"]);
    assert!(said.out.is_empty() && said.err.is_empty(), "{}{}", said.out, said.err);
}

#[test]
fn every_built_in_scene_renders() {
    let bench = Bench::new();
    let names = bench.good(&["scenes"]).out;
    for name in names.lines().filter_map(|l| l.split_whitespace().next()) {
        let said = bench.good(&["render", name, "--width", "16", "--height", "16", "--spp", "4", "-o", "a.exr"]);
        let image = bench.picture("a.exr").image;
        assert_eq!((image.width(), image.height()), (16, 16), "{name}");
        assert!(image.data().iter().all(|x| x.is_finite()) && image.data().iter().any(|x| *x > 0.0), "{name} is black");
        assert!(!said.err.contains("warning"), "{name}: {}", said.err);
    }
}

#[test]
fn statistics_hold_what_scripts_rely_on() {
    let bench = Bench::new();
    bench.good(&["render", "--width", "16", "--spp", "3", "--threads", "2", "-o", "a.exr", "--stats", "s.json"]);
    let stats = bench.json("s.json");
    for (name, value) in [("width", 16), ("height", 16), ("spp", 3), ("threads", 2), ("paths", 768), ("triangles", 32)] {
        assert_eq!(stats[name].as_u64(), Some(value), "{name}: {stats}");
    }
    assert_eq!(stats["solver"], "path-mis");
    assert_eq!(stats["nonfinite_samples"].as_u64(), Some(0));
    assert!(stats["rays"].as_u64() > stats["paths"].as_u64() && stats["peak_memory_bytes"].is_u64());
    for name in ["load_seconds", "build_seconds", "render_seconds"] {
        assert!(stats[name].as_f64().is_some_and(|x| x >= 0.0), "{name}: {stats}");
    }
    let data = bench.picture("a.exr").image;
    for channel in 0..3 {
        let mean = data.pixels().map(|p| f64::from(p[channel])).sum::<f64>() / 256.0;
        assert!((stats["mean"][channel].as_f64().unwrap_or(-1.0) - mean).abs() < 1e-6);
    }
}

#[test]
fn the_header_says_how_it_was_made() {
    let bench = Bench::new();
    bench.good(&["render", "--width", "16", "--spp", "3", "--seed", "5", "--max-depth", "4", "-o", "a.exr"]);
    let attributes = bench.picture("a.exr").attributes;
    let word = |name: &str| attributes.iter().find(|(n, _)| n == name).map(|(_, w)| w.as_str());
    assert_eq!(word("software"), Some(concat!("etendue ", env!("CARGO_PKG_VERSION"))));
    assert_eq!((word("scene"), word("solver")), (Some("cornell-box"), Some("path-mis")));
    assert_eq!((word("samples-per-pixel"), word("seed"), word("max-depth")), (Some("3"), Some("5"), Some("4")));
    let bytes = bench.read("a.exr");
    assert!(bytes.windows(14).any(|w| w == b"chromaticities"));
}

#[test]
fn every_format_and_layers() {
    let bench = Bench::new();
    let files = ["a.exr", "a.hdr", "a.pfm", "a.png", "a.jpg", "zwei Wörter 画像.exr"];
    let outputs: Vec<&str> = files.iter().flat_map(|f| ["-o", f]).collect();
    bench.good(&[&["render", "--width", "16", "--spp", "1", "--aov", "albedo,depth,normal"], outputs.as_slice()].concat());
    let mut sorted = files.map(str::to_owned);
    sorted.sort();
    assert_eq!(bench.files(), sorted);
    assert_eq!(bench.read("a.exr"), bench.read(files[5]));
    let picture = bench.picture("a.exr");
    let layers: Vec<_> = picture.layers.iter().map(|l| (l.name.as_str(), l.image.channels().concat())).collect();
    assert_eq!(layers, [("albedo", "RGB".to_owned()), ("depth", "T".to_owned()), ("normal", "XYZ".to_owned())]);
}

const SPHERE: &str = r#"<scene version="3.0.0">
    INTEGRATOR
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="17"/><integer name="height" value="17"/>
            FILM
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere"/>
    <emitter type="constant"/>
</scene>"#;

fn sphere(bench: &Bench, integrator: &str, film: &str) {
    bench.write("sphere.xml", SPHERE.replace("INTEGRATOR", integrator).replace("FILM", film));
    bench.good(&["render", "sphere.xml", "-o", "a.exr", "--spp", "4", "--stats", "s.json"]);
}

/// The layers that a file names, under its names; `depth` and an `aov` without light fill the picture itself.
#[test]
fn layers_of_the_file() {
    let bench = Bench::new();
    let aov = r#"<integrator type="aov"><string name="aovs" value="far:depth, nn:sh_normal, s:shape_index"/>LIGHT</integrator>"#;
    sphere(&bench, &aov.replace("LIGHT", r#"<integrator type="path"/>"#), "");
    let picture = bench.picture("a.exr");
    let layers: Vec<_> = picture.layers.iter().map(|l| (l.name.as_str(), l.image.channels().concat())).collect();
    assert_eq!(layers, [("far", "T".to_owned()), ("nn", "XYZ".to_owned()), ("s", "I".to_owned())]);
    let centre = |layer: &str| {
        let layer = picture.layers.iter().find(|l| l.name == layer).expect("the layer is there");
        layer.image.pixel(8, 8).to_vec()
    };
    // The sphere's front is 4 away from the eye, and faces it; a pixel is 0.37 of it wide.
    assert!((centre("far")[0] - 4.0).abs() < 0.02, "{:?}", centre("far"));
    assert!((centre("nn")[2] - 1.0).abs() < 0.01, "{:?}", centre("nn"));
    assert_eq!(bench.json("s.json")["solver"], "path-mis");

    sphere(&bench, r#"<integrator type="depth"/>"#, "");
    assert!(bench.picture("a.exr").image.pixel(8, 8).iter().all(|x| (x - 4.0).abs() < 0.02));
    sphere(&bench, &aov.replace("LIGHT", ""), "");
    assert!((bench.picture("a.exr").image.pixel(8, 8)[0] - 4.0).abs() < 0.02);

    let twice = r#"<integrator type="aov"><string name="aovs" value="a:depth, a:uv"/></integrator>"#;
    bench.write("sphere.xml", SPHERE.replace("INTEGRATOR", twice).replace("FILM", ""));
    bench.bad(1, &["render", "sphere.xml"]).says(&["two layers", "`a`"]);
}

/// A crop window is a window: the same numbers as in the whole picture. One channel is luminance.
#[test]
fn crops_and_luminance() {
    let bench = Bench::new();
    sphere(&bench, "", "");
    let whole = bench.picture("a.exr").image;
    let crop = r#"<integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="5"/>
                  <integer name="crop_width" value="7"/><integer name="crop_height" value="4"/>"#;
    sphere(&bench, "", crop);
    let part = bench.picture("a.exr").image;
    assert_eq!((part.width(), part.height()), (7, 4));
    for (x, y) in [(0, 0), (6, 3), (3, 2)] {
        assert_eq!(part.pixel(x, y), whole.pixel(x + 3, y + 5));
    }
    bench
        .write("light.xml", SPHERE.replace("INTEGRATOR", "").replace("FILM", r#"<string name="pixel_format" value="luminance"/>"#));
    let coloured = bench.read("light.xml");
    let coloured = String::from_utf8_lossy(&coloured)
        .replace(r#"<emitter type="constant"/>"#, r#"<emitter type="constant"><rgb name="radiance" value="1, 2, 4"/></emitter>"#);
    bench.write("light.xml", coloured);
    bench.good(&["render", "light.xml", "-o", "y.exr", "-o", "y.png", "--spp", "1"]);
    let image = bench.picture("y.exr").image;
    assert_eq!(image.channels(), ["Y"]);
    // The surroundings, seen in the corner: 0.2126 + 2 · 0.7152 + 4 · 0.0722.
    assert!((image.pixel(0, 0)[0] - 1.9318).abs() < 1e-4, "{:?}", image.pixel(0, 0));
}

/// Light of 0, 1, 2 and more bounces adds up to all light.
#[test]
fn bounces_add_up() {
    let bench = Bench::new();
    let mean = |bounces: &str| {
        bench.good(&["render", "furnace", "--width", "8", "--spp", "64", "-o", "a.exr", "--stats", "s.json", "--bounces", bounces]);
        bench.json("s.json")["mean"][0].as_f64().expect("a mean")
    };
    // Emission 1 and albedo 1/2: every bounce brings half of what the one before brought.
    for (bounces, want) in [("0", 1.0), ("1", 0.5), ("1..2", 0.75), ("2..", 0.5), ("0..", 2.0)] {
        assert!((mean(bounces) / want - 1.0).abs() < 0.05, "{bounces}: {} against {want}", mean(bounces));
    }
}

#[test]
fn a_black_picture_says_why() {
    let bench = Bench::new();
    let dark = SPHERE.replace("INTEGRATOR", "").replace("FILM", "").replace("<emitter type=\"constant\"/>", "");
    bench.write("dark.xml", &dark);
    bench.good(&["render", "dark.xml", "-o", "a.exr", "--spp", "1"]).says(&["black", "no emitter"]);
    let behind = SPHERE.replace("INTEGRATOR", "").replace("FILM", "").replace("target=\"0, 0, 0\"", "target=\"0, 0, 9\"");
    let behind = behind.replace("<emitter type=\"constant\"/>", "<emitter type=\"point\"/>");
    bench.write("behind.xml", behind);
    bench.good(&["render", "behind.xml", "-o", "a.exr", "--spp", "1"]).says(&["black", "behind"]);
    bench
        .good(&["render", "furnace", "-o", "a.exr", "--spp", "1", "--width", "8", "--solver", "direct", "--bounces", "7"])
        .says(&["black", "--bounces"]);
}

/// Photons of one pass are forgotten by the next.
#[test]
fn a_photon_map_takes_no_more_memory_for_more_passes() {
    let bench = Bench::new();
    let peak = |spp: &str| {
        bench.good(&[
            "render",
            "--solver",
            "photon-map",
            "--width",
            "48",
            "--threads",
            "2",
            "--spp",
            spp,
            "-o",
            "a.exr",
            "--stats",
            "a.json",
        ]);
        bench.json("a.json")["peak_memory_bytes"].as_f64().expect("a number")
    };
    let (few, many) = (peak("10"), peak("300"));
    assert!(many <= 1.15 * few, "{few} bytes at 10 passes, {many} at 300");
}
