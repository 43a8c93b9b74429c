//! Materials: compiled from files, evaluated, and their mistakes told.

mod surfaces;

use etendue_bsdf::{Bsdf, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths, math::FRAC_1_PI};
use etendue_scene::{Material, Scene, SurfaceId, texture::ColorSlot};
use surfaces::{compiled, mistakes, seen_at};

const RGB: Wavelengths = Wavelengths::Rgb;

/// Every model with every parameter that it has.
const EVERY_PARAMETER: &[&str] = &[
    r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.1 0.2 0.3"/></bsdf>"#,
    r#"<bsdf type="dielectric"><string name="int_ior" value="water"/><float name="ext_ior" value="1"/>
       <float name="specular_reflectance" value="0.9"/><rgb name="specular_transmittance" value="0.5"/></bsdf>"#,
    r#"<bsdf type="thindielectric"><float name="int_ior" value="1.5"/><string name="ext_ior" value="Air"/>
       <float name="specular_reflectance" value="0.9"/><rgb name="specular_transmittance" value="0.5"/></bsdf>"#,
    r#"<bsdf type="roughdielectric"><string name="distribution" value="ggx"/><float name="alpha_u" value="0.1"/>
       <texture name="alpha_v" type="checkerboard"/><boolean name="sample_visible" value="false"/>
       <string name="int_ior" value="bk7"/><string name="ext_ior" value="water"/>
       <float name="specular_reflectance" value="0.9"/><rgb name="specular_transmittance" value="0.5"/></bsdf>"#,
    r#"<bsdf type="conductor"><rgb name="eta" value="0.2 0.9 1.1"/><spectrum name="k" value="400:3, 700:4"/>
       <float name="specular_reflectance" value="0.9"/></bsdf>"#,
    r#"<bsdf type="roughconductor"><string name="material" value="Au"/><string name="distribution" value="Beckmann"/>
       <float name="alpha" value="0.2"/><boolean name="sample_visible" value="true"/>
       <float name="specular_reflectance" value="0.9"/></bsdf>"#,
    r#"<bsdf type="plastic"><float name="int_ior" value="1.6"/><float name="ext_ior" value="1"/><boolean name="nonlinear" value="true"/>
       <rgb name="diffuse_reflectance" value="0.1 0.2 0.3"/><float name="specular_reflectance" value="0.9"/></bsdf>"#,
    r#"<bsdf type="roughplastic"><float name="int_ior" value="1.6"/><float name="ext_ior" value="1"/>
       <boolean name="nonlinear" value="true"/><float name="alpha" value="0.3"/><string name="distribution" value="ggx"/>
       <rgb name="diffuse_reflectance" value="0.1 0.2 0.3"/><float name="specular_reflectance" value="0.9"/>
       <boolean name="sample_visible" value="true"/></bsdf>"#,
    r#"<bsdf type="principled"><rgb name="base_color" value="0.9 0.5 0.1"/><float name="roughness" value="0.3"/>
       <float name="anisotropic" value="0.4"/><float name="metallic" value="0.2"/><float name="spec_trans" value="0.3"/>
       <float name="specular" value="0.6"/><float name="spec_tint" value="0.1"/><float name="sheen" value="0.2"/>
       <float name="sheen_tint" value="0.3"/><float name="flatness" value="0.4"/><float name="clearcoat" value="0.5"/>
       <float name="clearcoat_gloss" value="0.6"/><float name="diffuse_reflectance_sampling_rate" value="2"/>
       <float name="main_specular_sampling_rate" value="2"/><float name="clearcoat_sampling_rate" value="2"/></bsdf>"#,
    r#"<bsdf type="principledthin"><rgb name="base_color" value="0.9 0.5 0.1"/><float name="roughness" value="0.3"/>
       <float name="anisotropic" value="0.4"/><float name="spec_trans" value="0.3"/><float name="eta" value="1.4"/>
       <float name="spec_tint" value="0.1"/><float name="sheen" value="0.2"/><float name="sheen_tint" value="0.3"/>
       <float name="flatness" value="0.4"/><float name="diff_trans" value="1.2"/>
       <float name="diffuse_reflectance_sampling_rate" value="2"/><float name="specular_reflectance_sampling_rate" value="2"/>
       <float name="specular_transmittance_sampling_rate" value="2"/>
       <float name="diffuse_transmittance_sampling_rate" value="2"/></bsdf>"#,
    r#"<bsdf type="phong"><rgb name="diffuse_reflectance" value="0.1 0.2 0.3"/><float name="specular_reflectance" value="0.4"/>
       <float name="exponent" value="50"/></bsdf>"#,
    r#"<bsdf type="hair"><rgb name="sigma_a" value="0.1 0.2 0.3"/><float name="beta_m" value="0.2"/><float name="beta_n" value="0.4"/>
       <float name="alpha" value="3"/><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>"#,
    r#"<bsdf type="hair"><float name="eumelanin" value="0.3"/><float name="pheomelanin" value="0.5"/><float name="scale_tilt" value="3"/>
       <float name="longitudinal_roughness" value="0.2"/><float name="azimuthal_roughness" value="0.4"/></bsdf>"#,
    r#"<bsdf type="coateddiffuse"><rgb name="reflectance" value="0.1 0.2 0.3"/><float name="int_ior" value="1.4"/><float name="ext_ior" value="1.1"/>
       <float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.2"/><boolean name="remap_roughness" value="true"/>
       <float name="thickness" value="0.1"/><float name="g" value="0.3"/><float name="albedo" value="0.2"/><integer name="max_depth" value="7"/>
       <integer name="samples" value="2"/></bsdf>"#,
    r#"<bsdf type="coatedconductor"><string name="material" value="Au"/><float name="int_ior" value="1.4"/><float name="ext_ior" value="1.1"/>
       <float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.2"/><boolean name="remap_roughness" value="true"/>
       <float name="base_alpha_u" value="0.3"/><float name="base_alpha_v" value="0.2"/><boolean name="base_remap_roughness" value="true"/>
       <float name="thickness" value="0.1"/><float name="g" value="0.3"/><float name="albedo" value="0.2"/><integer name="max_depth" value="7"/>
       <integer name="samples" value="2"/></bsdf>"#,
    r#"<bsdf type="diffusetransmission"><rgb name="reflectance" value="0.1 0.2 0.3"/><rgb name="transmittance" value="0.3 0.2 0.1"/>
       <float name="scale" value="0.5"/></bsdf>"#,
    r#"<bsdf type="null"/>"#,
    r#"<bsdf type="mask"><float name="opacity" value="0.25"/><bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="blendbsdf"><texture name="weight" type="checkerboard"/><bsdf type="diffuse"/><bsdf type="plastic"/></bsdf>"#,
    r#"<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="roughplastic"/></bsdf>"#,
    r#"<bsdf type="bumpmap"><texture name="any" type="checkerboard"/><float name="scale" value="2"/>
       <boolean name="flip_invalid_normals" value="false"/><boolean name="use_shadowing_function" value="false"/>
       <bsdf type="diffuse"/></bsdf>"#,
    r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.6 0.5 0.9"/><boolean name="flip_invalid_normals" value="false"/>
       <boolean name="use_shadowing_function" value="false"/><bsdf type="diffuse"/></bsdf>"#,
];

