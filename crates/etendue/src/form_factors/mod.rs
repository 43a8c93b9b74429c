//! Form factors of a scene: between patches, and between whole shapes, each number with its standard error.
//!
//! ```text
//! F_AB = Σ_i∈A A_i Σ_j∈B F_ij / Σ_i∈A A_i        between shapes A and B
//! ```
//!
//! A shape is named by its id in the scene, else by its mesh file, else by its model, with its number where names repeat; one facet of it is
//! `NAME:FACET`.

mod files;
mod words;

pub use files::{ENDINGS, csv, json, matrix_market, npz, write};

use crate::load::Loaded;
use crate::surfaces::{self, Defect};
use crate::{memory, pool, render::RenderError};
use etendue_description::nearest;
use etendue_radiosity::form_factor::{FormFactors, Method, Open, Repair, Watch};
use etendue_radiosity::{Cutting, Patches};
use std::ops::Range;

/// What to compute.
#[derive(Clone, Copy, Debug)]
pub struct FormFactorOptions {
    /// How to cut surfaces into patches.
    pub cutting: Cutting,
    /// How to find the factors.
    pub method: Method,
    /// Whether reciprocity and closure are restored.
    pub repair: bool,
    /// Threads; all cores where none is told.
    pub threads: Option<usize>,
}

/// Form factors with what they are between.
#[derive(Debug)]
pub struct ShapeFactors {
    /// The patches.
    pub patches: Patches,
    /// The factors between them.
    pub factors: FormFactors,
    /// The names of the shapes, objects of [`ShapeFactors::patches`].
    pub names: Vec<String>,
    /// What the repair did.
    pub repair: Option<Repair>,
    /// The same factors between shapes as estimated, before the repair: F and its standard error, row by row.
    pub between: Vec<Vec<(f64, f64)>>,
    /// Of z = (A_i F_ij - A_j F_ji) / SE before the repair, over pairs that both sides have seen: Σ z², their number, the largest |z|.
    pub reciprocity: (f64, usize, f64),
    /// What is wrong with the surfaces.
    pub defects: Vec<Defect>,
    /// What should be said about the scene: of defects the first few.
    pub warnings: Vec<String>,
    /// The method's name.
    pub method: &'static str,
}

/// Which shape, or which facet of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// As it was named.
    pub name: String,
    /// Its patches.
    pub patches: Vec<u32>,
}

/// The form factors of a scene.
pub fn form_factors(loaded: &Loaded, options: &FormFactorOptions, watch: &Watch) -> Result<ShapeFactors, RenderError> {
    pool::pool(options.threads)?.install(|| form_factors_here(loaded, options, watch))
}

fn form_factors_here(loaded: &Loaded, options: &FormFactorOptions, watch: &Watch) -> Result<ShapeFactors, RenderError> {
    let patches = Patches::cut(&loaded.scene, &options.cutting).map_err(|e| RenderError(words::too_many(&e)))?;
    if patches.is_empty() {
        return Err(RenderError("the scene has no surface that could be cut into patches".to_owned()));
    }
    let room = memory::available().unwrap_or(u64::MAX);
    options.method.check(patches.len(), room).map_err(|e| RenderError(words::too_large(&e, options.method.name(), room)))?;
    let names = surfaces::names(loaded, &patches);
    let defects = surfaces::defects(loaded, &patches, &names);
    let mut warnings = surfaces::words(&defects);
    let mut factors = options.method.run(&loaded.scene, &patches, watch).map_err(|_| RenderError("stopped".to_owned()))?;
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let between = between(&patches, &factors);
    let reciprocity = reciprocity(&factors, &areas);
    let repair = options.repair.then(|| factors.repair(&areas, Open::Reciprocal));
    if let Some(told) = repair.filter(|r| r.closure_after > 1e-12) {
        warnings.push(format!("warning: after {} sweeps rows are still {:.1e} off", told.sweeps, told.closure_after));
    }
    Ok(ShapeFactors { patches, factors, names, repair, between, reciprocity, defects, warnings, method: options.method.name() })
}

