//! Correlations between what a family draws.

use std::ops::Range;

use procedures::population::copula::GaussianCopula;
use procedures::table::TableReader;

use super::Coupled;
use super::variable::{Variable, spelled_out, suggestion_near};

/// Two variables, by their places, that go together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    places: [usize; 2],
    coefficient_ratio: f64,
}

/// Reads one `[[correlation]]`. Without variables, because some of them are wrong, only its keys are read.
pub(super) fn read(
    t: &mut TableReader<'_>,
    variables: Option<&[Variable]>,
    pairs: &mut Vec<Pair>,
) -> Option<()> {
    let keys = t.spanned_texts("keys");
    let coefficient = coefficient(t);
    t.text("reason");
    let keys = keys?;
    let [first, second] = keys.as_slice() else {
        t.mistake("keys", format!("expected two keys, found {}", keys.len()), None);
        return None;
    };
    let variables = variables?;
    let spelled = [first, second].map(|(key, _)| spelled_out(key));
    if spelled[0].len() != spelled[1].len() {
        let help = "write `*` in both keys, or in neither".to_owned();
        let message = format!("`{}` and `{}` are not pairs of settings", first.0, second.0);
        t.mistake("keys", message, Some(help));
        return None;
    }
    let coefficient_ratio = coefficient?;
    for (one, other) in spelled[0].iter().zip(&spelled[1]) {
        let places = [(one, &first.1), (other, &second.1)].map(|(key, span)| drawn(t, key, span, variables));
        let [Some(one_place), Some(other_place)] = places else { continue };
        let places = [one_place.min(other_place), one_place.max(other_place)];
        if one_place == other_place {
            t.mistake("keys", format!("`{one}` is correlated with itself"), None);
        } else if pairs.iter().any(|pair| pair.places == places) {
            let message = format!("the correlation of `{one}` and `{other}` is given twice");
            t.mistake("keys", message, Some("remove one of the two".to_owned()));
        } else {
            pairs.push(Pair { places, coefficient_ratio });
        }
    }
    Some(())
}

fn coefficient(t: &mut TableReader<'_>) -> Option<f64> {
    let key = "coefficient";
    let value = t.quantity(key)?;
    if value > -1.0 && value < 1.0 {
        return Some(value);
    }
    t.mistake(key, format!("`{key}` must be above -1 and below 1, found {value}"), None);
    None
}

fn drawn(t: &mut TableReader<'_>, key: &str, span: &Range<usize>, variables: &[Variable]) -> Option<usize> {
    let keys: Vec<String> = variables.iter().map(Variable::key).collect();
    let place = keys.iter().position(|known| known == key);
    if place.is_none() {
        let near = suggestion_near(key, keys.iter().map(String::as_str));
        let help = if near.starts_with("did") { near } else { "list it in a `[[setting]]`".to_owned() };
        t.mistake_at(
            span.clone(),
            format!("`{key}` is correlated, but this file does not draw it"),
            Some(help),
        );
    }
    place
}

/// The copula of all pairs; a matrix that is not positive definite is a mistake.
pub(super) fn coupled(
    t: &mut TableReader<'_>,
    place: Range<usize>,
    variables: &[Variable],
    pairs: &[Pair],
) -> Option<Coupled> {
    let mut places: Vec<usize> = pairs.iter().flat_map(|pair| pair.places).collect();
    places.sort_unstable();
    places.dedup();
    if places.is_empty() {
        return Some(Coupled::default());
    }
    let mut matrix = identity(places.len());
    for pair in pairs {
        let [Ok(row), Ok(column)] = pair.places.map(|place| places.binary_search(&place)) else { continue };
        matrix[row][column] = pair.coefficient_ratio;
        matrix[column][row] = pair.coefficient_ratio;
    }
    match GaussianCopula::new(&matrix) {
        Ok(copula) => Some(Coupled { places, copula: Some(copula) }),
        Err(error) => {
            let keys: Vec<String> =
                places.iter().map(|&place| format!("`{}`", variables[place].key())).collect();
            let help = format!(
                "correlations of {} contradict each other: make coefficients smaller, or give those that are missing between them",
                keys.join(", ")
            );
            t.mistake_at(place, error.to_string(), Some(help));
            None
        }
    }
}

fn identity(size: usize) -> Vec<Vec<f64>> {
    (0..size).map(|row| (0..size).map(|column| f64::from(u8::from(row == column))).collect()).collect()
}
