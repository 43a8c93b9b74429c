//! What `radiosity` and `measure` write, as other programs read it, and light meters against closed forms.

use etendue::radiosity::measure::{Grid, false_colour, read};
use etendue::radiosity::{export, solve};
use etendue::{LoadOptions, Loaded, load};
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solved::Settings;
use etendue_radiosity::{Patches, Solved};
use etendue_solvers::irradiance::Meter;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn file(folder: &tempfile::TempDir, name: &str, text: &[u8]) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

fn scene(folder: &tempfile::TempDir, shapes: &str) -> Loaded {
    let path = file(folder, "scene.xml", format!(r#"<scene version="3.0.0">{shapes}</scene>"#).as_bytes());
    load(&path, &LoadOptions::default()).expect("a scene")
}

fn solved(loaded: &Loaded, patches: usize) -> Solved {
    let settings = Settings { size: PatchSize::Count(patches), rays: 256, ..Settings::default() };
    solve(loaded, &settings, None, &|_| true).expect("a solution").0
}

#[test]
fn files_are_what_other_programs_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let loaded = load("cornell-box", &LoadOptions::default()).expect("a scene");
    let solved = solved(&loaded, 800);
    let n = solved.patches.len();
    let bytes =
        |ending: &str, lightmap| export::write(&loaded, &solved, ending, export::LUMINOUS_EFFICACY, lightmap).expect("bytes");
    let quads = |p: &Patches| (0..n as u32).filter(|i| !p.geometry(*i).1.is_triangle()).count();
    let triangles = n + quads(&solved.patches);

    // glTF, by another library, which checks all indices, sizes and types.
    for lightmap in [false, true] {
        let glb = gltf::Gltf::from_slice(&bytes("glb", lightmap)).expect("valid glTF");
        let blob = glb.blob.as_deref().expect("a binary chunk");
        let primitive = glb.document.meshes().next().and_then(|m| m.primitives().next()).expect("a mesh");
        let reader = primitive.reader(|_| Some(blob));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
        assert_eq!(indices.len(), 3 * triangles);
        assert!(indices.iter().all(|i| (*i as usize) < positions.len()));
        assert_eq!(reader.read_normals().expect("normals").len(), positions.len());
        if lightmap {
            let uv: Vec<[f32; 2]> = reader.read_tex_coords(1).expect("a second set").into_f32().collect();
            assert!(uv.len() == positions.len() && uv.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
            let image = glb.document.images().next().expect("a lightmap");
            let gltf::image::Source::View { view, mime_type: "image/png" } = image.source() else { panic!("a PNG within") };
            let png = &blob[view.offset()..view.offset() + view.length()];
            let atlas = etendue_image::load(std::path::Path::new(&file(&folder, "atlas.png", png))).expect("a picture");
            assert!(atlas.width() * atlas.height() >= 16 * n);
        } else {
            let colours: Vec<[f32; 4]> = reader.read_colors(0).expect("colours").into_rgba_f32().collect();
            assert!(colours.len() == positions.len() && colours.iter().any(|c| c[0] > 0.9) && colours.iter().any(|c| c[0] < 0.3));
        }
    }

    // The lightmap in floating point: its corner texels have the radiance of the brightest and the darkest patch.
    let atlas = export::lightmap(&loaded, &solved).expect("a picture");
    let most = atlas.data().iter().copied().fold(0.0f32, f32::max);
    let lamp = solved.solution.b.iter().map(|b| b.max_element()).fold(0.0, f64::max) / PI;
    assert!((f64::from(most) / lamp - 1.0).abs() < 0.05 && most > 1.0, "{most} for {lamp}");

    // PLY, by our own reader.
    let ply = file(&folder, "box.ply", &bytes("ply", false));
    let again = scene(&folder, &format!(r#"<shape type="ply"><string name="filename" value="{ply}"/></shape>"#));
    assert_eq!(again.scene.triangles as usize, triangles);

    // VTU, as XML.
    let vtu = bytes("vtu", false);
    let document = roxmltree::Document::parse(std::str::from_utf8(&vtu).expect("text")).expect("XML");
    let piece = document.descendants().find(|node| node.has_tag_name("Piece")).expect("a piece");
    assert_eq!(piece.attribute("NumberOfCells"), Some(n.to_string().as_str()));
    let names: Vec<_> = document.descendants().filter_map(|node| node.attribute("Name")).collect();
    for name in
        ["radiosity W/m2", "irradiance W/m2", "illuminance lx", "reflectance", "emission W/m2", "connectivity", "offsets", "types"]
    {
        assert!(names.contains(&name), "{name} in {names:?}");
    }

    // CSV: what leaves the patches is what the solution says.
    let csv = String::from_utf8(bytes("csv", false)).expect("text");
    let (head, rows) = csv.split_once('\n').expect("a head");
    assert!(head.contains("illuminance_lx_at_683.002_lm_per_W"));
    let column = |name: &str| head.split(',').position(|h| h == name).expect("a column");
    let (area, red) = (column("area_m2"), column("radiosity_W_per_m2_r"));
    let number = |row: &str, k: usize| row.split(',').nth(k).and_then(|x| x.parse::<f64>().ok()).expect("a number");
    let flux: f64 = rows.lines().map(|row| number(row, area) * number(row, red)).sum();
    let exact: f64 = solved.patches.patches.iter().zip(&solved.solution.b).map(|(p, b)| p.area * b.x).sum();
    assert_eq!(rows.lines().count(), n);
    assert!((flux / exact - 1.0).abs() < 1e-12);
}

/// lm/W.
const K: f64 = export::LUMINOUS_EFFICACY;

#[test]
fn meters_show_closed_forms() {
    let folder = tempfile::tempdir().expect("a folder");
    let floor = [Meter { p: Vec3::ZERO, n: Vec3::Z }];
    // 100 lm from a point 1 m above: 100 / 4π lx.
    let i = 100.0 / (4.0 * PI * K);
    let point = scene(
        &folder,
        &format!(
            r#"<emitter type="point"><point name="position" x="0" y="0" z="1"/><rgb name="intensity" value="{i}"/></emitter>"#
        ),
    );
    // 100 lm from a disc of radius r at distance d: 100 / (π (r² + d²)) lx.
    let (r, d) = (0.4, 1.0);
    let le = 100.0 / (K * PI * PI * r * r);
    let disc = scene(
        &folder,
        &format!(
            r#"<shape type="disk"><transform name="to_world"><scale value="{r}"/><rotate x="1" angle="180"/><translate z="{d}"/></transform>
            <emitter type="area"><rgb name="radiance" value="{le}"/></emitter></shape>"#
        ),
    );
    // Inside a furnace: π Le / (1 - a) from all around.
    let furnace = load("furnace", &LoadOptions::default()).expect("a scene");
    for (loaded, want, tolerance) in
        [(&point, 100.0 / (4.0 * PI), 1e-5), (&disc, 100.0 / (PI * (r * r + d * d)), 1e-3), (&furnace, K * PI * 2.0, 0.03)]
    {
        let solution = solved(loaded, 600);
        for by in [None, Some(&solution)] {
            let reading = read(loaded, by, &floor, 1 << 14, 1, K, None).expect("a reading")[0];
            let off = (reading.illuminance / want - 1.0).abs();
            assert!(off <= tolerance, "{} ± {} lx, closed form {want}", reading.illuminance, reading.illuminance_95);
        }
    }
    assert!((100.0 / (4.0 * PI) - 7.958f64).abs() < 5e-4);
}

#[test]
fn grids_agree_with_path_tracing_and_are_shown() {
    let loaded = load("cornell-box", &LoadOptions::default()).expect("a scene");
    let (origin, edges) = (DVec3::new(0.05, 0.34, 0.05), [DVec3::new(0.0, 0.0, 0.45), DVec3::new(0.45, 0.0, 0.0)]);
    let grid = Grid { origin, edges, cells: [3, 4] };
    let meters = grid.meters().expect("a plane");
    assert!(meters.len() == 12 && meters.iter().all(|m| m.n.distance(Vec3::Y) < 1e-6));
    let solution = solved(&loaded, 2500);
    let readings = [None, Some(&solution)].map(|by| read(&loaded, by, &meters, 4096, 3, K, None).expect("readings"));
    for (path, radiosity) in readings[0].iter().zip(&readings[1]) {
        // Twice the half width of a 95 % interval of each is four standard errors; patches of 2 cm are good for 2 %.
        let noise = 2.0 * path.illuminance_95.hypot(radiosity.illuminance_95);
        assert!((path.illuminance - radiosity.illuminance).abs() <= noise + 0.02 * path.illuminance, "{path:?} {radiosity:?}");
    }
    let picture = false_colour(&readings[1], grid.cells, K).expect("a picture");
    assert!(picture.width() > picture.height() && picture.data().iter().all(|x| (0.0..=1.0).contains(x)));
    assert!(Grid { edges: [DVec3::X, DVec3::X * 2.0], ..grid }.meters().is_none());
}
