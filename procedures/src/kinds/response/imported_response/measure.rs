//! From responses to measurements and pictures; lines that do not count stay visible as hollow markers.

use analysis::estimate::Estimate;
use analysis::frf::{DB_PER_NEPER, Line, unwrapped_rad};

use super::answer::{self, Answer, Named};
use super::peaks::{Peak, inverse, maxima};
use super::{Keys, Source, periodic};
use crate::case::Case;
use crate::kinds::response::{coherence_panel, phase_panel};
use crate::log::Window;
use crate::measurement::{Conclusion, Condition, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};
use crate::trace::{MAX_POINTS, Mark, Plot, Scale, Series, Style};

/// Estimator and version.
const ESTIMATOR: &str = "imported-response/1";

/// Analyses one point: every response of its record.
pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window) -> PointResult {
    let mut result = PointResult::of(case);
    let all = match answers(keys, case, window) {
        Ok(all) => all,
        Err(reason) => {
            let whole = On { keys, case, number: 0, name: "" };
            result.measurements = whole.nothing(&reason);
            result.inconclusive = Some(reason);
            return result;
        }
    };
    for named in &all {
        let part = On { keys, case, number: named.number, name: &named.name };
        match &named.answer {
            Ok(answer) => {
                let peaks = Peaks::of(keys, named, answer);
                result.measurements.extend(part.measure(named, answer, &peaks));
                result.remarks.extend(answer.distortion.as_ref().map(|found| part.amplitudes(found)));
                result.plots.extend(bode(&case.point, named, answer, &peaks));
                result.excluded.extend(answer.excluded.iter().cloned());
            }
            Err(reason) => {
                result.measurements.extend(part.nothing(reason));
                result.inconclusive.get_or_insert_with(|| Reason::of_point(&named.name, reason));
            }
        }
    }
    result
}

/// All points together: each stands for itself.
pub(super) fn conclude(keys: &Keys, points: &[PointResult]) -> Conclusion {
    let mut whole = Conclusion::default();
    for point in points {
        whole.measurements.extend(point.measurements.iter().cloned());
        whole.plots.extend(point.plots.iter().cloned());
    }
    if let Source::Periodic { responses, .. } = &keys.source {
        let names = responses.iter().enumerate().map(|(k, r)| format!("{}: {}", k + 1, r.name));
        whole.remarks.push(format!("Responses by number: {}.", names.collect::<Vec<_>>().join("; ")));
    }
    whole.remarks.extend(points.iter().flat_map(|point| point.remarks.clone()));
    whole
}

fn answers(keys: &Keys, case: &Case, window: &Window) -> Result<Vec<Named>, Reason> {
    let topic = format!("/{}", case.axis);
    let rows = window.topic(&topic)?;
    match &keys.source {
        Source::Analyser { least_coherence, averages } => {
            let answer = answer::read(rows, *least_coherence, *averages);
            Ok(vec![Named { name: case.point.clone(), number: 1, find: keys.find, answer }])
        }
        Source::Periodic { record, responses } => {
            let span = window.segments.first().ok_or(ResponseReason::NoSegment)?;
            let within = rows.range(span.start_s, span.end_s);
            let periods = periodic::Periods::new(rows, &within, record)?;
            let named = |(k, r): (usize, &super::Response)| Named {
                name: r.name.clone(),
                number: k + 1,
                find: r.find.unwrap_or(keys.find),
                answer: periods.answer(r),
            };
            Ok(responses.iter().enumerate().map(named).collect())
        }
    }
}

/// Resonances and anti-resonances of a response.
pub(super) struct Peaks {
    pub(super) resonances: Vec<Peak>,
    pub(super) antiresonances: Vec<Peak>,
}

impl Peaks {
    fn of(keys: &Keys, named: &Named, answer: &Answer) -> Self {
        // Lines that do not count are looked at, too: a peak that is not certified still has a place. Where variances
        // are known, only those that count: the others would rule the fit by their number.
        let lines = if answer.least_coherence.is_some() { answer.all() } else { answer.lines.clone() };
        let find = |lines: &[Line], wanted: bool| {
            if wanted { maxima(lines, keys.band_hz, keys.least_prominence) } else { Vec::new() }
        };
        Self {
            resonances: find(&lines, named.find.resonances),
            antiresonances: find(&inverse(&lines), named.find.antiresonances),
        }
    }
}

