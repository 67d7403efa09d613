//! What a tracker says about one axis.

use crate::finite_or_zero;

/// One evaluated image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the target stands off the line of sight, target minus line of sight; `None` if there is no target in
    /// the image, or none to trust.
    pub error_rad: Option<f64>,
    /// Time since the middle of the exposure, at the tick that gets the frame.
    pub age_s: f64,
}

impl Frame {
    /// The error, if it is a number.
    pub(crate) fn target_rad(&self) -> Option<f64> {
        self.error_rad.filter(|error| error.is_finite() && self.age_s.is_finite() && self.age_s >= 0.0)
    }
}

/// What a loop knows of its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TrackState {
    /// No target: none yet, or none for longer than it is held.
    #[default]
    Lost,
    /// The target is missing; its last estimate is held.
    Holding,
    /// Frames with a target arrive.
    Tracking,
}

/// Tells tracking, holding and lost apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Watch {
    state: TrackState,
    since_target_s: f64,
    dropout_s: f64,
    hold_s: f64,
    period_s: f64,
}

impl Watch {
    pub(crate) fn new(dropout_s: f64, hold_s: f64, period_s: f64) -> Self {
        let [dropout_s, hold_s] = [dropout_s, hold_s].map(|s| finite_or_zero(s).max(0.0));
        Self { state: TrackState::Lost, since_target_s: 0.0, dropout_s, hold_s, period_s }
    }

    pub(crate) fn state(&self) -> TrackState {
        self.state
    }

    pub(crate) fn forget(&mut self) {
        self.state = TrackState::Lost;
    }

    /// One tick: `target` is `Some(true)` for a frame with a target, `Some(false)` for one without, `None` between
    /// frames.
    pub(crate) fn update(&mut self, target: Option<bool>) -> TrackState {
        self.since_target_s = if target == Some(true) { 0.0 } else { self.since_target_s + self.period_s };
        self.state = match (self.state, target) {
            (_, Some(true)) => TrackState::Tracking,
            (TrackState::Lost, _) => TrackState::Lost,
            _ if self.since_target_s > self.hold_s + self.period_s / 2.0 => TrackState::Lost,
            (TrackState::Tracking, None) if self.since_target_s <= self.dropout_s + self.period_s / 2.0 => {
                TrackState::Tracking
            }
            _ => TrackState::Holding,
        };
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks of 1 ms.
    fn watch() -> Watch {
        Watch::new(0.05, 0.2, 1e-3)
    }

    #[test]
    fn frame_without_a_target_starts_the_hold_at_once() {
        let mut watch = watch();
        assert_eq!(watch.update(Some(false)), TrackState::Lost, "never seen");
        assert_eq!(watch.update(Some(true)), TrackState::Tracking);
        assert_eq!(watch.update(None), TrackState::Tracking);
        assert_eq!(watch.update(Some(false)), TrackState::Holding);
        assert_eq!(watch.update(None), TrackState::Holding);
        assert_eq!(watch.update(Some(true)), TrackState::Tracking);
    }

    #[test]
    fn silent_camera_is_noticed_after_the_dropout_time_and_the_target_lost_after_the_hold() {
        let mut watch = watch();
        watch.update(Some(true));
        let states: std::vec::Vec<_> = (0..300).map(|_| watch.update(None)).collect();
        let count = |state| states.iter().filter(|s| **s == state).count();
        assert_eq!((count(TrackState::Tracking), count(TrackState::Holding)), (50, 150));
        assert_eq!(states[299], TrackState::Lost);
        assert_eq!(watch.update(Some(false)), TrackState::Lost);
    }
}
