//! An attacker as a process of its own. It ends when its standard input does.

use std::io::{self, Read};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use iceoryx2::prelude::ipc;
use tagbus_client::{Client, ConnectOptions, Domain, Stop};
use tagbus_message::bus::{Bus, Patience};
use tagbus_message::ports::{DetectionsIn, FramesIn};
use tagbus_message::qos;
use tagbus_scene::Stream;

use super::lies;
use crate::Failure;

/// The camera and the detector that an attacker claims for itself.
pub(super) const OWN: &str = "evil";
/// Bytes of the largest payload of the hostile camera.
const MAX_BYTES: usize = 64 * 1024;
/// Tags of the longest message of the hostile detector.
const MAX_TAGS: usize = 64;
/// Mean pause between two messages of a hostile publisher: 200 a second.
const PAUSE: Duration = Duration::from_millis(5);
/// Subscribers of whoever hoards or never reads, of detections and of frames. Some places are left for others.
const IDLE: [usize; 2] = [24, 3];
/// What is attacked is there already.
const DEADLINE: Duration = Duration::from_secs(20);

/// What an attacker does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Attack {
    /// Publishes frames that lie, as a camera of its own that the same process detects in.
    Frames,
    /// Publishes detections that lie, as a detector of its own that an honest client listens to.
    Detections,
    /// Borrows all that subscribers can, and never gives it back.
    Hoard,
    /// Subscribes and never receives.
    Deaf,
    /// Sends requests to detector and camera as fast as it can, and takes no answer.
    Requests,
    /// Comes onto the bus, subscribes and leaves, as fast as it can.
    Visits,
}

impl Attack {
    pub(crate) const ALL: [Self; 6] =
        [Self::Frames, Self::Detections, Self::Hoard, Self::Deaf, Self::Requests, Self::Visits];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Frames => "frames",
            Self::Detections => "detections",
            Self::Hoard => "hoard",
            Self::Deaf => "deaf",
            Self::Requests => "requests",
            Self::Visits => "visits",
        }
    }
}

/// How an attacker behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Manner {
    /// Attacks.
    Hostile,
    /// Does as much in a domain of its own; as a publisher, tells the truth in the same. What that costs others is the machine's doing.
    Tame,
}

/// Whom to attack, and how.
#[derive(clap::Args)]
pub(crate) struct AttackOrder {
    #[arg(long)]
    pub(crate) domain: String,
    #[arg(long)]
    pub(crate) root: PathBuf,
    #[arg(long)]
    pub(crate) attack: Attack,
    #[arg(long)]
    pub(crate) manner: Manner,
    #[arg(long)]
    pub(crate) seed: u64,
}

type Local = ipc::Service;

/// Attacks until the standard input ends, then writes how often.
pub(crate) fn attack(order: &AttackOrder) -> Result<(), Failure> {
    let stop = Stop::new()?;
    let at_end = stop.clone();
    thread::spawn(move || {
        let _ = io::stdin().read_to_end(&mut Vec::new());
        at_end.trigger();
    });
    let honest = Domain::with_root(&order.domain, &order.root)?;
    let is_publisher = matches!(order.attack, Attack::Frames | Attack::Detections);
    let count = if order.manner == Manner::Tame && !is_publisher {
        let own = Domain::with_root(&format!("{}x", order.domain), order.root.with_extension("x"))?;
        let victims = Victims::new(&own, &stop)?;
        let count = Attacker::new(order, own, &stop)?.work(order.attack);
        drop(victims);
        count?
    } else {
        Attacker::new(order, honest, &stop)?.work(order.attack)?
    };
    println!("{count}");
    Ok(())
}

/// Topics for whoever attacks nobody; nobody serves them.
struct Victims {
    _topics: Box<dyn std::any::Any>,
}

impl Victims {
    fn new(domain: &Domain, stop: &Stop) -> Result<Self, Failure> {
        let bus = Bus::<Local>::start(domain, "victims", stop)?;
        let topics = (
            bus.create_frames("cam0", &qos::FRAMES, MAX_BYTES)?,
            bus.create_detections("cam0", "main", MAX_TAGS)?,
            bus.create_detector_control("cam0", "main")?,
            bus.create_camera_control("cam0")?,
        );
        Ok(Self { _topics: Box::new(topics) })
    }
}

struct Attacker {
    domain: Domain,
    stop: Stop,
    is_tame: bool,
    random: Stream,
}

impl Attacker {
    fn new(order: &AttackOrder, domain: Domain, stop: &Stop) -> Result<Self, Failure> {
        let is_tame = order.manner == Manner::Tame;
        Ok(Self { domain, stop: stop.clone(), is_tame, random: Stream::new(order.seed) })
    }

