use super::*;

/// The small version of `cargo run --release -p validation -- polarity`.
#[test]
fn a_few_seeds_of_every_fault_are_caught_and_sound_units_are_let_through() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let all = rows();
    let half = all.len().div_ceil(2);
    let wrong = |rows: &[Row], folder: &std::path::Path| -> Vec<String> {
        std::fs::create_dir_all(folder).expect("a folder of ours");
        let told = rows.iter().map(|row| {
            let mut found = Found::default();
            let seeds = (row.seeds / 100).max(1);
            for k in 0..seeds {
                // Poses of the whole band over all rows, not the same for all of them.
                let seed = 7 * row.name.len() as u64 + k;
                found.take(row, seed, &run(&row.unit, pose_deg(seed), seed, folder));
            }
            (found.holds(row, seeds), found.line(row, seeds))
        });
        told.filter(|(holds, _)| !holds).map(|(_, line)| line).collect()
    };
    let found = std::thread::scope(|scope| {
        let other = scope.spawn(|| wrong(&all[half..], &folder.path().join("second")));
        let mut found = wrong(&all[..half], &folder.path().join("first"));
        found.extend(other.join().expect("no panic"));
        found
    });
    assert_eq!(found, Vec::<String>::new());
}
