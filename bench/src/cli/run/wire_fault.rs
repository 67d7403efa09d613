//! One fault of the wire as an option: `back:delay=300us@1000x3`.

use std::time::Duration;

use drivers::wire::fault::{FaultKind, FrameFault, MIN_TRUNCATED_BYTES, Occurrence};
use drivers::wire::{MAX_FRAME_BYTES, Way};
use procedures::quantity::QuantityKind;

/// What `--help` says.
pub(super) const FORM: &str = "\
Plant a fault on the wire: WAY:KIND@WHEN; may be repeated. Refused where a device is real (exit 6)

WAY is `out` (to the stations) or `back`.
KIND is `drop`, `delay=300us`, `duplicate`, `corrupt` (one bit of any byte), `corrupt=17` (of that byte), `truncate=40` (bytes
that are left) or `reorder` (behind the next frame).
WHEN is a probability (`0.001`, `0.1%`), every n-th frame (`1/1000`), or frames in a row (`1000x3`: 1000, 1001, 1002). Frames
are counted from 1, each way for itself, as soon as it is known that no device is real. The same --seed gives the same faults.";

/// Longest delay.
const MOST_DELAY_S: f64 = 1.0;

/// A fault, and how it was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AskedFault {
    pub(super) text: String,
    pub(super) fault: FrameFault,
}

/// Reads a fault.
pub(super) fn wire_fault(text: &str) -> Result<AskedFault, String> {
    let form = || {
        format!("expected WAY:KIND@WHEN, e.g. `back:drop@0.001` or `out:delay=300us@1000x3`, found `{text}`")
    };
    let (way, rest) = text.split_once(':').ok_or_else(form)?;
    let (kind, when) = rest.rsplit_once('@').ok_or_else(form)?;
    let way = match way.trim() {
        "out" => Way::Out,
        "back" => Way::Back,
        other => {
            return Err(format!(
                "expected `out` (to the stations) or `back` before the colon, found `{other}`"
            ));
        }
    };
    let fault = FrameFault { way, kind: kind_of(kind.trim())?, when: when_of(when.trim())? };
    Ok(AskedFault { text: text.to_owned(), fault })
}

fn kind_of(text: &str) -> Result<FaultKind, String> {
    let (name, value) = match text.split_once('=') {
        Some((name, value)) => (name.trim(), Some(value.trim())),
        None => (text, None),
    };
    match (name, value) {
        ("drop", None) => Ok(FaultKind::Drop),
        ("duplicate", None) => Ok(FaultKind::Duplicate),
        ("reorder", None) => Ok(FaultKind::Reorder),
        ("corrupt", None) => Ok(FaultKind::Corrupt { byte: None }),
        ("corrupt", Some(byte)) => {
            let byte = Some(whole(name, byte, 0, MAX_FRAME_BYTES - 1)?);
            Ok(FaultKind::Corrupt { byte })
        }
        ("truncate", Some(bytes)) => {
            let bytes = whole(name, bytes, MIN_TRUNCATED_BYTES, MAX_FRAME_BYTES - 1)?;
            Ok(FaultKind::Truncate { bytes })
        }
        ("delay", Some(by)) => {
            let by_s = QuantityKind::Time.parse(by).map_err(|error| format!("`delay`: {error}"))?;
            if by_s <= 0.0 || by_s > MOST_DELAY_S {
                return Err(format!(
                    "`delay`: expected more than 0 and at most {MOST_DELAY_S} s, found `{by}`"
                ));
            }
            Ok(FaultKind::Delay { by: Duration::from_secs_f64(by_s) })
        }
        ("delay", None) => Err("`delay` needs a time, e.g. `delay=300us`".to_owned()),
        ("truncate", None) => Err("`truncate` needs the bytes that are left, e.g. `truncate=40`".to_owned()),
        ("drop" | "duplicate" | "reorder", Some(value)) => {
            Err(format!("`{name}` has no value, found `{value}`; when it occurs stands behind `@`"))
        }
        _ => Err(format!(
            "expected `drop`, `delay=TIME`, `duplicate`, `corrupt`, `corrupt=BYTE`, `truncate=BYTES` or `reorder`, found \
             `{name}`"
        )),
    }
}

