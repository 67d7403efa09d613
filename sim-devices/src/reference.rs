//! External angle reference: polygon and autocollimator.
