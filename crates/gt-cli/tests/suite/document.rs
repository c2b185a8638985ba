//! Documents whose blocks are run as they are printed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::place::{Place, Ran, object};

/// A Markdown file of the repository.
pub struct Document {
    text: String,
}

impl Document {
    /// Reads the file at a path from the repository's root.
    pub fn read(path: &str) -> Self {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let text = fs::read_to_string(root.join(path)).expect(path);
        Self { text }
    }

    /// The fenced blocks of a language, in their order.
    pub fn blocks(&self, language: &str) -> Vec<&str> {
        let mut blocks = Vec::new();
        let fenced = self.text.split("\n```").skip(1).step_by(2);
        for block in fenced {
            let (head, body) = block.split_once('\n').expect("a block");
            if head == language {
                blocks.push(body);
            }
        }
        blocks
    }

    /// The one block of a language that has a part.
    pub fn block_with(&self, language: &str, part: &str) -> &str {
        let mut blocks = self.blocks(language).into_iter();
        let block = blocks.find(|block| block.contains(part));
        block.unwrap_or_else(|| panic!("no block of {language} with `{part}`"))
    }

    /// The blocks that begin with their file's name in a comment: name and text.
    pub fn files(&self, language: &str) -> Vec<(&str, &str)> {
        let blocks = self.blocks(language).into_iter();
        let named = blocks.filter_map(|block| block.strip_prefix("# ")?.split_once('\n'));
        named.filter(|(name, _)| !name.contains(' ')).collect()
    }

    /// The cells of all rows of the table whose first column has a title.
    pub fn table(&self, title: &str) -> Vec<Vec<&str>> {
        let head = format!("| {title} |");
        let lines = self
            .text
            .lines()
            .skip_while(|line| !line.starts_with(&head));
        let rows = lines.take_while(|line| line.starts_with('|')).skip(2);
        let rows: Vec<Vec<&str>> = rows.map(cells).collect();
        assert!(!rows.is_empty(), "no table of `{title}`");
        rows
    }

    /// Runs all commands of all shell blocks in a place, one after the other.
    pub fn run_in(&self, place: &Place) -> Vec<Step> {
        let blocks = self.blocks("sh").into_iter();
        let commands = blocks.flat_map(commands);
        commands.map(|command| Step::run(place, command)).collect()
    }
}

fn cells(row: &str) -> Vec<&str> {
    let inner = row.trim().trim_start_matches('|').trim_end_matches('|');
    inner.split('|').map(str::trim).collect()
}

/// The commands of a block: lines, with those that a backslash continues and those of a text that
/// a command is given (`<<'EOF'`); comments are none.
pub fn commands(block: &str) -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let mut lines = block.lines();
    while let Some(line) = lines.next() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let mut command = line.to_owned();
        while let Some(head) = command.strip_suffix('\\') {
            let next = lines.next().expect("a line that is continued");
            command = format!("{head}{}", next.trim_start());
        }
        if command.ends_with("<<'EOF'") {
            for line in lines.by_ref() {
                command = format!("{command}\n{line}");
                if line == "EOF" {
                    break;
                }
            }
        }
        commands.push(command);
    }
    commands
}

/// A command that ran.
pub struct Step {
    pub command: String,
    pub stdout: String,
}

impl Step {
    /// Runs a command with a shell, the binary being the first on the path.
    pub fn run(place: &Place, command: String) -> Self {
        let binary = PathBuf::from(env!("CARGO_BIN_EXE_gtfdi"));
        let mut folders = vec![binary.parent().expect("a folder").to_owned()];
        let path = std::env::var_os("PATH").unwrap_or_default();
        folders.extend(std::env::split_paths(&path));
        let mut shell: Command = place.program("sh");
        shell.args(["-e", "-c", &command]);
        shell.env("PATH", std::env::join_paths(folders).expect("a path"));
        shell.env("GTFDI_JSON", "true");
        let ran = Ran::of(&mut shell);
        assert_eq!(ran.code, 0, "{command}: {}", ran.stderr);
        let stdout = ran.stdout;
        Self { command, stdout }
    }

    /// What the binary reported.
    pub fn report(&self) -> Value {
        object(&self.stdout)
    }
}

/// Whether the first number that is printed in a cell is a value, to the digits that are printed.
pub fn is_printed(cell: &str, value: f64) -> bool {
    let digits = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let from = cell.find(|c: char| c.is_ascii_digit()).expect(cell);
    let from = from - usize::from(cell[..from].ends_with('-'));
    let number: String = cell[from..].chars().take_while(|&c| digits(c)).collect();
    let number = number.trim_end_matches('.');
    let decimals = number.split_once('.').map_or(0, |(_, tail)| tail.len());
    let printed: f64 = number.parse().expect(cell);
    let half = 0.5 * 0.1_f64.powi(i32::try_from(decimals).expect("few digits"));
    // Rounding to even or away from zero are both right.
    (printed - value).abs() <= half * (1.0 + 1e-9)
}

#[test]
fn blocks_commands_and_tables_are_found() {
    let text = "Text.\n\n```sh\n# first\na \\\n    b\n\ncat > f <<'EOF'\nx \\\nEOF\nc\n```\n\n\
                ```toml\n# f.toml\nk = 1\n```\n\n| t | u |\n|---|---|\n| x | 1.5 % |\n| y | |\n\nEnd.\n";
    let document = Document {
        text: text.to_owned(),
    };
    let found = commands(document.block_with("sh", "cat"));
    assert_eq!(found, ["a b", "cat > f <<'EOF'\nx \\\nEOF", "c"]);
    assert_eq!(document.files("toml"), [("f.toml", "k = 1")]);
    assert_eq!(document.table("t"), [["x", "1.5 %"], ["y", ""]]);
    assert!(is_printed("1.5 %", 1.549) && !is_printed("1.5 %", 1.56));
    assert!(is_printed("row 162", 162.0) && !is_printed("row 162", 163.0));
    assert!(is_printed("-3", -3.4) && !is_printed("-3", 3.0));
}
