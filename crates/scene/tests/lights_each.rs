//! Many rays and many light samples at once give the bits of each alone.

mod lighting;

use etendue_check::{Rng, rng};
use etendue_image::{ExrSamples, Image, Picture, SaveOptions};
use etendue_numerics::{Ray, Vec3, Wavelengths};
use etendue_scene::{Escape, LightQuery, LightReference, LightSample, Scene, Seen};
use lighting::scene_in;

/// So many at once: none, fewer than a vector has lanes, just as many as go together, and more.
const COUNTS: [usize; 6] = [0, 1, 15, 64, 65, 300];

/// Pictures in every form that texels are kept in, grey ones and colours, one of a single row, one without light.
fn pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut r = rng(21);
    let mut save = |name: &str, w: usize, h: usize, channels: usize, exr: ExrSamples, light: f32| {
        let mut value = |i: usize| if i.is_multiple_of(41) { 40.0 * light * r.u1() } else { light * r.u1() * r.u1() };
        let data: Vec<f32> = (0..w * h * channels).map(&mut value).collect();
        let image = if channels == 1 { Image::from_data(w, h, &["Y"], data) } else { Image::rgb(w, h, data) };
        let options = SaveOptions { exr, ..SaveOptions::default() };
        etendue_image::save(&folder.path().join(name), &Picture::from(image.expect("a picture")), &options).expect("saved");
    };
    save("float.exr", 37, 21, 3, ExrSamples::Float, 1.0);
    save("half.exr", 64, 32, 3, ExrSamples::Half, 1.0);
    save("byte.png", 24, 24, 3, ExrSamples::Half, 0.2);
    save("grey.exr", 33, 17, 1, ExrSamples::Half, 1.0);
    save("row.exr", 16, 1, 3, ExrSamples::Float, 1.0);
    save("square.exr", 32, 32, 3, ExrSamples::Half, 1.0);
    save("black.exr", 16, 8, 3, ExrSamples::Half, 0.0);
    folder
}

fn rows() -> Vec<(&'static str, String)> {
    let sky = |file: &str, more: &str| {
        format!(
            r#"<emitter type="envmap"><string name="filename" value="{file}"/>{more}
                <transform name="to_world"><rotate x="1" y="0.3" angle="70"/></transform></emitter>"#
        )
    };
    let sun = r#"<emitter type="directional"><vector name="direction" value="0, 3, -4"/></emitter>"#;
    let lamp = r#"<shape type="sphere"><point name="center" value="0, 0, 3"/><emitter type="area"/></shape>"#;
    let square = r#"<string name="mapping" value="equal_area"/>"#;
    vec![
        ("floats", sky("float.exr", "")),
        ("halves", sky("half.exr", r#"<float name="scale" value="3"/>"#)),
        ("bytes", sky("byte.png", "")),
        ("grey", sky("grey.exr", "")),
        ("one row", sky("row.exr", "")),
        ("black", sky("black.exr", "")),
        ("beside a sun and a lamp", sky("half.exr", "") + sun + lamp),
        ("never sampled", sky("half.exr", r#"<float name="sampling_weight" value="0"/>"#) + lamp),
        ("a square", sky("square.exr", square)),
        ("a square of bytes beside a lamp", sky("byte.png", square) + lamp),
        ("constant", r#"<emitter type="constant"/>"#.into()),
        ("constant and a sky", r#"<emitter type="constant"/>"#.to_owned() + &sky("half.exr", "")),
        ("a lamp alone", lamp.into()),
    ]
}

/// Directions everywhere, among them poles, the seam and the axes.
fn direction(r: &mut Rng) -> Vec3 {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    if r.u1() < 0.1 {
        return axes[(r.u1() * 6.0) as usize % 6];
    }
    (Vec3::new(r.u1(), r.u1(), r.u1()) * 2.0 - 1.0).try_normalize().unwrap_or(Vec3::X)
}

fn reference(r: &mut Rng, shared: bool) -> LightReference {
    let p = Vec3::new(r.u1(), r.u1(), r.u1());
    let n = if r.u1() < 0.2 { Vec3::ZERO } else { direction(r) };
    LightReference { p, n, one_sided: r.u1() < 0.7, shared }
}

fn wavelengths(r: &mut Rng, spectral: bool) -> Wavelengths {
    if spectral { Wavelengths::hero(r.u1()) } else { Wavelengths::Rgb }
}

fn bits(seen: &Seen) -> [u32; 5] {
    let le: [f32; 4] = seen.le.0.into();
    [le[0], le[1], le[2], le[3], seen.pdf].map(f32::to_bits)
}

fn rays_that_escape(name: &str, scene: &Scene, r: &mut Rng, spectral: bool) {
    for count in COUNTS {
        let rays: Vec<_> = (0..count)
            .map(|_| {
                let shared = r.u1() < 0.5;
                let from = (r.u1() < 0.8).then(|| reference(r, shared));
                (Ray::new(direction(r), direction(r)), from, wavelengths(r, spectral))
            })
            .collect();
        let mut seen = Vec::new();
        scene.escaped_each(rays.iter().map(|(ray, from, wl)| Escape { ray, from: from.as_ref(), wl }), &mut seen);
        assert_eq!(seen.len(), count, "{name}");
        for ((ray, from, wl), seen) in rays.iter().zip(&seen) {
            let pdf = from.map_or(0.0, |from| scene.pdf_light_escaped(&from, ray.d));
            let alone = Seen { le: scene.le_escaped(ray, wl), pdf };
            assert_eq!(bits(seen), bits(&alone), "{name}, one of {count}, spectral {spectral}: {ray:?} from {from:?}");
        }
    }
}

fn light_samples(name: &str, scene: &Scene, r: &mut Rng, spectral: bool) {
    for count in COUNTS {
        // All beside walks, none of them, and mixed.
        let kind = r.u1();
        let query = |_| {
            let shared = kind < 0.4 || kind < 0.7 && r.u1() < 0.9;
            LightQuery { from: reference(r, shared), u_light: r.u1(), u: r.u2() }
        };
        let queries: Vec<LightQuery> = (0..count).map(query).collect();
        let wl: Vec<Wavelengths> = (0..if spectral { count } else { 0 }).map(|_| wavelengths(r, true)).collect();
        let mut found: Vec<Option<LightSample>> = Vec::new();
        scene.lights.sample_each(scene, &queries, &wl, |i, sample| {
            assert_eq!(i, found.len(), "{name}");
            found.push(sample);
        });
        assert_eq!(found.len(), count, "{name}");
        for (i, (query, found)) in queries.iter().zip(&found).enumerate() {
            let alone = scene.sample_light(&query.from, query.u_light, query.u, wl.get(i).unwrap_or(&Wavelengths::Rgb));
            assert_eq!(format!("{found:?}"), format!("{alone:?}"), "{name}, one of {count}, spectral {spectral}: {query:?}");
        }
    }
}

#[test]
fn many_at_once_have_the_bits_of_each_alone() {
    let folder = pictures();
    let mut r = rng(22);
    for (name, emitters) in rows() {
        let mut scene = scene_in(folder.path(), &format!("{emitters}<shape type=\"rectangle\"/>"));
        for spectral in [false, true] {
            scene.spectral = spectral;
            rays_that_escape(name, &scene, &mut r, spectral);
            light_samples(name, &scene, &mut r, spectral);
        }
    }
}
