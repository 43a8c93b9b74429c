//! What pbrt's files mean where Mitsuba's mean something else: pictures as numbers, encodings, glass.

use etendue_bsdf::Scatter;
use etendue_check::{Moments, rng, z_test};
use etendue_description::Diagnostics;
use etendue_formats::ReadOptions;
use etendue_image::{Encoding, Image, SaveOptions};
use etendue_numerics::spectrum::ior;
use etendue_numerics::{Pdf, Ray, Vec2, Vec3, Wavelengths, warp::square_to_cosine_hemisphere};
use etendue_scene::{CompileOptions, Interaction, LightReference, Scene, compile};

/// The scene of a world with these lines.
fn compiled(world: &str, spectral: bool) -> Scene {
    let (description, said) = etendue_formats::read_str("test.pbrt", &format!("WorldBegin\n{world}\n"), &ReadOptions::default());
    assert!(!said.has_errors(), "{}", said.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let scene = compile(&description, &CompileOptions { spectral, ..CompileOptions::default() }, &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// What of a surface's light passes straight through its `alpha`, a picture of the only file.
fn opacity(image: Image, more: &str) -> f32 {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    etendue_image::save(&path, &image.into(), &SaveOptions::default()).expect("a picture");
    let picture = format!("\"string filename\" \"{}\" {more}", path.display());
    let scene =
        compiled(&format!("Texture \"t\" \"float\" \"imagemap\" {picture}\nShape \"sphere\" \"texture alpha\" \"t\""), false);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 4.0), -Vec3::Z);
    let x = scene.interaction(&ray, &scene.intersect(&ray).expect("a hit"));
    let x = Interaction { uv: Vec2::splat(0.5), ..x };
    1.0 - scene.bsdf(&x, &Wavelengths::Rgb).transparency(Vec3::Z).0.x
}

#[test]
fn pictures_as_numbers_are_means_of_channels_or_alpha() {
    let codes = [51, 102, 204].map(|c: u8| f32::from(c) / 255.0);
    let colour = || Image::rgb(1, 1, codes.to_vec()).expect("a picture").with_encoding(Encoding::SRGB);
    let close = |got: f32, want: f32| assert!((got - want).abs() < 1e-6, "{got} is not {want}");
    let mean = |f: fn(f32) -> f32| codes.iter().map(|c| f(*c)).sum::<f32>() / 3.0;
    close(opacity(colour(), ""), mean(etendue_image::srgb_to_linear));
    close(opacity(colour(), "\"string encoding\" \"sRGB\""), mean(etendue_image::srgb_to_linear));
    close(opacity(colour(), "\"string encoding\" \"linear\""), mean(|c| c));
    close(opacity(colour(), "\"string encoding\" \"gamma 3\""), mean(|c| c * c * c));
    let with_alpha = |a: f32| {
        let image = Image::from_data(1, 1, &["R", "G", "B", "A"], vec![codes[0], codes[1], codes[2], a]).expect("a picture");
        image.with_encoding(Encoding::SRGB)
    };
    close(opacity(with_alpha(0.2), "\"string encoding\" \"linear\""), 0.2);
    close(opacity(with_alpha(1.0), "\"string encoding\" \"linear\""), mean(|c| c));
}

#[test]
fn glass_bends_each_wavelength_by_its_own_index() {
    let named = ("\"spectrum eta\" \"glass-F11\"", "glass-f11");
    let pairs = ("\"spectrum eta\" [ 380 1.6 780 1.4 ]", "");
    let ray = Ray::new(Vec3::new(0.5, 0.0, 4.0), -Vec3::Z);
    for (eta, glass) in [named, pairs] {
        for rough in ["", "\"float roughness\" 0.2"] {
            let world = format!("Material \"dielectric\" {eta} {rough}\nShape \"sphere\"");
            let scene = compiled(&world, true);
            let x = scene.interaction(&ray, &scene.intersect(&ray).expect("a hit"));
            for u in [0.1, 0.5, 0.9] {
                let wl = Wavelengths::hero(u);
                let Wavelengths::Hero(hero) = &wl else { panic!("no wavelengths") };
                let nm = f64::from(hero.nm()[0]);
                let want = ior::glass(glass).map_or(1.6 - (nm - 380.0) / 400.0 * 0.2, |glass| glass.index(nm));
                let bsdf = scene.bsdf(&x, &wl);
                assert!((f64::from(bsdf.eta()) - want).abs() < 2e-4, "{eta} at {nm} nm: {} is not {want}", bsdf.eta());
                assert!(bsdf.events().disperses(), "{eta}: secondary wavelengths must end");
            }
            // Three colours share one index, that of the d line.
            let scene = compiled(&world, false);
            let index = f64::from(scene.bsdf(&x, &Wavelengths::Rgb).eta());
            let want = ior::glass(glass).map_or(1.6 - (587.56 - 380.0) / 400.0 * 0.2, |glass| glass.index(587.56));
            assert!((index - want).abs() < 1e-5, "{index} is not {want}");
        }
    }
}

/// A mirror under a smooth layer, seen from above: all bounces between both, the metal's index taken over the layer's.
#[test]
fn a_coated_metal_is_seen_from_within_its_coat() {
    let (n, k, eta, thickness) = ([0.2f32, 0.9, 1.1], [3.9f32, 2.4, 2.1], 1.5f32, 0.05f32);
    let metal = "\"rgb conductor.eta\" [0.2 0.9 1.1] \"rgb conductor.k\" [3.9 2.4 2.1]";
    let world = format!(
        "Material \"coatedconductor\" {metal} \"float interface.eta\" {eta} \"float thickness\" {thickness} \"integer maxdepth\" 100\nShape \"sphere\""
    );
    let scene = compiled(&world, false);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 4.0), -Vec3::Z);
    let x = scene.interaction(&ray, &scene.intersect(&ray).expect("a hit"));
    let bsdf = scene.bsdf(&x, &Wavelengths::Rgb);
    let mut found = Vec::new();
    bsdf.diracs(Vec3::Z, &mut |s| found.push(s.weight));
    let f = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let way = (-2.0 * thickness).exp();
    for c in 0..3 {
        let (n, k) = (n[c] / eta, k[c] / eta);
        let r = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k) * way;
        let want = f + (1.0 - f).powi(2) * r / (1.0 - f * r);
        assert!(found.len() == 1 && (found[0][c] - want).abs() < 1e-3, "{:?} is not {want}", found[0]);
    }
}

