use super::*;
use crate::AxisGains;
use crate::filters::Biquad;
use crate::position::PositionController;
use crate::velocity::VelocityController;

const PERIOD_S: f64 = 250e-6;
const PROBE: Probe =
    Probe { period_s: PERIOD_S, operating_point: 0.0, amplitude: 1e-3, settle_s: 1.0, measure_s: 2.0 };

/// Relative distance of what is measured from what is expected.
fn deviation(law: impl FnMut(f64) -> f64, probe: &Probe, frequency_hz: f64, expected: Complex) -> f64 {
    let measured = frequency_response(law, probe, frequency_hz).expect("a finite response");
    (measured - expected).magnitude() / expected.magnitude()
}

fn z(frequency_hz: f64) -> Complex {
    Complex::unit(TAU * frequency_hz * PERIOD_S)
}

#[test]
fn velocity_law_is_kp_plus_ki_ts_z_over_z_minus_1() {
    let gains = AxisGains {
        velocity_kp_nm_s_per_rad: 18_250.0,
        velocity_ki_nm_per_rad: 361_400.0,
        ..AxisGains::default()
    };
    for frequency_hz in [0.7, 3.75, 17.0, 333.3, 1500.0] {
        let mut law = VelocityController::new(&gains, 1e6, PERIOD_S);
        let z = z(frequency_hz);
        let expected = Complex::real(18_250.0) + z / (z - Complex::ONE) * (361_400.0 * PERIOD_S);
        let error = deviation(|e| law.update(e, 0.0, 0.0), &PROBE, frequency_hz, expected);
        assert!(error < 1e-9, "{frequency_hz} Hz: {error}");
    }
}

#[test]
fn saturated_law_has_another_response_than_the_linear_one() {
    let gains = AxisGains { velocity_kp_nm_s_per_rad: 18_250.0, ..AxisGains::default() };
    let mut law = VelocityController::new(&gains, 9.0, PERIOD_S);
    let error = deviation(|e| law.update(e, 0.0, 0.0), &PROBE, 10.0, Complex::real(18_250.0));
    assert!(error > 0.3, "{error}");
}

#[test]
fn operating_point_decides_the_gain_of_a_curved_law() {
    let probe = Probe { operating_point: 3.0, ..PROBE };
    assert!(deviation(|x| x * x, &probe, 12.0, Complex::real(6.0)) < 1e-9);
    let gains = AxisGains { position_gain_per_s: 4.5, ..AxisGains::default() };
    let law = PositionController::new(&gains, 1.0);
    assert!(deviation(|e| law.update(e, 0.0, 0.1), &PROBE, 1.0, Complex::real(4.5)) < 1e-9);
}

#[test]
fn biquads_are_the_bilinear_transforms_of_their_prototypes() {
    let rate_hz = 1.0 / PERIOD_S;
    let notch = Biquad::notch(322.0, 0.36, 1.0, rate_hz).expect("below half the rate");
    let low_pass = Biquad::low_pass(60.0, 0.7, rate_hz).expect("below half the rate");
    for frequency_hz in [2.0, 60.0, 322.0, 900.0] {
        let tangent = |f: f64| libm::tan(TAU * f * PERIOD_S / 2.0);
        let second = |zeta: f64, x: f64| Complex::new(1.0 - x * x, 2.0 * zeta * x);
        let x = tangent(frequency_hz) / tangent(322.0);
        let mut filter = notch.clone();
        let error = deviation(|u| filter.update(u), &PROBE, frequency_hz, second(0.36, x) / second(1.0, x));
        assert!(error < 1e-9, "notch at {frequency_hz} Hz: {error}");
        let mut filter = low_pass.clone();
        let expected = Complex::ONE / second(0.7, tangent(frequency_hz) / tangent(60.0));
        let error = deviation(|u| filter.update(u), &PROBE, frequency_hz, expected);
        assert!(error < 1e-9, "low-pass at {frequency_hz} Hz: {error}");
    }
}

#[test]
fn double_integrator_is_measured_in_spite_of_its_ramp() {
    for frequency_hz in [1.0, 10.0, 100.0] {
        let mut first = 0.0;
        let mut second = 0.0;
        let law = |u: f64| {
            first += PERIOD_S * u;
            second += PERIOD_S * first;
            second
        };
        let z = z(frequency_hz);
        let integrator = z / (z - Complex::ONE) * PERIOD_S;
        let error = deviation(law, &PROBE, frequency_hz, integrator * integrator);
        assert!(error < 1e-6, "{frequency_hz} Hz: {error}");
    }
}

#[test]
fn what_cannot_be_measured_gives_no_number() {
    let law = |u: f64| u;
    assert_eq!(frequency_response(law, &PROBE, 0.0), None);
    assert_eq!(frequency_response(law, &PROBE, 2000.0), None);
    assert_eq!(frequency_response(law, &PROBE, f64::NAN), None);
    assert_eq!(frequency_response(law, &PROBE, 0.01), None, "a fiftieth of a period is a ramp");
    assert_eq!(frequency_response(|_| f64::NAN, &PROBE, 10.0), None);
    assert_eq!(frequency_response(law, &Probe { amplitude: 0.0, ..PROBE }, 10.0), None);
}
