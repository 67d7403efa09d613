use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

/// A line whose far end answers from a script and keeps what it was sent.
struct Script {
    sent: Vec<String>,
    replies: VecDeque<&'static str>,
    incoming: VecDeque<u8>,
    /// Most bytes that one read gives.
    piece: usize,
}

impl Script {
    fn new(replies: &[&'static str]) -> Self {
        Self {
            sent: vec![],
            replies: replies.iter().copied().collect(),
            incoming: VecDeque::new(),
            piece: 256,
        }
    }
}

impl ByteLine for Script {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.incoming.len()).min(self.piece);
        into.iter_mut().zip(self.incoming.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.sent.push(String::from_utf8_lossy(bytes).into_owned());
        self.incoming.extend(self.replies.pop_front().unwrap_or_default().bytes());
        Ok(())
    }
}

fn settings() -> GcsSettings {
    GcsSettings { name: "fsm".into(), axes: ["1".into(), "2".into()], answer_timeout_s: 0.05 }
}

/// The reply to a request, polled once a millisecond.
fn ask(line: &mut Script, request: Request) -> Result<Reply, DeviceError> {
    let mut gcs = Gcs::new(settings()).expect("the settings are sound");
    gcs.send(line, request, Duration::ZERO)?;
    for millisecond in 1..10_000 {
        if let Some(reply) = gcs.poll(line, Duration::from_millis(millisecond))? {
            assert!(gcs.is_idle());
            return Ok(reply);
        }
    }
    panic!("neither a reply nor an error after 10 s");
}

/// Wire forms of E727T0005, and the replies that the manual shows for them.
#[test]
fn requests_are_written_and_replies_read_as_the_manual_says() {
    let values = |a, b| Reply::Values([a, b]);
    for (request, sent, reply, expected) in [
        (
            Request::Identity,
            "*IDN?\n",
            "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, E-727.3SDA, 116051234, 12.34\n",
            Reply::Text("(c)2015 Physik Instrumente (PI) GmbH & Co. KG, E-727.3SDA, 116051234, 12.34".into()),
        ),
        (Request::Axes, "SAI?\n", "1 \n2\n", Reply::Lines(vec!["1".into(), "2".into()])),
        (Request::Servo([true, false]), "SVO 1 1 2 0\nERR?\n", "0\n", Reply::Done),
        (Request::IsServoOn, "SVO? 1 2\n", "1=1 \n2=0\n", values(1.0, 0.0)),
        (Request::Move([10.0, -3.0]), "MOV 1 10.000000 2 -3.000000\nERR?\n", "0\n", Reply::Done),
        (Request::Targets, "MOV? 1 2\n", "1=10.000000 \n2=-3.000000\n", values(10.0, -3.0)),
        (Request::MoveBy([0.5, 0.0]), "MVR 1 0.500000 2 0.000000\nERR?\n", "0\n", Reply::Done),
        (Request::OpenLoop([25.0, 0.0]), "SVA 1 25.000000 2 0.000000\nERR?\n", "0\n", Reply::Done),
        (Request::Positions, "POS? 1 2\n", "1=1.0e1 \n2=-2.999\n", values(10.0, -2.999)),
        (Request::OnTarget, "ONT? 1 2\n", "1=1 \n2=1\n", values(1.0, 1.0)),
        (Request::Overflow, "OVF? 1 2\n", "1=0 \n2=0\n", values(0.0, 0.0)),
        (Request::LowerLimits, "TMN? 1 2\n", "1=-5 \n2=-5\n", values(-5.0, -5.0)),
        (Request::UpperLimits, "TMX? 1 2\n", "1=5 \n2=5\n", values(5.0, 5.0)),
        (Request::PiezoVoltages, "VOL? 1 2\n", "1=50.1 \n2=49.9\n", values(50.1, 49.9)),
        (Request::Stop, "STP\nERR?\n", "10\n", Reply::Done),
        (
            Request::Parameter { axis: 1, id: 0x0700_0300 },
            "SPA? 2 0x07000300\n",
            "2 0x07000300=0.02\n",
            Reply::Number(0.02),
        ),
        (Request::TablesCount, "TNR?\n", "8\n", Reply::Number(8.0)),
        (Request::RecordEvery(4), "RTR 4\nERR?\n", "0\n", Reply::Done),
        (
            Request::RecordInto { table: 2, axis: 1, option: RecordOption::Position },
            "DRC 2 2 2\nERR?\n",
            "0\n",
            Reply::Done,
        ),
        (Request::RecordOn(TriggerSource::Move), "DRT 0 1 0\nERR?\n", "0\n", Reply::Done),
        (Request::RecordedCount(2), "DRL? 2\n", "2=1024\n", Reply::Number(1024.0)),
    ] {
        let mut line = Script::new(&[reply]);
        // Cut anywhere: a space and a line feed in different reads do not end a reply.
        line.piece = 1 + sent.len() % 3;
        assert_eq!(ask(&mut line, request).expect(sent), expected, "{sent}");
        assert_eq!(line.sent, [sent]);
    }
}

