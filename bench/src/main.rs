//! How right, how fast, on what machine, beside which peers.

mod accuracy;
mod arguments;
mod chaos;
mod clock;
mod compare;
mod corners;
mod costly;
mod critical;
mod crowd;
mod delay;
mod false_positives;
mod hostile;
mod index;
mod latency;
mod machine;
mod many;
mod median;
mod memory;
mod paper_ablations;
mod peers;
mod phases;
mod record;
mod recorder;
mod recursive;
mod sets;
mod soak;
mod sweep;
mod syscalls;
mod threads;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use arguments::{
    Arguments, ChaosArguments, ClockArguments, Command, CornersArguments, CostlyArguments, CpuArguments,
    CriticalArguments, FalsePositivesArguments, HostileArguments, IndexArguments, LatencyArguments,
    ManyArguments, PaperArguments, PhasesArguments, RecorderArguments, RecursiveArguments, RenderArguments,
    SoakArguments, SweepArguments, SyscallsArguments, ThreadsArguments,
};
use clap::Parser as _;
use tagbus_family::Family;
use tagbus_scene::Tone;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Attack(order) => hostile::attack(&order),
        Command::Chaos(arguments) => chaos(&arguments),
        Command::Critical(arguments) => critical(&arguments),
        Command::Cpu(arguments) => cpu(&arguments),
        Command::Client(order) => crowd::client(&order),
        Command::Clock(arguments) => clock_of_camera(&arguments),
        Command::ClockStandIn(order) => delay::stand_in(&order),
        Command::Corners(arguments) => corners(&arguments),
        Command::FalsePositives(arguments) => false_positives(&arguments),
        Command::Costly(arguments) => costly(&arguments),
        Command::Hostile(arguments) => hostile(&arguments),
        Command::Paper(arguments) => paper(&arguments),
        Command::Index(arguments) => index(&arguments),
        Command::Recorder(arguments) => recorder(&arguments),
        Command::Latency(arguments) => latency(&arguments),
        Command::LatencyClient(order) => latency::listen(&order),
        Command::LatencyEcho(order) => latency::echo(&order),
        Command::LatencySleeper => latency::sleep(),
        Command::LatencyReceiver(order) => latency::receive(&order),
        Command::Many(arguments) => many(&arguments),
        Command::Phases(arguments) => phases(&arguments),
        Command::Recursive(arguments) => recursive(&arguments),
        Command::Render(arguments) => render(&arguments),
        Command::Soak(arguments) => soak(&arguments),
        Command::Sweep(arguments) => sweep(&arguments),
        Command::Syscalls(arguments) => syscalls(&arguments),
        Command::Threads(arguments) => threads(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tagbus-bench: {error}");
            ExitCode::from(2)
        }
    }
}

fn chaos(arguments: &ChaosArguments) -> Result<(), Failure> {
    let ChaosArguments { kills, clients, seed, startup, program, record } = arguments;
    let plan = chaos::Plan {
        program: arguments::beside_this(program.as_deref())?,
        kills: *kills,
        startup: *startup,
        clients: *clients,
        seed: *seed,
    };
    let outcome = chaos::run(&plan)?;
    let page = chaos::page(&outcome);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    chaos::figure(&outcome, &folder.join("chaos.svg"))?;
    std::fs::write(folder.join("chaos.csv"), chaos::csv(&outcome))?;
    let how = format!(
        "`tagbus-bench chaos --kills {kills} --clients {clients} --seed {seed}{}`; {}",
        if *startup { " --startup" } else { "" },
        chaos::HOW
    );
    let page = format!("[Distribution](chaos.svg), [every kill](chaos.csv)\n\n{page}");
    Ok(record::write_page(&folder.join("chaos.md"), "Kills of random roles", &how, &page)?)
}

