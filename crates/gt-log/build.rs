//! Puts the short hash of the commit and the compiler's version into the binary. Without git, or
//! where this crate is not tracked by the repository around it, the hash is `unknown`.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!(
        "cargo::rustc-env=GT_LOG_GIT={}",
        commit().unwrap_or_else(unknown)
    );
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = first_line(Command::new(rustc).arg("--version")).unwrap_or_else(unknown);
    println!("cargo::rustc-env=GT_LOG_RUSTC={version}");
}

fn unknown() -> String {
    "unknown".to_owned()
}

fn commit() -> Option<String> {
    // A vendored copy lies in someone else's repository: that hash would say nothing.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    for name in ["HEAD", "refs/heads", "packed-refs"] {
        // Cargo reruns for ever on a path that does not exist.
        if let Some(path) = git(&["rev-parse", "--git-path", name])
            && Path::new(&path).exists()
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    first_line(Command::new("git").args(arguments))
}

fn first_line(command: &mut Command) -> Option<String> {
    let output = command
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(str::to_owned)
}