fn whole(name: &str, text: &str, least: usize, most: usize) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("`{name}`: expected a whole number from {least} to {most}, found `{text}`"))
}

fn when_of(text: &str) -> Result<Occurrence, String> {
    let wrong = || {
        format!(
            "expected behind `@` a probability (`0.001`, `0.1%`), every n-th frame (`1/1000`) or frames in a row \
             (`1000x3`), found `{text}`"
        )
    };
    let from_1 = |text: &str| text.trim().parse().ok().filter(|&number: &u64| number > 0).ok_or_else(wrong);
    if let Some((one, period)) = text.split_once('/') {
        return match one.trim() {
            "1" => Ok(Occurrence::Every(from_1(period)?)),
            _ => Err(wrong()),
        };
    }
    if let Some((first, count)) = text.split_once('x') {
        return Ok(Occurrence::At { first: from_1(first)?, count: from_1(count)? });
    }
    let probability = QuantityKind::Ratio.parse(text).map_err(|_| wrong())?;
    if probability > 0.0 && probability <= 1.0 { Ok(Occurrence::Chance(probability)) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<FrameFault, String> {
        wire_fault(text).map(|asked| asked.fault)
    }

    #[test]
    fn every_form_is_read_as_its_help_says() {
        let fault = |way, kind, when| Ok(FrameFault { way, kind, when });
        let chance = Occurrence::Chance(0.001);
        let us = Duration::from_micros(300);
        for (text, expected) in [
            ("back:drop@0.001", fault(Way::Back, FaultKind::Drop, chance)),
            ("back:drop@0.1%", fault(Way::Back, FaultKind::Drop, chance)),
            (
                "out:delay=300us@1000x3",
                fault(Way::Out, FaultKind::Delay { by: us }, Occurrence::At { first: 1000, count: 3 }),
            ),
            ("back:delay=0.3 ms@1", fault(Way::Back, FaultKind::Delay { by: us }, Occurrence::Chance(1.0))),
            ("out:duplicate@1/50", fault(Way::Out, FaultKind::Duplicate, Occurrence::Every(50))),
            ("back:corrupt@0.001", fault(Way::Back, FaultKind::Corrupt { byte: None }, chance)),
            ("back:corrupt=17@0.001", fault(Way::Back, FaultKind::Corrupt { byte: Some(17) }, chance)),
            ("back:truncate=40@0.001", fault(Way::Back, FaultKind::Truncate { bytes: 40 }, chance)),
            ("back:reorder@0.001", fault(Way::Back, FaultKind::Reorder, chance)),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn everything_else_is_told_what_was_expected() {
        for (text, expected) in [
            ("", "expected WAY:KIND@WHEN"),
            ("drop@0.1", "expected WAY:KIND@WHEN"),
            ("back:drop", "expected WAY:KIND@WHEN"),
            ("both:drop@0.1", "expected `out` (to the stations) or `back`"),
            ("back:loose@0.1", "expected `drop`"),
            ("back:drop=0.001@1x1", "`drop` has no value"),
            ("back:delay@0.1", "`delay` needs a time"),
            ("back:delay=3@0.1", "`delay`: expected"),
            ("back:delay=2 s@0.1", "`delay`: expected more than 0 and at most 1 s"),
            ("back:truncate=13@0.1", "`truncate`: expected a whole number from 14"),
            ("back:corrupt=-1@0.1", "`corrupt`: expected a whole number from 0"),
            ("back:drop@0", "expected behind `@`"),
            ("back:drop@1.5", "expected behind `@`"),
            ("back:drop@NaN", "expected behind `@`"),
            ("back:drop@2/100", "expected behind `@`"),
            ("back:drop@1/0", "expected behind `@`"),
            ("back:drop@0x3", "expected behind `@`"),
            ("back:drop@3x", "expected behind `@`"),
        ] {
            let found = read(text).expect_err(text);
            assert!(found.starts_with(expected), "{text}: {found}");
        }
    }
}