fn critical(arguments: &CriticalArguments) -> Result<(), Failure> {
    let CriticalArguments { clients, rounds, frames, rate, core, program, record } = arguments;
    let plan = critical::Plan {
        program: arguments::beside_this(program.as_deref())?,
        clients: clients.clone(),
        rounds: *rounds,
        frames: *frames,
        rate: *rate,
        core: *core,
    };
    let page = critical::page(&critical::run(&plan)?);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let how = format!(
        "`tagbus-bench critical --rounds {rounds} --frames {frames} --rate {rate}`: an empty frame of 640x480, one detector (tag36h11, \
         default settings, one thread, `always`) as a thread of the bench pinned to a core, camera and clients as processes \
         of their own on the others; CPU time of that thread (CLOCK_THREAD_CPUTIME_ID) from before the newest frame is taken until its \
         message was sent, before clients are woken; the numbers of clients take turns, one round before the first is not counted"
    );
    Ok(record::write_page(
        &folder.join("critical.md"),
        "What clients cost on the critical path",
        &how,
        &page,
    )?)
}

fn clock_of_camera(arguments: &ClockArguments) -> Result<(), Failure> {
    let pattern = arguments.pattern()?;
    let duration = Duration::from_secs(arguments.seconds.into());
    if let Some(delay_ms) = arguments.check {
        return clock_check(arguments, &pattern, delay_ms);
    }
    let options = arguments.options()?;
    if let Some(switch) = arguments.switch() {
        print!("{}", delay::light_page(&delay::light(&options, &switch, duration)?));
        return Ok(());
    }
    let stop = tagbus_client::Stop::new()?;
    let seen = std::thread::scope(|scope| {
        let screen = arguments.screen();
        let show = |screen: delay::Screen| screen.show(&pattern, &stop).map_err(|error| error.to_string());
        let showing = screen.map(|screen| scope.spawn(move || show(screen)));
        let seen = delay::watch(&options, &pattern, duration);
        stop.trigger();
        if let Some(showing) = showing {
            showing.join().map_err(|_| "showing the pattern panicked")??;
        }
        seen
    })?;
    print!("{}", delay::shown_page(&seen, &pattern));
    Ok(())
}

fn clock_check(arguments: &ClockArguments, pattern: &delay::Pattern, delay_ms: u32) -> Result<(), Failure> {
    let check = delay::Check {
        program: arguments::beside_this(arguments.program.as_deref())?,
        delay_ms,
        pattern: pattern.clone(),
        rate: arguments.rate,
        duration: Duration::from_secs(arguments.seconds.into()),
        light: arguments.light,
    };
    match delay::check(&check)? {
        delay::Found::Shown(seen) => print!("{}", delay::shown_page(&seen, pattern)),
        delay::Found::Light(light) => print!("{}", delay::light_page(&light)),
    }
    Ok(())
}

fn cpu(arguments: &CpuArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let pictures = compare::load(&arguments.pictures)?;
    let rows = compare::run(&pictures, &arguments.family, &arguments.decimate, arguments.rounds)?;
    print!("{}", record::table(&rows));
    if let Some(path) = &arguments.record {
        record::write(path, &rows, arguments.rounds)?;
    }
    Ok(())
}

fn corners(arguments: &CornersArguments) -> Result<(), Failure> {
    let families: Result<_, _> = arguments.family.iter().map(|name| Family::published(name)).collect();
    let CornersArguments { decimate, pictures, blur, noise, gamma, exposure, ink, seed, .. } = *arguments;
    let plan = corners::Plan {
        families: families?,
        factor: decimate,
        cells_px: arguments.cell.clone(),
        conditions: corners::Conditions {
            pictures,
            blur_sigma: blur,
            noise_sigma: noise,
            tone: Tone { exposure, gamma },
            ink_spread_cells: ink,
            seed,
        },
    };
    let table = corners::tables(&plan)?;
    print!("{table}");
    if let Some(path) = &arguments.record {
        let how = format!(
            "decimation {decimate}, blur sigma {blur} px, noise sigma {noise}, gamma {gamma}, exposure {exposure}, ink spread by \
             {ink} cells, tilt to 30 degrees, seed {seed}; CPU time is the quickest of three rounds, alignment what \
             `tag` takes longer than `edges`, both the median over pictures"
        );
        record::write_page(path, "Corner errors on rendered tags", &how, &table)?;
    }
    Ok(())
}

