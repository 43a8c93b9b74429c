//! Rendering, pictures side by side, and plots.

use crate::Drawn;
use etendue::{Image, LoadOptions, RenderOptions, Stop, ToneMap, Watch, load, render};
use etendue_image::{Picture, SaveOptions, save};
use plotters::prelude::*;
use std::path::Path;

/// What is rendered.
pub struct Shot<'a> {
    /// A scene's name or file.
    pub scene: &'a str,
    /// By which solver, with which parameters.
    pub solver: &'a str,
    pub parameters: &'a [(&'a str, &'a str)],
    /// Pixels across.
    pub width: u32,
    pub stop: Stop,
}

impl Shot<'_> {
    /// The picture, linear.
    pub fn take(&self) -> Drawn<Image> {
        self.take_with(LoadOptions::default())
    }

    /// The same of a scene that is loaded in a way of its own.
    pub fn take_with(&self, options: LoadOptions) -> Drawn<Image> {
        let loaded = load(self.scene, &LoadOptions { width: Some(self.width), ..options })?;
        let own = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        let options = RenderOptions {
            solver: Some(self.solver.to_owned()),
            parameters: self.parameters.iter().map(own).collect(),
            stop: Some(self.stop),
            ..RenderOptions::default()
        };
        let rendering = render(&loaded, &options, &Watch::default())?;
        println!(
            "{} by {}: {:.1} s, {} samples per pixel",
            self.scene, self.solver, rendering.stats.render_seconds, rendering.stats.spp
        );
        Ok(rendering.picture.image)
    }
}

/// Pictures of equal size, row by row, with a white gap between, as a PNG.
pub fn grid(path: &Path, rows: &[Vec<Image>], exposure: f32) -> Drawn {
    const GAP: usize = 6;
    let first = &rows[0][0];
    let (w, h) = (first.width(), first.height());
    let (width, height) = (rows[0].len() * (w + GAP) - GAP, rows.len() * (h + GAP) - GAP);
    let mut data = vec![1.0f32; 3 * width * height];
    let tone = ToneMap { exposure, ..ToneMap::default() };
    let mut encoding = first.encoding();
    for (r, row) in rows.iter().enumerate() {
        for (c, image) in row.iter().enumerate() {
            let image = tone.image(image);
            encoding = image.encoding();
            for (i, pixel) in image.pixels().enumerate() {
                let at = 3 * ((r * (h + GAP) + i / w) * width + c * (w + GAP) + i % w);
                data[at..at + 3].copy_from_slice(&pixel[..3]);
            }
        }
    }
    let image = Image::rgb(width, height, data)?.with_encoding(encoding);
    save(path, &Picture { image, layers: Vec::new(), attributes: Vec::new() }, &SaveOptions::default())?;
    println!("wrote {}", path.display());
    Ok(())
}

/// A curve with its name.
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Curves on logarithmic axes, as an SVG.
pub fn plot(path: &Path, x_axis: &str, y_axis: &str, curves: &[Curve]) -> Drawn {
    let colours = etendue::compare::COLOURS.map(|(r, g, b)| RGBColor(r, g, b));
    let range = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let all = || curves.iter().flat_map(|c| &c.points).map(of);
        (all().fold(f64::INFINITY, f64::min) / 1.4..all().fold(0.0, f64::max) * 1.4).log_scale()
    };
    let root = SVGBackend::new(path, (640, 380)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(72)
        .build_cartesian_2d(range(&|p| p.0), range(&|p| p.1))?;
    chart
        .configure_mesh()
        .x_desc(x_axis)
        .y_desc(y_axis)
        .bold_line_style(RGBColor(220, 222, 223))
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .x_label_formatter(&|v| etendue::compare::axis_number(*v))
        .y_label_formatter(&|v| etendue::compare::axis_number(*v))
        .draw()?;
    for (curve, colour) in curves.iter().zip(colours) {
        chart
            .draw_series(LineSeries::new(curve.points.iter().copied(), colour.stroke_width(2)))?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        chart.draw_series(curve.points.iter().map(|p| Circle::new(*p, 4, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.85))
        .label_font(("sans-serif", 14))
        .position(free_corner(curves))
        .draw()?;
    root.present()?;
    println!("wrote {}", path.display());
    Ok(())
}

/// The corner of the plot that the curves leave most room in: where the legend goes.
fn free_corner(curves: &[Curve]) -> SeriesLabelPosition {
    let logs = || curves.iter().flat_map(|c| &c.points).map(|(x, y)| [x.ln(), y.ln()]);
    let least = logs().fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    let most = logs().fold([f64::NEG_INFINITY; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    let place = |(x, y): &(f64, f64)| {
        let part = |v: f64, k: usize| (v.ln() - least[k]) / (most[k] - least[k]).max(f64::MIN_POSITIVE);
        [part(*x, 0), part(*y, 1)]
    };
    // The distance, in parts of the axes, from a corner to the nearest place on a curve.
    let room = |corner: [f64; 2]| {
        let mut nearest = f64::INFINITY;
        for pair in curves.iter().flat_map(|c| c.points.windows(2)) {
            let [a, b] = [place(&pair[0]), place(&pair[1])];
            for step in 0..=8 {
                let t = f64::from(step) / 8.0;
                let at = |k: usize| a[k] + t * (b[k] - a[k]) - corner[k];
                nearest = nearest.min(at(0).hypot(at(1)));
            }
        }
        nearest
    };
    let corners = [
        ([0.0, 0.0], SeriesLabelPosition::LowerLeft),
        ([1.0, 1.0], SeriesLabelPosition::UpperRight),
        ([0.0, 1.0], SeriesLabelPosition::UpperLeft),
        ([1.0, 0.0], SeriesLabelPosition::LowerRight),
    ];
    let freest = corners.into_iter().reduce(|best, next| if room(next.0) > room(best.0) { next } else { best });
    freest.map_or(SeriesLabelPosition::LowerLeft, |(_, position)| position)
}
