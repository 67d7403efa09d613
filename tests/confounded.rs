//! Two defects that hide each other from one measurement: what tells them apart.

use std::path::Path;

use crate::bench::{folder, measurements, run_in, verdict, write};

/// A friction procedure of one axis, the force gauge after it.
fn campaign(axis: &str) -> String {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures/quick");
    let gauge = shipped.join(format!("{axis}-torque-constant.toml"));
    format!(
        "schema = 1\nid = \"pair\"\ntitle = \"Friction, then the gauge\"\nrequirements = \"limit.toml\"\n\
         must-measure = [\"FRC\"]\n[[procedure]]\nfile = \"friction.toml\"\n[[procedure]]\nfile = \"{}\"\n",
        gauge.to_str().expect("a path of ours")
    )
}

fn friction(axis: &str) -> String {
    format!(
        "schema = 1\nid = \"FRICTION\"\ntitle = \"Friction\"\nkind = \"hysteresis\"\naxis = \"{axis}\"\n\
         log-rate = \"250 Hz\"\n[sweep]\nvelocity = [\"5 deg/s\", \"10 deg/s\"]\nspan = \"20 deg .. 60 deg\"\ncycles = 1\n"
    )
}

fn limit(axis: &str, at_most: &str) -> String {
    format!(
        "schema = 1\n[[requirement]]\nid = \"FRC\"\ntext = \"Friction.\"\nsource = \"ours\"\nmethod = \"test\"\n\
         measurand = [\"friction-torque\"]\naxis = \"{axis}\"\nlimit = \"<= {at_most}\"\n\
         where = {{ velocity = \"<= 10 deg/s\" }}\n"
    )
}

/// Largest friction up to 10 deg/s with its expanded uncertainty, by what the run found.
fn largest_friction(run: &Path) -> [f64; 2] {
    let friction = measurements(run).into_iter().filter(|m| m["measurand"] == "friction-torque");
    let values = friction.map(|m| [m["value"].as_f64().expect("a value"), 2.0 * m["u"].as_f64().expect("u")]);
    values.max_by(|a, b| a[0].total_cmp(&b[0])).expect("friction was measured")
}

/// Friction of an axis of the nominal unit.
struct Nominal {
    axis: &'static str,
    coulomb_nm: f64,
    static_nm: f64,
    stribeck_rad_per_s: f64,
    shape: f64,
    viscous_nm_s_per_rad: f64,
    constant_nm_per_a: f64,
}

const AZ: Nominal = Nominal {
    axis: "az",
    coulomb_nm: 167.75,
    static_nm: 210.0,
    stribeck_rad_per_s: 0.12,
    shape: 2.5,
    viscous_nm_s_per_rad: 273.6,
    constant_nm_per_a: 60.0,
};

const EL: Nominal = Nominal {
    axis: "el",
    coulomb_nm: 34.5,
    static_nm: 43.125,
    stribeck_rad_per_s: 0.012,
    shape: 0.85,
    viscous_nm_s_per_rad: 68.4,
    constant_nm_per_a: 52.0,
};

impl Nominal {
    /// Largest friction of the two velocities of [`friction`], N·m.
    fn largest_friction_nm(&self) -> f64 {
        let sliding = |deg_per_s: f64| {
            let rate = deg_per_s.to_radians();
            let dry = (-(rate / self.stribeck_rad_per_s).powf(self.shape)).exp();
            self.coulomb_nm + (self.static_nm - self.coulomb_nm) * dry + self.viscous_nm_s_per_rad * rate
        };
        sliding(5.0).max(sliding(10.0))
    }

    /// A unit with this axis' friction and torque constant multiplied.
    fn unit(&self, friction_ratio: f64, constant_ratio: f64) -> String {
        format!(
            "schema = 1\nid = \"pair\"\ntitle = \"A pair\"\nbase = \"nominal\"\nmust-flip = []\nreason = \"Drawn.\"\n\
             [{}]\ncoulomb-torque = \"{} N*m\"\nstatic-torque = \"{} N*m\"\nviscous-damping = \"{} N*m*s/rad\"\n\
             torque-constant = \"{} N*m/A\"\n",
            self.axis,
            friction_ratio * self.coulomb_nm,
            friction_ratio * self.static_nm,
            friction_ratio * self.viscous_nm_s_per_rad,
            constant_ratio * self.constant_nm_per_a
        )
    }
}

