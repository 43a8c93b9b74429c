//! The scenes that the program carries with it: ordinary scene files, embedded.

/// A scene within the program.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, in a line.
    pub summary: &'static str,
    /// Its file.
    pub text: &'static str,
}

macro_rules! scenes {
    ($($name:literal: $summary:literal;)*) => {
        /// The built-in scenes; the first is rendered when none is named.
        pub const SCENES: &[BuiltIn] = &[$(BuiltIn {
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../../../scenes/", $name, ".xml")),
        },)*];
    };
}

scenes! {
    "cornell-box": "the measured Cornell box, as in its photograph";
    "furnace": "a closed diffuse box that emits; every pixel has a closed-form answer";
    "veach-mis": "four glossy plates and four lamps of different size";
    "caustic": "light focused by a glass ball and a gold ring, both outside the picture";
    "caustic-seen": "the same with the glass and the ring in view";
    "cornell-lens": "the Cornell box through a wide lens";
    "ajar": "a room lit only through the gap of a door";
    "many-lights": "a hall lit by ten thousand small lamps";
}

macro_rules! files {
    ($($path:literal),* $(,)?) => {
        /// Files that the built-in scenes name, by path relative to them.
        pub const FILES: &[(&str, &[u8])] = &[$(($path, include_bytes!(concat!("../../../scenes/", $path))),)*];
    };
}

files!(
    "cornell-room.xml",
    "caustic-room.xml",
    "meshes/cornell-back.obj",
    "meshes/cornell-ceiling.obj",
    "meshes/cornell-floor.obj",
    "meshes/cornell-green.obj",
    "meshes/cornell-light.obj",
    "meshes/cornell-red.obj",
    "meshes/cornell-short-block.obj",
    "meshes/cornell-tall-block.obj",
    "meshes/lamps-0.ply",
    "meshes/lamps-1.ply",
    "meshes/lamps-2.ply",
    "meshes/lamps-3.ply",
    "meshes/lamps-4.ply",
);

/// The built-in scene of a name.
pub fn find(name: &str) -> Option<&'static BuiltIn> {
    SCENES.iter().find(|s| s.name == name)
}
