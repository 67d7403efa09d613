//! What the cameras see: target, atmosphere, line of sight, mirror.
