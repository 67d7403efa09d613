//! Bytes of the simulated unit: the calculated datagrams, and whatever it can say through the driver's parser.

use proptest::prelude::*;

use super::*;
use drivers::stim300::{Configuration, Found, Measurement, Parser, Triad};

/// Gyros +1, −1, +0.5 °/s; accelerometers and inclinometers 0, 0, 1 g at 10 g range; counter 8; 321 µs.
const BODY: Body = Body {
    gyros: Cluster { counts: [16_384, -16_384, 8192], status: 0 },
    accelerometers: Cluster { counts: [0, 0, 524_288], status: 0 },
    inclinometers: Cluster { counts: [0, 0, 4_194_304], status: 0 },
    temperature: 0,
    unit_status: 0,
    input: 0,
    counter: 8,
    latency_us: 321,
};
const RATES: Content =
    Content { accelerometers: false, inclinometers: false, temperatures: false, input: Input::None };

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ")
}

fn only(bytes: &[u8]) -> Found {
    let mut parser = Parser::default();
    parser.push(bytes);
    let found = parser.next().expect("a datagram");
    assert_eq!((parser.next(), parser.tally()), (None, drivers::stim300::Tally::default()));
    found
}

#[test]
fn the_calculated_datagrams_are_what_the_unit_sends() {
    let with_accelerometers = Content { accelerometers: true, ..RATES };
    let with_inclinometers = Content { inclinometers: true, ..with_accelerometers };
    for (content, line_end, expected) in [
        (RATES, false, "90 00 40 00 FF C0 00 00 20 00 00 08 01 41 08 91 17 D6"),
        (
            with_accelerometers,
            false,
            "91 00 40 00 FF C0 00 00 20 00 00 00 00 00 00 00 00 08 00 00 00 08 01 41 72 2D 9F 01",
        ),
        (
            with_inclinometers,
            true,
            "93 00 40 00 FF C0 00 00 20 00 00 00 00 00 00 00 00 08 00 00 00 00 00 00 00 00 00 40 00 00 00 08 01 \
             41 84 B6 4C 93 0D 0A",
        ),
    ] {
        assert_eq!(hex(Datagram::measurement(content, &BODY, line_end).bytes()), expected);
    }
}

fn content() -> impl Strategy<Value = Content> {
    let input = prop::sample::select(vec![Input::None, Input::Pps, Input::Aux]);
    (any::<[bool; 3]>(), input).prop_map(|([accelerometers, inclinometers, temperatures], input)| Content {
        accelerometers,
        inclinometers,
        temperatures,
        input,
    })
}

fn cluster() -> impl Strategy<Value = Cluster> {
    let count = -(1 << 23)..(1 << 23);
    (prop::array::uniform3(count), any::<u8>()).prop_map(|(counts, status)| Cluster { counts, status })
}

fn body() -> impl Strategy<Value = Body> {
    let input = -(1 << 23)..(1 << 23);
    let rest = (any::<i16>(), any::<u8>(), input, any::<u8>(), any::<u16>());
    (cluster(), cluster(), cluster(), rest).prop_map(
        |(gyros, accelerometers, inclinometers, (temperature, unit_status, input, counter, latency_us))| {
            Body {
                gyros,
                accelerometers,
                inclinometers,
                temperature,
                unit_status,
                input,
                counter,
                latency_us,
            }
        },
    )
}

/// What the driver must read of a body.
fn as_read(content: Content, body: &Body) -> Measurement {
    let triad = |is_present: bool, cluster: &Cluster| {
        if is_present { Triad { counts: cluster.counts, status: cluster.status } } else { Triad::default() }
    };
    let temperature = |is_present: bool| {
        let is_present = is_present && content.temperatures;
        let temperatures = Cluster { counts: [i32::from(body.temperature); 3], status: body.unit_status };
        triad(is_present, &temperatures)
    };
    let has_input = content.input != Input::None;
    Measurement {
        content,
        gyros: triad(true, &body.gyros),
        accelerometers: triad(content.accelerometers, &body.accelerometers),
        inclinometers: triad(content.inclinometers, &body.inclinometers),
        temperatures: [
            temperature(true),
            temperature(content.accelerometers),
            temperature(content.inclinometers),
        ],
        input: if has_input { body.input } else { 0 },
        input_status: if has_input { body.unit_status } else { 0 },
        counter: body.counter,
        latency_us: body.latency_us,
    }
}

