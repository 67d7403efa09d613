//! External velocity laws: equality with the built-in law, and what a library is refused for.

use std::path::Path;

use controllers::AxisGains;
use controllers::velocity::VelocityController;
use external_law::rows::{LawInput, LawSetup};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use validation::compiled;

use crate::bench::{content, folder, run_in, write};

const PERIOD_S: f64 = 2.5e-4;
const LIMIT_NM: f64 = 1882.0;

/// Largest difference of a library's torques from those of the built-in law, over random inputs that saturate it, break
/// off, and are taken over anew.
fn largest_difference_nm(library: &Path) -> f64 {
    let gains = AxisGains {
        velocity_kp_nm_s_per_rad: 23_600.0,
        velocity_ki_nm_per_rad: 447_500.0,
        ..AxisGains::default()
    };
    let mut built_in = VelocityController::new(&gains, LIMIT_NM, PERIOD_S);
    let setup = LawSetup { period_s: PERIOD_S, torque_limit_nm: LIMIT_NM, ..LawSetup::default() };
    let library = compiled::loaded(library);
    let mut law = library.create(&setup, &[23_600.0, 447_500.0]).expect("an instance");
    let mut random = ChaCha8Rng::seed_from_u64(24);
    let mut uniform = |most: f64| most * (f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0);
    let (mut largest_nm, mut sent_nm, mut limited) = (0.0_f64, 0.0, 0_u32);
    for step in 0..200_000_u32 {
        let scale = if step % 5000 < 500 { 1.0 } else { 0.02 };
        let mut input = LawInput {
            reference_rad_per_s: uniform(scale),
            rate_rad_per_s: uniform(scale),
            feed_forward_nm: uniform(100.0),
            sent_nm,
            ..LawInput::default()
        };
        if step % 997 == 3 {
            input.rate_rad_per_s = f64::NAN;
        }
        if step % 1009 == 0 {
            input.take_over = 1.0;
            law.step(&input);
            built_in.take_over(
                sent_nm,
                input.reference_rad_per_s,
                input.rate_rad_per_s,
                input.feed_forward_nm,
            );
            continue;
        }
        let expected_nm =
            built_in.update(input.reference_rad_per_s, input.rate_rad_per_s, input.feed_forward_nm);
        let output = law.step(&input);
        assert_eq!((output.saturated != 0.0, output.fault), (built_in.is_saturated(), 0.0), "step {step}");
        limited += u32::from(built_in.is_saturated());
        largest_nm = largest_nm.max((output.torque_nm - expected_nm).abs());
        sent_nm = expected_nm;
    }
    assert!((1000..150_000).contains(&limited), "both regions are covered: {limited} steps were limited");
    largest_nm
}

#[test]
fn the_examples_in_c_and_rust_equal_the_built_in_law_over_random_inputs() {
    let folder = folder();
    for library in [compiled::c_example(folder.path()), compiled::rust_example(folder.path())] {
        let difference_nm = largest_difference_nm(&library);
        assert!(difference_nm <= 1e-12 * LIMIT_NM, "{}: {difference_nm} N·m", library.display());
    }
}

const PROCEDURE: &str = "schema = 1\nid = \"AZ-SHORT\"\ntitle = \"Steps\"\nkind = \"step\"\naxis = \"az\"\n\
                         log-rate = \"500 Hz\"\nelevation = [\"20 deg\"]\nstep = [\"0.5 deg\"]\nrepeats = 3\n";

/// Runs the procedure with these further arguments; the exit code.
fn ran(folder: &Path, out: &str, arguments: &[&str]) -> i32 {
    let all = [&["run", "./short.toml", "--out", out, "--non-interactive"], arguments].concat();
    let said = run_in(folder, &all);
    assert!([0, 3].contains(&said.code), "exit {}\n{}\n{}", said.code, said.out, said.err);
    said.code
}

fn json(folder: &Path, file: &str) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join(file)).expect("a file of the run");
    serde_json::from_str(&text).expect("JSON")
}

/// The rows and events of a log: everything but its attachments.
fn rows(folder: &Path, out: &str) -> Vec<(String, u64, Vec<u8>)> {
    let all = content(&folder.join(out).join("AZ-SHORT.mcap"));
    all.into_iter().filter(|(name, _, _)| name.starts_with('/')).collect()
}

#[test]
fn a_procedure_with_the_example_has_rows_and_findings_of_the_built_in_law_and_its_record_names_the_library() {
    let folder = folder();
    let at = folder.path();
    write(at, "short.toml", PROCEDURE);
    let library = compiled::c_example(at);
    let digest = compiled::digest(&library);
    let asked = format!("az={}@{digest}", library.display());
    let code = ran(at, "built-in", &[]);
    for (out, arguments) in
        [("external", &["--law", &asked][..]), ("hosted", &["--law", &asked, "--host-laws"])]
    {
        assert_eq!(ran(at, out, arguments), code);
        let found = rows(at, out);
        assert!(found.len() > 1000 && found == rows(at, "built-in"), "{out}: rows differ");
        let [before, after] = ["built-in", out].map(|out| json(at, &format!("{out}/results.json")));
        assert_eq!(before["findings"], after["findings"], "{out}");
        for record in [&json(at, &format!("{out}/run.json")), &after["record"]] {
            let law = &record["laws"][0];
            let words =
                ["axis", "name", "version", "sha256"].map(|key| law[key].as_str().unwrap_or_default());
            assert_eq!(words, ["az", "velocity-pi", "1.0", &digest], "{out}: {record}");
        }
        let report = std::fs::read_to_string(at.join(out).join("report.html")).expect("a report");
        assert!(report.contains(&digest), "{out}: the report names the library");
        let attached = content(&at.join(out).join("AZ-SHORT.mcap"));
        let laws =
            attached.iter().find(|(name, _, _)| name == "laws.json").expect("the log names the library");
        assert!(String::from_utf8_lossy(&laws.2).contains(&digest));
    }
}

