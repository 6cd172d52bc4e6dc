//! The sender's side of each way, and its receivers as processes.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{self, Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::net::sockopt;
use rustix::pipe::fcntl_setpipe_size;
use tagbus_message::Local;
use tagbus_message::bus::Bus;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::domain::Domain;
use tagbus_message::frame::{FrameHeader, GREY};
use tagbus_message::ports::FramesOut;
use tagbus_message::qos::{FRAMES, TopicQos};
use tagbus_message::stop::Stop;

use super::copied::{BYTES, END, Label, WARM_UP};
use super::receiver::{CAMERA, Notes, READY};
use super::way::Way;
use super::zeromq::Publisher;
use crate::Failure;

/// What is asked of sockets, so that a whole frame fits.
const SOCKET_BYTES: usize = 4 << 20;
/// What is asked of pipes: the most that the system gives to everybody.
const PIPE_BYTES: usize = 1 << 20;
/// ZeroMQ tells nobody when its subscribers are there.
const SUBSCRIBING: Duration = Duration::from_millis(300);
/// ... and may drop the last message as any other.
const LAST_WORDS: usize = 20;
/// What takes longer than this hangs.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is sent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub(super) size: [u32; 2],
    /// Frames that count.
    pub(super) frames: u64,
    /// From frame to frame.
    pub(super) period: Duration,
}

impl Load {
    pub(super) fn bytes(&self) -> usize {
        self.size.iter().product::<u32>() as usize
    }
}

/// What became of one line of one round.
pub(super) struct Sent {
    /// Of each receiver.
    pub(super) notes: Vec<Notes>,
    /// CPU time of the sender, microseconds for all frames that count.
    pub(super) cpu_us: f64,
}

/// Sends frames one way to so many receivers, each in a process of its own.
pub(super) fn send(way: Way, receivers: usize, load: &Load) -> Result<Sent, Failure> {
    let ground = Ground::new()?;
    let mut link = Link::open(way, receivers, load, &ground)?;
    let mut children = Vec::new();
    for _ in 0..receivers {
        children.push(link.receiver(way, load, &ground)?);
    }
    for child in &mut children {
        child.wait_until_ready()?;
    }
    link.settle(receivers)?;
    let cpu_us = link.send_all(load)?;
    let notes = children.into_iter().map(Receiver::end).collect::<Result<_, _>>()?;
    drop(link);
    ground.check()?;
    Ok(Sent { notes, cpu_us })
}

/// A domain of its own, and a folder for sockets.
struct Ground {
    domain: Domain,
    folder: PathBuf,
}

impl Ground {
    fn new() -> Result<Self, Failure> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("lat{}-{}", process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        // Short, because paths of sockets are.
        let folder = std::env::temp_dir().join(&name);
        fs::create_dir_all(&folder)?;
        Ok(Self { domain: Domain::with_root(&name, folder.join("bus"))?, folder })
    }

    fn address(&self) -> String {
        format!("ipc://{}", self.folder.join("z").display())
    }

    fn check(&self) -> Result<(), Failure> {
        let left = self.domain.leftovers()?;
        if left.is_empty() { Ok(()) } else { Err(format!("left in /dev/shm: {left:?}").into()) }
    }
}

