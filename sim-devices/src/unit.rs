//! Settings of a simulated unit, SI units. Only the simulation obeys them; the bench never sees them.

mod atmosphere;
mod body;
mod drive;
mod friction;
mod imu;
mod instruments;
mod mirror;
mod motor;
mod nominal;
mod parameters;
mod row;
mod setting;
mod structure;
mod supply;
mod table;
mod target;
mod tracker;
mod wiring;

pub use atmosphere::AtmosphereSettings;
pub use imu::ImuSettings;
pub use instruments::InstrumentsSettings;
pub use mirror::MirrorSettings;
pub use parameters::PARAMETERS;
pub use setting::{Field, FieldOfPart, Setting};
pub use structure::{CURVES, Curve, ModeCurves, StructureSettings};
pub use supply::SupplySettings;
pub use table::{AXIS_PARAMETERS, MOST_AXES, TABLE_PARAMETERS, TableAxis, TableSettings};
pub use target::TargetSettings;
pub use tracker::{CameraSettings, TrackersSettings};
pub use wiring::WiringSettings;

/// One axis of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSettings {
    /// Inertia about the axis.
    pub inertia_kg_m2: f64,
    /// Unbalance A_u: torque A_u·cos θ.
    pub unbalance_nm: f64,
    /// Stiffness of cables and hoses K_s.
    pub spring_stiffness_nm_per_rad: f64,
    /// Angle at which cables and hoses bear no torque.
    pub spring_rest_rad: f64,
    /// Cogging periods per revolution: least common multiple of slots and poles.
    pub cogging_orders_per_rev: f64,
    /// Amplitude of the cogging fundamental A_c·sin(2πθ/period + phase).
    pub cogging_amplitude_nm: f64,
    /// Phase of the fundamental at θ = 0.
    pub cogging_phase_rad: f64,
    /// Amplitude of the second harmonic.
    pub cogging_second_amplitude_nm: f64,
    /// Phase of the second harmonic at θ = 0.
    pub cogging_second_phase_rad: f64,
    /// Periods per revolution of a torque order of its own beside cogging.
    pub ripple_orders_per_rev: f64,
    /// Its amplitude.
    pub ripple_amplitude_nm: f64,
    /// Its phase at θ = 0.
    pub ripple_phase_rad: f64,
    /// Lower hard stop.
    pub lower_stop_rad: f64,
    /// Upper hard stop.
    pub upper_stop_rad: f64,
    /// Stiffness of the stops.
    pub stop_stiffness_nm_per_rad: f64,
    /// Damping of the stops.
    pub stop_damping_nm_s_per_rad: f64,
    /// Coulomb torque T_C.
    pub coulomb_torque_nm: f64,
    /// Static torque T_S of a fresh contact.
    pub static_torque_nm: f64,
    /// Stribeck velocity ω_s.
    pub stribeck_velocity_rad_per_s: f64,
    /// Stribeck shape δ.
    pub stribeck_shape_exponent: f64,
    /// Viscous coefficient σ2.
    pub viscous_damping_nm_s_per_rad: f64,
    /// Bristle stiffness σ0.
    pub bristle_stiffness_nm_per_rad: f64,
    /// Bristle damping σ1.
    pub bristle_damping_nm_s_per_rad: f64,
    /// Growth of the static torque per unit of ln(1 + age/ageing-time), relative to static-torque.
    pub ageing_ratio: f64,
    /// Time scale of ageing τ_d.
    pub ageing_time_s: f64,
    /// Age at which the contact stops ageing.
    pub ageing_limit_s: f64,
    /// Share by which Coulomb and static torque are higher towards larger angles, and lower towards smaller ones.
    pub friction_asymmetry_ratio: f64,
    /// Share by which Coulomb and static torque are higher in the middle of a spot.
    pub friction_spot_ratio: f64,
    /// Middle of the spot.
    pub friction_spot_rad: f64,
    /// Width of the spot at half its height.
    pub friction_spot_width_rad: f64,
    /// Torque constant: motor torque per ampere.
    pub torque_constant_nm_per_a: f64,
    /// Change of the torque constant per kelvin of the heat sink above ambient.
    pub torque_constant_per_k_ratio: f64,
    /// +1 or -1: whether positive current turns the axis towards larger angles.
    pub motor_sign_factor: f64,
    /// Largest current the drive can give.
    pub current_limit_a: f64,
    /// Standard deviation of the measured current, white per exchange.
    pub current_noise_a: f64,
    /// Bits of the single-turn encoder.
    pub encoder_bits_count: f64,
    /// Real counts per turn over those that the drive says (608Fh).
    pub encoder_modulus_ratio: f64,
    /// Angle at which the encoder counts zero.
    pub encoder_zero_rad: f64,
    /// +1 or -1: whether counts grow with the angle.
    pub encoder_sign_factor: f64,
    /// Once-per-revolution error of the encoder: it reads θ + this·sin(θ + phase).
    pub encoder_eccentricity_rad: f64,
    /// Phase of the once-per-revolution error at θ = 0.
    pub encoder_eccentricity_phase_rad: f64,
    /// Twice-per-revolution error of the encoder.
    pub encoder_second_order_rad: f64,
    /// Phase of the twice-per-revolution error at θ = 0.
    pub encoder_second_order_phase_rad: f64,
    /// Largest error within a pitch of the encoder's scale (interpolation).
    pub encoder_interpolation_rad: f64,
    /// Pitches of the encoder's scale per revolution.
    pub encoder_pitches_per_rev: f64,
    /// Standard deviation of the angle that the encoder sends, new with each sample.
    pub encoder_noise_rad: f64,
    /// Play of the coupling between axis and encoder.
    pub encoder_backlash_rad: f64,
    /// Share of the travel towards larger angles that the coupling of the encoder loses.
    pub encoder_slip_ratio: f64,
    /// Window of the backward difference from which the drive takes its velocity.
    pub velocity_window_s: f64,
    /// Rated current 6075h: 1 permille = 2 mA.
    pub rated_current_a: f64,
    /// Rated torque 6076h.
    pub rated_torque_nm: f64,
    /// Proportional gain of the drive's own velocity loop (CSV and ramps).
    pub velocity_gain_nm_s_per_rad: f64,
    /// Integral gain of the drive's own velocity loop.
    pub velocity_integral_gain_nm_per_rad: f64,
    /// Time of each power state transition towards torque and of a fault reset.
    pub transition_delay_s: f64,
    /// From the arrival of a command at the drive to its current.
    pub command_delay_s: f64,
    /// Age of position, velocity and current when the drive sends them.
    pub sensor_delay_s: f64,
    /// Largest extra command delay, uniform and new with each command.
    pub delay_jitter_s: f64,
    /// Bandwidth of the current loop.
    pub current_bandwidth_hz: f64,
    /// DC link voltage below which the drive trips (3120h).
    pub under_voltage_v: f64,
    /// DC link voltage above which the drive trips (3110h).
    pub over_voltage_v: f64,
    /// Ambient temperature of the drive.
    pub ambient_degc: f64,
    /// Steady rise of the heat sink above ambient at heat-sink-power.
    pub heat_sink_rise_degc: f64,
    /// Power that heat-sink-rise refers to.
    pub heat_sink_power_w: f64,
    /// Time constant of the heat sink.
    pub heat_sink_time_s: f64,
    /// What the heat sink is warmer late in a campaign than at its beginning, when a point begins.
    pub warm_up_degc: f64,
    /// Time constant of that.
    pub warm_up_time_s: f64,
    /// Losses at loss-current; they grow with the square of the current.
    pub loss_power_w: f64,
    /// Current that loss-power refers to.
    pub loss_current_a: f64,
    /// Heat sink temperature at which the drive warns.
    pub heat_sink_warning_degc: f64,
    /// Heat sink temperature at which the drive trips (4310h).
    pub heat_sink_shutdown_degc: f64,
    /// Winding resistance of the motor, for the current that the torque constant refers to.
    pub winding_resistance_ohm: f64,
    /// 1: the drive keeps the soft limits that it was given (607Dh).
    pub soft_limits_enforced_flag: f64,
}

