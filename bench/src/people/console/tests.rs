//! A reader that stalls delays nobody, and a reader that is slow loses nothing.

use std::sync::Mutex;
use std::sync::mpsc::Sender;

use super::*;

/// Writes each event once it is let.
struct Held {
    let_go: Receiver<()>,
    heard: Arc<Mutex<Vec<String>>>,
}

impl Listener for Held {
    fn hear(&mut self, event: &RunEvent) {
        let _ = self.let_go.recv();
        let text = match event {
            RunEvent::Notice { text } | RunEvent::Question { text, .. } => text.clone(),
            other => format!("{other:?}"),
        };
        self.heard.lock().expect("not poisoned").push(text);
    }
}

fn lane(room: usize) -> (Lane, Sender<()>, Arc<Mutex<Vec<String>>>) {
    let (go, let_go) = std::sync::mpsc::channel();
    let heard = Arc::new(Mutex::new(Vec::new()));
    let listener = Box::new(Held { let_go, heard: Arc::clone(&heard) });
    (Lane::start("test", listener, Arc::default(), room).expect("a thread"), go, heard)
}

fn notice(text: &str) -> RunEvent {
    RunEvent::Notice { text: text.to_owned() }
}

#[test]
fn a_stalled_reader_delays_neither_who_speaks_nor_the_end() {
    let (lane, _go, heard) = lane(4);
    let watch = Stopwatch::start();
    for k in 0..10_000 {
        lane.hear(notice(&k.to_string()));
    }
    assert!(watch.elapsed_s() < 0.4, "{} s for 10000 messages", watch.elapsed_s());
    assert!(lane.counts.dropped.load(Ordering::Acquire) >= 10_000 - 5);
    let watch = Stopwatch::start();
    drain_lanes(&[&lane]);
    assert!((STALLED_S..STALLED_S + 0.4).contains(&watch.elapsed_s()), "{} s", watch.elapsed_s());
    assert!(heard.lock().expect("not poisoned").is_empty());
}

#[test]
fn a_reader_that_goes_on_gets_what_was_kept_and_is_told_what_was_not() {
    let (lane, go, heard) = lane(4);
    for k in 0..100 {
        lane.hear(notice(&k.to_string()));
    }
    for _ in 0..10 {
        go.send(()).expect("it listens");
    }
    drain_lanes(&[&lane]);
    let heard = heard.lock().expect("not poisoned").clone();
    assert!(heard.starts_with(&["0".to_owned()]) && heard.contains(&"3".to_owned()), "{heard:?}");
    let dropped = lane.counts.dropped.load(Ordering::Acquire);
    let told = format!("{dropped} messages are missing here, because the terminal did not accept them");
    assert!(heard.contains(&told), "{heard:?}");
}

#[test]
fn a_slow_reader_gets_everything_before_the_end() {
    let (lane, go, heard) = lane(QUEUE);
    for k in 0..20 {
        lane.hear(notice(&k.to_string()));
    }
    // A message each 50 ms: a second in all, twice as long as a stall may last.
    let reader = std::thread::spawn(move || {
        for _ in 0..20 {
            let watch = Stopwatch::start();
            while watch.elapsed_s() < 0.05 {
                clock::nap();
            }
            let _ = go.send(());
        }
    });
    drain_lanes(&[&lane]);
    assert_eq!(heard.lock().expect("not poisoned").len(), 20);
    reader.join().expect("it ends");
}

#[test]
fn a_question_counts_as_shown_only_when_it_was_written_and_its_loss_is_seen() {
    let (lane, go, _heard) = lane(1);
    let shown = Shown::default();
    lane.hear(RunEvent::Question { text: "Clear?".to_owned(), shown: shown.clone() });
    assert!(!shown.is_set() && !shown.is_lost());
    go.send(()).expect("it listens");
    drain_lanes(&[&lane]);
    assert!(shown.is_set());
    // The thread holds one message, the queue another; the next is dropped.
    lane.hear(notice("held"));
    while lane.queue.try_send(notice("queued")).is_ok() {
        clock::nap();
    }
    let lost = Shown::default();
    lane.hear(RunEvent::Question { text: "Clear?".to_owned(), shown: lost.clone() });
    assert!(lost.is_lost() && !lost.is_set());
}
