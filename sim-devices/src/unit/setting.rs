//! Settings as data: one table drives reading, range checks, schema and documentation.

/// One setting of a unit or of a part of it. Its value is SI; `field` finds it.
#[derive(Clone, Copy, Debug)]
pub struct Setting<F> {
    /// Dotted kebab-case key, e.g. `az.coulomb-torque`.
    pub key: &'static str,
    /// Name of the quantity kind, as in people's files, e.g. `torque`, `angle`, `ratio`, `count`.
    pub quantity: &'static str,
    /// Smallest and largest allowed SI value.
    pub range_si: [f64; 2],
    /// Default as a person would write it, e.g. `"167.75 N*m"`.
    pub default: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Where the figure comes from.
    pub source: &'static str,
    /// Finds the value, e.g. a [`Field`] of a struct; `()` where only the description matters.
    pub field: F,
}

/// Finds a value in the settings `S`.
pub type Field<S> = fn(&mut S) -> &mut f64;
/// Finds a value in a unit `U` through the part that it belongs to.
pub type FieldOfPart<U> = Box<dyn Fn(&mut U) -> &mut f64 + Send + Sync>;

impl<F> Setting<F> {
    /// The same setting with another way to find its value.
    pub(super) fn with_field<G>(&self, field: G) -> Setting<G> {
        let &Self { key, quantity, range_si, default, doc, source, .. } = self;
        Setting { key, quantity, range_si, default, doc, source, field }
    }

    /// Whether the setting may have this value.
    pub fn allows(&self, value_si: f64) -> bool {
        (self.range_si[0]..=self.range_si[1]).contains(&value_si)
    }

    /// The table of the file that the setting stands in (empty for the root), and its key there.
    pub fn table_and_key(&self) -> (&'static str, &'static str) {
        self.key.split_once('.').unwrap_or(("", self.key))
    }

    /// The description of the setting alone.
    pub fn described(&self) -> Setting<()> {
        self.with_field(())
    }

    /// Puts a value into the settings.
    pub fn set<S>(&self, settings: &mut S, value_si: f64)
    where
        F: Fn(&mut S) -> &mut f64,
    {
        *(self.field)(settings) = value_si;
    }

    /// Reads the value back.
    pub fn get<S: Clone>(&self, settings: &S) -> f64
    where
        F: Fn(&mut S) -> &mut f64,
    {
        *(self.field)(&mut settings.clone())
    }
}

impl<P: 'static> Setting<Field<P>> {
    /// The setting as one of the unit `U` that has such a part.
    pub(super) fn of_part<U: 'static>(&self, part: fn(&mut U) -> &mut P) -> Setting<FieldOfPart<U>> {
        let field = self.field;
        let found: FieldOfPart<U> = Box::new(move |unit| field(part(unit)));
        self.with_field(found)
    }

    /// The setting as one of the unit itself.
    pub(super) fn of_unit(&self) -> Setting<FieldOfPart<P>> {
        self.with_field(Box::new(self.field))
    }
}
