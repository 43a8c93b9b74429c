//! Each light alone: the picture that it makes while the others are off, and the picture of all as their sum.
//!
//! ```text
//! L(Le_1 + … + Le_n) = L(Le_1) + … + L(Le_n)        the rendering equation is linear in Le
//! ```
//!
//! Every emitter has a layer of its own name: its id in the file, or that of the shape that it belongs to. Surfaces of lights that are off reflect and stand
//! in the way as before.

use crate::choice::advise;
use crate::layers;
use crate::load::Loaded;
use crate::picture::mean;
use crate::render::{RenderError, RenderOptions, Rendering, Watch, check, render};
use crate::stats::LightStats;
use etendue_description::{Description, NodeId, Value};
use etendue_image::Layer;
use etendue_scene::EmitterId;
use etendue_solvers::{AnySolver, Stop, Stopped};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

/// The names of a scene's lights, each different from the others.
pub fn light_names(loaded: &Loaded) -> Vec<String> {
    let parents = parents(&loaded.description);
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    let name = |node: NodeId| {
        let id = |node: NodeId| loaded.description.node(node).id.as_ref().map(|id| id.value.clone());
        let of_shape = || parents.get(&node.0).and_then(|shape| id(*shape));
        let name = id(node).or_else(of_shape).unwrap_or_else(|| loaded.description.node(node).model.value.clone());
        // A dot would end the layer's name, and a slash the folder's.
        let name: String = name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '_' }).collect();
        let count = seen.entry(name.clone()).or_insert(0);
        *count += 1;
        if *count == 1 { name } else { format!("{name}-{count}") }
    };
    loaded.scene.emitters.iter().map(|e| e.node).map(name).collect()
}

/// The nodes that hold others, by what they hold.
fn parents(description: &Description) -> BTreeMap<u32, NodeId> {
    let mut parents = BTreeMap::new();
    for (i, node) in description.nodes.iter().enumerate() {
        for param in &node.params {
            if let Value::Node(child) = param.value.value {
                parents.insert(child.0, NodeId(i as u32));
            }
        }
    }
    parents
}

/// Whether [`render_per_light`] would begin.
pub fn check_per_light(loaded: &Loaded, options: &RenderOptions) -> Result<(), RenderError> {
    check(loaded, options)?;
    let refused = |words: &str| Err(RenderError(words.to_owned()));
    if loaded.scene.emitters.is_empty() {
        return refused("the scene has no lights to be rendered one by one");
    }
    if options.checkpoint_every.is_some() || options.resume.is_some() {
        return refused("lights are rendered one by one without checkpoints");
    }
    let advice = advise(loaded, options)?;
    let asked = advice.as_ref().map(|a| a.solver).or(options.solver.as_deref());
    let name = asked.unwrap_or(&loaded.scene.integrator.solver);
    let Some(mut solver) = AnySolver::new(name, &loaded.scene.integrator) else {
        return Err(RenderError(format!("`{name}` shows no light that could be told apart by lights")));
    };
    for (name, value) in &options.parameters {
        // Those that are wrong were refused above.
        let _ = solver.set(name, value);
    }
    if solver.parameters().iter().any(|p| p.name == "ambient" && p.value != "0") {
        return refused("`ambient` light belongs to no light\n  help: leave it out to render the lights one by one");
    }
    let names = light_names(loaded);
    if let Some(plan) = layers::plan(loaded, &options.aovs)?.iter().find(|plan| names.contains(&plan.name)) {
        return Err(RenderError(format!("two layers would be called `{}`: each needs a name of its own", plan.name)));
    }
    let bytes = 12 * loaded.scene.emitters.len() as u64;
    let pixels: u64 = loaded.scene.views.get(options.view).map_or(0, |v| v.film.crop_size.map(u64::from).iter().product());
    match crate::memory::available() {
        Some(free) if pixels.saturating_mul(bytes) > free => refused("the pictures of all lights have no room in memory"),
        _ => Ok(()),
    }
}

/// Renders each light alone, with the samples that are asked for; a time is shared out among them. `begin` is told which is next. The picture is their sum,
/// and each is a layer of it.
pub fn render_per_light(
    loaded: &mut Loaded,
    options: &RenderOptions,
    watch: &Watch,
    begin: &mut dyn FnMut(usize, &str),
) -> Result<Rendering, RenderError> {
    check_per_light(loaded, options)?;
    let names = light_names(loaded);
    let stop = options.stop.map(|stop| match stop {
        Stop::Time(time) => Stop::Time(time / names.len() as u32),
        other => other,
    });
    let mut options = RenderOptions { stop, ..options.clone() };
    // One solver for all of them, though each alone might suggest another.
    if let Some(advice) = advise(loaded, &options)? {
        (options.solver, options.because) = (Some(advice.solver.to_owned()), Some(advice.reason));
    }
    let mut sum: Option<Rendering> = None;
    for (i, name) in names.iter().enumerate() {
        begin(i, name);
        watch.progress.paths.store(0, Ordering::Relaxed);
        watch.progress.rays.store(0, Ordering::Relaxed);
        loaded.scene.switch(|id| id == EmitterId(i as u32));
        let alone = render(loaded, &options, watch);
        loaded.scene.switch(|_| true);
        let all = add(sum, alone?, name);
        let ended = all.failure.is_some() || all.stopped == Stopped::Cancelled;
        sum = Some(all);
        if ended {
            break;
        }
        // One light's picture brings the layers that know no light.
        options.aovs.clear();
        loaded.scene.integrator.aovs.clear();
    }
    let mut sum = sum.ok_or_else(|| RenderError("the scene has no lights".to_owned()))?;
    sum.stats.mean = mean(&sum.picture.image.to_rgb().pixels().map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>());
    Ok(sum)
}

/// One light more.
fn add(sum: Option<Rendering>, mut alone: Rendering, name: &str) -> Rendering {
    let layer = Layer { name: name.to_owned(), image: alone.picture.image.clone() };
    let light = LightStats {
        name: name.to_owned(),
        spp: alone.stats.spp,
        mean: alone.stats.mean,
        noise_percent: alone.stats.noise_percent,
    };
    alone.stats.noise_percent = None;
    let mut all = match sum {
        None => alone,
        Some(mut all) => {
            let (ours, theirs) = (all.picture.image.data_mut(), alone.picture.image.data());
            ours.iter_mut().zip(theirs).for_each(|(a, b)| *a += b);
            let (s, t) = (&mut all.stats, &alone.stats);
            s.render_seconds += t.render_seconds;
            (s.paths, s.rays) = (s.paths + t.paths, s.rays + t.rays);
            s.peak_memory_bytes = s.peak_memory_bytes.max(t.peak_memory_bytes);
            s.nonfinite_samples += t.nonfinite_samples;
            s.nonfinite_first.extend(&t.nonfinite_first);
            s.books = s.books.zip(t.books).map(|(a, b)| a.plus(&b));
            s.stopped.clone_from(&t.stopped);
            if all.picture.attributes != alone.picture.attributes {
                // Stopped by the clock, lights have sample counts of their own.
                all.picture.attributes.retain(|a| alone.picture.attributes.contains(a));
            }
            Rendering { stopped: alone.stopped, failure: alone.failure, black: Vec::new(), ..all }
        }
    };
    all.picture.layers.push(layer);
    all.stats.lights.push(light);
    all
}
