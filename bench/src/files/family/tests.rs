use super::*;
use crate::site::unit::Unit;

const HEAD: &str = "schema = 1\nid = \"f\"\ntitle = \"F\"\n";

fn family(tables: &str) -> Result<Family, Vec<Diagnostic>> {
    read_family(SourceFile::new("f.toml", format!("{HEAD}{tables}")))
}

/// A table that draws this setting, from these further lines.
fn setting(key: &str, lines: &str) -> String {
    format!("[[setting]]\nkeys = [\"{key}\"]\nreason = \"r\"\n{lines}\n")
}

fn correlation(keys: &str, coefficient: &str) -> String {
    format!("[[correlation]]\nkeys = [{keys}]\ncoefficient = \"{coefficient}\"\nreason = \"r\"\n")
}

fn units(family: &Family, count: u32) -> Vec<Unit> {
    let load = |number| family.unit(5, number).load().unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
    (1..=count).map(load).collect()
}

/// Values of a setting of the azimuth axis over units.
fn inertias(tables: &str) -> Vec<f64> {
    let family = family(tables).unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
    units(&family, 400).iter().map(|unit| unit.director().expect("a director").az.inertia_kg_m2).collect()
}

fn nominal_inertia() -> f64 {
    UnitSettings::default().az.inertia_kg_m2
}

#[test]
fn every_shipped_family_loads_and_its_first_units_are_good_files() {
    let mut read = 0;
    for file in shipped::all(Folder::Families) {
        let family = read_family(file.source()).unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
        assert_eq!(family.id, file.stem(), "the id is the name of the file");
        assert_eq!(units(&family, 8).len(), 8);
        read += 1;
    }
    assert!(read > 0);
}

#[test]
fn a_unit_drawn_twice_is_the_same_file_and_another_seed_or_number_is_another_unit() {
    let family = load_family("production").expect("shipped");
    let unit = family.unit(7, 12);
    assert_eq!(unit.id, "production-7-12");
    assert_eq!(unit, load_family("production").expect("shipped").unit(7, 12));
    let settings = |seed, number| family.settings(seed, number);
    assert!(unit.text.ends_with(&settings(7, 12)));
    assert_ne!(settings(7, 12), settings(7, 13));
    assert_ne!(settings(7, 12), settings(8, 12));
    assert_ne!(settings(7, 12), settings(8, 11), "seed and number are not added");
    let read = unit.load().expect("a good file");
    assert_eq!((read.id.as_str(), read.sources.len()), ("production-7-12", 2));
}

#[test]
fn rectangular_and_stepped_values_fill_their_width_evenly() {
    let found = inertias(&setting("az.inertia", "half-width = \"10 % of nominal\""));
    let shares: Vec<f64> = found.iter().map(|value| (value / nominal_inertia() - 1.0) / 0.1).collect();
    assert!(shares.iter().all(|share| share.abs() < 1.0 + 1e-4));
    let below = |limit: f64| shares.iter().filter(|share| **share < limit).count();
    for (limit, expected) in [(-0.5, 100), (0.0, 200), (0.5, 300)] {
        assert!(below(limit).abs_diff(expected) < 35, "{} below {limit}", below(limit));
    }
    let tables = setting("az.inertia", "distribution = \"steps\"\nstep = \"10 kg*m^2\"\nsteps = 2");
    let mut steps: Vec<i64> =
        inertias(&tables).iter().map(|value| ((value - nominal_inertia()) / 10.0).round() as i64).collect();
    steps.sort_unstable();
    for group in steps.chunk_by(|a, b| a == b) {
        assert!(group.len().abs_diff(80) < 35, "{} times {}", group.len(), group[0]);
    }
    steps.dedup();
    assert_eq!(steps, [-2, -1, 0, 1, 2]);
}

