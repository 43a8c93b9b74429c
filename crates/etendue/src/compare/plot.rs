//! Error against time on logarithmic axes, as inline SVG that takes the page's colours.

use super::Results;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Stands for the colour of the page's text, and of its faint lines: replaced by CSS after drawing.
const INK: RGBColor = RGBColor(1, 2, 3);
const FAINT: RGBColor = RGBColor(3, 2, 1);
const SIZE: (u32, u32) = (760, 400);

/// Eight colours that are told apart on light and on dark, and by the colour-blind [Okabe, Ito 2008].
pub const COLOURS: [(u8, u8, u8); 8] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (180, 150, 20), (86, 180, 233), (140, 86, 75), (127, 127, 127)];

/// The colour of the i-th solver, as CSS.
pub fn css_colour(i: usize) -> String {
    let (r, g, b) = COLOURS[i % COLOURS.len()];
    format!("rgb({r}, {g}, {b})")
}

/// The plot; `None` where there is nothing to draw.
pub fn convergence(results: &Results) -> Option<String> {
    let points = || results.solvers.iter().flat_map(|s| &s.series).filter(|p| p.rel_mse > 0.0 && p.seconds > 0.0);
    let range = |f: &dyn Fn(&super::Point) -> f64| {
        let (low, high) = points().map(f).fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(x), h.max(x)));
        (low < high).then(|| low / 1.5..high * 1.5)
    };
    let (x, y) = (range(&|p| p.seconds)?, range(&|p| p.rel_mse)?);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        draw(&root, results, x, y).ok()?;
        root.present().ok()?;
    }
    let svg = svg.replace("#010203", "currentColor").replace("#030201", "var(--faint)");
    let (w, h) = SIZE;
    Some(svg.replacen(
        &format!(r#"width="{w}" height="{h}""#),
        r#"role="img" aria-label="relMSE against time in seconds, both axes logarithmic""#,
        1,
    ))
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

fn draw(root: &DrawingArea<SVGBackend<'_>, Shift>, results: &Results, x: std::ops::Range<f64>, y: std::ops::Range<f64>) -> Drawn {
    let font = |size: i32| ("sans-serif", size).into_font().color(&INK);
    let mut chart = ChartBuilder::on(root)
        .margin(8)
        .margin_right(20)
        .x_label_area_size(48)
        .y_label_area_size(78)
        .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())?;
    chart
        .configure_mesh()
        .x_desc("time, s")
        .y_desc("relMSE")
        .axis_style(INK)
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .label_style(font(14))
        .axis_desc_style(font(15))
        .x_label_formatter(&|v| axis_number(*v))
        .y_label_formatter(&|v| axis_number(*v))
        .draw()?;
    for (i, solver) in results.solvers.iter().enumerate() {
        let (r, g, b) = COLOURS[i % COLOURS.len()];
        let colour = RGBColor(r, g, b);
        let points: Vec<(f64, f64)> =
            solver.series.iter().filter(|p| p.rel_mse > 0.0 && p.seconds > 0.0).map(|p| (p.seconds, p.rel_mse)).collect();
        chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?;
        chart.draw_series(points.iter().map(|p| Circle::new(*p, 4, colour.filled())))?;
    }
    Ok(())
}

/// Powers of ten as such, twice and five times them short, and nothing at the other lines: they are too many.
pub fn axis_number(v: f64) -> String {
    let exponent = v.log10();
    let first_digit = 10f64.powf(exponent - (exponent + 1e-9).floor()).round() as u32;
    if ![1, 2, 5].contains(&first_digit) {
        return String::new();
    }
    if (exponent - exponent.round()).abs() < 1e-6 && !(-2.0..=3.0).contains(&exponent) {
        let digits = |n: i32| n.to_string().chars().map(superscript).collect::<String>();
        return format!("10{}", digits(exponent.round() as i32));
    }
    match v {
        v if !(1e-3..1e4).contains(&v) => format!("{v:.0e}"),
        v => format!("{}", (v * 1e4).round() / 1e4),
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_on_axes() {
        let text = [1.0, 0.1, 1e-5, 1e4, 0.2, 2e-4, 0.3, 70.0].map(axis_number);
        assert_eq!(text, ["1", "0.1", "10⁻⁵", "10⁴", "0.2", "2e-4", "", ""]);
    }
}
