//! Development tasks, run as `cargo xtask <task>`.

mod fuzz;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const HELP: &str = "\
cargo xtask <task>

  test          all tests: Rust, without std, then the Python package in an environment of its own
  test-rust     the Rust tests alone
  test-no-std   build and run a program without std around gt-fdi's runtime (on Linux)
  test-python   build the wheel, install it, run the Python tests
  test-node     read logs of the binary with @mcap/core; needs node, npm and the network, and is no
                part of `test`
  fuzz [SECONDS] [TARGET ...]
                bytes of any kind for every parser, 600 s each; needs a C++ compiler and the network,
                and is no part of `test`

GTFDI_REFERENCE_DATA names the folder of public records that some tests read (absolute path);
unset, those tests skip by name.";

fn main() -> ExitCode {
    let task = env::args().nth(1);
    let outcome = match task.as_deref() {
        Some("test") => test_rust()
            .and_then(|()| test_no_std())
            .and_then(|()| test_python()),
        Some("test-rust") => test_rust(),
        Some("test-no-std") => test_no_std(),
        Some("test-python") => test_python(),
        Some("test-node") => test_node(),
        Some("fuzz") => fuzz::fuzz(&env::args().skip(2).collect::<Vec<_>>()),
        Some("help" | "--help" | "-h") => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Some(other) => Err(format!("unknown task `{other}`\n\n{HELP}")),
        None => Err(HELP.to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's root, one above this package.
fn root() -> Result<PathBuf, String> {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .map(Path::to_owned)
        .ok_or_else(|| "the xtask package has no parent folder".to_owned())
}

fn test_rust() -> Result<(), String> {
    check_reference_data()?;
    run(cargo()
        .args(["test", "--workspace", "--locked"])
        .current_dir(root()?))
}

/// Runs the program that has its own panic handler, so that it does not link if gt-fdi's runtime or
/// a crate that it needs brings std. It reads its own lock file, whose versions are the workspace's.
fn test_no_std() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        println!("skipped: the program without std starts under Linux's C library only");
        return Ok(());
    }
    let root = root()?;
    let manifest = root.join("crates/gt-fdi/no_std_host/Cargo.toml");
    run(cargo()
        .args(["run", "--locked", "--quiet", "--manifest-path"])
        .arg(manifest)
        .arg("--target-dir")
        .arg(root.join("target").join("no-std-host")))
}

/// The cargo that runs this task.
fn cargo() -> Command {
    Command::new(env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()))
}

/// Builds the package as a user would (`pip install .`) into `target/python-env` and runs pytest.
fn test_python() -> Result<(), String> {
    check_reference_data()?;
    let root = root()?;
    let environment = root.join("target").join("python-env");
    let python = environment.join(if cfg!(windows) {
        "Scripts/python.exe"
    } else {
        "bin/python"
    });
    if !python.exists() {
        let system = env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
        run(Command::new(system).args(["-m", "venv"]).arg(&environment)).map_err(|error| {
            format!("{error}\nPython needs its venv module (on Debian: the package python3-venv)")
        })?;
    }
    let pip = |arguments: &[&str]| {
        run(Command::new(&python)
            .args([
                "-m",
                "pip",
                "install",
                "--quiet",
                "--disable-pip-version-check",
            ])
            .args(arguments)
            .current_dir(&root))
    };
    pip(&[".[test]"])?;
    // Large, and not there for every Python: what they are needed for is skipped without them.
    if pip(&["--only-binary", ":all:", "pyarrow", "duckdb"]).is_err() {
        println!("no pyarrow and duckdb: Parquet is not compared with what they read and write");
    }
    for extra in ["control", "pandas", "polars", "scipy"] {
        if pip(&["--only-binary", ":all:", extra]).is_err() {
            println!("no {extra}: what is exchanged with it is not tested");
        }
    }
    if pip(&["--only-binary", ":all:", "nbclient", "ipykernel"]).is_err() {
        println!("no nbclient and ipykernel: the notebooks' cells are run without Jupyter");
    }
    // Away from the sources, so that the installed package is what the tests import.
    let mut tests = Command::new(&python);
    if let Some(binary) = binary(&root) {
        tests.env("GTFDI_BINARY", binary);
    }
    let examples = target(&root).join("debug").join("examples");
    if examples
        .join(format!("rotate_log{}", env::consts::EXE_SUFFIX))
        .is_file()
    {
        tests.env("GTFDI_EXAMPLES", examples);
    }
    run(tests
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir"])
        .arg(root.join("tests/python"))
        .arg(root.join("tests/python"))
        .env("GTFDI_ROOT", &root)
        .current_dir(root.join("target")))
}

