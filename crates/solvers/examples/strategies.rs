//! Writes each strategy's picture of bidirectional path tracing, weighted and not: EXRs named `s_t`, and a contact sheet with a row for each
//! length of paths, from s = 0 on the left.
//!
//! ```text
//! cargo run --release -p etendue-solvers --example strategies -- SCENE FOLDER [PASSES] [VERTICES]
//! ```

use etendue_description::Diagnostics;
use etendue_image::{Image, Picture, SaveOptions, ToneMap, save};
use etendue_numerics::SequenceKind;
use etendue_scene::{CompileOptions, Scene};
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::bidirectional::strategies::{StrategyPicture, pictures};
use etendue_solvers::{CancelToken, PathRules, Progress, Run, Spread, Stop};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, folder, rest @ ..] = &arguments[..] else { return Err("SCENE FOLDER [PASSES] [VERTICES]".into()) };
    let number = |i: usize, default: u32| rest.get(i).map_or(Ok(default), |n| n.parse());
    let (passes, vertices) = (number(0, 64)?, number(1, 6)?);
    let scene = read(Path::new(file))?;
    let run = Run {
        view: 0,
        seed: 0,
        sequence: SequenceKind::Sobol,
        stop: Stop::Samples(passes),
        spread: Spread::Uniform,
        rules: PathRules::of(&scene.integrator),
        digest: 0,
        pool: &rayon::ThreadPoolBuilder::new().build()?,
        cancel: &CancelToken::default(),
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    };
    let found = pictures(&Bidirectional::default(), &scene, &run, passes, vertices);

    let folder = Path::new(folder);
    std::fs::create_dir_all(folder)?;
    let [width, height] = scene.views[0].film.crop_size.map(|n| n as usize);
    for p in &found {
        for (kind, pixels) in [("weighted", &p.weighted), ("unweighted", &p.unweighted)] {
            let image = Image::rgb(width, height, pixels.as_flattened().to_vec())?;
            write(&folder.join(format!("{}_{}_{kind}.exr", p.s, p.t)), image)?;
        }
    }
    for (kind, of) in [("weighted", (|p| &p.weighted) as fn(&StrategyPicture) -> &Vec<[f32; 3]>), ("unweighted", |p| &p.unweighted)]
    {
        let sheet = sheet(&found, of, [width, height], vertices as usize)?;
        write(&folder.join(format!("{kind}.png")), ToneMap::default().image(&sheet))?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<Scene, Box<dyn Error>> {
    let (description, mut diagnostics) = etendue_formats::read(path, &Default::default());
    let errors = |d: &Diagnostics| d.render(&description.sources);
    if diagnostics.has_errors() {
        return Err(errors(&diagnostics).into());
    }
    let scene = etendue_scene::compile(&description, &CompileOptions::default(), &mut diagnostics);
    scene.ok_or_else(|| errors(&diagnostics).into())
}

fn write(path: &Path, image: Image) -> Result<(), Box<dyn Error>> {
    Ok(save(path, &Picture::from(image), &SaveOptions::default())?)
}

/// All pictures of one kind: row n - 2 holds those of n vertices.
fn sheet(
    found: &[StrategyPicture],
    of: fn(&StrategyPicture) -> &Vec<[f32; 3]>,
    [width, height]: [usize; 2],
    vertices: usize,
) -> Result<Image, Box<dyn Error>> {
    let across = width * vertices;
    let mut pixels = vec![[0.0f32; 3]; across * height * (vertices - 1)];
    for p in found {
        let (row, column) = ((p.s + p.t - 2) as usize, p.s as usize);
        for (y, line) in of(p).chunks(width).enumerate() {
            let start = (row * height + y) * across + column * width;
            pixels[start..start + width].copy_from_slice(line);
        }
    }
    Ok(Image::rgb(across, height * (vertices - 1), pixels.into_flattened())?)
}