/// Breakaway of an axis at 3 A/s, upwards, with its standard uncertainty.
fn breakaway(axis: &str, unit: &str) -> [f64; 2] {
    let folder = folder();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures/quick");
    let file = |name: &str| format!("[[procedure]]\nfile = \"{}\"\n", shipped.join(name).display());
    let campaign = format!(
        "schema = 1\nid = \"pair\"\ntitle = \"Breakaway, then inertia\"\nrequirements = \"shipped:requirements.toml\"\n\
         must-measure = []\n{}{}{}",
        file(&format!("{axis}-breakaway.toml")),
        file(&format!("{axis}-torque-constant.toml")),
        file(&format!("{axis}-velocity-loop.toml"))
    );
    write(folder.path(), "unit.toml", unit);
    write(folder.path(), "pair.toml", &campaign);
    let words = ["run", "./pair.toml", "--unit", "unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &words);
    let mut all = measurements(&folder.path().join("run")).into_iter();
    let asked = |m: &serde_json::Value, name: &str, value: f64| {
        let conditions = m["conditions"].as_array().expect("conditions");
        conditions.iter().any(|c| c["name"] == name && c["requested"] == value)
    };
    let fast = |m: &serde_json::Value| {
        m["measurand"] == "breakaway-torque" && asked(m, "rate", 3.0) && asked(m, "direction", 1.0)
    };
    let found = all.find(fast).unwrap_or_else(|| panic!("{}{}", said.out, said.err));
    [found["value"].as_f64().expect("a value"), found["u"].as_f64().expect("u")]
}

/// A ramp of current accelerates the axis before it slides: what the inertia takes is no friction. With the rig's inertia
/// an azimuth axis 15 % heavier would seem to break away 12 N·m higher.
fn breaks_away_alike(nominal: &Nominal, inertia_kg_m2: f64, inertia_ratio: f64, largest_u_ratio: f64) {
    let unit = |inertia_ratio: f64, constant_ratio: f64| {
        format!(
            "schema = 1\nid = \"pair\"\ntitle = \"A pair\"\nbase = \"nominal\"\nmust-flip = []\nreason = \"Drawn.\"\n\
             [{}]\ninertia = \"{} kg*m^2\"\ntorque-constant = \"{} N*m/A\"\n",
            nominal.axis,
            inertia_ratio * inertia_kg_m2,
            constant_ratio * nominal.constant_nm_per_a
        )
    };
    let axis = nominal.axis;
    let [nominal_nm, nominal_u] = breakaway(axis, &unit(1.0, 1.0));
    let [found_nm, found_u] = breakaway(axis, &unit(inertia_ratio, 1.03));
    assert!(
        (found_nm - nominal_nm).abs() < 2.0 * found_u.hypot(nominal_u),
        "{axis}: {found_nm} ± {found_u} N·m, nominal {nominal_nm} ± {nominal_u} N·m"
    );
    assert!(found_u < largest_u_ratio * found_nm, "{axis}: {found_u} N·m: the inertia was measured");
}

#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn inertia_that_the_rig_file_does_not_know_is_measured_and_leaves_the_breakaway_as_it_is() {
    breaks_away_alike(&AZ, 1200.0, 1.15, 0.015);
    // Elevation breaks away at 60 deg, and its inertia was measured at 0 deg.
    breaks_away_alike(&EL, 975.0, 0.85, 0.04);
}

/// Runs friction and then the gauge on a unit, and compares with the truth.
fn told_apart(nominal: &Nominal, limit_nm: &str, friction_ratio: f64, constant_ratio: f64, expected: &str) {
    let folder = folder();
    write(folder.path(), "unit.toml", &nominal.unit(friction_ratio, constant_ratio));
    write(folder.path(), "friction.toml", &friction(nominal.axis));
    write(folder.path(), "limit.toml", &limit(nominal.axis, limit_nm));
    write(folder.path(), "pair.toml", &campaign(nominal.axis));
    let words = ["run", "./pair.toml", "--unit", "unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &words);
    let run = folder.path().join("run");
    let [found_nm, expanded_nm] = largest_friction(&run);
    let truth_nm = friction_ratio * nominal.largest_friction_nm();
    let ratios = format!("{}: friction x {friction_ratio}, constant x {constant_ratio}", nominal.axis);
    assert!(
        (found_nm - truth_nm).abs() < expanded_nm,
        "{ratios}: {found_nm} ± {expanded_nm} N·m, truth {truth_nm}\n{}{}",
        said.out,
        said.err
    );
    assert!(expanded_nm < 0.01 * truth_nm, "the gauge knows it to 1 %: {expanded_nm}");
    assert_eq!(verdict(&run, "FRC"), expected, "{ratios}\n{}", said.out);
    let again = run_in(folder.path(), &["rejudge", "run"]);
    assert_eq!(again.code, said.code, "{}{}", again.out, again.err);
}

/// Friction shows as current, and a motor with more torque per ampere needs less of it.
#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn friction_that_a_strong_motor_hides_fails_by_the_gauge_though_it_was_measured_before() {
    told_apart(&AZ, "260 N*m", 1.25, 1.19, "fail");
    told_apart(&AZ, "260 N*m", 1.22, 1.045, "fail");
    told_apart(&EL, "52 N*m", 1.25, 1.19, "fail");
}

