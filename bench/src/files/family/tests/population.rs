use super::*;
use crate::files::unit::{Method, read_drawn};

fn production(method: Method, units: u32) -> Vec<DrawnUnit> {
    let family = load_family("production").expect("shipped");
    let population = Population { method, seed: 7, units, randomisations: LEAST_RANDOMISATIONS };
    family.population(&population).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_larger_population_of_independent_draws_keeps_the_units_of_a_smaller_one() {
    let many = production(Method::Independent, 12);
    assert_eq!(many[..5], production(Method::Independent, 5));
    assert_eq!(many[11], load_family("production").expect("shipped").unit(7, 12));
}

#[test]
fn a_unit_file_says_where_the_unit_comes_from_and_reads_back_alone() {
    for (method, id) in [
        (Method::Independent, "production-7-12"),
        (Method::LatinHypercube, "production-latin-hypercube-7-12-of-40"),
        (Method::Sobol, "production-sobol-7-12-of-40"),
    ] {
        let unit = &production(method, 40)[11];
        assert_eq!(unit.id, id);
        let loaded = unit.load().unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
        let drawn = read_drawn(loaded.sources[0].clone()).expect("a good file").expect("a drawn unit");
        assert_eq!((drawn.from.method, drawn.from.seed, drawn.from.number), (method, 7, 12));
        assert_eq!(drawn.from.randomisation(), if method == Method::Independent { 0 } else { 2 });
        let inertia = drawn.values_si.iter().find(|(key, _)| key == "az.inertia").expect("a drawn setting");
        assert_eq!(inertia.1, loaded.director().expect("a director").az.inertia_kg_m2);
        assert!(drawn.values_si.iter().any(|(key, _)| key == "az-structure.mode-1-frequency"));
    }
    let nominal = shipped::find(Folder::Units, "nominal", None).expect("shipped");
    assert_eq!(read_drawn(nominal), Ok(None));
}

#[test]
fn each_randomisation_of_a_design_fills_every_slice_of_a_setting_once() {
    for method in [Method::LatinHypercube, Method::Sobol] {
        let units = production(method, 80);
        let nominal = nominal_inertia();
        for set in units.chunks(8) {
            let value = |unit: &DrawnUnit| {
                unit.load().expect("a good file").director().expect("one").az.inertia_kg_m2
            };
            let slice = |value: f64| (8.0 * (0.5 + (value / nominal - 1.0) / 0.2)) as usize;
            let mut slices: Vec<usize> = set.iter().map(|unit| slice(value(unit))).collect();
            slices.sort_unstable();
            assert_eq!(slices, [0, 1, 2, 3, 4, 5, 6, 7]);
        }
        let texts: BTreeSet<&str> = units.iter().map(|unit| unit.text.as_str()).collect();
        assert_eq!(texts.len(), 80);
    }
}

#[test]
fn a_population_that_cannot_be_drawn_is_refused_with_what_can() {
    let family = load_family("production").expect("shipped");
    let refused = |method, seed, units, randomisations| {
        let population = Population { method, seed, units, randomisations };
        family.population(&population).expect_err("refused").to_string()
    };
    let said = [
        refused(Method::Independent, 1, 0, 1),
        refused(Method::Independent, 1, 2_000_000, 1),
        refused(Method::Independent, u64::MAX, 3, 1),
        refused(Method::Sobol, 1, 101, 10),
        refused(Method::LatinHypercube, 1, 100, 4),
        refused(Method::LatinHypercube, 1, 10, 10),
    ];
    insta::assert_snapshot!(said.join("\n"));
}
