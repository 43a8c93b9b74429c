//! Faults that renderers have had, each with its test: surfaces very close together and far away, mirrored meshes with vertex normals, the
//! last number below one, textures of nothing.

mod common;

use common::checks::{agreement, at_point, closed_form, floor, furnace, neumann, polygon_irradiance, round_furnace_scene};
use common::worlds::{WALLS, all_scenes, cone, eye, flat_furnace, lamp, room};
use common::*;
use etendue_film::{Film, FilmShape};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Dim, Numbers, Primary, Sampler, SequenceKind, Spectrum, Vec2, Wavelengths};
use etendue_solvers::bidirectional::{Bidirectional, Paths};
use etendue_solvers::direct::Direct;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::metropolis::Metropolis;
use etendue_solvers::metropolis::mutation::Mutation;
use etendue_solvers::oracle::Oracle;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::photon_map::PhotonMap;
use etendue_solvers::transport::PathState;
use etendue_solvers::{PathRules, Solver};
use std::f64::consts::PI;

/// Each solver begins roulette where it likes, unless somebody asks: the usual number is a question as well, and is not taken for silence.
#[test]
fn roulette_begins_where_it_is_asked_for() {
    let scene = room(&eye(), WALLS, &lamp());
    let begins = |name: &str, of: &dyn Fn(Job) -> Picture, own: u32, other: u32| {
        let of = |rr_depth| bits(&of(samples(2).with(PathRules { rr_depth, ..PathRules::default() })));
        assert!(of(None) == of(Some(own)), "{name} begins at {own}");
        assert!(of(None) != of(Some(other)), "{name} does not hear {other}");
    };
    begins("path", &|job| picture(&scene, &Path, job), 5, 2);
    begins("path-mis", &|job| picture(&scene, &PathMis::default(), job), 2, 5);
    begins("bidirectional", &|job| picture(&scene, &Bidirectional::default(), job), 2, 5);
}

