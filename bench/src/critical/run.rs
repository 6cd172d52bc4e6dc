//! A detector in a thread of this process, and clients that come and go as processes of their own.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use rustix::time::{ClockId, clock_gettime};
use tagbus_client::Stop;
use tagbus_family::Family;
use tagbus_service::{Moment, ServiceConfig, ServiceError, Summary, Watch, run as serve};

use crate::Failure;
use crate::crowd::{Machine, PlayedPicture, Temper};
use crate::machine::{keep_off, pin_to};

/// Width and height of the empty frame.
const SIZE: [usize; 2] = [640, 480];
/// Clients connect and buffers grow in this time.
const SETTLE: Duration = Duration::from_secs(1);
/// So many times as long as they should take are frames waited for.
const PATIENCE: u32 = 20;

/// What is measured how often.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    /// Numbers of clients, a line of the table each.
    pub(crate) clients: Vec<usize>,
    /// Rounds after one that warms up; in each the numbers of clients take turns.
    pub(crate) rounds: usize,
    /// Frames of each number in a round.
    pub(crate) frames: usize,
    /// Frames a second.
    pub(crate) rate: u32,
    /// The core of the detector, which the others are kept off.
    pub(crate) core: usize,
}

/// Microseconds of CPU time of each frame with so many clients, by round.
pub(crate) struct Measured {
    pub(super) clients: usize,
    pub(super) rounds: Vec<Vec<f64>>,
}

/// An error is whatever ends before, ends badly or leaves something, and a client that got less than was sent.
pub(crate) fn run(plan: &Plan) -> Result<Vec<Measured>, Failure> {
    keep_off(plan.core)?;
    let mut machine = Machine::new(&plan.program)?;
    let picture = PlayedPicture::write_empty(machine.domain.name(), SIZE)?;
    machine.camera("cam0", &[picture.source(), format!("--framerate={}", plan.rate)])?;
    let detector = Watched::start(&machine, plan.core)?;
    let bar = ProgressBar::new(((plan.rounds + 1) * plan.clients.len()) as u64);
    let none = |&clients: &usize| Measured { clients, rounds: Vec::new() };
    let mut all: Vec<Measured> = plan.clients.iter().map(none).collect();
    for round in 0..=plan.rounds {
        for measured in &mut all {
            let times = measure(plan, measured.clients, &mut machine, &detector)?;
            if round > 0 {
                measured.rounds.push(times);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    detector.end()?;
    machine.end()?;
    Ok(all)
}

fn measure(
    plan: &Plan,
    clients: usize,
    machine: &mut Machine,
    detector: &Watched,
) -> Result<Vec<f64>, Failure> {
    for _ in 0..clients {
        machine.client("cam0", "main", Temper::Honest)?;
    }
    thread::sleep(SETTLE);
    detector.take();
    let (begun, should_take) = (Instant::now(), Duration::from_secs(1) / plan.rate * plan.frames as u32);
    while detector.count() < plan.frames {
        if begun.elapsed() > should_take * PATIENCE {
            return Err("the detector does not get its frames".into());
        }
        thread::sleep(Duration::from_millis(20));
        machine.check()?;
    }
    let times = detector.take();
    for (_, _, tally) in machine.end_clients()? {
        let got = tally.received + tally.missed;
        if got < plan.frames as u64 || tally.unaccounted > 0 {
            return Err(format!("a client was not there all the time: {tally:?}").into());
        }
    }
    Ok(times)
}

/// A detector in a thread, and the CPU time of its frames.
struct Watched {
    stop: Stop,
    thread: JoinHandle<Result<Summary, ServiceError>>,
    times: Arc<Mutex<Vec<f64>>>,
}

impl Watched {
    /// It searches also while nobody listens: otherwise nothing could be compared.
    fn start(machine: &Machine, core: usize) -> Result<Self, Failure> {
        let times = Arc::new(Mutex::new(Vec::new()));
        let mut config = ServiceConfig::new(machine.domain.clone(), vec![Family::published("tag36h11")?]);
        config.always = true;
        config.watch = Some(stopwatch(Arc::clone(&times)));
        let stop = Stop::new()?;
        let own = stop.clone();
        let thread = thread::Builder::new().name("detector".to_owned()).spawn(move || {
            // On a machine with one core there is no other.
            let _ = pin_to(core);
            serve(config, own)
        })?;
        Ok(Self { stop, thread, times })
    }

    fn count(&self) -> usize {
        self.times.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// What was measured since the last time.
    fn take(&self) -> Vec<f64> {
        std::mem::take(&mut self.times.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn end(self) -> Result<(), Failure> {
        self.stop.trigger();
        match self.thread.join() {
            Ok(ended) => Ok(ended.map(|_summary| ())?),
            Err(_) => Err("the detector panicked".into()),
        }
    }
}

/// Takes the time from the moment at which a frame is about to be taken to that at which its message is sent.
fn stopwatch(times: Arc<Mutex<Vec<f64>>>) -> Watch {
    let mut begun = 0.0;
    Box::new(move |moment| match moment {
        Moment::Receive => begun = own_cpu_us(),
        Moment::Sent => {
            let took = own_cpu_us() - begun;
            times.lock().unwrap_or_else(PoisonError::into_inner).push(took);
        }
    })
}

/// CPU time of this thread so far.
fn own_cpu_us() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e6 + now.tv_nsec as f64 * 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_a_thread_goes_on_while_it_works_and_is_taken_for_each_message() {
        let times = Arc::new(Mutex::new(Vec::new()));
        let mut watch = stopwatch(Arc::clone(&times));
        watch(Moment::Receive);
        watch(Moment::Receive);
        let begun = own_cpu_us();
        while own_cpu_us() < begun + 300.0 {}
        watch(Moment::Sent);
        let times = times.lock().unwrap();
        assert!(times.len() == 1 && times[0] >= 300.0, "{times:?}");
    }
}
