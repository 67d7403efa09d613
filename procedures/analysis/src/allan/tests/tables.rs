//! Against published tables (tests/data/nbs14_allan).

use super::*;

const TEN: &str = include_str!("../../../../../tests/data/nbs14_allan/nbs14_10_deviations.csv");
const TEN_RATES: &str = include_str!("../../../../../tests/data/nbs14_allan/nbs14_10_frequency.csv");
const THOUSAND: &str = include_str!("../../../../../tests/data/nbs14_allan/nbs14_1000_deviations.csv");
const THOUSAND_RATES: &str = include_str!("../../../../../tests/data/nbs14_allan/nbs14_1000_frequency.csv");
const FREEDOM: &str = include_str!("../../../../../tests/data/nbs14_allan/freedom.csv");

/// Last column of a table with a heading.
fn last_column(table: &str) -> Vec<f64> {
    let last = |line: &str| line.rsplit(',').next().and_then(|v| v.parse().ok());
    table.lines().skip(1).map(|line| last(line).expect("a number in the last column")).collect()
}

fn statistic(name: &str) -> Option<Statistic> {
    Statistic::ALL.into_iter().find(|s| format!("{s:?}").eq_ignore_ascii_case(name))
}

/// Half a unit and a whole one of the last digit of a printed number, e.g. 2.922319e-01.
fn unit_of_last_digit(printed: &str) -> f64 {
    let (mantissa, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let digits = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len());
    let exponent: i32 = exponent.parse().expect("an exponent");
    10.0_f64.powi(exponent - digits as i32)
}

/// Compares every row of a table; returns the statistics that it held.
fn compare(table: &str, series: &Series) -> std::collections::BTreeSet<String> {
    let mut seen = std::collections::BTreeSet::new();
    for line in table.lines().skip(1) {
        let mut fields = line.splitn(5, ',');
        let mut next = || fields.next().expect("five columns");
        let name = next();
        let m = next();
        let published = next();
        let computed = next();
        let by = next();
        let Some(statistic) = statistic(name) else {
            assert_eq!(name, "SD", "a statistic that is not offered");
            continue;
        };
        let m: usize = m.parse().expect("an averaging factor");
        let mut found = deviations(series, statistic, &[m]).expect("a factor of the table")[0].deviation;
        if by.contains("sqrt(0.73)") || by.contains("sqrt(0.995)") {
            let ratio = statistic.bias_ratio(Noise::WhiteRate, m, series.rates()).unwrap_or(1.0);
            found /= ratio.sqrt();
        }
        let (exact, printed): (f64, f64) =
            (computed.parse().expect("a number"), published.parse().expect("a number"));
        assert!((found / exact - 1.0).abs() < 1e-9, "{name} {m}: {found} for {exact}");
        assert!((found - printed).abs() < unit_of_last_digit(published).max(1e-11 * printed), "{name} {m}");
        if statistic == Statistic::Pdev {
            assert!((found / printed - 1.0).abs() < 1e-11, "{name} {m}: {found} for {published}");
        }
        seen.insert(name.to_owned());
    }
    seen
}

#[test]
fn ten_points_of_nbs_monograph_140() {
    let series = Series::from_rate(&last_column(TEN_RATES), 1.0).expect("nine frequencies");
    assert_eq!(compare(TEN, &series).len(), 10, "ten statistics in the table");
}

#[test]
fn thousand_points_of_nist_sp_1065() {
    let mut number = 1_234_567_890_u64;
    for (k, frequency) in last_column(THOUSAND_RATES).into_iter().enumerate() {
        assert!((frequency * 2_147_483_647.0 - number as f64).abs() < 1e-5, "number {k}");
        number = 16_807 * number % 2_147_483_647;
    }
    let series = Series::from_rate(&last_column(THOUSAND_RATES), 1.0).expect("a thousand frequencies");
    assert_eq!(compare(THOUSAND, &series).len(), 12, "twelve statistics in the table");
}

#[test]
fn degrees_of_freedom_agree_with_greenhall_and_riley() {
    let mut compared = 0;
    for line in FREEDOM.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [name, exponent, m, rates, dof] = fields[..] else { panic!("five columns: {line}") };
        let noises = [
            Noise::WhitePhase,
            Noise::FlickerPhase,
            Noise::WhiteRate,
            Noise::FlickerRate,
            Noise::WalkRate,
            Noise::FlickerWalk,
            Noise::RunRate,
        ];
        let noise = noises.into_iter().find(|n| n.exponent().to_string() == exponent).expect("an exponent");
        let m = m.parse().expect("a factor");
        let rates = rates.parse().expect("a length");
        let expected: f64 = dof.parse().expect("a number");
        let found = freedom(statistic(name).expect("a statistic"), noise, m, rates).expect("it has some");
        assert!((found / expected - 1.0).abs() < 0.05, "{line}: {found}");
        compared += 1;
    }
    assert!(compared > 150, "{compared} rows");
}