const RECORD: &str = "# REM demo \n# VERSION = 1 \n# TYPE = 1 \n# SEPARATOR = 32 \n# DIM = 2 \n# SAMPLE_TIME = 0.00005 \n\
                      # NDATA = 3 \n# NAME0 = Target Position of axis 1 \n# NAME1 = Actual Position of axis 1 \n# \n\
                      # END_HEADER \n1.0 0.5 \n1.0 0.75 \n1.0 -8.75e-1\n";

#[test]
fn tables_of_the_recorder_come_with_their_header() {
    let mut line = Script::new(&[RECORD]);
    let request = Request::Recorded { first: 1, count: 3, tables: vec![1, 2] };
    let Reply::Record(record) = ask(&mut line, request).expect("a record") else { panic!("no record") };
    assert_eq!(line.sent, ["DRR? 1 3 1 2\n"]);
    assert_eq!(record.names, ["Target Position of axis 1", "Actual Position of axis 1"]);
    assert_eq!(record.sample_time_s, 50e-6);
    assert_eq!(record.columns, [vec![1.0; 3], vec![0.5, 0.75, -0.875]]);
}

#[test]
fn a_header_that_ends_without_a_space_has_no_data_behind_it() {
    let mut line = Script::new(&["# DIM = 1 \n# SAMPLE_TIME = 0.1 \n# NDATA = 0 \n# END_HEADER\n"]);
    let request = Request::Recorded { first: 1, count: 0, tables: vec![1] };
    let Reply::Record(record) = ask(&mut line, request).expect("a record") else { panic!("no record") };
    assert_eq!((record.names, record.columns), (vec![String::new()], vec![Vec::new()]));
}

#[test]
fn a_wrong_record_is_refused_with_what_is_wrong() {
    for (from, to, error) in [
        ("0.75 \n", "\n", "expected 2 values, found 1"),
        ("NDATA = 3", "NDATA = 4", "expected 4 values, found 3"),
        ("0.75 ", "0.7x ", "expected a number, found `0.7x`"),
        ("# DIM = 2 \n", "", "expected DIM in the header, found `none`"),
        ("DIM = 2", "DIM = 0", "expected DIM of 1 to 64, found `0`"),
        ("# SAMPLE_TIME = 0.00005 \n", "", "expected SAMPLE_TIME in the header, found `none`"),
        ("SEPARATOR = 32", "SEPARATOR = 9", "expected SEPARATOR = 32, a space, found `9`"),
        ("# END_HEADER \n", "", "expected a header line `# KEY = value`, found `1.0 0.5`"),
    ] {
        let text = RECORD.replace(from, to);
        assert_ne!(text, RECORD);
        assert_eq!(Record::read(&text).map_err(|wrong| wrong.to_string()), Err(error.to_owned()), "{from}");
    }
}

#[test]
fn errors_are_told_by_number_and_meaning() {
    let mut line = Script::new(&["7\n"]);
    let error = ask(&mut line, Request::Move([9e3, 0.0])).expect_err("7").to_string();
    let expected =
        "fsm: MOV 1 9000.000000 2 0.000000: the instrument reports 7, \"position out of the travel limits\"";
    assert_eq!(error, expected);
    // A query that is refused is not answered; the driver asks why.
    let mut line = Script::new(&["", "15\n"]);
    let error = ask(&mut line, Request::Positions).expect_err("15").to_string();
    assert_eq!(line.sent, ["POS? 1 2\n", "ERR?\n"]);
    assert_eq!(error, "fsm: POS? 1 2: the instrument reports 15, \"no such axis\"");
    assert!(error_meaning(-12_345).contains("manual"));
}

