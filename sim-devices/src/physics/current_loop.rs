//! Current loop of a drive: first order, exact for a command that is constant over a step.

/// The current that follows a command.
#[derive(Clone, Debug)]
pub struct CurrentLoop {
    /// What is left of a difference after one step, `e^{−h/τ}`.
    decay: f64,
    /// Mean over the step of what is left of a difference.
    mean: f64,
    current_a: f64,
    lag: Lag,
}

/// Course of a current during one step: from one value towards another, without ever reaching it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lag {
    /// At the begin of the step.
    pub from_a: f64,
    /// Where it would go.
    pub towards_a: f64,
}

impl Lag {
    /// The current so long after the begin of the step, through a loop of this −3 dB bandwidth; 0 Hz means ideal.
    pub fn at(&self, bandwidth_hz: f64, within_s: f64) -> f64 {
        let left =
            if bandwidth_hz > 0.0 { (-std::f64::consts::TAU * bandwidth_hz * within_s).exp() } else { 0.0 };
        self.towards_a + left * (self.from_a - self.towards_a)
    }
}

impl CurrentLoop {
    /// A loop of this −3 dB bandwidth, without current, for steps of `step_s`; 0 Hz means ideal.
    pub fn new(bandwidth_hz: f64, step_s: f64) -> Self {
        let x = std::f64::consts::TAU * bandwidth_hz * step_s;
        let (decay, mean) = if x > 0.0 { ((-x).exp(), -(-x).exp_m1() / x) } else { (0.0, 0.0) };
        Self { decay, mean, current_a: 0.0, lag: Lag::default() }
    }

    /// One step towards a command; the mean current over the step.
    #[inline]
    pub fn step(&mut self, command_a: f64) -> f64 {
        let missing_a = self.current_a - command_a;
        self.lag = Lag { from_a: self.current_a, towards_a: command_a };
        self.current_a = command_a + self.decay * missing_a;
        command_a + self.mean * missing_a
    }

    /// Current now.
    #[inline]
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Course of the current during the last step.
    #[inline]
    pub fn lag(&self) -> Lag {
        self.lag
    }

    /// The power stage switches off: the current is gone at once.
    pub fn switch_off(&mut self) {
        self.current_a = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_rises_with_the_time_constant_and_loses_one_time_constant_of_charge() {
        let mut current = CurrentLoop::new(1000.0, 50e-6);
        let mut charge = 0.0;
        for k in 1..=200_u32 {
            charge += 50e-6 * current.step(10.0);
            let exact = 10.0 * (1.0 - (-std::f64::consts::TAU * 1000.0 * 50e-6 * f64::from(k)).exp());
            assert!((current.current_a() - exact).abs() < 1e-12);
        }
        let lag_s = 200.0 * 50e-6 - charge / 10.0;
        assert!((lag_s - 159.155e-6).abs() < 1e-9, "{lag_s}");
    }

    #[test]
    fn the_course_inside_a_step_ends_where_the_next_step_begins() {
        let mut current = CurrentLoop::new(1000.0, 50e-6);
        for command_a in [10.0, 10.0, -3.0, 0.5] {
            current.step(command_a);
            assert!((current.lag().at(1000.0, 50e-6) - current.current_a()).abs() < 1e-12);
        }
        let half = Lag { from_a: 0.0, towards_a: 1.0 }.at(1000.0, 0.159_155e-3);
        assert!((half - (1.0 - (-1.0_f64).exp())).abs() < 1e-5, "{half}");
    }

    #[test]
    fn an_ideal_loop_gives_what_is_asked() {
        assert_eq!(CurrentLoop::new(0.0, 50e-6).step(3.0), 3.0);
    }
}
