//! Settings from findings that each depend on several of them: the estimator behind `bench identify`.

pub use analysis::posterior::{Estimated, Observation, Posterior, Prior};
