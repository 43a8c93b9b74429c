//! The page: one HTML file that needs nothing else, neither network nor fonts.

use super::maps::{DIFFERENCE, ERROR, css_gradient, diverging, map, sequential};
use super::plot::{convergence, css_colour};
use super::{Budget, Entry, Results};
use etendue_image::{Format, Image, Picture, SaveOptions, ToneMap, encode};
use etendue_solvers::agreement::{Area, Finding, Verdict};
use std::fmt::Write;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page as text.
pub fn page(results: &Results) -> String {
    let parts = [
        ("{{style}}", STYLE.to_owned()),
        ("{{title}}", escape(&format!("{}: {}", results.header.scene, names(results)))),
        ("{{scene}}", escape(&results.header.scene)),
        ("{{summary}}", summary(results)),
        ("{{table}}", table(results)),
        ("{{pictures}}", pictures(results)),
        ("{{choices_a}}", choices(results, 0)),
        ("{{choices_b}}", choices(results, results.solvers.len())),
        ("{{plot}}", plot(results)),
        ("{{differences}}", maps(results, "difference", diverging)),
        ("{{difference_legend}}", difference_legend()),
        ("{{blocks}}", blocks(results)),
        ("{{errors}}", maps(results, "error", sequential)),
        ("{{error_legend}}", error_legend()),
        ("{{notes}}", notes(results)),
        // What is embedded last may hold anything.
        ("{{script}}", SCRIPT.to_owned()),
    ];
    let mut text = String::with_capacity(TEMPLATE.len() + parts.iter().map(|p| p.1.len()).sum::<usize>());
    let mut rest = TEMPLATE;
    while let Some(at) = rest.find("{{") {
        text += &rest[..at];
        let name = &rest[at..rest[at..].find("}}").map_or(rest.len(), |n| at + n + 2)];
        text += parts.iter().find(|p| p.0 == name).map_or(name, |p| p.1.as_str());
        rest = &rest[at + name.len()..];
    }
    text + rest
}

fn names(results: &Results) -> String {
    results.solvers.iter().map(|s| s.solver.as_str()).collect::<Vec<_>>().join(", ")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn summary(r: &Results) -> String {
    let budget = match r.budget {
        Budget::Time(t) => format!("{} s each", t.as_secs_f64()),
        Budget::Samples(n) => format!("{n} samples per pixel each"),
    };
    format!(
        "{} at {} × {} pixels, {budget}, on {} threads, seed {}. Reference: {}.",
        escape(&names(r)),
        r.header.size[0],
        r.header.size[1],
        r.header.threads,
        r.header.seed,
        escape(&r.reference)
    )
}

/// A number without digits after its point, and without a sign before 0.
fn whole(x: f64) -> String {
    if x.abs() < 0.5 { "0".to_owned() } else { format!("{x:.0}").replace('-', "−") }
}

/// The same in the width of a cell.
fn short(t: f64) -> String {
    match t {
        t if t >= 99.5 => "≫".to_owned(),
        t if t <= -99.5 => "≪".to_owned(),
        t => whole(t),
    }
}

/// Three significant digits, powers of ten where they are many.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { "–".to_owned() };
    }
    let exponent = x.abs().log10().floor() as i32;
    if (-3..5).contains(&exponent) {
        let digits = (2 - exponent).max(0) as usize;
        return format!("{x:.digits$}").replace('-', "−");
    }
    let exponent_text = exponent.to_string().replace('-', "−");
    format!("{:.2}&#8239;·&#8239;10<sup>{exponent_text}</sup>", x / 10f64.powi(exponent)).replace('-', "−")
}

fn percent(x: f64) -> String {
    format!("{:+.2}&#8239;%", 100.0 * x).replace('-', "−")
}

