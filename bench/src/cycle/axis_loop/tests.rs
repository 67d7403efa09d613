use super::*;
use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};

fn azimuth() -> AxisLoop {
    let source = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
    let rig = read_rig(source).expect("a shipped rig parses");
    let gains = parameters::load(&rig).expect("shipped parameters");
    AxisLoop::of_rig(&rig, &gains).remove(0)
}

fn excited(into: Injection, value: f64, gain_ratio: Option<f64>) -> AxisLoop {
    let mut axis_loop = azimuth();
    let still = Actuals::default();
    let segment = Segment { gain_ratio, ..Segment::hold("excited", Mode::Velocity, 1.0) };
    axis_loop.enter(&segment, 0.0);
    let excitation = Some((into, value));
    let torque_nm = axis_loop.excited(excitation).torque(&still, 0.0, Some(&Setpoint::default()));
    axis_loop.sent(torque_nm);
    axis_loop
}

/// Otherwise a stop that begins during an excitation would keep its torque and push the axis on.
#[test]
fn nothing_of_an_excitation_is_left_in_an_emergency_stop() {
    for (into, value) in [(Injection::Torque, 300.0), (Injection::Velocity, 0.03)] {
        let mut axis_loop = excited(into, value, None);
        let still = Actuals::default();
        axis_loop.start_emergency_stop(&still, 1.7, 150.0, 0.0);
        for _ in 0..100 {
            let torque_nm = axis_loop.torque(&still, 0.0, None);
            assert!(torque_nm.abs() < 1.0, "{into:?}: {torque_nm} N*m");
            axis_loop.sent(torque_nm);
        }
    }
}

#[test]
fn a_loosened_loop_does_not_keep_the_excitation_of_the_tick_in_which_it_began() {
    let mut axis_loop = excited(Injection::Torque, 300.0, None);
    let still = Actuals::default();
    let detuned = Segment { gain_ratio: Some(0.0), ..Segment::hold("detuned", Mode::Velocity, 1.0) };
    axis_loop.enter(&detuned, 0.0);
    let torque_nm = axis_loop.excited(None).torque(&still, 0.0, Some(&Setpoint::default()));
    assert!(torque_nm.abs() < 1e-9, "{torque_nm}");
}

/// Torque and reference after 100 periods of a move, with all ticks or with a gap of 33 periods.
fn moved(ticks: &[u32]) -> (f64, Reference) {
    let mut axis_loop = azimuth();
    let still = Actuals::default();
    axis_loop.go_slowly(&still, 0.5);
    let mut torque_nm = 0.0;
    for &periods in ticks {
        axis_loop.pass(periods, periods);
        // An axis that follows its reference, a little too slowly.
        let position_rad = axis_loop.reference.reference().position_rad;
        let actuals = Actuals { position_rad, ..still };
        torque_nm = axis_loop.torque(&actuals, 0.9 * axis_loop.setpoint.velocity_rad_per_s, None);
        axis_loop.sent(torque_nm);
    }
    (torque_nm, axis_loop.reference.reference())
}

#[test]
fn reference_and_integral_go_on_in_time_over_missed_periods() {
    let (whole_nm, whole) = moved(&[1; 100]);
    let (gap_nm, gap) = moved(&[&[1; 60][..], &[33], &[1; 7]].concat());
    assert!((gap.position_rad - whole.position_rad).abs() < 1e-12, "{gap:?} {whole:?}");
    assert!((gap_nm - whole_nm).abs() < 0.05 * whole_nm.abs(), "{gap_nm} N·m instead of {whole_nm}");
}

#[test]
fn what_is_no_number_excites_nothing_and_nothing_exceeds_the_limit() {
    let still = Actuals::default();
    let mut axis_loop = azimuth();
    axis_loop.enter(&Segment::hold("excited", Mode::Velocity, 1.0), 0.0);
    let not_a_number = Some((Injection::Torque, f64::NAN));
    let torque_nm = axis_loop.excited(not_a_number).torque(&still, 0.0, Some(&Setpoint::default()));
    assert_eq!(torque_nm, 0.0);
    let too_much = Some((Injection::Torque, 1e9));
    let torque_nm = axis_loop.excited(too_much).torque(&still, 0.0, Some(&Setpoint::default()));
    assert_eq!(torque_nm, axis_loop.max_torque_nm);
}