#[test]
fn silence_and_strange_replies_are_errors_that_name_the_command() {
    let error = ask(&mut Script::new(&[]), Request::TablesCount).expect_err("silence").to_string();
    assert!(error.starts_with("fsm: reply: expected one to \"TNR?\", found 0 bytes in 0.05 s;"), "{error}");
    for (reply, request, expected) in [
        ("1=1\n", Request::Positions, "fsm: POS? 1 2: expected 2 values, found 1"),
        ("2=1 \n1=1\n", Request::Positions, "found `2=1`"),
        ("1=1 \n2=nan\n", Request::Positions, "value 2: expected a number, found `nan`"),
        ("what\n", Request::Stop, "fsm: ERR?: expected an error number, found `what`"),
    ] {
        let error = ask(&mut Script::new(&[reply]), request).expect_err(reply).to_string();
        assert!(error.contains(expected), "{error}");
    }
    // Half a reply, then silence: it is not asked why.
    let mut half = Script::new(&["1=1 \n"]);
    let error = ask(&mut half, Request::Positions).expect_err("half").to_string();
    assert!(error.contains("found 5 bytes in 0.05 s") && half.sent.len() == 1, "{error}");
}

#[test]
fn a_late_reply_is_not_taken_for_that_of_the_next_request() {
    let mut line = Script::new(&["1=5 \n2=5\n", "1=7 \n2=7\n"]);
    let mut gcs = Gcs::new(settings()).expect("the settings are sound");
    gcs.send(&mut line, Request::Positions, Duration::ZERO).expect("the line is there");
    gcs.send(&mut line, Request::Targets, Duration::ZERO).expect("the line is there");
    let reply = gcs.poll(&mut line, Duration::from_millis(1)).expect("a reply");
    assert_eq!(reply, Some(Reply::Values([7.0, 7.0])));
    assert_eq!(gcs.poll(&mut line, Duration::from_millis(2)), Ok(None), "nothing is under way");
}

#[test]
fn settings_and_values_that_cannot_be_are_refused() {
    let no_time = GcsSettings { answer_timeout_s: 0.0, ..settings() };
    assert!(matches!(Gcs::new(no_time), Err(DeviceError::Setting { .. })));
    for axes in [["1", "1"], ["", "2"], ["1", "2\nSTP"]] {
        let odd = GcsSettings { axes: axes.map(str::to_owned), ..settings() };
        assert!(matches!(Gcs::new(odd), Err(DeviceError::Field { field: "axes", .. })));
    }
    let mut line = Script::new(&[]);
    let error = ask(&mut line, Request::Move([f64::NAN, 0.0])).expect_err("not finite").to_string();
    assert!(error.contains("value of a command is NaN") && line.sent.is_empty(), "{error}");
}

/// Lines of headers and rows in any order.
const LINES_OF_RECORDS: &str = "(# (DIM|NDATA|SAMPLE_TIME|NAME[0-9]{1,3}) = [0-9.]{0,4} \n\
                                |# END_HEADER \n|[0-9. ]{0,9}\n){0,9}";

proptest! {
    #[test]
    fn no_reply_makes_the_driver_panic(reply in prop::collection::vec(any::<u8>(), 0..250), which in 0..4_usize) {
        let request = [
            Request::Positions,
            Request::Recorded { first: 1, count: 3, tables: vec![1] },
            Request::Stop,
            Request::TablesCount,
        ][which].clone();
        let mut line = Script::new(&[]);
        let mut gcs = Gcs::new(settings()).expect("the settings are sound");
        gcs.send(&mut line, request, Duration::ZERO).expect("the line is there");
        line.incoming.extend(&reply);
        let outcome = gcs.poll(&mut line, Duration::from_millis(1));
        prop_assert_eq!(matches!(outcome, Ok(None)), !is_complete(&reply));
    }

    #[test]
    fn any_record_is_read_or_refused(text in LINES_OF_RECORDS) {
        if let Ok(record) = Record::read(&text) {
            prop_assert!(record.columns.iter().all(|column| column.len() == record.columns[0].len()));
            prop_assert_eq!(record.names.len(), record.columns.len());
        }
    }
}
