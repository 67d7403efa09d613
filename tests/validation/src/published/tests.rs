use super::*;
use crate::shipped::{director, gains};

/// Rows that do not hold, as text.
fn failing(rows: &[Row]) -> String {
    let failing: Vec<Row> = rows.iter().filter(|row| !row.holds()).cloned().collect();
    if failing.is_empty() { String::new() } else { table(&failing) }
}

/// Tables 4.4 and 4.5, prediction on, at all elevations: three figures for elevation, two for azimuth (E21).
#[test]
fn the_coarse_track_loop_of_the_measured_unit_shows_the_published_figures() {
    let rows = track_rows(&director("as-measured"), &gains());
    assert_eq!(rows.len(), 11 * (3 + 2));
    assert_eq!(failing(&rows), "");
    for row in &rows {
        let tolerance = if row.quantity == "bandwidth Hz" { 0.005 } else { 0.15 };
        assert!((row.simulated - row.model).abs() < tolerance, "{}", table(std::slice::from_ref(row)));
    }
}

/// Tables 4.1 to 4.5 of the study at every elevation, from the linear model and from the simulated plant.
#[test]
fn as_measured_reproduces_the_published_tables() {
    let rows = rows(&director("as-measured"), &gains());
    assert_eq!(failing(&rows), "");
    insta::assert_snapshot!(table(&rows));
}
