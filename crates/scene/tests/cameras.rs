//! The battery of the sensors: rays against numbers of Mitsuba 3.9.1, We against its normalisation, and the same picture from rays
//! that leave the lens and from points that look for it.

mod lighting;

use etendue_check::{Moments, compare_means, family_wise, integrate_sphere, rng};
use etendue_numerics::{Pdf, Vec2, Vec3};
use etendue_scene::{Sensor, View};
use lighting::{on_square, scene};

const ALPHA: f64 = 1e-4;

fn film(width: u32, height: u32, more: &str) -> String {
    format!(r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>{more}</film>"#)
}

fn view(sensor: &str) -> View {
    scene(&format!(r#"<shape type="rectangle"/>{sensor}"#)).views.remove(0)
}

/// Every model, 8 × 6 pixels, looking down at the square [-2, 2]² in z = 0 from about 3 m.
fn rows() -> Vec<(&'static str, Sensor)> {
    let at = r#"<transform name="to_world"><lookat origin="0.3, -0.2, 3" target="0.1, 0.1, 0" up="0.2, 1, 0"/></transform>"#;
    let mirrored = r#"<transform name="to_world"><scale x="-1"/><lookat origin="0.3, -0.2, 3" target="0.1, 0.1, 0" up="0.2, 1, 0"/></transform>"#;
    let scaled = r#"<transform name="to_world"><scale x="0.8" y="0.9"/><lookat origin="0.3, -0.2, 3" target="0.1, 0.1, 0" up="0.2, 1, 0"/></transform>"#;
    let film = film(8, 6, "");
    let fov = r#"<float name="fov" value="40"/>"#;
    let lens = r#"<float name="aperture_radius" value="0.3"/><float name="focus_distance" value="2.2"/>"#;
    let shift = r#"<float name="principal_point_offset_x" value="0.1"/><float name="principal_point_offset_y" value="-0.15"/>"#;
    let sensor = |model: &str, inside: &str| view(&format!(r#"<sensor type="{model}">{film}{inside}</sensor>"#)).sensor;
    vec![
        ("perspective", sensor("perspective", &format!("{at}{fov}"))),
        ("perspective, shifted and mirrored", sensor("perspective", &format!("{mirrored}{fov}{shift}"))),
        ("thinlens", sensor("thinlens", &format!("{at}{fov}{lens}"))),
        ("orthographic", sensor("orthographic", scaled)),
    ]
}

const SIZE: Vec2 = Vec2::new(8.0, 6.0);

#[test]
fn rays_are_those_of_mitsuba() {
    // sample_ray(0, 0, (x, y), (0.3, 0.6)) of Mitsuba 3.9.1, 80 × 60 pixels: origin, direction, length.
    let look = r#"<transform name="to_world"><lookat origin="1, 2, 3" target="4, 2, 3" up="0, 0, 1"/></transform>"#;
    let clip = r#"<float name="near_clip" value="0.1"/><float name="far_clip" value="10"/>"#;
    let fov = r#"<float name="fov" value="50"/>"#;
    let shift = r#"<float name="principal_point_offset_x" value="0.1"/><float name="principal_point_offset_y" value="0.2"/>"#;
    let crop = r#"<integer name="crop_offset_x" value="20"/><integer name="crop_offset_y" value="10"/><integer name="crop_width" value="40"/><integer name="crop_height" value="20"/>"#;
    let lens = r#"<float name="aperture_radius" value="0.5"/><float name="focus_distance" value="3"/>"#;
    let scale = r#"<transform name="to_world"><scale x="3" y="2" z="4"/></transform><float name="near_clip" value="1"/>"#;
    let axis = |name: &str| format!(r#"<float name="fov" value="60"/><string name="fov_axis" value="{name}"/>"#);
    type Row<'a> = (&'a str, String, &'a str, [f32; 2], [f32; 7]);
    let rows: [Row; 9] = [
        (
            "perspective",
            String::new(),
            "",
            [0.25, 0.75],
            [0.001_730_66, -0.001_298, 0.01, 0.169_153_53, -0.126_865_1, 0.977_390_6, 10_231.314],
        ),
        (
            "perspective",
            axis("y"),
            "",
            [0.0, 0.0],
            [0.007_698, 0.005_773_5, 0.01, 0.554_700_2, 0.416_025_13, 0.720_576_7, 13_877.76],
        ),
        (
            "perspective",
            r#"<string name="focal_length" value="35mm"/>"#.into(),
            "",
            [0.0, 0.0],
            [0.004_944_76, 0.003_708_57, 0.01, 0.420_614_7, 0.315_460_98, 0.850_627_8, 11_756.013],
        ),
        (
            "perspective",
            format!("{look}{clip}{fov}"),
            "",
            [0.25, 0.75],
            [1.1, 2.023_315_4, 2.982_513_4, 0.960_057_85, 0.223_841_18, -0.167_880_83, 10.311_879],
        ),
        (
            "perspective",
            format!("{fov}{shift}"),
            "",
            [0.25, 0.75],
            [0.001_398_92, -0.003_147_58, 0.01, 0.132_266_03, -0.297_598_4, 0.945_484_46, 10_576.577],
        ),
        (
            "perspective",
            fov.into(),
            crop,
            [0.25, 0.75],
            [0.001_165_77, 0.000_582_88, 0.01, 0.115_599_17, 0.057_799_58, 0.991_612_85, 10_084.571],
        ),
        (
            "thinlens",
            format!("{fov}{lens}"),
            "",
            [0.25, 0.75],
            [-0.181_828_41, 0.074_532_93, 0.01, 0.277_639_1, -0.188_747_85, 0.941_961_17, 10_616.138],
        ),
        ("orthographic", String::new(), "", [0.25, 0.75], [0.5, -0.374_999_88, 0.01, 0.0, 0.0, 1.0, 9_999.99]),
        ("orthographic", scale.into(), "", [0.25, 0.75], [1.5, -0.749_999_76, 4.0, 0.0, 0.0, 1.0, 9_999.0]),
    ];
    for (model, inside, crop, at, expected) in rows {
        let view = view(&format!(r#"<sensor type="{model}">{inside}{}</sensor>"#, film(80, 60, crop)));
        let [offset, size] = [view.film.crop_offset, view.film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let ray = view.sensor.sample_ray(offset + Vec2::from(at) * size, Vec2::new(0.3, 0.6), 0.0).ray;
        let found = [ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z, ray.t_max];
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-6 + 1e-6 * b.abs(), "{model} {inside}: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn a_point_on_a_ray_finds_the_place_on_the_film_that_the_ray_came_from() {
    let mut r = rng(1);
    for (name, sensor) in rows() {
        for _ in 0..2000 {
            let (pixel, lens) = (r.u2() * SIZE, r.u2());
            let sent = sensor.sample_ray(pixel, lens, 0.3);
            assert_eq!((sent.weight, sent.ray.time), (1.0, 0.3));
            let y = sent.ray.at(10.0 * r.u1() + 0.5);
            let Some(seen) = sensor.sample_direction(y, lens) else {
                let margin = pixel.min(SIZE - pixel).min_element();
                assert!(margin < 1e-4, "{name}: {pixel} is not found again");
                continue;
            };
            assert!((seen.pixel - pixel).length() < 2e-3, "{name}: {} from {pixel}", seen.pixel);
            assert!((seen.wi + sent.ray.d).length() < 1e-5 && seen.p.distance(sent.ray.o) < 1e-4, "{name}: {seen:?} from {sent:?}");
            assert!(seen.we > 0.0 && seen.we.is_finite() && seen.pdf.value() > 0.0);
        }
    }
}

#[test]
fn importance_is_one_for_each_pixel() {
    // ∫ We cosθ dw over the film, from the middle of the lens, times the lens's area: W · H.
    for (name, sensor) in rows() {
        let ray = sensor.sample_ray(0.5 * SIZE, Vec2::splat(0.5), 0.0).ray;
        let (position, _) = sensor.pdf(ray.o, ray.d);
        if let Pdf::Delta(_) = sensor.pdf(ray.o, ray.d).1 {
            // Parallel rays: the density by area says it all.
            let seen = sensor.sample_direction(ray.at(1.0), Vec2::ZERO).expect("the middle is seen");
            assert!((position.value() * 48.0 / seen.we - 1.0).abs() < 1e-5, "{name}");
            continue;
        }
        let axis = sensor.sample_ray(0.5 * SIZE, Vec2::splat(0.5), 0.0);
        let lens = axis.ray.at(-axis.ray.o.distance(Vec3::new(0.3, -0.2, 3.0)));
        let forward = (Vec3::new(0.1, 0.1, 0.0) - Vec3::new(0.3, -0.2, 3.0)).normalize();
        let whole = integrate_sphere(|w| f64::from(sensor.we(lens, w) * w.dot(forward).max(0.0)));
        let share = if position.is_delta() { 1.0 } else { 1.0 / f64::from(position.area()) };
        assert!((whole * share / 48.0 - 1.0).abs() < 5e-3, "{name}: {}", whole * share);
        // And the density of rays, q uniform over the film, integrates to one.
        let density = integrate_sphere(|w| f64::from(sensor.pdf(lens, w).1.solid_angle()));
        assert!((density - 1.0).abs() < 5e-3, "{name}: {density}");
        // We cosθ is the density of rays times the number of pixels.
        let (pixel, d) = (Vec2::new(2.3, 4.1), 48.0);
        let ray = sensor.sample_ray(pixel, Vec2::splat(0.5), 0.0).ray;
        let product =
            sensor.pdf(lens, ray.d).1.solid_angle() * position.value() * d / (sensor.we(lens, ray.d) * ray.d.dot(forward));
        assert!((product - 1.0).abs() < 1e-4, "{name}: {product}");
    }
}

#[test]
fn pixels_from_the_lens_and_from_the_scene_agree() {
    // A plane z = 0 with a radiance that varies; each pixel by rays from the lens, and by points of the plane that look for the lens.
    let radiance = |y: Vec3| f64::from(1.0 + (3.0 * y.x).sin() * 0.6 + 0.3 * y.y);
    let half = 2.0;
    let pixels = [(0, 0), (3, 2), (7, 5), (2, 4)];
    let rows = rows();
    let alpha = family_wise(ALPHA, rows.len() * pixels.len());
    for (name, sensor) in rows {
        let mut r = rng(11);
        let mut seen = [Moments::default(); 4];
        for (moments, (i, j)) in seen.iter_mut().zip(pixels) {
            for _ in 0..20_000 {
                let ray = sensor.sample_ray(Vec2::new(i as f32, j as f32) + r.u2(), r.u2(), 0.0).ray;
                let y = ray.at(-ray.o.z / ray.d.z);
                let on_plane = y.x.abs() < half && y.y.abs() < half;
                moments.add(if on_plane { radiance(y) } else { 0.0 });
            }
        }
        let mut found = [Moments::default(); 4];
        for _ in 0..200_000 {
            let y = on_square(r.u2(), half).extend(0.0);
            let sample = sensor.sample_direction(y, r.u2());
            let place = sample.map(|s| (s.pixel.x as i32, s.pixel.y as i32));
            for (moments, pixel) in found.iter_mut().zip(pixels) {
                let hit = sample.filter(|_| place == Some(pixel));
                let area = f64::from(4.0 * half * half);
                moments.add(hit.map_or(0.0, |s| radiance(y) * f64::from(s.wi.z * s.we / s.pdf.value()) * area));
            }
        }
        for (k, pixel) in pixels.iter().enumerate() {
            let test = compare_means(&seen[k], &found[k]);
            let sharp = test.standard_error < 0.1;
            assert!(
                test.p_value > alpha && sharp,
                "{name}, pixel {pixel:?}: {} and {} ± {}",
                seen[k].mean,
                found[k].mean,
                test.standard_error
            );
        }
    }
}

#[test]
fn what_lies_off_the_film_or_the_clip_planes_is_not_seen() {
    for (name, sensor) in rows() {
        let up = Vec3::new(0.0, 0.0, 4.0);
        assert!(sensor.sample_direction(up, Vec2::splat(0.5)).is_none(), "{name} sees behind itself");
        assert!(sensor.sample_direction(Vec3::new(50.0, 0.0, 0.0), Vec2::splat(0.5)).is_none(), "{name}");
        assert!(sensor.sample_direction(Vec3::new(0.0, 0.0, -2e4), Vec2::splat(0.5)).is_none(), "{name}: beyond the far plane");
        let ray = sensor.sample_ray(Vec2::new(4.0, 3.0), Vec2::splat(0.5), 0.0).ray;
        assert!(sensor.sample_direction(ray.at(-5e-3), Vec2::splat(0.5)).is_none(), "{name}: before the near plane");
        assert!(sensor.sample_direction(ray.at(5e-3), Vec2::splat(0.5)).is_some(), "{name}: behind the near plane");
        assert_eq!(sensor.we(ray.o, -ray.d), 0.0);
    }
}

#[test]
fn a_scene_without_a_sensor_is_seen_whole() {
    let scene = scene(r#"<shape type="sphere"><point name="center" value="10, 20, 30"/><float name="radius" value="4"/></shape>"#);
    let view = &scene.views[0];
    let size = view.film.size.map(|s| s as f32);
    let mut hits = 0;
    for i in 0..20 {
        for j in 0..20 {
            let q = Vec2::new((i as f32 + 0.5) / 20.0 * size[0], (j as f32 + 0.5) / 20.0 * size[1]);
            let ray = view.sensor.sample_ray(q, Vec2::splat(0.5), 0.0).ray;
            let hit = scene.intersect(&ray).is_some();
            hits += usize::from(hit);
            assert!(!hit || (i > 0 && i < 19 && j > 0 && j < 19), "the sphere is cut off at {i}, {j}");
        }
    }
    assert!(hits > 40, "{hits} of 400 rays meet the sphere");
}
