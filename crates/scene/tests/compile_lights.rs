//! What the compiler says of lights, cameras, films, filters and samplers: every mistake at its place, in words that help.

mod lighting;

use etendue_numerics::kernel::Kernel;
use lighting::{scene, try_scene};

/// A mistake, the text it is told at, and words that the message holds.
type Row<'a> = (&'a str, &'a str, &'a [&'a str]);

fn refused(rows: &[Row]) {
    for (inside, at, words) in rows {
        let (scene, messages) = try_scene(inside);
        let place = format!("Error at `{at}");
        let line = messages.lines().find(|line| line.starts_with(&place));
        let said = line.is_some_and(|line| words.iter().all(|word| line.contains(word)));
        assert!(scene.is_none() && said, "{inside}\nexpected an error at `{at}` with {words:?}, got\n{messages}");
    }
}

#[test]
fn mistakes_about_lights_are_told_at_their_place() {
    refused(&[
        (r#"<emitter type="pont"/>"#, "pont", &["unknown emitter", "point"]),
        (r#"<emitter type="sunsky"/>"#, "sunsky", &["skies cannot be rendered yet"]),
        (r#"<emitter type="area"/>"#, "area", &["belongs into a shape"]),
        (r#"<shape type="sphere"><emitter type="point"/></shape>"#, "point", &["does not belong to a shape"]),
        (
            r#"<emitter type="point"><rgb name="intensty" value="1"/></emitter>"#,
            "intensty",
            &["unknown parameter", "did you mean `intensity`"],
        ),
        (
            r#"<emitter type="point"><point name="position" value="1 2 3"/><transform name="to_world"><translate x="1"/></transform></emitter>"#,
            "",
            &["both `position` and `to_world`"],
        ),
        (
            r#"<emitter type="point"><float name="sampling_weight" value="-1"/></emitter>"#,
            "-1",
            &["sampling_weight", "expected 0 to"],
        ),
        (
            r#"<emitter type="constant"><texture type="checkerboard" name="radiance"/></emitter>"#,
            "",
            &["`radiance` of `constant` cannot be a texture"],
        ),
        (r#"<emitter type="directional"><vector name="direction" value="0 0 0"/></emitter>"#, "", &["has no length"]),
        (r#"<emitter type="spot"><float name="cutoff_angle" value="200"/></emitter>"#, "200", &["cutoff_angle"]),
        (
            r#"<emitter type="spot"><texture type="mesh_attribute" name="texture"><string name="name" value="vertex_color"/></texture></emitter>"#,
            "",
            &["cannot be a mesh attribute"],
        ),
        (
            r#"<emitter type="spot"><texture type="checkerboard" name="texture"><texture type="mesh_attribute" name="color0"><string name="name" value="vertex_color"/></texture></texture></emitter>"#,
            "",
            &["cannot be a mesh attribute"],
        ),
        (
            r#"<emitter type="spot"><transform name="to_world"><matrix value="1 1 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform></emitter>"#,
            "",
            &["shears"],
        ),
        (r#"<emitter type="envmap"/>"#, "envmap", &["needs a `filename`"]),
        (r#"<emitter type="projector"><float name="fov" value="180"/></emitter>"#, "180", &["less than 180"]),
    ]);
}

#[test]
fn mistakes_about_cameras_are_told_at_their_place() {
    let sensor = |inside: &str| format!(r#"<sensor type="perspective">{inside}</sensor>"#);
    let film = |inside: &str| sensor(&format!(r#"<film type="hdrfilm">{inside}</film>"#));
    let rows = [
        (r#"<sensor type="perspectve"/>"#.to_owned(), "perspectve", ["unknown sensor", "did you mean `perspective`"]),
        (r#"<sensor type="radiancemeter"/>"#.to_owned(), "radiancemeter", ["cannot be rendered", "perspective"]),
        (r#"<sensor type="thinlens"/>"#.to_owned(), "thinlens", ["aperture_radius", "needs"]),
        (sensor(r#"<float name="fov" value="0"/>"#), "0", ["more than 0", "180 degrees"]),
        (sensor(r#"<float name="fov" value="30"/><string name="focal_length" value="50mm"/>"#), "50mm", ["fov", "focal_length"]),
        (sensor(r#"<string name="focal_length" value="fifty"/>"#), "fifty", ["fifty", "50mm"]),
        (sensor(r#"<string name="fov_axis" value="diagnal"/>"#), "diagnal", ["fov_axis", "did you mean `diagonal`"]),
        (sensor(r#"<float name="near_clip" value="-1"/>"#), "-1", ["near_clip", "above zero"]),
        (
            sensor(r#"<float name="near_clip" value="5"/><float name="far_clip" value="2"/>"#),
            "5",
            ["near plane", "before the far one"],
        ),
        (sensor(r#"<transform name="to_world"><scale x="2"/></transform>"#), "", ["scales its axes", "cannot be stretched"]),
        (
            sensor(r#"<float name="shutter_open" value="1"/><float name="shutter_close" value="0"/>"#),
            "0",
            ["shutter closes", "before it opens"],
        ),
        (film(r#"<integer name="width" value="0"/>"#), "0", ["width", "expected 1 to"]),
        (
            film(r#"<integer name="width" value="1000000"/><integer name="height" value="1000000"/>"#),
            "hdrfilm",
            ["1000000 x 1000000", "GiB"],
        ),
        (
            film(
                r#"<integer name="width" value="80"/><integer name="crop_offset_x" value="70"/><integer name="crop_width" value="40"/>"#,
            ),
            "40",
            ["does not fit", "80 pixels"],
        ),
        (film(r#"<string name="pixel_format" value="rbg"/>"#), "rbg", ["pixel_format", "did you mean `rgb`"]),
        (film(r#"<rfilter type="gausian"/>"#), "gausian", ["unknown rfilter", "did you mean `gaussian`"]),
        (
            film(r#"<rfilter type="gaussian"><float name="stddev" value="2147483300"/></rfilter>"#),
            "2147483300",
            ["stddev", "expected"],
        ),
        (film(r#"<rfilter type="mitchell"><float name="A" value="1"/></rfilter>"#), "A", ["unknown parameter `A`", "mitchell"]),
        (sensor(r#"<film type="specfilm"/>"#), "specfilm", ["specfilm", "cannot be rendered"]),
        (sensor(r#"<sampler type="independnt"/>"#), "independnt", ["unknown sampler", "did you mean `independent`"]),
        (
            sensor(r#"<sampler type="independent"><integer name="sample_count" value="0"/></sampler>"#),
            "0",
            ["sample_count", "expected 1"],
        ),
        (sensor(r#"<film type="hdrfilm"/><film type="hdrfilm"/>"#), "hdrfilm", ["one film", "at the most"]),
    ];
    for (inside, at, words) in &rows {
        refused(&[(inside, at, words)]);
    }
}

#[test]
fn all_mistakes_of_a_scene_are_told_at_once() {
    let (scene, messages) = try_scene(
        r#"<emitter type="pont"/><sensor type="perspective"><float name="fov" value="0"/></sensor><emitter type="area"/>"#,
    );
    assert!(scene.is_none());
    assert_eq!(messages.lines().filter(|line| line.starts_with("Error")).count(), 3, "{messages}");
}

#[test]
fn settings_arrive_as_the_file_gives_them() {
    let film = r#"<film type="hdrfilm"><integer name="width" value="320"/><integer name="height" value="200"/>
        <integer name="crop_offset_x" value="10"/><integer name="crop_offset_y" value="20"/>
        <integer name="crop_width" value="100"/><integer name="crop_height" value="50"/>
        <string name="pixel_format" value="luminance"/><string name="component_format" value="float32"/>
        <rfilter type="mitchell"><float name="B" value="0.1"/><float name="C" value="0.2"/></rfilter></film>"#;
    let sampler =
        r#"<sampler type="multijitter"><integer name="sample_count" value="37"/><integer name="seed" value="5"/></sampler>"#;
    let scene =
        scene(&format!(r#"<sensor type="perspective">{film}{sampler}</sensor><sensor type="orthographic"/><shape type="cube"/>"#));
    let [first, second] = &scene.views[..] else { panic!("two views") };
    assert_eq!((first.film.size, first.film.crop_offset, first.film.crop_size), ([320, 200], [10, 20], [100, 50]));
    assert_eq!((first.film.channels, first.film.filter), (1, Kernel::Mitchell { b: 0.1, c: 0.2 }));
    assert_eq!((first.sampler.count, first.sampler.seed), (37, 5));
    // Mitsuba's defaults.
    assert_eq!((second.film.size, second.film.channels), ([768, 576], 3));
    assert_eq!((second.film.filter, second.sampler.count), (Kernel::Gaussian { stddev: 0.5 }, 4));
}

#[test]
fn filters_have_their_parameters_and_defaults() {
    let filter = |inside: &str| {
        let sensor = format!(r#"<sensor type="perspective"><film type="hdrfilm">{inside}</film></sensor><shape type="cube"/>"#);
        scene(&sensor).views[0].film.filter
    };
    let third = 1.0 / 3.0;
    assert_eq!(filter(r#"<rfilter type="box"/>"#), Kernel::Box { radius: 0.5 });
    assert_eq!(filter(r#"<rfilter type="tent"/>"#), Kernel::Tent { radius: 1.0 });
    assert_eq!(filter(r#"<rfilter type="tent"><float name="radius" value="0.7"/></rfilter>"#), Kernel::Tent { radius: 0.7 });
    assert_eq!(filter(r#"<rfilter type="gaussian"/>"#), Kernel::Gaussian { stddev: 0.5 });
    assert_eq!(filter(r#"<rfilter type="mitchell"/>"#), Kernel::Mitchell { b: third, c: third });
    assert_eq!(filter(r#"<rfilter type="catmullrom"/>"#), Kernel::CatmullRom);
    assert_eq!(filter(r#"<rfilter type="lanczos"/>"#), Kernel::Lanczos { lobes: 3.0 });
}

#[test]
fn a_uniform_scale_of_a_camera_is_taken_out_with_a_warning() {
    let camera = |scale: &str| {
        format!(
            r#"<sensor type="perspective"><transform name="to_world">{scale}<translate z="3"/></transform></sensor><shape type="cube"/>"#
        )
    };
    let (scaled, messages) = try_scene(&camera(r#"<scale value="2"/>"#));
    assert!(messages.contains("Warning") && messages.contains("scales by 2.0000"), "{messages}");
    let (plain, _) = try_scene(&camera(""));
    let ray = |scene: Option<etendue_scene::Scene>| {
        let view = &scene.expect("a scene").views[0];
        view.sensor.sample_ray([3.0, 5.0].into(), [0.5, 0.5].into(), 0.0)
    };
    assert_eq!(ray(scaled), ray(plain));
}
