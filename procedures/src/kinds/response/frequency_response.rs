//! Kind `frequency-response`: responses of the loops of an axis, their margins, and how the axes couple.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::excitation::Injection;
use crate::kinds::response::excited::{self, BACKGROUND, EXCITATION, Excited};
use crate::kinds::{Experiment, Kind, Measurand, ReadKeys};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

mod coupling;
pub(in crate::kinds) mod loops;
mod plant;
pub(in crate::kinds) mod point;
#[cfg(test)]
mod tests;

const FIELDS: &[Field] = &[
    Field::default(
        "elevation",
        Shape::Quantities(Q::Angle),
        "0 deg",
        "Elevations, one point each with every level; an elevation whose strokes would leave the travel is \
         shifted inside it.",
    ),
    Field::required("excitation", Shape::Table(EXCITATION), "Excitation signal, and where it is injected."),
    Field::required(
        "background",
        Shape::Table(BACKGROUND),
        "Sliding motion of the axis during the excitation.",
    ),
    Field::required(
        "responses",
        Shape::Texts,
        "Responses to evaluate from each record: `velocity-loop`, `track-loop`, `plant`, `current-loop`, \
         `cross-axis`, `coaxiality`, `torque-angle`, `velocity-position`.",
    ),
];

/// A response that is read from a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Response {
    /// Open velocity loop: error to rate. Margins.
    VelocityLoop,
    /// Open coarse track loop: command of the velocity loop to what the tracker asks for. Margins.
    TrackLoop,
    /// Torque to rate and angle.
    Plant,
    /// Torque that was sent to torque that the drive shows.
    CurrentLoop,
    /// Rate of this axis to rate of the other one, under torque on this one.
    CrossAxis,
    /// Integrated rate of the gyro to angle of the encoder.
    Coaxiality,
    /// Torque to angle of the encoder.
    TorqueAngle,
    /// Commanded rate to angle, by encoder and by integrated gyro.
    VelocityPosition,
}

const RESPONSES: [(&str, Response); 8] = [
    ("velocity-loop", Response::VelocityLoop),
    ("track-loop", Response::TrackLoop),
    ("plant", Response::Plant),
    ("current-loop", Response::CurrentLoop),
    ("cross-axis", Response::CrossAxis),
    ("coaxiality", Response::Coaxiality),
    ("torque-angle", Response::TorqueAngle),
    ("velocity-position", Response::VelocityPosition),
];

/// What to write instead of a response that there is none of.
fn unknown_response(name: &str) -> String {
    if name.starts_with("mirror") {
        // It has no axis to slide, and its excitation goes another way.
        return "the mirror's loop, open and closed, is measured by `kind = \"fsm-response\"`".to_owned();
    }
    crate::table::suggestion(name, RESPONSES.iter().map(|(known, _)| *known))
}

impl Response {
    /// Whether it is read from the other axis, the gyros or a tracker.
    fn needs_gimbal(self) -> bool {
        matches!(self, Self::CrossAxis | Self::Coaxiality | Self::TrackLoop)
    }

    /// What it yields.
    fn measurands(self) -> &'static [&'static str] {
        match self {
            Self::VelocityLoop => loops::VELOCITY_NAMES,
            Self::TrackLoop => loops::TRACK_NAMES,
            Self::Plant => plant::PLANT_NAMES,
            Self::CurrentLoop => &[loops::CURRENT_NAME],
            Self::CrossAxis => coupling::NAMES,
            Self::Coaxiality => &[coupling::COAXIALITY_NAME],
            Self::TorqueAngle => plant::ANGLE_NAMES,
            Self::VelocityPosition => loops::CLOSED_NAMES,
        }
    }
}