    /// How often it did what it does.
    fn work(mut self, attack: Attack) -> Result<u64, Failure> {
        match attack {
            Attack::Frames => self.publish_frames(),
            Attack::Detections => self.publish_detections(),
            Attack::Hoard | Attack::Deaf => self.subscribe(attack),
            Attack::Requests => self.request(),
            Attack::Visits => self.visit(),
        }
    }

    fn bus(&self) -> Result<Bus<Local>, Failure> {
        Ok(Bus::start(&self.domain, "attacker", &self.stop)?)
    }

    /// Sleeps between nothing and twice the mean pause: at equal distances from the honest frames, which come regularly, some would always
    /// meet a processor that is awake, and others never.
    fn has_to_stop(&mut self) -> bool {
        let pause = PAUSE.mul_f64(2.0 * self.random.below(1024) as f64 / 1024.0);
        self.stop.wait(pause)
    }

    fn publish_frames(&mut self) -> Result<u64, Failure> {
        let out = self.bus()?.create_frames(OWN, &qos::FRAMES, MAX_BYTES)?;
        let noise: Vec<u8> = (0..MAX_BYTES).map(|_| self.random.bits() as u8).collect();
        let mut count = 0;
        while !self.has_to_stop() {
            let honest = lies::honest_header(count)?;
            let (header, length) = match self.is_tame {
                true => (honest, honest.bytes_used as usize),
                // As often the right length as any other.
                false => (
                    lies::frame_header(honest, &mut self.random),
                    match self.random.below(2) {
                        0 => honest.bytes_used as usize,
                        _ => self.random.below(MAX_BYTES as u64) as usize,
                    },
                ),
            };
            let mut loan = out.publisher().loan_slice_uninit(length)?.write_from_slice(&noise[..length]);
            *loan.user_header_mut() = header;
            loan.send()?;
            out.notify()?;
            count += 1;
        }
        Ok(count)
    }

    fn publish_detections(&mut self) -> Result<u64, Failure> {
        let out = self.bus()?.create_detections("cam0", OWN, MAX_TAGS)?;
        let mut count = 0;
        while !self.has_to_stop() {
            let mut header = lies::detections_header(&mut self.random);
            let tags: Vec<_> =
                (0..self.random.below(MAX_TAGS as u64)).map(|_| lies::tag(&mut self.random)).collect();
            if self.is_tame {
                header.schema = tagbus_message::detection::DETECTIONS_SCHEMA;
                (header.count, header.found) = (tags.len() as u32, tags.len() as u32);
            }
            let mut loan = out.publisher().loan_slice_uninit(tags.len())?.write_from_slice(&tags);
            *loan.user_header_mut() = header;
            loan.send()?;
            out.notify()?;
            count += 1;
        }
        Ok(count)
    }

    /// Opens many subscribers and, to hoard, takes from each all that it can hold.
    fn subscribe(&mut self, attack: Attack) -> Result<u64, Failure> {
        let bus = self.bus()?;
        let patience = Patience::AtMost(DEADLINE);
        let mut detections: Vec<DetectionsIn<Local>> = Vec::new();
        let mut frames: Vec<FramesIn<Local>> = Vec::new();
        for _ in 0..IDLE[0] {
            detections.push(bus.open_detections("cam0", "main", patience)?);
        }
        for _ in 0..IDLE[1] {
            frames.push(bus.open_frames("cam0", qos::FRAMES.buffer, patience)?);
        }
        let (mut kept_detections, mut kept_frames) = (Vec::new(), Vec::new());
        while !self.has_to_stop() {
            if attack == Attack::Hoard {
                // That it may hold no more is the end of it.
                kept_detections.extend(detections.iter().filter_map(|input| input.receive().ok().flatten()));
                kept_frames.extend(frames.iter().filter_map(|input| input.receive().ok().flatten()));
            }
        }
        Ok(match attack {
            Attack::Hoard => (kept_detections.len() + kept_frames.len()) as u64,
            _ => (detections.len() + frames.len()) as u64,
        })
    }

    fn request(&mut self) -> Result<u64, Failure> {
        let bus = self.bus()?;
        let patience = Patience::AtMost(DEADLINE);
        let detector = bus.open_detector_control("cam0", "main", patience)?;
        let camera = bus.open_camera_control("cam0", patience)?;
        let mut count = 0;
        while !self.stop.is_triggered() {
            // What cannot be sent now is sent the next time.
            if let Some(request) = lies::detector_request(&mut self.random) {
                count += u64::from(detector.ask(&request).is_ok());
            }
            if let Some(request) = lies::camera_request(&mut self.random) {
                count += u64::from(camera.ask(&request).is_ok());
            }
        }
        Ok(count)
    }

    fn visit(&mut self) -> Result<u64, Failure> {
        let options = ConnectOptions::in_domain(self.domain.clone()).deadline(DEADLINE);
        let mut count = 0;
        while !self.stop.is_triggered() {
            let mut client = Client::connect(&options)?;
            drop(client.receive(Duration::ZERO)?);
            count += 1;
        }
        Ok(count)
    }
}
