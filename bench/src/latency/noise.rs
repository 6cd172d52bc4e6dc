//! Whether the machine was quiet enough for latencies to be believed.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use crate::machine;

/// How long each processor is watched.
const WATCH: Duration = Duration::from_millis(250);
/// A loop that only reads the clock does not stop for so long by itself.
const GAP: Duration = Duration::from_micros(5);
/// More than this part of the time taken away, or a gap that is longer than this, is noise.
const MOST_LOST: f64 = 0.02;
const LONGEST_GAP_US: f64 = 1000.0;
/// Load average for each processor before the run.
const MOST_LOAD: f64 = 0.3;
/// Processor time that others used in the run.
const MOST_OTHERS: f64 = 0.05;

/// What a loop that only reads the clock saw on all processors at once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Calm {
    /// Part of the time in which the loop did not run.
    pub(super) lost: f64,
    /// The longest time in which it did not, microseconds.
    pub(super) longest_us: f64,
}

impl Calm {
    /// Watches every processor.
    pub(super) fn look() -> Self {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let watches: Vec<_> =
            (0..processors).map(|processor| thread::spawn(move || watch(processor))).collect();
        let seen = watches.into_iter().filter_map(|watch| watch.join().ok());
        seen.fold(Self::default(), Self::and)
    }

    /// The worse of both.
    pub(super) fn and(self, other: Self) -> Self {
        Self { lost: self.lost.max(other.lost), longest_us: self.longest_us.max(other.longest_us) }
    }
}

fn watch(processor: usize) -> Calm {
    // Without a processor of its own it still sees what is taken from it.
    let _ = machine::pin_to(processor);
    let (begun, mut lost, mut longest) = (Instant::now(), Duration::ZERO, Duration::ZERO);
    let mut last = begun;
    while last - begun < WATCH {
        let now = Instant::now();
        let gap = now - last;
        if gap > GAP {
            lost += gap;
        }
        longest = longest.max(gap);
        last = now;
    }
    Calm { lost: lost.as_secs_f64() / (last - begun).as_secs_f64(), longest_us: longest.as_secs_f64() * 1e6 }
}

/// The machine before and while something was measured.
#[derive(Clone, Debug, Default)]
pub(super) struct Noise {
    /// Load averages before and after.
    pub(super) loads: [String; 2],
    /// Before the first, between all and after the last round.
    pub(super) calm: Vec<Calm>,
    /// Part of the processors' time that was used by processes that are none of ours, and that the host took.
    pub(super) others: f64,
    pub(super) stolen: f64,
    processors: usize,
    begun: Option<Ticks>,
}

impl Noise {
    pub(super) fn begin() -> Self {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let loads = [load(), String::new()];
        Self { loads, calm: vec![Calm::look()], processors, begun: Ticks::now(), ..Self::default() }
    }

    /// To be called after each round.
    pub(super) fn look(&mut self) {
        self.calm.push(Calm::look());
    }

    pub(super) fn end(&mut self) {
        self.loads[1] = load();
        if let (Some(before), Some(after)) = (self.begun, Ticks::now()) {
            let all = (after.all - before.all).max(1) as f64;
            let busy = (after.busy - before.busy) as f64;
            let ours = (after.ours - before.ours) as f64;
            self.others = (busy - ours).max(0.0) / all;
            self.stolen = (after.stolen - before.stolen) as f64 / all;
        }
    }

    /// What speaks against the figures, a sentence each; nothing when the machine was quiet.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let load: f64 = self.loads[0].split(' ').next().and_then(|load| load.parse().ok()).unwrap_or(0.0);
        if load > MOST_LOAD * self.processors as f64 {
            warnings.push(format!(
                "the load average was {load} on {} processors before the run",
                self.processors
            ));
        }
        if self.others > MOST_OTHERS {
            warnings.push(format!("other processes used {:.0} % of the processors", self.others * 100.0));
        }
        if self.stolen > MOST_LOST {
            warnings.push(format!("the host took {:.0} % of the processors", self.stolen * 100.0));
        }
        let noisy = self.calm.iter().filter(|calm| calm.lost > MOST_LOST || calm.longest_us > LONGEST_GAP_US);
        let (count, worst) =
            (noisy.clone().count(), noisy.fold(Calm::default(), |worst, &one| worst.and(one)));
        if count > 0 {
            warnings.push(format!(
                "in {count} of {} looks a loop that only reads the clock lost up to {:.1} % of its time, {:.0} us at once",
                self.calm.len(),
                worst.lost * 100.0,
                worst.longest_us
            ));
        }
        warnings
    }
}

fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').take(3).collect::<Vec<_>>().join(" ")
}

/// Processor time in the kernel's ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ticks {
    all: u64,
    busy: u64,
    stolen: u64,
    /// Of this process and those children that have ended.
    ours: u64,
}

impl Ticks {
    fn now() -> Option<Self> {
        let machine = fs::read_to_string("/proc/stat").ok()?;
        Self::parse(&machine, &fs::read_to_string("/proc/self/stat").ok()?)
    }

    /// `cpu user nice system idle iowait irq softirq steal ...`, and the fields after the name of a process, whose 12th to 15th are
    /// user and system time, its own and that of its children.
    fn parse(machine: &str, process: &str) -> Option<Self> {
        let numbers = |text: &str| -> Vec<u64> {
            text.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect()
        };
        let all = numbers(machine.lines().next()?);
        let [user, nice, system, idle, waiting, interrupts, soft, stolen, ..] = all[..] else { return None };
        let busy = user + nice + system + interrupts + soft;
        let (_, fields) = process.rsplit_once(')')?;
        let fields: Vec<&str> = fields.split_ascii_whitespace().collect();
        let ours = fields.get(11..15)?.iter().filter_map(|word| word.parse::<u64>().ok()).sum();
        Some(Self { all: busy + idle + waiting + stolen, busy, stolen, ours })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_read() {
        let machine = "cpu  10 1 5 100 7 2 3 4 0 0\ncpu0 1 1 1 1 1 1 1 1 0 0\n";
        let process = "77 (a) b) S 1 2 3 4 5 6 7 8 9 10 20 30 40 50 60 0\n";
        let ticks = Ticks::parse(machine, process).unwrap();
        assert_eq!(ticks, Ticks { all: 132, busy: 21, stolen: 4, ours: 140 });
        assert!(Ticks::parse("cpu 1 2", process).is_none());
        assert!(Ticks::now().is_some());
    }

    #[test]
    fn a_quiet_machine_gives_no_warning_and_a_busy_one_says_why() {
        let quiet = Noise {
            loads: ["0.10 0.2 0.3".to_owned(), "1.0 0.2 0.3".to_owned()],
            calm: vec![Calm { lost: 0.001, longest_us: 60.0 }; 3],
            processors: 2,
            ..Noise::default()
        };
        assert_eq!(quiet.warnings(), Vec::<String>::new());
        let mut busy = Noise { others: 0.5, stolen: 0.1, ..quiet };
        busy.loads[0] = "3.20 1 1".to_owned();
        busy.calm[1] = Calm { lost: 0.3, longest_us: 4000.0 };
        let warnings = busy.warnings().join("; ");
        for words in
            ["load average was 3.2", "used 50 %", "took 10 %", "in 1 of 3 looks", "30.0 %", "4000 us"]
        {
            assert!(warnings.contains(words), "{words}: {warnings}");
        }
    }

    #[test]
    fn a_look_sees_parts_of_the_time() {
        let calm = Calm::look();
        assert!((0.0..=1.0).contains(&calm.lost) && calm.longest_us > 0.0);
    }
}