const MEASURANDS: &[Measurand] = &[
    Measurand::new("velocity-bandwidth", Q::Frequency, "Lowest 0 dB crossing of the open velocity loop."),
    Measurand::new(
        "velocity-gain-margin",
        Q::Decibel,
        "Smallest gain margin of all -180 deg crossings of the open velocity loop.",
    ),
    Measurand::new(
        "velocity-phase-margin",
        Q::Angle,
        "Smallest phase margin of all 0 dB crossings of the open velocity loop.",
    ),
    Measurand::new(
        "velocity-delay-margin",
        Q::Time,
        "Delay margin: smallest additional delay that would make the velocity loop unstable.",
    ),
    Measurand::new(
        "velocity-modulus-margin",
        Q::Ratio,
        "Modulus margin: smallest distance of the open velocity loop from -1.",
    ),
    Measurand::new(
        "velocity-disk-margin",
        Q::Ratio,
        "Disk margin of the velocity loop: gain and phase may change together by this amount (Seiler et al. 2020).",
    ),
    Measurand::new("track-bandwidth", Q::Frequency, "Lowest 0 dB crossing of the open coarse track loop."),
    Measurand::new(
        "track-gain-margin",
        Q::Decibel,
        "Smallest gain margin of all -180 deg crossings of the open coarse track loop.",
    ),
    Measurand::new(
        "track-phase-margin",
        Q::Angle,
        "Smallest phase margin of all 0 dB crossings of the open coarse track loop.",
    ),
    Measurand::new(
        "current-bandwidth",
        Q::Frequency,
        "-3 dB frequency of the current loop by fit, with the hold of the command and the transport delay removed.",
    ),
    Measurand::new(
        "cross-coupling-low",
        Q::Ratio,
        "Largest rate of the other axis over the rate of this one up to 10 Hz, under torque on this one.",
    ),
    Measurand::new(
        "cross-coupling-high",
        Q::Ratio,
        "Largest rate of the other axis over the rate of this one above 10 Hz, under torque on this one.",
    ),
    Measurand::new(
        "sensor-coaxiality",
        Q::Ratio,
        "Largest departure of the modulus of integrated gyro over encoder from 1, up to 5 Hz.",
    ),
    Measurand::new(
        "direct-departure",
        Q::Ratio,
        "Bias of the direct estimate of torque to rate in the closed loop: largest departure from the \
         joint input-output estimate.",
    ),
    Measurand::new(
        plant::GAINS_NAME,
        Q::Ratio,
        "Torque to rate with other loop gains: root mean square departure from that with the first gains.",
    ),
    Measurand::new(
        "distortion",
        Q::Ratio,
        "Stochastic non-linear distortion of torque to rate over the response, median over the lines.",
    ),
    Measurand::new(
        "apparent-inertia",
        Q::Inertia,
        "Inertia from torque to angle up to 5 Hz, -Re(1/G)/w^2, if the torque constant is that of the rig file; friction has no \
         effect on it.",
    ),
    Measurand::new(
        "closed-velocity-bandwidth",
        Q::Frequency,
        "-3 dB frequency of the closed velocity loop, commanded rate to angle of the encoder times jw.",
    ),
    Measurand::new(
        "closed-velocity-peak",
        Q::Decibel,
        "Largest gain of the closed velocity loop, commanded rate to encoder angle times jw, interpolated \
         by a curve through the lines up to 8 Hz.",
    ),
    Measurand::new(
        "closed-velocity-bandwidth-gyro",
        Q::Frequency,
        "-3 dB frequency of the closed velocity loop by the integrated gyro, L/(1 + L).",
    ),
    Measurand::new(
        "closed-velocity-peak-gyro",
        Q::Decibel,
        "Largest gain of the closed velocity loop by the integrated gyro, L/(1 + L).",
    ),
];

/// The keys, read.
#[derive(Clone, Debug, PartialEq)]
struct Keys {
    excited: Excited,
    responses: Vec<Response>,
}

impl Keys {
    fn asks_for(&self, response: Response) -> bool {
        self.responses.contains(&response)
    }
}

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("frequency-response", include_str!("frequency_response/doc.md"), FIELDS, MEASURANDS);

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let excited = Excited::read(table);
        let names = table.spanned_texts("responses")?;
        let mut responses = Vec::new();
        for (name, span) in names {
            match RESPONSES.iter().find(|(known, _)| *known == name) {
                Some((_, response)) => responses.push(*response),
                None => {
                    let help = unknown_response(&name);
                    table.mistake_at(span, format!("unknown response `{name}`"), Some(help));
                }
            }
        }
        let excited = excited?;
        let behind_a_target = excited.background.target_turn_s.is_some();
        let others = responses.iter().any(|r| *r != Response::TrackLoop);
        if responses.contains(&Response::TrackLoop) != behind_a_target || behind_a_target && others {
            let help = "`track-loop` alone, with `by = \"target\"` in `[background]`; all others without";
            table.mistake(
                "responses",
                "a track loop is measured while a target is tracked, and nothing else is",
                Some(help.to_owned()),
            );
        }
        if responses.contains(&Response::VelocityPosition) && excited.into != Injection::Velocity {
            let help = "`into = \"velocity\"` in `[excitation]`: with an injected torque the command is \
                        itself a response";
            table.mistake(
                "responses",
                "`velocity-position` needs a signal that is added to the command",
                Some(help.to_owned()),
            );
        }
        let loose = excited.into != Injection::Velocity || excited.gain_ratio.is_some();
        if responses.contains(&Response::VelocityLoop) && loose {
            let help = "`into = \"velocity\"` in `[excitation]`, without `gain-ratio`";
            table.mistake(
                "responses",
                "`velocity-loop` is measured at the command of the loop, with its production gains",
                Some(help.to_owned()),
            );
        }
        Some(Self { excited, responses })
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let departure = self.asks_for(Response::Plant) && self.excited.gain_ratios.len() > 1;
        let names = self.responses.iter().flat_map(|r| r.measurands().iter().copied());
        Some(names.chain(departure.then_some(plant::GAINS_NAME)).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        if axes.gimbal_index(axis).is_none()
            && let Some((name, _)) =
                RESPONSES.iter().find(|(_, own)| own.needs_gimbal() && self.asks_for(*own))
        {
            let message =
                format!("response `{name}` needs two axes, one carrying the other; axis `{axis}` has none");
            return Err(vec![Diagnostic::new(message).help(format!("remove `{name}` from `responses`"))]);
        }
        let mut cases = excited::plan(&self.excited, axis, axes)?;
        cases.iter_mut().for_each(|case| case.looks_at_others = self.asks_for(Response::CrossAxis));
        Ok(cases)
    }

    fn notes(&self, axis: &str, axes: &Axes) -> Vec<String> {
        excited::notes(&self.excited, axis, axes)
    }

    fn cuts(&self, axis: &str, axes: &Axes) -> Vec<String> {
        excited::moved(&self.excited, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        point::conclude(self, cases, points, axes)
    }
}
