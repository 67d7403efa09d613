//! Modes of a structure from frequency responses: frequency, damping and residues with uncertainty.

use super::frf::{C64, Frf};
use super::rational::lines::Data;
use super::rational::{LINES_PER_UNKNOWN, LineError, RationalError, RationalFit};

mod assign;
mod choose;
mod diagram;
mod lscf;
mod mode;
#[cfg(test)]
mod tests;
mod track;

pub use track::{Step, Track, track};

/// Why there are no modes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModalError {
    /// The lines cannot be used.
    #[error(transparent)]
    Lines(#[from] LineError),
    /// No fit of the residual terms and modes.
    #[error(transparent)]
    Fit(#[from] RationalError),
    /// A setting is out of its range.
    #[error("{name} is {found}: expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// What was found.
        found: f64,
        /// What is expected.
        expected: &'static str,
    },
}

/// What stands for everything below the band, one real coefficient a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lower {
    /// Nothing.
    None,
    /// LR/(−ω²): a free mass, force to displacement.
    Mass,
    /// LR/(jω): a rigid body, torque to velocity.
    Rigid,
    /// LR/(jω + q), q fitted: a rigid body with viscous friction, torque to velocity.
    Viscous,
}

/// What stands for everything above the band, one real coefficient a response and term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Upper {
    /// Nothing.
    None,
    /// UR: stiffness of the modes above, force to displacement.
    Constant,
    /// UR·jω: the same, torque to velocity.
    Linear,
    /// UR₀ + UR₁·jω: torque to velocity, with what a rigid body leaves between two sensors of which one is later,
    /// LR/(jω)·(1 − e^(−jωδ)) ≈ LR·δ.
    Affine,
}

/// What is looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Lines outside are left out, Hz.
    pub band_hz: Option<[f64; 2]>,
    /// Delay that is taken out first, s.
    pub delay_s: f64,
    /// Whether what is left of the delay is fitted with the modes; the same for all responses.
    pub fits_delay: bool,
    /// Below the band.
    pub lower: Lower,
    /// Above the band.
    pub upper: Upper,
    /// Highest order of the common denominator; two a mode, and as many again for noise and what lies outside.
    pub most_order: usize,
    /// Relative step of frequency between orders within which a pole is stable.
    pub frequency_step: f64,
    /// Relative step of damping ratio between orders within which a pole is stable.
    pub damping_step: f64,
    /// Orders in which a pole must be stable to be tried as a mode.
    pub least_orders: usize,
    /// Largest damping ratio of a mode.
    pub most_damping: f64,
    /// Modes after which no more are sought in the residual.
    pub most_modes: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            band_hz: None,
            delay_s: 0.0,
            fits_delay: false,
            lower: Lower::None,
            upper: Upper::Constant,
            most_order: 40,
            frequency_step: 0.01,
            damping_step: 0.05,
            least_orders: 4,
            most_damping: 0.3,
            most_modes: 40,
        }
    }
}

/// A damping ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// ζ.
    pub ratio: f64,
    /// Standard uncertainty of `ratio`.
    pub u: f64,
}

/// Why a mode has no damping ratio.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unresolved {
    /// The resonance falls between two lines.
    #[error(
        "damping not resolved: half-power width {width_hz:.3} Hz below the line spacing of {spacing_hz:.3} Hz"
    )]
    Spacing {
        /// 2ζf of the fit, Hz.
        width_hz: f64,
        /// Distance of the lines there, Hz.
        spacing_hz: f64,
    },
    /// Noise moves it by more than half of it.
    #[error("damping not resolved: {ratio:.5} with a standard uncertainty of {u:.5}")]
    Noise {
        /// ζ of the fit.
        ratio: f64,
        /// Standard uncertainty of `ratio`.
        u: f64,
    },
}

