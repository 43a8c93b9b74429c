//! The figures of the documents, each by one command:
//!
//!     cargo run --release -p etendue --example figures -- NAME [FOLDER]
//!
//! without a name it lists them. A figure is written to `docs/images`, or to FOLDER. Pictures are the same on every machine; plots measure time,
//! and their figures change with it.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program")]

mod approximations;
mod canvas;
mod growth;
mod path_vs_light;
mod radiosity;
mod spectra;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What a figure may run into.
type Drawn<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// A figure: its name, what it shows, and who draws it.
struct Figure {
    name: &'static str,
    shows: &'static str,
    draw: fn(&Path) -> Drawn,
}

const FIGURES: &[Figure] = &[
    Figure {
        name: "scene-size",
        shows: "path and light tracing: how much of the scene is in view",
        draw: path_vs_light::scene_size,
    },
    Figure { name: "path-kinds", shows: "path and light tracing: caustics, gloss, diffuse light", draw: path_vs_light::path_kinds },
    Figure { name: "sources", shows: "path and light tracing: the number of lamps", draw: path_vs_light::sources },
    Figure { name: "finite-directions", shows: "gloss as a sum over directions", draw: approximations::finite_directions },
    Figure { name: "patches", shows: "radiance that is constant on each patch", draw: approximations::patches },
    Figure { name: "spectra", shows: "three numbers for a spectrum", draw: spectra::spectra },
    Figure { name: "ambient", shows: "ambient light for light between surfaces", draw: approximations::ambient },
    Figure {
        name: "radiosity-convergence",
        shows: "radiosity: its error against the number of patches",
        draw: radiosity::convergence,
    },
    Figure { name: "radiosity-growth", shows: "radiosity: time and memory against the number of patches", draw: radiosity::growth },
    Figure { name: "growth", shows: "time against triangles, lamps, bounces, pixels and threads", draw: growth::growth },
    Figure { name: "lambertian", shows: "all surfaces diffuse", draw: approximations::lambertian },
];

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(name) = arguments.next() else {
        FIGURES.iter().for_each(|f| println!("{:<20}{}", f.name, f.shows));
        return ExitCode::SUCCESS;
    };
    if name == radiosity::CHILD {
        return ended(&name, radiosity::growth_of(&arguments.collect::<Vec<_>>()));
    }
    let folder = arguments.next().map_or_else(|| repository().join("docs/images"), PathBuf::from);
    let Some(figure) = FIGURES.iter().find(|f| f.name == name) else {
        eprintln!("there is no figure `{name}`; without a name they are listed");
        return ExitCode::from(2);
    };
    ended(&name, (figure.draw)(&folder))
}

/// How it ended, told.
fn ended(name: &str, drawn: Drawn) -> ExitCode {
    match drawn {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{name}: {e}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the repository.
fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
