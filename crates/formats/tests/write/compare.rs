//! Descriptions as lists of words and numbers, in which what means the same is written the same.

use etendue_description::{Description, Kind, Node, NodeId, SpectrumValue, Value};
use std::path::Path;

/// A word, or a number that may have been rounded.
#[derive(Clone, Debug, PartialEq)]
pub enum Token {
    Word(String),
    Number(f64),
}

/// Parameters whose numbers are colours.
const COLOURS: [&str; 17] = [
    "reflectance",
    "transmittance",
    "albedo",
    "radiance",
    "intensity",
    "irradiance",
    "eta",
    "k",
    "a",
    "b",
    "color0",
    "color1",
    "inside",
    "outside",
    "v00",
    "v01",
    "value",
];
/// What tells a mesh's reader how, and has been obeyed.
const OBEYED: [&str; 2] = ["flip_tex_coords", "shape_index"];

/// Everything that is rendered, with all that it refers to.
pub fn tokens(d: &Description) -> Vec<Token> {
    let mut out = Vec::new();
    let kinds = [Kind::Integrator, Kind::Sensor, Kind::Shape, Kind::Emitter];
    let in_shapes = |id: &NodeId| d.nodes.iter().any(|n| n.kind == Kind::Shape && children(n).contains(id));
    for kind in kinds {
        let top = d.top.iter().filter(|id| d.node(**id).kind == kind);
        // Groups and shared lights are told where they are shown.
        top.filter(|id| !in_shapes(id)).for_each(|id| node(d, *id, &mut out));
    }
    out
}

fn children(n: &Node) -> Vec<NodeId> {
    n.params.iter().filter_map(|p| if let Value::Node(id) = p.value.value { Some(id) } else { None }).collect()
}

fn word(out: &mut Vec<Token>, text: &str) {
    out.push(Token::Word(text.to_owned()));
}

fn node(d: &Description, id: NodeId, out: &mut Vec<Token>) {
    let n = d.node(id);
    let mesh = n.params.iter().any(|p| matches!(p.value.value, Value::Mesh(_)));
    word(out, n.kind.name());
    word(out, if mesh { "mesh" } else { &n.model.value });
    let mut params: Vec<_> = n.params.iter().filter(|p| !OBEYED.contains(&p.name.value.as_str())).collect();
    // Named ones by name; children stay in their order.
    params.sort_by_key(|p| (p.name.value.clone(), if let Value::Node(c) = p.value.value { Some(d.node(c).kind) } else { None }));
    // What a scene leaves out is written out.
    let holds = |kind: Kind| children(n).iter().any(|c| d.node(*c).kind == kind);
    let left_out = |out: &mut Vec<Token>, words: &[&str]| {
        words.iter().for_each(|w| out.push(w.parse().map_or_else(|_| Token::Word((*w).to_owned()), Token::Number)));
    };
    if n.kind == Kind::Film && !holds(Kind::Filter) {
        left_out(out, &["", "rfilter", "gaussian", "stddev", "0.5", "end"]);
    }
    if n.kind == Kind::Sensor && !holds(Kind::Film) {
        left_out(
            out,
            &["", "film", "hdrfilm", "", "rfilter", "gaussian", "stddev", "0.5", "end", "height", "576", "width", "768", "end"],
        );
    }
    let first = params.iter().position(|p| !p.name.value.is_empty());
    for (i, p) in params.into_iter().enumerate() {
        if Some(i) == first && n.kind == Kind::Sensor && !holds(Kind::Sampler) {
            left_out(out, &["", "sampler", "independent", "sample_count", "4", "seed", "0", "end"]);
        }
        word(out, &p.name.value);
        value(d, &p.name.value, &p.value.value, out);
    }
    word(out, "end");
}

fn value(d: &Description, name: &str, value: &Value, out: &mut Vec<Token>) {
    let colour = COLOURS.contains(&name);
    let numbers = |out: &mut Vec<Token>, list: &[f64]| out.extend(list.iter().map(|x| Token::Number(*x)));
    match value {
        Value::Float(x) if colour => numbers(out, &[*x; 3]),
        Value::Integer(i) if colour => numbers(out, &[*i as f64; 3]),
        Value::Float(x) => numbers(out, &[*x]),
        Value::Integer(i) => numbers(out, &[*i as f64]),
        Value::Rgb(rgb) => numbers(out, rgb),
        Value::Vector(v) => numbers(out, &v.to_array()),
        Value::Transform(t) => numbers(out, &t.matrix().to_cols_array()),
        Value::Spectrum(SpectrumValue::Constant(x)) => numbers(out, &[*x; 3]),
        Value::Spectrum(SpectrumValue::Samples(pairs)) => pairs.iter().for_each(|(nm, x)| numbers(out, &[*nm, *x])),
        Value::Spectrum(SpectrumValue::Blackbody { kelvin, scale }) => numbers(out, &[*kelvin, *scale]),
        Value::Bool(b) => word(out, &b.to_string()),
        Value::String(s) => word(out, s),
        Value::Path(path) => word(out, &content(path)),
        Value::Node(id) => node(d, *id, out),
        Value::Grid(i) => word(out, &format!("{:?}", d.assets.grids[*i as usize].data)),
        Value::Measured(i) => word(out, &format!("{:?}", d.assets.measured[*i as usize].spectra)),
        Value::Mesh(i) => {
            let m = &d.assets.meshes[*i as usize];
            word(out, &format!("{:?} {:?} {:?} {:?} {:?}", m.positions, m.normals, m.uvs, m.indices, m.attributes));
        }
    }
}

/// A file by what it holds.
fn content(path: &Path) -> String {
    let bytes = std::fs::read(path).unwrap();
    format!(
        "{} bytes, {:x}",
        bytes.len(),
        bytes.iter().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3))
    )
}

/// Whether both say the same; numbers within a relative tolerance.
pub fn same(a: &[Token], b: &[Token], tolerance: f64, shown: &str) {
    let near = |x: f64, y: f64| x == y || (x - y).abs() <= tolerance * (1.0 + x.abs().max(y.abs()));
    let equal = |x: &Token, y: &Token| match (x, y) {
        (Token::Number(x), Token::Number(y)) => near(*x, *y),
        _ => x == y,
    };
    let first = a.iter().zip(b).position(|(x, y)| !equal(x, y));
    if let Some(i) = first.or((a.len() != b.len()).then_some(a.len().min(b.len()))) {
        let from = i.saturating_sub(12);
        let cut = |t: &[Token]| format!("{:?}", t.iter().skip(from).take(20).collect::<Vec<_>>());
        panic!("token {i} differs:\n{}\n{}\n{shown}", cut(a), cut(b));
    }
}
