//! The control socket of `bench sim`: a Unix socket in a folder of the user's own, mode 0600, that takes orders from the same
//! user or from root, and from nobody else.

use std::fs;
use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::Duration;

use crate::site::order::{self, Answer, Order};

/// Longest order: a case with a long stimulus.
const LONGEST: u64 = 4 << 20;
/// How long a client may take to write its order or to take the answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// How long a simulator that ends waits for a client to have its answer.
const LAST_PATIENCE: Duration = Duration::from_millis(500);

/// An order on its way to the simulator, and where the answer goes.
pub(super) struct Asked {
    pub(super) order: Order,
    answer: Sender<Answer>,
    /// Closed when the client has the answer, or has gone.
    told: Receiver<()>,
}

impl Asked {
    /// Answers; whoever asked may have gone.
    pub(super) fn answer(&self, answer: Answer) {
        let _ = self.answer.send(answer);
    }

    /// Waits until the client has the answer, for a program that is about to end.
    pub(super) fn wait_until_told(&self) {
        let _ = self.told.recv_timeout(LAST_PATIENCE);
    }
}

/// A socket that listens. It is removed when this is dropped.
pub(super) struct Control {
    path: PathBuf,
    orders: Receiver<Asked>,
}

impl Control {
    /// Listens at a path.
    ///
    /// # Errors
    /// When a living simulator listens there, or the socket cannot be made.
    pub(super) fn listen(path: &Path) -> io::Result<Self> {
        if UnixStream::connect(path).is_ok() {
            let why = "another simulator listens there; stop it with `bench sim --tell '\"stop\"'`";
            return Err(io::Error::new(ErrorKind::AddrInUse, why));
        }
        if let Ok(found) = fs::symlink_metadata(path) {
            if !found.file_type().is_socket() {
                let why = "it exists and is no socket; name another path";
                return Err(io::Error::new(ErrorKind::AlreadyExists, why));
            }
            fs::remove_file(path)?;
        }
        let listener = UnixListener::bind(path)?;
        fs::set_permissions(path, fs::Permissions::from_mode(0o600))?;
        let (sender, orders) = mpsc::channel();
        let serve = move || {
            for stream in listener.incoming().flatten() {
                let sender = sender.clone();
                // A client that dawdles holds up itself alone.
                let talk = move || {
                    let _ = converse(&stream, &sender);
                };
                let _ = std::thread::Builder::new().name("control client".to_owned()).spawn(talk);
            }
        };
        std::thread::Builder::new().name("control".to_owned()).spawn(serve)?;
        Ok(Self { path: path.to_owned(), orders })
    }

    /// The next order, if there is one. Never waits.
    pub(super) fn next(&self) -> Option<Asked> {
        self.orders.try_recv().ok()
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// One client, one order a line until it hangs up.
fn converse(stream: &UnixStream, orders: &Sender<Asked>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let peer = rustix::net::sockopt::socket_peercred(stream)?;
    let own = rustix::process::geteuid();
    if peer.uid != own && !peer.uid.is_root() {
        let refused = Answer::Refused(format!("only user {} and root may give orders", own.as_raw()));
        return answer(stream, &refused);
    }
    let mut lines = BufReader::new(io::Read::take(stream, LONGEST)).lines();
    while let Some(line) = lines.next().transpose()? {
        let (open, told) = mpsc::channel();
        let given = match order::read(&line) {
            Err(why) => Answer::Refused(why),
            Ok(order) => ask(order, orders, told),
        };
        answer(stream, &given)?;
        drop(open);
    }
    Ok(())
}

fn ask(order: Order, orders: &Sender<Asked>, told: Receiver<()>) -> Answer {
    let (answer, given) = mpsc::channel();
    let is_sent = orders.send(Asked { order, answer, told }).is_ok();
    let ends = || Answer::Refused("the simulator ends".to_owned());
    if is_sent { given.recv_timeout(PATIENCE).unwrap_or_else(|_| ends()) } else { ends() }
}

fn answer(mut stream: &UnixStream, answer: &Answer) -> io::Result<()> {
    let mut line = serde_json::to_string(answer).map_err(io::Error::other)?;
    line.push('\n');
    stream.write_all(line.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::tell;

    /// A simulator that answers every order with its name.
    fn serve_one(control: Control) -> std::thread::JoinHandle<Order> {
        std::thread::spawn(move || {
            loop {
                if let Some(asked) = control.next() {
                    asked.answer(Answer::Done("seen".to_owned()));
                    asked.wait_until_told();
                    return asked.order;
                }
                crate::clock::nap();
            }
        })
    }

    #[test]
    fn an_order_of_the_same_user_arrives_and_is_answered() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sim.sock");
        let control = Control::listen(&path).expect("listens");
        let mode = fs::metadata(&path).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let serving = serve_one(control);
        assert_eq!(tell(&path, &Order::Status).expect("answered"), Answer::Done("seen".to_owned()));
        assert_eq!(serving.join().expect("served"), Order::Status);
        assert!(!path.exists(), "a simulator that ends takes its socket along");
    }

    #[test]
    fn a_file_that_is_no_socket_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rig.toml");
        fs::write(&path, "schema = 1").expect("written");
        let error = Control::listen(&path).err().expect("refused");
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&path).expect("still there"), "schema = 1");
    }

    #[test]
    fn nonsense_is_refused_and_reaches_nobody() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sim.sock");
        let control = Control::listen(&path).expect("listens");
        let mut stream = UnixStream::connect(&path).expect("connects");
        stream.write_all(b"nonsense\n").expect("sent");
        let mut told = String::new();
        BufReader::new(&stream).read_line(&mut told).expect("answered");
        assert!(told.contains("refused") && told.contains("an order is"), "{told}");
        assert!(control.next().is_none());
    }

    #[test]
    fn a_socket_that_was_left_behind_is_taken_over_and_a_living_one_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sim.sock");
        drop(UnixListener::bind(&path).expect("left behind"));
        let _control = Control::listen(&path).expect("taken over");
        let error = Control::listen(&path).err().expect("taken");
        assert_eq!(error.kind(), ErrorKind::AddrInUse);
    }
}
