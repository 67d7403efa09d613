//! Settings as data: one table drives reading, range checks, schema and documentation.

/// One setting of a settings struct `S`; the value is SI.
pub struct Parameter<S> {
    /// Dotted kebab-case key, e.g. `az.coulomb-torque`.
    pub key: &'static str,
    /// Name of the quantity kind, as in people's files, e.g. `torque`, `angle`, `ratio`, `count`.
    pub quantity: &'static str,
    /// Smallest allowed SI value.
    pub min_si: f64,
    /// Largest allowed SI value.
    pub max_si: f64,
    /// Default as a person would write it, e.g. `"167.75 N*m"`.
    pub default: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Where the figure comes from.
    pub source: &'static str,
    /// Puts a value into the settings.
    pub set: fn(&mut S, f64),
    /// Reads it back.
    pub get: fn(&S) -> f64,
}