/// What measurements of one response share.
struct On<'a> {
    keys: &'a Keys,
    case: &'a Case,
    number: usize,
    name: &'a str,
}

impl On<'_> {
    fn blank(&self, measurand: &str, kind: Q, estimate: Option<Estimate>) -> Measurement {
        let mut m = Measurement::new(measurand, &self.case.axis, kind, estimate, ESTIMATOR);
        m.point = Some(self.case.point.clone());
        if self.number > 0 {
            m.conditions.push(condition("response", self.number as f64, Q::Count));
        }
        m.flags.extend((!self.name.is_empty()).then(|| self.name.to_owned()));
        m
    }

    /// Every measurand without a value, and why.
    fn nothing(&self, reason: &Reason) -> Vec<Measurement> {
        let given = super::MEASURANDS.iter().filter(|m| self.keys.gives(m.name));
        let of = |m: &super::Measurand| Measurement {
            inconclusive: Some(reason.to_string()),
            ..self.blank(m.name, m.kind, None)
        };
        given.map(of).collect()
    }

    fn measure(&self, named: &Named, answer: &Answer, peaks: &Peaks) -> Vec<Measurement> {
        let mut all = vec![self.deviation(answer)];
        if named.find.resonances {
            all.extend(self.frequencies("resonance-frequency", answer, &peaks.resonances));
            all.extend(peaks.resonances.iter().zip(1..).map(|(p, k)| self.damping(answer, p, k)));
        }
        if named.find.antiresonances {
            all.extend(self.frequencies("antiresonance-frequency", answer, &peaks.antiresonances));
        }
        let lines = answer.all();
        all.extend(self.keys.at_hz.iter().flat_map(|hz| self.at(answer, &lines, *hz)));
        all.extend(self.distortion(answer));
        for m in &mut all {
            m.excluded.clone_from(&answer.excluded);
            m.evidence.clone_from(&answer.evidence);
            m.flags.extend(answer.flags.iter().cloned());
            m.flags.extend(answer.unknown.iter().map(ResponseReason::to_string));
        }
        all
    }

    /// Median over the lines of sd/|G|; its uncertainty from the order statistics half a root of n away.
    fn deviation(&self, answer: &Answer) -> Measurement {
        // Without the noisy lines of a periodic record the median would flatter it.
        let lines = if answer.least_coherence.is_some() { answer.lines.clone() } else { answer.all() };
        let mut ratios: Vec<f64> = lines.iter().map(|l| l.variance.sqrt() / l.value.norm()).collect();
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len();
        let reason = answer.unknown.clone().or_else(|| (n == 0).then_some(ResponseReason::NoLine));
        if let Some(reason) = reason {
            return Measurement {
                inconclusive: Some(reason.to_string()),
                ..self.blank("relative-deviation", Q::Ratio, None)
            };
        }
        let half = (0.5 * (n as f64).sqrt()).ceil() as usize;
        let value = 0.5 * (ratios[(n - 1) / 2] + ratios[n / 2]);
        let low = ratios[(n / 2).saturating_sub(half)];
        let high = ratios[(n / 2 + half).min(n - 1)];
        let estimate = Estimate { value, u: 0.5 * (high - low), dof: f64::INFINITY, n };
        self.blank("relative-deviation", Q::Ratio, Some(estimate))
    }

    fn frequencies(&self, measurand: &str, answer: &Answer, peaks: &[Peak]) -> Vec<Measurement> {
        if peaks.is_empty() {
            let reason = ResponseReason::NoExtreme { least_ratio: self.keys.least_prominence };
            return vec![Measurement {
                inconclusive: Some(reason.to_string()),
                ..self.blank(measurand, Q::Frequency, None)
            }];
        }
        peaks.iter().zip(1..).map(|(peak, k)| self.frequency(measurand, answer, peak, k)).collect()
    }

    fn frequency(&self, measurand: &str, answer: &Answer, peak: &Peak, number: usize) -> Measurement {
        let coarse_u = peak.spacing_hz / 12_f64.sqrt();
        let line_hz = peak.line.frequency_hz;
        let (value, u, how) = match &peak.mode {
            Ok(mode) if answer.unknown.is_none() => (mode.frequency_hz, mode.u_hz, "local fit".to_owned()),
            // The residual tells the noise, but not what averaging hid.
            Ok(mode) => (mode.frequency_hz, mode.u_hz.max(coarse_u), "local fit".to_owned()),
            Err(reason) => (line_hz, coarse_u, reason.to_string()),
        };
        let dof = f64::INFINITY;
        let estimate = Estimate { value, u, dof, n: answer.lines.len() + answer.hollow.len() };
        let mut m = self.blank(measurand, Q::Frequency, Some(estimate));
        m.conditions.push(condition("peak", number as f64, Q::Count));
        m.flags.push(how);
        m.flags.push(format!("extreme at the line {line_hz} Hz"));
        m.inconclusive = answer.doubt(line_hz).map(|doubt| doubt.to_string());
        m
    }

    fn damping(&self, answer: &Answer, peak: &Peak, number: usize) -> Measurement {
        let doubt = answer.doubt(peak.line.frequency_hz);
        let (estimate, reason) = match &peak.mode {
            Ok(mode) => match &mode.damping {
                Ok([value, u]) => {
                    let n = answer.lines.len() + answer.hollow.len();
                    (Some(Estimate { value: *value, u: *u, dof: f64::INFINITY, n }), doubt.map(Reason::from))
                }
                Err(unresolved) => (None, Some(unresolved.clone())),
            },
            Err(reason) => {
                (None, Some(ResponseReason::DampingOfNoMode { reason: Box::new(reason.clone()) }.into()))
            }
        };
        let mut m = self.blank("resonance-damping", Q::Ratio, estimate);
        m.conditions.push(condition("peak", number as f64, Q::Count));
        m.inconclusive = reason.map(|reason| reason.to_string());
        m
    }

    /// Gain and phase of the line at a frequency.
    fn at(&self, answer: &Answer, lines: &[Line], hz: f64) -> Vec<Measurement> {
        let line = lines.iter().find(|l| (l.frequency_hz - hz).abs() <= 1e-6 * hz);
        let largest = |measurand: &str, kind: Q, value: fn(&Line) -> f64, scale: f64| {
            let estimate = line.map(|l| {
                // Real and imaginary part: two degrees of freedom for each of the line.
                let known = l.variance > 0.0;
                let (u, dof) =
                    if known { (scale * l.relative_sd(), 2.0 * l.dof) } else { (0.0, f64::INFINITY) };
                Estimate { value: value(l), u, dof, n: 1 }
            });
            let mut m = self.blank(measurand, kind, estimate);
            m.conditions.push(condition("frequency", hz, Q::Frequency));
            let reason = match line {
                None => Some(ResponseReason::NoLineAt { hz }),
                Some(_) => answer.doubt(hz).or_else(|| answer.unknown.clone()),
            };
            m.inconclusive = reason.map(|reason| reason.to_string());
            m
        };
        vec![
            largest("response-gain", Q::Decibel, Line::gain_db, DB_PER_NEPER),
            largest("response-phase", Q::Angle, Line::phase_rad, 1.0),
        ]
    }

    /// Amplitudes of the output at lines that are excited, odd and even.
    fn amplitudes(&self, found: &super::periodic::Found) -> String {
        let [excited, odd, even] = found.rms;
        format!(
            "rms amplitude a line, {}: excited {excited:.4e}, odd not excited {odd:.4e}, even {even:.4e} \
             (SI; nothing subtracted)",
            self.name
        )
    }

    fn distortion(&self, answer: &Answer) -> Vec<Measurement> {
        let Some(found) = &answer.distortion else { return Vec::new() };
        let rms = self.amplitudes(found);
        let measurement = |measurand: &str, estimate: Option<Estimate>, noise: f64| {
            let mut m = self.blank(measurand, Q::Ratio, estimate);
            m.flags.push(rms.clone());
            m.flags.push(format!("noise of the mean {}", Q::Ratio.format(noise)));
            let reason = ResponseReason::InDistortionNoise { noise };
            m.inconclusive = estimate.is_none().then(|| reason.to_string());
            m
        };
        let [odd_noise, even_noise] = found.noise_ratio;
        vec![
            measurement("odd-distortion", found.odd, odd_noise),
            measurement("even-distortion", found.even, even_noise),
        ]
    }
}

