//! How time grows with the number of triangles, of lamps, of bounces, of pixels, and how it shrinks with threads: a table and a plot of each.
//!
//! Seconds are those of the clock, on an idle machine; the median of rounds in which all cases take turns.

#[path = "../../../accel/benches/meshes/mod.rs"]
#[allow(dead_code, reason = "of its meshes one is cast at here")]
mod meshes;
#[path = "../../benches/seeds/mod.rs"]
mod seeds;

use crate::Drawn;
use crate::canvas::{Curve, plot};
use etendue::{LoadOptions, Loaded, RenderOptions, Stop, Watch, cores, load, render};
use etendue_accel::NoShapes;
use meshes::{Mesh, Random, rays};
use seeds::{Runs, noise};
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

/// All of them.
pub fn growth(folder: &Path) -> Drawn {
    [triangles, emitters, depth, size, threads].into_iter().try_for_each(|table| table(folder))
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Rays per second of one thread against triangles: 27 bumpy spheres of ever smaller ones.
fn triangles(folder: &Path) -> Drawn {
    const KINDS: [&str; 4] = ["camera", "bounce", "shadow", "occlusion"];
    println!("\n| triangles | build, s | M rays/s, {} |\n| ---: | ---: | ---: | ---: | ---: | ---: |", KINDS.join(" | "));
    let mut curves: Vec<_> = KINDS.map(|name| Curve { name: name.to_owned(), points: Vec::new() }).into();
    for segments in [3, 10, 30, 96, 304] {
        let mesh = Mesh::spheres(3, segments);
        let begun = Instant::now();
        let accel = mesh.build(0.25);
        let built = begun.elapsed().as_secs_f64();
        let mut row = format!("| {} | {built:.3} |", mesh.indices.len());
        for ((kind, rays), curve) in rays(&mesh, &accel).0.iter().zip(&mut curves) {
            let any = matches!(*kind, "shadow" | "occlusion");
            let rate = || {
                let (begun, mut cast) = (Instant::now(), 0);
                while begun.elapsed().as_secs_f64() < 0.2 {
                    black_box(
                        rays.iter()
                            .filter(|r| if any { accel.occluded(r, &NoShapes) } else { accel.closest(r, &NoShapes).is_some() })
                            .count(),
                    );
                    cast += rays.len();
                }
                cast as f64 / begun.elapsed().as_secs_f64() / 1e6
            };
            let rate = median((0..5).map(|_| rate()).collect());
            write!(row, " {rate:.2} |")?;
            curve.points.push((mesh.indices.len() as f64, rate));
        }
        println!("{row}");
    }
    plot(&folder.join("growth-triangles.svg"), "triangles", "million rays a second, one thread", &curves)
}

/// Seconds of a picture on some threads.
fn seconds(loaded: &Loaded, samples: u32, options: RenderOptions) -> Drawn<f64> {
    Ok(render(loaded, &RenderOptions { stop: Some(Stop::Samples(samples)), ..options }, &Watch::default())?.stats.render_seconds)
}

fn one_thread() -> RenderOptions {
    RenderOptions { threads: Some(1), ..RenderOptions::default() }
}

/// Of each row the median over the rounds, in turns.
fn in_turns<T>(rounds: usize, rows: &[T], time: impl Fn(&T) -> Drawn<f64>) -> Drawn<Vec<f64>> {
    let mut times = vec![Vec::new(); rows.len()];
    for _ in 0..rounds {
        for (row, times) in rows.iter().zip(&mut times) {
            times.push(time(row)?);
        }
    }
    Ok(times.into_iter().map(median).collect())
}

fn of_width(scene: &str, width: u32) -> Drawn<Loaded> {
    Ok(load(scene, &LoadOptions { width: Some(width), height: Some(width), ..LoadOptions::default() })?)
}

/// A hall under ever more lamps of the same area and power together: time of a picture, and time until it is as clean.
fn emitters(folder: &Path) -> Drawn {
    const SAMPLES: u32 = 16;
    println!("\n| lamps | time, s | noise | time, of one lamp's | time to the same noise |\n| ---: | ---: | ---: | ---: | ---: |");
    let scratch = tempfile::tempdir()?;
    let halls = [1u32, 10, 100, 1000, 10_000, 100_000].map(|count| -> Drawn<_> {
        let file = scratch.path().join(format!("hall-{count}.xml"));
        std::fs::write(scratch.path().join(format!("lamps-{count}.ply")), lamps(count))?;
        std::fs::write(&file, hall(&format!("lamps-{count}.ply")))?;
        Ok((count, of_width(&file.display().to_string(), 128)?, Runs::default()))
    });
    let mut halls = halls.into_iter().collect::<Drawn<Vec<_>>>()?;
    for seed in 0..6 {
        for (_, hall, runs) in &mut halls {
            runs.add(hall, &RenderOptions { stop: Some(Stop::Samples(SAMPLES)), seed: Some(seed), ..one_thread() });
        }
    }
    let told: Vec<_> =
        halls.iter().map(|(count, _, runs)| (f64::from(*count), runs.seconds(), noise(runs, &runs.means()))).collect();
    let (_, second, first) = told[0];
    for (count, time, noise) in &told {
        let (time_ratio, both) = (time / second, time * noise / (second * first));
        println!("| {count} | {time:.2} | {noise:.5} | {time_ratio:.2} | {both:.2} |");
    }
    let curve = |name: &str, of: &dyn Fn(f64, f64) -> f64| Curve {
        name: name.to_owned(),
        points: told.iter().map(|(n, time, noise)| (*n, of(*time / second, *noise / first))).collect(),
    };
    let curves = [curve("time of as many samples", &|time, _| time), curve("time to the same noise", &|time, noise| time * noise)];
    plot(&folder.join("growth-emitters.svg"), "lamps", "time, in that of one lamp", &curves)
}

/// A closed hall with two blocks and a ball; the lamps are above the picture, so that the noise is that of the light which they give.
fn hall(lamps: &str) -> String {
    let block = |x: f32, z: f32| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale value="0.6"/><rotate y="1" angle="20"/><translate x="{x}" y="0.6" z="{z}"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf></shape>"#
        )
    };
    format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="6"/></integrator>
        <sensor type="perspective"><float name="fov" value="50"/>
            <transform name="to_world"><lookat origin="0, 2.5, 5.5" target="0, 0, 1.5" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><rfilter type="box"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <transform name="to_world"><scale x="6" y="2" z="6"/><translate y="2"/></transform><bsdf type="diffuse"/></shape>
        <shape type="sphere"><point name="center" x="1.2" y="0.7" z="0.6"/><float name="radius" value="0.7"/><bsdf type="diffuse"/></shape>
        {}{}
        <shape type="ply"><string name="filename" value="{lamps}"/><bsdf type="diffuse"/>
            <emitter type="area"><rgb name="radiance" value="40"/></emitter></shape></scene>"#,
        block(-1.2, 0.0),
        block(2.0, -2.0)
    )
}

