//! A folder of its own in which the binary runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A folder that is removed at the end.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        let folder = TempDir::new().expect("a folder");
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect(name);
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    /// The binary in this folder, with nothing of this process's own configuration.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = self.program(env!("CARGO_BIN_EXE_gtfdi"));
        command.args(args);
        command
    }

    /// Any program in this folder, likewise.
    pub fn program(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        for (name, _) in std::env::vars_os() {
            if name.to_string_lossy().starts_with("GTFDI_") {
                command.env_remove(name);
            }
        }
        command.current_dir(self.folder.path());
        command
    }

    pub fn run(&self, args: &[&str]) -> Ran {
        Ran::of(&mut self.command(args))
    }

    /// Runs what has to end with 0 and gives its standard output.
    pub fn done(&self, args: &[&str]) -> String {
        let ran = self.run(args);
        assert_eq!(ran.code, 0, "{args:?}: {}", ran.stderr);
        ran.stdout
    }

    /// Runs what has to end with 0 and print one JSON object on one line.
    pub fn json(&self, args: &[&str]) -> Value {
        object(&self.done(&[args, &["--json"]].concat()))
    }

    /// The report of a verb whose warnings speak of samples that are NaN.
    pub fn json_of_missing(&self, args: &[&str]) -> Value {
        let text = self.done(&[args, &["--json"]].concat());
        serde_json::from_str(&text).expect("one JSON object")
    }

    /// Runs what has to be refused: exit code 2, every one of `texts` on standard error, nothing
    /// on standard output, no panic, and no file made, changed or left over.
    pub fn refused(&self, args: &[&str], texts: &[&str]) {
        self.ends_badly(2, &mut self.command(args), texts);
    }

    /// As [`Place::refused`], with the whole text. `FIRST|LAST` are its first line and how its last
    /// begins, between which stands an excerpt of a file with the place of the mistake.
    pub fn refused_exactly(&self, args: &[&str], text: &str) {
        self.refused(args, &[]);
        let found = self.run(args).stderr;
        let whole = format!("gtfdi: {text}");
        let agrees = match whole.split_once('|') {
            Some((first, last)) => {
                found.starts_with(&format!("{first}\n"))
                    && found.contains("^\n")
                    && found.contains(&format!("\n{last}"))
            }
            None => found == format!("{whole}\n"),
        };
        assert!(agrees, "{args:?}: expected `{text}`, found\n{found}");
    }

    /// As [`Place::refused`], with another exit code or environment.
    pub fn ends_badly(&self, code: i32, command: &mut Command, texts: &[&str]) {
        let before = contents(self.folder.path());
        let ran = Ran::of(command);
        assert_eq!(ran.code, code, "{command:?}: {}", ran.stderr);
        assert_eq!(ran.stdout, "", "{command:?}: standard output");
        assert!(
            !ran.stderr.contains("panicked"),
            "{command:?}: {}",
            ran.stderr
        );
        for text in texts {
            assert!(
                ran.stderr.contains(text),
                "{command:?}: expected `{text}` in\n{}",
                ran.stderr
            );
        }
        let after = contents(self.folder.path());
        assert!(before == after, "{command:?}: files changed");
    }
}

/// How a run ended.
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Ran {
    pub fn of(command: &mut Command) -> Self {
        let Output {
            status,
            stdout,
            stderr,
        } = command.output().expect("the binary starts");
        Self {
            code: status.code().expect("no signal"),
            stdout: String::from_utf8(stdout).expect("text"),
            stderr: String::from_utf8(stderr).expect("text"),
        }
    }
}

/// The one JSON object of a standard output.
pub fn object(stdout: &str) -> Value {
    let line = stdout.strip_suffix('\n').expect("a line");
    assert!(!line.contains('\n'), "one line, found {line}");
    assert!(!line.contains("NaN"), "no NaN, found {line}");
    let value: Value = serde_json::from_str(line).expect("JSON");
    assert_eq!(value["schema_version"], 1, "{line}");
    value
}

/// Names and bytes of everything in a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            let bytes = fs::read(&path).expect("a file");
            found.push((path, bytes));
        }
    }
    found.sort();
    found
}

/// The folder of the public records, or `None` after saying by name what is skipped.
pub fn reference_data(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: {test} needs GTFDI_REFERENCE_DATA");
    }
    folder
}

/// A number at a JSON pointer.
pub fn number(value: &Value, pointer: &str) -> f64 {
    let found = value.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {pointer} in {value}"))
}

/// An array at a JSON pointer.
pub fn array<'a>(value: &'a Value, pointer: &str) -> &'a [Value] {
    let found = value.pointer(pointer).and_then(Value::as_array);
    found.unwrap_or_else(|| panic!("no array at {pointer} in {value}"))
}
