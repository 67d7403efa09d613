//! What the strain gauge loop removes, and what the support shows.

use super::*;

#[test]
fn hysteresis_makes_harmonics_open_loop_and_few_closed() {
    let distortion = |settings: &MirrorSettings| {
        let seen = harmonics(&mut mirror(settings), 0, 5.0, 1.0, Mirror::angle_rad)[0];
        let power: f64 = seen[1..].iter().map(|z| z[0] * z[0] + z[1] * z[1]).sum();
        power.sqrt() / seen[0][0].hypot(seen[0][1])
    };
    let open = distortion(&broken_loop());
    let closed = distortion(&MirrorSettings::default());
    // Rayleigh loops of this width have a third harmonic of 8/15π × 15 % × 500/1050 = 1.2 %.
    assert!((0.010..0.018).contains(&open), "open loop {open}");
    assert!(closed < 0.1 * open, "closed {closed} of open {open}");
}

#[test]
fn a_broken_strain_gauge_loop_leaves_the_width_and_the_creep() {
    let mut mirror = mirror(&broken_loop());
    let mut tick = 0;
    let mut hold = |mirror: &mut Mirror, volts: f64, steps: u32| {
        mirror.command_analog_v(0, volts);
        for _ in 0..steps {
            mirror.step(tick);
            tick += 1;
        }
        mirror.angle_rad()[0]
    };
    hold(&mut mirror, 1.5, 400);
    let down = hold(&mut mirror, 0.0, 400);
    hold(&mut mirror, -1.5, 400);
    let up = hold(&mut mirror, 0.0, 400);
    assert!(down - up > 0.05 * 1.5e-3, "{down} {up}");
    let soon = hold(&mut mirror, 1.0, 2000);
    let later = hold(&mut mirror, 1.0, 18_000);
    assert!((later / soon - 1.0 - 0.02).abs() < 0.01, "creep {}", later / soon - 1.0);
}

#[test]
fn the_support_shows_in_the_mirrors_own_response_near_its_resonance_only() {
    let table = MirrorSettings { support_coupling_ratio: 0.02, ..linear() };
    let departure = |hz: f64| {
        let ratio = divide(
            response(&table, 0, hz, 0.2, Mirror::sensed_rad),
            response(&linear(), 0, hz, 0.2, Mirror::sensed_rad),
        );
        (ratio[0] - 1.0).hypot(ratio[1])
    };
    let below = departure(50.0);
    let near = departure(140.0);
    let above = departure(400.0);
    assert!(near > 0.05, "near {near}");
    assert!(below < 0.1 * near && above < 0.5 * near, "below {below}, near {near}, above {above}");
}

/// τ = J·θ̈: a sine of 250 µrad at 80 Hz, followed with the gain of the loop.
#[test]
fn the_reaction_torque_is_inertia_times_acceleration() {
    let look: Look = |mirror| mirror.reaction_nm();
    let torque = response(&linear(), 0, 80.0, 0.5, look);
    let angle = response(&linear(), 0, 80.0, 0.5, Mirror::angle_rad);
    let square = (TAU * 80.0).powi(2);
    let ratio = divide(torque, angle);
    // The torque is the mean of a step: half a step before its end.
    let expected = [
        6e-4 * square * (TAU * 80.0 * STEP_S / 2.0).cos(),
        -6e-4 * square * (TAU * 80.0 * STEP_S / 2.0).sin(),
    ];
    let error = divide(ratio, expected);
    assert!((error[0] - 1.0).hypot(error[1]) < 1e-3, "{ratio:?} {expected:?}");
}

#[test]
fn coupling_tilts_the_other_axis_a_little() {
    let settings = MirrorSettings { cross_coupling_ratio: 0.005, strain_gauge_loop_switch: 0.0, ..linear() };
    let seen = harmonics(&mut mirror(&settings), 0, 20.0, 0.5, Mirror::angle_rad);
    let ratio = seen[1][0][0].hypot(seen[1][0][1]) / seen[0][0][0].hypot(seen[0][0][1]);
    assert!((ratio / 0.005 - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn the_terminals_show_the_modes_of_their_axis() {
    let mirror = mirror(&MirrorSettings::default());
    for (axis, mode_hz) in [(0, 322.0), (1, 350.0)] {
        let resistance = |hz: f64| mirror.circuit(axis).impedance(hz).resistance_ohm;
        let at = resistance(1.05 * mode_hz);
        let off = resistance(2.0 * mode_hz);
        assert!(at > 20.0 * off, "axis {axis}: {at} {off} ohm");
    }
}

#[test]
fn a_mirror_with_a_shorter_negative_stroke_stops_there_and_not_on_the_other_side() {
    let settings = MirrorSettings { stroke_asymmetry_ratio: [0.2, 0.0], ..MirrorSettings::default() };
    let reached = |axis: usize, volts: f64| {
        let mut mirror = mirror(&settings);
        mirror.command_analog_v(axis, volts);
        (0..4000).for_each(|tick| mirror.step(tick));
        mirror.angle_rad()[axis]
    };
    assert!((reached(0, 2.05) - 1.025e-3).abs() < 2e-6);
    assert!((reached(0, -2.05) + 0.84e-3).abs() < 6e-6, "{}", reached(0, -2.05));
    assert!((reached(1, -2.05) + 1.025e-3).abs() < 2e-6);
}