fn setup() -> impl Strategy<Value = Stim300Setup> {
    let rates = [125, 250, 500, 1000, 2000].map(SampleRate::Internal);
    let rate = prop::sample::select([&rates[..], &[SampleRate::External]].concat());
    let gyro = prop::sample::select(vec![
        GyroUnit::Rate,
        GyroUnit::IncrementalAngle,
        GyroUnit::AverageRate,
        GyroUnit::IntegratedAngle,
    ]);
    let force = prop::sample::select(vec![
        ForceUnit::Acceleration,
        ForceUnit::IncrementalVelocity,
        ForceUnit::AverageAcceleration,
        ForceUnit::IntegratedVelocityGs,
        ForceUnit::IntegratedVelocity,
    ]);
    let range = prop::sample::select(vec![
        AccelerometerRange::G5,
        AccelerometerRange::G10,
        AccelerometerRange::G30,
        AccelerometerRange::G80,
    ]);
    let bit_rate = prop::sample::select(vec![374_400, 460_800, 921_600, 1_843_200, 500_023]);
    (content(), rate, gyro, force, range, bit_rate, any::<[bool; 4]>()).prop_map(
        |(content, sample_rate, gyro_unit, accelerometer_unit, accelerometer_range, bit_rate, switches)| {
            let [line_end, is_gyro_delayed, sends_bias_trim, is_terminated] = switches;
            Stim300Setup {
                sample_rate,
                content,
                line_end,
                bit_rate,
                gyro_unit,
                is_gyro_delayed,
                accelerometer_unit,
                accelerometer_range,
                sends_bias_trim,
                is_terminated,
            }
        },
    )
}

proptest! {
    #[test]
    fn every_measurement_is_read_as_it_was_meant(content in content(), body in body(), line_end: bool) {
        let datagram = Datagram::measurement(content, &body, line_end);
        prop_assert_eq!(only(datagram.bytes()), Found::Measurement(as_read(content, &body)));
    }

    #[test]
    fn every_configuration_is_read_as_it_was_meant(setup in setup()) {
        let datagram = Datagram::special(SpecialKind::Configuration, &setup.payload(), setup.line_end);
        let Found::Special(special) = only(datagram.bytes()) else { panic!("a special datagram") };
        let payload = special.payload().first_chunk().expect("21 bytes");
        let read = Configuration::decode(payload).expect("listed codes");
        let bit_rate = (setup.bit_rate != 500_023).then_some(setup.bit_rate);
        prop_assert_eq!((read.sample_rate, read.content), (setup.sample_rate, setup.content));
        prop_assert_eq!((read.line_end, read.bit_rate), (setup.line_end, bit_rate));
        prop_assert_eq!((read.gyro_unit, read.is_gyro_delayed), (setup.gyro_unit, setup.is_gyro_delayed));
        prop_assert_eq!(read.accelerometer_unit, setup.accelerometer_unit);
        prop_assert_eq!(read.accelerometer_range, [setup.accelerometer_range; 3]);
        prop_assert_eq!((read.sends_bias_trim, read.is_terminated), (setup.sends_bias_trim, setup.is_terminated));
        prop_assert_eq!((read.gyros_active, read.gyro_filter_hz), ([true; 3], [262; 3]));
    }

    /// A stream that is cut anywhere: the parser misses at most the datagram that was cut.
    #[test]
    fn behind_a_cut_the_next_datagram_is_found(content in content(), body in body(), cut in 0..63_usize) {
        let datagram = Datagram::measurement(content, &body, false);
        let cut = cut.min(datagram.bytes().len());
        let mut parser = Parser::default();
        parser.push(&datagram.bytes()[cut..]);
        parser.push(datagram.bytes());
        parser.push(&[0; 63]);
        let mut all = Vec::new();
        while let Some(found) = parser.next() {
            all.push(found);
        }
        prop_assert!(all.contains(&Found::Measurement(as_read(content, &body))));
    }
}
