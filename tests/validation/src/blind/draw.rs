//! Distributions of the settings of a unit, and units drawn from them.

use std::fmt::Write as _;

use procedures::quantity::QuantityKind;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use sim_devices::unit::{CURVES, PARAMETERS, UnitSettings};

/// Half-width of a rectangular distribution about the nominal value.
#[derive(Clone, Copy, Debug)]
pub enum Spread {
    /// A share of the nominal value.
    Share(f64),
    /// SI.
    Within(f64),
    /// So many steps (SI) either way: what the simulator does in steps.
    Steps(f64, u32),
}

/// Settings that are spread alike.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// Keys; `*` stands for `az` and `el`.
    pub keys: &'static [&'static str],
    /// How far.
    pub spread: Spread,
    /// Why so far.
    pub because: &'static str,
}

const fn drawn(keys: &'static [&'static str], spread: Spread, because: &'static str) -> Drawn {
    Drawn { keys, spread, because }
}

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Every setting in which units differ. What is left out are switches of the simulation, its steps, the scenery, and what the rig
/// file or a certificate fixes.
#[rustfmt::skip]
pub const DRAWN: &[Drawn] = &[
    drawn(&["*.coulomb-torque", "*.static-torque"], Spread::Share(0.08), "preload of bearings and seals; the rig bets on 0.9 times the static one"),
    drawn(&["*.stribeck-velocity", "*.stribeck-shape"], Spread::Share(0.2), "grease and its temperature"),
    drawn(&["*.viscous-damping"], Spread::Share(0.15), "viscosity; the rig bets on 0.8 times the identified one"),
    drawn(&["*.bristle-stiffness", "*.bristle-damping"], Spread::Share(0.2), "contact stiffness"),
    drawn(&["*.ageing", "*.ageing-time"], Spread::Share(0.5), "growth of the contact at rest"),
    drawn(&["*.inertia"], Spread::Share(0.1), "mass of the payload; the rig states 15 %"),
    drawn(&["*.torque-constant"], Spread::Share(0.04), "magnets; the rig states 5 %"),
    drawn(&["az.unbalance"], Spread::Within(2.0), "levelling"),
    drawn(&["el.unbalance"], Spread::Within(4.0), "balancing"),
    drawn(&["el.spring-stiffness"], Spread::Within(10.0), "cables"),
    drawn(&["el.spring-rest"], Spread::Within(5.0 * DEG), "cables"),
    drawn(&["*.cogging-amplitude", "*.cogging-second-amplitude"], Spread::Share(0.2), "air gap"),
    drawn(&["*.cogging-phase", "*.cogging-second-phase"], Spread::Within(180.0 * DEG), "position of the encoder on the motor"),
    drawn(&["*.encoder-eccentricity", "*.encoder-second-order", "*.encoder-interpolation"], Spread::Share(0.5), "mounting of the scale"),
    drawn(&["*.encoder-eccentricity-phase", "*.encoder-second-order-phase"], Spread::Within(180.0 * DEG), "mounting of the scale"),
    drawn(&["*.encoder-zero"], Spread::Within(100e-6), "reading of the scale when it was set"),
    drawn(&["*.current-noise"], Spread::Share(0.2), "amplifier"),
    drawn(&["*.current-bandwidth"], Spread::Share(0.08), "winding and its temperature"),
    drawn(&["*.command-delay", "*.sensor-delay"], Spread::Steps(50e-6, 3), "firmware; the simulator steps by 50 us"),
    drawn(&["*.heat-sink-rise", "*.heat-sink-time"], Spread::Share(0.05), "air of the cabinet"),
    drawn(&["imu.misalignment-x", "imu.misalignment-y", "imu.misalignment-z"], Spread::Within(200e-6), "mount"),
    drawn(&["imu.lean-yx", "imu.lean-zx", "imu.lean-zy"], Spread::Within(60e-6), "data sheet"),
    drawn(&["imu.gyro-scale-error-x", "imu.gyro-scale-error-y", "imu.gyro-scale-error-z"], Spread::Within(150e-6), "data sheet"),
    drawn(&["imu.gyro-bias-x", "imu.gyro-bias-y", "imu.gyro-bias-z"], Spread::Within(2e-6), "data sheet: 0.5 deg/h"),
    drawn(&["imu.delay"], Spread::Share(0.2), "firmware and filter"),
    drawn(&["imu.gyro-random-walk"], Spread::Share(0.2), "data sheet"),
    drawn(&["imu.accelerometer-bias-x", "imu.accelerometer-bias-y", "imu.accelerometer-bias-z"], Spread::Within(0.005), "data sheet: 0.5 mg"),
    drawn(&["mirror.az-frequency", "mirror.el-frequency"], Spread::Share(0.015), "FSM-MODE allows 3 %"),
    drawn(&["mirror.capacitance", "mirror.coupling"], Spread::Share(0.05), "ceramic"),
    drawn(&["mirror.bare-damping", "mirror.hysteresis"], Spread::Share(0.2), "ceramic"),
    drawn(&["mirror.support-frequency"], Spread::Share(0.04), "support"),
    drawn(&["mirror.cross-coupling"], Spread::Share(0.5), "assembly"),
    drawn(&["trackers.coarse-latency"], Spread::Within(1e-3), "image processing"),
    drawn(&["trackers.fine-latency"], Spread::Within(0.3e-3), "image processing"),
    drawn(&["trackers.optical-gain-elevation", "trackers.optical-gain-cross-elevation"], Spread::Share(0.012), "focal lengths; OPT-GAIN allows 3 %"),
    drawn(&["trackers.coarse-jitter", "trackers.fine-jitter"], Spread::Share(0.2), "light"),
    drawn(&["instruments.force-scale-error"], Spread::Within(0.002), "certificate of the force gauge"),
    drawn(&["instruments.lever-arm-error"], Spread::Within(0.0005), "certificate of the lever arm"),
    drawn(&["instruments.autocollimator-scale-error", "instruments.mirror-reference-scale-error"], Spread::Within(0.002), "certificates of the autocollimators"),
    drawn(&["instruments.current-probe-scale-error"], Spread::Within(0.005), "certificate of the current probe"),
];

