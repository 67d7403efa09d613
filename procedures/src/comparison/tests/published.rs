use crate::comparison::*;
use crate::diagnostic::SourceFile;
use crate::measurement::Estimate;
use crate::quantity::QuantityKind as Q;

const TABLE: &str = "schema = 1\nid = \"t\"\ntitle = \"T\"\nsource = \"study, table 4.2\"\n\
    [[value]]\nmeasurand = \"velocity-phase-margin\"\naxis = \"az\"\nwhere = { elevation = \"40 deg\" }\n\
    value = \"46.7 deg\"\nu = \"0.03 deg\"\n";

fn parsed(text: &str) -> Result<PublishedTable, String> {
    let source = SourceFile { name: "published.toml".to_owned(), text: text.to_owned() };
    PublishedTable::parse(&source)
        .map_err(|found| found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// A phase margin at an elevation, both in degrees.
fn margin(elevation_deg: f64, value_deg: f64) -> Measurement {
    let estimate = Estimate { value: value_deg.to_radians(), u: 0.2_f64.to_radians(), dof: 20.0, n: 9 };
    let requested = elevation_deg.to_radians();
    let condition = Condition { name: "elevation".to_owned(), requested, achieved: None, kind: Q::Angle };
    Measurement {
        conditions: vec![condition],
        ..Measurement::new("velocity-phase-margin", "az", Q::Angle, Some(estimate), "test/1")
    }
}

fn call(measurements: &[Measurement]) -> Vec<Call> {
    let run = [Found { procedure: "AZ-LOOP", measurements, plots: &[] }];
    let table = parsed(TABLE).expect("the table is right");
    compare_with_published(&run, &table, None).values.iter().map(|pair| pair.call).collect()
}

#[test]
fn a_published_value_is_compared_with_what_was_measured_under_its_conditions() {
    assert_eq!(call(&[margin(40.0, 46.9), margin(50.0, 60.0)]), [Call::Same]);
    assert_eq!(call(&[margin(40.0, 48.9)]), [Call::Differs]);
    assert_eq!(call(&[margin(50.0, 46.7)]), [Call::OnlyInB], "at another elevation");
}

#[test]
fn mistakes_in_a_table_come_at_once_and_say_what_was_expected() {
    let wrong = TABLE
        .replace("46.7 deg", "46.7 Hz")
        .replace("elevation =", "elevaton =")
        .replace("schema = 1\n", "schema = 1\nsorce = \"x\"\n");
    let told = parsed(&wrong).expect_err("three mistakes");
    for part in ["`value`", "elevaton", "sorce"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let unknown = parsed(&TABLE.replace("velocity-phase-margin", "velocity-phase-margn"));
    assert!(unknown.expect_err("unknown").contains("did you mean `velocity-phase-margin`?"));
    assert!(parsed(&TABLE.replace("0.03 deg", "-0.03 deg")).is_err(), "a negative uncertainty");
}
