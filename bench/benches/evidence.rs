//! What it costs to check a run folder: nearly all of it is the digests of the logs.

use bench::record::evidence;
use bench::record::journal::{Entry, Journal, sha256_of};
use divan::counter::BytesCount;

fn main() {
    divan::main();
}

const LOG: &str = "P.mcap";

/// A folder with one log of this size, which the journal has on record.
fn folder(bytes: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(LOG);
    let noise: Vec<u8> = (0..bytes).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    std::fs::write(&path, noise).expect("a writable folder");
    let (sha256, size_bytes) = sha256_of(&path).expect("readable");
    let mut journal = Journal::create(folder.path()).expect("a fresh folder");
    journal.write(Entry::Kept { file: LOG.to_owned(), sha256, size_bytes }).expect("writable");
    let files = journal.close(0).expect("writable");
    evidence::write_index(folder.path(), &files).expect("writable");
    folder
}

#[divan::bench(args = [16, 256], sample_count = 5)]
fn check(bencher: divan::Bencher<'_, '_>, mebibytes: usize) {
    let bytes = mebibytes << 20;
    let folder = folder(bytes);
    bencher.counter(BytesCount::new(bytes)).bench(|| evidence::check(folder.path()));
}