/// A mode: R/(jω − p) + R*/(jω − p*) in each response.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Undamped frequency |p|/2π, Hz.
    pub frequency_hz: f64,
    /// Standard uncertainty of `frequency_hz`, Hz.
    pub frequency_u_hz: f64,
    /// Damping ratio −Re p/|p|, or why there is none.
    pub damping: Result<Damping, Unresolved>,
    /// R of each response, response unit × rad/s.
    pub residues: Vec<C64>,
    /// √(E|R̂ − R|²) of each.
    pub residue_u: Vec<f64>,
    /// The same of R·e^(−pτ), what the mode adds to the measured response: a delay τ that is fitted, too, turns all residues together,
    /// and where the lines leave it open they are far less certain than what can be seen of them.
    pub observed_u: Vec<f64>,
    /// Orders in which the pole was stable; 0 if it was found in the residual of the others.
    pub orders: usize,
}

/// Why a pole is no mode.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    /// Residues that are no more than noise.
    #[error("residue too small: chi squared {weight:.1} below {needed:.1}")]
    Weak {
        /// χ² of its residues.
        weight: f64,
        /// What noise stays below anywhere in the band with a probability of 99.9 %.
        needed: f64,
    },
    /// A pole that grows.
    #[error("unstable")]
    Unstable,
    /// A pole that does not resonate, or not in the band.
    #[error("no resonance inside the band")]
    OutOfBand,
    /// A pole that is damped more than a mode may be.
    #[error("damping ratio above {most}")]
    Damping {
        /// Largest that is taken.
        most: f64,
    },
    /// A pole that moves with the order.
    #[error("stable in {orders} orders, expected {needed}")]
    NotStable {
        /// Orders in which it stood.
        orders: usize,
        /// Orders asked for.
        needed: usize,
    },
}

/// A pole that is no mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejected {
    /// |p|/2π, Hz.
    pub frequency_hz: f64,
    /// −Re p/|p|.
    pub damping: f64,
    /// Why.
    pub reason: Reason,
}

/// One pole of a stabilisation diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramPole {
    /// |p|/2π, Hz.
    pub frequency_hz: f64,
    /// −Re p/|p|; below 0 if it grows.
    pub damping: f64,
    /// Whether the order before has a pole within [`Settings::frequency_step`].
    pub stable_frequency: bool,
    /// Whether that pole is also within [`Settings::damping_step`].
    pub stable_damping: bool,
}

/// Poles of one order, by frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramOrder {
    /// Order of the denominator.
    pub order: usize,
    /// Poles of the order inside the band.
    pub poles: Vec<DiagramPole>,
}

/// Poles of all orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    /// In ascending order.
    pub orders: Vec<DiagramOrder>,
}

/// Modes with the fit they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Modal {
    /// By frequency.
    pub modes: Vec<Mode>,
    /// Poles that are no modes, by frequency.
    pub rejected: Vec<Rejected>,
    /// Stabilisation diagram.
    pub diagram: Diagram,
    /// The fit of all modes and residual terms; its `misfit_ratio` is 1 where they describe the lines. Where it is
    /// significantly above, the uncertainties of [`Mode`] are widened by its root; those of the fit itself are not.
    pub fit: RationalFit,
}

