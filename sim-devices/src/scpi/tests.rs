use super::*;

fn units(messages: &str) -> (Port, Vec<Unit>) {
    let mut port = Port::new("a,b,c,d");
    port.receive(messages.as_bytes());
    let mut all = Vec::new();
    while let Some(unit) = port.next_unit(Duration::ZERO) {
        all.push(unit);
    }
    (port, all)
}

fn said(port: &mut Port) -> String {
    let mut text = Vec::new();
    let mut into = [0; 64];
    loop {
        match port.take(Duration::from_secs(1), &mut into) {
            0 => return String::from_utf8_lossy(&text).into_owned(),
            count => text.extend(&into[..count]),
        }
    }
}

#[test]
fn short_and_long_forms_are_known_and_nothing_between() {
    let pattern = "SENSe#:FREQuency:STARt";
    for header in ["SENS1:FREQ:STAR", "SENSE:FREQUENCY:START", "SENS:FREQUENCY:STAR"] {
        assert_eq!(matches(pattern, header), Some(vec![1]), "{header}");
    }
    assert_eq!(matches(pattern, "SENS12:FREQ:STAR"), Some(vec![12]));
    for header in ["SEN:FREQ:STAR", "SENSE1:FREQU:STAR", "SENS:FREQ", "SENS:FREQ:STAR:X", "SENS:FREQ1:STAR"] {
        assert_eq!(matches(pattern, header), None, "{header}");
    }
}

#[test]
fn units_of_a_message_go_on_from_the_last_node() {
    let (_, units) = units(":sens1:freq:star 20;STOP 2000;*OPC?;POIN? 1 , 2\nABOR\n");
    let headers: Vec<_> = units.iter().map(|unit| (unit.header.as_str(), unit.query)).collect();
    let expected = [
        ("SENS1:FREQ:STAR", false),
        ("SENS1:FREQ:STOP", false),
        ("*OPC", true),
        ("SENS1:FREQ:POIN", true),
        ("ABOR", false),
    ];
    assert_eq!(headers, expected);
    assert_eq!(units[3].parameters, ["1", "2"]);
}

#[test]
fn a_message_before_an_answer_was_read_interrupts_it() {
    let mut port = Port::new("a,b,c,d");
    port.receive(b"*OPC?\n");
    let unit = port.next_unit(Duration::ZERO).expect("a query");
    assert!(port.common(&unit, true));
    port.receive(b"ABOR\nSYST:ERR?\n");
    let abort = port.next_unit(Duration::ZERO).expect("a command");
    assert_eq!(abort.header, "ABOR");
    let ask = port.next_unit(Duration::ZERO).expect("a query");
    assert!(port.common(&ask, false));
    assert_eq!(port.next_unit(Duration::ZERO), None);
    port.complete(Duration::ZERO);
    assert_eq!(said(&mut port), "-410,\"Query INTERRUPTED\"\n");
}

#[test]
fn the_error_queue_ends_with_its_overflow_and_cls_empties_it() {
    let mut port = Port::new("a,b,c,d");
    (0..30).for_each(|_| port.raise(code::UNDEFINED_HEADER));
    let mut read = || {
        port.receive(b"SYST:ERR?\n");
        let unit = port.next_unit(Duration::ZERO).expect("a query");
        assert!(port.common(&unit, false));
        assert_eq!(port.next_unit(Duration::ZERO), None);
        said(&mut port)
    };
    for _ in 0..19 {
        assert_eq!(read(), "-113,\"Undefined header\"\n");
    }
    assert_eq!(read(), "-350,\"Queue overflow\"\n");
    assert_eq!(read(), "+0,\"No error\"\n");
}

#[test]
fn a_channel_list_is_one_parameter() {
    let (_, units) = units("VOLT 24 , (@1,2:3)\nMEAS? (@1)\n");
    assert_eq!(units[0].parameters, ["24", "(@1,2:3)"]);
    assert_eq!(units[1].parameters, ["(@1)"]);
}

#[test]
fn a_message_that_is_too_long_is_thrown_away_whole_and_the_next_one_is_heard() {
    let long = "X".repeat(LONGEST_MESSAGE + 100);
    let (port, units) = units(&format!("ABOR\n{long}\n*CLS\n"));
    let headers: Vec<&str> = units.iter().map(|unit| unit.header.as_str()).collect();
    assert_eq!(headers, ["ABOR", "*CLS"]);
    assert_eq!(port.errors, [code::INPUT_OVERRUN]);
}

#[test]
fn the_status_byte_sums_up_errors_events_and_masks() {
    let mut port = Port::new("a,b,c,d");
    let ask = |port: &mut Port, message: &str| {
        port.receive(format!("{message}\n").as_bytes());
        while let Some(unit) = port.next_unit(Duration::ZERO) {
            if !port.common(&unit, false) {
                port.raise(code::UNDEFINED_HEADER);
            }
        }
        said(port)
    };
    assert_eq!(ask(&mut port, "*CLS;*ESE 32;*SRE 36;*STB?"), "+0\n");
    assert_eq!(ask(&mut port, "NONSENSE"), "");
    // Error queue 4, event summary 32, master summary 64.
    assert_eq!(ask(&mut port, "*STB?"), "+100\n");
    assert_eq!(ask(&mut port, "*ESR?;*ESR?;*ESE?;*SRE?"), "+32;+0;+32;+36\n");
    assert_eq!(ask(&mut port, "SYST:ERR?"), "-113,\"Undefined header\"\n");
    assert_eq!(ask(&mut port, "*STB?;*TST?;*WAI;SYST:VERS?"), "+0;+0;1999.0\n");
}
