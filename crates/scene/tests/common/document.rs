//! Descriptions made by hand: every node and parameter gets a line of its own, so that messages have places.

use etendue_description::{Description, Diagnostics, Kind, Node, NodeId, Param, Span, Spanned, Value};
use etendue_scene::{CompileOptions, Scene, compile};

#[derive(Default)]
pub struct Document {
    description: Description,
    text: String,
}

impl Document {
    fn write<T>(&mut self, word: &str, value: T) -> Spanned<T> {
        let start = self.text.len() as u32;
        self.text.push_str(word);
        self.text.push('\n');
        let source = etendue_description::SourceId(0);
        Spanned::new(value, Span { source, start, end: start + word.len() as u32 })
    }

    /// A node on lines of its own: the model first, then a line for each parameter.
    pub fn node(&mut self, kind: Kind, model: &str, params: &[(&str, Value)]) -> NodeId {
        let model = self.write(model, model.to_owned());
        let params: Vec<Param> = params
            .iter()
            .map(|(name, value)| {
                let word = if name.is_empty() { "child" } else { name };
                let name = self.write(word, (*name).to_owned());
                Param { value: Spanned::new(value.clone(), name.span), name }
            })
            .collect();
        let span = model.span;
        self.description.add(Node { kind, model, id: None, params, span })
    }

    /// A node of the scene itself.
    pub fn top(&mut self, kind: Kind, model: &str, params: &[(&str, Value)]) -> NodeId {
        let id = self.node(kind, model, params);
        self.description.top.push(id);
        id
    }

    pub fn assets(&mut self) -> &mut etendue_description::Assets {
        &mut self.description.assets
    }

    /// The scene and the messages as text.
    pub fn compile(mut self) -> (Option<Scene>, String) {
        self.description.sources.add("scene", self.text.clone());
        let mut diagnostics = Diagnostics::default();
        let scene = compile(&self.description, &CompileOptions::default(), &mut diagnostics);
        (scene, diagnostics.render(&self.description.sources))
    }

    /// The scene, which has no errors.
    pub fn scene(self) -> Scene {
        let (scene, messages) = self.compile();
        scene.unwrap_or_else(|| panic!("{messages}"))
    }

    /// The messages of a scene that cannot be compiled.
    pub fn refused(self) -> String {
        let (scene, messages) = self.compile();
        assert!(scene.is_none(), "{messages}");
        messages
    }
}
