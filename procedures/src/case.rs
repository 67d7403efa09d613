//! A planned point: the segments that the bench runs and the conditions that end them.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::device::{DeviceRole, Task};
use crate::excitation::{Excitation, Injection};
use crate::pull::Pull;
use crate::stimulus::{Envelope, Stimulus};
use crate::target::Target;

/// How a segment commands its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// The stimulus is a motor torque, N·m, without feedback.
    Torque,
    /// The stimulus is a velocity for the velocity loop.
    Velocity,
    /// The stimulus is a position (with velocity and acceleration) for the position loop.
    Position,
    /// The stimulus is a velocity for the drive's own velocity loop (CSV): there the drive itself keeps its soft limits.
    DriveVelocity,
    /// The coarse tracker commands the velocity; the stimulus says nothing.
    Track,
}

/// Track loops of a segment beside its own axis' coarse loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tracks {
    /// In track mode all other axes track, too; otherwise they hold their pose.
    pub others: bool,
    /// The fine tracker moves the mirror.
    pub fine: bool,
    /// In track mode the axes that track take over what the mirror holds on average.
    pub off_load: bool,
}

/// What ends a segment before its time is up. A closed list.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "quantity")]
pub enum Condition {
    /// The axis has moved from where the segment started by more than this.
    Displacement {
        /// Threshold of |θ − θ at segment start|.
        above_rad: f64,
    },
    /// The axis turns faster than this.
    Speed {
        /// Threshold of |ω|.
        above_rad_per_s: f64,
    },
    /// The axis has been slower than a threshold for a while.
    Settled {
        /// Threshold of |ω|.
        below_rad_per_s: f64,
        /// How long without a break.
        for_s: f64,
    },
    /// Every track loop of the segment has had its target for a while. A point in which that does not come ends.
    Locked {
        /// How long without a break.
        for_s: f64,
    },
}

/// What follows a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Then {
    /// The next segment starts in the next tick.
    Next,
    /// The axis is brought to rest under position control, then the next segment starts.
    Hold,
    /// The point ends after this segment.
    Stop,
    /// The point ends with the drives' own quick stop, from whatever rate the axes have.
    QuickStop,
    /// The point ends with the torque of its axis taken away, as by safe torque off: friction alone stops it.
    TorqueOff,
}

/// Another axis that moves along in a segment, under position control: it begins with the segment, which does not end
/// before its stimulus is over. Where no segment moves it, it rests where its command stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Companion {
    /// Name of the axis.
    pub axis: String,
    /// Command of the axis over time since the segment's start.
    pub stimulus: Stimulus,
}

/// One stretch of a case with one stimulus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// What the analysis knows it by, e.g. `approach`, `stroke`, `dwell`, `ramp+`.
    pub label: String,
    /// How the axis is commanded.
    pub mode: Mode,
    /// The command over time since the segment's start.
    pub stimulus: Stimulus,
    /// Ends the segment early.
    pub until: Option<Condition>,
    /// Ends the segment at the latest after this time.
    pub at_most_s: f64,
    /// What follows.
    pub then: Then,
    /// Whether the loop adds a seeded dither of ± ½ torque quantum to the command.
    pub dithered: bool,
    /// Which of the case's excitations is added meanwhile; its time begins with the first segment that names it and
    /// runs on through all that follow and name it, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excited: Option<usize>,
    /// Gains of the velocity loop in velocity mode, as a ratio of the production gains; 0 leaves the torque that holds
    /// the axis at the segment's start, without feedback. Any stop uses the production gains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_ratio: Option<f64>,
    /// What an instrument of the bench does meanwhile; the segment ends when it is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<Task>,
    /// Which track loops are closed beside the axis' own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracks: Option<Tracks>,
    /// What the other axis does at the same time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub companion: Option<Companion>,
}

impl Default for Segment {
    /// Nothing, for no time.
    fn default() -> Self {
        Self::hold("", Mode::Position, 0.0)
    }
}

impl Segment {
    /// Longest time for which it moves the axis: a cruise that a displacement ends lasts no longer than that takes.
    pub fn moves_at_most_s(&self) -> f64 {
        match (&self.stimulus, self.until) {
            (
                Stimulus::Cruise { from_rad_per_s, velocity_rad_per_s, .. },
                Some(Condition::Displacement { above_rad }),
            ) if from_rad_per_s * velocity_rad_per_s >= 0.0 => {
                // As far as at full rate from the start on: the place in the end is that of the displacement.
                self.at_most_s.min(above_rad / velocity_rad_per_s.abs().max(f64::MIN_POSITIVE))
            }
            _ => self.at_most_s,
        }
    }

    /// A segment without excitation, task or early end, in which the axis stays.
    pub fn hold(label: &str, mode: Mode, at_most_s: f64) -> Self {
        Self {
            label: label.to_owned(),
            mode,
            stimulus: Stimulus::Hold { torque_nm: 0.0 },
            until: None,
            at_most_s,
            then: Then::Next,
            dithered: false,
            excited: None,
            gain_ratio: None,
            task: None,
            tracks: None,
            companion: None,
        }
    }
}

