//! Fast steering mirror. Pairs are azimuth, elevation.

mod rows;

pub(super) use rows::MIRROR;

/// Fast steering mirror; pairs are azimuth, elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorSettings {
    /// Natural frequency of the axis; which axis has which mode is a matter of exchanging the two.
    pub frequency_hz: [f64; 2],
    /// Damping ratio from actuator demand to angle.
    pub damping_ratio: [f64; 2],
    /// One-sided stroke.
    pub stroke_rad: [f64; 2],
    /// Share that the stroke towards negative tilt is shorter than the other.
    pub stroke_asymmetry_ratio: [f64; 2],
    /// Share of the actuator travel of one axis that tilts the other.
    pub cross_coupling_ratio: f64,
    /// Moving inertia of an axis with its payload: sets the reaction torque.
    pub inertia_kg_m2: f64,
    /// Natural frequency of what carries the mirror.
    pub support_frequency_hz: f64,
    /// Damping ratio of what carries the mirror.
    pub support_damping_ratio: f64,
    /// Moving inertia over that of the support: 0 rigid mount, 0.2 % on the assembly, 2 % on the optical table.
    pub support_coupling_ratio: f64,
    /// Opening of the open-loop hysteresis over full stroke.
    pub hysteresis_ratio: f64,
    /// Creep per decade of time from 0.1 s to 100 s.
    pub creep_per_decade_ratio: f64,
    /// Angle per volt at the piezo stacks.
    pub actuator_gain_rad_per_v: f64,
    /// Peak-to-peak output range of the amplifier, about its bias.
    pub amplifier_voltage_v: f64,
    /// Peak current of the amplifier.
    pub amplifier_current_a: f64,
    /// Cut-off of the amplifier, first order.
    pub amplifier_cutoff_hz: f64,
    /// Cut-off of the strain gauge conditioner, first order.
    pub gauge_cutoff_hz: f64,
    /// Standard deviation of the strain gauge noise, new every 8 steps, held between.
    pub gauge_noise_rad: f64,
    /// Share of actuator strain instead of mirror angle in the gauge: they part near the mode.
    pub gauge_departure_ratio: f64,
    /// Quantum of the digitised strain gauge.
    pub resolution_rad: f64,
    /// Proportional gain P.
    pub proportional_gain_ratio: f64,
    /// Integral gain I.
    pub integral_gain_per_s: f64,
    /// Double integral gain I2.
    pub double_integral_gain_per_s2: f64,
    /// 1: notch in the loop; 0: left out.
    pub notch_switch: f64,
    /// Centre of the notch.
    pub notch_frequency_hz: [f64; 2],
    /// Damping ratio of the notch's zeros.
    pub notch_numerator_damping_ratio: f64,
    /// Damping ratio of the notch's poles.
    pub notch_denominator_damping_ratio: f64,
    /// 1: closed when ordered; 0: broken, the unit says it is closed and stays open: hysteresis and creep uncorrected.
    pub strain_gauge_loop_switch: f64,
    /// Extra delay inside the loop.
    pub loop_delay_s: f64,
    /// Angle per volt of command and monitor, analog and serial.
    pub scale_rad_per_v: [f64; 2],
    /// Delay of the analog command channel.
    pub analog_delay_s: f64,
    /// Delay from the last character of a serial order to its effect.
    pub serial_delay_s: f64,
    /// Bit rate of the serial line at power-up, 10 bits a character.
    pub serial_bit_rate_hz: f64,
    /// 1: configuration switch 2 is mounted, serial orders for the source are ignored.
    pub analog_only_switch: f64,
    /// Capacitance of an axis at 20 Hz, motional branch included.
    pub capacitance_f: f64,
    /// Electromechanical coupling k2: motional over whole capacitance at 20 Hz.
    pub coupling_ratio: f64,
    /// Damping ratio of the bare mechanism, as the impedance shows it.
    pub bare_damping_ratio: f64,
    /// Dielectric loss tangent.
    pub loss_tangent_ratio: f64,
    /// Leads and electrodes.
    pub series_resistance_ohm: f64,
    /// Leakage across the stacks.
    pub leak_resistance_ohm: f64,
}

impl Default for MirrorSettings {
    /// The mirror of the unit `nominal`.
    fn default() -> Self {
        Self {
            frequency_hz: [322.0, 350.0],
            damping_ratio: [0.36, 0.36],
            stroke_rad: [1.05e-3, 1.05e-3],
            stroke_asymmetry_ratio: [0.0, 0.0],
            cross_coupling_ratio: 0.005,
            inertia_kg_m2: 6e-4,
            support_frequency_hz: 140.0,
            support_damping_ratio: 0.02,
            support_coupling_ratio: 0.002,
            hysteresis_ratio: 0.15,
            creep_per_decade_ratio: 0.02,
            actuator_gain_rad_per_v: 14e-6,
            amplifier_voltage_v: 150.0,
            amplifier_current_a: 2.4,
            amplifier_cutoff_hz: 20_000.0,
            gauge_cutoff_hz: 20_000.0,
            gauge_noise_rad: 0.1e-6,
            gauge_departure_ratio: 0.02,
            resolution_rad: 0.2e-6,
            proportional_gain_ratio: 0.08,
            integral_gain_per_s: 500.0,
            double_integral_gain_per_s2: 1.0e5,
            notch_switch: 1.0,
            notch_frequency_hz: [322.0, 350.0],
            notch_numerator_damping_ratio: 0.36,
            notch_denominator_damping_ratio: 1.0,
            strain_gauge_loop_switch: 1.0,
            loop_delay_s: 0.0,
            scale_rad_per_v: [500e-6, 500e-6],
            analog_delay_s: 50e-6,
            serial_delay_s: 150e-6,
            serial_bit_rate_hz: 937_500.0,
            analog_only_switch: 0.0,
            capacitance_f: 30.2e-6,
            coupling_ratio: 0.1,
            bare_damping_ratio: 0.02,
            loss_tangent_ratio: 0.02,
            series_resistance_ohm: 0.1,
            leak_resistance_ohm: 1.0e6,
        }
    }
}
