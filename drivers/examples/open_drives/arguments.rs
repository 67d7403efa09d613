//! What the example is told.

/// How to call it.
pub(crate) const USAGE: &str = "usage: open_drives INTERFACE [--cycles N] [--cycle-us US] [--sync0] [--enable] [--read INDEX:SUB]... \
                                [--probe]; cycles from 1, cycle 100 to 100000 us, index and sub-index in hexadecimal digits";

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) interface: String,
    pub(crate) cycles: u32,
    pub(crate) cycle_us: u32,
    pub(crate) has_sync0: bool,
    pub(crate) enables: bool,
    /// Objects to be read from every station.
    pub(crate) reads: Vec<Place>,
    pub(crate) probes: bool,
}

/// An object of a dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) index: u16,
    pub(crate) sub: u8,
}

pub(crate) fn read(given: &[String]) -> Result<Plan, String> {
    let mut plan = Plan {
        interface: String::new(),
        cycles: 1000,
        cycle_us: 1000,
        has_sync0: false,
        enables: false,
        reads: Vec::new(),
        probes: false,
    };
    let mut rest = given.iter();
    while let Some(word) = rest.next() {
        let mut value = || rest.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--cycles" => plan.cycles = number(word, value()?, 1, u32::MAX)?,
            "--cycle-us" => plan.cycle_us = number(word, value()?, 100, 100_000)?,
            "--sync0" => plan.has_sync0 = true,
            "--enable" => plan.enables = true,
            "--probe" => plan.probes = true,
            "--read" => plan.reads.push(place(value()?)?),
            other if other.starts_with('-') || !plan.interface.is_empty() => {
                return Err(format!("{other} is not understood"));
            }
            interface => interface.clone_into(&mut plan.interface),
        }
    }
    if plan.interface.is_empty() { Err("no interface is given".to_owned()) } else { Ok(plan) }
}

fn number(option: &str, text: &str, least: u32, most: u32) -> Result<u32, String> {
    let value = text.parse().ok().filter(|value| (least..=most).contains(value));
    value.ok_or_else(|| format!("{option} {text}: expected a whole number from {least} to {most}"))
}

fn place(text: &str) -> Result<Place, String> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    match (u16::from_str_radix(index, 16), u8::from_str_radix(sub, 16)) {
        (Ok(index), Ok(sub)) => Ok(Place { index, sub }),
        _ => Err(format!(
            "--read {text}: expected an index and a sub-index in hexadecimal digits, e.g. 1018:1"
        )),
    }
}
