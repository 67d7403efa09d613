//! A made-up result with every verdict, status and style of picture: what the tests and the example render.
//!
//! The numbers are typical of a friction test, the verdicts were worked out by hand.

use procedures::measurement::{Condition, Estimate, Evidence, Exclusion, Measurement};
use procedures::quantity::QuantityKind;
use procedures::verdict::{Judgement, Outcome, Overall, Verdict};
use reports::record::{
    Attempt, CampaignFindings, DeviceRecord, FileHash, Findings, Origin, PointRow, ProcedureFindings,
    PromptRecord, Results, RunRecord, Status, WaiverRecord,
};

mod demands;
mod pictures;
pub(crate) mod responses;
mod safety;
pub(crate) mod tracking;

const METHOD: &str = "# What it finds\nFriction torque as half the difference of the two branches.\n\n\
    # How it excites\nConstant velocity back and forth between the same limits, velocities ascending.\n\n\
    # How it computes\n- effort is `Kt*i - J*alpha`\n- plateau only, whole cogging periods\n\n\
    # Fails when\nThe plateau holds less than one cogging period, or variance inflation exceeds 30.\n\n\
    # Source\nArmstrong-Hélouvry, Dupont, Canudas de Wit (1994).";

/// The result.
pub(crate) fn results() -> Results {
    let procedures = vec![azimuth(), elevation()];
    let outcomes = demands::all()
        .iter()
        .map(|r| {
            let decided_by = procedures
                .iter()
                .flat_map(|p| p.judgements.iter().map(move |j| (p.id.clone(), j.clone())))
                .filter(|(_, j)| j.requirement == r.id)
                .max_by_key(|(_, j)| j.verdict);
            let judged =
                procedures.iter().flat_map(|p| &p.judgements).filter(|j| j.requirement == r.id).count();
            let verdict = decided_by.as_ref().map_or(Verdict::None, |(_, j)| j.verdict);
            Outcome {
                requirement: r.id.clone(),
                verdict,
                before_coverage: verdict,
                decided_by,
                by_measurand: Vec::new(),
                judged,
                required: r.required,
                reason: None,
            }
        })
        .collect();
    let findings = Findings {
        campaign: CampaignFindings {
            left_out: Vec::new(),
            id: "quick".to_owned(),
            title: "Friction and breakaway, every kind once".to_owned(),
            partial: false,
            sha256: Some("5d".repeat(32)),
            requirements_sha256: Some("9f".repeat(32)),
        },
        unit: "azimuth-retainer".to_owned(),
        origin: Origin::Simulated,
        seed: 1,
        overall: Overall::Fail,
        requirements: demands::all(),
        outcomes,
        not_in_this_campaign: vec!["POS-ACC".to_owned()],
        no_kind_measures_it_yet: vec!["FSM-BW".to_owned(), "STR-XAX".to_owned()],
        disagreements: Vec::new(),
        not_enforced: safety::not_enforced(),
        procedures,
    };
    Results::new(findings, record())
}

/// The result with one more procedure, which has a figure of every kind that frequency responses need.
pub(crate) fn with_responses() -> Results {
    let mut results = results();
    results.findings.procedures.push(response());
    results
}

fn response() -> ProcedureFindings {
    let mut plots = responses::bode();
    plots.push(responses::nyquist());
    plots.extend(responses::margins());
    plots.push(responses::modes());
    plots.extend(responses::impedance());
    plots.push(responses::latency());
    plots.extend(tracking::errors());
    plots.extend([tracking::histogram(), tracking::spectrum(), tracking::approaches()]);
    ProcedureFindings {
        id: "EL-RESPONSE".to_owned(),
        title: "Frequency responses, elevation".to_owned(),
        kind: "frequency-response".to_owned(),
        axis: "el".to_owned(),
        method: METHOD.to_owned(),
        status: Status::Completed,
        plots,
        ..ProcedureFindings::default()
    }
}