fn table(r: &Results) -> String {
    let best = r.solvers.iter().map(|s| s.efficiency).fold(0.0, f64::max);
    let mut rows = String::new();
    for (i, s) in r.solvers.iter().enumerate() {
        let slope = s.slope.map_or("–".to_owned(), |s| format!("{s:+.2}").replace('-', "−"));
        let verdict = match &s.agreement {
            None if s.biased => {
                "<span class=\"verdict none\" title=\"right in the limit only: see the slope, and the interval of the bias\">biased</span>"
                    .to_owned()
            }
            None => {
                "<span class=\"verdict none\" title=\"it made the reference, and is not tested against itself\">reference</span>"
                    .to_owned()
            }
            Some(a) => {
                let class = match a.verdict {
                    Verdict::Pass => "pass",
                    Verdict::Fail => "fail",
                    Verdict::Inconclusive => "open",
                };
                format!("<span class=\"verdict {class}\" title=\"{}\">{}</span>", escape(&a.worst.to_string()), a.verdict)
            }
        };
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><i style=\"background:{}\"></i>{}</th><td>{}</td><td>{:.2}</td><td>{:.1}</td><td>{}</td>\
             <td>{}</td><td>{} ± {:.2}&#8239;%</td><td>{slope}</td><td>{verdict}</td></tr>",
            css_colour(i),
            escape(&s.solver),
            s.spp,
            s.seconds,
            s.rays as f64 / s.seconds.max(1e-9) / 1e6,
            number(s.rel_mse),
            number(s.efficiency / best.max(1e-300)),
            percent(s.bias),
            100.0 * s.bias_half_width,
        );
    }
    rows
}

/// The pictures of the viewer, all exposed alike: so that the reference's mean becomes a middle grey.
fn pictures(r: &Results) -> String {
    let mean = 0.2126 * r.reference_mean[0] + 0.7152 * r.reference_mean[1] + 0.0722 * r.reference_mean[2];
    let exposure = if mean > 0.0 { (0.25 / mean).log2().round() as f32 } else { 0.0 };
    let tone = ToneMap { exposure, ..ToneMap::default() };
    let mut text = String::new();
    let all = r.solvers.iter().map(|s| &s.picture).chain([&r.reference_picture]);
    for (i, picture) in all.enumerate() {
        if let Some(uri) = png(&tone.image(&picture.image)) {
            let _ = write!(text, "<img data-i=\"{i}\" alt=\"\" src=\"{uri}\">");
        }
    }
    text
}

fn choices(r: &Results, selected: usize) -> String {
    let all = r.solvers.iter().map(|s| s.solver.as_str()).chain(["reference"]);
    let option = |(i, name): (usize, &str)| {
        let mark = if i == selected { " selected" } else { "" };
        format!("<option value=\"{i}\"{mark}>{}</option>", escape(name))
    };
    all.enumerate().map(option).collect()
}

fn plot(r: &Results) -> String {
    let svg = convergence(r).unwrap_or_else(|| "<p>Too few passes for a curve.</p>".to_owned());
    let mut legend = String::new();
    for (i, s) in r.solvers.iter().enumerate() {
        let slope = s.slope.map_or("no slope".to_owned(), |s| format!("slope {s:+.2}").replace('-', "−"));
        let _ = write!(legend, "<li><i style=\"background:{}\"></i>{} <span>{slope}</span></li>", css_colour(i), escape(&s.solver));
    }
    format!("{svg}<ul class=\"legend\">{legend}</ul>")
}

fn maps(r: &Results, layer: &str, colour: fn(f64) -> [f64; 3]) -> String {
    let figure = |(i, s): (usize, &Entry)| {
        let image = map(s.picture.layer(layer)?, &r.reference_picture.image, colour)?;
        let uri = png(&image)?;
        let name = escape(&s.solver);
        let of = css_colour(i);
        Some(format!(
            "<figure><img src=\"{uri}\" alt=\"{layer} of {name}\"><figcaption><i style=\"background:{of}\"></i>{name}</figcaption></figure>"
        ))
    };
    r.solvers.iter().enumerate().filter_map(figure).collect()
}

fn difference_legend() -> String {
    let gradient = css_gradient(diverging, |x| DIFFERENCE * (2.0 * x - 1.0));
    let p = 100.0 * DIFFERENCE;
    let ticks = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|x| format!("<span>{}</span>", format!("{:+}&#8239;%", p * x).replace('-', "−")));
    legend(&gradient, &ticks.concat(), "darker ← relative to the reference’s luminance → brighter")
}