fn condition(name: &str, value: f64, kind: Q) -> Condition {
    Condition { name: name.to_owned(), requested: value, achieved: Some(value), kind }
}

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;

fn bode(point: &str, named: &Named, answer: &Answer, peaks: &Peaks) -> Vec<Plot> {
    let title = if named.name == point { point.to_owned() } else { format!("{point}: {}", named.name) };
    let id = id(&title);
    let lines = &answer.lines;
    let hollow = &answer.hollow;
    let unwrapped: Vec<f64> = unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect();
    let column = |lines: &[Line], value: fn(&Line) -> f64| -> Vec<f64> { lines.iter().map(value).collect() };
    let gain_u = |l: &Line| COVERAGE * DB_PER_NEPER * l.relative_sd();
    let band = |u: fn(&Line) -> f64| if answer.unknown.is_none() { column(lines, u) } else { Vec::new() };
    let gain = Plot {
        series: curves(answer, column(lines, Line::gain_db), band(gain_u), column(hollow, Line::gain_db)),
        marks: marks("resonance", &peaks.resonances)
            .chain(marks("anti-resonance", &peaks.antiresonances))
            .collect(),
        ..Plot::new(
            &id,
            &title,
            Scale::logarithmic("frequency", "Hz"),
            Scale::linear("gain, dB re SI units", "dB"),
        )
    };
    let phase = curves(
        answer,
        unwrapped,
        band(|l| COVERAGE * l.relative_sd().to_degrees()),
        column(hollow, |l| l.phase_rad().to_degrees()),
    );
    let phase = phase_panel(&gain, phase);
    let share = |l: &Line| l.coherence.unwrap_or(0.0);
    let shares = curves(answer, column(lines, share), Vec::new(), column(hollow, share));
    let coherence = coherence_panel(&gain, "coherence", shares);
    vec![gain, phase, coherence]
}

