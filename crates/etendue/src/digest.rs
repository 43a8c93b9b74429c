//! What a scene boils down to: 64 bits that change when anything does that decides the picture. A checkpoint remembers them.

use crate::load::LoadOptions;
use etendue_description::{Description, SourceId, Value};
use etendue_numerics::sequence::mix;
use std::collections::BTreeSet;

/// A digest that eats bytes, eight at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digest(u64);

impl Digest {
    /// The digest of nothing, of this version of the program: another version may give other bits.
    pub(crate) fn new() -> Self {
        let mut digest = Self(0);
        digest.bytes(crate::render::software().as_bytes());
        digest
    }

    /// Eats one word.
    pub(crate) fn word(&mut self, word: u64) {
        self.0 = mix(self.0.rotate_left(23) ^ word);
    }

    /// Eats bytes, and their number.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.word(u64::from_le_bytes(word));
        }
    }

    fn floats<'a>(&mut self, numbers: impl Iterator<Item = &'a f32>) {
        numbers.for_each(|x| self.word(u64::from(x.to_bits())));
    }

    /// What was eaten.
    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}

/// The digest of all scene texts, of the meshes, grids and pictures that they name, and of the values given to them.
pub(crate) fn scene(description: &Description, options: &LoadOptions) -> u64 {
    let mut digest = Digest::new();
    digest.word(options.spectral.map_or(0, |spectral| 1 + u64::from(spectral)));
    for i in 0..description.sources.len() {
        digest.bytes(description.sources.text(SourceId(i as u32)).as_bytes());
    }
    for mesh in &description.assets.meshes {
        digest.floats(mesh.positions.iter().chain(&mesh.normals).flat_map(|v| v.as_ref() as &[f32; 3]));
        digest.floats(mesh.uvs.iter().flat_map(|v| v.as_ref() as &[f32; 2]));
        mesh.indices.as_flattened().iter().for_each(|i| digest.word(u64::from(*i)));
        mesh.attributes.iter().for_each(|a| digest.floats(a.data.iter()));
    }
    for grid in &description.assets.grids {
        digest.floats(grid.data.iter());
    }
    let values = description.nodes.iter().flat_map(|node| &node.params).map(|param| &param.value.value);
    let paths: BTreeSet<_> = values.filter_map(|v| if let Value::Path(path) = v { Some(path) } else { None }).collect();
    for path in paths {
        let held = description.assets.files.get(path).map(|bytes| bytes.to_vec());
        // A file that has gone since it was read has no bytes to be told apart by.
        digest.bytes(&held.or_else(|| std::fs::read(path).ok()).unwrap_or_default());
    }
    for (name, value) in &options.defines {
        digest.bytes(name.as_bytes());
        digest.bytes(value.as_bytes());
    }
    for side in [options.width, options.height] {
        digest.word(side.map_or(0, |n| u64::from(n) + 1));
    }
    digest.finish()
}
