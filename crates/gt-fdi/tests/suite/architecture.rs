//! What the crate, and its runtime half, may import.

use std::fs;
use std::path::Path;

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
/// design half.
#[test]
fn the_runtime_uses_core_and_alloc_only() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/runtime");
    let mut files = 0;
    for entry in fs::read_dir(folder).expect("src/runtime") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("a source file");
        for forbidden in [
            "std::",
            "nalgebra",
            "gt_core",
            "crate::design",
            "println",
            "Instant",
        ] {
            assert!(
                !text.contains(forbidden),
                "{forbidden} in {}",
                path.display()
            );
        }
        files += 1;
    }
    assert_eq!(files, 4);
}