/// What `run` says to a law; it must be a mistake (exit 2), and nothing may have been written.
fn refused(folder: &Path, asked: &str) -> String {
    refused_with(folder, asked, &[])
}

/// The same with further arguments.
fn refused_with(folder: &Path, asked: &str, arguments: &[&str]) -> String {
    let all = [&["run", "./short.toml", "--out", "refused", "--law", asked], arguments].concat();
    let said = run_in(folder, &all);
    assert_eq!(said.code, 2, "{asked}: {}\n{}", said.out, said.err);
    assert!(!folder.join("refused/journal.jsonl").exists(), "{asked}: a run was begun");
    said.err
}

#[test]
fn a_library_of_another_digest_version_or_layout_is_refused_before_motion() {
    let folder = folder();
    let at = folder.path();
    write(at, "short.toml", PROCEDURE);
    let example = "#include \"velocity_pi.c\"\n";
    let with = |from: &str, to: &str| {
        let source = std::fs::read_to_string(
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../controllers/abi/examples/velocity_pi.c"),
        )
        .expect("the example");
        assert!(source.contains(from), "{from}");
        source.replace(from, to)
    };
    let cases = [
        (
            "version",
            with(".abi_version = BENCH_LAW_ABI_VERSION", ".abi_version = 2"),
            "expected version 1 of the interface, found 2",
        ),
        (
            "layout",
            with(".input_bytes = sizeof(bench_law_input)", ".input_bytes = 56"),
            "bench_law_input: expected 48 bytes, found 56",
        ),
        (
            "symbol",
            "#define bench_law_step other\n".to_owned() + example,
            "exports no function `bench_law_step`",
        ),
        (
            "unit",
            with("\"N*m/rad\"", "\"N*m/deg\""),
            "parameter `velocity-ki`: expected unit `N*m/rad`, found `N*m/deg`",
        ),
        (
            "parameter",
            with("\"velocity-ki\"", "\"velocity-kd\""),
            "parameter `velocity-kd`: expected a key of an axis in the parameter file or a default value",
        ),
    ];
    for (name, text, expected) in cases {
        let library = compiled::c(at, name, &text);
        let said = refused(at, &format!("az={name}.so@{}", compiled::digest(&library)));
        assert!(said.contains(expected) && said.contains(&format!("{name}.so")), "{name}: {said}");
    }
    let library = compiled::c_example(at);
    let digest = compiled::digest(&library);
    let other = "0".repeat(64);
    let said = refused(at, &format!("az=velocity_pi.so@{other}"));
    assert!(said.contains(&format!("expected SHA-256 {other}, found {digest}")), "{said}");
    let wired = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("rigs/wired.toml"))
        .expect("a shipped rig");
    write(at, "real.toml", &wired.replace("tier = \"wired\"", "tier = \"hardware\""));
    let on_axes = ["run", "wired", "--rig", "./real.toml", "--law", &format!("az=velocity_pi.so@{digest}")];
    let real = run_in(at, &on_axes);
    assert!(
        real.code == 2 && real.err.contains("external laws are not released for them yet"),
        "{}",
        real.err
    );
    let said = refused(at, &format!("ax=velocity_pi.so@{digest}"));
    assert!(said.contains("has no axis `ax`; expected az, el"), "{said}");
    let said = refused(at, &format!("az=missing.so@{digest}"));
    assert!(said.contains("missing.so: cannot be read"), "{said}");
    let text = write(at, "text.so", "no library");
    let said = refused(at, &format!("az=text.so@{}", compiled::digest(&text)));
    assert!(said.contains("text.so: cannot be loaded"), "{said}");
}

#[test]
fn a_library_that_needs_another_library_is_refused_because_its_digest_does_not_cover_that() {
    let folder = folder();
    let at = folder.path();
    write(at, "short.toml", PROCEDURE);
    compiled::c(at, "libgains", "double gain(void) { return 1.0; }\n");
    let text = "#include \"velocity_pi.c\"\ndouble gain(void);\ndouble used(void) { return gain(); }\n";
    let library = compiled::c_linked(at, "needy", text, &["-L.", "-lgains"]);
    let said = refused(at, &format!("az=needy.so@{}", compiled::digest(&library)));
    assert!(said.contains("needy.so: needs `libgains.so`, which its SHA-256 does not cover"), "{said}");
}

#[test]
fn a_library_that_crashes_or_hangs_while_it_is_loaded_in_its_own_process_is_named_and_does_not_take_bench_along()
 {
    let folder = folder();
    let at = folder.path();
    write(at, "short.toml", PROCEDURE);
    for (name, does, expected) in [
        ("crashes", "abort();", "crashes.so: its process ended before it had described the law"),
        ("hangs", "for (;;) sleep(1);", "hangs.so: its process has not described the law within 10 s"),
    ] {
        let text = format!(
            "#include \"velocity_pi.c\"\n#include <unistd.h>\n\
             __attribute__((constructor)) static void loaded(void) {{ {does} }}\n"
        );
        let library = compiled::c(at, name, &text);
        let asked = format!("az={name}.so@{}", compiled::digest(&library));
        let said = refused_with(at, &asked, &["--host-laws"]);
        assert!(said.contains(expected), "{said}");
    }
}
