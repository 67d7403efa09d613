use super::*;

#[test]
fn every_value_of_the_nominal_unit_is_a_number_with_an_uncertainty() {
    let gains = DirectorGains::default();
    let rows = friction::rows(&Subject { unit: &UnitSettings::default(), gains: &gains });
    assert!(rows.iter().all(|r| r.value_si.is_finite() && r.uncertainty_si > 0.0));
}

/// 210 N·m and what a ramp of minutes adds: between a fresh contact and one that rested as long as the ramp lasts.
#[test]
fn a_slow_ramp_breaks_away_above_the_fresh_contact() {
    let gains = DirectorGains::default();
    let rows = friction::rows(&Subject { unit: &UnitSettings::default(), gains: &gains });
    let slow = rows.iter().find(|r| r.condition.contains("0.01 A/s")).expect("predicted").value_si;
    let oldest = 210.0 * (1.0 + 0.02 * 350.0_f64.ln_1p());
    assert!(slow > 210.0 && slow < oldest, "{slow}");
}

#[test]
fn signs_and_scales_of_the_nominal_unit_are_right_and_each_wrong_one_is_named() {
    assert_eq!(polarity(&UnitSettings::default()), Ok(()));
    let wrong: [fn(&mut UnitSettings); 5] = [
        |unit| unit.el.encoder_sign_factor = -1.0,
        |unit| unit.imu.gyro_sign_factor = [-1.0; 3],
        |unit| unit.imu.gyro_sign_factor[0] = -1.0,
        |unit| unit.wiring.axes_swapped_flag = 1.0,
        |unit| unit.az.torque_constant_nm_per_a *= 0.7,
    ];
    for spoil in wrong {
        let mut unit = UnitSettings::default();
        spoil(&mut unit);
        assert!(polarity(&unit).is_err());
    }
}