/// So many triangles under the ceiling that look down, 0.2 m² together, scattered evenly.
fn lamps(count: u32) -> String {
    let mut random = Random(5);
    let side = f64::from(count).sqrt().ceil() as u32;
    let edge = (2.0 * 0.2 / count as f32).sqrt();
    let mut ply = "ply\nformat ascii 1.0\n".to_owned();
    let _ = write!(ply, "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", 3 * count);
    let _ = write!(ply, "element face {count}\nproperty list uchar uint vertex_indices\nend_header\n");
    for i in 0..count {
        let mut place = |cell: u32| 10.0 * ((cell as f32 + random.unit()) / side as f32 - 0.5);
        let (x, z) = if count == 1 { (0.0, 0.0) } else { (place(i % side), place(i / side)) };
        let y = 3.0 + 0.8 * random.unit();
        let _ = write!(ply, "{x} {y} {z}\n{} {y} {z}\n{x} {y} {}\n", x + edge, z + edge);
    }
    for i in 0..count {
        let _ = writeln!(ply, "3 {} {} {}", 3 * i, 3 * i + 1, 3 * i + 2);
    }
    ply
}

/// The Cornell box with ever more bounces.
fn depth(folder: &Path) -> Drawn {
    let rows = [2u32, 3, 5, 9, 17, 33, 65, 129];
    let scenes = ["cornell-box", "ajar"];
    println!("\n| edges at most | s, {} |\n| ---: | ---: | ---: |", scenes.join(" | "));
    let mut curves = Vec::new();
    for scene in scenes {
        let loaded = of_width(scene, 128)?;
        let times = in_turns(3, &rows, |n| seconds(&loaded, 16, RenderOptions { max_depth: Some(Some(*n)), ..one_thread() }))?;
        curves.push(Curve { name: scene.to_owned(), points: rows.iter().map(|n| f64::from(*n)).zip(times).collect() });
    }
    for (i, n) in rows.iter().enumerate() {
        println!("| {n} | {:.3} | {:.3} |", curves[0].points[i].1, curves[1].points[i].1);
    }
    plot(&folder.join("growth-depth.svg"), "edges between eye and light, at most", "s, 128 x 128 x 16 samples", &curves)
}

/// The Cornell box in ever more pixels.
fn size(folder: &Path) -> Drawn {
    let rows = [32u32, 64, 128, 256, 512, 1024];
    let loaded = rows.iter().map(|width| of_width("cornell-box", *width)).collect::<Drawn<Vec<_>>>()?;
    let times = in_turns(3, &loaded, |loaded| seconds(loaded, 4, one_thread()))?;
    println!("\n| pixels | time, s | ns a sample |\n| ---: | ---: | ---: |");
    let mut points = Vec::new();
    for (width, time) in rows.iter().zip(&times) {
        let pixels = f64::from(*width).powi(2);
        println!("| {width} x {width} | {time:.3} | {:.0} |", 1e9 * time / (4.0 * pixels));
        points.push((pixels, *time));
    }
    let even = points.iter().map(|(pixels, _)| (*pixels, points[0].1 * pixels / points[0].0)).collect();
    let curves =
        [Curve { name: "cornell-box, 4 samples".to_owned(), points }, Curve { name: "in proportion".to_owned(), points: even }];
    plot(&folder.join("growth-size.svg"), "pixels", "s, one thread", &curves)
}

/// Three scenes on ever more threads, up to one for each core.
fn threads(folder: &Path) -> Drawn {
    let rows: Vec<usize> = std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n <= cores()).collect();
    println!("\n| scene | threads | time, s | times as fast |\n| --- | ---: | ---: | ---: |");
    let mut curves = Vec::new();
    for scene in ["cornell-box", "veach-mis", "many-lights"] {
        let loaded = of_width(scene, 256)?;
        let times = in_turns(5, &rows, |n| seconds(&loaded, 16, RenderOptions { threads: Some(*n), ..RenderOptions::default() }))?;
        for (n, time) in rows.iter().zip(&times) {
            println!("| `{scene}` | {n} | {time:.3} | {:.2} |", times[0] / time);
        }
        curves.push(Curve {
            name: scene.to_owned(),
            points: rows.iter().zip(&times).map(|(n, time)| (*n as f64, times[0] / time)).collect(),
        });
    }
    plot(&folder.join("growth-threads.svg"), "threads", "times as fast as one", &curves)
}
