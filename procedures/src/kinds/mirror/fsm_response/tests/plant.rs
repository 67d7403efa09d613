//! A mirror in closed form: second order behind a hold and a delay, stepped exactly, and what it leaves in the log.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use crate::case::{Case, MirrorChannel};
use crate::kinds::mirror::fsm_response::mirror_axis;
use crate::log::{Channel, EndedBy, Rows, SegmentSpan, Topic, Width, Window};
use crate::synthetic::Random;

const ROW_HZ: f64 = 4000.0;
/// Steps of the plant in a row.
const STEPS: usize = 20;
const STEP_S: f64 = 1.0 / ROW_HZ / STEPS as f64;

#[derive(Clone, Debug)]
pub(super) struct Plant {
    pub(super) frequency_hz: f64,
    pub(super) damping_ratio: f64,
    pub(super) analog_delay_s: f64,
    /// Time on the line, without a sign, and in the unit.
    pub(super) serial_delay_s: f64,
    /// By how much a negative order is later.
    pub(super) sign_s: f64,
    /// Scale of the serial channel.
    pub(super) serial_gain: f64,
    /// Frequency, damping, size of a bend on the response.
    pub(super) support: Option<[f64; 3]>,
    pub(super) stroke_rad: f64,
    /// Gauge over tilt.
    pub(super) gauge_ratio: f64,
    /// Quadratic term of the gauge.
    pub(super) bend_per_rad: f64,
    pub(super) noise_rad: f64,
    pub(super) has_reference: bool,
}

impl Default for Plant {
    fn default() -> Self {
        Self {
            frequency_hz: 150.0,
            damping_ratio: 0.5,
            analog_delay_s: 50e-6,
            serial_delay_s: 150e-6 + 90.0 / 937.5e3,
            sign_s: 10.0 / 937.5e3,
            serial_gain: 1.0,
            support: None,
            stroke_rad: 1.2e-3,
            gauge_ratio: 1.0,
            bend_per_rad: 0.0,
            noise_rad: 0.1e-6,
            has_reference: true,
        }
    }
}

/// ÿ = ω²·(u − y) − 2ζω·ẏ, exact for an input that holds over a step.
struct SecondOrder {
    omega: f64,
    damping_ratio: f64,
    y: f64,
    rate: f64,
}

impl SecondOrder {
    fn new(frequency_hz: f64, damping_ratio: f64) -> Self {
        Self { omega: TAU * frequency_hz, damping_ratio, y: 0.0, rate: 0.0 }
    }

    fn step(&mut self, input: f64) {
        let decay = self.damping_ratio * self.omega;
        let ring = (self.omega * self.omega - decay * decay).sqrt();
        let (sin, cos) = (ring * STEP_S).sin_cos();
        let shrink = (-decay * STEP_S).exp();
        let x = self.y - input;
        let v = self.rate;
        self.y = input + shrink * (x * cos + (v + decay * x) / ring * sin);
        self.rate = shrink * (v * cos - (decay * v + self.omega * self.omega * x) / ring * sin);
    }
}

/// Orders on their way, each with the time at which it acts, and the one that acts.
#[derive(Default)]
struct Input {
    orders: VecDeque<[f64; 2]>,
    acting: f64,
}

impl Input {
    fn mean_over_step(&mut self, from_s: f64) -> f64 {
        let mut mean = self.acting;
        while let Some(&[at_s, order]) = self.orders.front().filter(|[at_s, _]| *at_s < from_s + STEP_S) {
            mean += (order - self.acting) * (1.0 - (at_s - from_s).max(0.0) / STEP_S);
            self.acting = order;
            self.orders.pop_front();
        }
        mean
    }
}

impl Plant {
    /// What a run of a case leaves: the command of a tick is sent in the next one, the gauge is read before.
    pub(super) fn run(&self, case: &Case) -> Window {
        let mut random = Random::new(case.point.bytes().map(u64::from).sum());
        let axis = mirror_axis(case).expect("a mirror point");
        let serial = case.mirror_channel == Some(MirrorChannel::Serial);
        let gain = if serial { self.serial_gain } else { 1.0 };
        let delay_s = |order: f64| match (serial, order.is_sign_negative()) {
            (false, _) => self.analog_delay_s,
            (true, false) => self.serial_delay_s,
            (true, true) => self.serial_delay_s + self.sign_s,
        };
        let mut input = Input::default();
        let mut body = SecondOrder::new(self.frequency_hz, self.damping_ratio);
        let mut support = self.support.map(|[hz, damping, _]| SecondOrder::new(hz, damping));
        let mut time_s = Vec::new();
        let mut columns = vec![Vec::new(); 6];
        let mut next = 0.0;
        let mut segments = Vec::new();
        for (index, segment) in case.segments.iter().enumerate() {
            let ticks = (segment.at_most_s * ROW_HZ).round() as u32;
            let start_s = time_s.len() as f64 / ROW_HZ;
            for k in 0..ticks {
                let sent = next;
                let tilt = self.tilt(&body, support.as_ref());
                let excitation = segment.excited.map(|e| &case.excitations[e]);
                next = excitation.map_or(0.0, |e| e.at(f64::from(k) / ROW_HZ));
                time_s.push(time_s.len() as f64 / ROW_HZ);
                let shown = self.gauge_ratio * tilt + self.bend_per_rad * tilt * tilt;
                let row = [sent, shown + self.noise_rad * random.normal(), tilt + 0.05e-6 * random.normal()];
                for (part, value) in row.into_iter().enumerate() {
                    columns[2 * part + axis].push(value);
                    columns[2 * part + 1 - axis].push(0.0);
                }
                let now_s = (time_s.len() - 1) as f64 / ROW_HZ;
                input.orders.push_back([now_s + delay_s(sent), gain * sent]);
                for step in 0..STEPS {
                    let held = input.mean_over_step(now_s + step as f64 * STEP_S) / self.gauge_ratio;
                    body.step(held.clamp(-self.stroke_rad, self.stroke_rad));
                    if let Some(support) = &mut support {
                        support.step(body.y);
                    }
                }
            }
            let end_s = time_s.len() as f64 / ROW_HZ;
            let ended_by = EndedBy::Completed;
            segments.push(SegmentSpan { segment: index, start_s, end_s, start_position_rad: 0.0, ended_by });
        }
        self.window(time_s, columns, segments)
    }

    /// The mirror, bent by a·2ζ·(s/ω)/(s²/ω² + 2ζs/ω + 1), which is a·2ζ/ω times the rate of the support.
    fn tilt(&self, body: &SecondOrder, support: Option<&SecondOrder>) -> f64 {
        let bend = self
            .support
            .zip(support)
            .map_or(0.0, |([_, damping, size], support)| size * 2.0 * damping * support.rate / support.omega);
        body.y + bend
    }

    fn window(&self, time_s: Vec<f64>, columns: Vec<Vec<f64>>, segments: Vec<SegmentSpan>) -> Window {
        let names = ["command_az", "command_el", "angle_az", "angle_el", "reference_az", "reference_el"];
        let count = if self.has_reference { 6 } else { 4 };
        let channel =
            |name: &&str| Channel { name: format!("{name}_rad"), unit: "rad".to_owned(), width: Width::F32 };
        let channels = names[..count].iter().map(channel).collect();
        let topic = Topic { name: "/fsm".to_owned(), message: "test".to_owned(), channels };
        let columns = columns.into_iter().take(count).collect();
        Window::completed(vec![Rows { topic, time_s, columns }], segments)
    }
}
