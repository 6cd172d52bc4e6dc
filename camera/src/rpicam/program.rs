//! The program as a child process.

use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crate::config::SourceOptions;
use crate::format::FrameShape;
use crate::readiness::Readiness;

/// What the program is called today, and what it was called before 2023.
const NAMES: [&str; 2] = ["rpicam-vid", "libcamera-vid"];

/// Room in the pipe: a frame of 800x600 fits, so that the program seldom waits and the camera seldom wakes for a part of one.
const PIPE_BYTES: usize = 1 << 20;

/// Waiting for the last words of a program that has ended.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// The program that is to be started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Program {
    path: PathBuf,
    arguments: Vec<OsString>,
}

impl Program {
    /// The named program, or the first of the usual ones that is installed.
    pub(super) fn find(named: Option<&Path>, options: &SourceOptions, shape: FrameShape) -> Option<Program> {
        let path = match named {
            Some(path) => path.is_file().then(|| path.to_path_buf()),
            None => {
                let folders = std::env::var_os("PATH").unwrap_or_default();
                let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
                let places =
                    NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
                places.into_iter().find(|place| place.is_file())
            }
        };
        path.map(|path| Program { path, arguments: arguments(options, shape) })
    }

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Starts it.
    pub(super) fn start(&self) -> io::Result<Running> {
        let mut command = Command::new(&self.path);
        command.args(&self.arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let (Some(pipe), Some(errors)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(io::Error::other("a child process without pipes"));
        };
        let last_words = Arc::new(Mutex::new(String::new()));
        let silence = listen(errors, Arc::clone(&last_words));
        let flags = rustix::fs::fcntl_getfl(&pipe)?;
        rustix::fs::fcntl_setfl(&pipe, flags | rustix::fs::OFlags::NONBLOCK)?;
        // Above the limit of an ordinary user the pipe stays as it is, which costs wake-ups only.
        let _ = rustix::pipe::fcntl_setpipe_size(&pipe, PIPE_BYTES);
        Ok(Running { pipe, child, last_words, silence })
    }
}

/// Everything that the program is told: endless raw video of this size on its standard output, and the user's own options.
fn arguments(options: &SourceOptions, shape: FrameShape) -> Vec<OsString> {
    let mut arguments: Vec<OsString> =
        ["--codec", "yuv420", "--output", "-", "--timeout", "0", "--nopreview", "--flush"]
            .map(OsString::from)
            .into();
    let mut add = |name: &str, value: String| arguments.extend([format!("--{name}").into(), value.into()]);
    add("width", shape.width().to_string());
    add("height", shape.height().to_string());
    if let Some(framerate) = options.pace.framerate() {
        add("framerate", framerate.to_string());
    }
    for control in &options.controls.0 {
        // Its options have hyphens where names of controls have low lines.
        add(&control.name.replace('_', "-"), control.value.clone());
    }
    arguments
}

/// Keeps the last line that the program writes to its standard error, until that is closed; then the answer's sender goes.
fn listen(errors: ChildStderr, last_words: Arc<Mutex<String>>) -> Receiver<()> {
    let (open, silence) = channel();
    thread::spawn(move || {
        let _open = open;
        for line in BufReader::new(errors).split(b'\n') {
            let Ok(line) = line else { break };
            let line = String::from_utf8_lossy(&line).trim().to_string();
            if !line.is_empty() {
                *last_words.lock().unwrap_or_else(PoisonError::into_inner) = line;
            }
        }
    });
    silence
}

/// The program at work. Dropped, it is ended.
#[derive(Debug)]
pub(super) struct Running {
    pipe: ChildStdout,
    child: Child,
    last_words: Arc<Mutex<String>>,
    /// Disconnected when the program's standard error is closed and read to its end.
    silence: Receiver<()>,
}

impl Running {
    /// Its number in the system.
    pub(super) fn process(&self) -> u32 {
        self.child.id()
    }

    /// What wakes a wait set when it has written something, or has ended.
    pub(super) fn readiness(&self) -> io::Result<Readiness> {
        Readiness::of(&self.pipe)
    }

    /// How it ended, and the last thing that it said.
    pub(super) fn obituary(&mut self) -> String {
        let how = match self.child.wait() {
            Ok(status) => format!("it ended ({status})"),
            Err(error) => format!("it ended ({error})"),
        };
        // What it said last may still be on its way. Children of its own could hold that open for ever.
        let _ = self.silence.recv_timeout(LAST_WORDS);
        match self.last_words.lock().unwrap_or_else(PoisonError::into_inner).as_str() {
            "" => how,
            words => format!("{how}; its last words: {words}"),
        }
    }
}

impl Read for Running {
    /// Takes what has been written, without waiting for more.
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.pipe.read(into)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A program that has ended already is only taken note of.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Pace;

    #[test]
    fn size_rate_and_the_users_options_are_passed_on() {
        let options = SourceOptions {
            pace: Pace::Framerate(56.5),
            controls: "shutter=5000,gain=4,denoise=cdn_off".parse().unwrap(),
            ..SourceOptions::default()
        };
        let words = arguments(&options, FrameShape::grey(640, 480).unwrap());
        let words: Vec<_> = words.iter().map(|word| word.to_str().unwrap()).collect();
        let text = words.join(" ");
        assert!(text.starts_with("--codec yuv420 --output - --timeout 0"), "{text}");
        assert!(
            text.ends_with(
                "--width 640 --height 480 --framerate 56.5 --shutter 5000 --gain 4 --denoise cdn_off"
            ),
            "{text}"
        );
    }

    #[test]
    fn a_program_that_is_not_there_is_not_found() {
        let shape = FrameShape::grey(640, 480).unwrap();
        let options = SourceOptions::default();
        assert_eq!(Program::find(Some(Path::new("/no/such/program")), &options, shape), None);
        assert!(Program::find(Some(Path::new("/bin/sh")), &options, shape).is_some());
    }
}
