//! How a table that another tool recorded becomes a log of ours, as its map says.

use procedures::diagnostic::SourceFile;

/// Where the time of a row comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TimeSource {
    /// A column, in this unit's seconds.
    Column {
        /// Name of the column.
        column: String,
        /// Seconds a unit.
        scale_s: f64,
    },
    /// Rows at a constant rate.
    Rate {
        /// Rows per second.
        rate_hz: f64,
    },
    /// A static map: rows have no time.
    None,
}

/// One channel of the log, from one column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChannelMap {
    /// Channel of the log, e.g. `position_rad`.
    pub channel: String,
    /// Column of the table.
    pub column: String,
    /// SI value of one unit of the column.
    pub scale_factor: f64,
}

/// A stretch of a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SegmentMap {
    /// Table, as written.
    pub file: String,
    /// A second table of the same rows, whose columns stand beside those of the first.
    pub beside: Option<String>,
    /// Name of the point.
    pub point: String,
    /// `forward` or `reverse`, or another label that the kind knows.
    pub branch: String,
    /// First and last data row, 1-based; everything if `None`.
    pub rows: Option<[u64; 2]>,
    /// Rows before this time are left out.
    pub from_s: Option<f64>,
    /// Velocity that was asked for, where there was one.
    pub velocity_rad_per_s: Option<f64>,
}

/// An import map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImportMap {
    /// Procedure that judges the log, as written.
    pub procedure: String,
    /// Requirements that travel with the log, as written.
    pub requirements: String,
    /// Time.
    pub time: TimeSource,
    /// Channels.
    pub channels: Vec<ChannelMap>,
    /// Segments in order.
    pub segments: Vec<SegmentMap>,
    /// Torque constant, where efforts in ampere are to be judged in N·m.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Inertia, for the J·α term; zero leaves it out.
    pub inertia_kg_m2: f64,
    /// Expected cogging periods per revolution.
    pub cogging_orders_per_rev: f64,
    /// The file.
    pub source: SourceFile,
}
