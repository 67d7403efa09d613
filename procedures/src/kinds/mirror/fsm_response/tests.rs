use super::keys::{DelayKeys, HarmonicsKeys, MultisineKeys, StrokeKeys};
use super::point::MirrorPoint;
use super::spectra::LineQuality;
use super::*;
use crate::case::MirrorChannel;
use crate::kinds::position::positioned::tests::with_elevation;
use crate::measurement::{Bound, Measurement, Reduced};
use crate::verdict::coverage_factor;

mod files;
mod open_loop;
mod parts;
mod plant;

use plant::Plant;

/// Short, with all parts.
pub(super) fn keys() -> Keys {
    Keys {
        mirror_axes: vec![0],
        channels: vec![MirrorChannel::Analog, MirrorChannel::Serial],
        levels_v: vec![1.0],
        scale_rad_per_v: 500e-6,
        place: "table".to_owned(),
        azimuth_rad: 0.0,
        elevation_rad: 0.7,
        multisine: MultisineKeys {
            range_hz: [4.0, 1500.0],
            lines: 40,
            reaction_hz: [60.0, 250.0],
            period_s: 0.25,
            periods: 7,
            dropped: 2,
            least_snr_db: 20.0,
        },
        delays: DelayKeys {
            analog_s: 50e-6,
            serial_s: 150e-6,
            bit_rate_hz: 937.5e3,
            u_s: 10e-6,
            compared_to_hz: 100.0,
        },
        stroke: Some(StrokeKeys { reach_rad: 1.05e-3, positions: 3, ramp_s: 0.05, rest_s: 0.1 }),
        harmonics: None,
        gauge_u_ratio: None,
        reference_u_ratio: 1e-3,
    }
}

/// Plans, runs on the plant, analyses and concludes.
fn conclusion(keys: &Keys, plant: &Plant) -> Conclusion {
    let axes = with_elevation();
    let cases = keys.plan("az", &axes).expect("the axis is there");
    let points: Vec<PointResult> =
        cases.iter().map(|case| keys.analyse(case, &plant.run(case), &axes)).collect();
    keys.conclude(&cases, &points, &axes)
}

fn all<'a>(conclusion: &'a Conclusion, measurand: &str) -> Vec<&'a Measurement> {
    conclusion.measurements.iter().filter(|m| m.measurand == measurand).collect()
}

fn value(m: &Measurement) -> f64 {
    m.value.unwrap_or_else(|| panic!("{}: {:?}", m.measurand, m.inconclusive))
}

/// |T| of the second order at a frequency, dB.
fn gain_db(plant: &Plant, frequency_hz: f64) -> f64 {
    let r = frequency_hz / plant.frequency_hz;
    -10.0 * ((1.0 - r * r).powi(2) + (2.0 * plant.damping_ratio * r).powi(2)).log10()
}

#[test]
fn bandwidth_and_attenuation_of_a_second_order_come_out_within_their_uncertainty() {
    let plant = Plant::default();
    let c = conclusion(&keys(), &plant);
    // Closed form: (ω/ω0)² = 1 − 2ζ² + √((1 − 2ζ²)² + 1).
    let a = 1.0 - 2.0 * plant.damping_ratio.powi(2);
    let expected_hz = plant.frequency_hz * (a + (a * a + 1.0).sqrt()).sqrt();
    assert_eq!(all(&c, response::BANDWIDTH).len(), 2, "one a channel");
    for m in all(&c, response::BANDWIDTH) {
        assert!((value(m) - expected_hz).abs() < 2.5 * m.u + 0.05, "{} {} {expected_hz}", value(m), m.u);
        assert!(m.u < 0.005 * expected_hz, "{}", m.u);
        assert!(
            m.conditions[0].achieved.is_some_and(|level| (level - 1.0).abs() < 0.03),
            "{:?}",
            m.conditions
        );
    }
    for m in all(&c, response::ATTENUATION) {
        let expected_db = -gain_db(&plant, 100.0);
        assert!((value(m) - expected_db).abs() < 2.5 * m.u + 0.005, "{} {} {expected_db}", value(m), m.u);
    }
}

