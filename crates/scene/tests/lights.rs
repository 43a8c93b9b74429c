//! The battery of the emitters, a row each: what is drawn follows its density, what is estimated meets closed forms, and light that
//! sets out carries what light that is looked for brings.

mod lighting;

use etendue_check::{ChiSquareTest, Moments, Sphere, compare_means, family_wise, rng, z_test};
use etendue_image::{Image, Picture, SaveOptions};
use etendue_numerics::{Pdf, Ray, Vec2, Vec3};
use etendue_scene::{LightReference, Scene};
use lighting::{WL, grey, irradiance, look, on_square, scene, scene_in};
use std::f64::consts::PI;

/// The chance that a whole battery raises a false alarm.
const ALPHA: f64 = 1e-4;

const RED: &str = r#"<rgb name="radiance" value="3, 2, 1"/>"#;

/// Pictures that the rows name, in a folder that lives as long as the value.
fn pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut r = rng(77);
    let save = |name: &str, w: usize, h: usize, f: &mut dyn FnMut(usize, usize) -> f32| {
        let data = (0..w * h).flat_map(|i| [f(i % w, i / w), f(i % w, i / w) * 0.5, f(i % w, i / w) * 0.25]).collect();
        let picture = Picture::from(Image::rgb(w, h, data).expect("a picture"));
        etendue_image::save(&folder.path().join(name), &picture, &SaveOptions::default()).expect("saved");
    };
    save("sky.exr", 24, 13, &mut |_, _| r.u1() + 0.1);
    // A sun: one texel two thousand times as bright as the rest, and a black half.
    save("sun.exr", 32, 16, &mut |x, y| {
        if (x, y) == (5, 4) {
            2000.0
        } else if x < 16 {
            1.0
        } else {
            0.0
        }
    });
    save("slide.exr", 6, 4, &mut |x, y| 0.2 + ((x * 5 + y * 3) % 7) as f32 * 0.3);
    folder
}

