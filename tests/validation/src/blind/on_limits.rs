//! Drawn units whose truth lies on limits: of the findings there as many may pass as the rule of the limit promises.

use std::collections::BTreeMap;

use analysis::proportion::probability_of_at_least;
use bench::files::unit::load_unit;
use procedures::verdict::Verdict;
use sim_devices::physics::lugre::LuGre;
use sim_devices::unit::{AxisSettings, PARAMETERS, UnitSettings};

use super::Scored;
use super::truth::drivetrain::{TICK_S, spring_span_rad};
use super::truth::inertial::{elevation_gyro_scale, leans_rad};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Fastest rate at which FRC-AZ and FRC-EL hold.
const FRICTION_RATE_RAD_PER_S: f64 = 10.0 * DEG;
/// Limits of FRC-AZ and FRC-EL, N·m.
const FRICTION_NM: [f64; 2] = [260.0, 130.0];
/// Step of the contact where only its steady torque is asked for, s.
const STEP_S: f64 = 50e-6;

/// Procedures of `quick` that look at what is set.
pub const PROCEDURES: [&str; 13] = [
    "AZ-TORQUE-CONSTANT",
    "AZ-FRICTION",
    "EL-TORQUE-CONSTANT",
    "EL-FRICTION",
    "AZ-CURRENT",
    "EL-CURRENT",
    "FSM-IMPEDANCE",
    "IMU-CONSISTENCY",
    "IMU-NOISE",
    "AZ-LATENCY",
    "EL-LATENCY",
    "AZ-COARSE-LATENCY",
    "EL-COARSE-LATENCY",
];

