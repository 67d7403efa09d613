//! Gain with phase and coherence as panels; lines that do not count stay visible as hollow markers.

use analysis::frf::{Line, unwrapped_rad};

use super::answer::{Answer, Named};
use super::measure::Peaks;
use super::peaks::Peak;
use crate::trace::{MAX_POINTS, Mark, Plot, Scale, Series, Style};

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// 20·lg e: what a relative deviation is in dB.
const DB_PER_NEPER: f64 = 8.685_889_638;

pub(super) fn bode(point: &str, named: &Named, answer: &Answer, peaks: &Peaks) -> Vec<Plot> {
    let title = if named.name == point { point.to_owned() } else { format!("{point}: {}", named.name) };
    let id = id(&title);
    let lines = &answer.lines;
    let hollow = &answer.hollow;
    let unwrapped: Vec<f64> = unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect();
    let column = |lines: &[Line], value: fn(&Line) -> f64| -> Vec<f64> { lines.iter().map(value).collect() };
    let gain_u = |l: &Line| COVERAGE * DB_PER_NEPER * l.relative_sd();
    let band = |u: fn(&Line) -> f64| if answer.unknown.is_none() { column(lines, u) } else { Vec::new() };
    let frequency = || Scale::logarithmic("frequency", "Hz");
    let gain = Plot {
        series: curves(answer, column(lines, Line::gain_db), band(gain_u), column(hollow, Line::gain_db)),
        marks: marks("resonance", &peaks.resonances)
            .chain(marks("anti-resonance", &peaks.antiresonances))
            .collect(),
        ..Plot::new(&id, &title, frequency(), Scale::linear("gain, dB re SI units", "dB"))
    };
    let phase = Plot {
        series: curves(
            answer,
            unwrapped,
            band(|l| COVERAGE * l.relative_sd().to_degrees()),
            column(hollow, |l| l.phase_rad().to_degrees()),
        ),
        ..Plot::new(
            format!("{id}-phase"),
            format!("{title}: phase"),
            frequency(),
            Scale::linear("phase", "deg"),
        )
    }
    .panel_of(&gain);
    let share = |l: &Line| l.coherence.unwrap_or(0.0);
    let coherence = Plot {
        series: curves(answer, column(lines, share), Vec::new(), column(hollow, share)),
        y_range: Some([0.0, 1.0]),
        ..Plot::new(
            format!("{id}-coherence"),
            format!("{title}: coherence"),
            frequency(),
            Scale::linear("coherence", ""),
        )
    }
    .panel_of(&gain);
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
