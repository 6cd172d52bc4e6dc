//! What the tests share: a bus of their own, processes that end with the test, a watchdog.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{self, Child, Command, ExitStatus, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tagbus_message::domain::Domain;

/// The binary under test.
pub(crate) const TAGBUS: &str = env!("CARGO_BIN_EXE_tagbus");

/// Ends the whole test process when a test hangs; says nothing about time otherwise.
pub(crate) struct Watchdog {
    _alive: Sender<()>,
}

impl Watchdog {
    pub(crate) fn of_seconds(seconds: u64, test: &'static str) -> Self {
        let (alive, ended) = channel();
        thread::spawn(move || {
            if ended.recv_timeout(Duration::from_secs(seconds)) == Err(RecvTimeoutError::Timeout) {
                eprintln!("watchdog: {test} did not end within {seconds} s");
                process::abort();
            }
        });
        Self { _alive: alive }
    }
}

/// A folder of one test, removed at its end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        // Short, because paths of sockets are.
        let path = std::env::temp_dir().join(format!("tbt{}-{number}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// `tagbus` with these arguments, apart from the configuration of whoever runs the tests.
pub(crate) fn tagbus<I: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = I>) -> Command {
    let mut command = Command::new(TAGBUS);
    command.args(arguments).env("XDG_CONFIG_HOME", "/nonexistent").env_remove("NO_COLOR");
    command.stdin(Stdio::null());
    command
}

/// The standard output of a command that must have ended with this exit code.
pub(crate) fn printed(command: &mut Command, code: i32) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{command:?}: {}", complaints(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The standard error of a command that must have ended with this exit code.
pub(crate) fn complained(command: &mut Command, code: i32) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{command:?}: {}", complaints(&output));
    complaints(&output)
}

pub(crate) fn complaints(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Each line read as JSON.
pub(crate) fn json_lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The folder of real pictures, if there is one; loud when not.
pub(crate) fn test_data() -> Option<PathBuf> {
    let folder = std::env::var_os("TAGBUS_TEST_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("SKIPPED: TAGBUS_TEST_DATA is not set, so no real pictures were looked at");
    }
    folder
}

/// A bus of one test: its own domain, root and configuration.
pub(crate) struct Bus {
    pub(crate) domain: Domain,
    _folder: Folder,
}

impl Bus {
    pub(crate) fn new() -> Self {
        let folder = Folder::new();
        let name = folder.0.file_name().unwrap().to_str().unwrap().to_owned();
        let domain = Domain::with_root(&name, folder.file("bus")).unwrap();
        Self { domain, _folder: folder }
    }

    /// A subcommand on this bus.
    pub(crate) fn command(&self, subcommand: &str, arguments: &[&str]) -> Command {
        let mut command = tagbus([subcommand]);
        command.arg("--domain").arg(self.domain.name()).arg("--root").arg(self.domain.root());
        command.args(arguments);
        command
    }

    /// A running process on this bus.
    pub(crate) fn start(&self, subcommand: &str, arguments: &[&str]) -> Running {
        Running::start(self.command(subcommand, arguments))
    }

    /// Living processes that have this domain on their command line.
    pub(crate) fn processes(&self) -> Vec<i32> {
        let numbers = fs::read_dir("/proc").unwrap().filter_map(Result::ok);
        let numbers = numbers.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
        numbers.filter(|&number| self.is_named_by(number)).collect()
    }

    fn is_named_by(&self, process: i32) -> bool {
        // A process that has ended, or is only waited for, has no command line.
        let line = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).into_owned();
        line.split('\0').any(|word| word.trim_start_matches("--domain=") == self.domain.name())
    }

    /// Waits until no process, nothing in shared memory and nothing in the root is left of this bus.
    pub(crate) fn wait_until_gone(&self) {
        let gone = || {
            self.processes().is_empty()
                && self.domain.leftovers().unwrap().is_empty()
                && !self.domain.root().exists()
        };
        let started = Instant::now();
        while !gone() {
            assert!(
                started.elapsed() < Duration::from_secs(20),
                "left: processes {:?}, shared memory {:?}, root {:?}",
                self.processes(),
                self.domain.leftovers(),
                fs::read_dir(self.domain.root()).map(|entries| entries.flatten().collect::<Vec<_>>())
            );
            thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Bus {
    /// A test that failed must not leave anything either.
    fn drop(&mut self) {
        for process in self.processes() {
            let _ = Pid::from_raw(process).map(|pid| kill_process(pid, Signal::KILL));
        }
        for name in self.domain.leftovers().unwrap_or_default() {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
    }
}

/// A running process, killed with its owner. Its lines are read all the time, so that it never waits for us.
pub(crate) struct Running {
    child: Child,
    pub(crate) lines: Receiver<String>,
    pub(crate) complaints: Receiver<String>,
}

impl Running {
    pub(crate) fn start(mut command: Command) -> Self {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let lines = lines_of(child.stdout.take().unwrap());
        let complaints = lines_of(child.stderr.take().unwrap());
        Self { child, lines, complaints }
    }

    /// The next line of the standard output.
    pub(crate) fn line(&self) -> String {
        self.lines.recv().unwrap_or_else(|_| panic!("the process has ended: {:?}", self.all_complaints()))
    }

    /// The next line of the standard output, as JSON.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.line()).unwrap()
    }

    /// Waits for a line of the standard error with this text.
    pub(crate) fn wait_for_complaint(&self, text: &str) {
        let mut seen = Vec::new();
        for line in &self.complaints {
            if line.contains(text) {
                return;
            }
            seen.push(line);
        }
        panic!("the process has ended without saying {text:?}: {seen:?}");
    }

    pub(crate) fn all_complaints(&self) -> String {
        self.complaints.try_iter().collect::<Vec<_>>().join("\n")
    }

    pub(crate) fn send(&self, signal: Signal) {
        let pid = Pid::from_raw(self.child.id() as i32).unwrap();
        kill_process(pid, signal).unwrap();
    }

    /// The number of the process.
    pub(crate) fn number(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn is_alive(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub(crate) fn wait(&mut self) -> ExitStatus {
        self.child.wait().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn lines_of(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}
