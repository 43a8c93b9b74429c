//! The scene as inert data with source spans.
