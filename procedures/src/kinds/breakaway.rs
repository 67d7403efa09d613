//! stub
use super::{Experiment, Kind, Measurand};
use crate::table::{Field, TableReader};

pub(super) struct Breakaway;

impl Kind for Breakaway {
    fn name(&self) -> &'static str {
        "breakaway"
    }
    fn doc(&self) -> &'static str {
        ""
    }
    fn fields(&self) -> &'static [Field] {
        &[]
    }
    fn measurands(&self) -> &'static [Measurand] {
        &[]
    }
    fn read(&self, _table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
        None
    }
}