fn azimuth() -> ProcedureFindings {
    let mut measurements: Vec<Measurement> =
        [(2.0, 419.31, 2.13), (10.0, 529.874, 2.61), (60.0, 1280.2, 6.8)]
            .into_iter()
            .map(|(velocity, torque, u)| {
                let mut m = number("friction-torque", "az", QuantityKind::Torque, torque, u, 14.2);
                at_velocity(&mut m, velocity);
                m.flags = vec!["variance inflation 14.2".to_owned()];
                m.excluded = vec![left_out(412, "samples", "turn-round: outside the plateau")];
                m
            })
            .collect();
    measurements.push(number("cogging-order", "az", QuantityKind::SpatialOrder, 144.0, 0.031, 58.0));
    measurements.push(number("spring-torque", "az", QuantityKind::Torque, 1.7, 0.82, f64::INFINITY));
    let judgements = vec![
        judged("FRC-AZ", 0, &measurements[0], 2.19, [None, Some(260.0)], Verdict::Fail, 1.0),
        judged("FRC-AZ", 1, &measurements[1], 2.19, [None, Some(260.0)], Verdict::Fail, 1.0),
        judged("COG-AZ", 3, &measurements[3], 2.03, [Some(143.5), Some(144.5)], Verdict::Pass, 1e-12),
        judged("SPR-AZ", 4, &measurements[4], 2.0, [None, Some(5.0)], Verdict::Pass, 2.8e-5),
    ];
    let done = Status::Completed;
    let mut points: Vec<PointRow> = ["velocity=2 deg/s", "velocity=10 deg/s", "velocity=60 deg/s"]
        .iter()
        .map(|p| PointRow::collect(p, done, Vec::new(), None, &measurements, &judgements))
        .collect();
    let trip = "following error: az: following error 1.310 deg, limit 1.000 deg".to_owned();
    points.push(PointRow::collect("velocity=80 deg/s", Status::Aborted, vec![], Some(trip), &[], &[]));
    ProcedureFindings {
        id: "AZ-FRICTION".to_owned(),
        title: "Friction hysteresis, azimuth".to_owned(),
        kind: "hysteresis".to_owned(),
        axis: "az".to_owned(),
        method: METHOD.to_owned(),
        status: Status::Completed,
        verdict: Verdict::Fail,
        log: Some("AZ-FRICTION.mcap".to_owned()),
        log_sha256: None,
        points,
        measurements,
        judgements,
        plots: vec![pictures::loops(), pictures::friction(), pictures::spectrum()],
        remarks: vec!["T_S, ω_s and δ not determined: five velocities carry T_C and σ2 only.".to_owned()],
        safety: Some(safety::azimuth()),
        ..ProcedureFindings::default()
    }
}

fn elevation() -> ProcedureFindings {
    let mut unbalance = number("unbalance-torque", "el", QuantityKind::Torque, 64.2, 0.71, 9.0);
    unbalance.conditions = vec![condition("velocity", QuantityKind::AngularVelocity, 10.0, Some(9.997))];
    let reason = "loose after the ramp: displacement never passed 8 z_ss";
    let mut hold =
        Measurement::inconclusive("holding-margin", "el", QuantityKind::Torque, "breakaway-peak/2", reason);
    hold.point = Some("pose=40 deg".to_owned());
    hold.conditions = vec![condition("pose", QuantityKind::Angle, 40.0, None)];
    let breakaway = number("breakaway-torque", "el", QuantityKind::Torque, 101.44, 1.31, 6.0);
    let measurements = vec![unbalance, hold, breakaway];
    let mut undecided =
        judged("HOLD-EL", 1, &measurements[1], 0.0, [Some(0.0), None], Verdict::Inconclusive, 0.0);
    undecided.reason = Some(reason.to_owned());
    undecided.probability_outside = None;
    let mut conditional =
        judged("UNB-EL", 0, &measurements[0], 2.32, [None, Some(65.0)], Verdict::ConditionalPass, 0.145);
    conditional.goal_met = Some(false);
    let judgements = vec![
        conditional,
        undecided,
        judged("FRC-EL", 2, &measurements[2], 2.52, [None, Some(130.0)], Verdict::Pass, 1.6e-7),
    ];
    let left = vec![left_out(1, "ramps", "operator stop")];
    let points =
        vec![PointRow::collect("pose=40 deg", Status::Completed, left, None, &measurements, &judgements)];
    ProcedureFindings {
        id: "EL-BREAKAWAY".to_owned(),
        title: "Breakaway and holding, elevation".to_owned(),
        kind: "breakaway".to_owned(),
        axis: "el".to_owned(),
        method: METHOD.to_owned(),
        status: Status::Completed,
        verdict: Verdict::Inconclusive,
        log: Some("EL-BREAKAWAY.mcap".to_owned()),
        log_sha256: None,
        points,
        measurements,
        judgements,
        plots: vec![pictures::ramp()],
        safety: Some(safety::elevation()),
        ..ProcedureFindings::default()
    }
}

fn number(name: &str, axis: &str, kind: QuantityKind, value: f64, u: f64, dof: f64) -> Measurement {
    let estimate = Some(Estimate { value, u, dof, n: 18 });
    let mut m = Measurement::new(name, axis, kind, estimate, "hysteresis-friction/1");
    m.evidence = vec![Evidence {
        file: "AZ-FRICTION.mcap".to_owned(),
        channels: vec![format!("/{axis} position_rad"), format!("/{axis} current_a")],
        t0_s: 12.5,
        t1_s: 48.25,
    }];
    m
}