fn error_legend() -> String {
    let [low, high] = ERROR;
    let gradient = css_gradient(sequential, |x| low * (high / low).powf(x));
    let ticks = [0.1, 1.0, 10.0, 100.0].map(|p| format!("<span>{p}&#8239;%</span>"));
    legend(&gradient, &ticks.concat(), "standard error of a pixel, relative to its luminance, logarithmic")
}

fn legend(gradient: &str, ticks: &str, words: &str) -> String {
    format!("<div class=\"scale\"><div style=\"background:{gradient}\"></div><p>{ticks}</p><p class=\"words\">{words}</p></div>")
}

/// The blocks of each tested solver: t of the channel that is worst, and a frame where it fails.
fn blocks(r: &Results) -> String {
    let mut text = String::new();
    for (i, s) in r.solvers.iter().enumerate() {
        let Some(a) = &s.agreement else { continue };
        let mut cells = String::new();
        for of_area in a.findings.chunks(3) {
            // Of the channels that tell something, where one does.
            let rank = |f: &&Finding| if f.evidence >= 1.0 { 1.0 + f.t.abs() } else { 0.0 };
            let worst = of_area.iter().max_by(|x, y| rank(x).total_cmp(&rank(y)));
            let Some(f) = worst.filter(|f| f.area != Area::Picture) else { continue };
            let t = f.t.clamp(-10.0, 10.0);
            let colour = super::maps::hex(diverging(DIFFERENCE * t / 6.0));
            let failed = of_area.iter().any(|f| f.verdict == Verdict::Fail);
            let told = of_area.iter().any(|f| f.evidence >= 1.0);
            let class = if failed {
                " class=\"fail\""
            } else if told {
                ""
            } else {
                " class=\"untold\""
            };
            let _ = write!(
                cells,
                "<b{class} style=\"background:{colour}\" title=\"{}\">{}</b>",
                escape(&f.to_string()),
                if told { short(f.t) } else { "·".to_owned() }
            );
        }
        let _ = write!(
            text,
            "<figure><div class=\"blocks\" style=\"--columns:{};--ratio:{}/{}\">{cells}</div><figcaption><i style=\"background:{}\"></i>{}: \
             {}. Worst: {}. A bias of {} of the picture, or {} of a block, would have been seen.</figcaption></figure>",
            r.header.blocks[0],
            r.header.size[0],
            r.header.size[1],
            css_colour(i),
            escape(&s.solver),
            a.verdict,
            escape(&a.worst.to_string()).replace('-', "−"),
            percent(a.visible_picture).replace('+', ""),
            percent(a.visible_block).replace('+', ""),
        );
    }
    if text.is_empty() { "<p>No solver was tested.</p>".to_owned() } else { text }
}

fn notes(r: &Results) -> String {
    format!(
        "The reference's own relMSE is {}, and is taken off the errors. {} comparisons of areas and channels are one family with {}&#8239;% \
         of false alarms. Bounds: {}&#8239;% of the picture, {}&#8239;% of a block. Written by {}.",
        number(r.reference_rel_mse),
        r.tests,
        100.0 * r.header.standard.alpha,
        100.0 * r.header.standard.bound,
        100.0 * r.header.standard.block_bound,
        escape(&r.header.software)
    )
}

/// A picture as a data URI.
fn png(image: &Image) -> Option<String> {
    let bytes = encode(&Picture::from(image.clone()), Format::Png, &SaveOptions::default()).ok()?;
    Some(format!("data:image/png;base64,{}", base64(&bytes)))
}

/// Base64 with padding [RFC 4648, §4].
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |b, x| b << 8 | u32::from(*x)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i > chunk.len() { '=' } else { char::from(digit) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standards_examples() {
        let pairs = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")];
        for (plain, coded) in pairs {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn numbers_as_people_write_them() {
        assert_eq!(["0.0123", "12.3", "1230"], [0.0123, 12.3, 1230.0].map(number).each_ref().map(String::as_str));
        assert_eq!(number(-0.5), "−0.500");
        assert_eq!(number(1.5e-7), "1.50&#8239;·&#8239;10<sup>−7</sup>");
    }
}