/// A name, the emitter, and where it is looked at from.
fn sampled_rows() -> Vec<(&'static str, String, LightReference)> {
    let area = |shape: &str, inside: &str| format!(r#"<shape type="{shape}">{inside}<emitter type="area">{RED}</emitter></shape>"#);
    let place = |s: f64| {
        format!(r#"<transform name="to_world"><scale value="{s}"/><rotate x="1" angle="30"/><translate z="2"/></transform>"#)
    };
    let facing = |p: [f32; 3]| LightReference { p: p.into(), n: Vec3::Z, one_sided: true, shared: false };
    let free = |p: [f32; 3]| LightReference::point(p.into());
    let surface = LightReference { p: Vec3::ZERO, n: Vec3::new(0.6, 0.0, 0.8), one_sided: false, shared: false };
    let textured = r#"<emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="slide.exr"/></texture></emitter>"#;
    let sky = |file: &str| {
        format!(
            r#"<emitter type="envmap"><string name="filename" value="{file}"/><transform name="to_world"><rotate x="1" angle="70"/></transform></emitter>"#
        )
    };
    let flip = r#"<boolean name="flip_normals" value="true"/>"#;
    vec![
        ("rectangle", area("rectangle", &format!("{}{flip}", place(0.7))), facing([0.2, 0.1, 0.0])),
        ("rectangle afar", area("rectangle", &format!("{}{flip}", place(0.05))), free([0.2, 0.1, 0.0])),
        ("picture", format!(r#"<shape type="rectangle">{}{flip}{textured}</shape>"#, place(1.0)), facing([0.2, 0.1, 0.0])),
        ("sphere", area("sphere", &place(0.5)), facing([0.2, 0.1, 0.0])),
        ("sphere inside", area("sphere", &format!("{flip}{}", place(3.0))), free([0.2, 0.1, 0.0])),
        ("disk", area("disk", &format!("{}{flip}", place(1.0))), facing([0.3, -0.1, 0.1])),
        ("cube", area("cube", &place(0.4)), facing([0.2, 0.1, 0.0])),
        (
            "two",
            area("cube", &place(0.3))
                + &area("sphere", r#"<point name="center" value="2, 1, 1"/><float name="radius" value=".7"/>"#),
            free([0.0, 0.0, 0.0]),
        ),
        ("sky", sky("sky.exr"), free([0.0; 3])),
        ("sun", sky("sun.exr"), surface),
        ("sky beside a walk", sky("sky.exr"), LightReference { shared: true, ..surface }),
        ("sun beside a walk", sky("sun.exr"), LightReference { shared: true, ..free([0.0; 3]) }),
        (
            "sun and sphere beside a walk",
            sky("sun.exr") + &area("sphere", &place(0.5)),
            LightReference { shared: true, ..facing([0.2, 0.1, 0.0]) },
        ),
        (
            "sky and constant beside a walk",
            sky("sky.exr") + r#"<emitter type="constant"/>"#,
            LightReference { shared: true, ..surface },
        ),
        ("constant", r#"<emitter type="constant"/>"#.into(), free([0.0; 3])),
        ("constant, one side", r#"<emitter type="constant"/>"#.into(), LightReference { one_sided: true, ..surface }),
        ("constant, both sides", r#"<emitter type="constant"/>"#.into(), surface),
        ("sky and constant", sky("sky.exr") + r#"<emitter type="constant"/>"#, surface),
        ("sky and sphere", sky("sky.exr") + &area("sphere", &place(0.5)), free([0.2, 0.1, 0.0])),
    ]
}

#[test]
fn samples_follow_their_density() {
    let folder = pictures();
    let rows = sampled_rows();
    let alpha = family_wise(ALPHA, rows.len());
    for (name, emitter, from) in rows {
        let scene = scene_in(folder.path(), &emitter);
        // Surroundings are drawn behind things as well.
        let density =
            |wi: Vec3| look(&scene, from.p, wi).map_or(0.0, |x| scene.pdf_light(&from, &x)) + scene.pdf_light_escaped(&from, wi);
        // The choice of the light is the fourth number, drawn apart.
        let mut r = rng(5);
        let sample = |[x, y, _]: [f32; 3]| scene.sample_light(&from, r.u1(), Vec2::new(x, y), &WL).map(|s| s.wi);
        let report = ChiSquareTest::new(Sphere).samples(30_000).run(sample, density);
        assert!(report.passes(alpha), "{name}: {report}");
    }
}

#[test]
fn a_sample_carries_the_density_and_the_light_of_its_direction() {
    let folder = pictures();
    for (name, emitter, from) in sampled_rows() {
        let scene = scene_in(folder.path(), &emitter);
        let mut r = rng(6);
        for _ in 0..500 {
            let Some(s) = scene.sample_light(&from, r.u1(), r.u2(), &WL) else { continue };
            let hit = look(&scene, from.p, s.wi);
            if hit.is_some() && s.distance.is_infinite() {
                continue;
            }
            let (seen, le, pdf) = match hit {
                Some(x) => (x.p.distance(from.p), scene.le(&x, &WL), scene.pdf_light(&from, &x)),
                None => {
                    let ray = Ray::new(from.p, s.wi);
                    (f32::INFINITY, scene.le_escaped(&ray, &WL), scene.pdf_light_escaped(&from, s.wi))
                }
            };
            // A sphere's rim, a triangle's edge and a texel's border may fall to the other side by rounding.
            let same = seen == s.distance || (seen / s.distance - 1.0).abs() < 1e-3;
            let alike = |a: f64, b: f64| (a / b - 1.0).abs() < 2e-2;
            let fine = same && alike(grey(le), grey(s.le)) && alike(f64::from(pdf), f64::from(s.pdf.value()));
            let rare = r.u1() < 0.02;
            assert!(fine || rare, "{name}: at {seen} {le:?} {pdf}, sampled {s:?}");
        }
    }
}

/// π E of a polygon of radiance 1 as Lambert's formula has it: ½ Σ θ_i cosγ_i over its edges.
fn lambert(p: Vec3, n: Vec3, polygon: &[Vec3]) -> f64 {
    let to = |q: Vec3| (q - p).as_dvec3().normalize();
    let edge = |(a, b): (Vec3, Vec3)| to(a).dot(to(b)).acos() * to(a).cross(to(b)).normalize().dot(n.as_dvec3());
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| edge((*a, *b))).sum::<f64>().abs()
}

#[test]
fn irradiance_meets_closed_forms() {
    let folder = pictures();
    let p = Vec3::new(0.3, -0.2, 0.0);
    let corners = [[-1.0, -2.0], [1.0, -2.0], [1.0, 2.0], [-1.0, 2.0]].map(|[x, y]: [f32; 2]| Vec3::new(x, y, 2.5));
    let down = r#"<transform name="to_world"><scale x="1" y="2"/><rotate x="1" angle="180"/><translate z="2.5"/></transform>"#;
    let spot = |extra: &str| {
        format!(
            r#"<emitter type="spot">{extra}<transform name="to_world"><lookat origin="0.3, -0.2, 2" target="0.3, -0.2, 0" up="0, 1, 0"/></transform></emitter>"#
        )
    };
    let d2: f64 = 0.3 * 0.3 + 0.2 * 0.2 + 4.0;
    let stack: String = (0..40)
        .map(|i| {
            format!(r#"<emitter type="point"><point name="position" value="{}, 0.1, 3"/></emitter>"#, 0.2 * f64::from(i) - 4.0)
        })
        .collect();
    let stacked: f64 = (0..40)
        .map(|i| {
            let d = [0.2 * f64::from(i) - 4.0 - 0.3, 0.3, 3.0];
            3.0 / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).powf(1.5)
        })
        .sum();
    let rows: Vec<(&str, String, f64)> = vec![
        // E = I cosθ / r²
        ("point", r#"<emitter type="point"><rgb name="intensity" value="3, 2, 1"/><point name="position" value="0, 0, 2"/></emitter>"#.into(), 2.0 * 2.0 / d2.powf(1.5)),
        ("40 points", stack, stacked),
        ("spot", spot(""), 0.25),
        ("directional", r#"<emitter type="directional"><vector name="direction" value="0, 3, -4"/><rgb name="irradiance" value="5"/></emitter>"#.into(), 4.0),
        // E = π L r² cosθ / d² above the horizon
        ("sphere", r#"<shape type="sphere"><point name="center" value="0, 0, 2"/><float name="radius" value="0.7"/><emitter type="area"/></shape>"#.into(), PI * 0.49 / d2 * 2.0 / d2.sqrt()),
        ("quad", format!(r#"<shape type="rectangle">{down}<emitter type="area"/></shape>"#), lambert(p, Vec3::Z, &corners)),
        ("constant", r#"<emitter type="constant"/>"#.into(), PI),
        ("all at once", r#"<emitter type="constant"/><emitter type="directional"><vector name="direction" value="0, 0, -1"/></emitter>"#.to_owned() + &format!(r#"<shape type="rectangle">{down}<emitter type="area"><float name="radiance" value="3"/></emitter></shape>"#), PI + 2.0 * lambert(p, Vec3::Z, &corners)),
        // π s t / z² straight below
        ("projector", r#"<emitter type="projector"><float name="scale" value="2"/><float name="fov" value="90"/><transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform></emitter>"#.into(), PI * 2.0 / 4.0),
    ];
    let alpha = family_wise(ALPHA, rows.len());
    for (name, emitter, expected) in rows {
        let scene = scene_in(folder.path(), &emitter);
        let measured = irradiance(&scene, p, Vec3::Z, 20_000, &mut rng(3));
        // Deterministic where there is one light and no area: rounding is all that may differ.
        let exact = (measured.mean / expected - 1.0).abs() < 1e-5;
        // "all at once": the sun is behind the quad.
        assert!(
            exact || z_test(&measured, expected).p_value > alpha,
            "{name}: {} ± {}, expected {expected}",
            measured.mean,
            measured.standard_error()
        );
    }
}

/// Emitters whose whole light is known, over a unit square in z = 0 that receives some of it.
fn emitting_rows() -> Vec<(&'static str, String)> {
    let area = |shape: &str, at: &str, emitter: &str| format!(r#"<shape type="{shape}">{at}{emitter}</shape>"#);
    let glow = format!(r#"<emitter type="area">{RED}</emitter>"#);
    let down = r#"<transform name="to_world"><scale x="0.6" y="0.3"/><rotate x="1" angle="160"/><translate z="1.5"/></transform>"#;
    let above = r#"<transform name="to_world"><scale value="0.4"/><rotate x="1" y="0" z="0" angle="50"/><translate x="0.4" z="1.5"/></transform>"#;
    let aim = r#"<transform name="to_world"><lookat origin="0.5, -0.4, 1.5" target="0.2, 0.1, 0" up="0, 1, 0"/></transform>"#;
    let slide =
        |name: &str| format!(r#"<texture type="bitmap" name="{name}"><string name="filename" value="slide.exr"/></texture>"#);
    vec![
        ("rectangle", area("rectangle", down, &glow)),
        ("picture", area("rectangle", down, &format!(r#"<emitter type="area">{}</emitter>"#, slide("radiance")))),
        ("sphere", area("sphere", above, &glow)),
        ("disk", area("disk", down, &glow)),
        ("cylinder", area("cylinder", above, &glow)),
        ("cube", area("cube", above, &glow)),
        ("point", r#"<emitter type="point"><point name="position" value=".2, 0, 1"/></emitter>"#.into()),
        ("spot", format!(r#"<emitter type="spot"><float name="cutoff_angle" value="35"/>{}{aim}</emitter>"#, slide("texture"))),
        ("directional", r#"<emitter type="directional"><vector name="direction" value="1, -.5, -2"/></emitter>"#.into()),
        ("sky", r#"<emitter type="envmap"><string name="filename" value="sun.exr"/></emitter>"#.into()),
        ("constant", r#"<emitter type="constant"/>"#.into()),
        ("projector", format!(r#"<emitter type="projector">{}{aim}</emitter>"#, slide("irradiance"))),
        (
            "several",
            area("cube", above, &glow)
                + r#"<emitter type="point"><point name="position" value=".2, 0, 1"/></emitter><emitter type="constant"/>"#,
        ),
    ]
}

const RECEIVER: &str = r#"<shape type="rectangle"/>"#;

#[test]
fn light_that_sets_out_carries_what_light_that_is_looked_for_brings() {
    let folder = pictures();
    let rows = emitting_rows();
    let alpha = family_wise(ALPHA, rows.len());
    for (name, emitter) in rows {
        let scene = scene_in(folder.path(), &(RECEIVER.to_owned() + &emitter));
        let receiver = 0;
        let (mut emitted, mut received, mut r) = (Moments::default(), Moments::default(), rng(9));
        for _ in 0..60_000 {
            // Flux onto the receiver's front, of particles that meet it first.
            let s = scene.lights.sample_emission(&scene, r.u1(), r.u2(), r.u2(), &WL);
            let hit = s.and_then(|s| scene.intersect(&s.ray).filter(|h| h.geometry == receiver).map(|_| s));
            emitted.add(hit.filter(|s| s.ray.d.z < 0.0).map_or(0.0, |s| grey(s.weight)));

            // The same as 4 m² times the mean irradiance.
            let q = on_square(r.u2(), 1.0);
            received.add(4.0 * irradiance(&scene, q.extend(1e-4), Vec3::Z, 1, &mut r).mean);
        }
        let test = compare_means(&emitted, &received);
        let sharp = test.standard_error < 0.05 * received.mean;
        assert!(test.p_value > alpha && sharp, "{name}: {} and {} ± {}", emitted.mean, received.mean, test.standard_error);
    }
}

#[test]
fn power_meets_closed_forms_and_what_sets_out() {
    let folder = pictures();
    let (b, c) = (0.3f64, 0.8f64);
    let spot = format!(
        r#"<emitter type="spot"><float name="cutoff_angle" value="{}"/><float name="beam_width" value="{}"/></emitter>"#,
        c.to_degrees(),
        b.to_degrees()
    );
    let area = |shape: &str, at: &str| format!(r#"<shape type="{shape}">{at}<emitter type="area">{RED}</emitter></shape>"#);
    // The receiver's sphere is (0, 0, 0), √2; the scene's is a ten-thousandth larger.
    let disk = PI * 2.0 * 1.0001f64.powi(2);
    let rows: Vec<(&str, String, Option<f64>)> = vec![
        ("sphere", area("sphere", r#"<float name="radius" value="0.5"/>"#), Some(2.0 * PI * PI)),
        ("rectangle", area("rectangle", r#"<transform name="to_world"><scale x="2" y="3"/></transform>"#), Some(2.0 * PI * 24.0)),
        ("cube", area("cube", ""), Some(2.0 * PI * 24.0)),
        ("point", r#"<emitter type="point"><rgb name="intensity" value="3, 2, 1"/></emitter>"#.into(), Some(8.0 * PI)),
        ("spot", spot, Some(2.0 * PI * (1.0 - (c.sin() - b.sin()) / (c - b)))),
        ("directional", r#"<emitter type="directional"/>"#.into(), Some(disk)),
        ("constant", r#"<emitter type="constant"/>"#.into(), Some(4.0 * PI * disk)),
        ("projector", r#"<emitter type="projector"><float name="fov" value="90"/></emitter>"#.into(), Some(4.0 * PI)),
        ("laser", r#"<shape type="rectangle"><emitter type="directionalarea"/></shape>"#.into(), Some(4.0)),
        ("sky", r#"<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"#.into(), None),
        ("sun", r#"<emitter type="envmap"><string name="filename" value="sun.exr"/></emitter>"#.into(), None),
        ("picture", r#"<shape type="rectangle"><emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="slide.exr"/></texture></emitter></shape>"#.into(), None),
    ];
    let alpha = family_wise(ALPHA, rows.len());
    for (name, emitter, closed) in rows {
        let scene = scene_in(folder.path(), &(RECEIVER.to_owned() + &emitter));
        let power = grey(scene.emitters[0].power(&scene));
        if let Some(closed) = closed {
            assert!((power / closed - 1.0).abs() < 1e-3, "{name}: {power} W, expected {closed}");
        }
        let (mut moments, mut r) = (Moments::default(), rng(4));
        for _ in 0..20_000 {
            let s = scene.lights.sample_emission(&scene, r.u1(), r.u2(), r.u2(), &WL);
            moments.add(s.map_or(0.0, |s| grey(s.weight)));
        }
        // Quadratures over pictures are good to a few thousandths.
        let near = (moments.mean / power - 1.0).abs() < 4e-3;
        assert!(near || z_test(&moments, power).p_value > alpha, "{name}: {power} W, but {} W set out", moments.mean);
    }
}

#[test]
fn emission_densities_are_the_same_from_both_sides() {
    let folder = pictures();
    for (name, emitter) in emitting_rows() {
        let scene = scene_in(folder.path(), &emitter);
        let mut r = rng(8);
        for _ in 0..300 {
            let Some(s) = scene.lights.sample_emission(&scene, r.u1(), r.u2(), r.u2(), &WL) else { continue };
            assert!(s.weight.is_finite() && s.ray.d.is_normalized(), "{name}: {s:?}");
            let environment = scene.lights.environments().contains(&s.emitter);
            let pdf = if environment {
                scene.lights.pdf_emission_escaped(&scene, s.emitter, -s.ray.d)
            } else if let (false, Pdf::SolidAngle(_)) = (s.pdf.position.is_delta(), s.pdf.direction) {
                // Look back at where it came from, from a little way off.
                let Some(x) = look(&scene, s.ray.at(1e-3), -s.ray.d) else { continue };
                if x.p.distance(s.ray.o) > 1e-3 {
                    continue;
                }
                scene.lights.pdf_emission(&scene, &x)
            } else {
                continue;
            };
            let alike = |a: f32, b: f32| (a / b - 1.0).abs() < 2e-2 || (a - b).abs() < 1e-3;
            let fine = alike(pdf.position.value(), s.pdf.position.value()) && alike(pdf.direction.value(), s.pdf.direction.value());
            assert!(fine, "{name}: {pdf:?} and {:?}", s.pdf);
        }
    }
}

#[test]
fn the_ends_of_the_unit_interval_and_odd_places_do_no_harm() {
    let folder = pictures();
    let ends = [0.0, 1.0 - f32::EPSILON / 2.0];
    for (name, emitter) in emitting_rows() {
        let scene = scene_in(folder.path(), &emitter);
        for i in 0..32 {
            let u = |bit: usize| ends[i >> bit & 1];
            let emitted = scene.lights.sample_emission(&scene, u(0), Vec2::new(u(1), u(2)), Vec2::new(u(3), u(4)), &WL);
            assert!(
                emitted.is_none_or(|s| s.weight.is_finite() && s.ray.o.is_finite() && s.ray.d.is_finite()),
                "{name}: {emitted:?}"
            );
            for p in [Vec3::ZERO, Vec3::new(0.2, 0.0, 1.0), Vec3::new(0.0, 0.0, 1.5), Vec3::splat(1e5)] {
                for from in [LightReference::point(p), LightReference { p, n: Vec3::Z, one_sided: true, shared: false }] {
                    let s = scene.sample_light(&from, u(0), Vec2::new(u(1), u(2)), &WL);
                    let sane = s.is_none_or(|s| {
                        s.le.is_finite() && s.wi.is_normalized() && s.pdf.value() > 0.0 && s.pdf.value().is_finite()
                    });
                    assert!(sane, "{name} from {p}: {s:?}");
                }
            }
        }
    }
}

#[test]
fn a_light_of_sampling_weight_zero_is_left_to_scattered_rays() {
    let two = |weight: &str| {
        format!(
            r#"<emitter type="point"><point name="position" value="0, 0, 2"/></emitter><shape type="sphere"><emitter type="area">{weight}</emitter></shape>"#
        )
    };
    let from = LightReference::point(Vec3::new(0.0, 0.0, 3.0));
    let share = |scene: &Scene| {
        let mut r = rng(1);
        (0..1000).filter(|_| scene.sample_light(&from, r.u1(), r.u2(), &WL).is_some_and(|s| !s.pdf.is_delta())).count()
    };
    let plain = scene(&two(""));
    assert!(share(&plain) > 100);
    let without = scene(&two(r#"<float name="sampling_weight" value="0"/>"#));
    assert_eq!(share(&without), 0);
    let x = look(&without, from.p, Vec3::NEG_Z).expect("the sphere");
    assert_eq!(without.pdf_light(&from, &x), 0.0);
    assert!(grey(without.le(&x, &WL)) > 0.0);
}
