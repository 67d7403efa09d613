//! Restricted zones: rectangles in azimuth and elevation that the line of sight does not enter.

use crate::envelope::BrakingCurve;
use crate::{EnvelopeSettings, finite_or_zero};

/// Largest number of restricted zones.
pub const MASKS: usize = 8;

/// A restricted zone, edges included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Lower edges: azimuth, elevation.
    pub lower_rad: [f64; 2],
    /// Upper edges: azimuth, elevation.
    pub upper_rad: [f64; 2],
}

impl Zone {
    /// Distance of one axis from the zone's nearest edge, rad, and the sign of a rate towards the zone (1 or −1).
    ///
    /// Inside the zone's interval the distance is negative, and the sign is that of a rate away from the nearest edge.
    fn gap(&self, axis: usize, position_rad: f64) -> (f64, f64) {
        let below_rad = self.lower_rad[axis] - position_rad;
        let above_rad = position_rad - self.upper_rad[axis];
        if below_rad >= above_rad { (below_rad, 1.0) } else { (above_rad, -1.0) }
    }
}

/// A zone and the axis that keeps out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Guarded {
    zone: Zone,
    /// Axis that keeps out of the zone; `None` until the first position is known.
    guard: Option<usize>,
    /// Ticks in a row in which the axis that is not the guard could have stopped in front of the zone, too.
    able_ticks: u32,
}

/// Limits rate commands so that the line of sight enters no zone.
///
/// The line of sight is outside a zone as long as one axis is outside the zone's interval. So for each zone one axis is the
/// guard. The guard's rate towards the zone is limited by the braking curve; the other axis is free.
///
/// The other axis becomes the guard only after it could have stopped in front of the zone for a whole reaction time. Its
/// commanded and its measured rate must both have allowed that. As long as the axes brake as the settings say, a line of
/// sight that starts at rest outside all zones therefore never enters one.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskKeeper {
    zones: [Option<Guarded>; MASKS],
    curve: BrakingCurve,
    reaction_ticks: u32,
    command_rad_per_s: [f64; 2],
}

impl MaskKeeper {
    /// A keeper without zones, whose [`Self::limit`] is called every `period_s`.
    pub fn new(settings: &EnvelopeSettings, period_s: f64) -> Self {
        Self {
            zones: [None; MASKS],
            curve: BrakingCurve::new(settings),
            reaction_ticks: libm::ceil(settings.reaction_time_s / period_s) as u32,
            command_rad_per_s: [0.0; 2],
        }
    }

    /// Adds a zone; `false` if its lower edges are not below its upper edges, or [`MASKS`] zones are there already.
    #[must_use]
    pub fn add(&mut self, zone: Zone) -> bool {
        let valid = (0..2).all(|axis| zone.lower_rad[axis] < zone.upper_rad[axis]);
        let free = self.zones.iter_mut().find(|slot| slot.is_none());
        match free {
            Some(slot) if valid => {
                *slot = Some(Guarded { zone, guard: None, able_ticks: 0 });
                true
            }
            _ => false,
        }
    }

    /// Turns wanted rates into allowed rates, once per tick. All arrays are azimuth, elevation. Positions and
    /// `rate_rad_per_s` are measured.
    ///
    /// Rates are only ever made smaller. Inside a zone (e.g. at power-up) the guard may move only towards its nearest edge.
    /// While a position is not finite, all rates are 0. A rate that is not finite counts as 0.
    pub fn limit(
        &mut self,
        position_rad: [f64; 2],
        rate_rad_per_s: [f64; 2],
        wanted_rad_per_s: [f64; 2],
    ) -> [f64; 2] {
        let mut allowed = wanted_rad_per_s.map(finite_or_zero);
        if position_rad.iter().any(|angle| !angle.is_finite()) {
            allowed = [0.0; 2];
        } else {
            for guarded in self.zones.iter_mut().flatten() {
                let gaps = [0, 1].map(|axis| guarded.zone.gap(axis, position_rad[axis]));
                let max_towards = gaps.map(|(gap_rad, _)| self.curve.rate_rad_per_s(gap_rad));
                let can_stop = [0, 1].map(|axis| {
                    let (gap_rad, towards) = gaps[axis];
                    let measured = finite_or_zero(rate_rad_per_s[axis]);
                    let fastest = (towards * measured).max(towards * self.command_rad_per_s[axis]);
                    gap_rad > 0.0 && fastest <= max_towards[axis]
                });
                let guard = guarded.choose(gaps, can_stop, self.reaction_ticks);
                let (_, towards) = gaps[guard];
                // Only a rate towards the zone is limited; one away from it stays as wanted.
                allowed[guard] = towards * (towards * allowed[guard]).min(max_towards[guard]);
            }
        }
        self.command_rad_per_s = allowed;
        allowed
    }
}

impl Guarded {
    /// The guard of this tick, as index of the axis. `gaps` are those of [`Zone::gap`]; `can_stop`: in front of the zone.
    fn choose(&mut self, gaps: [(f64, f64); 2], can_stop: [bool; 2], reaction_ticks: u32) -> usize {
        let [(azimuth_gap_rad, _), (elevation_gap_rad, _)] = gaps;
        let farther = usize::from(elevation_gap_rad > azimuth_gap_rad);
        let guard = *self.guard.get_or_insert(farther);
        let other = 1 - guard;
        self.able_ticks = if can_stop[other] { self.able_ticks.saturating_add(1) } else { 0 };
        // The braking curve limits the axis that is farther from the zone less.
        if self.able_ticks > reaction_ticks && other == farther {
            self.guard = Some(other);
            self.able_ticks = 0;
            return other;
        }
        guard
    }
}

#[cfg(test)]
mod tests;