fn false_positives(arguments: &FalsePositivesArguments) -> Result<(), Failure> {
    let FalsePositivesArguments { images, same_place, seeds, threads, record } = arguments;
    let plan = false_positives::Plan {
        folders: images.clone(),
        same_place: same_place.clone(),
        seeds: *seeds as usize,
        threads: *threads,
    };
    let findings = false_positives::run(&plan)?;
    let page = false_positives::page(&findings);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    false_positives::figure(&findings, &folder.join("false-positives.svg"))?;
    std::fs::write(folder.join("false-positives.csv"), false_positives::csv(&findings))?;
    let page = format!("[Against random bits](false-positives.svg)\n\n{page}");
    let (path, title) = (folder.join("false-positives.md"), "False positives by complexity metric");
    Ok(record::write_page(&path, title, &false_positives::how(&plan), &page)?)
}

fn costly(arguments: &CostlyArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let CostlyArguments { pictures, decimate, rounds, record, .. } = arguments;
    let plan = costly::Plan { pictures: pictures.clone(), factors: decimate.clone(), rounds: *rounds };
    let page = costly::page(&costly::run(&plan)?);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let how = format!(
        "noise, checkerboards and stripes (grey levels 35 and 215) against natural pictures, whose middle part is scaled to \
         the same size (Catmull-Rom); CPU time, {rounds} rounds after one warm-up, detectors take turns on each frame in an order drawn anew, one \
         thread pinned to one core; memory is the most that a fresh detector allocates for the frame"
    );
    Ok(record::write_page(&folder.join("costly.md"), "Frames made to cost", &how, &page)?)
}

fn hostile(arguments: &HostileArguments) -> Result<(), Failure> {
    let HostileArguments { attacks, rounds, seconds, rate, seed, core, program, record } = arguments;
    let plan = hostile::Plan {
        program: arguments::beside_this(program.as_deref())?,
        attacks: if attacks.is_empty() { hostile::Attack::ALL.to_vec() } else { attacks.clone() },
        rounds: *rounds,
        seconds: *seconds,
        rate: *rate,
        seed: *seed,
        core: *core,
    };
    let outcome = hostile::run(&plan)?;
    let page = hostile::page(&outcome);
    print!("{page}");
    if let Some(folder) = record {
        std::fs::create_dir_all(folder)?;
        let command = format!(
            "`tagbus-bench hostile --rounds {rounds} --seconds {seconds} --rate {rate} --seed {seed}`"
        );
        let how = format!("{command}; {}", hostile::HOW);
        std::fs::write(folder.join("hostile.csv"), hostile::csv(&outcome))?;
        let page = format!("[Every measurement](hostile.csv)\n\n{page}");
        record::write_page(&folder.join("hostile.md"), "Attackers on the bus", &how, &page)?;
    }
    match hostile::faults(&outcome).as_slice() {
        [] => Ok(()),
        faults => Err(format!("this must not happen: {}", faults.join("; ")).into()),
    }
}

fn index(arguments: &IndexArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let IndexArguments { hamming, rounds, probes, seed, record, .. } = arguments;
    let plan = index::Plan { hamming: *hamming, rounds: *rounds, probes: *probes, seed: *seed };
    let outcome = index::run(&plan)?;
    let page = index::page(&outcome);
    print!("{page}");
    if let Some(folder) = record {
        std::fs::create_dir_all(folder)?;
        let how = format!(
            "`tagbus-bench index --hamming {hamming} --rounds {rounds} --probes {probes} --seed {seed}`; CPU time of one thread pinned to \
             one core; brute force compares every code in every rotation ({}) and must agree on tag or not, id, wrong bits \
             and rotation; half of its probes are random codes, half tags in any rotation with 0 to 4 wrong bits; tags that are timed have \
             as many wrong bits as are corrected",
            tagbus_family::search::Level::best()
        );
        record::write_page(&folder.join("index.md"), "All published families at once", &how, &page)?;
    }
    match outcome.disagreements() {
        0 => Ok(()),
        count => Err(format!("look-up and brute force disagree on {count} probes").into()),
    }
}

