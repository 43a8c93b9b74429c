//! Typed indices into the scene's flat arrays.

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            /// The position in its array.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// A surface: a shape with its material and emission.
    SurfaceId,
    /// A material.
    MaterialId,
    /// An emitter.
    EmitterId,
    /// A texture.
    TextureId,
}

/// Stands for "not part of an instance".
pub const NO_INSTANCE: u32 = u32::MAX;