impl Segment {
    /// Whether an axis follows a target in this segment; `own` for the axis of the case.
    pub fn is_tracked(&self, own: bool) -> bool {
        self.mode == Mode::Track && (own || self.tracks.is_some_and(|t| t.others))
    }

    /// Whether the fine tracker moves the mirror.
    pub fn is_fine(&self) -> bool {
        self.tracks.is_some_and(|t| t.fine)
    }
}

/// One condition of a point as it was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Name of the condition, e.g. `velocity`, `pose`, `rate`, `dwell`.
    pub name: String,
    /// Value in SI units.
    pub value: f64,
    /// Kind of quantity, for printing.
    pub kind: crate::quantity::QuantityKind,
}

/// How far and how fast any axis may move in a point; beyond it is a trip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// From where each axis stood when the drives were enabled.
    pub displacement_rad: f64,
    /// Of each axis.
    pub speed_rad_per_s: f64,
}

/// Limits of position of a point's own, ordered past to show that they hold: whatever holds them ends the point in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fence {
    /// Soft limits that the interlocks of the bench are given, by axis. Wider ones than the rig's own may be given for
    /// creeping, up to the ends of the travel.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub bench_rad: BTreeMap<String, [f64; 2]>,
    /// Soft limits that drives are given (607Dh), by axis.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drive_rad: BTreeMap<String, [f64; 2]>,
    /// Zones that the axes must not be in together.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<Zone>,
}

/// A restricted zone: a rectangle in azimuth and elevation, edges included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Smallest azimuth, elevation.
    pub lower_rad: [f64; 2],
    /// Largest azimuth, elevation.
    pub upper_rad: [f64; 2],
}

impl Zone {
    /// How far an axis (0 azimuth, 1 elevation) stands off the zone's interval, negative inside it, and the direction
    /// towards it.
    pub fn gap_rad(&self, axis: usize, angle_rad: f64) -> (f64, f64) {
        let below = self.lower_rad[axis] - angle_rad;
        let above = angle_rad - self.upper_rad[axis];
        if below >= above { (below, 1.0) } else { (above, -1.0) }
    }
}

/// A planned point: one cell of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Name of the point, unique in its procedure, e.g. `velocity=10 deg/s`.
    pub point: String,
    /// The axis that the segments command; all others hold their pose, unless a segment names one as its companion.
    pub axis: String,
    /// What was asked for.
    pub requested: Vec<Request>,
    /// Where each axis stands, at rest, before the first segment.
    pub start_pose_rad: BTreeMap<String, f64>,
    /// What the axis does.
    pub segments: Vec<Segment>,
    /// No loop may be closed in this point, because signs and scales are not proven yet: an axis without a command has
    /// no torque, and a stop takes the torque away.
    #[serde(default)]
    pub open_loop: bool,
    /// Torque limit that the drive of `axis` is given for this point, N·m; the rig's own if `None`.
    #[serde(default)]
    pub torque_limit_nm: Option<f64>,
    /// Tighter bounds than the rig's.
    #[serde(default)]
    pub bounds: Option<Bounds>,
    /// Limits of position that are ordered past.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence: Option<Fence>,
    /// What is added to commands; segments name them by their index.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excitations: Vec<Excitation>,
    /// Way of the mirror's commands in this point; the rig's own if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror_channel: Option<MirrorChannel>,
    /// Whether devices on the gimbal are logged at the loop rate: otherwise at most 500 rows/s, as means.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub logs_payload_fully: bool,
    /// Whether what the other axes do belongs to the answer.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub looks_at_others: bool,
    /// What the director is to look at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<Target>,
    /// Longest wait before motion for a heat sink that is warmer than its gate allows; refused at once if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cool_down_s: Option<f64>,
    /// Frames per second of the fine tracker in this point; the rig's own if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fine_frame_rate_hz: Option<f64>,
    /// Who pulls at the axis from outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pull: Option<Pull>,
}

/// Way of commands to the steering mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MirrorChannel {
    /// Analog inputs.
    Analog,
    /// Serial line.
    Serial,
}

impl Case {
    /// Devices without which the point cannot be run.
    pub fn needs(&self) -> BTreeSet<DeviceRole> {
        let mut needs = BTreeSet::new();
        for segment in &self.segments {
            needs.extend(segment.task.as_ref().map(Task::needs));
            needs.extend((segment.mode == Mode::Track).then_some(DeviceRole::CoarseTracker));
            if segment.is_fine() {
                needs.extend([DeviceRole::FineTracker, DeviceRole::Mirror]);
            }
        }
        let moves_mirror = |e: &Excitation| matches!(e.into, Injection::MirrorAz | Injection::MirrorEl);
        if self.mirror_channel.is_some() || self.excitations.iter().any(moves_mirror) {
            needs.insert(DeviceRole::Mirror);
        }
        needs.extend(self.fine_frame_rate_hz.map(|_| DeviceRole::FineTracker));
        needs.extend(self.pull.map(|_| DeviceRole::ForceGauge));
        needs
    }

