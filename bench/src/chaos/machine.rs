//! A whole machine: a supervisor with camera and detector, and clients beside it, each its own process.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{self, Command};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use tagbus_message::domain::Domain;

use super::arrivals::{Arrivals, Wanted};
use super::process::{Complaints, Found, Process, child_of, signal, with_word};
use super::storage::{Storage, list};
use crate::Failure;

/// Longer than any recovery may take: what takes longer hangs.
pub(super) const PATIENCE: Duration = Duration::from_secs(20);
/// Frames of the built-in scene.
const SCENE: [&str; 3] = ["--width=320", "--height=240", "--framerate=200"];

/// Who is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Camera,
    Service,
    Client,
    Supervisor,
}

impl Role {
    pub(super) const ALL: [Self; 4] = [Self::Camera, Self::Service, Self::Client, Self::Supervisor];

    /// The subcommand of `tagbus`.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Service => "service",
            Self::Client => "watch",
            Self::Supervisor => "run",
        }
    }
}

/// The running machine. What is left of it goes with it.
pub(super) struct Machine {
    program: PathBuf,
    domain: Domain,
    pub(super) arrivals: Arrivals,
    complaints: Complaints,
    supervisor: Process,
    clients: Vec<Process>,
}

impl Machine {
    /// Starts all processes and waits until detections arrive at every client.
    pub(super) fn start(program: &Path, clients: usize) -> Result<Self, Failure> {
        let name = format!("chaos{}", process::id());
        // Short, because paths of sockets are.
        let domain = Domain::with_root(&name, std::env::temp_dir().join(&name))?;
        if Storage::of(&domain) != Storage::default() {
            return Err(format!("domain {name} is in use: {}", Storage::of(&domain)).into());
        }
        let (arrivals, complaints) = (Arrivals::default(), Complaints::default());
        let supervisor = start_supervisor(program, &domain, &complaints)?;
        let program = program.to_owned();
        let mut machine = Self { program, domain, arrivals, complaints, supervisor, clients: Vec::new() };
        for number in 0..clients {
            let client = machine.new_client(number)?;
            machine.clients.push(client);
        }
        machine.wait(Wanted::default())?;
        Ok(machine)
    }

    fn new_client(&self, number: usize) -> Result<Process, Failure> {
        let arrivals = self.arrivals.clone();
        let mut command = command(&self.program, &self.domain, Role::Client);
        command.arg("--json");
        let take = move |process: u32, line: &str| arrivals.take(number, process, line);
        Ok(Process::start(command, &self.complaints, take)?)
    }

    /// How many clients there are.
    pub(super) fn clients(&self) -> usize {
        self.clients.len()
    }

    /// The camera or detector, when it runs.
    pub(super) fn find(&self, role: Role) -> Option<Found> {
        child_of(self.supervisor.number(), role)
    }

    /// Waits until the supervisor has started another one than `before`.
    pub(super) fn wait_for_another(&mut self, role: Role, before: Option<Found>) -> Result<Found, Failure> {
        let started = Instant::now();
        loop {
            match self.find(role) {
                Some(found) if Some(found) != before => return Ok(found),
                _ if started.elapsed() > PATIENCE => {
                    return Err(self.wrong(&format!("no {} was started again", role.name())));
                }
                _ => thread::sleep(Duration::from_millis(2)),
            }
            self.check_survivors()?;
        }
    }

    pub(super) fn kill_client(&mut self, number: usize) -> Result<(), Failure> {
        Ok(self.clients[number].kill()?)
    }

    /// Starts the client again; `CLOCK_BOOTTIME` of that, nanoseconds.
    pub(super) fn restart_client(&mut self, number: usize) -> Result<u64, Failure> {
        self.clients[number] = self.new_client(number)?;
        Ok(self.clients[number].started_ns)
    }

    pub(super) fn kill_supervisor(&mut self) -> Result<(), Failure> {
        Ok(self.supervisor.kill()?)
    }

    /// Starts the supervisor again; `CLOCK_BOOTTIME` of that, nanoseconds.
    pub(super) fn restart_supervisor(&mut self) -> Result<u64, Failure> {
        self.supervisor = start_supervisor(&self.program, &self.domain, &self.complaints)?;
        Ok(self.supervisor.started_ns)
    }

    /// When the first wanted detection arrived at each client (`CLOCK_BOOTTIME`, nanoseconds).
    pub(super) fn wait(&mut self, wanted: Wanted) -> Result<Vec<u64>, Failure> {
        let processes: Vec<u32> = self.clients.iter().map(Process::number).collect();
        let started = Instant::now();
        loop {
            // In short steps, so that the end of a process is not taken for a hang.
            match self.arrivals.wait(wanted, &processes, Duration::from_millis(200)) {
                Ok(times) => return Ok(times),
                Err(error) if started.elapsed() > PATIENCE => return Err(self.wrong(&error)),
                Err(_) => self.check_survivors()?,
            }
        }
    }

