//! Who may import whom: the arrows of ARCHITECTURE.md, checked against `cargo metadata`.

#![allow(clippy::expect_used, reason = "helpers of tests")]

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, MetadataCommand, Package};

/// Crates of the workspace that each crate may depend on (development dependencies apart).
const ROOMS: [(&str, &[&str]); 12] = [
    ("gt-core", &[]),
    ("gt-plant", &["gt-core"]),
    ("gt-ident", &["gt-core"]),
    ("gt-fdi", &["gt-core"]),
    ("gtfdi", &["gt-core", "gt-plant", "gt-ident", "gt-fdi"]),
    ("gt-mcap", &[]),
    ("gt-log", &["gtfdi", "gt-core", "gt-mcap"]),
    ("gt-campaign", &["gtfdi", "gt-log"]),
    ("gt-serve", &["gtfdi", "gt-log"]),
    ("gt-cli", &["gtfdi", "gt-log", "gt-campaign", "gt-serve"]),
    ("gt-py", &["gtfdi", "gt-log", "gt-campaign"]),
    ("xtask", &[]),
];

/// Outside crates that only some rooms may name.
const GUARDED: [(&str, &[&str]); 28] = [
    ("faer", &["gt-core", "gt-ident", "gt-fdi"]),
    ("clarabel", &["gt-core"]),
    ("pulp", &["gt-fdi", "gt-ident", "gt-plant"]),
    ("libm", &["gt-fdi"]),
    ("tokio", &["gt-serve"]),
    ("axum", &["gt-serve"]),
    ("hyper-util", &["gt-serve"]),
    ("rumqttc", &["gt-serve"]),
    ("rustls", &["gt-serve"]),
    ("tracing", &["gt-serve"]),
    ("mcap", &["gt-log", "gt-mcap"]),
    ("zstd", &["gt-log"]),
    ("lz4", &["gt-log"]),
    ("crc32fast", &["gt-log"]),
    ("prost", &["gt-log", "gt-mcap"]),
    ("prost-types", &["gt-log"]),
    ("csv", &["gt-log"]),
    ("parquet", &["gt-log", "gt-campaign"]),
    ("rayon", &["gt-campaign"]),
    ("pyo3", &["gt-py"]),
    ("numpy", &["gt-py"]),
    ("clap", &["gt-cli"]),
    ("clap_complete", &["gt-cli"]),
    ("clap_mangen", &["gt-cli"]),
    ("indicatif", &["gt-cli"]),
    ("ctrlc", &["gt-cli"]),
    ("anyhow", &["gt-cli"]),
    (
        "schemars",
        &["gt-plant", "gt-log", "gt-campaign", "gt-serve", "gt-cli"],
    ),
];

/// What the runtime of gt-fdi, which is all of it without its feature `design`, depends on. That
/// none of it brings std is for the linker to say: `cargo xtask test-no-std`.
const RUNTIME: [&str; 3] = ["libm", "serde", "thiserror"];

/// The packages of the workspace.
fn packages() -> Vec<Package> {
    MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata runs")
        .packages
}

/// Dependencies of every workspace crate that end up in what it builds, with all its features.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    packages()
        .iter()
        .map(|package| {
            let names = package
                .dependencies
                .iter()
                .filter(|dependency| dependency.kind != DependencyKind::Development)
                .map(|dependency| dependency.name.clone())
                .collect();
            (package.name.to_string(), names)
        })
        .collect()
}

#[test]
fn crates_import_only_what_the_architecture_allows() {
    let found = dependencies();
    let known: BTreeSet<&str> = ROOMS.iter().map(|(name, _)| *name).collect();
    let there: BTreeSet<&str> = found.keys().map(String::as_str).collect();
    assert_eq!(
        there, known,
        "a crate is new or gone: say in ROOMS what it may import"
    );
    for (name, allowed) in ROOMS {
        let inside: BTreeSet<&str> = found[name]
            .iter()
            .map(String::as_str)
            .filter(|name| known.contains(name))
            .collect();
        let forbidden: Vec<&&str> = inside
            .iter()
            .filter(|name| !allowed.contains(name))
            .collect();
        assert!(
            forbidden.is_empty(),
            "{name} imports {forbidden:?}, allowed are {allowed:?}"
        );
    }
}

/// The design half and what it needs are switched off with one feature, and what is left is small
/// and does without the default features that mean std.
#[test]
fn the_runtime_of_gt_fdi_stands_on_three_crates() {
    let packages = packages();
    let package = packages
        .iter()
        .find(|package| package.name.as_str() == "gt-fdi")
        .expect("gt-fdi is a package of the workspace");
    assert_eq!(package.features["default"], ["design"]);
    let (optional, always): (Vec<_>, Vec<_>) = package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind == DependencyKind::Normal)
        .partition(|dependency| dependency.optional);
    let found: BTreeSet<&str> = always.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(found, BTreeSet::from(RUNTIME));
    for dependency in always {
        assert!(
            !dependency.uses_default_features,
            "{} with its default features",
            dependency.name
        );
        assert!(!dependency.features.contains(&"std".to_owned()));
    }
    for dependency in optional {
        let switch = format!("dep:{}", dependency.name);
        assert!(
            package.features["design"].contains(&switch),
            "{switch} is not switched on by `design`"
        );
    }
}

#[test]
fn guarded_libraries_stay_in_their_rooms() {
    for (name, imports) in dependencies() {
        for (library, rooms) in GUARDED {
            assert!(
                !imports.contains(library) || rooms.contains(&name.as_str()),
                "{name} imports {library}, which belongs to {rooms:?}"
            );
        }
    }
}
