//! Measured materials from file to f: a tabulated metal is the metal, whatever its channels are and what walks carry.

#[path = "../../bsdf/tests/battery/tabulated.rs"]
mod tabulated;
#[path = "../../formats/tests/common/tensor.rs"]
mod tensor;

use etendue_bsdf::lobes::MeasuredParams;
use etendue_bsdf::{Scatter, lobes::RoughConductor};
use etendue_description::Diagnostics;
use etendue_formats::{ReadOptions, read_str};
use etendue_numerics::{Ray, Vec3, Wavelengths, spectrum::upsample::Smooth};
use etendue_scene::{CompileOptions, Scene, compile};
use tabulated::Resolution;

const ALPHA: [f32; 2] = [0.4, 0.4];
const FINE: Resolution = Resolution { normals: 48, square: 24, theta: 12, phi: 1, part: 1.0 };

/// The file of a sample; `wavelengths` in place of red, green and blue, with as many tables.
fn file(p: &MeasuredParams, wavelengths: &[f32]) -> Vec<u8> {
    let directions = [p.phi.len(), p.theta.len()];
    let [n, m] = [p.ndf.size[0], p.luminance.size[0]];
    let channels = p.channels.len();
    let mut fields = vec![
        tensor::floats("phi_i", &[directions[0]], &p.phi),
        tensor::floats("theta_i", &[directions[1]], &p.theta),
        tensor::floats("ndf", &[n, n], &p.ndf.values),
        tensor::floats("sigma", &[n, n], &p.sigma.values),
        tensor::floats("vndf", &[directions[0], directions[1], n, n], &p.vndf.values),
        tensor::floats("luminance", &[directions[0], directions[1], m, m], &p.luminance.values),
        tensor::bytes("jacobian", &[1]),
    ];
    let name = if wavelengths.is_empty() { "rgb" } else { "spectra" };
    fields.push(tensor::floats(name, &[directions[0], directions[1], channels, m, m], &p.spectra.values));
    if !wavelengths.is_empty() {
        fields.push(tensor::floats("wavelengths", &[wavelengths.len()], wavelengths));
    }
    tensor::file(&fields)
}

