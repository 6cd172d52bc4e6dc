//! A terminal of 80 columns and 24 rows in front of the binary.

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

const ROWS: u16 = 24;
const COLUMNS: u16 = 80;
/// Longer than anything that is waited for takes, even on a machine with much other work.
const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) struct Terminal {
    screen: Arc<Mutex<vt100::Parser>>,
    keyboard: File,
    /// Held, so that the terminal's modes can be asked for when the process has ended.
    line: File,
    child: Child,
}

impl Terminal {
    /// A command in a terminal, which becomes its controlling one, as from a shell.
    pub(crate) fn start(command: &Command) -> Self {
        let keyboard = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&keyboard).unwrap();
        unlockpt(&keyboard).unwrap();
        tcsetwinsize(&keyboard, Winsize { ws_row: ROWS, ws_col: COLUMNS, ws_xpixel: 0, ws_ypixel: 0 })
            .unwrap();
        let path = ptsname(&keyboard, Vec::new()).unwrap().into_string().unwrap();
        let line = File::options().read(true).write(true).open(path).unwrap();
        let end = || Stdio::from(line.try_clone().unwrap());
        let mut in_terminal = Command::new("setsid");
        in_terminal.arg("--ctty").arg(command.get_program()).args(command.get_args());
        in_terminal.env("XDG_CONFIG_HOME", "/nonexistent").env("TERM", "xterm").env_remove("NO_COLOR");
        let child = in_terminal.stdin(end()).stdout(end()).stderr(end()).spawn().unwrap();
        let screen = Arc::new(Mutex::new(vt100::Parser::new(
            NonZero::new(ROWS).unwrap(),
            NonZero::new(COLUMNS).unwrap(),
            0,
        )));
        let keyboard = File::from(keyboard);
        let (mut output, shown) = (keyboard.try_clone().unwrap(), Arc::clone(&screen));
        thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut bytes) {
                shown.lock().unwrap().process(&bytes[..count]);
            }
        });
        Self { screen, keyboard, line, child }
    }

    /// The rows that are on the screen.
    pub(crate) fn rows(&self) -> Vec<String> {
        self.screen.lock().unwrap().screen().rows(0, COLUMNS).collect()
    }

    /// Waits until a screen has it, and says how long that took. What is on the screen is said when it never comes.
    pub(crate) fn wait_until(&self, what: &str, has: impl Fn(&[String]) -> bool) -> Duration {
        let started = Instant::now();
        while !has(&self.rows()) {
            assert!(started.elapsed() < PATIENCE, "no {what} on the screen:\n{}", self.rows().join("\n"));
            thread::sleep(Duration::from_millis(10));
        }
        started.elapsed()
    }

    /// Waits for a row with this text.
    pub(crate) fn wait_for(&self, text: &str) -> Duration {
        self.wait_until(text, |rows| rows.iter().any(|row| row.contains(text)))
    }

    pub(crate) fn press(&mut self, keys: &[u8]) {
        self.keyboard.write_all(keys).unwrap();
    }

    /// Waits for the end of the process and says how it ended. The terminal must be as it was before.
    pub(crate) fn end(mut self) -> ExitStatus {
        let status = self.child.wait().unwrap();
        let modes = tcgetattr(&self.line).unwrap().local_modes;
        assert!(modes.contains(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG), "{modes:?}");
        // What was written last may not be read yet.
        self.wait_until("cursor", |_| {
            let screen = self.screen.lock().unwrap();
            !screen.screen().alternate_screen() && !screen.screen().hide_cursor()
        });
        status
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