/// Textured thickness and g: at every place the coat is the one that has these numbers all over, to the bit, for both are estimated by the same walks.
#[test]
fn a_coat_may_be_thicker_here_than_there() {
    let coats = |coat: &str| {
        ["coateddiffuse", "coatedconductor"].map(|model| {
            let textures = "Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" 0.5 \"float tex2\" 0.02\n\
                 Texture \"g\" \"float\" \"checkerboard\" \"float tex1\" 0.6 \"float tex2\" -0.3\n";
            let square = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 2 0 0 2 2 0 0 2 0] \"point2 uv\" [0 0 2 0 2 2 0 2] \"integer indices\" [0 1 2 0 2 3]";
            compiled(&format!("{textures}Material \"{model}\" \"rgb albedo\" [.3 .5 .7] {coat}\n{square}"), false)
        })
    };
    let textured = coats("\"texture thickness\" \"t\" \"texture g\" \"g\"");
    let even = [("0.5", "0.6"), ("0.02", "-0.3")].map(|(t, g)| coats(&format!("\"float thickness\" {t} \"float g\" {g}")));
    let (wo, wi) = (Vec3::new(0.3, 0.1, 0.9).normalize(), Vec3::new(-0.5, 0.4, 0.7).normalize());
    for ((x, y), here) in [((0.5, 0.5), 0), ((1.5, 0.5), 1), ((1.5, 1.5), 0)] {
        let ray = Ray::new(Vec3::new(x, y, 4.0), -Vec3::Z);
        let seen = |scene: &Scene| {
            let x = scene.interaction(&ray, &scene.intersect(&ray).expect("a hit"));
            scene.bsdf(&x, &Wavelengths::Rgb).eval(wo, wi).to_rgb()
        };
        for k in 0..2 {
            let (got, want, other) = (seen(&textured[k]), seen(&even[here][k]), seen(&even[1 - here][k]));
            assert!(got == want && got != other, "at ({x}, {y}): {got:?}, {want:?}, not {other:?}");
        }
    }
}

/// A floor under a portal in the ceiling: the irradiance is ∫ L cos cos/r² over it, by light samples, and by looking all around.
#[test]
fn a_portal_lets_light_in_through_its_rectangle_only() {
    let portal = "\"point3 portal\" [-1 -0.5 2  -1 0.5 2  1 0.5 2  1 -0.5 2]";
    let scene = compiled(
        &format!("Translate 5 5 5 LightSource \"infinite\" \"rgb L\" [3 3 3] {portal}\nShape \"disk\" \"float radius\" 9"),
        false,
    );
    let p = Vec3::new(0.3, 0.2, 0.0);
    let (n, mut want) = (64, 0.0f64);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
        let (x, y) = (2.0 * at(i) - 1.0 - 0.3, at(j) - 0.5 - 0.2);
        let r2 = x * x + y * y + 4.0;
        want += 3.0 * 4.0 / (r2 * r2) * 2.0 / f64::from(n * n);
    }

    let from = LightReference { p, n: Vec3::Z, ..LightReference::from(&seen_from(p)) };
    let (mut sampled, mut looked, mut numbers) = (Moments::default(), Moments::default(), rng(6));
    for _ in 0..40_000 {
        let s = scene.sample_light(&from, 0.5, numbers.u2(), &Wavelengths::Rgb);
        sampled.add(s.map_or(0.0, |s| {
            let Pdf::SolidAngle(pdf) = s.pdf else { panic!("a discrete choice") };
            assert!((pdf / scene.pdf_light_escaped(&from, s.wi) - 1.0).abs() < 1e-4);
            f64::from(s.le[0] * s.wi.z.max(0.0) / pdf)
        }));
        let w = square_to_cosine_hemisphere(numbers.u2());
        let le = scene.le_escaped(&Ray::new(p, w), &Wavelengths::Rgb)[0];
        looked.add(f64::from(le) * std::f64::consts::PI);
        // What the sampler never draws does not shine.
        assert_eq!(le > 0.0, scene.pdf_light_escaped(&from, w) > 0.0, "{w}");
    }
    // Two tests, one false alarm in a thousand runs were the seed drawn anew.
    for m in [sampled, looked] {
        assert!(z_test(&m, want).p_value > 5e-4, "{} ± {} is not {want}", m.mean, m.standard_error());
    }
    // From outside, and beside it, there is nothing.
    for (p, w) in [(Vec3::new(0.0, 0.0, 3.0), Vec3::Z), (Vec3::new(1.5, 0.0, 0.0), Vec3::Z), (p, -Vec3::Z)] {
        assert!(scene.le_escaped(&Ray::new(p, w), &Wavelengths::Rgb).is_zero(), "{p} {w}");
    }
}

fn seen_from(p: Vec3) -> Interaction {
    let scene = compiled("Shape \"sphere\"", false);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 4.0), -Vec3::Z);
    Interaction { p, n: Vec3::Z, ..scene.interaction(&ray, &scene.intersect(&ray).expect("a hit")) }
}
