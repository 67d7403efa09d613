//! For how long something has lasted without a break, as samples show it.

/// A spell of something that every sample shows or does not show.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spell {
    period_s: f64,
    lasted_s: f64,
}

impl Spell {
    /// None yet; samples come at this period.
    pub(super) fn new(period_s: f64) -> Self {
        Self { period_s, lasted_s: 0.0 }
    }

    /// A sample `span_s` after the one before. A gap counts in full where the samples at both of its ends show it; a
    /// first sample after a gap stands for one period only, because nobody saw when it began.
    pub(super) fn take(&mut self, shows: bool, span_s: f64) {
        self.lasted_s = match (shows, self.lasted_s > 0.0) {
            (false, _) => 0.0,
            (true, true) => self.lasted_s + span_s,
            (true, false) => self.period_s,
        };
    }

    /// How long it has lasted; 0 where the newest sample does not show it.
    pub(super) fn lasted_s(&self) -> f64 {
        self.lasted_s
    }
}