#[test]
fn channels_agree_once_their_known_delays_are_off_and_a_late_one_shows_by_its_angle() {
    let c = conclusion(&keys(), &Plant::default());
    let [level] = all(&c, channels::LEVEL_DIFFERENCE)[..] else { panic!("one pair") };
    let [phase] = all(&c, channels::PHASE_DIFFERENCE)[..] else { panic!("one pair") };
    assert!(value(level) < 0.02 && value(phase) < 0.3_f64.to_radians(), "{} {}", value(level), value(phase));
    // 0.45 ms more: 16.2 deg at 100 Hz.
    let plant = Plant::default();
    let late = Plant { serial_delay_s: plant.serial_delay_s + 0.45e-3, ..plant };
    let c = conclusion(&keys(), &late);
    let phase = all(&c, channels::PHASE_DIFFERENCE)[0];
    assert!((value(phase).to_degrees() - 16.2).abs() < 0.3, "{}", value(phase).to_degrees());
    assert!(phase.u.to_degrees() < 1.0 && phase.dof.is_none_or(|dof| dof > 4.0), "{phase:?}");
}

#[test]
fn the_sign_of_a_serial_order_takes_time_and_does_not_show_as_a_difference_of_the_channels() {
    let sound = Plant { noise_rad: 0.02e-6, ..Plant::default() };
    let level = |plant: &Plant| all(&conclusion(&keys(), plant), channels::LEVEL_DIFFERENCE)[0].clone();
    let known = level(&sound);
    // The steps of the plant leave 0.0002 dB.
    assert!(value(&known) < 1e-3 && known.u < 5e-4, "{known:?}");
    // Orders that all come alike are not what the evaluation knows of: lines scatter by what it makes of their signs.
    let alike = level(&Plant { sign_s: 0.0, ..sound });
    assert!(alike.u > 5.0 * known.u, "{} {}", alike.u, known.u);
    assert!(alike.flags.iter().any(|flag| flag.contains("chi2/dof")), "{:?}", alike.flags);
}

#[test]
fn a_difference_of_scale_does_not_grow_with_the_number_of_lines() {
    let plant = Plant { serial_gain: 1.02, noise_rad: 3e-6, ..Plant::default() };
    let expected_db = 20.0 * 1.02_f64.log10();
    let with_lines = |lines: u32, period_s: f64| {
        let multisine = MultisineKeys { lines, period_s, ..keys().multisine };
        let c = conclusion(&Keys { multisine, stroke: None, ..keys() }, &plant);
        all(&c, channels::LEVEL_DIFFERENCE)[0].clone()
    };
    for m in [with_lines(30, 0.25), with_lines(120, 1.0)] {
        let off = value(&m) - expected_db;
        assert!(off.abs() < coverage_factor(m.dof) * m.u, "{off} {} {:?}", m.u, m.flags);
    }
}

#[test]
fn channels_of_which_a_few_lines_are_left_are_not_compared() {
    let axes = with_elevation();
    let keys = Keys { stroke: None, ..keys() };
    let cases = keys.plan("az", &axes).expect("the axis is there");
    let sound = || -> Vec<PointResult> {
        cases.iter().map(|case| keys.analyse(case, &Plant::default().run(case), &axes)).collect()
    };
    // What is left of the serial channel, by number and frequency.
    let left = |keeps: &dyn Fn(usize, f64) -> bool| {
        let mut points = sound();
        let serial =
            cases.iter().position(|c| c.mirror_channel == Some(MirrorChannel::Serial)).expect("planned");
        let mut point = points[serial].reduced.get::<MirrorPoint>().expect("it was reduced").clone();
        let response = point.response.as_mut().expect("a response");
        for (k, line) in response.gauge.iter_mut().enumerate() {
            if !keeps(k, line.line.frequency_hz) {
                line.quality = LineQuality::Noise;
            }
        }
        points[serial].reduced = Reduced::to(point);
        let c = keys.conclude(&cases, &points, &axes);
        let names = [channels::LEVEL_DIFFERENCE, channels::PHASE_DIFFERENCE];
        names.map(|name| all(&c, name)[0].inconclusive.clone())
    };
    assert_eq!(left(&|_, _| true), [None, None]);
    assert_eq!(left(&|k, _| k != 3), [None, None], "one line less says as much");
    for reason in left(&|k, _| k == 0) {
        let said = reason.expect("one line is no response");
        assert!(said.starts_with("1 of ") && said.contains("at least 80 % are needed"), "{said}");
    }
    // Lines from 96 Hz on: 4 of 25, so that the share alone would do.
    for reason in left(&|_, hz| hz < 79.0) {
        assert!(reason.is_some(), "nothing is left where a delay shows most");
    }
}

