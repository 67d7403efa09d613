//! Below the getters: finding a key, its default or its absence, and what is left over.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::value::{Asked, Given, Wrong};
use super::super::{Field, Need, Shape, mistake_in, suggestion};
use super::{Found, MapEntry, TableReader, misuse};

impl<'a> TableReader<'a> {
    /// Keys that this table may have.
    pub(in crate::table) fn known_keys(&self) -> Vec<&'static str> {
        self.fields.iter().map(|field| field.key).collect()
    }

    /// All mistakes of this table, those of keys left over included, and how many more there are.
    pub(in crate::table) fn finish(mut self) -> (Vec<Found>, usize) {
        if !self.any_key {
            let known: Vec<&str> = self.fields.iter().map(|f| f.key).collect();
            for (key, _) in self.entries.into_iter().flatten() {
                let name: &str = key.get_ref();
                if known.contains(&name) {
                    continue;
                }
                if self.found.len() >= self.room {
                    self.untold += 1;
                } else {
                    let message = format!("unknown key `{name}`");
                    let help = Some(suggestion(name, known.iter().copied()));
                    self.mistake_at(key.span(), message, help);
                }
            }
        }
        (self.found, self.untold)
    }

    pub(super) fn value(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.entries.and_then(|entries| entries.get(key))
    }

    pub(super) fn take(&mut self, key: &'static str) -> Option<(Asked<'static>, Given<'a>)> {
        let field =
            self.fields.iter().copied().find(|f| f.key == key).unwrap_or_else(|| misuse(key, "field"));
        if let Some(value) = self.value(key) {
            return Some((field.into(), Given::Written(value)));
        }
        match field.need {
            Need::Optional => None,
            Need::Default(text) => Some((field.into(), Given::Default(text, self.place.clone()))),
            Need::Required => {
                let message = format!("missing key `{key}`");
                let help = Some(format!("`{key}` must be {}: {}", field.shape.expectation(), field.doc));
                self.tell(Wrong { span: self.place.clone(), message, help }, true);
                None
            }
        }
    }

    pub(super) fn map_with(
        &mut self,
        key: &'static str,
        read: impl Fn(&Given<'a>, &Asked<'_>) -> Result<Vec<(String, Range<usize>)>, Wrong>,
    ) -> Option<Vec<MapEntry>> {
        let (asked, given) = self.take(key)?;
        let Shape::Map(shape) = asked.shape else { misuse(key, "map") };
        let Given::Written(value) = given else { return Some(Vec::new()) };
        let DeValue::Table(entries) = value.get_ref() else {
            return self.keep(Err(given.mismatch(&asked, value.get_ref())));
        };
        if let Some(wrong) = Wrong::too_many(&asked, entries.len(), given.span()) {
            return self.keep(Err(wrong));
        }
        let mut all = Vec::with_capacity(entries.len());
        for (name, value) in entries {
            // Messages about an entry name the entry, not the map.
            let asked = Asked { key: name.get_ref(), shape };
            match read(&Given::Written(value), &asked) {
                Ok(texts) => {
                    all.push(MapEntry { key: name.get_ref().to_string(), key_span: name.span(), texts });
                }
                Err(wrong) => self.wrong(wrong),
            }
        }
        all.sort_by_key(|entry| entry.key_span.start);
        Some(all)
    }

    pub(super) fn below<T>(
        &mut self,
        entries: Option<&'a DeTable<'a>>,
        place: Range<usize>,
        fields: &'static [Field],
        read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
    ) -> Option<T> {
        let room = self.room.saturating_sub(self.found.len());
        let mut child = TableReader::new(self.source, entries, place, fields, room);
        let value = read(&mut child);
        let (found, untold) = child.finish();
        self.found.extend(found);
        self.untold += untold;
        value
    }

    pub(super) fn keep<T>(&mut self, read: Result<T, Wrong>) -> Option<T> {
        read.map_err(|wrong| self.wrong(wrong)).ok()
    }

    pub(super) fn wrong(&mut self, wrong: Wrong) {
        self.tell(wrong, false);
    }

    /// Keeps a mistake while there is room: finding its line costs a walk through the file.
    fn tell(&mut self, Wrong { span, message, help }: Wrong, missing: bool) {
        if self.found.len() >= self.room {
            self.untold += 1;
            return;
        }
        let mistake = mistake_in(self.source, span, message, help);
        self.found.push(Found { mistake, missing });
    }
}
