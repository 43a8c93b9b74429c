//! Ray casting: a wide bounding volume hierarchy over triangles, custom shapes and instances.
