//! The least that waking another process takes on this machine: two processes that do nothing but wake each other.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::process::{self, Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{FileName, SemanticString};
use iceoryx2_bb_posix::creation_mode::CreationMode;
use iceoryx2_bb_posix::permission::Permission;
use iceoryx2_bb_posix::semaphore::{NamedSemaphore, NamedSemaphoreBuilder, SemaphoreInterface};
use rustix::event::{EventfdFlags, eventfd};
use tagbus_message::clock::monotonic_ns;

use crate::Failure;

/// Wakes at the start that count for nothing.
const WARM_UP: usize = 100;

/// What one process wakes another by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Bell {
    /// A number in the kernel that is read and written like a file.
    Eventfd,
    /// A POSIX semaphore in shared memory, whose sleepers are the kernel's futex.
    Futex,
}

impl Bell {
    pub(super) const ALL: [Self; 2] = [Self::Futex, Self::Eventfd];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Eventfd => "eventfd",
            Self::Futex => "futex (POSIX semaphore)",
        }
    }
}

/// What the other process shall do.
#[derive(clap::Args)]
pub(crate) struct EchoOrder {
    #[arg(long)]
    bell: Bell,
    /// How often it answers before it ends.
    #[arg(long)]
    count: usize,
    /// Names of the semaphores.
    #[arg(long, default_value = "")]
    there: String,
    #[arg(long, default_value = "")]
    back: String,
}

/// Half of what there and back takes in nanoseconds, so many times, with a rest of `pause` before each.
pub(super) fn measure(bell: Bell, count: usize, pause: Duration) -> Result<Vec<u64>, Failure> {
    let (mut pair, all) = (Pair::start(bell, count + WARM_UP)?, count + WARM_UP);
    let mut times = Vec::with_capacity(all);
    let mut next = Instant::now();
    for _ in 0..all {
        if !pause.is_zero() {
            next += pause;
            thread::sleep(next.saturating_duration_since(Instant::now()));
        }
        let begun = monotonic_ns();
        pair.ring_and_wait()?;
        times.push((monotonic_ns() - begun) / 2);
    }
    pair.end()?;
    Ok(times.split_off(WARM_UP))
}

/// Two bells and the process that answers.
struct Pair {
    bells: Bells,
    child: Child,
}

enum Bells {
    Eventfd([OwnedFd; 2]),
    Futex(Box<[NamedSemaphore; 2]>),
}

impl Pair {
    fn start(bell: Bell, count: usize) -> Result<Self, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        let bell_name = clap::ValueEnum::to_possible_value(&bell).ok_or("a bell without a name")?;
        command.args(["latency-echo", "--bell", bell_name.get_name(), "--count", &count.to_string()]);
        let bells = match bell {
            Bell::Eventfd => {
                let bells = [eventfd(0, EventfdFlags::CLOEXEC)?, eventfd(0, EventfdFlags::CLOEXEC)?];
                command.stdin(Stdio::from(bells[0].try_clone()?));
                command.stdout(Stdio::from(bells[1].try_clone()?));
                Bells::Eventfd(bells)
            }
            Bell::Futex => {
                let names = ["there", "back"].map(|way| format!("tagbus-bench-{}-{way}", process::id()));
                command.args(["--there", &names[0], "--back", &names[1]]).stdin(Stdio::null());
                let [there, back] = names.map(|name| create(&name));
                Bells::Futex(Box::new([there?, back?]))
            }
        };
        Ok(Self { bells, child: command.spawn()? })
    }

    fn ring_and_wait(&mut self) -> Result<(), Failure> {
        match &self.bells {
            Bells::Eventfd([there, back]) => {
                ring(there)?;
                Ok(wait(back)?)
            }
            Bells::Futex(pair) => {
                let [there, back] = &**pair;
                there.post().map_err(|error| format!("{error:?}"))?;
                Ok(back.blocking_wait().map_err(|error| format!("{error:?}"))?)
            }
        }
    }

    fn end(mut self) -> Result<(), Failure> {
        let status = self.child.wait()?;
        if status.success() { Ok(()) } else { Err(format!("the echo ended with {status}").into()) }
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        // It may have ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Answers so many times.
pub(crate) fn echo(order: &EchoOrder) -> Result<(), Failure> {
    match order.bell {
        Bell::Eventfd => {
            let (there, back) = (io::stdin(), io::stdout());
            (0..order.count).try_for_each(|_| wait(&there).and_then(|()| ring(&back)))?;
        }
        Bell::Futex => {
            let (there, back) = (open(&order.there)?, open(&order.back)?);
            for _ in 0..order.count {
                there.blocking_wait().map_err(|error| format!("{error:?}"))?;
                back.post().map_err(|error| format!("{error:?}"))?;
            }
        }
    }
    Ok(())
}

fn ring(bell: &impl AsFd) -> io::Result<()> {
    rustix::io::write(bell, &1_u64.to_ne_bytes())?;
    Ok(())
}

fn wait(bell: &impl AsFd) -> io::Result<()> {
    let mut number = [0; 8];
    match rustix::io::read(bell, &mut number)? {
        8 => Ok(()),
        bytes => Err(io::Error::other(format!("{bytes} bytes from an eventfd"))),
    }
}

fn named(name: &str) -> Result<NamedSemaphoreBuilder, Failure> {
    let name = FileName::new(name.as_bytes()).map_err(|error| format!("{name}: {error:?}"))?;
    Ok(NamedSemaphoreBuilder::new(&name))
}

/// It is removed when it is dropped.
fn create(name: &str) -> Result<NamedSemaphore, Failure> {
    let new = named(name)?.creation_mode(CreationMode::PurgeAndCreate);
    let new = new.permission(Permission::OWNER_READ_WRITE).create();
    Ok(new.map_err(|error| format!("semaphore {name} ({error:?})"))?)
}

fn open(name: &str) -> Result<NamedSemaphore, Failure> {
    Ok(named(name)?.open_existing().map_err(|error| format!("semaphore {name} ({error:?})"))?)
}