/// Directions over both hemispheres, none of them grazing.
fn directions() -> impl Iterator<Item = Vec3> {
    (0..40).map(|i| {
        let z = if i % 2 == 0 { 1.0 } else { -1.0 } * (0.1 + 0.022 * i as f32);
        let (sin, cos) = (2.4 * i as f32).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    })
}

fn bsdf(scene: &Scene, wo: Vec3, uv: Vec2) -> Bsdf<'_> {
    scene.bsdf(&seen_at(SurfaceId(0), wo, uv), &RGB)
}

fn material(scene: &Scene) -> &Material {
    scene.material(scene.surface(SurfaceId(0)).material)
}

#[test]
fn every_parameter_of_every_model_is_known() {
    for text in EVERY_PARAMETER {
        let scene = compiled(text);
        for wo in directions() {
            let b = bsdf(&scene, wo, Vec2::new(0.3, 0.2));
            for wi in directions() {
                let (f, pdf) = (b.eval(wo, wi), b.pdf(wo, wi));
                assert!(f.is_finite() && f.to_rgb().iter().all(|x| *x >= 0.0) && pdf >= 0.0 && pdf.is_finite(), "{text}");
            }
            let declared = material(&scene).events();
            assert_eq!(declared | b.events(), declared, "{text} does what it does not declare");
            assert!(b.len() <= material(&scene).lobes());
        }
    }
}

