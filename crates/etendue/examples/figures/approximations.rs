//! What is lost by simplifying the rendering equation.

use crate::Drawn;
use crate::canvas::{Shot, grid};
use etendue::{Image, LoadOptions, Stop, load};
use etendue_film::{Film, FilmShape};
use etendue_numerics::{Sampler, SequenceKind, Spectrum, Vec3};
use etendue_solvers::drivers::PixelSolver;
use etendue_solvers::transport::{Context, PathState, Vertex};
use etendue_solvers::{CancelToken, PathRules, Progress, Run, Spread};
use std::path::Path;

/// The integral over the hemisphere as a sum over n = 2·rings² directions, the centres of cells of equal solid angle Δω = 2π/n:
///
/// ```text
/// L(x, wo) = Le(x, wo) + Σ_j f(w_j, x, wo) Le(RT(x, w_j), -w_j) cosθ_j Δω          of light of one bounce
/// ```
struct FiniteDirections {
    rings: u32,
}

impl PixelSolver for FiniteDirections {
    fn radiance(&self, c: &Context<'_>, eye: PathState, _: &Sampler, rays: &mut u64) -> Spectrum {
        let (scene, wl) = (c.scene, &eye.wl);
        let seen = |ray: &etendue_numerics::Ray, rays: &mut u64| {
            *rays += 1;
            scene.intersect(ray).map(|hit| scene.interaction(ray, &hit))
        };
        let Some(x) = seen(&eye.ray, rays) else { return eye.beta.carry(scene.le_escaped(&eye.ray, wl)) };
        let mut l = scene.le(&x, wl);
        let vertex = Vertex::new(scene, x, wl);
        let sectors = 2 * self.rings;
        let solid_angle = std::f32::consts::TAU / (self.rings * sectors) as f32;
        for (i, j) in (0..self.rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
            let cos = (i as f32 + 0.5) / self.rings as f32;
            let (sin_phi, cos_phi) = (std::f32::consts::TAU * (j as f32 + 0.5) / sectors as f32).sin_cos();
            let sin = (1.0 - cos * cos).sqrt();
            let w = vertex.x.shading.to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos));
            let (f_cos, _) = vertex.eval(w);
            if f_cos.is_zero() {
                continue;
            }
            let ray = vertex.x.spawn(w);
            let arriving = seen(&ray, rays).map_or_else(|| scene.le_escaped(&ray, wl), |y| scene.le(&y, wl));
            l += f_cos * arriving * solid_angle;
        }
        eye.beta.carry(l)
    }
}

/// Four glossy plates under four lamps, by 128, by 512 and by 3,200 directions, and by the integral.
pub fn finite_directions(folder: &Path) -> Drawn {
    const WIDTH: u32 = 160;
    let loaded = load("veach-mis", &LoadOptions { width: Some(WIDTH), ..LoadOptions::default() })?;
    let view = &loaded.scene.views[0].film;
    let (w, h) = (view.crop_size[0] as usize, view.crop_size[1] as usize);
    let pool = rayon::ThreadPoolBuilder::new().build()?;
    let by = |solver: &dyn Fn(&Run<'_>, &Film), spp: u32| -> Drawn<Image> {
        let film = Film::new(FilmShape { size: view.crop_size, kernel: view.filter });
        let (cancel, progress) = (CancelToken::default(), Progress::default());
        let run = Run {
            view: 0,
            seed: 0,
            sequence: SequenceKind::Sobol,
            stop: Stop::Samples(spp),
            spread: Spread::Uniform,
            rules: PathRules::default().with_bounces(0..=1),
            digest: 0,
            pool: &pool,
            cancel: &cancel,
            progress: &progress,
            events: &|_| (),
            checkpoint_every: None,
        };
        solver(&run, &film);
        Ok(Image::rgb(w, h, film.develop().into_flattened())?)
    };
    let integral = etendue_solvers::direct::Direct { emitter_samples: 1, bsdf_samples: 1 };
    let truth = by(&|run, film| drop(etendue_solvers::render(&integral, "integral", &loaded.scene, run, film, None)), 256)?;
    let mut pictures = Vec::new();
    for rings in [8u32, 16, 40] {
        let solver = FiniteDirections { rings };
        let picture = by(&|run, film| drop(etendue_solvers::render(&solver, "sum", &loaded.scene, run, film, None)), 1)?;
        let error = etendue_image::metrics::compare(&picture, &truth)?.rel_mse;
        println!("{:>6} directions: relMSE {error:.3}", 2 * rings * rings);
        pictures.push(picture);
    }
    pictures.push(truth);
    let bottom = pictures.split_off(2);
    grid(&folder.join("finite-directions.png"), &[pictures, bottom], 0.0)
}