    /// Whether an axis follows a target somewhere in the point.
    pub fn is_tracked(&self, axis: &str) -> bool {
        self.segments.iter().any(|segment| segment.is_tracked(axis == self.axis))
    }

    /// Longest duration of the point in s.
    pub fn planned_s(&self) -> f64 {
        self.segments.iter().map(|s| s.at_most_s).sum()
    }

    /// The axes that move: the case's own, then companions in the order in which they are first named.
    pub fn moved_axes(&self) -> Vec<&str> {
        let mut all = vec![self.axis.as_str()];
        for companion in self.segments.iter().filter_map(|s| s.companion.as_ref()) {
            if !all.contains(&companion.axis.as_str()) {
                all.push(&companion.axis);
            }
        }
        all
    }

    /// Whether axes other than its own are logged as often: where they move, too, or are looked at, or no loop holds them.
    pub fn logs_all_axes(&self) -> bool {
        let others_track = self.segments.iter().any(|s| s.tracks.is_some_and(|tracks| tracks.others));
        self.looks_at_others
            || self.logs_payload_fully
            || self.open_loop
            || others_track
            || self.moved_axes().len() > 1
    }

    /// This point for another axis: its own stimuli where segments name it, rest elsewhere, under
    /// position control or behind the target, and for as long as the segments last.
    pub fn seen_from(&self, axis: &str) -> Self {
        if axis == self.axis {
            return self.clone();
        }
        let segment = |s: &Segment| {
            let own = s.companion.as_ref().filter(|c| c.axis == axis).map(|c| c.stimulus.clone());
            // Where all axes follow the target this one does, too.
            let mode = if s.is_tracked(false) { Mode::Track } else { Mode::Position };
            let rest = Segment::hold(&s.label, mode, s.at_most_s);
            Segment { stimulus: own.unwrap_or(Stimulus::Hold { torque_nm: 0.0 }), ..rest }
        };
        Self {
            axis: axis.to_owned(),
            segments: self.segments.iter().map(segment).collect(),
            torque_limit_nm: None,
            excitations: Vec::new(),
            ..self.clone()
        }
    }

    /// Soft limits that an axis' plan is held against: its own, or the wider ones of a fence.
    pub fn soft_limits_rad(&self, axis: &str, own_rad: [f64; 2]) -> [f64; 2] {
        let wider = self.fence.as_ref().and_then(|fence| fence.bench_rad.get(axis));
        wider.map_or(own_rad, |[low, high]| [low.min(own_rad[0]), high.max(own_rad[1])])
    }

    /// The condition of this name that was asked for, in SI units.
    pub fn requested(&self, name: &str) -> Option<f64> {
        self.requested.iter().find(|r| r.name == name).map(|r| r.value)
    }

    /// Everything that the segments can ask of the axis, starting at its start pose.
    ///
    /// A move or a whole set of strokes ends at a known place; anything else may end wherever it reaches.
    pub fn envelope(&self) -> Envelope {
        let start_rad = self.start_pose_rad.get(&self.axis).copied().unwrap_or(0.0);
        let mut whole = Envelope::at(start_rad);
        let mut here = Envelope::at(start_rad);
        for segment in &self.segments {
            let mut reach = segment.stimulus.envelope(&here, segment.moves_at_most_s());
            if let Some(excitation) = segment.excited.and_then(|index| self.excitations.get(index)) {
                reach.excite(excitation);
            }
            let cruises = matches!(segment.stimulus, Stimulus::Cruise { .. });
            if let Some(Condition::Displacement { above_rad }) = segment.until.filter(|_| !cruises) {
                reach.widen_position(above_rad);
            }
            if let (Mode::Track, Some(bounds)) = (segment.mode, self.bounds) {
                reach.join(&Envelope::at(start_rad - bounds.displacement_rad));
                reach.join(&Envelope::at(start_rad + bounds.displacement_rad));
                reach.velocity_rad_per_s = bounds.speed_rad_per_s;
            }
            whole.join(&reach);
            here = match (&segment.stimulus, segment.until) {
                (Stimulus::Move { target_rad, .. } | Stimulus::Step { target_rad }, None) => {
                    Envelope::at(*target_rad)
                }
                (Stimulus::Sine { .. }, None) => here,
                (Stimulus::Trajectory { knots }, None) if !knots.is_empty() => {
                    Envelope::at(knots[knots.len() - 1].position_rad)
                }
                (Stimulus::Reversals { from_rad, .. }, None) => Envelope::at(*from_rad),
                _ => Envelope { position_rad: reach.position_rad, ..Envelope::at(start_rad) },
            };
        }
        whole
    }
}
