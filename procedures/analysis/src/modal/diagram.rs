//! Stabilisation: which poles stay where they are as the order grows.

use super::super::frf::C64;
use super::super::rational::lines::Data;
use super::lscf::Lscf;
use super::{Diagram, DiagramOrder, DiagramPole, Settings};

/// Orders that a pole may be absent and still count as the same.
const GAP: usize = 2;

/// A pole followed over orders.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    /// Index of the order and the pole there.
    steps: Vec<(usize, C64)>,
}

impl Trail {
    /// The pole of the highest order.
    pub(super) fn pole(&self) -> C64 {
        self.steps[self.steps.len() - 1].1
    }

    /// Orders in which it stands.
    pub(super) fn count(&self) -> usize {
        self.steps.len()
    }
}

/// Relative steps of frequency and damping ratio between two poles.
fn steps(from: C64, to: C64) -> [f64; 2] {
    let damping = |p: C64| -p.re / p.norm();
    [
        (to.norm() - from.norm()).abs() / from.norm(),
        (damping(to) - damping(from)).abs() / damping(from).abs().max(f64::MIN_POSITIVE),
    ]
}

/// Poles of all orders, and the trails of those that stay.
pub(super) fn stabilise(data: &Data, settings: &Settings, most_order: usize) -> (Diagram, Vec<Trail>) {
    let mut trails: Vec<Trail> = Vec::new();
    let mut diagram = Diagram { orders: Vec::new() };
    let Some(lscf) = Lscf::new(data, most_order) else { return (diagram, trails) };
    let lowest = data.lowest();
    for (index, order) in (2..=most_order).step_by(2).enumerate() {
        let mut poles = lscf.poles(order).unwrap_or_default();
        poles.retain(|p| p.im >= lowest && p.im < 1.0);
        poles.sort_by(|x, y| x.im.total_cmp(&y.im));
        let last = diagram.orders.last().map(|o: &DiagramOrder| o.poles.clone()).unwrap_or_default();
        let scale_hz = data.scale_rad_per_s / std::f64::consts::TAU;
        let seen = poles.iter().map(|p| seen(*p, scale_hz, &last, settings)).collect();
        diagram.orders.push(DiagramOrder { order, poles: seen });
        let usable = |p: &C64| p.re < 0.0 && -p.re / p.norm() <= settings.most_damping;
        extend(&mut trails, index, poles.into_iter().filter(usable).collect(), settings);
    }
    (diagram, trails)
}

/// A pole with its verdict against those of the order before.
fn seen(pole: C64, scale_hz: f64, last: &[DiagramPole], settings: &Settings) -> DiagramPole {
    let frequency_hz = pole.norm() * scale_hz;
    let damping = -pole.re / pole.norm();
    let near =
        |p: &&DiagramPole| (p.frequency_hz - frequency_hz).abs() <= settings.frequency_step * frequency_hz;
    let alike = |p: &DiagramPole| (p.damping - damping).abs() <= settings.damping_step * p.damping.abs();
    DiagramPole {
        frequency_hz,
        damping,
        stable_frequency: last.iter().any(|p| near(&p)),
        stable_damping: last.iter().filter(near).any(alike),
    }
}

/// Joins the poles of one order to the trails, closest first, each once; the rest begin trails.
fn extend(trails: &mut Vec<Trail>, index: usize, poles: Vec<C64>, settings: &Settings) {
    let mut pairs = Vec::new();
    for (t, trail) in trails.iter().enumerate().filter(|(_, t)| t.steps[t.steps.len() - 1].0 + GAP >= index) {
        for (p, pole) in poles.iter().enumerate() {
            let [frequency, damping] = steps(trail.pole(), *pole);
            if frequency <= settings.frequency_step && damping <= settings.damping_step {
                pairs.push((frequency / settings.frequency_step + damping / settings.damping_step, t, p));
            }
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
    let mut used_trails = vec![false; trails.len()];
    let mut used = vec![false; poles.len()];
    for (_, t, p) in pairs {
        if !used_trails[t] && !used[p] {
            (used_trails[t], used[p]) = (true, true);
            trails[t].steps.push((index, poles[p]));
        }
    }
    let new = poles.iter().zip(&used).filter(|(_, used)| !**used);
    trails.extend(new.map(|(p, _)| Trail { steps: vec![(index, *p)] }));
}

/// Trails long enough for a mode, none of them a continuation of another; longest first.
pub(super) fn candidates(trails: &[Trail], settings: &Settings) -> Vec<Trail> {
    let mut long: Vec<&Trail> = trails.iter().filter(|t| t.count() >= settings.least_orders).collect();
    long.sort_by(|x, y| y.count().cmp(&x.count()).then(x.pole().im.total_cmp(&y.pole().im)));
    let mut kept: Vec<Trail> = Vec::new();
    for trail in long {
        let again = |k: &Trail| {
            let apart = k.steps.iter().all(|(i, _)| trail.steps.iter().all(|(j, _)| i != j));
            apart && steps(k.pole(), trail.pole())[0] <= settings.frequency_step
        };
        if !kept.iter().any(again) {
            kept.push(trail.clone());
        }
    }
    kept
}
