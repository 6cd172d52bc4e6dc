//! What a service is told at its start.

use std::fmt;
use std::ops::Range;

use tagbus_detector::{LumaView, Settings};
use tagbus_family::Family;
use tagbus_message::control::Region;
use tagbus_message::domain::Domain;
use tagbus_message::frame::FrameHeader;
use tagbus_message::qos;

use crate::report::Report;

/// Is told what a user may want to know.
pub type Reporter = Box<dyn FnMut(&Report) + Send>;
/// Is shown frames just before they are searched.
pub type Observer = Box<dyn FnMut(&FrameSeen) + Send>;

/// Is told of moments on the way of a frame.
pub type Watch = Box<dyn FnMut(Moment) + Send>;

/// The ends of what lies between a frame's arrival and its message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// The service is about to take the newest frame; there may be none.
    Receive,
    /// A message was sent; nobody was woken for it yet.
    Sent,
}

/// Everything that a service needs to know.
pub struct ServiceConfig {
    /// The machine's bus.
    pub domain: Domain,
    /// Name of the camera whose frames are searched.
    pub camera: String,
    /// Name of this detector.
    pub detector: String,
    /// Families searched for; at least one.
    pub families: Vec<Family>,
    /// How they are searched for.
    pub settings: Settings,
    /// The part of each frame that is searched, in its pixels; `None` for the whole frame.
    pub region: Option<Region>,
    /// Whether frames are searched even when nobody subscribes; otherwise searching pauses until somebody does.
    pub always: bool,
    /// Tags that a message has room for, 1 to 65,536. Costs memory: 243 messages of 512 bytes a tag are reserved.
    pub max_tags: usize,
    /// Told of problems, never more often than once a second for the same kind, and of changes, ten a second.
    pub report: Reporter,
    /// Shown every frame just before it is searched; for tests and measurements.
    pub observer: Option<Observer>,
    /// Told when a frame is about to be taken and when its message was sent; for measurements.
    pub watch: Option<Watch>,
}

/// What the detector is about to read.
pub struct FrameSeen<'a> {
    /// The frame's header, checked.
    pub header: &'a FrameHeader,
    /// What the detector reads.
    pub view: &'a LumaView<'a>,
    /// Where the frame's payload lies in this process.
    pub payload: Range<*const u8>,
}

impl ServiceConfig {
    /// Detector `main` of camera `cam0` with default settings; reports go nowhere.
    #[must_use]
    pub fn new(domain: Domain, families: Vec<Family>) -> Self {
        Self {
            domain,
            camera: "cam0".to_owned(),
            detector: "main".to_owned(),
            families,
            settings: Settings::default(),
            region: None,
            always: false,
            max_tags: qos::DEFAULT_MAX_TAGS,
            report: Box::new(|_| ()),
            observer: None,
            watch: None,
        }
    }
}

impl fmt::Debug for ServiceConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let families: Vec<_> = self.families.iter().map(Family::name).collect();
        f.debug_struct("ServiceConfig")
            .field("domain", &self.domain)
            .field("camera", &self.camera)
            .field("detector", &self.detector)
            .field("families", &families)
            .field("settings", &self.settings)
            .field("region", &self.region)
            .field("always", &self.always)
            .field("max_tags", &self.max_tags)
            .finish_non_exhaustive()
    }
}