#[test]
fn a_single_line_that_stands_apart_is_a_difference_by_itself() {
    let axes = with_elevation();
    let keys = Keys { stroke: None, ..keys() };
    let cases = keys.plan("az", &axes).expect("the axis is there");
    let mut points: Vec<PointResult> =
        cases.iter().map(|case| keys.analyse(case, &Plant::default().run(case), &axes)).collect();
    let serial = cases.iter().position(|c| c.mirror_channel == Some(MirrorChannel::Serial)).expect("planned");
    let mut point = points[serial].reduced.get::<MirrorPoint>().expect("it was reduced").clone();
    let gauge = &mut point.response.as_mut().expect("a response").gauge;
    let line = gauge.iter_mut().find(|l| l.line.frequency_hz > 60.0).expect("a line");
    line.line.value *= 10.0_f64.powf(0.05);
    points[serial].reduced = Reduced::to(point);
    let c = keys.conclude(&cases, &points, &axes);
    let m = all(&c, channels::LEVEL_DIFFERENCE)[0];
    assert!((value(m) - 1.0).abs() < 0.1, "{m:?}");
    assert!(m.flags.iter().any(|flag| flag == "the line at 64 Hz deviates from the others"), "{:?}", m.flags);
}

#[test]
fn bandwidth_is_that_of_the_mirror_and_not_of_a_gauge_whose_scale_is_wrong() {
    // The servo brings the gauge onto the command, so the mirror moves 10 % too far; the gauge knows nothing of it.
    let wrong = Plant { gauge_ratio: 0.9, ..Plant::default() };
    let expected_db = -gain_db(&wrong, 100.0) + 20.0 * 0.9_f64.log10();
    let seen = conclusion(&keys(), &wrong);
    for m in all(&seen, response::ATTENUATION) {
        assert!((value(m) - expected_db).abs() < 2.5 * m.u, "{m:?}, expected {expected_db}");
        assert!(m.flags.contains(&"by the autocollimator".to_owned()), "{:?}", m.flags);
    }
    let gauge = |plant: Plant| conclusion(&keys(), &Plant { has_reference: false, ..plant });
    for m in all(&gauge(wrong.clone()), response::ATTENUATION) {
        assert!(
            (value(m) + gain_db(&wrong, 100.0)).abs() < 0.05,
            "the gauge shows the response of its own: {m:?}"
        );
        for flag in ["by the strain gauge", "u excludes the scale of the gauge"] {
            assert!(m.flags.contains(&flag.to_owned()), "{:?}", m.flags);
        }
    }
    // The margins are those of the loop, which the gauge closes.
    let margins = |c: &Conclusion| all(c, response::PHASE_MARGIN)[0].value;
    assert!(margins(&seen).is_some());
    assert_eq!(margins(&seen), margins(&gauge(wrong)));
}

