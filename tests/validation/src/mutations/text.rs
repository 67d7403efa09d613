//! Mutations of files as people and disks make them: of text by what it says, of bytes wherever they lie.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::RngCore;

/// A number below `end`; 0 where there is none.
pub(super) fn below(random: &mut ChaCha8Rng, end: usize) -> usize {
    if end == 0 { 0 } else { (random.next_u64() % end as u64) as usize }
}

/// One of a list.
pub(super) fn one<'a, T>(random: &mut ChaCha8Rng, of: &'a [T]) -> &'a T {
    &of[below(random, of.len())]
}

/// A way to mutate.
pub(super) struct Way {
    /// What it does, for the record.
    pub name: &'static str,
    /// Does it.
    pub apply: fn(Vec<u8>, &mut ChaCha8Rng) -> Vec<u8>,
}

/// Ways that fit every file.
pub(super) const BYTES: &[Way] = &[
    Way { name: "bits flipped", apply: flip },
    Way { name: "cut off", apply: truncate },
    Way { name: "a range missing", apply: remove },
    Way { name: "a range twice", apply: double },
    Way { name: "ranges exchanged", apply: exchange },
    Way { name: "zeros", apply: zero },
    Way { name: "foreign characters", apply: foreign },
];

/// Ways that fit text.
pub(super) const TEXT: &[Way] = &[
    Way { name: "lines exchanged", apply: swap_lines },
    Way { name: "a line missing", apply: drop_line },
    Way { name: "a line twice", apply: double_line },
    Way { name: "extreme number", apply: extreme },
    Way { name: "extreme numbers", apply: extremes },
    Way { name: "values exchanged", apply: swap_values },
    Way { name: "another unit", apply: unit },
    Way { name: "a word for a value", apply: word },
    Way { name: "long text", apply: long },
    Way { name: "nested deeply", apply: nested },
    Way { name: "blocks repeated", apply: repeated },
    Way { name: "unknown keys", apply: keys },
    Way { name: "a very long list", apply: list },
    Way { name: "foreign characters", apply: foreign },
];

/// Numbers at the ends of what a number can be.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1e-13",
    "1e-300",
    "1e300",
    "-1e300",
    "1e308",
    "3.6e302",
    "4.9e-324",
    "1e18",
    "1e9",
    "1e6",
    "0.5",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "4294967295",
    "65536",
    "10000",
    "1000",
    "nan",
    "inf",
    "1e400",
    "999999999999",
    "0.1",
    "2",
    "7",
    "1e-5",
    "1e3",
    "1e-3",
    "100",
];

fn ends(random: &mut ChaCha8Rng, bytes: &[u8]) -> [usize; 2] {
    let from = below(random, bytes.len());
    let most = *one(random, &[1, 4, 16, 256, 4096, usize::MAX]);
    [from, from + 1 + below(random, (bytes.len() - from).min(most))].map(|at| at.min(bytes.len()))
}

fn flip(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    for _ in 0..*one(random, &[1, 1, 2, 8, 64]) {
        let at = below(random, bytes.len());
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 1 << below(random, 8);
        }
    }
    bytes
}

fn truncate(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    bytes.truncate(below(random, bytes.len()));
    bytes
}

fn remove(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let [from, to] = ends(random, &bytes);
    bytes.drain(from..to);
    bytes
}

fn double(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let [from, to] = ends(random, &bytes);
    let range = bytes[from..to].to_vec();
    let at = below(random, bytes.len());
    bytes.splice(at..at, range);
    bytes
}

fn exchange(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let [from, to] = ends(random, &bytes);
    let range: Vec<u8> = bytes.drain(from..to).collect();
    let at = below(random, bytes.len());
    bytes.splice(at..at, range);
    bytes
}

fn zero(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let [from, to] = ends(random, &bytes);
    let value = *one(random, &[0_u8, 0xFF, 0x1B, b'"', b'[']);
    bytes[from..to].fill(value);
    bytes
}

fn foreign(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let pieces: [&[u8]; 9] = [
        b"\0",
        b"\x1b[2J\x1b]0;x\x07",
        "µ€😀".as_bytes(),
        "\u{202e}".as_bytes(),
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"\r",
        "\u{0301}\u{0301}".as_bytes(),
        "−".as_bytes(),
    ];
    for _ in 0..*one(random, &[1, 1, 3]) {
        let at = below(random, bytes.len() + 1);
        bytes.splice(at..at, one(random, &pieces).iter().copied());
    }
    bytes
}

fn lines(bytes: &[u8]) -> Vec<Vec<u8>> {
    bytes.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec).collect()
}

fn swap_lines(bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut all = lines(&bytes);
    if !all.is_empty() {
        let a = below(random, all.len());
        let b = below(random, all.len());
        all.swap(a, b);
    }
    all.concat()
}

fn drop_line(bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut all = lines(&bytes);
    if !all.is_empty() {
        all.remove(below(random, all.len()));
    }
    all.concat()
}

fn double_line(bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut all = lines(&bytes);
    if !all.is_empty() {
        let line = all[below(random, all.len())].clone();
        all.insert(below(random, all.len()), line);
    }
    all.concat()
}

