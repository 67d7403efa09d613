//! Estimators: arrays in, numbers with uncertainty out. They know nothing of kinds or files.
