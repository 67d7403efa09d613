use super::*;

/// A manifest, or a file of a test, would be refused as a procedure by whoever lists what is shipped.
#[test]
fn the_files_of_a_folder_come_before_those_of_its_subfolders_and_no_manifest_is_among_them() {
    let paths: Vec<&str> = all(Folder::Procedures).map(|e| e.path).collect();
    let of_folder = paths.iter().take_while(|path| !path.contains('/')).count();
    let (campaigns, procedures) = paths.split_at(of_folder);
    assert!(campaigns.is_sorted() && procedures.is_sorted(), "{paths:?}");
    assert!(procedures.iter().all(|path| path.contains('/')), "{paths:?}");
    for expected in ["fat.toml", "requirements.toml", "quick/az-friction.toml", "smoke/requirements.toml"] {
        assert!(paths.contains(&expected), "{expected} is not among {paths:?}");
    }
    assert!(!paths.contains(&"Cargo.toml"));
    assert!(!paths.iter().any(|path| path.starts_with("src/") || path.starts_with("analysis/")));
}

#[test]
fn build_states_are_no_units() {
    assert!(all(Folder::Units).any(|e| e.path == "defects/azimuth-retainer.toml"));
    assert!(all(Folder::States).any(|e| e.path == "azimuth-table.toml"));
    assert!(!all(Folder::Units).any(|e| e.path.starts_with("states/")));
}