/// Where numbers stand.
fn numbers(bytes: &[u8]) -> Vec<[usize; 2]> {
    let digit = |b: u8| b.is_ascii_digit() || b == b'.';
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at].is_ascii_digit() && (at == 0 || !bytes[at - 1].is_ascii_alphanumeric()) {
            let length = bytes[at..].iter().take_while(|b| digit(**b)).count();
            found.push([at, at + length]);
            at += length;
        } else {
            at += 1;
        }
    }
    found
}

/// One of the places, if there are any.
fn any(places: &[[usize; 2]], random: &mut ChaCha8Rng) -> Option<[usize; 2]> {
    places.get(below(random, places.len())).copied()
}

/// Puts a text in the place of the number of an index.
fn put(bytes: &mut Vec<u8>, place: Option<&[usize; 2]>, text: &str) {
    if let Some(&[from, to]) = place {
        bytes.splice(from..to, text.bytes());
    }
}

fn extreme(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let place = any(&numbers(&bytes), random);
    let number = *one(random, NUMBERS);
    put(&mut bytes, place.as_ref(), number);
    bytes
}

fn extremes(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    for _ in 0..3 {
        bytes = extreme(bytes, random);
    }
    bytes
}

fn swap_values(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let all = numbers(&bytes);
    if all.len() > 1 {
        let a = all[below(random, all.len())];
        let b = all[below(random, all.len())];
        let text = String::from_utf8_lossy(&bytes[b[0]..b[1]]).into_owned();
        put(&mut bytes, Some(&a), &text);
    }
    bytes
}

/// Texts in double quotes, without these.
fn quoted(bytes: &[u8]) -> Vec<[usize; 2]> {
    let marks: Vec<usize> = bytes.iter().enumerate().filter(|(_, b)| **b == b'"').map(|(at, _)| at).collect();
    marks.chunks_exact(2).map(|pair| [pair[0] + 1, pair[1]]).collect()
}

fn unit(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    const UNITS: &[&str] =
        &["deg", "rad", "Hz", "s", "h", "N*m", "A", "deg/s", "deg/s^2", "%", "kg*m^2", "urad", "us", "kHz"];
    let place = any(&quoted(&bytes), random);
    let text = format!("{} {}", one(random, NUMBERS), one(random, UNITS));
    put(&mut bytes, place.as_ref(), &text);
    bytes
}

fn word(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    const WORDS: &[&str] = &[
        "",
        " ",
        "az",
        "el",
        "..",
        "-1 .. 1",
        "../../../etc/passwd",
        "/dev/zero",
        "1 .. 1",
        "yes",
        "%n",
        "shipped:quick.toml",
    ];
    let place = any(&quoted(&bytes), random);
    let text = *one(random, WORDS);
    put(&mut bytes, place.as_ref(), text);
    bytes
}

fn long(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let place = any(&quoted(&bytes), random);
    let text = one(random, &["x", "é", "9", "../", "1 .. "]).repeat(*one(random, &[200, 20_000, 600_000]));
    put(&mut bytes, place.as_ref(), &text);
    bytes
}

fn nested(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let depth = *one(random, &[70, 90, 200, 10_000, 300_000]);
    let (open, close) = *one(random, &[("[", "]"), ("{a=", "}"), ("{\"a\":", "}"), ("[[", "]]")]);
    let text = format!("{}1{}", open.repeat(depth), close.repeat(depth));
    let all = numbers(&bytes);
    match all.get(below(random, all.len())).copied() {
        Some(place) => put(&mut bytes, Some(&place), &text),
        None => bytes.extend(text.bytes()),
    }
    bytes
}

fn repeated(bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let all = lines(&bytes);
    let headers: Vec<usize> = (0..all.len()).filter(|&k| all[k].first() == Some(&b'[')).collect();
    let from = if headers.is_empty() { 0 } else { *one(random, &headers) };
    let to = headers.iter().copied().find(|&k| k > from).unwrap_or(all.len());
    let block = all[from..to].concat();
    let times = (*one(random, &[2, 30, 2000, 40_000])).min((3 << 20) / block.len().max(1));
    let mut mutated = all[..to].concat();
    mutated.extend(block.repeat(times));
    mutated.extend(all[to..].concat());
    mutated
}

fn keys(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let count = *one(random, &[1, 50, 5000, 90_000, 200_000]);
    let at = if below(random, 2) == 0 { 0 } else { bytes.len() };
    let text: String = (0..count).map(|k| format!("key{k} = {k}\n")).collect();
    bytes.splice(at..at, text.bytes());
    bytes
}

fn list(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let all = quoted(&bytes);
    let Some([from, to]) = all.get(below(random, all.len())).copied() else { return bytes };
    let value = format!("\"{}\", ", String::from_utf8_lossy(&bytes[from..to]));
    let count = *one(random, &[3, 500, 900, 2000, 100_000]);
    let text = value.repeat(count.min((2 << 20) / value.len()));
    bytes.splice(from - 1..from - 1, text.bytes());
    bytes
}
