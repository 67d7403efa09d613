use super::*;
use crate::files::rig::tests::told;

fn shipped_text(name: &str) -> String {
    shipped::find(Folder::Profiles, name, None).expect("a shipped profile").text
}

/// What is said of a shipped profile after these replacements, each of the first place where the text stands.
fn said(name: &str, edits: &[(&str, &str)]) -> String {
    let mut text = shipped_text(name);
    for (old, new) in edits {
        assert!(text.contains(old), "the profile no longer says {old}");
        text = text.replacen(old, new, 1);
    }
    told(&read_profile(&SourceFile::new("drive.toml", text)).err().unwrap_or_default())
}

#[test]
fn every_shipped_profile_is_read_and_is_called_as_its_file() {
    let names: Vec<&str> = shipped::all(Folder::Profiles).map(|file| file.stem()).collect();
    assert_eq!(names, ["elmo-gold", "generic-cia402", "simulated"]);
    for name in names {
        let profile = load(name, None).unwrap_or_else(|mistakes| panic!("{}", told(&mistakes)));
        assert_eq!(profile.id, name);
    }
}

#[test]
fn the_simulated_drives_are_sent_ten_bytes_and_send_twenty_eight() {
    let profile = simulated();
    let place = |index| ObjectPlace { index, sub: 0 };
    let offsets = [0x6040, 0x6071, 0x60FF, 0x6060].map(|index| profile.outputs.offset_of(place(index)));
    assert_eq!(offsets, [Some(0), Some(2), Some(4), Some(8)]);
    let offsets = [0x6041, 0x603F, 0x6061, 0x6064, 0x606C, 0x6077, 0x6078, 0x6079, 0x22A3, 0x60FD]
        .map(|index| profile.inputs.offset_of(place(index)));
    assert_eq!(offsets, [0, 2, 4, 6, 10, 14, 16, 18, 22, 24].map(Some));
    assert_eq!(
        (profile.identity, profile.lacks.len(), profile.start_up.len()),
        (ProfileIdentity::default(), 0, 0)
    );
}

#[test]
fn the_elmo_profile_assigns_fixed_pdos_and_reads_its_temperature_by_sdo() {
    let profile = load("elmo-gold", None).expect("a shipped profile");
    assert_eq!(profile.outputs, ProcessData::Assigned(vec![0x1602, 0x161C, 0x160B]));
    assert_eq!(profile.identity.vendor, Some(0x9A));
    assert_eq!(profile.identity.revisions, Some([0x10420, 0x10420]));
    assert_eq!(profile.heat_sink.map(|own| (own.place.sub, own.by)), Some((1, ReadBy::Sdo)));
    assert_eq!((profile.torque_scale, profile.watchdog), (TorqueScale::RatedCurrent, None));
    assert_eq!(profile.start_up.len(), 2);
}

#[test]
fn objects_that_are_none_or_that_nobody_sends_are_refused() {
    insta::assert_snapshot!(said(
        "simulated",
        &[("\"6040h\", ", "\"6040\", \"607Ah\", "), ("\"60FFh\", ", ""), ("\"6061h\"", "\"1008h\"")]
    ));
}

#[test]
fn process_data_that_lack_an_object_or_have_one_twice_are_refused() {
    insta::assert_snapshot!(said(
        "simulated",
        &[
            ("\"60FFh\", ", "\"607Ah\", "),
            ("\"6041h\", ", ""),
            ("\"22A3h\", ", "\"6064h\", "),
            ("\"6078h\", ", "")
        ]
    ));
}

#[test]
fn mapped_and_fixed_outputs_exclude_each_other() {
    insta::assert_snapshot!(said("simulated", &[("outputs = ", "fixed-outputs = [\"1602h\"]\noutputs = ")]));
    insta::assert_snapshot!(said("simulated", &[("outputs = ", "fixed-inputs = ")]));
}

#[test]
fn what_keeps_an_axis_safe_may_not_be_lacked() {
    insta::assert_snapshot!(said(
        "simulated",
        &[("[process-data]", "lacks = [\"6080h\", \"6007h\"]\n\n[process-data]")]
    ));
}

#[test]
fn a_start_up_list_may_not_write_what_the_driver_writes_nor_what_does_not_fit_its_type() {
    insta::assert_snapshot!(said(
        "elmo-gold",
        &[("\"1C32h:01\"", "\"6072h\""), ("\"1C33h:01\"", "\"1C13h:01\"")]
    ));
    insta::assert_snapshot!(said("elmo-gold", &[("value = 2", "value = 70000")]));
    assert_eq!(
        said("elmo-gold", &[("\"1C32h:01\"", "\"6073h\"")]),
        "",
        "the commissioned limit is left to people"
    );
}

#[test]
fn revisions_that_cross_are_refused() {
    insta::assert_snapshot!(said(
        "elmo-gold",
        &[("highest-revision = 0x10420", "highest-revision = 0x10400")]
    ));
}
