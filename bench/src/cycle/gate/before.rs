//! The gate that is checked before the tick: free disk for the planned log.

use std::path::Path;

use procedures::case::Case;
use procedures::log::{Plan, STOP_SUFFIX, Topic, Width};

/// Free disk per planned byte of log (safety.md: gates).
const FREE_PER_PLANNED: f64 = 1.5;
/// Rows beside the planned segments of a point: power-up, arrests, the safe state.
const BESIDE_THE_PLAN_S: f64 = 5.0;
/// Every tick of a stop, and of the two seconds of standstill after a trip.
const STOP_S: f64 = 3.0;
/// Header of a message in the file and of its CDR payload.
const MESSAGE_BYTES: f64 = 31.0 + 4.0;
/// Bytes of a message's entry in the index of its chunk, which is not compressed.
const INDEX_BYTES: f64 = 16.0;
/// Devices on the gimbal are logged at this rate at the most.
const PAYLOAD_HZ: f64 = 500.0;
/// What compression leaves of the messages; 0.3 in logs of moving axes, so this is none too little for noisier ones.
const COMPRESSED_RATIO: f64 = 0.5;
/// Attachments, events, index and summary.
const FIXED_BYTES: f64 = 1e6;

/// The size that the log of a procedure is expected to have, bytes. `topics` begin with the axes and the loop.
pub(crate) fn planned_log_bytes(plan: &Plan, topics: &[Topic]) -> u64 {
    let longest_s = |case: &Case| case.planned_s() + case.cool_down_s.unwrap_or(0.0) + BESIDE_THE_PLAN_S;
    let duration_s: f64 = plan.cases.iter().map(longest_s).sum();
    let of_stops = topics.iter().position(|topic| topic.name.ends_with(STOP_SUFFIX)).unwrap_or(topics.len());
    let (topics, stops) = topics.split_at(of_stops);
    let (every_row, payload) = topics.split_at(topics.len().min(plan.axes.all().len() + 1));
    let kept = |topic: &Topic| COMPRESSED_RATIO * (MESSAGE_BYTES + payload_bytes(topic)) + INDEX_BYTES;
    let bytes = |topics: &[Topic]| topics.iter().map(kept).sum::<f64>();
    let per_s = plan.log_rate_hz * bytes(every_row) + plan.log_rate_hz.min(PAYLOAD_HZ) * bytes(payload);
    let of_stops = STOP_S * plan.loop_rate_hz * bytes(stops) * plan.cases.len() as f64;
    (FIXED_BYTES + duration_s * per_s + of_stops).ceil() as u64
}

fn payload_bytes(topic: &Topic) -> f64 {
    let bytes = |width| match width {
        Width::F64 => 8,
        Width::F32 | Width::I32 | Width::U32 => 4,
        Width::U16 => 2,
        Width::I8 => 1,
    };
    f64::from(topic.channels.iter().map(|c| bytes(c.width)).sum::<u32>())
}

/// Why a log of this size is not begun in this folder: less than one and a half times of it is free.
pub(crate) fn free_disk(folder: &Path, planned_bytes: u64) -> Option<String> {
    let needed = (FREE_PER_PLANNED * planned_bytes as f64).ceil();
    let free = match rustix::fs::statvfs(folder) {
        Ok(disk) => disk.f_bavail as f64 * disk.f_frsize as f64,
        Err(error) => {
            return Some(format!(
                "gate `free-disk`: free space of {} cannot be read: {error}",
                folder.display()
            ));
        }
    };
    closed(needed, free).map(|text| format!("{text} for {}", folder.display()))
}

fn closed(needed: f64, free: f64) -> Option<String> {
    let megabytes = |bytes: f64| format!("{:.0} MB", bytes / 1e6);
    (free < needed).then(|| {
        format!(
            "gate `free-disk`: expected at least {} (1.5 times the planned log), found {}: free some space or choose \
             another --out",
            megabytes(needed),
            megabytes(free)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::channels;
    use crate::files::rig::read_rig;
    use crate::files::shipped::{self, Folder};
    use crate::model::rig::Rig;

    fn rig() -> Rig {
        read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("a shipped rig parses")
    }

    #[test]
    fn too_little_disk_is_refused_with_both_numbers() {
        let here = std::env::temp_dir();
        assert_eq!(free_disk(&here, 1), None);
        let told = free_disk(&here, 1_000_000_000_000_000).unwrap_or_default();
        assert!(told.contains("expected at least 1500000000 MB (1.5 times the planned log)"), "{told}");
        let nowhere = free_disk(Path::new("/no/such/folder"), 1).unwrap_or_default();
        assert!(nowhere.contains("cannot be read"), "{nowhere}");
    }

    #[test]
    fn a_log_is_planned_with_its_rate_and_its_channels() {
        let case = procedures::case::Case::default();
        let mut plan = Plan {
            schema: 1,
            procedure: "P".to_owned(),
            axis: "az".to_owned(),
            seed: 1,
            loop_rate_hz: 4e3,
            log_rate_hz: 1e3,
            command_delay_ticks: 1,
            axes: rig().limits(),
            cases: vec![case.clone(), case],
            mode: "simulated".to_owned(),
        };
        let mut topics = channels::topics(&rig().axis_names(), &[]);
        let with_stops = planned_log_bytes(&plan, &topics);
        topics.retain(|topic| !topic.name.ends_with(STOP_SUFFIX));
        assert!(with_stops > planned_log_bytes(&plan, &topics), "stops have room of their own");
        let slow = planned_log_bytes(&plan, &topics) as f64 - FIXED_BYTES;
        plan.log_rate_hz = 4e3;
        let fast = planned_log_bytes(&plan, &topics) as f64 - FIXED_BYTES;
        assert!((fast / slow - 4.0).abs() < 1e-6);
        assert!(slow > 2.0 * COMPRESSED_RATIO * BESIDE_THE_PLAN_S * 1e3 * 3.0 * MESSAGE_BYTES);
    }
}
