//! What particles leave behind: splats on the film, and entries in the books.

use super::{LightContext, Particle, SensorQuery, arrives_at_sensor, light_slot, surroundings};
use etendue_film::Splat;
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2};
use etendue_scene::FilmSettings;

/// The entries of some particles, in f64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entries {
    /// Flux that set out.
    pub emitted: [f64; 3],
    /// Flux left at surfaces.
    pub absorbed: [f64; 3],
    /// Flux that met nothing.
    pub escaped: [f64; 3],
    /// Flux that was given up.
    pub cut: [f64; 3],
}

/// What the particles of a chunk add up to.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    splats: Vec<Splat>,
    entries: Entries,
    /// Rays cast.
    pub rays: u64,
    /// The particle that is followed, counted through all passes.
    particle: u64,
    /// The crop: its first pixel and its size.
    crop: [Vec2; 2],
}

impl Tally {
    /// Nothing yet, for a film.
    pub fn new(film: &FilmSettings) -> Self {
        let crop = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        Self { crop, ..Self::default() }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.splats.clear();
        (self.rays, self.entries) = (0, Entries::default());
    }

    /// Turns to another particle.
    pub fn begin(&mut self, particle: u64) {
        self.particle = particle;
    }

    /// What reached the film.
    pub fn splats(&self) -> &[Splat] {
        &self.splats
    }

    /// What became of the flux.
    pub fn entries(&self) -> &Entries {
        &self.entries
    }

    /// Light that reached the full film's position `pixel`; dropped beyond the crop.
    #[inline]
    pub fn splat(&mut self, pixel: Vec2, value: Spectrum) {
        if self.shows(pixel) && !value.is_zero() {
            self.splats.push(Splat { position: pixel - self.crop[0], value, particle: self.particle });
        }
    }

    /// Light that a connection brings to the sensor.
    #[inline]
    pub fn connect(&mut self, c: &LightContext<'_>, query: &SensorQuery, particle: &Particle) {
        if self.shows(query.pixel) {
            self.rays += 1;
            self.splat(query.pixel, particle.wl.to_rgb(arrives_at_sensor(c, query, &particle.wl)));
        }
    }

    /// Light of the surroundings that needs no bounce, at one position of the particle's own pixel: a particle a pixel, so each counts for all pixels.
    pub fn surroundings(&mut self, c: &LightContext<'_>, u: &Sampler) {
        let [corner, size] = self.crop;
        let pixels = (size.x * size.y) as u64;
        let (place, width) = (self.particle % pixels.max(1), size.x as u64);
        let own = Vec2::new((place % width) as f32, (place / width) as f32) + u.u2(Dim::at(0, light_slot::PIXEL));
        if let Some(l) = surroundings(c, corner + own, u, self) {
            self.splat(corner + own, l * (size.x * size.y));
        }
    }

    /// Flux that sets out.
    pub fn emitted(&mut self, flux: Spectrum) {
        Entries::add(&mut self.entries.emitted, flux);
    }

    /// Flux left at a surface.
    pub fn absorbed(&mut self, flux: Spectrum) {
        Entries::add(&mut self.entries.absorbed, flux);
    }

    /// Flux that meets nothing.
    pub fn escaped(&mut self, flux: Spectrum) {
        Entries::add(&mut self.entries.escaped, flux);
    }

    /// Flux that is given up.
    pub fn cut(&mut self, flux: Spectrum) {
        Entries::add(&mut self.entries.cut, flux);
    }

    #[inline]
    fn shows(&self, pixel: Vec2) -> bool {
        let own = pixel - self.crop[0];
        own.cmpge(Vec2::ZERO).all() && own.cmplt(self.crop[1]).all()
    }
}

impl Entries {
    /// Adds `flux` to one of the entries.
    #[inline]
    fn add(entry: &mut [f64; 3], flux: Spectrum) {
        entry.iter_mut().zip(flux.to_rgb()).for_each(|(e, f)| *e += f64::from(f));
    }
}