impl AxisSettings {
    /// Whether the drive keeps the soft limits that it was given.
    pub fn soft_limits_enforced(&self) -> bool {
        self.soft_limits_enforced_flag >= 0.5
    }

    /// What the heat sink is warmer when a point begins so long after the beginning of the campaign, by the plan.
    pub fn warmed_degc(&self, planned_s: f64) -> f64 {
        warmed_degc(self.warm_up_degc, self.warm_up_time_s, planned_s)
    }

    /// Losses of motor and drive over the square of the current.
    pub fn loss_resistance_ohm(&self) -> f64 {
        self.winding_resistance_ohm + self.loss_power_w / (self.loss_current_a * self.loss_current_a)
    }
}

/// What something is warmer after a time that warms up by `rise_degc`, first order.
pub(crate) fn warmed_degc(rise_degc: f64, time_constant_s: f64, after_s: f64) -> f64 {
    -rise_degc * (-after_s / time_constant_s).exp_m1()
}

/// A simulated director.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitSettings {
    /// Azimuth.
    pub az: AxisSettings,
    /// Elevation.
    pub el: AxisSettings,
    /// Structure of azimuth over elevation.
    pub az_structure: StructureSettings,
    /// Structure of elevation over elevation.
    pub el_structure: StructureSettings,
    /// Inertial measurement unit on the elevation frame.
    pub imu: ImuSettings,
    /// Fast steering mirror.
    pub mirror: MirrorSettings,
    /// Coarse and fine video tracker.
    pub trackers: TrackersSettings,
    /// What the director points at.
    pub target: TargetSettings,
    /// Turbulence between director and target.
    pub atmosphere: AtmosphereSettings,
    /// DC link and power supply of both drives.
    pub supply: SupplySettings,
    /// Instruments on the bench.
    pub instruments: InstrumentsSettings,
    /// How much of azimuth's modes shows in the elevation of the frame, at elevation 0.
    pub cross_coupling_ratio: f64,
    /// What comes on top of it at the zenith; it grows with the sine of elevation.
    pub cross_coupling_growth_ratio: f64,
    /// How the unit is put together.
    pub wiring: WiringSettings,
    /// World sub-step rate.
    pub step_rate_hz: f64,
    /// How long after the beginning of the campaign the point begins, by the plan; a point says so, no unit file.
    pub planned_s: f64,
    /// Who pulls at an axis; a point says so, no unit file.
    pub pull: Option<crate::operator::PullSettings>,
}