/// F between shapes with standard errors. Errors of what one row counts are counted together; those of different rows are independent.
fn between(patches: &Patches, factors: &FormFactors) -> Vec<Vec<(f64, f64)>> {
    let n = patches.objects.len();
    let row = |rows: Range<u32>| {
        let mut sums = vec![(0.0, 0.0); n];
        let mut total = 0.0;
        for i in rows {
            let (i, area) = (i as usize, patches.get(i).area);
            total += area;
            let mut add = |to: usize, f: f64, error: f64| {
                if let Some((sum, variance)) = sums.get_mut(to) {
                    (*sum, *variance) = (*sum + area * f, *variance + (area * error).powi(2));
                }
            };
            match &factors.to_objects {
                Some(counted) => {
                    for k in counted.rows.indptr().outer_inds_sz(i) {
                        add(counted.rows.indices()[k] as usize, counted.rows.data()[k].into(), counted.errors[k].into());
                    }
                }
                None => factors.row(i).for_each(|(j, f)| add(patches.patches[j].object as usize, f, factors.error(i, j))),
            }
        }
        sums.into_iter()
            .map(|(sum, variance)| if total > 0.0 { (sum / total, variance.sqrt() / total) } else { (0.0, 0.0) })
            .collect()
    };
    patches.objects.iter().map(|o| row(o.patches.clone())).collect()
}

/// Σ z² over pairs with z = (A_i F_ij - A_j F_ji) / SE, how many there are, and the largest |z|: both sides must have seen enough of each other for
/// their errors to be known.
fn reciprocity(factors: &FormFactors, areas: &[f64]) -> (f64, usize, f64) {
    /// Standard errors that F must be above zero.
    const SEEN: f64 = 5.0;
    let (mut sum, mut count, mut most) = (0.0, 0, 0.0f64);
    for i in 0..factors.len() {
        for (j, f) in factors.row(i).filter(|(j, _)| *j < i) {
            let (back, errors) = (factors.get(j, i), [factors.error(i, j), factors.error(j, i)]);
            if errors[0] > 0.0 && errors[1] > 0.0 && f > SEEN * errors[0] && back > SEEN * errors[1] {
                let variance = (areas[i] * errors[0]).powi(2) + (areas[j] * errors[1]).powi(2);
                let z2 = (areas[i] * f - areas[j] * back).powi(2) / variance;
                sum += z2;
                most = most.max(z2.sqrt());
                count += 1;
            }
        }
    }
    (sum, count, most)
}

impl ShapeFactors {
    /// The patches of a shape by its name, or of one facet of it.
    pub fn select(&self, text: &str) -> Result<Selection, RenderError> {
        let (name, facet) = match text.rsplit_once(':') {
            Some((name, facet)) if !self.names.iter().any(|n| n == text) => {
                let number =
                    facet.parse::<u32>().map_err(|_| RenderError(format!("`{facet}` in `{text}` is no number of a facet")))?;
                (name, Some(number))
            }
            _ => (text, None),
        };
        let Some(object) = self.names.iter().position(|n| n == name) else {
            let mut words = format!("no shape is called `{name}`");
            if let Some(near) = nearest(name, self.names.iter().map(String::as_str)) {
                words += &format!("\n  help: did you mean `{near}`?");
            }
            words += &format!("\n  help: shapes: {}", self.names.join(", "));
            return Err(RenderError(words));
        };
        let of_facet = |i: &u32| facet.is_none_or(|f| self.patches.triangles_of(*i).contains(&f));
        let patches: Vec<u32> = self.patches.objects[object].patches.clone().filter(of_facet).collect();
        if patches.is_empty() {
            return Err(RenderError(format!("`{text}` has no patches")));
        }
        Ok(Selection { name: text.to_owned(), patches })
    }

    /// F from one selection to another, its standard error, and why it is zero if it is.
    pub fn between_selections(&self, from: &Selection, to: &Selection) -> (f64, f64, Option<&'static str>) {
        let (mut sum, mut variance, mut total) = (0.0, 0.0, 0.0);
        for i in &from.patches {
            let (i, area) = (*i as usize, self.patches.get(*i).area);
            total += area;
            for j in &to.patches {
                sum += area * self.factors.get(i, *j as usize);
                variance += (area * self.factors.error(i, *j as usize)).powi(2);
            }
        }
        // Of whole shapes the error was counted as one.
        let whole = |s: &Selection| self.patches.objects.iter().position(|o| o.patches.clone().eq(s.patches.iter().copied()));
        let counted = whole(from).zip(whole(to)).filter(|_| self.factors.to_objects.is_some()).map(|(a, b)| self.between[a][b].1);
        let error = counted.unwrap_or(variance.sqrt() / total);
        (sum / total, error, (sum == 0.0).then(|| words::why_zero(&self.patches, from, to)))
    }
}