fn recorder(arguments: &RecorderArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let frames = 100_000;
    let page = recorder::page(&recorder::run(arguments.rounds, frames));
    print!("{page}");
    if let Some(folder) = &arguments.record {
        std::fs::create_dir_all(folder)?;
        let how = format!(
            "`tagbus-bench recorder --rounds {}`; one thread pinned to one core; warm: CPU time of {frames} frames a round; emptied: 16 MB are written before each of 64 frames of a round, whose times are added up",
            arguments.rounds
        );
        record::write_page(&folder.join("recorder.md"), "What the flight recorder costs", &how, &page)?;
    }
    Ok(())
}

fn latency(arguments: &LatencyArguments) -> Result<(), Failure> {
    let LatencyArguments { size, clients, seconds, rounds, rate, ways, program, record } = arguments;
    let plan = latency::Plan {
        program: arguments::beside_this(program.as_deref())?,
        size: *size,
        clients: clients.clone(),
        seconds: *seconds,
        rounds: *rounds as usize,
        rate: *rate,
        ways: ways.clone(),
    };
    let outcome = latency::run(&plan)?;
    let page = latency::page(&outcome);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    latency::figure(&outcome, &folder.join("latency.svg"))?;
    std::fs::write(folder.join("latency.csv"), latency::csv(&outcome))?;
    let [width, height] = size;
    let counts: Vec<String> = clients.iter().map(ToString::to_string).collect();
    let how = format!(
        "`tagbus-bench latency --size {width}x{height} --clients {} --seconds {seconds} --rounds {rounds} --rate {rate}`; {}",
        counts.join(","),
        latency::HOW
    );
    let page = format!("[Distributions](latency.svg), [quantiles](latency.csv)\n\n{page}");
    Ok(record::write_page(&folder.join("latency.md"), "How long a frame takes", &how, &page)?)
}

fn many(arguments: &ManyArguments) -> Result<(), Failure> {
    let ManyArguments { seconds, clients, rate, program, record } = arguments;
    let program = arguments::beside_this(program.as_deref())?;
    let plan = many::Plan { program, seconds: *seconds, clients: *clients as usize, rate: *rate };
    let told = many::run(&plan)?;
    let page = many::page(&told);
    print!("{page}");
    if let Some(folder) = record {
        std::fs::create_dir_all(folder)?;
        let command = format!("`tagbus-bench many --seconds {seconds} --clients {clients} --rate {rate}`");
        let how = format!("{command}; {}", many::HOW);
        record::write_page(&folder.join("many.md"), "Changes while many listen", &how, &page)?;
    }
    match many::faults(&told).as_slice() {
        [] => Ok(()),
        faults => Err(format!("this must not happen: {}", faults.join("; ")).into()),
    }
}

fn phases(arguments: &PhasesArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let PhasesArguments { pictures, decimate, rounds, record, .. } = arguments;
    let plan = phases::Plan { pictures: pictures.clone(), factors: decimate.clone(), rounds: *rounds };
    let page = phases::page(&phases::run(&plan)?);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let how = format!(
        "tags aligned as a whole (--refine tag), CPU time in milliseconds: of each picture the quickest of {rounds} rounds after one \
         warm-up, medians over pictures (each column for itself); all levels and the C library take turns on each picture, one thread pinned to one core"
    );
    Ok(record::write_page(&folder.join("phases.md"), "Where the time goes", &how, &page)?)
}

fn paper(arguments: &PaperArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    let PaperArguments { sets, family, count, seed, rounds, .. } = arguments;
    let mut page = String::from(paper_ablations::COLUMNS);
    for set in sets {
        let recipe = sets::named(set)?;
        for name in family {
            let renderer = sets::Renderer::new(recipe, Family::published(name)?, *seed);
            let lines = paper_ablations::run(&renderer, count * recipe.bins().len(), *rounds)?;
            page += &paper_ablations::section(&format!("{set}, {name}"), &lines);
        }
    }
    print!("{page}");
    let Some(path) = &arguments.record else { return Ok(()) };
    let how = format!(
        "{count} frames of every distance and tilt, seed {seed}, {rounds} rounds; lines take turns on each frame, one thread \
         pinned to one core"
    );
    Ok(record::write_page(path, "The paper's choices, one at a time", &how, &page)?)
}