/// A sphere of it, in pbrt's words or in Mitsuba's.
fn scene(file: Vec<u8>, pbrt: bool, spectral: bool) -> Scene {
    let mut options = ReadOptions::default();
    options.files.insert("gold.bsdf".into(), file.into());
    let text = if pbrt {
        "WorldBegin Material \"measured\" \"string filename\" \"gold.bsdf\" Shape \"sphere\""
    } else {
        "<scene version=\"3.0.0\"><shape type=\"sphere\"><bsdf type=\"measured\"><string name=\"filename\" value=\"gold.bsdf\"/></bsdf></shape></scene>"
    };
    let (description, said) = read_str(if pbrt { "s.pbrt" } else { "s.xml" }, text, &options);
    assert!(!said.has_errors(), "{}", said.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let scene = compile(&description, &CompileOptions { spectral, ..CompileOptions::default() }, &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// The largest error of f cosθ among some directions, relative to the largest value, with what `truth` should be by lane.
fn worst(scene: &Scene, wl: &Wavelengths, truth: impl Fn(&RoughConductor, Vec3, Vec3) -> [f32; 4]) -> f32 {
    let gold = tabulated::truth(ALPHA);
    let ray = Ray::new(Vec3::new(0.5, 0.2, 4.0), -Vec3::Z);
    let x = scene.interaction(&ray, &scene.intersect(&ray).expect("a hit"));
    let bsdf = scene.bsdf(&x, wl);
    let (mut worst, mut largest) = (0.0f32, 0.0f32);
    for (wo, wi) in [(0.0, 0.1), (0.4, 0.3), (0.5, -0.6), (0.9, 0.8)]
        .map(|(a, b): (f32, f32)| (Vec3::new(a.sin(), 0.0, a.cos()), Vec3::new(-b.sin() * 0.96, b.sin() * 0.28, b.cos())))
    {
        let (f, want) = (bsdf.eval(wo, wi) * wi.z, truth(&gold, wo, wi));
        for lane in 0..4 {
            worst = worst.max((f[lane] - want[lane] * wi.z).abs());
            largest = largest.max(want[lane]);
        }
    }
    worst / largest
}

#[test]
fn from_the_file_to_f() {
    let p = tabulated::params(ALPHA, &FINE, [0.0, 1.0, 2.0]);
    let rgb = |gold: &RoughConductor, wo, wi| {
        let [r, g, b] = gold.eval(wo, wi).to_rgb();
        [r, g, b, 0.0]
    };
    for pbrt in [true, false] {
        let off = worst(&scene(file(&p, &[]), pbrt, false), &Wavelengths::Rgb, rgb);
        assert!(off < 0.03, "{off}");
    }

    // The same numbers as values at three wavelengths: straight lines between them, and flat beyond.
    let nm = [450.0f32, 550.0, 650.0];
    let spectral = scene(file(&p, &nm), true, true);
    for u in [0.05, 0.3, 0.8] {
        let wl = Wavelengths::hero(u);
        let Wavelengths::Hero(hero) = &wl else { panic!("no wavelengths") };
        let waves = hero.nm().to_array();
        let off = worst(&spectral, &wl, |gold, wo, wi| {
            let f = gold.eval(wo, wi);
            waves.map(|w| {
                let t = ((w - 450.0) / 100.0).clamp(0.0, 2.0);
                let i = (t as usize).min(1);
                f[i] + (t - i as f32) * (f[i + 1] - f[i])
            })
        });
        assert!(off < 0.03, "{u}: {off}");
    }

    // Colours become smooth spectra, with a table every 10 nm.
    let upsampled = scene(file(&p, &[]), true, true);
    let wl = Wavelengths::hero(0.4);
    let Wavelengths::Hero(hero) = &wl else { panic!("no wavelengths") };
    let off = worst(&upsampled, &wl, |gold, wo, wi| {
        let f = gold.eval(wo, wi).to_rgb();
        let scale = 2.0 * f.into_iter().fold(0.0, f32::max);
        (Smooth::fit(f.map(|x| x / scale)).at(hero.nm()) * scale).to_array()
    });
    assert!(off < 0.04, "{off}");

    // The same at every wavelength is grey.
    let mut grey = p.clone();
    let size = grey.spectra.size[0] * grey.spectra.size[1];
    for tables in grey.spectra.values.chunks_exact_mut(3 * size) {
        let (first, rest) = tables.split_at_mut(size);
        rest.chunks_exact_mut(size).for_each(|t| t.copy_from_slice(first));
    }
    let off = worst(&scene(file(&grey, &nm), true, false), &Wavelengths::Rgb, |gold, wo, wi| {
        let f = gold.eval(wo, wi)[0];
        [f, f, f, 0.0]
    });
    assert!(off < 0.03, "{off}");
}

#[test]
fn what_is_not_there_is_told() {
    let said = |name: &str, text: &str| {
        let (description, said) = read_str(name, text, &ReadOptions::default());
        let mut diagnostics = said;
        let _ = compile(&description, &CompileOptions::default(), &mut diagnostics);
        diagnostics.render(&description.sources)
    };
    let pbrt = said("s.pbrt", "WorldBegin Material \"measured\" Shape \"sphere\"");
    assert!(pbrt.contains("a `measured` material needs the `filename` of what was measured"), "{pbrt}");
    let xml = said("s.xml", "<scene version=\"3.0.0\"><shape type=\"sphere\"><bsdf type=\"measured\"/></shape></scene>");
    assert!(xml.contains("`measured` needs the `filename` of a measured material"), "{xml}");
    let missing = said("s.pbrt", "WorldBegin Material \"measured\" \"string filename\" \"gold.bsdf\" Shape \"sphere\"");
    assert!(missing.contains("gold.bsdf"), "{missing}");
}