fn condition(name: &str, kind: QuantityKind, deg: f64, achieved_deg: Option<f64>) -> Condition {
    Condition {
        name: name.to_owned(),
        requested: deg.to_radians(),
        achieved: achieved_deg.map(f64::to_radians),
        kind,
    }
}

fn at_velocity(m: &mut Measurement, deg_per_s: f64) {
    m.point = Some(format!("velocity={deg_per_s} deg/s"));
    m.conditions =
        vec![condition("velocity", QuantityKind::AngularVelocity, deg_per_s, Some(deg_per_s * 0.9998))];
}

fn left_out(count: usize, of: &str, reason: &str) -> Exclusion {
    Exclusion { count, of: of.to_owned(), reason: reason.to_owned() }
}

/// A judgement by the rule w = U.
fn judged(
    id: &str,
    measurement: usize,
    m: &Measurement,
    k: f64,
    limits: [Option<f64>; 2],
    verdict: Verdict,
    probability_outside: f64,
) -> Judgement {
    let u = k * m.u;
    let margin = |value: f64| {
        let below = limits[0].map_or(f64::INFINITY, |low| value - low);
        below.min(limits[1].map_or(f64::INFINITY, |high| high - value))
    };
    Judgement {
        requirement: id.to_owned(),
        measurement,
        k,
        expanded_u: u,
        guard_band: u,
        acceptance: [limits[0].map(|l| l + u), limits[1].map(|l| l - u)],
        margin: m.value.map(margin),
        probability_outside: Some(probability_outside),
        verdict,
        limit: None,
        band: None,
        goal_met: None,
        reason: None,
    }
}

fn record() -> RunRecord {
    let file = |name: &str, size_bytes, digest: &str| FileHash {
        file: name.to_owned(),
        size_bytes,
        sha256: digest.repeat(32),
    };
    RunRecord {
        operator: Some("A. Tester".to_owned()),
        serial_number: Some("SIM-0001".to_owned()),
        rig: Some("sim".to_owned()),
        started_utc: Some("2026-11-21T15:00:00Z".to_owned()),
        ended_utc: Some("2026-11-21T15:00:14Z".to_owned()),
        wall_s: 14.2,
        simulated_s: 872.5,
        cpu_s: 16.05,
        speed_factor: Some(54.4),
        jobs: 2,
        command_line: "bench run quick --unit azimuth-retainer --seed 1".to_owned(),
        software_version: "0.1.0".to_owned(),
        git_commit: Some("0123abcd".to_owned()),
        numeric_profile: Some("x86_64-unknown-linux-gnu, avx2, fma".to_owned()),
        devices: vec![DeviceRecord {
            name: "az-drive".to_owned(),
            identity: "SIM servo drive, serial number SIM-AZ-1, firmware 1.0".to_owned(),
            may_be_real: false,
            proven_real: false,
            grounds: "identity carries the simulator's mark".to_owned(),
        }],
        attempts: vec![Attempt {
            procedure: "AZ-FRICTION".to_owned(),
            attempt: 1,
            file: "AZ-FRICTION.mcap".to_owned(),
            status: Status::Completed,
            reason: None,
            planned_s: Some(402.0),
            ran_s: Some(449.5),
        }],
        prompts: vec![PromptRecord {
            asked_by: "EL-BREAKAWAY".to_owned(),
            id: "elevation-free".to_owned(),
            class: "safety".to_owned(),
            text: "Is elevation free of clamps, and nobody near it?".to_owned(),
            answer: "yes".to_owned(),
            by: "A. Tester".to_owned(),
            how: "terminal".to_owned(),
            utc: "2026-11-21T15:00:02Z".to_owned(),
        }],
        waivers: vec![waiver()],
        files: vec![
            file("AZ-FRICTION.mcap", 48_211_034, "0a"),
            file("EL-BREAKAWAY.mcap", 7_310_556, "0b"),
            file("journal.jsonl", 9_120, "0c"),
        ],
        ..RunRecord::default()
    }
}

fn waiver() -> WaiverRecord {
    WaiverRecord {
        requirement: "FRC-AZ".to_owned(),
        number: "W-17".to_owned(),
        approver: "B. Customer".to_owned(),
        expiry: "2026-12-31".to_owned(),
        reason: "The retainer of azimuth is exchanged before the site test.".to_owned(),
    }
}