/// Frequencies of the modes over all poses, by a factor for each mode: within half of what STR-MODE allows.
const MODE_FREQUENCY_SHARE: f64 = 0.025;
/// Damping of the modes, by a factor for each mode.
const MODE_DAMPING_SHARE: f64 = 0.15;

/// The file of a unit.
///
/// # Panics
/// For a key that no unit has.
pub fn unit(id: &str, number: u32) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(0x00b1_1d00 + u64::from(number));
    let mut tables: Vec<(String, Vec<String>)> = Vec::new();
    let mut line = |table: &str, text: String| match tables.iter_mut().find(|(name, _)| name == table) {
        Some((_, lines)) => lines.push(text),
        None => tables.push((table.to_owned(), vec![text])),
    };
    for one in DRAWN {
        for key in one.keys.iter().flat_map(|key| spelled_out(key)) {
            let setting =
                PARAMETERS.iter().find(|p| p.key == key).unwrap_or_else(|| panic!("no setting `{key}`"));
            let nominal = setting.get(&UnitSettings::default());
            let value = one.spread.draw(nominal, &mut random).clamp(setting.range_si[0], setting.range_si[1]);
            let (table, own) = setting.table_and_key();
            line(table, format!("{own} = \"{}\"", text(setting.quantity, value)));
        }
    }
    for curve in CURVES.iter() {
        let share = match (curve.key.contains("-frequency"), curve.key.contains("-damping")) {
            (true, _) => MODE_FREQUENCY_SHARE,
            (_, true) => MODE_DAMPING_SHARE,
            _ => continue,
        };
        let shipped = UnitSettings::default();
        let nominal = curve.get(&shipped);
        let factor = 1.0 + share * both_ways(&mut random);
        if nominal.iter().all(|value| *value > 0.0) && !nominal.is_empty() {
            let values: Vec<String> =
                nominal.iter().map(|value| format!("\"{}\"", text(curve.quantity, factor * value))).collect();
            line(curve.table, format!("{} = [{}]", curve.key, values.join(", ")));
        }
    }
    let mut file =
        format!("schema = 1\nid = \"{id}\"\ntitle = \"Drawn unit {number}\"\nbase = \"nominal\"\n");
    for (table, lines) in tables {
        let _ = write!(file, "\n[{table}]\n{}\n", lines.join("\n"));
    }
    file
}

fn spelled_out(key: &str) -> Vec<String> {
    match key.strip_prefix("*.") {
        Some(own) => vec![format!("az.{own}"), format!("el.{own}")],
        None => vec![key.to_owned()],
    }
}

/// A value as a person would write it, to six digits: what is read back is the truth.
pub fn text(quantity: &str, value: f64) -> String {
    let name = serde_json::Value::String(quantity.to_owned());
    let kind: QuantityKind = serde_json::from_value(name).expect("settings name kinds of quantity");
    kind.format(value)
}

impl Spread {
    fn draw(self, nominal: f64, random: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Share(share) => nominal * (1.0 + share * both_ways(random)),
            Self::Within(half_width) => nominal + half_width * both_ways(random),
            Self::Steps(step, most) => {
                let span = u64::from(2 * most + 1);
                nominal + step * ((random.next_u64() % span) as f64 - f64::from(most))
            }
        }
    }
}

/// Between -1 and 1.
fn both_ways(random: &mut ChaCha8Rng) -> f64 {
    let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    2.0 * unit - 1.0
}

#[cfg(test)]
mod tests {
    use bench::files::unit::load_unit;

    use super::*;

    #[test]
    fn every_drawn_unit_is_a_good_file_and_another_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let files: Vec<String> = (1..=4).map(|number| unit("drawn", number)).collect();
        assert!(files.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(unit("drawn", 3), files[2], "the same number is the same unit");
        for (k, text) in files.iter().enumerate() {
            let path = folder.path().join(format!("drawn-{k}.toml"));
            std::fs::write(&path, text).expect("a writable folder");
            let unit = load_unit(path.to_str().expect("a plain path"));
            assert!(unit.is_ok_and(|unit| unit.director().is_some()), "{text}");
        }
    }
}