/// The setting that puts a truth on its limit, and what it must be.
type OnLimit = (&'static str, fn(&UnitSettings) -> f64);

/// Left out are UNB-EL and ENC-PLAY: an unbalance of 65 N·m where the rig file declares 14 trips the bounds of the first motion, and
/// play of 9 µrad in elevation is refused by polarity on two units of three, as an encoder or a torque scale.
const SETTINGS: &[OnLimit] = &[
    ("az.coulomb-torque", |unit| unit.az.coulomb_torque_nm + friction_missing_nm(&unit.az, FRICTION_NM[0])),
    ("el.coulomb-torque", |unit| unit.el.coulomb_torque_nm + friction_missing_nm(&unit.el, FRICTION_NM[1])),
    ("az.static-torque", |unit| unit.az.static_torque_nm + friction_missing_nm(&unit.az, FRICTION_NM[0])),
    ("el.static-torque", |unit| unit.el.static_torque_nm + friction_missing_nm(&unit.el, FRICTION_NM[1])),
    ("az.unbalance", |_| 5.0),
    ("el.spring-stiffness", |unit| 65.0 / spring_span_rad(&unit.el)),
    ("az.cogging-amplitude", |_| 12.0),
    ("el.cogging-amplitude", |_| 8.0),
    ("az.current-bandwidth", |_| 800.0),
    ("el.current-bandwidth", |_| 1300.0),
    ("mirror.az-frequency", |_| 322.0 * 1.03),
    ("mirror.el-frequency", |_| 350.0 * 0.97),
    ("az.encoder-interpolation", |_| 1e-6),
    ("el.encoder-interpolation", |_| 1e-6),
    ("el.encoder-zero", |unit| leans_rad(unit) - 1e-3),
    ("az.encoder-slip", |_| 250e-6),
    ("az.command-delay", |unit| 3.5e-3 - TICK_S - unit.az.sensor_delay_s),
    // Gyros x and y share the elevation axis: what one adds shows as half.
    ("imu.gyro-scale-error-x", |unit| {
        unit.imu.gyro_scale_error_ratio[0] + 2.0 * (500e-6 - elevation_gyro_scale(unit))
    }),
    ("imu.gyro-random-walk", |_| 0.015 * DEG / 60.0),
    ("imu.accelerometer-bias-z", |_| 0.02),
    ("trackers.coarse-scale", |_| 1.10),
    ("trackers.coarse-latency", |_| 45e-3),
];

/// What steady friction at the fastest rate lacks to its limit: Coulomb and static torque shift it one for one.
fn friction_missing_nm(axis: &AxisSettings, limit_nm: f64) -> f64 {
    limit_nm - LuGre::new(axis, STEP_S).steady_torque_nm(FRICTION_RATE_RAD_PER_S)
}

/// The file of a drawn unit with its truths on the limits.
///
/// # Panics
/// Where the drawn unit is no director, or has none of the settings.
pub fn unit(id: &str, number: u32) -> String {
    let drawn = super::draw::unit(id, number);
    let folder = tempfile::tempdir().expect("a folder for a unit");
    let path = folder.path().join("drawn.toml");
    std::fs::write(&path, &drawn).expect("a writable folder");
    let unit = load_unit(path.to_str().expect("a plain path")).expect("a drawn unit");
    let settings = unit.director().expect("a director").clone();
    let mut file: toml::Table = drawn.parse().expect("a drawn unit");
    for (key, value) in SETTINGS {
        let setting =
            PARAMETERS.iter().find(|p| p.key == *key).unwrap_or_else(|| panic!("no setting `{key}`"));
        let (table, own) = setting.table_and_key();
        let text = super::draw::text(setting.quantity, value(&settings));
        let table = file.entry(table).or_insert_with(|| toml::Table::new().into());
        table.as_table_mut().expect("a table of settings").insert(own.to_owned(), text.into());
    }
    file.to_string()
}

/// Findings of one requirement on one axis whose truth is on a limit.
#[derive(Debug)]
pub struct Row {
    /// Requirement, measurand and axis.
    pub name: String,
    /// Findings, one a unit.
    pub findings: u64,
    /// Of these passed.
    pub passes: u64,
    /// Share of passes that the rule promises: 2.275 % for a guarded one, half for a simple one.
    pub promised: f64,
    /// Probability of so many passes or more.
    pub p: f64,
    /// Of these findings passed by simple acceptance, which promises half of them.
    pub simple_passes: u64,
    /// Probability of so many of those or more.
    pub simple_p: f64,
}

const GUARDED: f64 = 0.02275;
const SIMPLE: f64 = 0.5;

/// One row for each requirement, measurand and axis; of each unit its first finding counts.
pub fn rows(all: &[Scored]) -> Vec<Row> {
    let mut groups: BTreeMap<String, BTreeMap<u32, &Scored>> = BTreeMap::new();
    for one in all {
        if let Some(judged) = one.on_limit.as_ref() {
            let name = format!("{} {} {}", judged.requirement, one.measurand, one.axis);
            groups.entry(name).or_default().entry(one.unit).or_insert(one);
        }
    }
    let row = |(name, group): (String, BTreeMap<u32, &Scored>)| {
        let findings = group.len() as u64;
        // A conditional pass is a number inside of the guard band: it says that it may be outside of the limit.
        let count = |passed: fn(&Scored) -> bool| group.values().filter(|one| passed(one)).count() as u64;
        let passes = count(|one| one.verdict == Verdict::Pass);
        let simple_passes = count(|one| one.on_limit.as_ref().is_some_and(|j| j.by_simple == Verdict::Pass));
        let is_guarded =
            group.values().any(|one| one.on_limit.as_ref().is_some_and(|judged| judged.is_guarded));
        let promised = if is_guarded { GUARDED } else { SIMPLE };
        let p = |passes, promised| {
            probability_of_at_least(passes, findings, promised).expect("passes are findings")
        };
        let (p, simple_p) = (p(passes, promised), p(simple_passes, SIMPLE));
        Row { name, findings, passes, promised, p, simple_passes, simple_p }
    };
    groups.into_iter().map(row).collect()
}

/// The rows for a person, Markdown.
pub fn table(rows: &[Row]) -> String {
    let mut text = "| truth on the limit of | units | passes | promised | p | by simple acceptance | p |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n"
        .to_owned();
    for row in rows {
        let promised = 100.0 * row.promised;
        text += &format!(
            "| {} | {} | {} | {promised:.1} % | {:.2} | {} | {:.2} |\n",
            row.name, row.findings, row.passes, row.p, row.simple_passes, row.simple_p
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaves(text: &str) -> BTreeMap<(String, String), String> {
        let file: toml::Table = text.parse().expect("a unit");
        let settings = |(table, inner): (String, toml::Value)| {
            let inner = inner.as_table().cloned().unwrap_or_default();
            inner.into_iter().map(move |(key, value)| ((table.clone(), key), value.to_string()))
        };
        file.into_iter().flat_map(settings).collect()
    }

    #[test]
    fn a_unit_on_its_limits_is_the_drawn_one_but_for_them() {
        let text = unit("drawn", 7);
        let [own, drawn] = [text.clone(), super::super::draw::unit("drawn", 7)].map(|text| leaves(&text));
        let changed = own.iter().filter(|(key, value)| drawn.get(*key) != Some(value)).count();
        assert_eq!(changed, SETTINGS.len());
        assert!(drawn.keys().all(|key| own.contains_key(key)));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("unit.toml");
        std::fs::write(&path, text).expect("a writable folder");
        let unit = load_unit(path.to_str().expect("a plain path")).expect("a good file");
        let settings = unit.director().expect("a director");
        for (axis, limit_nm) in [(&settings.az, FRICTION_NM[0]), (&settings.el, FRICTION_NM[1])] {
            let torque_nm = LuGre::new(axis, STEP_S).steady_torque_nm(FRICTION_RATE_RAD_PER_S);
            // A hundredth of what friction is known to: ageing grows with the static torque.
            assert!((torque_nm - limit_nm).abs() < 0.01, "{torque_nm} N·m");
        }
    }
}
