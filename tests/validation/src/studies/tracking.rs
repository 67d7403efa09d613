//! Tracks rail, drone and star with the whole simulated director and prints what is left, beside the study's figures.
//!
//! `cargo run --release -p validation -- tracking [seed …]`

use std::io::Write;

use drivers::device::DeviceError;
use sim_devices::unit::UnitSettings;
use validation::budget::Rejection;
use validation::probe::tracking::{
    CASES, FineTracking, Scenario, deviation, fine_loop, largest, longest_within, quiet, rejection, span,
    track,
};
use validation::shipped;

/// Two cycles of the rail, one of the drone.
const SECONDS: f64 = 125.0;

pub(crate) fn study() -> Result<(), Box<dyn std::error::Error>> {
    let seeds: Vec<u64> = crate::arguments().map(|seed| seed.parse()).collect::<Result<_, _>>()?;
    let mut out = std::io::stdout().lock();
    for seed in if seeds.is_empty() { vec![1, 2, 3] } else { seeds } {
        writeln!(out, "seed {seed}; angles in urad, 1 sigma")?;
        for scenario in [Scenario::Rail, Scenario::Drone] {
            follow(&mut out, scenario, seed)?;
        }
        for (wind_speed_m_per_s, strength_m_pow) in [(20.0, 1e-14), (25.0, 5e-14)] {
            reject(&mut out, (wind_speed_m_per_s, strength_m_pow), seed)?;
        }
    }
    Ok(())
}

fn follow(out: &mut impl Write, scenario: Scenario, seed: u64) -> Result<(), Box<dyn std::error::Error>> {
    let unit = scenario.unit(&UnitSettings::default());
    let gains = shipped::gains();
    let rows = track(&unit, &gains, seed, SECONDS)?;
    for case in CASES.iter().filter(|case| case.scenario == scenario) {
        let coarse = case.coarse_window(&rows);
        let found = 1e6 * deviation(coarse.iter().map(|row| row.coarse_rad(case.axis)));
        let published = 1e6 * case.coarse_rad;
        let peak = 1e6 * largest(span(&rows, 8.0, SECONDS).iter().map(|row| row.coarse_rad(case.axis)));
        let (outside, excluded) = quiet(&rows, case.axis);
        let outside = 1e6 * (outside.iter().map(|e| e * e).sum::<f64>() / outside.len() as f64).sqrt();
        let fine = FineTracking::of(case.fine_window(&rows), case.axis, &unit, &gains);
        writeln!(
            out,
            "{:16} coarse {found:6.2} / {published:5.2} = {:4.2}, peak {peak:6.1}, TRK-RMS-C {outside:5.1} ({:3.1} % out), \
             fine {:4.2} / {:4.2} = {:4.2}, published {:4.2}",
            case.name,
            found / published,
            100.0 * excluded,
            1e6 * fine.found_rad,
            1e6 * fine.predicted_rad,
            fine.ratio(),
            1e6 * case.fine_rad,
        )?;
    }
    let dwell_s = longest_within(span(&rows, 5.0, SECONDS), 5e-6);
    writeln!(out, "{scenario:?}: ENG-DWELL {dwell_s:.1} s of fine track within 5 urad RMS on both axes")?;
    Ok(())
}

fn reject(out: &mut impl Write, case: (f64, f64), seed: u64) -> Result<(), Box<dyn std::error::Error>> {
    let mut unit = Scenario::Star.unit(&UnitSettings::default());
    (unit.atmosphere.wind_speed_m_per_s, unit.atmosphere.strength_m_pow) = case;
    let gains = shipped::gains();
    let rows = track(&unit, &gains, seed, SECONDS).map_err(|error: DeviceError| error.to_string())?;
    let rows = span(&rows, 5.0, SECONDS);
    let knee_hz = sim_devices::atmosphere::knee_hz(&unit.atmosphere);
    for axis in [0, 1] {
        print(out, &format!("ATM-REJ {knee_hz:2.0} Hz {}", ["az", "el"][axis]), rejection(rows, axis))?;
    }
    Ok(print(out, "        as designed", fine_loop(&unit, &gains).figures())?)
}

fn print(out: &mut impl Write, name: &str, seen: Rejection) -> std::io::Result<()> {
    writeln!(
        out,
        "{name:19} 1 Hz {:6.2} dB, 3 Hz {:5.2} dB, crossing {:4.2} Hz, amplification {:4.2} dB",
        seen.at_1_hz_db, seen.at_3_hz_db, seen.crossing_hz, seen.amplification_db
    )
}
