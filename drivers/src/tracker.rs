//! Video trackers: target offset in pixels, counter, quality.
