use procedures::diagnostic::SourceFile;

use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};

const CERTIFIED: &str = "\n[[instrument]]\nname = \"autocollimator\"\nrole = \"force\"\nmaker = \"Maker\"\nmodel = \"M1\"\n\
                         serial-number = \"77\"\ncertificate = \"C-12\"\ncalibrated = \"2025-03-01\"\ndue = \"2026-03-01\"\n";

fn with(more: &str) -> Result<Rig, Vec<String>> {
    let shipped = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
    let rig = read_rig(SourceFile { text: format!("{}{more}", shipped.text), ..shipped });
    rig.map_err(|all| all.into_iter().map(|d| d.message).collect())
}

#[test]
fn an_instrument_is_believed_up_to_its_due_day_and_refused_after_it() {
    let rig = with(CERTIFIED).expect("right");
    assert_eq!(refusals(&rig, &[], "2026-03-01"), Vec::<String>::new());
    let told = refusals(&rig, &[], "2026-03-02").join("\n");
    for part in [
        "`autocollimator` (Maker M1, serial number 77)",
        "due on 2026-03-01",
        "certificate C-12",
        "calibrated one",
    ] {
        assert!(told.contains(part), "{told:?} lacks {part:?}");
    }
    let status = |today| records(&rig, today).pop().expect("the last of the file").status;
    assert_eq!(status("2026-03-01"), "calibrated until 2026-03-01");
    assert_eq!(status("2026-12-31"), "OVERDUE since 2026-03-01");
}

#[test]
fn with_a_real_device_no_instrument_is_simulated_and_none_is_unknown() {
    let rig = with("").expect("shipped");
    assert_eq!(refusals(&rig, &[], "2026-11-22"), Vec::<String>::new(), "all is simulated");
    let told = refusals(&rig, &["az-drive"], "2026-11-22").join("\n");
    assert!(told.contains("is declared `simulated`, but az-drive is real"), "{told}");
    let bare = Rig { instruments: Vec::new(), ..rig };
    let told = refusals(&bare, &["az-drive"], "2026-11-22").join("\n");
    assert!(told.contains("no instrument is assigned to the device `reference`"), "{told}");
    assert!(told.contains("`role = \"scope\"`") || told.contains("role = \"scope\""), "{told}");
}

#[test]
fn mistakes_in_an_instrument_say_what_is_missing() {
    for (from, to, expected) in [
        ("due = \"2026-03-01\"\n", "", "the instrument has no `due`"),
        ("2026-03-01", "2026-02-30", "`due` must be a day such as `2027-03-01`, found `2026-02-30`"),
        ("2026-03-01", "1.3.2026", "`due` must be a day such as `2027-03-01`, found `1.3.2026`"),
        ("2026-03-01", "2024-03-01", "the due date is before the date of calibration"),
        ("role = \"force\"", "role = \"force\"\nsimulated = true", "a simulated instrument has no `due`"),
    ] {
        let found = with(&CERTIFIED.replace(from, to)).expect_err("a mistake");
        assert!(found.iter().any(|message| message == expected), "{expected:?} is not in {found:?}");
    }
}
