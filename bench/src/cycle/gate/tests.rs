use super::*;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::model::rig::Rig;

/// Switch on disabled.
const DISABLED: u16 = 0x0250;

fn rig() -> Rig {
    read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("a shipped rig parses")
}

fn quiet() -> Actuals {
    Actuals {
        statusword: DISABLED,
        position_rad: 0.5,
        heat_sink_degc: 41.0,
        bus_v: 560.0,
        ..Actuals::default()
    }
}

fn told(actuals: &Actuals, case: &Case) -> Option<String> {
    let rig = rig();
    let asked = vec![("heat-sink".to_owned(), Q::Temperature.parse_limit("< 60 degC").expect("a limit"))];
    closed_on(&asked, &View { axis: &rig.axes[1], actuals, case })
}

#[test]
fn each_gate_says_what_it_expected_and_what_it_found() {
    let open_loop = Case { open_loop: true, axis: "el".to_owned(), ..Case::default() };
    let closed_loop = Case { axis: "el".to_owned(), ..Case::default() };
    let q = quiet();
    for (actuals, case, expected) in [
        (
            Actuals { statusword: 0x0237, ..q },
            &closed_loop,
            "`drive-state` of el: expected a drive without torque",
        ),
        (Actuals { statusword: 0x021F, ..q }, &closed_loop, "found fault reaction active (statusword 021Fh"),
        (Actuals { position_rad: f64::NAN, ..q }, &closed_loop, "`homed` of el: expected -10 deg .. 90 deg"),
        (Actuals { position_rad: 1.6, ..q }, &closed_loop, "(the travel), found 91.6732 deg"),
        (Actuals { velocity_rad_per_s: 0.04, ..q }, &closed_loop, "`slow` of el: expected at most 2 deg/s"),
        (
            Actuals { position_rad: 0.2, ..q },
            &open_loop,
            "`room` of el: expected at least 30 deg to either end",
        ),
        (
            Actuals { heat_sink_degc: 61.0, ..q },
            &closed_loop,
            "`heat-sink` of el: expected < 60 degC, found 61 degC",
        ),
    ] {
        let told = told(&actuals, case).unwrap_or_default();
        assert!(told.contains(expected), "{told:?} lacks {expected:?}");
    }
}

#[test]
fn a_quiet_axis_passes_and_so_does_one_that_is_held_or_has_a_latched_fault() {
    let case = Case { axis: "el".to_owned(), ..Case::default() };
    for statusword in [DISABLED, 0x0231, 0x0233, 0x0207, 0x0218] {
        let q = Actuals { statusword, ..quiet() };
        assert_eq!(told(&q, &case), None, "{statusword:04X}h");
    }
    // Short of room, but with closed loops: homing takes it to the start.
    assert_eq!(told(&Actuals { position_rad: 0.2, ..quiet() }, &case), None);
}

#[test]
fn every_gate_that_a_procedure_may_ask_for_has_a_row() {
    let known: Vec<&str> = procedures::procedure::GATES.iter().map(|(name, _)| *name).collect();
    let rows: Vec<&str> = ASKED.iter().map(|gate| gate.name).collect();
    assert_eq!(known, rows);
}
