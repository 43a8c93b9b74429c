//! All mistakes of a file in one go: where reading has found some, what can be compiled of the rest is looked at too.
//!
//! A mistake that reading has found leaves a hole, and the compiler stumbles over holes. So of what the compiler says only that counts
//! which lies in a node without such a hole.

use etendue_description::{Description, Diagnostics, NodeId, Severity, Span, Value};
use etendue_scene::{CompileOptions, compile};

/// References deeper than this are refused by the reader, and not looked into.
const DEEPEST: u32 = 200;

/// Adds the compiler's errors that do not follow from those told already.
pub(crate) fn add_those_of_the_compiler(description: &Description, options: &CompileOptions, diagnostics: &mut Diagnostics) {
    if depth(description) > DEEPEST {
        return;
    }
    let mut more = Diagnostics::default();
    let _ = compile(description, options, &mut more);
    let holes: Vec<Span> = diagnostics.iter().filter(|d| d.severity == Severity::Error).filter_map(|d| d.span).collect();
    for told in more.iter().filter(|d| d.severity == Severity::Error) {
        let Some(span) = told.span.filter(|span| !follows(description, &holes, *span)) else { continue };
        let error = diagnostics.error(span, told.message.clone());
        error.labels.clone_from(&told.labels);
        error.help.clone_from(&told.help);
    }
}

/// Whether the innermost node around `at` has a hole in it.
fn follows(description: &Description, holes: &[Span], at: Span) -> bool {
    let contains =
        |outer: &Span, inner: &Span| outer.source == inner.source && outer.start <= inner.start && inner.end <= outer.end;
    let around = description.nodes.iter().map(|node| node.span).filter(|span| contains(span, &at));
    let innermost = around.min_by_key(|span| span.end - span.start).unwrap_or(at);
    holes.iter().any(|hole| contains(&innermost, hole))
}

/// How deep objects lie within objects; they never lie within themselves.
fn depth(description: &Description) -> u32 {
    let mut depths = vec![0u32; description.nodes.len()];
    let children = |node: NodeId| {
        let values = description.node(node).params.iter().map(|p| &p.value.value);
        values.filter_map(|v| if let Value::Node(child) = v { Some(*child) } else { None })
    };
    for start in 0..description.nodes.len() as u32 {
        let mut open = vec![NodeId(start)];
        while let Some(&node) = open.last() {
            let before = open.len();
            open.extend(children(node).filter(|child| depths[child.0 as usize] == 0));
            if open.len() == before {
                depths[node.0 as usize] = 1 + children(node).map(|child| depths[child.0 as usize]).max().unwrap_or(0);
                open.pop();
            }
        }
    }
    depths.into_iter().max().unwrap_or(0)
}
