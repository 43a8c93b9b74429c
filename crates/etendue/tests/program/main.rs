//! The program from outside, as users and scripts meet it: what it writes, what it says, and with which exit status it ends.
//!
//! Each test runs the built binary in a folder of its own. Pictures are tiny; nothing here measures time.

mod bad_files;
mod commands;
mod convert;
mod form_factors;
mod per_light;
mod pictures;
mod radiosity;
mod same_bits;
mod stopping;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// A folder of its own for a test, and the program run in it.
struct Bench(tempfile::TempDir);

/// How the program ended and what it said.
struct Said {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder for temporary files"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).expect("the test's file is written");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
        command.args(arguments).current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    fn run(&self, arguments: &[&str]) -> Said {
        Said::of(self.command(arguments).output().expect("the program starts"))
    }

    /// Runs, and expects success.
    fn good(&self, arguments: &[&str]) -> Said {
        let said = self.run(arguments);
        assert_eq!(said.code, Some(0), "{arguments:?}\n{}", said.err);
        said
    }

    /// Runs, and expects exit status `code` and words of an error; nothing may panic.
    fn bad(&self, code: i32, arguments: &[&str]) -> Said {
        let said = self.run(arguments);
        assert_eq!(said.code, Some(code), "{arguments:?}\n{}", said.err);
        assert!(said.err.contains("error"), "{arguments:?}\n{}", said.err);
        assert!(!said.err.contains("mistake of its own"), "{arguments:?}\n{}", said.err);
        said
    }

    fn picture(&self, name: &str) -> etendue_image::Picture {
        etendue_image::load_picture(&self.path(name)).unwrap_or_else(|e| panic!("{e}"))
    }

    /// The bits of the picture's numbers, layers left out.
    fn bits(&self, name: &str) -> Vec<u32> {
        self.picture(name).image.data().iter().map(|x| x.to_bits()).collect()
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files.
    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder is there");
        let mut names: Vec<_> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Said {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program speaks UTF-8");
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Expects each of `words` in the messages.
    #[track_caller]
    fn says(&self, words: &[&str]) -> &Self {
        for word in words {
            assert!(self.err.contains(word), "expected `{word}` in:\n{}", self.err);
        }
        self
    }
}

/// The repository's folder of scenes.
fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}
