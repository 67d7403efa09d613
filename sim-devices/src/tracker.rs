//! Video trackers at the far end of their ports.