impl UnitSettings {
    /// An axis: 0 azimuth, 1 elevation.
    ///
    /// # Panics
    /// For any other index.
    pub fn axis(&self, axis: usize) -> &AxisSettings {
        [&self.az, &self.el][axis]
    }

    /// An axis to be changed: 0 azimuth, 1 elevation.
    fn axis_mut(&mut self, axis: usize) -> &mut AxisSettings {
        if axis == 0 { &mut self.az } else { &mut self.el }
    }
}

impl Default for UnitSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        Self {
            az: nominal::AZIMUTH,
            el: nominal::ELEVATION,
            az_structure: structure::nominal::azimuth(),
            el_structure: structure::nominal::elevation(),
            imu: ImuSettings::default(),
            mirror: MirrorSettings::default(),
            trackers: TrackersSettings::default(),
            target: TargetSettings::default(),
            atmosphere: AtmosphereSettings::default(),
            supply: SupplySettings::default(),
            instruments: InstrumentsSettings::default(),
            cross_coupling_ratio: 0.005,
            cross_coupling_growth_ratio: 0.0,
            wiring: WiringSettings::default(),
            step_rate_hz: 20_000.0,
            planned_s: 0.0,
            pull: None,
        }
    }
}

/// A setting that every axis has.
struct AxisSetting {
    /// Key in the table of an axis, e.g. `inertia`.
    key: &'static str,
    quantity: &'static str,
    range_si: [f64; 2],
    /// Defaults of the director, in the order azimuth, elevation.
    defaults: [&'static str; 2],
    doc: &'static str,
    /// Where the figures of the director come from.
    source: &'static str,
    /// An axis of a rotary table.
    table: Figure,
    field: Field<AxisSettings>,
}

/// A default and where it comes from.
struct Figure {
    default: &'static str,
    source: &'static str,
}

impl AxisSetting {
    /// The setting of azimuth (0) or elevation (1) of the director.
    fn of_director(&self, axis: usize) -> Setting<Field<AxisSettings>> {
        // A key lives as long as the list of settings, which is made once and never dropped.
        let key = String::leak(format!("{}.{}", ["az", "el"][axis], self.key));
        self.setting(key, self.defaults[axis], self.source)
    }

    /// The setting of an axis of a rotary table.
    fn of_table(&self) -> Setting<Field<AxisSettings>> {
        self.setting(self.key, self.table.default, self.table.source)
    }

    fn setting(
        &self,
        key: &'static str,
        default: &'static str,
        source: &'static str,
    ) -> Setting<Field<AxisSettings>> {
        Setting {
            key,
            quantity: self.quantity,
            range_si: self.range_si,
            default,
            doc: self.doc,
            source,
            field: self.field,
        }
    }
}

#[cfg(test)]
mod tests;
