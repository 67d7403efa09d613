//! The thread for calls that wait for a station: transfers and changes of state. The tick only sends orders and looks whether
//! there is an answer.

use std::io::ErrorKind;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use ethercat::{AlState, Error, Master, MasterAccess, SdoIdx, SlavePos};

use super::super::{SdoAbort, SdoRequest};

/// Longest object that can be read.
const MOST_BYTES: usize = 1024;
/// General error: the binding does not tell the station's own abort code.
const GENERAL: SdoAbort = SdoAbort(0x0800_0000);
const TIMED_OUT: SdoAbort = SdoAbort(0x0504_0000);

enum Order {
    Transfer { number: u64, position: SlavePos, object: SdoIdx, write: Option<Vec<u8>> },
    State { position: SlavePos, state: AlState },
}

struct Done {
    number: u64,
    outcome: Result<Vec<u8>, SdoAbort>,
}

/// The tick's end of the thread.
pub(super) struct Worker {
    orders: Sender<Order>,
    answers: Receiver<Done>,
    /// Number of the transfer that was begun last: answers to others are forgotten.
    number: u64,
    /// The transfer has failed before it was begun.
    failed: Option<SdoAbort>,
}

impl Worker {
    /// Starts the thread, with a handle of the master of its own. It ends after the last order.
    pub(super) fn start(master: u32) -> Result<Self, String> {
        let own = Master::open(master, MasterAccess::ReadWrite).map_err(|error| super::told(&error))?;
        let (orders, ordered) = channel();
        let (answer, answers) = channel();
        let work = move || serve(own, &ordered, &answer);
        let spawned = std::thread::Builder::new().name("igh-sdo".to_owned()).spawn(work);
        spawned.map_err(|error| format!("cannot start a thread: {error}"))?;
        Ok(Self { orders, answers, number: 0, failed: None })
    }

    /// Begins a transfer; `None` is a station that there is not.
    pub(super) fn start_transfer(&mut self, position: Option<SlavePos>, request: &SdoRequest<'_>) {
        self.number += 1;
        self.failed = None;
        let Some(position) = position else {
            self.failed = Some(TIMED_OUT);
            return;
        };
        let object = SdoIdx::new(request.index, request.sub);
        let write = request.write.map(<[u8]>::to_vec);
        let order = Order::Transfer { number: self.number, position, object, write };
        if self.orders.send(order).is_err() {
            self.failed = Some(GENERAL);
        }
    }

    /// What the transfer came to that was begun last, once.
    pub(super) fn outcome(&mut self) -> Option<Result<Vec<u8>, SdoAbort>> {
        if let Some(abort) = self.failed.take() {
            return Some(Err(abort));
        }
        loop {
            match self.answers.try_recv() {
                Ok(Done { number, outcome }) if number == self.number => return Some(outcome),
                Ok(_) => {}
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => return Some(Err(GENERAL)),
            }
        }
    }

    /// Asks for a station's state.
    pub(super) fn request(&self, position: SlavePos, state: AlState) {
        // Without the thread nothing follows, and the state says so.
        let _ = self.orders.send(Order::State { position, state });
    }
}

fn serve(mut master: Master, orders: &Receiver<Order>, answer: &Sender<Done>) {
    while let Ok(order) = orders.recv() {
        match order {
            Order::State { position, state } => {
                // What a station refuses shows in its state.
                let _ = master.request_state(position, state);
            }
            Order::Transfer { number, position, object, write } => {
                let outcome = transfer(&mut master, position, object, write.as_deref());
                if answer.send(Done { number, outcome: outcome.map_err(|error| abort(&error)) }).is_err() {
                    return;
                }
            }
        }
    }
}

fn transfer(
    master: &mut Master,
    position: SlavePos,
    object: SdoIdx,
    write: Option<&[u8]>,
) -> Result<Vec<u8>, Error> {
    if let Some(bytes) = write {
        return master.sdo_download(position, object, false, &bytes).map(|()| Vec::new());
    }
    let mut bytes = [0; MOST_BYTES];
    master.sdo_upload(position, object, false, &mut bytes).map(|read| read.to_vec())
}

fn abort(error: &Error) -> SdoAbort {
    match error {
        Error::Io(source) if source.kind() == ErrorKind::TimedOut => TIMED_OUT,
        _ => GENERAL,
    }
}