    /// Nobody ended who was not killed, and nobody panicked.
    pub(super) fn check_survivors(&mut self) -> Result<(), Failure> {
        if let Some(status) = self.supervisor.ended()? {
            return Err(self.wrong(&format!("the supervisor ended ({status})")));
        }
        for number in 0..self.clients.len() {
            if let Some(status) = self.clients[number].ended()? {
                return Err(self.wrong(&format!("client {number} ended ({status})")));
            }
        }
        let lines = self.complaints.all();
        match lines.iter().find(|line| is_bad(line)) {
            Some(line) => Err(self.wrong(line)),
            None => Ok(()),
        }
    }

    /// Waits until `fine` holds of what is stored.
    pub(super) fn wait_for_storage(
        &self,
        what: &str,
        fine: impl Fn(&Storage) -> bool,
    ) -> Result<Storage, Failure> {
        let started = Instant::now();
        loop {
            let now = Storage::of(&self.domain);
            if fine(&now) {
                return Ok(now);
            }
            if started.elapsed() > PATIENCE {
                return Err(self.wrong(&format!("{what}: {now}\n{}", list(&self.domain))));
            }
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// A further client comes and goes: nobody looks for the dead by himself, and the last victim may have died after everybody
    /// else had come.
    pub(super) fn visit(&self) -> Result<(), Failure> {
        let mut command = command(&self.program, &self.domain, Role::Client);
        command.args(["--json", "--frames=1"]);
        let mut visitor = Process::start(command, &self.complaints, |_, _| ())?;
        let started = Instant::now();
        while visitor.ended()?.is_none() {
            if started.elapsed() > PATIENCE {
                visitor.kill()?;
                return Err(self.wrong("a further client gets nothing"));
            }
            thread::sleep(Duration::from_millis(2));
        }
        Ok(())
    }

    /// Detections go on at every client.
    pub(super) fn wait_for_more(&self) -> Result<(), Failure> {
        self.arrivals.wait_for_more(self.clients.len(), PATIENCE).map_err(|error| self.wrong(&error))
    }

    /// Ends all in good order and waits until nothing is left.
    pub(super) fn end(mut self) -> Result<Vec<String>, Failure> {
        self.check_survivors()?;
        let mut ends = Vec::new();
        for process in self.clients.iter_mut().chain([&mut self.supervisor]) {
            ends.push(process.end(PATIENCE)?);
        }
        if let Some(end) = ends.iter().find(|end| !end.is_some_and(|status| status.success())) {
            return Err(self.wrong(&format!("the end was not in good order: {end:?}")));
        }
        let gone = |storage: &Storage| *storage == Storage::default();
        self.wait_for_storage("something is left after the end", gone)?;
        let left = with_word(self.domain.name());
        if !left.is_empty() {
            return Err(self.wrong(&format!("processes are left after the end: {left:?}")));
        }
        Ok(self.complaints.all())
    }

    fn wrong(&self, what: &str) -> Failure {
        format!("{what}\n---- last words on the standard error:\n{}", self.complaints.last()).into()
    }
}

impl Drop for Machine {
    /// A run that failed leaves nothing either.
    fn drop(&mut self) {
        let _ = self.supervisor.kill();
        self.clients.iter_mut().for_each(|client| drop(client.kill()));
        for process in with_word(self.domain.name()) {
            signal(process, Signal::KILL);
        }
        for name in self.domain.leftovers().unwrap_or_default() {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
        let _ = fs::remove_dir_all(self.domain.root());
    }
}

/// A panic, or what the supervisor says of a role that ended in another way than by our kill.
fn is_bad(line: &str) -> bool {
    line.contains("panicked") || (line.contains(" ended (") && !line.contains(" ended (signal: 9 "))
}

/// The supervisor prints what its own client sees; that is read and dropped.
fn start_supervisor(program: &Path, domain: &Domain, complaints: &Complaints) -> Result<Process, Failure> {
    let mut command = command(program, domain, Role::Supervisor);
    command.arg("--json").args(SCENE);
    Ok(Process::start(command, complaints, |_, _| ())?)
}

/// Apart from the configuration of whoever runs this.
fn command(program: &Path, domain: &Domain, role: Role) -> Command {
    let mut command = Command::new(program);
    command.arg(role.name()).arg("--domain").arg(domain.name()).arg("--root").arg(domain.root());
    command.env("XDG_CONFIG_HOME", "/nonexistent");
    command
}