fn recursive(arguments: &RecursiveArguments) -> Result<(), Failure> {
    let RecursiveArguments { decimate, seeds, seed, record } = arguments;
    let lines = recursive::run(&recursive::Plan { factors: decimate.clone(), seeds: *seeds, seed: *seed })?;
    let page = recursive::page(&lines);
    print!("{page}\n{}", recursive::verdict(&lines));
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    recursive::figure(&lines, &folder.join("recursive.svg"))?;
    std::fs::write(folder.join("recursive.csv"), recursive::csv(&lines))?;
    let how = format!(
        "three nested tagCustom48h12, printed 90.2, 18.04 and 3.608 cm wide, 640x480 pixels over 62.2 degrees; a room full \
         of structure around the print, blur sigma 0.6 px, noise sigma 2.5, vignetting 0.25; {seeds} frames of every \
         distance with noise, ids, rotation, tilt up to 5 degrees and place (within 40 px of the middle) of their own, \
         seed {seed}"
    );
    let page = format!("[Found against distance](recursive.svg)\n\n{page}");
    Ok(record::write_page(&folder.join("recursive.md"), "The nested tag of Figure 1", &how, &page)?)
}

fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let recipe = sets::named(&arguments.set)?;
    for name in &arguments.family {
        let renderer = sets::Renderer::new(recipe, Family::published(name)?, arguments.seed);
        let count = arguments.count.unwrap_or(recipe.frame_count());
        match &arguments.out {
            Some(folder) => sets::write(&renderer, count, folder)?,
            None => print!("{}", sets::list(&renderer, count)?),
        }
    }
    Ok(())
}

fn soak(arguments: &SoakArguments) -> Result<(), Failure> {
    let SoakArguments { minutes, clients, rate, program, record } = arguments;
    let program = arguments::beside_this(program.as_deref())?;
    let plan = soak::Plan { program, minutes: *minutes, clients: *clients as usize, rate: *rate };
    let outcome = soak::run(&plan)?;
    let page = soak::page(&plan, &outcome);
    print!("{page}");
    if let Some(folder) = record {
        std::fs::create_dir_all(folder)?;
        soak::figure(&outcome, &folder.join("soak.svg"))?;
        std::fs::write(folder.join("soak.csv"), soak::csv(&outcome))?;
        let how = format!(
            "`tagbus-bench soak --minutes {minutes} --clients {clients} --rate {rate}`; {}",
            soak::HOW
        );
        let page = format!("[Over time](soak.svg), [every look](soak.csv)\n\n{page}");
        record::write_page(&folder.join("soak.md"), "Many clients for a long time", &how, &page)?;
    }
    match soak::faults(&plan, &outcome).as_slice() {
        [] => Ok(()),
        faults => Err(format!("this must not happen: {}", faults.join("; ")).into()),
    }
}

fn syscalls(arguments: &SyscallsArguments) -> Result<(), Failure> {
    let SyscallsArguments { seconds, clients, rate, program, record } = arguments;
    let program = arguments::beside_this(program.as_deref())?;
    let plan = syscalls::Plan { program, seconds: *seconds, clients: clients.clone(), rate: *rate };
    let page = syscalls::run(&plan)?;
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let how = format!(
        "`tagbus-bench syscalls --seconds {seconds} --rate {rate}`: an empty frame of 640x480, one detector with one thread (`--always`), \
         after three seconds of warm-up; first CPU time of the detector's process (schedstat) from frame to frame, waiting, \
         receiving, searching, sending and waking all clients together, then `strace -c -f` on all its threads, and at last on a client"
    );
    Ok(record::write_page(
        &folder.join("syscalls.md"),
        "CPU time and system calls of a detector and a client",
        &how,
        &page,
    )?)
}