/// The folder of what cargo builds.
fn target(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}

/// Reads logs of the binary with the readers of npm, installed below `target/node-env`: one as it is
/// written, and one that was cut off and recovered.
fn test_node() -> Result<(), String> {
    for program in ["node", "npm"] {
        if Command::new(program).arg("--version").output().is_err() {
            println!("skipped: test-node needs {program}");
            return Ok(());
        }
    }
    let root = root()?;
    run(cargo()
        .args(["build", "-p", "gt-cli", "--locked"])
        .current_dir(&root))?;
    let binary = binary(&root).ok_or("expected the binary gtfdi, found none")?;
    let place = target(&root).join("node-env");
    let said = |error: std::io::Error| format!("{}: {error}", place.display());
    fs::create_dir_all(&place).map_err(said)?;
    for name in ["package.json", "read.mjs"] {
        fs::copy(root.join("tests/node").join(name), place.join(name)).map_err(said)?;
    }
    let quiet = ["install", "--silent", "--no-audit", "--no-fund"];
    run(Command::new("npm").args(quiet).current_dir(&place))?;
    let gtfdi = |arguments: &[&str]| run(Command::new(&binary).args(arguments).current_dir(&place));
    gtfdi(&[
        "simulate",
        "--seconds",
        "60",
        "--seed",
        "3",
        "--out",
        "whole.mcap",
    ])?;
    let whole = fs::read(place.join("whole.mcap")).map_err(said)?;
    let cut = &whole[..whole.len() / 2];
    fs::write(place.join("cut.mcap.part"), cut).map_err(said)?;
    gtfdi(&["log", "recover", "cut.mcap.part", "--out", "cut.mcap"])?;
    for log in ["whole.mcap", "cut.mcap"] {
        for topic in ["/plant/measured", "/plant/truth"] {
            let out = ["--topic", topic, "--time", "seconds", "--out", "table.csv"];
            gtfdi(&[&["log", "export", log], &out[..]].concat())?;
            let read = ["read.mjs", log, "table.csv", topic];
            run(Command::new("node").args(read).current_dir(&place))?;
        }
    }
    Ok(())
}

/// The binary that the Rust tests built, if they did; some Python tests read what it writes.
fn binary(root: &Path) -> Option<PathBuf> {
    let name = format!("gtfdi{}", env::consts::EXE_SUFFIX);
    let path = target(root).join("debug").join(name);
    path.canonicalize().ok().filter(|path| path.is_file())
}

/// A reference folder that is named but not there is a mistake, not a reason to skip.
fn check_reference_data() -> Result<(), String> {
    match env::var_os("GTFDI_REFERENCE_DATA") {
        Some(folder) if !Path::new(&folder).is_dir() || !Path::new(&folder).is_absolute() => {
            Err(format!(
                "GTFDI_REFERENCE_DATA: expected the absolute path of a folder, found {}",
                Path::new(&folder).display()
            ))
        }
        _ => Ok(()),
    }
}

fn run(command: &mut Command) -> Result<(), String> {
    let shown = format!("{command:?}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("failed ({status}): {shown}")),
        Err(error) => Err(format!("could not start {shown}: {error}")),
    }
}
