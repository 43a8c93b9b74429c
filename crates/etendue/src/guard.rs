//! Panics of a render become words: what was rendered before is kept.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `f`; a panic in it, on whatever thread of the pool, becomes its words.
pub(crate) fn guarded<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    // What a panic leaves behind is looked at through the film alone, whose sums are whole at any time.
    catch_unwind(AssertUnwindSafe(f)).map_err(|payload| panic_words(&*payload))
}

/// What a panic says.
pub fn panic_words(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str).or_else(|| payload.downcast_ref::<&str>().copied());
    text.unwrap_or("a panic without words").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pool;
    use etendue_film::{Film, FilmShape};
    use etendue_numerics::kernel::Kernel;
    use rayon::prelude::*;

    /// A panic on a thread of the pool comes back as its words, and what other tiles added stays on the film.
    #[test]
    fn a_panic_does_not_take_the_film_with_it() {
        let pool = pool::pool(Some(2)).expect("two threads");
        let film = Film::new(FilmShape { size: [8, 8], kernel: Kernel::Box { radius: 0.5 } });
        let words = guarded(|| {
            pool.install(|| {
                (0..8u32).into_par_iter().for_each(|y| {
                    assert!(y != 5, "row {y} is bad");
                    let mut tile = film.tile();
                    tile.begin([0, y], [8, y + 1]);
                    tile.add(etendue_numerics::Vec2::new(0.5, y as f32 + 0.5), etendue_numerics::Spectrum::ONE, 0);
                    film.add_tile(&tile);
                });
            });
        });
        assert_eq!(words, Err("row 5 is bad".to_owned()));
        let column: Vec<f32> = film.develop().chunks(8).map(|row| row[0][0]).collect();
        assert!(column[5] == 0.0 && column.contains(&1.0), "{column:?}");
    }
}