#[test]
fn every_default_is_known() {
    for model in [
        "diffuse",
        "dielectric",
        "thindielectric",
        "roughdielectric",
        "conductor",
        "roughconductor",
        "plastic",
        "roughplastic",
        "principled",
        "principledthin",
        "phong",
    ] {
        let scene = compiled(&format!(r#"<bsdf type="{model}"/>"#));
        let b = bsdf(&scene, Vec3::new(0.3, 0.2, 0.9).normalize(), Vec2::ZERO);
        assert_eq!(b.len(), 1, "{model}");
        assert!(b.sample(Vec3::Z, 0.3, Vec2::new(0.4, 0.6)).is_some_and(|s| s.weight.is_finite()), "{model}");
    }
}

#[test]
fn mistakes_are_told_where_they_stand() {
    for (text, at, message) in [
        (r#"<bsdf type="difuse"/>"#, "difuse", "unknown material `difuse`"),
        (r#"<bsdf type="diffuse"><float name="reflectence" value="0.1"/></bsdf>"#, "reflectence", "unknown parameter"),
        (r#"<bsdf type="diffuse"><string name="reflectance" value="red"/></bsdf>"#, "red", "is a string"),
        (r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.1 1.2 0"/></bsdf>"#, "0.1 1.2 0", "outside 0 to 1"),
        (r#"<bsdf type="dielectric"><string name="int_ior" value="wader"/></bsdf>"#, "wader", "unknown index of refraction"),
        (r#"<bsdf type="dielectric"><float name="ext_ior" value="-1.5"/></bsdf>"#, "-1.5", "not a number above 0"),
        (
            r#"<bsdf type="roughdielectric"><float name="int_ior" value="1.1"/><float name="ext_ior" value="1.1"/></bsdf>"#,
            "1.1",
            "equal",
        ),
        (r#"<bsdf type="conductor"><string name="material" value="Gu"/></bsdf>"#, "Gu", "unknown metal"),
        (r#"<bsdf type="conductor"><string name="material" value="Au"/><float name="k" value="3"/></bsdf>"#, "Au", "either"),
        (r#"<bsdf type="roughconductor"><string name="distribution" value="ggg"/></bsdf>"#, "ggg", "unknown `distribution`"),
        (r#"<bsdf type="roughconductor"><float name="alpha_u" value="0.7"/></bsdf>"#, "0.7", "both"),
        (r#"<bsdf type="roughplastic"><texture name="alpha" type="checkerboard"/></bsdf>"#, "", "not a texture"),
        (r#"<bsdf type="principled"><float name="eta" value="1.3"/><float name="specular" value="0.4"/></bsdf>"#, "0.4", "either"),
        (r#"<bsdf type="mask"/>"#, "mask", "one nested material, not 0"),
        (r#"<bsdf type="blendbsdf"><bsdf type="diffuse"/><bsdf type="diffuse"/></bsdf>"#, "blendbsdf", "needs a `weight`"),
        (r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="diffuse"/></bsdf>"#, "blendbsdf", "not 1"),
        (r#"<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>"#, "twosided", "lets light through"),
        (r#"<bsdf type="twosided"><bsdf type="mask"><bsdf type="diffuse"/></bsdf></bsdf>"#, "twosided", "lets light through"),
        (r#"<bsdf type="bumpmap"><bsdf type="diffuse"/></bsdf>"#, "bumpmap", "one nested texture, not 0"),
        (r#"<bsdf type="normalmap"><bsdf type="diffuse"/></bsdf>"#, "normalmap", "needs a texture"),
        (r#"<bsdf type="diffuse"/><bsdf type="plastic"/>"#, "", "one material"),
        (
            r#"<bsdf type="diffuse"><spectrum name="reflectance" type="blackbody"><float name="temperature" value="5000"/></spectrum></bsdf>"#,
            "",
            "is a light",
        ),
    ] {
        let told = mistakes(text);
        let found = told.iter().any(|(place, words)| words.contains(message) && (at.is_empty() || place.trim_matches('"') == at));
        assert!(found, "{text}\nexpected `{message}` at `{at}`, got {told:#?}");
        assert_eq!(told.len(), 1, "{text}: {told:#?}");
    }
}

#[test]
fn near_names_are_suggested() {
    for (text, near) in [
        (r#"<bsdf type="roughconducter"/>"#, "roughconductor"),
        (r#"<bsdf type="dielectric"><string name="int_ior" value="dimond"/></bsdf>"#, "diamond"),
        (r#"<bsdf type="diffuse"><texture name="reflectance" type="bitmep"/></bsdf>"#, "bitmap"),
    ] {
        let told = mistakes(text);
        assert!(told.iter().any(|(_, words)| words.contains(&format!("did you mean `{near}`?"))), "{told:#?}");
    }
}

#[test]
fn blends_hold_eight_lobes_and_no_more() {
    fn nest(n: usize) -> String {
        match n {
            1 => r#"<bsdf type="diffuse"/>"#.to_owned(),
            n => format!(r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/>{}{}</bsdf>"#, nest(1), nest(n - 1)),
        }
    }
    let scene = compiled(&nest(8));
    let b = bsdf(&scene, Vec3::Z, Vec2::ZERO);
    assert_eq!((b.len(), material(&scene).lobes()), (8, 8));
    // Eight shares of the same thing are the thing.
    let f = b.eval(Vec3::Z, Vec3::new(0.6, 0.0, 0.8)).0.x;
    assert!((f - 0.5 * FRAC_1_PI).abs() < 1e-6, "{f}");
    let told = mistakes(&nest(9));
    assert!(told.len() == 1 && told[0].1.contains("up to 9"), "{told:#?}");
}

#[test]
fn blends_and_masks_weigh_their_parts() {
    let scene = compiled(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.25"/>
           <bsdf type="diffuse"><float name="reflectance" value="0.8"/></bsdf>
           <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="diffuse"><float name="reflectance" value="0.4"/></bsdf></bsdf>
           </bsdf>"#,
    );
    let b = bsdf(&scene, Vec3::Z, Vec2::ZERO);
    let f = b.eval(Vec3::Z, Vec3::Z).0.x;
    assert!((f - (0.75 * 0.8 + 0.25 * 0.5 * 0.4) * FRAC_1_PI).abs() < 1e-6);
    assert!((b.transparency(Vec3::Z).0.x - 0.125).abs() < 1e-6);
    assert!(material(&scene).may_be_transparent() && scene.has_transparent);
}

#[test]
fn opaque_masks_are_not_transparent() {
    let scene = compiled(r#"<bsdf type="mask"><float name="opacity" value="1"/><bsdf type="diffuse"/></bsdf>"#);
    assert!(!material(&scene).may_be_transparent());
}

#[test]
fn two_sided_surfaces_show_their_own_back() {
    let scene = compiled(
        r#"<bsdf type="twosided"><bsdf type="diffuse"><float name="reflectance" value="0.2"/></bsdf>
           <bsdf type="diffuse"><float name="reflectance" value="0.6"/></bsdf></bsdf>"#,
    );
    let (up, down) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.0, -0.8));
    let f = |wo: Vec3, wi: Vec3| bsdf(&scene, wo, Vec2::ZERO).eval(wo, wi).0.x;
    assert!((f(up, Vec3::Z) - 0.2 * FRAC_1_PI).abs() < 1e-6);
    assert!((f(down, -Vec3::Z) - 0.6 * FRAC_1_PI).abs() < 1e-6);
    assert_eq!((f(up, -Vec3::Z), f(down, Vec3::Z)), (0.0, 0.0));
}

#[test]
fn normal_maps_turn_the_cosine() {
    let options = r#"<boolean name="use_shadowing_function" value="false"/><bsdf type="diffuse"><float name="reflectance" value="1"/></bsdf>"#;
    let scene = compiled(&format!(r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.8 0.5 0.9"/>{options}</bsdf>"#));
    let n = Vec3::new(0.6, 0.0, 0.8);
    let b = bsdf(&scene, Vec3::Z, Vec2::ZERO);
    for wi in directions() {
        let f_cos = b.eval(Vec3::Z, wi).0.x * wi.z.abs();
        let want = if wi.z > 0.0 { FRAC_1_PI * wi.dot(n).max(0.0) } else { 0.0 };
        assert!((f_cos - want).abs() < 1e-5, "{wi}: {f_cos}, expected {want}");
    }
}

#[test]
fn invalid_normals_are_mirrored_unless_told_otherwise() {
    let scene = |flip: bool| {
        compiled(&format!(
            r#"<bsdf type="normalmap"><rgb name="normalmap" value="0.8 0.5 0.9"/><boolean name="flip_invalid_normals" value="{flip}"/>
               <boolean name="use_shadowing_function" value="false"/><bsdf type="diffuse"/></bsdf>"#
        ))
    };
    let wo = Vec3::new(-0.96, 0.0, 0.28);
    let mirrored = Vec3::new(-0.6, 0.0, 0.8);
    let f = |flip| bsdf(&scene(flip), wo, Vec2::ZERO).eval(wo, Vec3::Z).0.x;
    assert_eq!(f(false), 0.0);
    assert!((f(true) - 0.5 * FRAC_1_PI * mirrored.z).abs() < 1e-6);
}

#[test]
fn bump_maps_follow_the_height_in_the_surface_s_units() {
    // A rectangle of 2 by 2 has ∂p/∂u = (2, 0, 0); the height rises by `scale` · 2 over a texel of width 1/4.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ramp.exr");
    let heights = [0.0, 0.5, 1.0, 1.5].repeat(4);
    let picture = etendue_image::Image::from_data(4, 4, &["Y"], heights).unwrap();
    etendue_image::save(&path, &picture.into(), &Default::default()).unwrap();
    let scene = compiled(&format!(
        r#"<bsdf type="bumpmap"><texture type="bitmap"><string name="filename" value="{}"/><boolean name="raw" value="true"/></texture>
           <float name="scale" value="0.5"/><boolean name="use_shadowing_function" value="false"/>
           <bsdf type="diffuse"><float name="reflectance" value="1"/></bsdf></bsdf>"#,
        path.display()
    ));
    // dh/du = 0.5 · 0.5 · 4 = 1, and so dh/dx = 1/2: the normal is (-1/2, 0, 1).
    let n = Vec3::new(-0.5, 0.0, 1.0).normalize();
    let b = bsdf(&scene, Vec3::Z, Vec2::new(0.45, 0.5));
    for wi in directions().filter(|w| w.z > 0.0) {
        let want = FRAC_1_PI * wi.dot(n).max(0.0);
        assert!((b.eval(Vec3::Z, wi).0.x * wi.z - want).abs() < 1e-5);
    }
}

#[test]
fn surfaces_without_a_material_are_grey_and_lights_black() {
    let grey = compiled("");
    assert_eq!(bsdf(&grey, Vec3::Z, Vec2::ZERO).diffuse_reflectance(), Spectrum::rgb(0.5, 0.5, 0.5));
    let light = compiled(r#"<emitter type="area"><rgb name="radiance" value="1"/></emitter>"#);
    assert_eq!(bsdf(&light, Vec3::Z, Vec2::ZERO).diffuse_reflectance(), Spectrum::ZERO);
}

#[test]
fn shared_materials_are_compiled_once() {
    let scene = compiled(
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/>
           <bsdf type="diffuse" id="one"><float name="reflectance" value="0.3"/></bsdf><ref id="one"/></bsdf>"#,
    );
    let same = |m: &&Material| matches!(m, Material::Diffuse(d) if d.reflectance == ColorSlot::from([0.3; 3]));
    assert_eq!(scene.materials.iter().filter(same).count(), 1);
}

#[test]
fn metals_have_measured_colours() {
    let scene = compiled(r#"<bsdf type="conductor"><string name="material" value="Au"/></bsdf>"#);
    let wo = Vec3::Z;
    let s = bsdf(&scene, wo, Vec2::ZERO).sample(wo, 0.5, Vec2::splat(0.5)).unwrap();
    let [r, g, b] = s.weight.to_rgb();
    assert!(r > 0.9 && g > 0.6 && g < r && b < g, "gold is ({r}, {g}, {b})");
}
