//! What the director points at: parametric, seeded trajectories.
