//! Starting, watching and ending the processes of a machine.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{self, Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use tagbus_client::{ConnectOptions, Domain};

use super::client::Temper;
use super::tally::Tally;
use crate::Failure;

/// What takes longer than this hangs.
const PATIENCE: Duration = Duration::from_secs(20);

/// What a process is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Part {
    Camera,
    Detector,
    Client(Temper),
}

impl Part {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Detector => "detector",
            Self::Client(Temper::Honest) => "client",
            Self::Client(Temper::Slow) => "slow client",
            Self::Client(Temper::Stuck) => "stuck client",
            Self::Client(Temper::Misled) => "misled client",
        }
    }
}

/// A client that has ended: what it listened to, and what it counted.
pub(crate) type Ended = (Part, [String; 2], Tally);

/// One process. It is killed when it is dropped.
pub(crate) struct Member {
    pub(crate) part: Part,
    /// Camera and detector that it is, or listens to.
    pub(crate) place: [String; 2],
    child: Child,
}

impl Member {
    pub(crate) fn number(&self) -> u32 {
        self.child.id()
    }

    /// Clients end with their standard input, roles by a signal.
    fn ask_to_end(&mut self) {
        drop(self.child.stdin.take());
        let number = i32::try_from(self.number()).ok().and_then(Pid::from_raw);
        if !matches!(self.part, Part::Client(_)) {
            // That it has ended already is what is wanted.
            let _ = number.map(|number| kill_process(number, Signal::TERM));
        }
    }

    /// What it wrote, once it has ended well.
    fn last_words(&mut self) -> Result<String, Failure> {
        let (name, begun) = (self.part.name(), Instant::now());
        let status = loop {
            match self.child.try_wait()? {
                Some(status) => break status,
                None if begun.elapsed() > PATIENCE => return Err(format!("a {name} does not end").into()),
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        if !status.success() {
            return Err(format!("a {name} ended with {status}").into());
        }
        let mut words = String::new();
        if let Some(out) = &mut self.child.stdout {
            out.read_to_string(&mut words)?;
        }
        Ok(words)
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        // It may have ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// All processes of a domain of their own.
pub(crate) struct Machine {
    program: PathBuf,
    pub(crate) domain: Domain,
    pub(crate) members: Vec<Member>,
    /// A folder whose programs roles find before all others.
    pub(crate) programs: Option<PathBuf>,
}

impl Machine {
    /// An empty machine.
    pub(crate) fn new(program: &Path) -> Result<Self, Failure> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("crowd{}-{}", process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        // Short, because paths of sockets are.
        let domain = Domain::with_root(&name, std::env::temp_dir().join(&name))?;
        Ok(Self { program: program.to_owned(), domain, members: Vec::new(), programs: None })
    }

    pub(crate) fn camera(&mut self, name: &str, flags: &[String]) -> Result<(), Failure> {
        self.role(Part::Camera, [name, ""], flags)
    }

    pub(crate) fn detector(&mut self, camera: &str, name: &str, flags: &[String]) -> Result<(), Failure> {
        self.role(Part::Detector, [camera, name], flags)
    }

    fn role(&mut self, part: Part, place: [&str; 2], flags: &[String]) -> Result<(), Failure> {
        let mut command = Command::new(&self.program);
        command.arg(if part == Part::Camera { "camera" } else { "service" });
        command.args(["--camera", place[0]]).args(flags);
        if part == Part::Detector {
            command.args(["--detector", place[1]]);
        }
        if let Some(folder) = &self.programs {
            let others = std::env::var_os("PATH").unwrap_or_default();
            let folders = std::iter::once(folder.clone()).chain(std::env::split_paths(&others));
            command.env("PATH", std::env::join_paths(folders)?);
        }
        // Apart from the configuration of whoever runs this.
        command.env("XDG_CONFIG_HOME", "/nonexistent");
        self.start(command, part, place, Stdio::null())
    }

    pub(crate) fn client(&mut self, camera: &str, detector: &str, temper: Temper) -> Result<(), Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["client", "--camera", camera, "--detector", detector, "--temper"]);
        command.arg(format!("{temper:?}").to_lowercase());
        self.start(command, Part::Client(temper), [camera, detector], Stdio::piped())
    }

    fn start(
        &mut self,
        mut command: Command,
        part: Part,
        place: [&str; 2],
        out: Stdio,
    ) -> Result<(), Failure> {
        command.arg("--domain").arg(self.domain.name()).arg("--root").arg(self.domain.root());
        let child = command.stdin(Stdio::piped()).stdout(out).spawn()?;
        self.members.push(Member { part, place: place.map(str::to_owned), child });
        Ok(())
    }

    /// How to reach a detector of this machine.
    pub(crate) fn reach(&self, camera: &str, detector: &str) -> ConnectOptions {
        ConnectOptions::in_domain(self.domain.clone()).camera(camera).detector(detector).deadline(PATIENCE)
    }

    /// An error when a process has ended.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        for member in &mut self.members {
            if let Some(status) = member.child.try_wait()? {
                return Err(format!("a {} has ended ({status})", member.part.name()).into());
            }
        }
        Ok(())
    }

    /// Ends all clients, and says what each counted, in the order of [`Machine::members`]. An error when a process has ended before.
    pub(crate) fn end_clients(&mut self) -> Result<Vec<Ended>, Failure> {
        self.check()?;
        let is_client = |member: &Member| matches!(member.part, Part::Client(_));
        let (clients, others) = std::mem::take(&mut self.members).into_iter().partition(is_client);
        self.members = others;
        let mut clients: Vec<Member> = clients;
        clients.iter_mut().for_each(Member::ask_to_end);
        let mut ended = Vec::new();
        for mut member in clients {
            let words = member.last_words()?;
            let tally = Tally::read(&words).ok_or(format!("a client wrote '{words}'"))?;
            ended.push((member.part, member.place.clone(), tally));
        }
        Ok(ended)
    }

    /// Ends clients, then detectors and cameras, and says what each client counted, in the order of [`Machine::members`]. An
    /// error when one ends badly or something is left.
    pub(crate) fn end(mut self) -> Result<Vec<Ended>, Failure> {
        let tallies = self.end_clients()?;
        self.members.iter_mut().for_each(Member::ask_to_end);
        for member in &mut self.members {
            member.last_words()?;
        }
        let left = self.domain.leftovers()?;
        if !left.is_empty() || self.domain.root().exists() {
            return Err(format!("after the end of all is left in /dev/shm or the root: {left:?}").into());
        }
        Ok(tallies)
    }
}

impl Drop for Machine {
    /// A run that failed leaves nothing either.
    fn drop(&mut self) {
        self.members.clear();
        for name in self.domain.leftovers().unwrap_or_default() {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
        let _ = fs::remove_dir_all(self.domain.root());
    }
}
