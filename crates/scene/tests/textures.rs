//! Textures and spectra: compiled from files, looked up, and their mistakes told.

mod surfaces;

use etendue_bsdf::Scatter;
use etendue_description::Severity;
use etendue_image::{Image, SaveOptions, srgb_to_linear};
use etendue_numerics::spectrum::cie;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::texture::{Color, ColorSlot, Role};
use etendue_scene::{Material, Scene, SurfaceId, Texture};
use std::path::PathBuf;
use std::sync::Arc;
use surfaces::{compiled, compiled_scene, messages, mistakes, seen_at};

/// ρ of a diffuse rectangle.
fn reflectance(scene: &Scene, uv: Vec2) -> Spectrum {
    scene.bsdf(&seen_at(SurfaceId(0), Vec3::Z, uv), &Wavelengths::Rgb).diffuse_reflectance()
}

fn diffuse(inner: &str) -> String {
    format!(r#"<bsdf type="diffuse">{inner}</bsdf>"#)
}

struct Pictures(tempfile::TempDir);

impl Pictures {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn save(&self, name: &str, image: Image) -> PathBuf {
        let path = self.0.path().join(name);
        etendue_image::save(&path, &image.into(), &SaveOptions::default()).expect("a picture");
        path
    }

    /// 2 by 2 texels of eight bits: black, grey of code value 51, (255, 0, 102), white.
    fn png(&self, name: &str) -> PathBuf {
        let codes = [0, 0, 0, 51, 51, 51, 255, 0, 102, 255, 255, 255].map(|c: u8| f32::from(c) / 255.0);
        let image = Image::rgb(2, 2, codes.to_vec()).expect("a picture").with_encoding(etendue_image::Encoding::SRGB);
        self.save(name, image)
    }
}

fn bitmap(path: &std::path::Path, more: &str) -> String {
    format!(r#"<texture name="reflectance" type="bitmap"><string name="filename" value="{}"/>{more}</texture>"#, path.display())
}

#[test]
fn pictures_are_decoded_unless_raw() {
    let pictures = Pictures::new();
    let path = pictures.png("größe 图.png");
    let at = Vec2::new(0.25, 0.75);
    let decoded = reflectance(&compiled(&diffuse(&bitmap(&path, ""))), at).to_rgb();
    assert_eq!(decoded, [1.0, 0.0, srgb_to_linear(102.0 / 255.0)]);
    let raw = reflectance(&compiled(&diffuse(&bitmap(&path, r#"<boolean name="raw" value="true"/>"#))), at).to_rgb();
    assert_eq!(raw, [1.0, 0.0, 102.0 / 255.0]);
}

#[test]
fn coordinates_go_through_to_uv_from_the_top_left() {
    let pictures = Pictures::new();
    let path = pictures.png("a.png");
    let to_uv = r#"<string name="filter_type" value="nearest"/><transform name="to_uv"><scale x="2" y="1"/><translate x="0.5"/></transform>"#;
    let scene = compiled(&diffuse(&bitmap(&path, to_uv)));
    // u' = 2 u + 0.5, v' = v.
    let grey = srgb_to_linear(0.2);
    for (u, v, red) in [(0.1, 0.1, grey), (0.3, 0.1, 0.0), (0.1, 0.9, 1.0), (0.3, 0.9, 1.0), (0.55, 0.1, grey)] {
        assert_eq!(reflectance(&scene, Vec2::new(u, v)).0.x, red, "({u}, {v})");
    }
}

#[test]
fn a_picture_named_twice_is_in_memory_once() {
    let pictures = Pictures::new();
    let path = pictures.png("a.png");
    let mirrored = bitmap(&path, r#"<string name="wrap_mode" value="mirror"/>"#);
    let scene = compiled(&format!(r#"<bsdf type="twosided">{}{}</bsdf>"#, diffuse(&bitmap(&path, "")), diffuse(&mirrored)));
    let texels: Vec<_> =
        scene.textures.iter().filter_map(|t| if let Texture::Bitmap(b) = t { Some(&b.texels) } else { None }).collect();
    assert_eq!(texels.len(), 2);
    assert!(Arc::ptr_eq(texels[0], texels[1]));
}

#[test]
fn numbers_of_coloured_textures_are_luminances_and_of_colours_means() {
    let pictures = Pictures::new();
    let path = pictures.save("a.exr", Image::rgb(1, 1, vec![0.5, 0.25, 1.0]).expect("a picture"));
    let mask = |opacity: &str| {
        let scene = compiled(&format!(r#"<bsdf type="mask">{opacity}<bsdf type="diffuse"/></bsdf>"#));
        let x = seen_at(SurfaceId(0), Vec3::Z, Vec2::new(0.3, 0.6));
        1.0 - scene.bsdf(&x, &Wavelengths::Rgb).transparency(Vec3::Z).0.x
    };
    let picture = bitmap(&path, "").replace("reflectance", "opacity");
    assert!((mask(&picture) - (0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722)).abs() < 1e-6);
    // Mitsuba takes the squares the other way round where one number is asked for; (0.3, 0.6) lies in a square of `color1`.
    let board = r#"<texture name="opacity" type="checkerboard"><float name="color0" value="0.9"/><float name="color1" value="0.2"/></texture>"#;
    assert!((mask(board) - 0.9).abs() < 1e-6);
    assert!((mask(r#"<rgb name="opacity" value="0.1 0.2 0.6"/>"#) - 0.3).abs() < 1e-6);
}

#[test]
fn checkerboards_hold_colours_and_textures() {
    let pictures = Pictures::new();
    let path = pictures.save("a.exr", Image::rgb(1, 1, vec![0.5, 0.25, 1.0]).expect("a picture"));
    let scene = compiled(&diffuse(&format!(
        r#"<texture name="reflectance" type="checkerboard">{}<rgb name="color1" value="0.1 0.2 0.3"/>
           <transform name="to_uv"><scale value="2"/></transform></texture>"#,
        bitmap(&path, "").replace("reflectance", "color0")
    )));
    assert_eq!(reflectance(&scene, Vec2::new(0.1, 0.1)).to_rgb(), [0.5, 0.25, 1.0]);
    assert_eq!(reflectance(&scene, Vec2::new(0.3, 0.1)).to_rgb(), [0.1, 0.2, 0.3]);
    let mean = scene.textures.last().expect("a texture").mean(&scene).to_rgb();
    assert!(mean.iter().zip([0.3, 0.225, 0.65]).all(|(m, want)| (m - want).abs() < 1e-6));
}

#[test]
fn attributes_are_interpolated_on_vertices_and_flat_on_faces() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ply");
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float r\n\
                property float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\nproperty float r\n\
                property float g\nproperty float b\nend_header\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2 0.5 0.25 0.125\n";
    std::fs::write(&path, text).expect("a file");
    let seen = |attribute: &str| {
        let scene = compiled_scene(&format!(
            r#"<scene version="3.0.0"><shape type="ply"><string name="filename" value="{}"/><bsdf type="diffuse">
               <texture name="reflectance" type="mesh_attribute"><string name="name" value="{attribute}"/><float name="scale" value="0.5"/>
               </texture></bsdf></shape><emitter type="constant"/><sensor type="perspective"/></scene>"#,
            path.display()
        ));
        reflectance(&scene, Vec2::ZERO).to_rgb()
    };
    // bary = (1/4, 1/2) of the first triangle.
    assert_eq!(seen("vertex_color"), [0.125, 0.125, 0.25]);
    assert_eq!(seen("face_color"), [0.25, 0.125, 0.0625]);
}

#[test]
fn spectra_become_colours_by_their_role() {
    let pairs = [(400.0, 0.1), (500.0, 0.5), (700.0, 0.9)];
    let samples = etendue_numerics::spectrum::SampledSpectrum::new(&pairs).expect("a spectrum");
    let written = "400:0.1, 500:0.5, 700:0.9";
    for (text, want) in [
        (format!(r#"<spectrum name="reflectance" value="{written}"/>"#), cie::reflectance_to_rgb(&samples)),
        (r#"<spectrum name="reflectance" value="0.6"/>"#.to_owned(), [0.6; 3]),
        (r#"<spectrum name="reflectance" type="uniform"><float name="value" value="0.6"/></spectrum>"#.to_owned(), [0.6; 3]),
        (r#"<texture name="reflectance" type="srgb"><rgb name="color" value="0.1 0.2 0.3"/></texture>"#.to_owned(), [0.1, 0.2, 0.3]),
        (r#"<spectrum name="reflectance" type="d65"><rgb name="color" value="0.1 0.2 0.3"/><float name="scale" value="2"/></spectrum>"#.to_owned(), [0.2, 0.4, 0.6]),
        (
            r#"<spectrum name="reflectance" type="irregular"><string name="wavelengths" value="400, 500, 700"/>
               <string name="values" value="0.1, 0.5, 0.9"/></spectrum>"#
                .to_owned(),
            cie::reflectance_to_rgb(&samples),
        ),
    ] {
        let got = reflectance(&compiled(&diffuse(&text)), Vec2::ZERO).to_rgb();
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-6), "{text}: {got:?}, expected {want:?}");
    }
    let regular = compiled(&diffuse(
        r#"<spectrum name="reflectance" type="regular"><float name="wavelength_min" value="400"/><float name="wavelength_max" value="700"/>
           <string name="values" value="0.5 0.5"/></spectrum>"#,
    ));
    assert!(reflectance(&regular, Vec2::ZERO).0.y > 0.4);
}

#[test]
fn metals_take_spectra_without_bounds() {
    let scene = compiled(r#"<bsdf type="conductor"><rgb name="eta" value="1.5 2 3"/><rgb name="k" value="4 5 6"/></bsdf>"#);
    let Material::Conductor(metal) = scene.material(scene.surface(SurfaceId(0)).material) else { panic!("a metal") };
    let unbounded = |rgb| ColorSlot::Constant(Color::rgb(rgb, Role::Unbounded));
    assert_eq!((&metal.eta, &metal.k), (&unbounded([1.5, 2.0, 3.0]), &unbounded([4.0, 5.0, 6.0])));
}

#[test]
fn mistakes_are_told_where_they_stand() {
    let folder = tempfile::tempdir().expect("a folder");
    let broken = folder.path().join("broken.png");
    std::fs::write(&broken, b"\x89PNG\r\n\x1a\nnothing").expect("a file");
    let path = broken.display().to_string();
    let constant =
        |model: &str, inner: &str| diffuse(&format!(r#"<spectrum name="reflectance" type="{model}">{inner}</spectrum>"#));
    for (text, at, message) in [
        (diffuse(r#"<texture name="reflectance" type="chekerboard"/>"#), "chekerboard", "unknown texture"),
        (diffuse(r#"<texture name="reflectance" type="volume"/>"#), "volume", "refused"),
        (diffuse(r#"<texture name="reflectance" type="bitmap"/>"#), "bitmap", "needs a `filename`"),
        (diffuse(&bitmap(&broken, "")), path.as_str(), "PNG"),
        (
            diffuse(r#"<texture name="reflectance" type="checkerboard"><float name="colour0" value="1"/></texture>"#),
            "colour0",
            "`color0`",
        ),
        (
            diffuse(r#"<texture name="reflectance" type="checkerboard"><string name="color0" value="x"/></texture>"#),
            "x",
            "is a string",
        ),
        (diffuse(r#"<texture name="reflectance" type="mesh_attribute"/>"#), "mesh_attribute", "needs a `name`"),
        (
            diffuse(r#"<texture name="reflectance" type="mesh_attribute"><string name="name" value="color"/></texture>"#),
            "color",
            "`vertex_…`",
        ),
        (
            diffuse(r#"<texture name="reflectance" type="mesh_attribute"><string name="name" value="vertex_color"/></texture>"#),
            "vertex_color",
            "this `rectangle` has no attribute",
        ),
        (constant("srgb", ""), "srgb", "needs a `color`"),
        (constant("irregular", r#"<string name="values" value="1, 2"/>"#), "irregular", "needs `wavelengths`"),
        (
            constant("irregular", r#"<string name="wavelengths" value="400, 500, 600"/><string name="values" value="1, 2"/>"#),
            "400, 500, 600",
            "3 wavelengths, but 2 values",
        ),
        (
            constant("irregular", r#"<string name="wavelengths" value="500, 400"/><string name="values" value="0.1, 0.2"/>"#),
            "irregular",
            "rising",
        ),
        (constant("irregular", r#"<string name="wavelengths" value="1, b"/><string name="values" value="1, 2"/>"#), "1, b", "`b`"),
        (constant("uniform", r#"<float name="volue" value="1"/>"#), "volue", "`value`"),
    ] {
        let told = mistakes(&text);
        let found = told.iter().any(|(place, words)| words.contains(message) && place.trim_matches('"') == at);
        assert!(found && told.len() == 1, "{text}\nexpected `{message}` at `{at}`, got {told:#?}");
    }
}

#[test]
fn doubtful_values_are_warnings() {
    let pictures = Pictures::new();
    let bright = pictures.save("bright.exr", Image::rgb(1, 1, vec![0.5, 0.25, 3.0]).expect("a picture"));
    let odd = pictures.save("odd.exr", Image::rgb(1, 1, vec![f32::NAN, 0.25, 0.5]).expect("a picture"));
    for (text, message) in [
        (diffuse(&bitmap(&bright, "")), "up to 3"),
        (diffuse(&bitmap(&odd, "")), "not finite (1 of them)"),
        (diffuse(r#"<float name="reflectance" value="1.5"/>"#), "outside 0 to 1"),
        (diffuse(r#"<spectrum name="reflectance" value="400:0.5, 700:1.5"/>"#), "outside 0 to 1"),
        (r#"<bsdf type="principled"><float name="roughness" value="2"/></bsdf>"#.to_owned(), "taken as 1"),
        (r#"<bsdf type="phong"><float name="specular_reflectance" value="0.9"/></bsdf>"#.to_owned(), "scaled down"),
    ] {
        let told = messages(&text);
        assert!(told.len() == 1 && told[0].0 == Severity::Warning && told[0].2.contains(message), "{text}: {told:#?}");
    }
}