/// The Cornell box: direct light alone, with an ambient constant, and with light between surfaces.
pub fn ambient(folder: &Path) -> Drawn {
    // The constant that makes the pictures' means equal.
    const AMBIENT: &str = "0.093, 0.047, 0.01";
    let shot = |solver, parameters| Shot { scene: "cornell-box", solver, parameters, width: 200, stop: Stop::Samples(96) }.take();
    let pictures = vec![shot("whitted", &[])?, shot("whitted", &[("ambient", AMBIENT)])?, shot("path-mis", &[])?];
    for picture in &pictures {
        let mean: [f32; 3] = std::array::from_fn(|c| picture.pixels().map(|p| p[c]).sum::<f32>() / (200.0 * 200.0));
        println!("mean {mean:.3?}");
    }
    grid(&folder.join("ambient.png"), &[pictures], 1.0)
}

/// The Cornell box by 400 and by 6,000 patches, as they are, and by walks.
pub fn patches(folder: &Path) -> Drawn {
    let shot =
        |solver, parameters, spp| Shot { scene: "cornell-box", solver, parameters, width: 200, stop: Stop::Samples(spp) }.take();
    let few = shot("radiosity", &[("patches", "400"), ("show", "patches")], 16)?;
    let many = shot("radiosity", &[("patches", "6000"), ("show", "patches"), ("samples", "4096")], 16)?;
    grid(&folder.join("patches.png"), &[vec![few, many, shot("path-mis", &[], 96)?]], 1.0)
}

/// Glass, metal and varnish, and the same balls as if they were diffuse with the same albedo.
pub fn lambertian(folder: &Path) -> Drawn {
    let balls = [
        r#"<bsdf type="dielectric"/>"#,
        r#"<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.15"/></bsdf>"#,
        r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1, 0.25, 0.6"/></bsdf>"#,
    ];
    let diffuse = ["0.95, 0.95, 0.95", "0.95, 0.73, 0.36", "0.12, 0.26, 0.58"];
    let matt = diffuse.map(|c| format!(r#"<bsdf type="diffuse"><rgb name="reflectance" value="{c}"/></bsdf>"#));
    let file = std::env::temp_dir().join(format!("etendue-lambertian-{}.xml", std::process::id()));
    let mut pictures = Vec::new();
    for materials in [balls.map(str::to_owned), matt] {
        std::fs::write(&file, still_life(&materials))?;
        let scene = file.display().to_string();
        let picture = Shot { scene: &scene, solver: "path-mis", parameters: &[], width: 240, stop: Stop::Samples(96) }.take();
        std::fs::remove_file(&file)?;
        pictures.push(picture?);
    }
    grid(&folder.join("lambertian.png"), &[pictures], 0.0)
}

fn still_life(materials: &[String; 3]) -> String {
    let ball = |(i, bsdf): (usize, &String)| {
        let x = 1.1 * (i as f64 - 1.0);
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="0.5" z="0"/><float name="radius" value="0.5"/>{bsdf}</shape>"#
        )
    };
    let balls: String = materials.iter().enumerate().map(ball).collect();
    format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="-1"/></integrator>
        <sensor type="perspective"><float name="fov" value="32"/>
            <transform name="to_world"><lookat origin="0, 2.2, 6" target="0, 0.5, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="320"/><integer name="height" value="200"/><rfilter type="gaussian"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <transform name="to_world"><scale x="4" y="2.5" z="7"/><translate y="2.5"/></transform>
            <bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.35"/><rgb name="color1" value="0.55"/>
                <transform name="to_uv"><scale x="8" y="8"/></transform></texture></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale x="0.5" z="0.5"/><translate x="-1.2" y="4" z="0.8"/></transform>
            <bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="60, 58, 52"/></emitter></shape>
        {balls}</scene>"#
    )
}
