//! `cargo xtask fuzz`: bytes of any kind for every parser, with libFuzzer.
//!
//! No other toolchain is needed: the counters of coverage that libFuzzer steers by are a pass of LLVM
//! that the stable compiler runs when asked to. A C++ compiler builds libFuzzer itself.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{cargo, root, run, target};

/// A target.
struct Target {
    name: &'static str,
    /// The longest input in bytes.
    longest: u32,
}

const TARGETS: [Target; 9] = [
    Target {
        name: "table",
        longest: 4096,
    },
    Target {
        name: "parquet",
        longest: 16_384,
    },
    Target {
        name: "log",
        longest: 32_768,
    },
    Target {
        name: "document",
        longest: 32_768,
    },
    Target {
        name: "campaign",
        longest: 8192,
    },
    Target {
        name: "step",
        longest: 4096,
    },
    Target {
        name: "message",
        longest: 1024,
    },
    Target {
        name: "state",
        longest: 32_768,
    },
    Target {
        name: "hygiene",
        longest: 4096,
    },
];

/// Seconds a target.
const SECONDS: u32 = 600;

/// What makes LLVM count edges, and the crates open the doors that are for fuzzing alone.
const FLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                     -Cllvm-args=-sanitizer-coverage-pc-table \
                     -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1";

/// `fuzz [SECONDS] [TARGET ...]`: each target for so long, one after the other; what is found is kept
/// below `target/fuzz/found`.
pub fn fuzz(arguments: &[String]) -> Result<(), String> {
    let (seconds, names) = match arguments.split_first() {
        Some((first, rest)) if first.parse::<u32>().is_ok() => {
            (first.parse().unwrap_or(SECONDS), rest)
        }
        _ => (SECONDS, arguments),
    };
    let known: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
    if let Some(wrong) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(format!(
            "expected one of {}, found `{wrong}`",
            known.join(", ")
        ));
    }
    let root = root()?;
    let place = target(&root).join("fuzz");
    let programs = build(&root, &place)?;
    for target in &TARGETS {
        if !names.is_empty() && !names.iter().any(|name| name == target.name) {
            continue;
        }
        let found = place.join("found").join(target.name);
        let corpus = place.join("corpus").join(target.name);
        for folder in [&found, &corpus] {
            fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
        println!("== {} for {seconds} s", target.name);
        run(Command::new(programs.join(target.name))
            .arg(&corpus)
            .arg(root.join("fuzz/seeds").join(target.name))
            .arg(format!("-artifact_prefix={}/", found.display()))
            .arg(format!("-max_total_time={seconds}"))
            .arg(format!("-max_len={}", target.longest))
            // What takes longer is a hang.
            .args(["-timeout=10", "-rss_limit_mb=2048", "-print_final_stats=1"])
            .current_dir(&place))?;
    }
    Ok(())
}

/// Builds the targets, with the versions of its own lock file as far as they fit the workspace; the
/// folder of the programs.
fn build(root: &Path, place: &Path) -> Result<PathBuf, String> {
    let host = host()?;
    // With a target named, build scripts and macros are built without the counters.
    run(cargo()
        .args(["build", "--release", "--target", &host])
        .arg("--manifest-path")
        .arg(root.join("fuzz/Cargo.toml"))
        .arg("--target-dir")
        .arg(place.join("build"))
        .env("RUSTFLAGS", FLAGS))?;
    Ok(place.join("build").join(host).join("release"))
}

fn host() -> Result<String, String> {
    let compiler = env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let said = Command::new(compiler).arg("-vV").output();
    let said = said.map_err(|error| format!("could not start rustc: {error}"))?;
    let text = String::from_utf8_lossy(&said.stdout);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned)
        .ok_or_else(|| "rustc -vV: expected a line `host:`, found none".to_owned())
}
