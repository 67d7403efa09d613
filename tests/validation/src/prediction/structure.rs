//! Natural frequencies against the finite element analysis, and coupling between the axes.

use num_complex::Complex64;
use sim_devices::unit::{ModeCurves, StructureSettings};

use super::{Expected, Subject, row};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Finite element analysis (director.md, section 5): an elevation, deg, and modes 1, 2 and 3 of elevation there.
pub const ANALYSED_HZ: [(f64, [f64; 3]); 3] =
    [(0.0, [10.0, 16.6, 17.4]), (45.0, [11.0, 18.3, 20.7]), (90.0, [11.9, 18.1, 23.9])];
const MODE_IDS: [&str; 3] = ["STR-MODE-1", "STR-MODE-2", "STR-MODE-3"];
/// Azimuth's first and second mode stand in bands.
const BAND_NAMES: [&str; 2] = ["first-mode-az", "second-mode-az"];
/// Row 8: neighbouring modes 0.02 % at 60 dB; here at about 40 dB, k = 2.
const FREQUENCY_U: f64 = 4e-3;
/// Cross response: coherence 0.99 and 16 averages (row 2), relative.
const COUPLING_U: f64 = 0.05;
/// Up to here the coupling may not show.
const LOW_HZ: f64 = 10.0;
/// Highest frequency of the structural sweeps that the modal model covers.
const HIGH_HZ: f64 = 100.0;
const LOWEST_HZ: f64 = 1.0;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = Vec::new();
    for (elevation_deg, analysed) in ANALYSED_HZ {
        let condition = format!("elevation {elevation_deg} deg");
        let modes = frequencies_hz(subject.structure(1), elevation_deg);
        for (k, id) in MODE_IDS.into_iter().enumerate() {
            let departure = modes.get(k).map_or(f64::NAN, |hz| hz / analysed[k] - 1.0);
            rows.push(row(id, 1, "frequency-departure", condition.clone(), departure, FREQUENCY_U));
        }
        let modes = frequencies_hz(subject.structure(0), elevation_deg);
        for (k, name) in BAND_NAMES.into_iter().enumerate() {
            let hz = modes.get(k).copied().unwrap_or(f64::NAN);
            rows.push(row(MODE_IDS[0], 0, name, condition.clone(), hz, FREQUENCY_U * hz));
        }
    }
    for elevation_deg in super::ELEVATIONS_DEG {
        for (name, from_hz, to_hz) in
            [("coupling-to-10-hz", LOWEST_HZ, LOW_HZ), ("coupling-above-10-hz", LOW_HZ, HIGH_HZ)]
        {
            let ratio = coupling(subject, elevation_deg, from_hz, to_hz);
            let condition = format!("elevation {elevation_deg} deg");
            rows.push(row("STR-XAX", None, name, condition, ratio, COUPLING_U * ratio));
        }
    }
    rows
}

/// Natural frequencies at an elevation, ascending.
fn frequencies_hz(structure: &StructureSettings, elevation_deg: f64) -> Vec<f64> {
    let at = |mode: &ModeCurves| structure.interpolate(&mode.frequency_hz, elevation_deg * DEG);
    let mut found: Vec<f64> = structure.modes.iter().map(at).collect();
    found.sort_by(f64::total_cmp);
    found
}

/// Largest share of azimuth's rate at the frame that shows in elevation: what the modes leak, and what the gyros' lean
/// and misalignment mix in.
fn coupling(subject: &Subject<'_>, elevation_deg: f64, from_hz: f64, to_hz: f64) -> f64 {
    const POINTS: u32 = 400;
    let structure = subject.structure(0);
    let at = |values: &[f64]| structure.interpolate(values, elevation_deg * DEG);
    let inertia = subject.unit.az.inertia_kg_m2 / at(&structure.rigid_gain_ratio);
    let modes: Vec<[f64; 3]> = structure
        .modes
        .iter()
        .map(|m| [std::f64::consts::TAU * at(&m.frequency_hz), at(&m.damping_ratio), at(&m.gyro_per_kg_m2)])
        .collect();
    let unit = subject.unit;
    let leaked = unit.cross_coupling_ratio + unit.cross_coupling_growth_ratio * (elevation_deg * DEG).sin();
    let imu = &unit.imu;
    let mixed: f64 = imu.misalignment_rad.iter().chain(&imu.nonorthogonality_rad).map(|a| a * a).sum();
    let share = |k: u32| {
        let hz = from_hz * (to_hz / from_hz).powf(f64::from(k) / f64::from(POINTS));
        let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
        let modal: Complex64 = modes.iter().map(|[w, z, c]| c * s / (s * s + 2.0 * z * w * s + w * w)).sum();
        let rigid = 1.0 / (inertia * s);
        leaked * modal.norm() / (rigid + modal).norm() + mixed.sqrt()
    };
    (0..=POINTS).map(share).fold(0.0, f64::max)
}