#[test]
fn a_resonance_of_the_support_is_named_and_its_lines_do_not_count_and_a_rigid_one_is_silent() {
    let rigid = conclusion(&keys(), &Plant::default());
    for m in all(&rigid, response::RESONANCE) {
        assert!(m.inconclusive.as_deref().is_some_and(|r| r.starts_with("none visible")), "{m:?}");
    }
    assert_eq!(rigid.remarks, [""; 0]);
    let shaken = Plant { support: Some([140.0, 0.02, 0.05]), ..Plant::default() };
    let c = conclusion(&keys(), &shaken);
    for m in all(&c, response::RESONANCE) {
        assert!((value(m) - 140.0).abs() < 2.5 * m.u, "{} {}", value(m), m.u);
    }
    assert!(c.remarks[0].starts_with("az: a resonance of the mirror's support"), "{:?}", c.remarks);
    let gain = c.plots.iter().find(|p| p.id == "gain-az").expect("a picture");
    let hollow = gain.series.iter().find(|s| s.style == crate::trace::Style::Excluded).expect("left out");
    assert!(hollow.x.iter().any(|f| (f - 140.0).abs() < 3.0), "{:?}", hollow.x);
    // What is left is the mirror without the support.
    let expected_db = -gain_db(&shaken, 100.0);
    let m = all(&c, response::ATTENUATION)[0];
    assert!((value(m) - expected_db).abs() < 0.06, "{} {expected_db}", value(m));
}

#[test]
fn stroke_counts_by_the_autocollimator_and_by_the_gauge_alone_only_with_its_certificate() {
    let seen = Plant { gauge_ratio: 1.01, ..Plant::default() };
    let c = conclusion(&keys(), &seen);
    let stroke = all(&c, conclude::STROKE)[0];
    // The servo brings the gauge onto the command, so the mirror stays short of it by what the gauge is too large.
    assert!((value(stroke) - 1.05e-3 / 1.01).abs() < 2.0 * stroke.u, "{stroke:?}");
    let scale = all(&c, conclude::GAUGE_SCALE)[0];
    assert!((value(scale) - 0.01).abs() < 2.0 * scale.u, "{scale:?}");

    let alone = Plant { has_reference: false, ..Plant::default() };
    let c = conclusion(&keys(), &alone);
    let stroke = all(&c, conclude::STROKE)[0];
    assert!(stroke.inconclusive.as_deref().is_some_and(|r| r.starts_with("gauge only")), "{stroke:?}");
    let c = conclusion(&Keys { gauge_u_ratio: Some(0.01), ..keys() }, &alone);
    let stroke = all(&c, conclude::STROKE)[0];
    assert!(
        (stroke.u - 1.05e-5).abs() < 1e-6 && stroke.flags.contains(&"gauge only".to_owned()),
        "{stroke:?}"
    );

    let short = Plant { stroke_rad: 0.9e-3, ..Plant::default() };
    let stroke = value(all(&conclusion(&keys(), &short), conclude::STROKE)[0]);
    assert!((stroke - 0.9e-3).abs() < 2e-6, "{stroke}");
}

#[test]
fn a_stroke_whose_end_was_not_seen_is_a_bound_and_says_so() {
    let is_bound = |plant: &Plant| {
        let c = conclusion(&keys(), plant);
        let stroke = &all(&c, conclude::STROKE)[0];
        let is_told = stroke.flags.iter().any(|flag| flag.starts_with("at least"));
        assert_eq!(is_told, matches!(stroke.bound, Some(Bound::AtLeast(_))));
        is_told
    };
    // The commands end at 1.05 mrad.
    assert!(is_bound(&Plant { stroke_rad: 1.2e-3, ..Plant::default() }));
    assert!(!is_bound(&Plant { stroke_rad: 1.0e-3, ..Plant::default() }));
}

