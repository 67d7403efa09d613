//! Restricted zones: rectangles in azimuth and elevation that the line of sight does not enter.

use crate::envelope::BrakingCurve;
use crate::{EnvelopeSettings, finite_or_zero};

/// Zones that can be kept.
pub const MASKS: usize = 8;

/// A restricted zone, edges included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Smallest azimuth, elevation.
    pub lower_rad: [f64; 2],
    /// Largest azimuth, elevation.
    pub upper_rad: [f64; 2],
}

impl Zone {
    /// How far one axis stands off the zone (negative inside its interval), and the direction towards it.
    fn gap(&self, axis: usize, position_rad: f64) -> (f64, f64) {
        let below = self.lower_rad[axis] - position_rad;
        let above = position_rad - self.upper_rad[axis];
        if below >= above { (below, 1.0) } else { (above, -1.0) }
    }
}

/// A zone and the axis that keeps out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Guarded {
    zone: Zone,
    /// `None` until the first position is known.
    guard: Option<usize>,
    /// Ticks for which the other axis, too, could have stopped in front of the zone.
    able_ticks: u32,
}

/// Keeps rate commands out of zones.
///
/// One axis outside a zone's interval is enough to be outside the zone. So for each zone one axis is the guard: towards
/// the zone it is held to the braking curve, the other is free. The guard changes only to an axis that could have
/// stopped in front of the zone, by its command and by its measured rate, during a whole reaction time. With braking
/// as reliable as the settings say, a line of sight that starts at rest outside all zones therefore never enters one.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskKeeper {
    zones: [Option<Guarded>; MASKS],
    curve: BrakingCurve,
    reaction_ticks: u32,
    command_rad_per_s: [f64; 2],
}

impl MaskKeeper {
    /// No zones yet; it is updated every `period_s`.
    pub fn new(settings: &EnvelopeSettings, period_s: f64) -> Self {
        Self {
            zones: [None; MASKS],
            curve: BrakingCurve::new(settings),
            reaction_ticks: libm::ceil(settings.reaction_time_s / period_s) as u32,
            command_rad_per_s: [0.0; 2],
        }
    }

    /// One more zone; `false` if it is not a rectangle or there is no room for it.
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

    /// One tick: positions and measured rates of azimuth and elevation, wanted rates in, allowed rates out.
    ///
    /// Rates are only ever made smaller; inside a zone (e.g. at power-up) the guard leaves by the nearest edge. While
    /// a position is not known nothing moves; a rate that is not finite counts as 0.
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
                let largest = [0, 1].map(|axis| self.curve.rate_rad_per_s(gaps[axis].0));
                let able = [0, 1].map(|axis| {
                    let (gap_rad, towards) = gaps[axis];
                    let measured = finite_or_zero(rate_rad_per_s[axis]);
                    let fastest = (towards * measured).max(towards * self.command_rad_per_s[axis]);
                    gap_rad > 0.0 && fastest <= largest[axis]
                });
                let guard = guarded.choose(gaps, able, self.reaction_ticks);
                let towards = gaps[guard].1;
                allowed[guard] = towards * (towards * allowed[guard]).min(largest[guard]);
            }
        }
        self.command_rad_per_s = allowed;
        allowed
    }
}

impl Guarded {
    /// The guard of this tick.
    fn choose(&mut self, gaps: [(f64, f64); 2], able: [bool; 2], reaction_ticks: u32) -> usize {
        let farther = usize::from(gaps[1].0 > gaps[0].0);
        let guard = *self.guard.get_or_insert(farther);
        let other = 1 - guard;
        self.able_ticks = if able[other] { self.able_ticks.saturating_add(1) } else { 0 };
        // The farther one hinders less.
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
