//! What repeats with the strokes, taken out of the amplitudes.
//!
//! Each turn-round leaves the same transient in the windows that follow it, and strokes between the same ends meet the same
//! cogging. Neither knows of the excitation, but a few dozen windows at regular times do not average it away: it would stay in
//! the response as an error that no scatter shows. So amplitudes over the excitation, Z_w = G + D_c/R_w, are fitted with a
//! D_c for each class c of windows that lie at the same place of a stroke; R_w, the excitation seen from the window's start,
//! turns from window to window, which tells both apart.

use analysis::frf::C64;

/// Windows that a class needs.
const LEAST_WINDOWS: usize = 4;
/// Share of the windows' weight that must be left for the response.
const LEAST_LEFT: f64 = 0.3;

/// Windows at the same place of a stroke, by index.
pub(super) fn classes(places: &[usize]) -> Vec<Vec<usize>> {
    let mut names: Vec<usize> = places.to_vec();
    names.sort_unstable();
    names.dedup();
    let windows_of = |name: usize| (0..places.len()).filter(|&w| places[w] == name).collect::<Vec<_>>();
    names.into_iter().map(windows_of).filter(|class| class.len() >= LEAST_WINDOWS).collect()
}

/// Takes D_c/R_w off the amplitudes of a line; `inverse` is 1/R_w. Gives the share of the windows' weight that is left for
/// the response, if both could be told apart.
pub(super) fn take_out(z: &mut [C64], inverse: &[C64], classes: &[Vec<usize>]) -> Option<f64> {
    // Residuals of amplitudes and of a constant on 1/R_w, class by class; windows of no class stay as they are.
    let mut rest_z = z.to_vec();
    let mut rest_one = vec![C64::new(1.0, 0.0); z.len()];
    for class in classes {
        project(&mut rest_z, inverse, class);
        project(&mut rest_one, inverse, class);
    }
    let left: f64 = rest_one.iter().map(C64::norm_sqr).sum();
    if classes.is_empty() || left < LEAST_LEFT * z.len() as f64 {
        return None;
    }
    let response: C64 = rest_one.iter().zip(&rest_z).map(|(one, z)| one.conj() * z).sum::<C64>() / left;
    for class in classes {
        let mut top = C64::new(0.0, 0.0);
        let mut bottom = 0.0;
        for &w in class {
            top += inverse[w].conj() * (z[w] - response);
            bottom += inverse[w].norm_sqr();
        }
        for &w in class {
            z[w] -= inverse[w] * top / bottom;
        }
    }
    Some(left / z.len() as f64)
}

/// Takes off what lies along 1/R_w within a class.
fn project(values: &mut [C64], inverse: &[C64], class: &[usize]) {
    let mut top = C64::new(0.0, 0.0);
    let mut bottom = 0.0;
    for &w in class {
        top += inverse[w].conj() * values[w];
        bottom += inverse[w].norm_sqr();
    }
    for &w in class {
        values[w] -= inverse[w] * top / bottom;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_repeats_is_taken_out_and_the_response_stays() {
        let turn = |w: usize| C64::from_polar(2.0, 0.85 * (w * w) as f64);
        let response = C64::new(0.3, -0.7);
        let [up, down] = [C64::new(5.0, 1.0), C64::new(-4.0, 2.0)];
        let inverse: Vec<C64> = (0..24).map(|w| turn(w).inv()).collect();
        let d = |w: usize| if w.is_multiple_of(2) { up } else { down };
        let mut z: Vec<C64> = (0..24).map(|w| response + d(w) * inverse[w]).collect();
        let classes = classes(&(0..24).map(|w| w % 2).collect::<Vec<_>>());
        assert!(take_out(&mut z, &inverse, &classes).is_some_and(|left| left > 0.8));
        assert!(z.iter().all(|z| (z - response).norm() < 1e-12));
    }

    #[test]
    fn windows_that_all_meet_the_excitation_alike_are_left_alone() {
        let mut z = vec![C64::new(1.0, 0.0); 12];
        let before = z.clone();
        assert_eq!(take_out(&mut z, &[C64::new(0.5, 0.5); 12], &classes(&[0; 12])), None);
        assert_eq!(z, before);
    }

    #[test]
    fn places_with_too_few_windows_are_no_class() {
        assert_eq!(classes(&[0, 0, 0, 1, 1, 1, 1]), [vec![3, 4, 5, 6]]);
    }
}
