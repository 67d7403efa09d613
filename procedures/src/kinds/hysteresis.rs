//! stub
use super::{Experiment, Kind, Measurand};
use crate::table::{Field, TableReader};

pub(super) struct Hysteresis;

impl Kind for Hysteresis {
    fn name(&self) -> &'static str {
        "hysteresis"
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
