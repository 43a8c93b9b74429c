//! Path tracing against light tracing: image size, kind of path, number of sources.

use crate::Drawn;
use crate::canvas::{Curve, Shot, grid, plot};
use etendue::Stop;
use etendue::compare::{Budget, CompareOptions, Reference, compare};
use etendue_solvers::CancelToken;
use etendue_solvers::agreement::Standard;
use std::path::Path;
use std::time::Duration;

const SOLVERS: [&str; 2] = ["path-mis", "light-nee"];

/// What a second of each solver is worth: one over the variance of its picture after a second, relative to the reference, mean over the pixels.
fn worth(scene: &str, defines: &[(String, String)], size: u32, seconds: u64) -> Drawn<Vec<f64>> {
    let options = CompareOptions {
        solvers: SOLVERS.map(str::to_owned).to_vec(),
        reference: Reference::Best,
        budget: Budget::Time(Duration::from_secs(seconds)),
        width: Some(size),
        height: None,
        seed: 0,
        threads: None,
        defines: defines.to_vec(),
        spectral: None,
        standard: Standard::default(),
    };
    let results = compare(scene, &options, &CancelToken::default(), &|_| ()).map_err(|e| format!("{scene}: {e:?}"))?;
    Ok(results.solvers.iter().map(|s| 1.0 / s.variance_second).collect())
}

fn curves(points: &[(f64, Vec<f64>)]) -> Vec<Curve> {
    let of = |(i, name): (usize, &str)| Curve { name: name.to_owned(), points: points.iter().map(|(x, y)| (*x, y[i])).collect() };
    SOLVERS.into_iter().enumerate().map(of).collect()
}

/// The Cornell box through ever longer lenses: a path of `path-mis` begins in the picture, a particle of `light-nee` falls anywhere.
pub fn scene_size(folder: &Path) -> Drawn {
    let mut points = Vec::new();
    for fov in [40.0f64, 20.0, 10.0, 5.0, 2.5] {
        let worth = worth("cornell-box", &[("fov".to_owned(), fov.to_string())], 48, 2)?;
        println!("fov {fov}: {worth:.3?}, {:.3} to 1", worth[1] / worth[0]);
        points.push((fov, worth));
    }
    plot(&folder.join("scene-size.svg"), "field of view, degrees", "1 / variance of a second", &curves(&points))
}

/// Three kinds of paths, each with both solvers in equal time.
pub fn path_kinds(folder: &Path) -> Drawn {
    let mut rows = Vec::new();
    for scene in ["caustic", "veach-mis", "ajar"] {
        let shot = |solver| Shot { scene, solver, parameters: &[], width: 200, stop: Stop::Time(Duration::from_secs(8)) }.take();
        let row = SOLVERS.iter().map(|s| shot(s)).collect::<Drawn<Vec<_>>>();
        match row {
            Ok(row) => rows.push(row),
            Err(e) => println!("{scene}: {e}"),
        }
    }
    let height = rows.iter().map(|r| r[0].height()).min().ok_or("no picture")?;
    let rows: Vec<_> =
        rows.into_iter().map(|r| r.into_iter().map(|i| upper(&i, height)).collect::<Drawn<Vec<_>>>()).collect::<Drawn<_>>()?;
    grid(&folder.join("path-kinds.png"), &rows, 0.0)
}

/// The first rows of a picture.
fn upper(image: &etendue::Image, height: usize) -> Drawn<etendue::Image> {
    let rgb = image.to_rgb();
    let data = rgb.data()[..3 * rgb.width() * height].to_vec();
    Ok(etendue::Image::rgb(rgb.width(), height, data)?)
}

/// A hall with ever more lamps of the same power together.
pub fn sources(folder: &Path) -> Drawn {
    let file = std::env::temp_dir().join(format!("etendue-sources-{}.xml", std::process::id()));
    let mut points = Vec::new();
    for side in [1u32, 3, 10, 30] {
        std::fs::write(&file, hall(side))?;
        let worth = worth(&file.display().to_string(), &[], 64, 2);
        std::fs::remove_file(&file)?;
        let worth = worth?;
        println!("{} lamps: {worth:.3?}, {:.3} to 1", side * side, worth[1] / worth[0]);
        points.push((f64::from(side * side), worth));
    }
    plot(&folder.join("sources.svg"), "lamps", "1 / variance of a second", &curves(&points))
}

/// A floor with blocks under a lattice of side × side balls that glow, above the picture.
fn hall(side: u32) -> String {
    let radius = 0.05;
    let radiance = 400.0 / f64::from(side * side);
    let place = |i: u32| 6.0 * ((f64::from(i) + 0.5) / f64::from(side) - 0.5);
    let lamps: String = (0..side * side)
        .map(|i| {
            let (x, z) = (place(i % side), place(i / side));
            format!(
                r#"<shape type="sphere"><point name="center" x="{x}" y="2.6" z="{z}"/><float name="radius" value="{radius}"/>
                    <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter></shape>"#
            )
        })
        .collect();
    format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="-1"/></integrator>
        <sensor type="perspective"><float name="fov" value="50"/>
            <transform name="to_world"><lookat origin="0, 2, 5.5" target="0, 0.2, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <transform name="to_world"><scale x="6" y="2" z="6"/><translate y="2"/></transform><bsdf type="diffuse"/></shape>
        <shape type="cube"><transform name="to_world"><scale value="0.6"/><rotate y="1" angle="20"/><translate x="-1" y="0.6"/></transform><bsdf type="diffuse"/></shape>
        <shape type="sphere"><point name="center" x="1" y="0.7" z="0.4"/><float name="radius" value="0.7"/><bsdf type="diffuse"/></shape>
        {lamps}</scene>"#
    )
}
