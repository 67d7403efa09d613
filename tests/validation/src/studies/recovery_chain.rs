//! The whole chain against the unit's own parameters: simulated director → drive protocol → loop → log → judge.
//!
//! Runs a campaign over several seeds and prints, for each measurand that has a true value in the unit's settings,
//! the true value, mean error, rms error and coverage of the expanded uncertainty.
//!
//! `cargo run --release -p validation -- recovery_chain [CAMPAIGN] [SEEDS]`

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use sim_devices::unit::{AxisSettings, UnitSettings};

/// What was measured over the seeds: value and expanded uncertainty.
type Samples = BTreeMap<(String, String), Vec<(f64, f64)>>;

pub(crate) fn study() {
    let mut arguments = crate::arguments();
    let campaign = arguments.next().unwrap_or_else(|| "quick".to_owned());
    let seeds: u64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(10);
    let folder = std::env::temp_dir().join(format!("recovery-chain-{}", std::process::id()));
    let mut samples = Samples::new();
    for seed in 1..=seeds {
        let run = folder.join(seed.to_string());
        let status = Command::new("cargo")
            .args(["run", "--quiet", "--release", "--", "run", &campaign, "--non-interactive"])
            .args(["--seed", &seed.to_string(), "--out"])
            .arg(&run)
            .status();
        assert!(status.is_ok_and(|s| matches!(s.code(), Some(0 | 1 | 3))), "the campaign runs");
        collect(&run, &mut samples);
        let _ = std::fs::remove_dir_all(&run);
    }
    print(&samples);
}

fn collect(run: &Path, samples: &mut Samples) {
    let text = std::fs::read_to_string(run.join("results.json")).expect("results of a finished run");
    let results = reports::json::parse(&text).expect("results of this program");
    for procedure in &results.findings.procedures {
        for m in &procedure.measurements {
            let Some(value) = m.value else { continue };
            let expanded_u = 2.0 * m.u;
            samples.entry((m.axis.clone(), m.measurand.clone())).or_default().push((value, expanded_u));
        }
    }
}

fn truth(axis: &AxisSettings, measurand: &str) -> Option<f64> {
    Some(match measurand {
        "coulomb-torque" => axis.coulomb_torque_nm,
        "viscous-coefficient" => axis.viscous_damping_nm_s_per_rad,
        "bristle-stiffness" => axis.bristle_stiffness_nm_per_rad,
        "presliding-damping" => axis.bristle_damping_nm_s_per_rad + axis.viscous_damping_nm_s_per_rad,
        "unbalance-torque" => axis.unbalance_nm,
        "spring-stiffness" => axis.spring_stiffness_nm_per_rad,
        "cogging-amplitude" => axis.cogging_amplitude_nm,
        "cogging-order" => axis.cogging_orders_per_rev,
        _ => return None,
    })
}

fn print(samples: &Samples) {
    let unit = UnitSettings::default();
    println!("axis  measurand               truth        mean error   rms error    covered  n");
    for ((axis, measurand), values) in samples {
        let settings = if axis == "az" { &unit.az } else { &unit.el };
        let Some(truth) = truth(settings, measurand) else { continue };
        let n = values.len() as f64;
        let mean = values.iter().map(|(v, _)| v - truth).sum::<f64>() / n;
        let rms = (values.iter().map(|(v, _)| (v - truth).powi(2)).sum::<f64>() / n).sqrt();
        let covered = values.iter().filter(|(v, u)| (v - truth).abs() <= *u).count();
        println!("{axis:<5} {measurand:<22} {truth:>10.3} {mean:>13.4} {rms:>11.4} {covered:>8}/{n}");
    }
}