#[test]
fn harmonics_of_a_bent_gauge_are_its_series_and_miss_the_criterion() {
    // y + b·y²: at amplitude A the second harmonic is b·A/2 of the fundamental.
    let bent = Plant { bend_per_rad: 400.0, ..Plant::default() };
    let criterion = Q::Ratio.parse_limit("<= 2 %").expect("a limit");
    let harmonics = Some(HarmonicsKeys { frequencies_hz: vec![20.0], duration_s: 0.6, criterion });
    let keys = Keys { harmonics, stroke: None, channels: vec![MirrorChannel::Analog], ..keys() };
    let c = conclusion(&keys, &bent);
    let m = all(&c, response::DISTORTION)[0];
    let amplitude_rad = 250e-6 * 10_f64.powf(gain_db(&bent, 20.0) / 20.0);
    assert!((value(m) - 200.0 * amplitude_rad).abs() < 5e-4, "{m:?}");
    assert!(m.flags.contains(&"criterion <= 2 % not met".to_owned()), "{:?}", m.flags);
    assert!(c.remarks[0].contains("sine of 20 Hz, criterion <= 2 % not met"), "{:?}", c.remarks);
    let level = m.conditions[0].achieved.expect("the judge checks it");
    assert!((level - 1.0).abs() < 1e-3, "{level}");
}

/// Every fifth command lasts two rows, as one does whose answer came late; the peak of each period, of 500 rows, is among them.
fn hold_some(command: &mut [f64]) {
    let peak = (0..command.len()).max_by(|&a, &b| command[a].total_cmp(&command[b])).expect("rows");
    for k in (1..command.len()).filter(|k| k % 5 == (peak + 1) % 5) {
        command[k] = command[k - 1];
    }
}

#[test]
fn a_command_that_a_serial_line_holds_for_two_rows_now_and_then_is_not_cut_off() {
    let axes = with_elevation();
    let keys = Keys { stroke: None, ..keys() };
    let cases = keys.plan("az", &axes).expect("the axis is there");
    let mut window = Plant::default().run(&cases[0]);
    hold_some(&mut window.topics[0].columns[0]);
    let result = keys.analyse(&cases[0], &window, &axes);
    let why = result.measurements[0].inconclusive.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(!why.starts_with("saturation"), "{why}");
}

#[test]
fn missing_rows_a_cut_off_command_and_a_dead_sensor_give_reasons_not_numbers() {
    let axes = with_elevation();
    let keys = Keys { stroke: None, ..keys() };
    let cases = keys.plan("az", &axes).expect("the axis is there");
    let spoilt = |plant: &Plant, spoil: &dyn Fn(&mut Window)| {
        let mut window = plant.run(&cases[0]);
        spoil(&mut window);
        let result = keys.analyse(&cases[0], &window, &axes);
        result.measurements[0].inconclusive.clone().expect("no number")
    };
    let sound = Plant::default();
    let missing = spoilt(&sound, &|w| {
        // A row in every period.
        let topic = &mut w.topics[0];
        for column in topic.columns.iter_mut().chain([&mut topic.time_s]) {
            let rows: Vec<f64> = column.chunks(500).flat_map(|rows| &rows[1..]).copied().collect();
            *column = rows;
        }
    });
    assert!(missing.starts_with("rows of the mirror are missing"), "{missing}");
    let cut =
        spoilt(&sound, &|w| w.topics[0].columns[0].iter_mut().for_each(|c| *c = c.clamp(-1.2e-4, 1.2e-4)));
    assert!(cut.starts_with("saturation"), "{cut}");
    let held_and_cut = spoilt(&sound, &|w| {
        let command = &mut w.topics[0].columns[0];
        command.iter_mut().for_each(|c| *c = c.clamp(-1.2e-4, 1.2e-4));
        hold_some(command);
    });
    assert!(held_and_cut.starts_with("saturation"), "{held_and_cut}");
    let dead = |plant: &Plant, channel: usize| {
        spoilt(plant, &|w| {
            let mut k = 0_u32;
            w.topics[0].columns[channel].iter_mut().for_each(|c| {
                k = k.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *c = f64::from(k >> 8) * 1e-14;
            });
        })
    };
    assert_eq!(dead(&sound, 4), "no line counts", "the autocollimator");
    assert_eq!(dead(&Plant { has_reference: false, ..sound }, 2), "no line counts", "the gauge");
    let absent = spoilt(&sound, &|w| w.topics.clear());
    assert!(absent.contains("`/fsm`"), "{absent}");
}