fn marks<'a>(what: &'a str, peaks: &'a [Peak]) -> impl Iterator<Item = Mark> + 'a {
    peaks
        .iter()
        .map(move |p| Mark { label: format!("{what} {} Hz", p.line.frequency_hz), x: p.line.frequency_hz })
}

fn curves(answer: &Answer, y: Vec<f64>, band: Vec<f64>, hollow: Vec<f64>) -> Vec<Series> {
    let hz = |lines: &[Line]| -> Vec<f64> { lines.iter().map(|l| l.frequency_hz).collect() };
    let mut all = Vec::new();
    if !answer.lines.is_empty() {
        let x = hz(&answer.lines);
        if !band.is_empty() && x.len() <= MAX_POINTS {
            all.push(Series::new("U (k = 2)", Style::Band, x.clone(), y.clone()).with_u(band));
        }
        // Lines that count one by one between others that do not are no curve.
        let style = if answer.least_coherence.is_some() { Style::Markers } else { Style::Line };
        all.push(Series::thinned("measured", style, [&x, &y], MAX_POINTS));
    }
    if !answer.hollow.is_empty() {
        all.push(Series::thinned(
            "does not count",
            Style::Excluded,
            [&hz(&answer.hollow), &hollow],
            MAX_POINTS,
        ));
    }
    all
}

/// Kebab-case.
fn id(title: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
    let words: String = title.chars().map(plain).collect();
    words.split_whitespace().collect::<Vec<_>>().join("-")
}
