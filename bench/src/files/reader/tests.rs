use super::*;
use crate::files::rig::tests::told;

fn shipped_text(name: &str) -> String {
    shipped::find(Folder::Readers, name, None).expect("a shipped profile").text
}

/// What is said of a shipped profile after these replacements, each of the first place where the text stands.
fn said(name: &str, edits: &[(&str, &str)]) -> String {
    let mut text = shipped_text(name);
    for (old, new) in edits {
        assert!(text.contains(old), "the profile no longer says {old}");
        text = text.replacen(old, new, 1);
    }
    told(&read_reader(&SourceFile::new("reader.toml", text)).err().unwrap_or_default())
}

#[test]
fn every_shipped_profile_is_read_and_is_called_as_its_file() {
    let names: Vec<&str> = shipped::all(Folder::Readers).map(|file| file.stem()).collect();
    assert_eq!(names, ["ascii-force-gauge", "scpi-autocollimator"]);
    for name in names {
        let profile = load(name, None).unwrap_or_else(|mistakes| panic!("{}", told(&mistakes)));
        assert_eq!(profile.id, name);
    }
}

#[test]
fn numbers_of_the_shipped_profiles_are_si() {
    let angles = load("scpi-autocollimator", None).expect("a shipped profile");
    let azimuth = angles.scale(Measured::Azimuth).expect("an angle");
    assert!((azimuth.scale_si - 1.0_f64.to_radians() / 3600.0).abs() < 1e-15, "{azimuth:?}");
    assert!((azimuth.quantum_si() - 0.01 * azimuth.scale_si).abs() < 1e-18);
    let gauge = load("ascii-force-gauge", None).expect("a shipped profile");
    let force = gauge.scale(Measured::Force).expect("a force");
    assert_eq!((force.scale_si, force.range_si, gauge.query.as_deref()), (1.0, [-2000.0, 2000.0], None));
    assert!((gauge.stale_s() - 0.22).abs() < 1e-12);
}

#[test]
fn what_a_profile_cannot_be_is_pointed_at_all_at_once() {
    insta::assert_snapshot!(said(
        "scpi-autocollimator",
        &[
            ("query = \"MEAS:ANGL?\"\n", ""),
            ("period = \"10 ms\"", "period = \"10 us\""),
            ("{azimuth},{elevation}", "{azimuth}{elevation}"),
            ("scale = \"1 arcsec\"", "scale = \"0 arcsec\""),
            ("uncertainty = \"0.7 urad\"", "uncertainty = \"0.7 N\""),
            ("decimals = 2", "decimals = 13"),
        ]
    ));
}

#[test]
fn values_without_a_place_in_the_line_and_the_other_way_round_are_pointed_at() {
    insta::assert_snapshot!(said(
        "ascii-force-gauge",
        &[("{*},{force} N", "{*},{azimuth} N"), ("terminator = \"cr-lf\"", "terminator = \"crlf\"")]
    ));
}