#[test]
fn normal_values_have_their_deviation_and_keep_their_limits() {
    let nominal = nominal_inertia();
    let whole = "distribution = \"normal\"\nstandard-deviation = \"5 % of nominal\"";
    let found = inertias(&setting("az.inertia", whole));
    let mean = found.iter().sum::<f64>() / 400.0;
    let deviation = (found.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
    assert!((mean / nominal - 1.0).abs() < 0.01 && (deviation / nominal - 0.05).abs() < 0.006, "{deviation}");
    let limits = format!("{whole}\nlimits = \"{} kg*m^2 .. {} kg*m^2\"", 0.98 * nominal, 1.2 * nominal);
    let least = inertias(&setting("az.inertia", &limits)).into_iter().fold(f64::INFINITY, f64::min);
    assert!(least > 0.9799 * nominal && least < 0.983 * nominal, "{least}");
}

#[test]
fn two_of_three_log_normal_values_lie_within_their_factor() {
    let lines = "distribution = \"log-normal\"\ngeometric-deviation = \"1.3\"";
    let found = inertias(&setting("az.inertia", lines));
    let within = |value: &&f64| (**value / nominal_inertia()).ln().abs() < 1.3_f64.ln();
    let above = found.iter().filter(|value| **value > nominal_inertia()).count();
    assert!(found.iter().filter(within).count().abs_diff(273) < 30 && above.abs_diff(200) < 35);
}

#[test]
fn correlated_settings_go_together_and_the_others_stay_what_they_were() {
    let two = setting("*.inertia", "half-width = \"10 % of nominal\"");
    let third = setting("mirror.coupling", "half-width = \"5 % of nominal\"");
    let tables = format!("{two}{third}");
    let pair = correlation("\"az.inertia\", \"el.inertia\"", "0.9");
    let [alone, coupled] = [tables.clone(), format!("{tables}{pair}")].map(|t| family(&t).expect("a family"));
    let ranks = |family: &Family| {
        let units = units(family, 400);
        let directors = units.iter().filter_map(Unit::director);
        let (az, el): (Vec<f64>, Vec<f64>) =
            directors.map(|unit| (unit.az.inertia_kg_m2, unit.el.inertia_kg_m2)).unzip();
        procedures::population::rank::spearman(&az, &el).expect("values")
    };
    assert!(ranks(&alone).abs() < 0.15 && (ranks(&coupled) - 0.891).abs() < 0.03);
    let mirror = |family: &Family| family.settings(5, 3).split("[mirror]").nth(1).map(str::to_owned);
    assert_eq!(mirror(&alone), mirror(&coupled));
    assert!(mirror(&alone).is_some());
}

#[test]
fn factors_of_modes_move_a_whole_curve_and_leave_other_modes_alone() {
    let lines = "[[mode-factor]]\nof = \"frequency\"\nhalf-width = \"2.5 %\"\nreason = \"r\"\n";
    let family = family(lines).expect("a family");
    let unit = &units(&family, 1)[0];
    let drawn = &unit.director().expect("a director").az_structure.modes;
    let nominal = &UnitSettings::default().az_structure.modes;
    let factor = |mode: usize| drawn[mode].frequency_hz[0] / nominal[mode].frequency_hz[0];
    for (k, value) in drawn[0].frequency_hz.iter().enumerate() {
        assert!((value / nominal[0].frequency_hz[k] / factor(0) - 1.0).abs() < 1e-5);
    }
    assert!((factor(0) - 1.0).abs() < 0.025 && (factor(0) - factor(1)).abs() > 1e-4);
    assert_eq!(drawn[0].damping_ratio, nominal[0].damping_ratio);
}

#[test]
fn a_base_that_is_a_path_is_found_from_any_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let own =
        "schema = 1\nid = \"own\"\ntitle = \"Own\"\nbase = \"nominal\"\n[az]\nunbalance = \"1.5 N*m\"\n";
    std::fs::write(folder.path().join("own.toml"), own).expect("a writable folder");
    let path = folder.path().join("f.toml");
    let tables = setting("az.inertia", "half-width = \"1 % of nominal\"");
    std::fs::write(&path, format!("{HEAD}base = \"./own.toml\"\n{tables}")).expect("a writable folder");
    let family =
        load_family(&path.display().to_string()).unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
    let unit = family.unit(1, 1).load().expect("a good file");
    assert_eq!(unit.sources.len(), 3);
    assert_eq!(unit.director().expect("a director").az.unbalance_nm, 1.5);
}

/// Impossible families, each with what is said of it.
#[test]
fn mistakes_in_families_lead_to_their_mend() {
    let width = "half-width = \"5 % of nominal\"";
    let twice = format!("{}{}", setting("*.inertia", width), setting("az.inertia", width));
    let three = ["az.inertia", "el.inertia", "mirror.coupling"].map(|key| setting(key, width)).concat();
    let contradicting = format!(
        "{three}{}{}{}",
        correlation("\"az.inertia\", \"el.inertia\"", "0.9"),
        correlation("\"el.inertia\", \"mirror.coupling\"", "0.9"),
        correlation("\"mirror.coupling\", \"az.inertia\"", "-0.9"),
    );
    let cases = [
        ("nothing", String::new()),
        ("unknown setting", setting("az.inertai", width)),
        ("drawn twice", twice),
        ("negative width", setting("az.inertia", "half-width = \"-2 kg*m^2\"")),
        ("another quantity", setting("az.inertia", "half-width = \"2 N*m\"")),
        ("beyond the range", setting("az.inertia", "half-width = \"150 % of nominal\"")),
        ("a share of zero", setting("az.encoder-backlash", width)),
        ("no width", setting("az.inertia", "")),
        (
            "a width of another distribution",
            setting("az.inertia", &format!("distribution = \"normal\"\n{width}")),
        ),
        (
            "limits that leave nothing",
            setting(
                "az.inertia",
                "distribution = \"normal\"\nstandard-deviation = \"1 kg*m^2\"\nlimits = \"5 kg*m^2 .. 6 kg*m^2\"",
            ),
        ),
        (
            "a factor of one",
            setting("az.inertia", "distribution = \"log-normal\"\ngeometric-deviation = \"1\""),
        ),
        ("a switch", setting("mirror.notch", "half-width = \"0.5\"")),
        ("steps that are none", setting("az.command-delay", "half-width = \"70 us\"")),
        (
            "correlated but not drawn",
            format!("{three}{}", correlation("\"az.inertia\", \"el.unbalance\"", "0.5")),
        ),
        ("a correlation of one", format!("{three}{}", correlation("\"az.inertia\", \"el.inertia\"", "1"))),
        ("with itself", format!("{three}{}", correlation("\"az.inertia\", \"az.inertia\"", "0.5"))),
        ("one star", format!("{three}{}", correlation("\"*.inertia\", \"mirror.coupling\"", "0.5"))),
        ("not positive definite", contradicting),
        ("a base of another world", format!("base = \"table\"\n{three}")),
        ("a base that is not there", format!("base = \"nominl\"\n{three}")),
    ];
    let said = cases.map(|(name, tables)| {
        let found = family(&tables).expect_err(name);
        let all: Vec<String> = found.iter().map(ToString::to_string).collect();
        format!("{name}\n{}", all.join("\n"))
    });
    insta::assert_snapshot!(said.join("\n\n"));
}

#[test]
fn all_mistakes_of_a_family_come_at_once() {
    let tables =
        ["az.inertai", "az.inertia"].map(|key| setting(key, "half-width = \"-1 % of nominal\"")).concat();
    let found = family(&format!("{tables}{}", setting("el.inertia", ""))).expect_err("mistakes");
    assert_eq!(found.len(), 3, "{found:?}");
}

mod population;
