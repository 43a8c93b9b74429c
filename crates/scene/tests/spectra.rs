//! What colours, numbers and spectra are to walks that carry wavelengths: as Mitsuba 3.9.1 has them in its spectral mode.

use etendue_description::Diagnostics;
use etendue_numerics::spectrum::{cie, ior};
use etendue_numerics::{Hero, Ray, Spectrum, Vec3, Wavelengths};
use etendue_scene::{CompileOptions, Material, Scene, SurfaceId, compile};

fn compiled(body: &str) -> Scene {
    let text = format!("<scene version=\"3.0.0\">{body}</scene>");
    let (description, _) = etendue_formats::read_str("test.xml", &text, &etendue_formats::ReadOptions::default());
    let mut diagnostics = Diagnostics::default();
    let scene = compile(&description, &CompileOptions { spectral: true, ..CompileOptions::default() }, &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// Wavelengths with what stands for them, for several walks.
fn heroes() -> impl Iterator<Item = (Wavelengths, Hero)> {
    (0..16).filter_map(|i| match Wavelengths::hero((i as f32 + 0.5) / 16.0) {
        Wavelengths::Hero(hero) => Some((Wavelengths::Hero(hero), hero)),
        Wavelengths::Rgb => None,
    })
}

fn must_be(what: &str, got: impl Fn(&Wavelengths) -> Spectrum, want: impl Fn(f64) -> f64, tolerance: f64) {
    for (wl, hero) in heroes() {
        for k in 0..4 {
            let (got, want) = (f64::from(got(&wl)[k]), want(f64::from(hero.nm()[k])));
            assert!(
                (got - want).abs() <= tolerance * want.abs().max(0.1),
                "{what} at {} nm: {got} instead of {want}",
                hero.nm()[k]
            );
        }
    }
}

#[test]
fn emission() {
    let of = |radiance: &str| compiled(&format!(r#"<emitter type="constant">{radiance}</emitter>"#));
    let le = |scene: &Scene, wl: &Wavelengths| scene.le_escaped(&Ray::new(Vec3::ZERO, Vec3::Z), wl);
    // The illuminant is looked up in the table of the observer's quantiles: straight between its entries, which are up to 5 nm apart.
    for (radiance, what) in [
        (r#"<float name="radiance" value="2"/>"#, "a number"),
        (r#"<rgb name="radiance" value="2"/>"#, "white"),
        (r#"<spectrum type="d65" name="radiance"><float name="scale" value="2"/></spectrum>"#, "d65"),
    ] {
        let scene = of(radiance);
        must_be(what, |wl| le(&scene, wl), |nm| 2.0 * cie::d65(nm), 2e-2);
    }
    for (radiance, what) in [
        (r#"<spectrum name="radiance" value="2"/>"#, "one value"),
        (r#"<spectrum type="uniform" name="radiance"><float name="value" value="2"/></spectrum>"#, "uniform"),
    ] {
        let scene = of(radiance);
        must_be(what, |wl| le(&scene, wl), |_| 2.0, 1e-6);
    }
    let scene = of(r#"<spectrum name="radiance" value="300:0, 500:2, 900:4"/>"#);
    must_be("values", |wl| le(&scene, wl), |nm| if nm < 500.0 { (nm - 300.0) / 100.0 } else { 2.0 + (nm - 500.0) / 200.0 }, 1e-4);
    let scene = of(r#"<blackbody name="radiance" temperature="5000" scale="0.001"/>"#);
    must_be("a black body", |wl| le(&scene, wl), |nm| 1e-3 * cie::blackbody(nm, 5000.0), 1e-4);
    // Mitsuba 3.9.1 gives (0.1439, 0.2486, 1.1680, 1.3487) at 450, 550, 650 and 700 nm.
    let scene = of(r#"<rgb name="radiance" value="1, 0.2, 0.1"/>"#);
    let points = [(450.0, 0.143945), (550.0, 0.248649), (650.0, 1.168), (700.0, 1.3487)];
    for (nm, want) in points {
        let nearest = (0..4096).map(|i| (i as f32 + 0.5) / 4096.0).map(Wavelengths::hero).min_by(|a, b| {
            let off = |wl: &Wavelengths| if let Wavelengths::Hero(h) = wl { (h.nm()[0] - nm).abs() } else { f32::MAX };
            off(a).total_cmp(&off(b))
        });
        let got = le(&scene, &nearest.expect("wavelengths"))[0];
        assert!((got / want - 1.0).abs() < 0.03, "{nm} nm: {got} instead of {want}");
    }
}

#[test]
fn metals_and_glasses() {
    let of = |bsdf: &str| compiled(&format!(r#"<shape type="rectangle">{bsdf}</shape>"#));
    let scene = of(r#"<bsdf type="conductor"><string name="material" value="Au"/></bsdf>"#);
    let Material::Conductor(metal) = scene.material(scene.surface(SurfaceId(0)).material) else { panic!("a metal") };
    let gold = ior::Conductor::named("Au").expect("gold");
    let at = |slot: &etendue_scene::ColorSlot, wl: &Wavelengths| match slot {
        etendue_scene::ColorSlot::Constant(color) => color.at(wl),
        etendue_scene::ColorSlot::Texture(_) => panic!("no texture"),
    };
    // The measurements have entries between whole nanometres.
    must_be("eta of gold", |wl| at(&metal.eta, wl), |nm| gold.eta.eval(nm), 1e-2);
    must_be("k of gold", |wl| at(&metal.k, wl), |nm| gold.k.eval(nm), 1e-2);

    let scene =
        of(r#"<bsdf type="dielectric"><string name="int_ior" value="glass-SF11"/><float name="ext_ior" value="1"/></bsdf>"#);
    let Material::Dielectric(glass) = scene.material(scene.surface(SurfaceId(0)).material) else { panic!("glass") };
    assert!((glass.eta - 1.78472).abs() < 1e-4, "{}", glass.eta);
    let (curve, flint) = (glass.dispersion.as_ref().expect("dispersion"), ior::glass("glass-sf11").expect("flint"));
    for (_, hero) in heroes() {
        (0..4).for_each(|k| assert!((f64::from(curve.at(&hero)[k]) - flint.index(f64::from(hero.nm()[k]))).abs() < 1e-4));
    }
    let scene = of(r#"<bsdf type="dielectric"><string name="int_ior" value="bk7"/></bsdf>"#);
    let Material::Dielectric(glass) = scene.material(scene.surface(SurfaceId(0)).material) else { panic!("glass") };
    assert!(glass.dispersion.is_none(), "Mitsuba's glasses are numbers");
}

/// White reflects all light at every wavelength, written in whichever way.
#[test]
fn white_is_white() {
    for white in [
        r#"<rgb name="reflectance" value="1"/>"#,
        r#"<rgb name="reflectance" value="1, 1, 1"/>"#,
        r#"<float name="reflectance" value="1"/>"#,
    ] {
        let scene = compiled(&format!(r#"<shape type="rectangle"><bsdf type="diffuse">{white}</bsdf></shape>"#));
        let Material::Diffuse(diffuse) = scene.material(scene.surface(SurfaceId(0)).material) else { panic!("diffuse") };
        let etendue_scene::ColorSlot::Constant(color) = &diffuse.reflectance else { panic!("a colour") };
        must_be(white, |wl| color.at(wl), |_| 1.0, 1e-4);
    }
}