/// Finds the modes that several responses have in common.
///
/// Poles of all orders by [least squares in z](lscf), stable ones fitted by maximum likelihood together with the
/// residual terms; what is no more than noise is left out, and while the residual is more than noise the mode it
/// shows is added. Uncertainties from the inverse Fisher information.
///
/// The band should begin below half of its end: the polynomials in z lose their footing on a short arc, and modes are
/// then found from the residual alone.
///
/// # Errors
/// See [`ModalError`]. No mode at all is no error.
pub fn modes(frfs: &[Frf], settings: &Settings) -> Result<Modal, ModalError> {
    check(settings)?;
    let band = settings.band_hz.unwrap_or([0.0, f64::INFINITY]);
    let inside = |frf: &Frf| -> Frf {
        let outside = |hz: f64| hz < band[0] || hz > band[1];
        frf.iter().filter(|l| !outside(l.frequency_hz)).copied().collect()
    };
    let data = Data::new(&frfs.iter().map(inside).collect::<Vec<_>>(), settings.delay_s)?;
    let mut choice = choose::Choice::new(&data, settings);
    if choice.most_pairs() == 0 {
        let unknowns = choice.unknowns_of_one();
        let lines = data.line_count();
        let needed = LINES_PER_UNKNOWN * unknowns;
        return Err(RationalError::TooFew { lines, unknowns, needed }.into());
    }
    let fewest = data.responses.iter().map(|r| r.s.len()).min().unwrap_or(0);
    let most_order = settings.most_order.min(fewest / 2);
    let (diagram, trails) = diagram::stabilise(&data, settings, most_order);
    let mut candidates = diagram::candidates(&trails, settings);
    candidates.truncate(choice.most_pairs());
    let solution = choice.run(candidates.iter().map(diagram::Trail::pole).collect())?;
    let orders = |pole: C64| {
        let near = |t: &&diagram::Trail| (t.pole() - pole).norm() < settings.frequency_step * pole.norm();
        candidates.iter().filter(near).map(diagram::Trail::count).max().unwrap_or(0)
    };
    let mut modes: Vec<Mode> = (0..solution.shape.pairs)
        .map(|k| mode::mode(&data, &solution, k, orders(choose::pole_of(&solution, k))))
        .collect();
    modes.sort_by(|x, y| x.frequency_hz.total_cmp(&y.frequency_hz));
    let mut rejected = choice.rejected;
    rejected.extend(wanderers(&diagram, &trails, &candidates, settings, &data));
    rejected.sort_by(|x, y| x.frequency_hz.total_cmp(&y.frequency_hz));
    let fit = RationalFit::from_solution(solution, data.scale_rad_per_s, settings.delay_s);
    Ok(Modal { modes, rejected, diagram, fit })
}

fn check(settings: &Settings) -> Result<(), ModalError> {
    let wrong = |name, found, expected| Err(ModalError::Setting { name, found, expected });
    let within = |v: f64, most: f64| v > 0.0 && v <= most;
    if !settings.delay_s.is_finite() {
        return wrong("delay_s", settings.delay_s, "a finite number");
    }
    if let Some([from, to]) = settings.band_hz.filter(|[from, to]| from.is_nan() || to.is_nan() || from >= to)
    {
        return wrong(
            "band_hz",
            from,
            if to.is_nan() { "an end of the band" } else { "below the end of the band" },
        );
    }
    if settings.most_order < 2 {
        return wrong("most_order", settings.most_order as f64, "at least 2");
    }
    for (name, found) in
        [("frequency_step", settings.frequency_step), ("damping_step", settings.damping_step)]
    {
        if !within(found, 1.0) {
            return wrong(name, found, "above 0, at most 1");
        }
    }
    if !within(settings.most_damping, 0.99) {
        return wrong("most_damping", settings.most_damping, "above 0, at most 0.99");
    }
    Ok(())
}

/// Stable-looking poles of the highest order that did not last: those no candidate is near.
fn wanderers(
    diagram: &Diagram,
    trails: &[diagram::Trail],
    candidates: &[diagram::Trail],
    settings: &Settings,
    data: &Data,
) -> Vec<Rejected> {
    let scale_hz = data.scale_rad_per_s / std::f64::consts::TAU;
    let near =
        |hz: f64, t: &diagram::Trail| (t.pole().norm() * scale_hz - hz).abs() <= settings.frequency_step * hz;
    let poles = diagram.orders.last().map(|o| o.poles.as_slice()).unwrap_or_default();
    let rejected = |pole: &DiagramPole| {
        let hz = pole.frequency_hz;
        if candidates.iter().any(|t| near(hz, t)) {
            return None;
        }
        let orders = trails.iter().filter(|t| near(hz, t)).map(diagram::Trail::count).max().unwrap_or(0);
        let reason = if pole.damping < 0.0 {
            Reason::Unstable
        } else if pole.damping > settings.most_damping {
            Reason::Damping { most: settings.most_damping }
        } else {
            Reason::NotStable { orders, needed: settings.least_orders }
        };
        Some(Rejected { frequency_hz: hz, damping: pole.damping, reason })
    };
    poles.iter().filter_map(rejected).collect()
}