impl Drop for Ground {
    /// A run that failed leaves nothing either.
    fn drop(&mut self) {
        for name in self.domain.leftovers().unwrap_or_default() {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A receiver. It is killed when it is dropped before its end.
struct Receiver {
    child: Child,
    out: BufReader<ChildStdout>,
}

impl Receiver {
    fn start(mut command: Command) -> Result<Self, Failure> {
        let mut child = command.stdout(Stdio::piped()).spawn()?;
        let out = child.stdout.take().ok_or("a receiver without standard output")?;
        Ok(Self { child, out: BufReader::new(out) })
    }

    fn wait_until_ready(&mut self) -> Result<(), Failure> {
        let mut line = String::new();
        self.out.read_line(&mut line)?;
        if line.trim_end() == READY { Ok(()) } else { Err("a receiver does not begin".into()) }
    }

    fn end(mut self) -> Result<Notes, Failure> {
        let mut text = String::new();
        self.out.read_to_string(&mut text)?;
        let status = self.child.wait()?;
        if !status.success() {
            return Err(format!("a receiver ended with {status}").into());
        }
        Notes::parse(&text).ok_or_else(|| "a receiver wrote something else than figures".into())
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        // It may have ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The sender's end.
enum Link {
    Bus { out: Box<FramesOut<Local>>, wakes: bool, picture: Vec<u8> },
    Copies { outs: Vec<File>, frame: Vec<u8> },
    Zeromq { publisher: Publisher, frame: Vec<u8> },
}

impl Link {
    fn open(way: Way, receivers: usize, load: &Load, ground: &Ground) -> Result<Self, Failure> {
        // Every byte written, so that no page is the system's one of zeros.
        let frame = vec![0x5a; BYTES + load.bytes()];
        if way.is_piped() {
            return Ok(Self::Copies { outs: Vec::new(), frame });
        }
        if way == Way::Zeromq {
            return Ok(Self::Zeromq { publisher: Publisher::bind(&ground.address())?, frame });
        }
        let bus = Bus::start(&ground.domain, "camera cam0", &Stop::new()?)?;
        let qos = TopicQos { subscribers: receivers.max(FRAMES.subscribers), ..FRAMES };
        let out = bus.create_frames(CAMERA, &qos, load.bytes())?;
        Ok(Self::Bus { out: Box::new(out), wakes: way != Way::Polling, picture: frame[BYTES..].to_vec() })
    }

    /// Starts a receiver and connects it.
    fn receiver(&mut self, way: Way, load: &Load, ground: &Ground) -> Result<Receiver, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        let name = clap::ValueEnum::to_possible_value(&way).ok_or("a way without a name")?;
        command.args(["latency-receiver", "--way", name.get_name()]);
        command.args(["--bytes", &load.bytes().to_string(), "--address", &ground.address()]);
        command.args(["--domain", ground.domain.name()]).arg("--root").arg(ground.domain.root());
        command.stdin(Stdio::null());
        match (self, way) {
            (Self::Copies { outs, .. }, Way::Unix) => {
                let (ours, theirs) = UnixStream::pair()?;
                enlarge(&ours)?;
                command.stdin(Stdio::from(OwnedFd::from(theirs)));
                outs.push(File::from(OwnedFd::from(ours)));
                Receiver::start(command)
            }
            (Self::Copies { outs, .. }, _) => {
                let (theirs, ours) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
                fcntl_setpipe_size(&ours, PIPE_BYTES)?;
                command.stdin(Stdio::from(theirs));
                outs.push(File::from(ours));
                Receiver::start(command)
            }
            _ => Receiver::start(command),
        }
    }

    /// Waits until all receivers are connected.
    fn settle(&self, receivers: usize) -> Result<(), Failure> {
        match self {
            Self::Bus { out, .. } => {
                let begun = Instant::now();
                while out.subscribers() < receivers {
                    if begun.elapsed() > PATIENCE {
                        return Err("receivers do not come".into());
                    }
                    thread::sleep(Duration::from_millis(1));
                }
            }
            Self::Copies { .. } => {}
            Self::Zeromq { .. } => thread::sleep(SUBSCRIBING),
        }
        Ok(())
    }

    /// Says how much CPU time sending took, after the warm-up.
    fn send_all(&mut self, load: &Load) -> Result<f64, Failure> {
        let (mut next, mut cpu_us) = (Instant::now(), 0.0);
        for sequence in 0..WARM_UP + load.frames {
            if sequence == WARM_UP {
                cpu_us = crate::clock::now_us();
            }
            next += load.period;
            thread::sleep(next.saturating_duration_since(Instant::now()));
            self.send_one(sequence, load)?;
        }
        let cpu_us = crate::clock::now_us() - cpu_us;
        let last_words = if matches!(self, Self::Zeromq { .. }) { LAST_WORDS } else { 1 };
        for _ in 0..last_words {
            thread::sleep(load.period.max(Duration::from_millis(20)));
            self.send_one(END, load)?;
        }
        Ok(cpu_us)
    }

    fn send_one(&mut self, sequence: u64, load: &Load) -> Result<(), Failure> {
        let written_ns = monotonic_ns();
        match self {
            Self::Bus { out, wakes, picture } => publish(out, *wakes, picture, sequence, load),
            Self::Copies { outs, frame } => {
                Label { sequence, written_ns, sent_ns: written_ns }.write(frame);
                for out in outs {
                    out.write_all(frame)?;
                }
                Ok(())
            }
            Self::Zeromq { publisher, frame } => {
                Label { sequence, written_ns, sent_ns: written_ns }.write(frame);
                publisher.send(frame)
            }
        }
    }
}

/// As a camera does: loan, write, header, send, notify.
fn publish(
    out: &FramesOut<Local>,
    wakes: bool,
    picture: &[u8],
    sequence: u64,
    load: &Load,
) -> Result<(), Failure> {
    let dequeue_ns = monotonic_ns();
    let loan = out.publisher().loan_slice_uninit(picture.len());
    let loan = loan.map_err(|error| format!("no memory for a frame ({error:?})"))?;
    let mut loan = loan.write_from_slice(picture);
    let header = FrameHeader::packed(GREY, load.size[0], load.size[1])?;
    *loan.user_header_mut() = FrameHeader { sequence, dequeue_ns, publish_ns: monotonic_ns(), ..header };
    loan.send().map_err(|error| format!("a frame could not be sent ({error:?})"))?;
    if wakes {
        out.notify().map_err(|error| format!("nobody could be woken ({error:?})"))?;
    }
    Ok(())
}

/// A whole frame fits into the socket where the system allows it.
fn enlarge(socket: &UnixStream) -> Result<(), Failure> {
    // Beyond the system's limit only root may go.
    if sockopt::set_socket_send_buffer_size_force(socket, SOCKET_BYTES).is_err() {
        sockopt::set_socket_send_buffer_size(socket, SOCKET_BYTES)?;
    }
    Ok(())
}
