//! A client as a process of its own. It ends when its standard input does, so it never outlives whoever started it.

use std::io::{self, Read};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use tagbus_client::{Client, ConnectOptions, Domain, Stop};

use super::tally::Tally;
use crate::Failure;

/// How long a slow client works on each message.
const SLOW: Duration = Duration::from_millis(50);
/// Detector and camera were started just before.
const PATIENCE: Duration = Duration::from_secs(30);

/// How a client behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub(crate) enum Temper {
    /// Takes each message as it comes.
    Honest,
    /// Works on each message for 50 ms.
    Slow,
    /// Takes one message, keeps it and never comes again.
    Stuck,
    /// Takes each message and counts nothing else: what it listens to may lie.
    Misled,
}

/// Whom to listen to, and how.
#[derive(clap::Args)]
pub(crate) struct Order {
    #[arg(long)]
    pub(crate) domain: String,
    #[arg(long)]
    pub(crate) root: PathBuf,
    #[arg(long)]
    pub(crate) camera: String,
    #[arg(long)]
    pub(crate) detector: String,
    #[arg(long)]
    pub(crate) temper: Temper,
}

/// Listens until the standard input ends, then writes what it counted as one line.
pub(crate) fn client(order: &Order) -> Result<(), Failure> {
    let stop = Stop::new()?;
    let at_end = stop.clone();
    thread::spawn(move || {
        let _ = io::stdin().read_to_end(&mut Vec::new());
        at_end.trigger();
    });
    let domain = Domain::with_root(&order.domain, &order.root)?;
    let options = ConnectOptions::in_domain(domain)
        .camera(&order.camera)
        .detector(&order.detector)
        .deadline(PATIENCE)
        .stop(stop.clone());
    let mut client = Client::connect(&options)?;
    let tally = listen(&mut client, order.temper, &stop)?;
    println!("{}", tally.line());
    Ok(())
}

fn listen(client: &mut Client, temper: Temper, stop: &Stop) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    while !stop.is_triggered() {
        let Some(message) = client.receive(Duration::from_secs(1))? else { continue };
        match temper {
            Temper::Misled => tally.count(&message),
            _ => tally.take(&message),
        }
        match temper {
            Temper::Honest | Temper::Misled => {}
            Temper::Slow => drop(stop.wait(SLOW)),
            Temper::Stuck => while !stop.wait(Duration::from_secs(3600)) {},
        }
    }
    Ok(tally)
}
