//! What the crate, and its runtime half, may import.

use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn the_crate_imports_neither_identification_nor_the_plant() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
        .expect("the manifest");
    assert!(
        manifest.contains("gt-core"),
        "the manifest that was read is not this crate's"
    );
    for sibling in ["gt-ident", "gt-plant"] {
        assert!(!manifest.contains(sibling), "{sibling} in Cargo.toml");
    }
}

/// `runtime` is written for `no_std` with `alloc`: it names neither std, nor nalgebra, nor the
/// design half, and calls no function of a float that only std has.
#[test]
fn the_runtime_uses_core_and_alloc_only() {
    let files = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/runtime"));
    for path in &files {
        let text = fs::read_to_string(path).expect("a source file");
        // Links in the documentation may lead to the design half.
        let code: String = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .collect();
        for forbidden in [
            "std::",
            "nalgebra",
            "gt_core",
            "crate::design",
            "println",
            "Instant",
            ".sqrt(",
            ".exp(",
            ".ln(",
            ".powi(",
            ".mul_add(",
        ] {
            assert!(
                !code.contains(forbidden),
                "{forbidden} in {}",
                path.display()
            );
        }
    }
    assert_eq!(files.len(), 58);
}

/// All source files below `folder`.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else {
            files.push(path);
        }
    }
    files
}
