//! The settings of every law, as in `params/director.toml`.

use crate::velocity::VelocityLaw;

/// Gains of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisGains {
    /// Law of the velocity loop.
    pub velocity_law: VelocityLaw,
    /// Proportional gain of the velocity loop.
    pub velocity_kp_nm_s_per_rad: f64,
    /// Integral gain of the velocity loop.
    pub velocity_ki_nm_per_rad: f64,
    /// Gain of the position loop around the velocity loop.
    pub position_gain_per_s: f64,
    /// Coarse track loop around the velocity loop.
    pub track: TrackGains,
}

/// Gains of the coarse track loop of one axis: `ω_cmd = Kt (e + (1/Tt) ∫e)`, `e = θ_target − θ_LOS − Tp ω_gyro`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackGains {
    /// Kt: rate command per error.
    pub gain_per_s: f64,
    /// Tt: time in which the integral repeats the proportional part; 0 switches the integral off.
    pub integral_time_s: f64,
    /// Tp: lead on the gyro rate; holds the gyro's own age, too.
    pub gyro_lead_s: f64,
}

/// What both axes of the coarse track loop share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackSettings {
    /// Age of the summed line of sight: that of a gyro sample when the law gets it, less half a period of the law.
    pub gyro_age_s: f64,
    /// Without a frame for this long the target counts as missing.
    pub dropout_s: f64,
    /// A missing target is held for this long, then it is lost.
    pub hold_s: f64,
    /// Whether the target's rate is estimated and used.
    pub prediction: Prediction,
    /// α of the target's estimate.
    pub alpha: f64,
    /// β of the target's estimate.
    pub beta: f64,
}

/// How a target is thought to move between its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prediction {
    /// Not at all.
    #[default]
    Off,
    /// With a constant rate, which an α-β filter estimates.
    ConstantVelocity,
}

/// Fine track loop: fine camera → mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FineTrackGains {
    /// K of the integrator, in line-of-sight angle per time and error.
    pub gain_per_s: f64,
    /// Mirror angle per line-of-sight angle, azimuth, with its sign.
    pub az_optical_gain: f64,
    /// Mirror angle per line-of-sight angle, elevation, with its sign.
    pub el_optical_gain: f64,
    /// Largest mirror angle that is commanded.
    pub stroke_rad: f64,
    /// Without a frame for this long the target counts as missing.
    pub dropout_s: f64,
    /// After this long without a target the mirror goes back to its centre.
    pub hold_s: f64,
    /// How fast it goes back.
    pub return_rate_rad_per_s: f64,
}

/// Transfer of the mirror's mean angle to the gimbal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OffLoadGains {
    /// Gimbal rate per mean mirror angle, both as line of sight.
    pub gain_per_s: f64,
    /// Time in which the integral repeats the proportional part; 0 switches the integral off.
    pub integral_time_s: f64,
    /// Corner of the low-pass that makes the mean.
    pub filter_hz: f64,
    /// Largest rate that is commanded.
    pub rate_limit_rad_per_s: f64,
}

/// The mirror's own position loop: PI + I² and a notch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MirrorGains {
    /// P, drive per error; both are angles.
    pub proportional: f64,
    /// I.
    pub integral_per_s: f64,
    /// I².
    pub double_integral_per_s2: f64,
    /// Centre of azimuth's notch.
    pub az_notch_hz: f64,
    /// Centre of elevation's notch.
    pub el_notch_hz: f64,
    /// ζ of the notch's numerator: the mode's. Equal to the denominator's it switches the notch off.
    pub notch_numerator_damping: f64,
    /// ζ of the notch's denominator.
    pub notch_denominator_damping: f64,
    /// Largest drive.
    pub drive_limit_rad: f64,
}

/// Where the unit stands on the Earth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EarthSettings {
    /// Geodetic latitude, north positive.
    pub latitude_rad: f64,
    /// Compass heading (clockwise from north) of the line of sight at azimuth 0.
    pub azimuth_zero_heading_rad: f64,
}

/// Cross-elevation control near the zenith.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KeyholeSettings {
    /// Elevation from which on the integral fades.
    pub start_rad: f64,
    /// Elevation beyond which the secant grows no more and the integral stands.
    pub limit_rad: f64,
    /// So far below the limit the keyhole is left again.
    pub hysteresis_rad: f64,
}

/// Braking in front of soft limits and restricted zones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnvelopeSettings {
    /// Deceleration that the axis can be relied on for.
    pub deceleration_rad_per_s2: f64,
    /// Time from a rate command to the rate, one tick included.
    pub reaction_time_s: f64,
}

/// Most axes of a rig.
pub(crate) const MOST_AXES: usize = 4;

/// Everything in `params/director.toml`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectorGains {
    /// Azimuth.
    pub az: AxisGains,
    /// Elevation.
    pub el: AxisGains,
    /// Gains of the axes of a rig, in its order, each from the section that the rig names; zero beyond its last axis.
    pub axes: [AxisGains; MOST_AXES],
    /// Sign of the IMU's mount: −1 where the mapping as published gives −d(el)/dt.
    pub elevation_sign: f64,
    /// Earth-rate compensation.
    pub earth: EarthSettings,
    /// Coarse tracking, both axes.
    pub track: TrackSettings,
    /// Fine tracking.
    pub fine: FineTrackGains,
    /// Off-load of the mirror.
    pub off_load: OffLoadGains,
    /// The mirror's loop.
    pub mirror: MirrorGains,
    /// Keyhole.
    pub keyhole: KeyholeSettings,
    /// Braking.
    pub envelope: EnvelopeSettings,
}