#[test]
#[ignore = "takes the better part of a minute; `.ci/run` runs it after the others"]
fn friction_that_a_weak_motor_makes_look_large_does_not_fail_and_passes_nothing_either() {
    told_apart(&AZ, "260 N*m", 1.0, 0.82, "inconclusive");
    told_apart(&EL, "52 N*m", 1.0, 0.82, "inconclusive");
}

/// A run of these procedures of `quick` on a unit that differs from the nominal one by these lines; its folder stays with it.
fn quick_look(lines: &str, procedures: &[&str]) -> tempfile::TempDir {
    retuned_look(lines, &str::to_owned, procedures)
}

/// A text with other words in the place of some that it must have.
fn replaced(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "there is no `{old}`");
    text.replace(old, new)
}

/// The same, with gains of the controllers that were changed.
fn retuned_look(lines: &str, retune: &dyn Fn(&str) -> String, procedures: &[&str]) -> tempfile::TempDir {
    let folder = folder();
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(workspace.join(path)).expect("a file of ours");
    write(folder.path(), "gains.toml", &retune(&read("controllers/params/director.toml")));
    let rig = read("bench/rigs/sim.toml");
    write(folder.path(), "rig.toml", &replaced(&rig, "\"director\"", "\"./gains.toml\""));
    let shipped = workspace.join("procedures/quick");
    let file = |name: &&str| format!("[[procedure]]\nfile = \"{}\"\n", shipped.join(name).display());
    let files: String = procedures.iter().map(file).collect();
    let campaign = format!(
        "schema = 1\nid = \"pair\"\ntitle = \"A pair\"\nrequirements = \"shipped:requirements.toml\"\nmust-measure = []\n{files}"
    );
    let unit = format!(
        "schema = 1\nid = \"pair\"\ntitle = \"A pair\"\nbase = \"nominal\"\nmust-flip = []\nreason = \"Drawn.\"\n{lines}"
    );
    write(folder.path(), "unit.toml", &unit);
    write(folder.path(), "pair.toml", &campaign);
    let words = [
        "run",
        "./pair.toml",
        "--rig",
        "./rig.toml",
        "--unit",
        "unit.toml",
        "--out",
        "run",
        "--non-interactive",
    ];
    let said = run_in(folder.path(), &words);
    assert!(folder.path().join("run/results.json").exists(), "{}{}", said.out, said.err);
    folder
}

/// Value and standard uncertainty of every measurement of this name and axis.
fn found(run: &Path, measurand: &str, axis: &str) -> Vec<[f64; 2]> {
    let all = measurements(run).into_iter();
    all.filter(|m| m["measurand"] == measurand && m["axis"] == axis)
        .filter_map(|m| Some([m["value"].as_f64()?, m["u"].as_f64()?]))
        .collect()
}

/// Gyros and encoder of an axis that are off by the same share agree with each other: whoever compares them sees nothing. An
/// external reference does. Where the axis turns, the slope of an eccentricity of so many urad is as many ppm.
fn caught_by_the_autocollimator(axis: &str, eccentricity_urad: f64, phase: &str) {
    let gyro = |name: &str, share: f64| {
        format!("gyro-scale-error-{name} = \"{} ppm\"\n", -share * eccentricity_urad)
    };
    let unit = format!(
        "[{axis}]\nencoder-eccentricity = \"{eccentricity_urad} urad\"\nencoder-eccentricity-phase = \"{phase}\"\n\
         [imu]\n{}{}{}",
        gyro("x", 0.875),
        gyro("y", 1.1),
        gyro("z", 0.925)
    );
    let folder = quick_look(&unit, &["imu-consistency.toml", &format!("{axis}-accuracy.toml")]);
    let run = folder.path().join("run");
    let scales = found(&run, "gyro-scale-error", axis);
    let hidden = 0.25e-6 * eccentricity_urad;
    assert!(!scales.is_empty() && scales.iter().all(|[value, _]| value.abs() < hidden), "{axis}: {scales:?}");
    let accuracy = found(&run, "positioning-accuracy", axis);
    assert!(!accuracy.is_empty() && accuracy.iter().all(|[value, _]| *value > 75e-6), "{axis}: {accuracy:?}");
    assert_eq!(verdict(&run, "POS-ACC"), "fail", "{axis}");
}

