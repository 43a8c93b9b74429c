//! étendue: a physically based renderer and light-transport laboratory.
//!
//! This crate is the facade: it loads a scene ([`load()`]), renders it ([`render()`]) and hands back pictures. It touches no globals: threads,
//! cancellation and progress come in through [`RenderOptions`] and [`Watch`], words go out as values. Only the program beside it
//! reads arguments and prints.
//!
//! ```
//! let loaded = etendue::load("furnace", &etendue::LoadOptions { width: Some(8), ..Default::default() }).unwrap();
//! let watch = etendue::Watch::default();
//! let options = etendue::RenderOptions { stop: Some(etendue::Stop::Samples(4)), ..Default::default() };
//! let rendering = etendue::render(&loaded, &options, &watch).unwrap();
//! // Le / (1 - a) = 2 in every pixel.
//! assert!((rendering.mean()[0] - 2.0).abs() < 0.2);
//! ```

mod bare_mesh;
pub mod bench;
pub mod builtin;
mod choice;
pub mod compare;
pub mod convert;
mod digest;
pub mod experiment;
pub mod form_factors;
mod guard;
mod layers;
pub mod load;
pub mod memory;
mod mistakes;
pub mod per_light;
mod picture;
mod pool;
pub mod radiosity;
pub mod render;
pub mod stats;
pub mod strategies;
pub mod surfaces;
pub mod verify;

pub use choice::{advise, check_solver_name};
pub use etendue_image::{Curve, Image, Picture, ToneMap};
pub use etendue_solvers::{SOLVERS, Spread, Stop, Stopped};
pub use load::{LoadError, LoadOptions, Loaded, load};
pub use per_light::{check_per_light, light_names, render_per_light};
pub use pool::cores;
pub use render::{Listener, RenderError, RenderOptions, Rendering, Watch, check, render};
pub use stats::Stats;
