//! `etendue convert`: a scene in another format.

use super::scene::{SceneArguments, SizeArguments};
use super::{Done, output};
use clap::Args;
use etendue::convert::{ConvertError, ConvertOptions, Converted, convert, target_named};
use etendue_formats::write::{Fate, Note, Target};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Writes a scene as Mitsuba 3 or pbrt-v4, and says what was kept, approximated and dropped.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue convert kitchen.pbrt kitchen.xml")]
pub struct ConvertArguments {
    /// A scene file, or the name of a built-in scene.
    input: String,
    /// The file to write: `.xml` for Mitsuba 3, `.pbrt` for pbrt-v4.
    output: PathBuf,
    /// The format, whatever the file's ending: mitsuba, pbrt.
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    to: Option<Target>,
    /// Keep étendue's own models where Mitsuba has none: the picture stays the same, and only étendue reads the file.
    #[arg(long)]
    own_words: bool,
    /// Copy meshes and pictures beside the scene instead of naming them where they are.
    #[arg(long)]
    copy: bool,
    /// Replace files that étendue did not write.
    #[arg(long)]
    force: bool,
    /// Tell what became of everything as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    common: SceneArguments,
}

fn format(text: &str) -> Result<Target, String> {
    target_named(text).ok_or_else(|| "expected mitsuba or pbrt".to_owned())
}

pub fn run(arguments: &ConvertArguments) -> Done {
    let options = ConvertOptions {
        out: arguments.output.clone(),
        target: arguments.to,
        own_words: arguments.own_words,
        copy: arguments.copy,
        force: arguments.force,
    };
    let load_options = arguments.common.options(SizeArguments::default());
    let converted = match convert(&arguments.input, &load_options, &options) {
        Ok(converted) => converted,
        Err(ConvertError::Load(why)) => return Err(output::load_error(&why)),
        Err(ConvertError::Usage(words)) => {
            output::error(&words);
            return Ok(ExitCode::from(2));
        }
        Err(why) => return Err(why.to_string()),
    };
    output::diagnostics(&converted.loaded.diagnostics, &converted.loaded.description);
    if arguments.json {
        let text = serde_json::to_string_pretty(&as_json(&converted)).map_err(|e| e.to_string())?;
        output::result(&text);
    } else {
        report(&converted);
    }
    let beside = match converted.files.len() - 1 {
        0 => String::new(),
        1 => " and one file beside it".to_owned(),
        n => format!(" and {n} files beside it"),
    };
    output::message(&format!("wrote {}{beside}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

const FATES: [Fate; 3] = [Fate::Kept, Fate::Approximated, Fate::Dropped];

/// A line for each sort of thing.
fn report(converted: &Converted) {
    for fate in FATES {
        let mut head = fate.name();
        let notes: Vec<&Note> = converted.notes.by_fate(fate).collect();
        if fate == Fate::Kept {
            let words: Vec<String> = notes.iter().map(|n| format!("{} {}", n.count, n.what)).collect();
            output::result(&format!("{head:<14}{}", words.join(", ")));
            continue;
        }
        for note in notes {
            let count = if note.count > 1 { format!("{} ", note.count) } else { String::new() };
            output::result(&format!("{head:<14}{count}{}: {} ({})", note.what, note.how, places(note)));
            head = "";
        }
    }
}

/// The first few places of a note.
fn places(note: &Note) -> String {
    const TOLD: usize = 4;
    let mut words = note.places.iter().take(TOLD).cloned().collect::<Vec<_>>().join(", ");
    if note.places.len() > TOLD {
        words += &format!(" and {} more", note.places.len() - TOLD);
    }
    words
}

fn as_json(converted: &Converted) -> serde_json::Value {
    let of = |fate: Fate| -> Vec<serde_json::Value> {
        let notes = converted.notes.by_fate(fate);
        notes.map(|n| json!({ "what": n.what, "how": n.how, "count": n.count, "places": n.places })).collect()
    };
    let format = if converted.target == Target::Pbrt { "pbrt" } else { "mitsuba" };
    json!({
        "format": format,
        "files": converted.files,
        "kept": of(Fate::Kept),
        "approximated": of(Fate::Approximated),
        "dropped": of(Fate::Dropped),
    })
}
