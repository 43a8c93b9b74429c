//! The compiled scene: shapes, materials, emitters, sensors, textures.