fn sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    if arguments.set == arguments::NATURAL {
        return sweep_natural(arguments);
    }
    let recipe = sets::named(&arguments.set)?;
    let repetitions = arguments.count.unwrap_or(recipe.repetitions);
    let count = repetitions * recipe.bins().len();
    let plan = plan(arguments, count);
    let mut lines = Vec::new();
    for name in &arguments.family {
        let renderer = sets::Renderer::new(recipe, Family::published(name)?, arguments.seed);
        lines.extend(sweep::run(&renderer, &plan)?);
    }
    let page = sweep::page(&lines);
    print!("{page}");
    let Some(folder) = &arguments.record else { return Ok(()) };
    let how = format!(
        "set {} ({}), {repetitions} frames of every distance and tilt, seed {}, {} rounds; detectors take turns on each \
         frame in an order drawn anew, one thread pinned to one core",
        recipe.name, recipe.about, arguments.seed, arguments.rounds
    );
    record_sweep(folder, &recipe, &lines, &how, &page)
}

fn plan(arguments: &SweepArguments, frames: usize) -> sweep::Plan {
    let SweepArguments { rounds, only, python, .. } = arguments;
    let detectors = peers::Choice { only: only.clone(), python: python.clone() };
    sweep::Plan { frames, rounds: *rounds, detectors }
}

fn record_sweep(
    folder: &Path,
    recipe: &sets::Recipe,
    lines: &[sweep::Line],
    how: &str,
    page: &str,
) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let name = recipe.name;
    let mut links = String::new();
    let plotted: &[sweep::Line] = if recipe.ids == sets::Ids::None { &[] } else { lines };
    for family in plotted.chunk_by(|a, b| a.family == b.family) {
        let title = &family[0].family;
        let file = |figure: u32| format!("{name}-{title}-figure{figure}.svg");
        let (speed, range) = (file(7), file(8));
        sweep::figure_7(family, &format!("Speed against recall: {name}, {title}"), &folder.join(&speed))?;
        sweep::figure_8(family, &format!("Recall against distance: {name}, {title}"), &folder.join(&range))?;
        links += &format!("* {title}: [speed against recall]({speed}), [recall against distance]({range})\n");
    }
    let page = format!("{links}\n{page}");
    record::write_page(&folder.join(format!("{name}.md")), &format!("Sweep of the set {name}"), how, &page)?;
    Ok(std::fs::write(folder.join(format!("{name}.csv")), sweep::csv(lines))?)
}

fn sweep_natural(arguments: &SweepArguments) -> Result<(), Failure> {
    let folder = arguments
        .pictures
        .as_deref()
        .ok_or("natural pictures are yours: name their folder with --pictures")?;
    let plan = plan(arguments, arguments.count.unwrap_or(usize::MAX));
    let mut page = String::new();
    for family in &arguments.family {
        page += &sweep::sweep_natural(folder, family, &plan)?;
    }
    print!("{page}");
    let Some(folder) = &arguments.record else { return Ok(()) };
    let how = format!(
        "natural pictures as they are, and their middle part scaled to 1296x964 (Catmull-Rom), {} rounds; detectors take \
         turns on each picture, one thread pinned to one core",
        arguments.rounds
    );
    std::fs::create_dir_all(folder)?;
    Ok(record::write_page(&folder.join("natural.md"), "Sweep of natural pictures", &how, &page)?)
}

fn threads(arguments: &ThreadsArguments) -> Result<(), Failure> {
    let ThreadsArguments { pictures, decimate, threads, rounds, pause, record } = arguments;
    let plan = threads::Plan {
        pictures: pictures.clone(),
        factor: *decimate,
        threads: threads.clone(),
        rounds: *rounds,
        pause: Duration::from_millis(*pause),
    };
    let page = threads::page(&threads::run(&plan)?);
    print!("{page}");
    let Some(folder) = record else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    let how = format!(
        "wall time in milliseconds, tag36h11 and tagStandard41h12 in one detector, decimation {decimate}, {rounds} rounds; \
         numbers of threads take turns on each picture, {pause} ms of rest before each search; natural pictures \
         are scaled to each size (Catmull-Rom)"
    );
    Ok(record::write_page(&folder.join("threads.md"), "Threads", &how, &page)?)
}
