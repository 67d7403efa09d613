//! Percentiles of a block, their ratios, and the verdict.

/// Limits of the medians over all blocks.
pub(crate) struct Limits {
    pub(crate) p50_ratio: f64,
    pub(crate) p99_ratio: f64,
}

/// What one side's exchanges of a block took.
pub(crate) struct Taken {
    /// Complete exchanges without stall.
    pub(crate) exchanges_us: Vec<f64>,
    /// The same exchanges without what they waited for the interface.
    pub(crate) own_parts_us: Vec<f64>,
    /// And without what sending and receiving took.
    pub(crate) code_us: Vec<f64>,
    pub(crate) lost_count: u32,
    pub(crate) short_count: u32,
    pub(crate) stalls_count: u32,
}

/// Half of the exchanges take no longer than the first, 99 % no longer than the second.
#[derive(Clone, Copy)]
struct Percentiles {
    p50: f64,
    p99: f64,
}

/// Figures of one side.
struct SideFigures {
    took_us: Percentiles,
    own_part_us: Percentiles,
    code_us: Percentiles,
    exchanges_count: usize,
    lost_count: u32,
    short_count: u32,
    stalls_count: u32,
}

/// Figures of a block.
pub(crate) struct BlockFigures {
    bare: SideFigures,
    ours: SideFigures,
}

impl Taken {
    /// With memory for so many exchanges, so that none is asked for meanwhile.
    pub(crate) fn with_room(room: usize) -> Self {
        Self {
            exchanges_us: Vec::with_capacity(room),
            own_parts_us: Vec::with_capacity(room),
            code_us: Vec::with_capacity(room),
            lost_count: 0,
            short_count: 0,
            stalls_count: 0,
        }
    }

    fn figures(&mut self) -> Option<SideFigures> {
        Some(SideFigures {
            took_us: Percentiles::of(&mut self.exchanges_us)?,
            own_part_us: Percentiles::of(&mut self.own_parts_us)?,
            code_us: Percentiles::of(&mut self.code_us)?,
            exchanges_count: self.exchanges_us.len(),
            lost_count: self.lost_count,
            short_count: self.short_count,
            stalls_count: self.stalls_count,
        })
    }
}

impl Percentiles {
    fn of(values: &mut [f64]) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let at =
            |part: f64| values.get((values.len().saturating_sub(1) as f64 * part).round() as usize).copied();
        Some(Self { p50: at(0.5)?, p99: at(0.99)? })
    }
}

impl BlockFigures {
    /// `None` if one side has no complete exchange.
    pub(crate) fn of(bare: &mut Taken, ours: &mut Taken) -> Option<Self> {
        Some(Self { bare: bare.figures()?, ours: ours.figures()? })
    }

    fn p50_ratio(&self) -> f64 {
        self.ours.took_us.p50 / self.bare.took_us.p50
    }

    fn p99_ratio(&self) -> f64 {
        self.ours.took_us.p99 / self.bare.took_us.p99
    }

    /// Two lines.
    pub(crate) fn print(&self, number: u32) {
        println!("{number:>5}  bare  {}", self.bare.text());
        println!("       ours  {}  {:>6.3} {:>6.3}", self.ours.text(), self.p50_ratio(), self.p99_ratio());
    }
}

impl SideFigures {
    fn text(&self) -> String {
        let times = [self.took_us, self.own_part_us, self.code_us];
        let times: Vec<_> = times.iter().map(|both| format!("{:>6.1} {:>6.1}", both.p50, both.p99)).collect();
        let Self { exchanges_count, lost_count, short_count, stalls_count, .. } = self;
        let times = times.join("  ");
        format!("{times}  {exchanges_count:>6} {lost_count:>4} {short_count:>5} {stalls_count:>6}")
    }
}

/// Three lines above the blocks. Times in microseconds.
pub(crate) fn print_head() {
    println!("times in us; lost: no reply; short: not all stations; stalls: longer than 1 ms");
    println!(
        "             exchange       own part       of it code                                ours / bare"
    );
    println!(
        "block  side     p50    p99     p50    p99     p50    p99   count lost short stalls     p50    p99"
    );
}

/// Prints the medians over all blocks and says whether they are within the limits; `None` without blocks.
pub(crate) fn verdict(blocks: &[BlockFigures], limits: &Limits) -> Option<bool> {
    let over = |figure: fn(&BlockFigures) -> f64| median(blocks.iter().map(figure).collect());
    let p50 = over(BlockFigures::p50_ratio)?;
    let p99 = over(BlockFigures::p99_ratio)?;
    for (name, side) in [("bare", bare_of as fn(&BlockFigures) -> &SideFigures), ("ours", ours_of)] {
        let over = |figure: fn(&SideFigures) -> Percentiles| {
            let all: Vec<_> = blocks.iter().map(|block| figure(side(block))).collect();
            let p50 = median(all.iter().map(|both| both.p50).collect())?;
            Some(format!("p50 {p50:.1}, p99 {:.1}", median(all.iter().map(|both| both.p99).collect())?))
        };
        let (took, own) = (over(|side| side.took_us)?, over(|side| side.own_part_us)?);
        println!(
            "medians of {name}: exchange {took}; own part {own}; of it code {} us",
            over(|side| side.code_us)?
        );
    }
    let is_within = p50 <= limits.p50_ratio && p99 <= limits.p99_ratio;
    println!(
        "p50 ours / bare {p50:.3} (limit {}), p99 {p99:.3} (limit {}): {}",
        limits.p50_ratio,
        limits.p99_ratio,
        if is_within { "within the limits" } else { "OUTSIDE" }
    );
    Some(is_within)
}

fn bare_of(block: &BlockFigures) -> &SideFigures {
    &block.bare
}

fn ours_of(block: &BlockFigures) -> &SideFigures {
    &block.ours
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (lower, upper) = (values.len().checked_sub(1)? / 2, values.len() / 2);
    Some((values[lower] + values[upper]) / 2.0)
}
