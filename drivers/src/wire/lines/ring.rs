//! A ring of chunks between two threads: bytes, and where and when each chunk of them was put in. Neither end waits, locks or
//! allocates.

use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

/// How much fits into a ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RingSize {
    /// Bytes of all chunks together.
    pub(super) bytes: usize,
    /// Chunks.
    pub(super) chunks: usize,
}

/// Bytes that were put in together.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    at: Duration,
    bytes_count: usize,
}

/// The end at which chunks are put in.
pub(super) struct Feed {
    bytes: Producer<u8>,
    chunks: Producer<Chunk>,
}

/// The end at which they are taken out.
pub(super) struct Drain {
    bytes: Consumer<u8>,
    chunks: Consumer<Chunk>,
    /// Bytes of the oldest chunk that were taken already.
    taken_count: usize,
}

/// Both ends of a ring.
pub(super) fn ring(size: RingSize) -> (Feed, Drain) {
    let (bytes_in, bytes_out) = RingBuffer::new(size.bytes);
    let (chunks_in, chunks_out) = RingBuffer::new(size.chunks);
    (
        Feed { bytes: bytes_in, chunks: chunks_in },
        Drain { bytes: bytes_out, chunks: chunks_out, taken_count: 0 },
    )
}

impl Feed {
    /// Puts a chunk in, whole; `false` if there is no room for it.
    pub(super) fn push(&mut self, at: Duration, bytes: &[u8]) -> bool {
        // The chunk is announced after its bytes, so whoever finds it finds them.
        !self.chunks.is_full()
            && self.bytes.push_entire_slice(bytes).is_ok()
            && self.chunks.push(Chunk { at, bytes_count: bytes.len() }).is_ok()
    }

    /// Puts the first of the bytes in, as many as there is room for, as one chunk; how many.
    pub(super) fn push_what_fits(&mut self, at: Duration, bytes: &[u8]) -> usize {
        let count = bytes.len().min(self.room_bytes());
        if count > 0 && self.push(at, &bytes[..count]) { count } else { 0 }
    }

    /// Bytes that the next chunk may have.
    pub(super) fn room_bytes(&self) -> usize {
        if self.chunks.is_full() { 0 } else { self.bytes.slots() }
    }

    /// Bytes that fit into the ring.
    pub(super) fn capacity_bytes(&self) -> usize {
        self.bytes.buffer().capacity()
    }
}

impl Drain {
    /// Takes bytes that were put in at `now` or before, across chunks; how many.
    pub(super) fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        let mut filled_count = 0;
        while let Ok(&chunk) = self.chunks.peek()
            && chunk.at <= now
            && filled_count < into.len()
        {
            let left_count = chunk.bytes_count - self.taken_count;
            let count = left_count.min(into.len() - filled_count);
            self.take(&mut into[filled_count..filled_count + count]);
            filled_count += count;
            self.taken_count += count;
            if count == left_count {
                self.end_chunk();
            }
        }
        filled_count
    }

    /// Takes the oldest chunk if it was put in at `now` or before; how many of its bytes are in `into`. Those that do not fit are
    /// thrown away.
    pub(super) fn next_chunk(&mut self, now: Duration, into: &mut [u8]) -> Option<usize> {
        let chunk = self.chunks.peek().ok().copied().filter(|chunk| chunk.at <= now)?;
        let count = chunk.bytes_count.min(into.len());
        self.take(&mut into[..count]);
        if let Ok(rest) = self.bytes.read_chunk(chunk.bytes_count - count) {
            rest.commit_all();
        }
        self.end_chunk();
        Some(count)
    }

    /// Whether nothing is in the ring, of whatever time.
    pub(super) fn is_empty(&self) -> bool {
        self.chunks.is_empty()
    }

    fn take(&mut self, into: &mut [u8]) {
        let is_whole = self.bytes.pop_entire_slice(into).is_ok();
        debug_assert!(is_whole, "a chunk is announced after its bytes");
    }

    fn end_chunk(&mut self) {
        let _ = self.chunks.pop();
        self.taken_count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: RingSize = RingSize { bytes: 8, chunks: 3 };

    fn at(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn bytes_come_out_in_order_across_chunks_and_in_pieces_of_any_size() {
        let (mut feed, mut drain) = ring(SIZE);
        assert!(feed.push(at(1), b"abc") && feed.push(at(2), b"de"));
        let mut two = [0; 2];
        assert_eq!((drain.read(at(9), &mut two), &two), (2, b"ab"));
        assert_eq!((drain.read(at(9), &mut two), &two), (2, b"cd"));
        assert_eq!((drain.read(at(9), &mut two), two[0]), (1, b'e'));
        assert_eq!(drain.read(at(9), &mut two), 0);
        assert!(drain.is_empty());
    }

    #[test]
    fn what_was_put_in_later_than_now_stays() {
        let (mut feed, mut drain) = ring(SIZE);
        assert!(feed.push(at(1), b"ab") && feed.push(at(3), b"cd"));
        let mut all = [0; 8];
        assert_eq!(drain.read(at(0), &mut all), 0);
        assert_eq!(drain.read(at(2), &mut all), 2);
        assert_eq!(drain.next_chunk(at(2), &mut all), None);
        assert!(!drain.is_empty());
        assert_eq!(drain.next_chunk(at(3), &mut all), Some(2));
    }

    #[test]
    fn a_chunk_goes_in_whole_or_not_at_all() {
        let (mut feed, mut drain) = ring(SIZE);
        assert!(feed.push(at(1), b"abcdef"));
        assert!(!feed.push(at(1), b"ghi"), "8 bytes");
        assert_eq!(feed.room_bytes(), 2);
        assert!(feed.push(at(1), b"") && feed.push(at(1), b"g"));
        assert_eq!(feed.room_bytes(), 0);
        assert!(!feed.push(at(1), b"h"), "3 chunks");
        let mut all = [0; 8];
        assert_eq!((drain.read(at(1), &mut all), &all[..7]), (7, b"abcdefg".as_slice()));
        assert_eq!(feed.room_bytes(), 8);
    }

    #[test]
    fn of_a_line_as_much_goes_in_as_fits() {
        let (mut feed, mut drain) = ring(SIZE);
        assert_eq!(feed.push_what_fits(at(1), b"abcdefghijk"), 8, "more than the ring");
        assert_eq!(feed.push_what_fits(at(1), b"l"), 0, "8 bytes are in");
        let mut all = [0; 8];
        assert_eq!((drain.read(at(1), &mut all), &all), (8, b"abcdefgh"));
        let chunks = ["m", "n", "o", "p"].map(|byte| feed.push_what_fits(at(1), byte.as_bytes()));
        assert_eq!(chunks, [1, 1, 1, 0], "3 chunks");
    }

    #[test]
    fn what_does_not_fit_of_a_message_is_cut_off_and_the_next_one_is_whole() {
        let (mut feed, mut drain) = ring(SIZE);
        assert!(feed.push(at(1), b"abcd") && feed.push(at(1), b"") && feed.push(at(1), b"xy"));
        let mut three = [0; 3];
        assert_eq!((drain.next_chunk(at(1), &mut three), &three), (Some(3), b"abc"));
        assert_eq!(drain.next_chunk(at(1), &mut three), Some(0));
        assert_eq!(drain.next_chunk(at(1), &mut three), Some(2));
        assert_eq!(&three[..2], b"xy");
        assert_eq!(drain.next_chunk(at(1), &mut three), None);
    }
}
