//! How right, how fast, on what machine, beside which peers.

mod accuracy;
mod arguments;
mod clock;
mod compare;
mod corners;
mod machine;
mod peers;
mod record;
mod sets;
mod sweep;

use std::path::Path;
use std::process::ExitCode;

use arguments::{Arguments, Command, CornersArguments, CpuArguments, RenderArguments, SweepArguments};
use clap::Parser as _;
use tagbus_family::Family;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Cpu(arguments) => cpu(&arguments),
        Command::Corners(arguments) => corners(&arguments),
        Command::Render(arguments) => render(&arguments),
        Command::Sweep(arguments) => sweep(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tagbus-bench: {error}");
            ExitCode::from(2)
        }
    }
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
    let conditions = corners::Conditions {
        families: families?,
        factor: arguments.decimate,
        pictures: arguments.pictures,
        blur_sigma: arguments.blur,
        noise_sigma: arguments.noise,
        seed: arguments.seed,
    };
    let table = corners::table(&conditions)?;
    print!("{table}");
    if let Some(path) = &arguments.record {
        let CornersArguments { decimate, blur, noise, seed, .. } = arguments;
        let how = format!(
            "decimation {decimate}, blur sigma {blur} px, noise sigma {noise}, tilt to 30 degrees, seed {seed}"
        );
        record::write_page(path, "Corner errors on rendered tags", &how, &table)?;
    }
    Ok(())
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

fn sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    machine::pin_to(arguments.core)?;
    if arguments.set == arguments::NATURAL {
        return sweep_natural(arguments);
    }
    let recipe = sets::named(&arguments.set)?;
    let repetitions = arguments.count.unwrap_or(recipe.repetitions);
    let count = repetitions * recipe.bins().len();
    let mut lines = Vec::new();
    for name in &arguments.family {
        let renderer = sets::Renderer::new(recipe, Family::published(name)?, arguments.seed);
        lines.extend(sweep::run(&renderer, count, arguments.rounds)?);
    }
    let page = sweep::page(&lines);
    print!("{page}");
    let Some(folder) = &arguments.record else { return Ok(()) };
    let how = format!(
        "set {} ({}), {repetitions} frames of every distance and tilt, seed {}, {} rounds; detectors take turns on each \
         frame, one thread pinned to one core",
        recipe.name, recipe.about, arguments.seed, arguments.rounds
    );
    record_sweep(folder, &recipe, &lines, &how, &page)
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
    let path = |ending: &str| folder.join(format!("{name}{ending}"));
    let figures = format!("![Figure 7]({name}-figure7.svg)\n![Figure 8]({name}-figure8.svg)\n\n{page}");
    record::write_page(&path(".md"), &format!("Sweep of the set {name}"), how, &figures)?;
    std::fs::write(path(".csv"), sweep::csv(lines))?;
    sweep::figure_7(lines, &format!("Speed against recall: {name}"), &path("-figure7.svg"))?;
    sweep::figure_8(lines, &format!("Recall against distance: {name}"), &path("-figure8.svg"))
}

fn sweep_natural(arguments: &SweepArguments) -> Result<(), Failure> {
    let folder = arguments
        .pictures
        .as_deref()
        .ok_or("natural pictures are yours: name their folder with --pictures")?;
    let mut page = String::new();
    for family in &arguments.family {
        page += &sweep::sweep_natural(folder, family, arguments.rounds)?;
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
