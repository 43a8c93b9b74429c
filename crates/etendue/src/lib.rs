//! A physically based renderer and light-transport laboratory.