#[test]
fn gyros_and_encoder_that_are_wrong_alike_are_caught_by_the_autocollimator() {
    // More would be beyond the autocollimator's range at ± 80 deg.
    caught_by_the_autocollimator("az", 200.0, "180 deg");
    caught_by_the_autocollimator("el", 400.0, "140 deg");
}

/// What goes later to the drive and comes earlier back is the same for every loop, and for LAT-RT.
#[test]
fn delays_that_make_up_for_each_other_leave_the_round_trip_as_it_is() {
    let at = |out_ms: f64, back_ms: f64| {
        let unit = format!("[az]\ncommand-delay = \"{out_ms} ms\"\nsensor-delay = \"{back_ms} ms\"\n");
        let folder = quick_look(&unit, &["az-latency.toml"]);
        let [[value, u]] = found(&folder.path().join("run"), "transport-round-trip", "az")[..] else {
            panic!("one round trip is measured")
        };
        [value, u]
    };
    let [even_s, even_u] = at(0.85, 1.25);
    let [odd_s, odd_u] = at(1.25, 0.85);
    assert!((even_s - odd_s).abs() < 2.0 * even_u.hypot(odd_u), "{even_s} ± {even_u}, {odd_s} ± {odd_u} s");
}

/// A camera that shows too little beside a track loop that is as much too fast: the bandwidth is that of the nominal unit, the
/// scale is not.
#[test]
fn a_coarse_camera_whose_scale_hides_in_the_loop_gain_is_told_by_the_encoder() {
    let faster = |gains: &str| {
        // By 1.06, the scale of the nominal camera, over 0.9.
        let az = replaced(gains, "track-gain = \"4.95 1/s\"", "track-gain = \"5.83 1/s\"");
        replaced(&az, "track-gain = \"5.51 1/s\"", "track-gain = \"6.49 1/s\"")
    };
    let folder = retuned_look(
        "[trackers]\ncoarse-scale = \"0.9\"\n",
        &faster,
        &["az-coarse-latency.toml", "el-coarse-latency.toml", "az-track-loop.toml", "el-track-loop.toml"],
    );
    let run = folder.path().join("run");
    for axis in ["az", "el"] {
        let [[bandwidth_hz, _]] = found(&run, "track-bandwidth", axis)[..] else {
            panic!("one bandwidth is measured")
        };
        assert!(bandwidth_hz > 1.05, "{axis}: {bandwidth_hz} Hz, at least 1 Hz are asked: nothing shows");
        let [[value, u]] = found(&run, "tracker-scale-error", axis)[..] else {
            panic!("one scale is measured")
        };
        assert!((value + 0.1).abs() < 2.0 * u && u < 0.01, "{axis}: {value} ± {u}");
    }
    assert_eq!(verdict(&run, "TRK-SCALE"), "fail");
}

/// A camera whose frames come late beside a track loop whose lead makes up for it: latency is measured by the light, not by the
/// loop.
#[test]
fn a_coarse_camera_whose_latency_hides_behind_the_lead_of_the_loop_is_told_by_its_frames() {
    let leading =
        |gains: &str| replaced(gains, "track-gyro-lead = \"2.25 ms\"", "track-gyro-lead = \"12.25 ms\"");
    let folder = retuned_look(
        "[trackers]\ncoarse-latency = \"50 ms\"\n",
        &leading,
        &["az-coarse-latency.toml", "el-coarse-latency.toml"],
    );
    let run = folder.path().join("run");
    for axis in ["az", "el"] {
        let latencies = found(&run, "tracker-latency", axis);
        let is_told = |[value, u]: &[f64; 2]| (value - 0.05).abs() < 2.0 * u && *u < 2.5e-3;
        assert!(!latencies.is_empty() && latencies.iter().all(is_told), "{axis}: {latencies:?}");
    }
    assert_eq!(verdict(&run, "LAT-TRK"), "fail");
}