/// A furnace of half a millimetre, one a kilometre from the origin, and one of paper-thin height: rays that start a rounding error behind their
/// surface leak out or see it again. Path is exact here, so a single leak shows.
#[test]
fn rays_stay_within_small_far_and_flat_furnaces() {
    for (name, map, from, to) in [
        ("small", r#"<scale value="0.0005"/>"#, "0, 0, 0", "0.0001, 0.0002, 0.0005"),
        ("far", r#"<translate x="1000" y="-700" z="300"/>"#, "1000, -700, 300", "1000.2, -699.9, 301"),
        ("flat", r#"<scale x="1" y="1" z="0.0001"/>"#, "0, 0, 0", "1, 0.3, 0"),
        ("large", r#"<scale value="100000"/>"#, "0, 0, 0", "10000, 20000, 90000"),
    ] {
        let camera = camera(from, to, "0, 1, 0", 60.0, [8, 8]).replace(
            r#"<float name="fov""#,
            r#"<float name="near_clip" value="0.000001"/><float name="far_clip" value="1000000"/><float name="fov""#,
        );
        let scene = scene(&format!(
            r#"{camera}<shape type="cube"><boolean name="flip_normals" value="true"/>
                <transform name="to_world">{map}</transform>{}{}</shape>"#,
            diffuse(0.5),
            area("1")
        ));
        let rules = PathRules { max_edges: 8, rr_depth: Some(u32::MAX), ..PathRules::default() };
        let mean = picture(&scene, &Path, samples(256).with(rules)).iter().map(|p| f64::from(p[0])).sum::<f64>() / 64.0;
        let want = neumann(0.5, Some(7));
        // (Some rays end in an edge or a corner of the box, where rounding may let them through: one in 10⁴ at most.)
        assert!((mean / want - 1.0).abs() < 1e-4, "{name}: {mean} instead of {want}");
    }
}

/// A lamp as a mesh with vertex normals shines where its normals point, mirrored or not; and a floor of such a mesh is lit from above.
#[test]
fn mirrored_meshes_with_vertex_normals() {
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n";
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("regression-quad.obj");
    std::fs::write(&path, quad).expect("the folder for temporary files");
    let mesh = |map: &str, inside: &str| {
        format!(
            r#"<shape type="obj"><string name="filename" value="{}"/><transform name="to_world">{map}</transform>{inside}</shape>"#,
            path.display()
        )
    };
    let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
    let lit = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
    let lamp = format!("{}{}", diffuse(0.0), area("2"));
    let mut family = Family::default();
    for (mirror, floor_mirror) in [("", ""), (r#"<scale x="-1"/>"#, r#"<scale y="-1"/>"#)] {
        for (down, expected) in [(r#"<rotate x="1" angle="180"/>"#, lit), (r#"<scale z="-1"/>"#, lit), ("", 0.0)] {
            let scene = scene(&format!(
                "{}{}{}",
                at_point("4, 0, 1.5", "0.3, 0.4, 0"),
                mesh(&format!(r#"{floor_mirror}<scale x="20" y="20"/>"#), &diffuse(0.5)),
                mesh(&format!(r#"{mirror}{down}<translate z="2"/>"#), &lamp)
            ));
            let name = format!("mirrored by `{mirror}`, turned by `{down}`");
            closed_form(&mut family, &format!("path, {name}"), &scene, &Path, expected, 256, 0.08);
            closed_form(&mut family, &format!("path-nee, {name}"), &scene, &PathNee, expected, 64, 0.08);
            closed_form(&mut family, &format!("path-mis, {name}"), &scene, &PathMis::default(), expected, 64, 0.08);
        }
    }
    family.must_hold();
}

/// Every pixel gets its own samples, however far from zero: x + u rounds up to x + 1 for one in 16 384 numbers u beyond x = 1024.
#[test]
fn no_sample_falls_into_the_next_pixel() {
    let scene = scene(&format!(
        r#"{}<emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#,
        camera("0, 0, 0", "0, 0, 1", "0, 1, 0", 60.0, [4096, 48])
    ));
    let picture = picture(&scene, &Path, samples(1));
    assert_eq!(picture.iter().filter(|p| **p != [1.0; 3]).count(), 0);
}

/// A sample on the far border of a tile, as u = 1 - 2⁻²⁴ rounds to, is neither lost nor out of bounds, whatever the filter.
#[test]
fn samples_on_a_tiles_far_border_are_kept() {
    for kernel in [Kernel::Box { radius: 0.5 }, Kernel::Tent { radius: 1.0 }, Kernel::Gaussian { stddev: 0.5 }] {
        let film = Film::new(FilmShape { size: [8, 8], kernel });
        let mut tile = film.tile();
        tile.begin([0, 0], [8, 8]);
        tile.add(Vec2::new(8.0, 8.0), Spectrum::ONE, 0);
        tile.add(Vec2::new(0.0, 8.0), Spectrum::ONE, 0);
        film.add_tile(&tile);
        let picture = film.develop();
        assert_eq!((picture[63], picture[56]), ([1.0; 3], [1.0; 3]), "{kernel:?}");
    }
}

/// Lamps, skies, materials and roughness of textures that are zero everywhere: darkness, and no number lost on the way.
#[test]
fn textures_of_nothing() {
    let black = picture_file("regression-black", 2, &[[0.0; 3]; 4]);
    let texture = |name: &str| {
        format!(
            r#"<texture type="bitmap" name="{name}"><string name="filename" value="{black}"/><boolean name="raw" value="true"/></texture>"#
        )
    };
    let ball = |x: i32, bsdf: String| {
        format!(r#"<shape type="sphere"><point name="center" value="{x}, 0, 0"/><float name="radius" value="0.4"/>{bsdf}</shape>"#)
    };
    let body = format!(
        "{}{}{}{}{}{}",
        camera("0, 0, 4", "0, 0, 0", "0, 1, 0", 50.0, [8, 8]),
        ball(-1, format!(r#"<bsdf type="diffuse">{}</bsdf>"#, texture("reflectance"))),
        ball(0, format!(r#"<bsdf type="roughconductor">{}</bsdf>"#, texture("alpha"))),
        ball(1, format!(r#"<bsdf type="plastic">{}</bsdf>"#, texture("diffuse_reflectance"))),
        format_args!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1"/></transform>
                <emitter type="area">{}</emitter></shape>"#,
            texture("radiance")
        ),
        ball(2, format!(r#"<bsdf type="mask">{}{}</bsdf>"#, texture("opacity"), diffuse(0.5))),
    );
    let dark = scene(&format!(r#"{body}<emitter type="envmap"><string name="filename" value="{black}"/></emitter>"#));
    let lit = scene(&format!(r#"{body}<emitter type="constant"/>"#));
    // `picture` fails if a sample is not a number.
    for scene in [&dark, &lit] {
        // (All that is lit here are mirrors.)
        assert!(picture(scene, &LightNee, samples(64)).iter().flatten().all(|x| *x == 0.0));
        let pictures = [
            picture(scene, &Path, samples(16)),
            picture(scene, &PathNee, samples(16)),
            picture(scene, &PathMis::default(), samples(16)),
            picture(scene, &Direct { emitter_samples: 2, bsdf_samples: 2 }, samples(16)),
            picture(scene, &Oracle::default(), samples(16)),
            picture(scene, &Bidirectional::default(), samples(16)),
            picture(scene, &METROPOLIS, samples(64)),
            picture(scene, &PhotonMap::default(), samples(16)),
        ];
        for (i, p) in pictures.iter().enumerate() {
            let light = p.iter().flatten().any(|x| *x > 0.0);
            assert_eq!(light, std::ptr::eq(scene, &raw const lit), "solver {i}");
        }
    }
}

/// Light samples cannot find what shines on the inner side of a point that rounding has put outside a sphere; walks must count it.
#[test]
fn within_a_shining_sphere() {
    let scene = round_furnace_scene([0.5; 3]);
    let mut family = Family::default();
    furnace(&mut family, "path-nee", &PathNee, (&scene, 0.5), Some(3), 64, 0.05);
    furnace(&mut family, "path-mis", &PathMis::default(), (&scene, 0.5), Some(3), 64, 0.05);
    family.must_hold();
}

/// A floor under a lamp with sampling weight zero is lit by scattered rays alone.
#[test]
fn lamps_that_are_never_sampled() {
    let lamp = |weight: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>{}
                <emitter type="area"><rgb name="radiance" value="2"/>{weight}</emitter></shape>"#,
            diffuse(0.0)
        )
    };
    let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]];
    let expected = 0.5 / PI * 2.0 * polygon_irradiance([0.3, 0.4, 0.0], &corners);
    let never = lamp(r#"<float name="sampling_weight" value="0"/>"#);
    let scene = scene(&format!("{}{}{never}", at_point("4, 0, 1.5", "0.3, 0.4, 0"), floor(0.5)));
    let mut family = Family::default();
    closed_form(&mut family, "path-nee", &scene, &PathNee, expected, 256, 0.08);
    closed_form(&mut family, "path-mis", &scene, &PathMis::default(), expected, 256, 0.08);
    family.must_hold();
}

/// For small pictures.
const METROPOLIS: Metropolis = Metropolis {
    chains: 32,
    bootstrap: 4096,
    mutation: Mutation { large_step: 0.3, smallest: 1.0 / 1024.0, largest: 1.0 / 64.0 },
    direct: 0,
    renewal: 256,
};

/// Vertices very close together: in a furnace so flat that nearly every connection is short, nothing is infinite and nothing is missing.
#[test]
fn very_close_vertices() {
    let scene = flat_furnace();
    let mut family = Family::default();
    furnace(&mut family, "path-mis", &PathMis::default(), (&scene, 0.5), Some(4), 256, 0.1);
    furnace(&mut family, "metropolis", &METROPOLIS, (&scene, 0.5), Some(4), 4096, 0.1);
    furnace(
        &mut family,
        "photon-map",
        &PhotonMap { radius: 0.05, photons: 2048, direct: 0, ..PhotonMap::default() },
        (&scene, 0.5),
        Some(4),
        32,
        0.1,
    );
    family.must_hold();
}

/// The edge of a spot's cone ends at the same place whoever looks for it: path-nee alone draws it from the lamp, the others from its walks, too.
#[test]
fn the_edge_of_a_cone() {
    let scene = cone();
    let rules = PathRules { max_edges: 2, ..PathRules::default() };
    let of = |solver: &dyn Fn(Job) -> Vec<Picture>, spp: u32, seed: u64| solver(samples(spp).with(rules).seed(seed));
    let reference = of(&|job| replicates(&scene, &PathNee, job), 128, 1);
    let mut family = Family::default();
    let mut agrees = |name: &str, ours: &[Picture]| agreement(&mut family, name, &scene, ours, &reference, 0.3);
    agrees("path-mis", &of(&|job| replicates(&scene, &PathMis::default(), job), 128, 2));
    agrees("light-nee", &of(&|job| replicates(&scene, &LightNee, job), 4096, 3));
    agrees("metropolis", &of(&|job| replicates(&scene, &METROPOLIS, job), 1024, 4));
    family.must_hold();
}

/// All numbers at the ends of their range, zero and one less an ulp, and in its middle, alone and mixed: every light, camera and scattering gives paths whose light is a number and
/// falls on the film.
#[test]
fn numbers_at_the_ends_of_their_range() {
    let ends = [0.0, 0.5, 1.0f32.next_down()];
    for (name, scene) in all_scenes() {
        let film = &scene.views[0].film;
        let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let rules = PathRules { max_edges: 5, rr_depth: Some(u32::MAX), ..PathRules::default() };
        let all = Bidirectional::default().strategies_of(&scene, 0, rules);
        let (mut paths, mut found) = (Paths::default(), 0);
        for i in 0..243u32 {
            // Each number one of the ends; of the first nine paths all the same one.
            let pick = Sampler::new(SequenceKind::Independent, 1, 0, i, 243);
            let end = |x: f32| ends[(x * 3.0) as usize];
            let vector: Vec<Vec2> = (0..8 * Dim::SLOTS)
                .map(|d| if i < 9 { Vec2::new(ends[i as usize / 3], ends[i as usize % 3]) } else { pick.u2(Dim(d)).map(end) })
                .collect();
            let u = Primary { vector: &vector, beyond: pick };
            // The sum of a whole number and this rounds up: the driver keeps it within its pixel, and so must we.
            let place = (u.u2(Dim(0)) * size).min(size.map(f32::next_down));
            let ray = scene.views[0].sensor.sample_ray(corner + place, u.u2(Dim(1)), u.u1(Dim(2))).ray;
            all.sample(PathState::start(ray, Spectrum::ONE, Wavelengths::Rgb), &u, &mut paths, &mut |f, _, _| {
                found += 1;
                assert!(f.value.is_finite() && (0.0..=1.0).contains(&f.weight), "{name}, {i}: {:?} {}", f.value, f.weight);
                let at = f.pixel.map_or(place, |p| p - corner);
                assert!(at.cmpge(Vec2::ZERO).all() && at.cmplt(size).all(), "{name}, {i}: {at}");
            });
        }
        assert!(found > 0, "{name}");
    }
}

/// A crop window shows of splats what the whole film shows there, by whomever: the light of a lamp that is a point, on a floor.
#[test]
fn splats_in_a_crop() {
    let of = |film: &str| {
        scene(&format!(
            r#"{}{}<emitter type="point"><point name="position" x="0.2" y="0.1" z="1"/><rgb name="intensity" value="3"/></emitter>"#,
            camera_with("0, 0, 3", "0, 0, 0", "0, 1, 0", 40.0, [24, 16], film),
            floor(0.5)
        ))
    };
    let filter = r#"<rfilter type="box"/>"#;
    let window = r#"<integer name="crop_offset_x" value="6"/><integer name="crop_offset_y" value="4"/>
        <integer name="crop_width" value="8"/><integer name="crop_height" value="8"/>"#;
    let (whole, part) = (of(filter), of(&format!("{filter}{window}")));
    let cut =
        |picture: &Picture| -> Picture { (4..12).flat_map(|y| (6..14).map(move |x| y * 24 + x)).map(|i| picture[i]).collect() };
    let reference: Vec<Picture> = replicates(&whole, &PathNee, samples(16)).iter().map(cut).collect();
    let mut family = Family::default();
    fn shots(scene: &etendue_scene::Scene, solver: &impl Solver, spp: u32) -> Vec<Picture> {
        replicates(scene, solver, samples(spp).seed(5))
    }
    let mut agrees = |name: &str, ours: &[Picture]| agreement(&mut family, name, &part, ours, &reference, 0.3);
    // Of a crop's particles most miss it: a film twice as large in each direction is six times the crop.
    agrees("light-nee", &shots(&part, &LightNee, 4096));
    agrees("bidirectional", &shots(&part, &Bidirectional::default(), 64));
    agrees("metropolis", &shots(&part, &METROPOLIS, 512));
    agrees("photon-map", &shots(&part, &PhotonMap::default(), 64));
    family.must_hold();
}
