use super::*;
use std::f64::consts::TAU;

const FULL_SCALE: f64 = 1.05e-3;
const UNITY: f64 = 0.25e-3;

fn actuator() -> Hysteresis {
    Hysteresis::new(FULL_SCALE, 0.15, UNITY)
}

/// A triangle between two turning points and back, `points` each way: inputs and outputs.
fn loop_of(hysteresis: &mut Hysteresis, low: f64, high: f64, points: u32) -> Vec<[f64; 2]> {
    let at = |k: u32| {
        low + (high - low) * f64::from(if k <= points { k } else { 2 * points - k }) / f64::from(points)
    };
    (0..=2 * points).map(|k| [at(k), hysteresis.update(at(k))]).collect()
}

#[test]
fn the_major_loop_closes_and_opens_by_the_width_asked_for() {
    let mut hysteresis = actuator();
    loop_of(&mut hysteresis, -FULL_SCALE, FULL_SCALE, 500);
    let path = loop_of(&mut hysteresis, -FULL_SCALE, FULL_SCALE, 500);
    assert!((path[0][1] - path[1000][1]).abs() < 1e-15, "open: {} {}", path[0][1], path[1000][1]);
    let travel = path[500][1] - path[0][1];
    let widest = (0..=500).map(|k| path[1000 - k][1] - path[k][1]).fold(0.0, f64::max);
    assert!((widest / travel - 0.15).abs() < 1e-9, "width {}", widest / travel);
    assert!((path[750][1] - path[250][1] - widest).abs() < 1e-15, "widest at zero input");
}

#[test]
fn the_secant_gain_is_one_at_its_reference_amplitude() {
    let mut hysteresis = actuator();
    loop_of(&mut hysteresis, -UNITY, UNITY, 100);
    let path = loop_of(&mut hysteresis, -UNITY, UNITY, 100);
    assert!(((path[100][1] - path[0][1]) / (2.0 * UNITY) - 1.0).abs() < 1e-12);
}

#[test]
fn the_loop_does_not_depend_on_how_fast_or_how_evenly_it_is_run() {
    let mut fast = actuator();
    let mut slow = actuator();
    for _ in 0..2 {
        let coarse = loop_of(&mut fast, -0.7e-3, 0.9e-3, 7);
        let fine = loop_of(&mut slow, -0.7e-3, 0.9e-3, 7 * 911);
        for (k, point) in coarse.iter().enumerate() {
            assert!((point[1] - fine[k * 911][1]).abs() < 1e-15, "point {k}");
        }
    }
}

#[test]
fn an_inner_loop_is_wiped_out_by_passing_its_turning_point() {
    let mut plain = actuator();
    let mut detoured = actuator();
    for hysteresis in [&mut plain, &mut detoured] {
        hysteresis.update(0.9e-3);
        hysteresis.update(-0.6e-3);
        hysteresis.update(0.4e-3);
    }
    // A loop inside, back to where it began: same output there and ever after.
    detoured.update(-0.2e-3);
    detoured.update(0.1e-3);
    detoured.update(-0.2e-3);
    for input in [0.4e-3, 0.5e-3, 0.2e-3, -0.8e-3] {
        assert!((plain.update(input) - detoured.update(input)).abs() < 1e-18, "at {input}");
    }
}

#[test]
fn below_the_first_threshold_there_is_no_loop() {
    let mut hysteresis = actuator();
    let path = loop_of(&mut hysteresis, -50e-6, 50e-6, 20);
    let gain = path[0][1] / path[0][0];
    assert!(0.0 < gain && gain < 1.0, "{gain}");
    path.iter().for_each(|[input, output]| assert!((output - gain * input).abs() < 1e-18));
}

#[test]
fn creep_grows_by_its_share_in_every_decade() {
    let step_s = 1e-3;
    let mut creep = Creep::new(0.02, step_s);
    let mut at = |count: u32| (0..count).map(|_| creep.update(1.0)).last().unwrap_or(0.0);
    // At 0.3, 3 and 30 s: each decade adds 2 %, the first and last of the ladder a little less.
    let samples = [at(300), at(2700), at(27_000)];
    for pair in samples.windows(2) {
        assert!((pair[1] - pair[0] - 0.02).abs() < 0.001, "{samples:?}");
    }
    let settled = at(1_000_000);
    assert!((settled - 1.08).abs() < 1e-5, "{settled}");
}

fn circuit() -> Circuit {
    Circuit::new(&CircuitValues {
        capacitance_f: 30.2e-6,
        coupling_ratio: 0.1,
        loss_tangent_ratio: 0.02,
        frequency_hz: 322.0,
        damping_ratio: 0.02,
        series_ohm: 0.1,
        leak_ohm: 1e6,
    })
}

#[test]
fn the_circuit_shows_its_capacitance_its_loss_and_its_resonances() {
    let circuit = circuit();
    let low = circuit.impedance(20.0);
    let capacitance = -1.0 / (TAU * 20.0 * low.reactance_ohm);
    assert!((capacitance / 30.2e-6 - 1.0).abs() < 0.01, "{capacitance:e} F");
    let bare = Circuit { series_ohm: 0.0, leak_ohm: 1e12, motional_f: 0.0, ..self::circuit() };
    for frequency_hz in [20.0, 65.0, 200.0, 650.0, 2000.0] {
        let z = bare.impedance(frequency_hz);
        let loss = -z.resistance_ohm / z.reactance_ohm;
        assert!((loss / 0.02 - 1.0).abs() < 0.12, "{frequency_hz} Hz: tan delta {loss}");
    }
    // Smallest |Z|·ω near the series, largest near the parallel resonance f_s/√(1 − k²) = 339.4 Hz.
    let scaled = |f: &f64| circuit.impedance(*f).magnitude_ohm() * f;
    let grid: Vec<f64> = (0..1000).map(|k| 280.0 + 0.1 * f64::from(k)).collect();
    let least = grid.iter().copied().min_by(|a, b| scaled(a).total_cmp(&scaled(b))).unwrap_or(0.0);
    let most = grid.iter().copied().max_by(|a, b| scaled(a).total_cmp(&scaled(b))).unwrap_or(0.0);
    assert!((least - 322.0).abs() < 3.5 && (most - 339.4).abs() < 3.5, "{least} Hz, {most} Hz");
}

/// The relaxations are part of the stated capacitance: with too much loss nothing would be left beside them.
#[test]
fn every_loss_tangent_that_a_unit_may_have_leaves_a_fast_capacitance() {
    let allowed = crate::unit::PARAMETERS.iter().find(|p| p.key == "mirror.loss-tangent").expect("a setting");
    let fast_f = |loss_tangent_ratio: f64| {
        let settings = crate::unit::UnitSettings::default().mirror;
        let values = CircuitValues {
            capacitance_f: settings.capacitance_f,
            coupling_ratio: settings.coupling_ratio,
            loss_tangent_ratio,
            frequency_hz: settings.frequency_hz[0],
            damping_ratio: settings.bare_damping_ratio,
            series_ohm: settings.series_resistance_ohm,
            leak_ohm: settings.leak_resistance_ohm,
        };
        Circuit::new(&values).fast_capacitance_f
    };
    assert!(fast_f(allowed.range_si[1]) > 0.0, "{}", allowed.range_si[1]);
    assert!(fast_f(1.02 * allowed.range_si[1]) <= 0.0, "the range ends where the circuit does");
}
