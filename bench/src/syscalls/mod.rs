//! CPU time and system calls of a running detector and of one of its clients for each empty frame, the latter counted by strace.

use std::fs;
use std::io;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use tagbus_client::control::DetectorControl;

use crate::Failure;
use crate::crowd::{Machine, Member, Part, Temper};

/// What is counted how long.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    pub(crate) seconds: u32,
    /// Numbers of clients, a line of the table each.
    pub(crate) clients: Vec<usize>,
    pub(crate) rate: u32,
}

/// Width and height of the empty frame.
const SIZE: [usize; 2] = [640, 480];

/// What was counted with one number of clients.
struct Counted {
    /// CPU time of the detector's process, microseconds a frame.
    cpu_us: f64,
    /// Frames that were searched while calls were counted.
    frames: u64,
    /// Times in which no frame came for three frame times, and the dead were looked for, while calls were counted.
    silences: u64,
    calls: Vec<Calls>,
    /// Messages that were sent while the calls of a client were counted, and these; nothing without clients.
    of_client: Option<(u64, Vec<Calls>)>,
}

/// One call and how often it was made.
struct Calls {
    name: String,
    count: u64,
}

/// A line for each number of clients.
pub(crate) fn run(plan: &Plan) -> Result<String, Failure> {
    let mut text = String::from(
        "| clients | CPU us a frame | frames traced | silences | system calls a frame | which, a frame | of a client, a message | which |\n\
         |---:|---:|---:|---:|---:|---|---:|---|\n",
    );
    for &clients in &plan.clients {
        let Counted { cpu_us, frames, silences, calls, of_client } = count(plan, clients)?;
        let of_client =
            of_client.map_or_else(|| "- | -".to_owned(), |(messages, calls)| each(&calls, messages));
        text += &format!(
            "| {clients} | {cpu_us:.1} | {frames} | {silences} | {} | {of_client} |\n",
            each(&calls, frames)
        );
    }
    Ok(text)
}

/// All calls together and each of them, by frame.
fn each(calls: &[Calls], frames: u64) -> String {
    let share = |count: u64| count as f64 / frames.max(1) as f64;
    let all = calls.iter().map(|calls| calls.count).sum();
    let each: Vec<String> =
        calls.iter().map(|calls| format!("{} {:.2}", calls.name, share(calls.count))).collect();
    format!("{:.2} | {}", share(all), each.join(", "))
}

fn count(plan: &Plan, clients: usize) -> Result<Counted, Failure> {
    let mut machine = Machine::new(&plan.program)?;
    let picture = std::env::temp_dir().join(format!("{}.pgm", machine.domain.name()));
    fs::write(&picture, empty_picture())?;
    let source = format!("--source=replay:{}", picture.display());
    let counted = machine
        .camera("cam0", &[source, format!("--framerate={}", plan.rate)])
        .and_then(|()| count_of(plan, clients, machine));
    fs::remove_file(&picture)?;
    counted
}

fn count_of(plan: &Plan, clients: usize, mut machine: Machine) -> Result<Counted, Failure> {
    machine.detector("cam0", "main", &["--always".to_owned()])?;
    for _ in 0..clients {
        machine.client("cam0", "main", Temper::Honest)?;
    }
    let mut asking = DetectorControl::connect(&machine.reach("cam0", "main"))?;
    // Warm-up: everybody connects, buffers grow to what frames need.
    thread::sleep(Duration::from_secs(3));
    let detector = machine.members.iter().find(|member| member.part == Part::Detector);
    let number = detector.ok_or("there is no detector")?.number();
    let duration = Duration::from_secs(plan.seconds.into());
    let (first, cpu_before) = (asking.get()?.statistics, cpu_ns(number)?);
    thread::sleep(duration);
    let (cpu_after, before) = (cpu_ns(number)?, asking.get()?.statistics);
    let calls = strace(number, duration)?;
    let after = asking.get()?.statistics;
    let client = machine.members.iter().find(|member| matches!(member.part, Part::Client(_)));
    let of_client = match client.map(Member::number) {
        Some(client) => {
            let calls = strace(client, duration)?;
            Some((asking.get()?.statistics.messages_sent - after.messages_sent, calls))
        }
        None => None,
    };
    let frames = (before.frames_searched - first.frames_searched).max(1);
    let cpu_us = (cpu_after - cpu_before) as f64 / 1e3 / frames as f64;
    drop(asking);
    machine.end()?;
    let frames = after.frames_searched - before.frames_searched;
    let silences = after.deadlines_missed - before.deadlines_missed;
    Ok(Counted { cpu_us, frames, silences, calls, of_client })
}

/// Flat grey, as a PGM file.
fn empty_picture() -> Vec<u8> {
    let [width, height] = SIZE;
    let mut file = format!("P5\n{width} {height}\n255\n").into_bytes();
    file.resize(file.len() + width * height, 120);
    file
}

/// CPU time of all threads of a process, nanoseconds.
pub(crate) fn cpu_ns(process: u32) -> io::Result<u64> {
    let mut sum = 0;
    for thread in fs::read_dir(format!("/proc/{process}/task"))? {
        let text = fs::read_to_string(thread?.path().join("schedstat"))?;
        let first = text.split_whitespace().next().and_then(|word| word.parse::<u64>().ok());
        sum += first.ok_or_else(|| io::Error::other(format!("no CPU time in schedstat: '{text}'")))?;
    }
    Ok(sum)
}

/// Attaches to all threads of a process for so long.
fn strace(process: u32, duration: Duration) -> Result<Vec<Calls>, Failure> {
    let mut command = Command::new("strace");
    command.args(["-f", "-c", "-p", &process.to_string()]).stdout(Stdio::null()).stderr(Stdio::piped());
    let child = command.spawn().map_err(|error| format!("strace cannot be started ({error}): install it"))?;
    thread::sleep(duration);
    if let Some(number) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        kill_process(number, Signal::INT)?;
    }
    let output = child.wait_with_output()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let calls = table(&text);
    if calls.is_empty() {
        return Err(format!("strace counted nothing: {text}").into());
    }
    Ok(calls)
}

/// Lines of `strace -c`: share, seconds, microseconds a call, calls, errors (or nothing), name.
fn table(text: &str) -> Vec<Calls> {
    let calls = text.lines().filter_map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (name, count) = (words.last()?, words.get(3)?.parse().ok()?);
        (words.len() >= 5 && *name != "total").then(|| Calls { name: (*name).to_owned(), count })
    });
    calls.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_strace_is_read() {
        let text = "strace: Process 7 attached with 2 threads\n\
            % time     seconds  usecs/call     calls    errors syscall\n\
            ------ ----------- ----------- --------- --------- ----------------\n \
            60.00    0.000600           6       100           epoll_wait\n \
            40.00    0.000400           2       200       100 recvfrom\n\
            ------ ----------- ----------- --------- --------- ----------------\n\
            100.00    0.001000           3       300       100 total\n";
        let calls: Vec<_> = table(text).into_iter().map(|calls| (calls.name, calls.count)).collect();
        assert_eq!(calls, [("epoll_wait".to_owned(), 100), ("recvfrom".to_owned(), 200)]);
    }
}
