//! What it saves to take more samples where there is noise: `cargo bench -p etendue --bench adaptive [-- SAMPLES ROUNDS WIDTH [SCENE]...]`.
//!
//! Each scene is rendered with as many samples in every pixel, and with as many on average, on one thread in turns, each round with a seed of its own. Noise is
//! measured between the rounds, by the mean of all of them (noise: see `seeds`). As noise falls like one over the time,
//!
//! ```text
//! time to the same relMSE = (seconds × noise) of adaptive / (seconds × noise) of uniform
//! ```

#![allow(clippy::print_stdout, reason = "what it measured is all that it has to say")]

mod seeds;

use etendue::{LoadOptions, RenderOptions, Spread, Stop, load};
use seeds::{Runs, noise};

const SCENES: [&str; 3] = ["ajar", "caustic", "veach-mis"];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let mut numbers = arguments.iter().filter_map(|a| a.parse::<u32>().ok());
    let (samples, rounds, width) =
        (numbers.next().unwrap_or(256), numbers.next().unwrap_or(6).max(2), numbers.next().unwrap_or(96));
    let named: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| a.parse::<u32>().is_err()).collect();
    println!("{samples} samples, {rounds} rounds, {width} x {width} pixels\n");
    println!("| scene | time | noise, uniform | noise, adaptive | time to the same noise |\n| --- | ---: | ---: | ---: | ---: |");
    for scene in if named.is_empty() { &SCENES[..] } else { &named } {
        let size = LoadOptions { width: Some(width), height: Some(width), ..LoadOptions::default() };
        let loaded = load(scene, &size).unwrap_or_else(|e| panic!("{scene}: {e}"));
        let mut runs = [Runs::default(), Runs::default()];
        for seed in 0..u64::from(rounds) {
            for (spread, runs) in [Spread::Uniform, Spread::Adaptive].into_iter().zip(&mut runs) {
                let stop = Some(Stop::Noise { percent: 1e-9, limit: samples });
                let options = RenderOptions {
                    stop,
                    spread: Some(spread),
                    // Walks that share what neighbours find do so where all take as many samples: these here are alone.
                    solver: Some("path-mis".to_owned()),
                    parameters: vec![("block".to_owned(), "1".to_owned())],
                    seed: Some(seed),
                    threads: Some(1),
                    ..RenderOptions::default()
                };
                runs.add(&loaded, &options);
            }
        }
        let best: Vec<f64> = runs[0].means().iter().zip(runs[1].means()).map(|(a, b)| 0.5 * (a + b)).collect();
        let [uniform, adaptive] = [0, 1].map(|i| noise(&runs[i], &best));
        let time = runs[1].seconds() / runs[0].seconds();
        println!("| `{scene}` | {time:.2} | {uniform:.3e} | {adaptive:.3e} | {:.2} |", time * adaptive / uniform);
    }
}
