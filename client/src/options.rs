//! Whom to listen to.

use std::path::PathBuf;
use std::time::Duration;

use tagbus_message::domain::{Domain, DomainError};
use tagbus_message::stop::Stop;

/// Which detector (or camera) to listen to, and how long to wait for it.
#[derive(Clone, Debug)]
pub struct ConnectOptions {
    /// The machine's bus; must be that of camera and detector.
    pub domain: Domain,
    /// Name of the camera.
    pub camera: String,
    /// Name of the detector at that camera.
    pub detector: String,
    /// What the client calls itself where clients are listed: the program's name unless it is told another.
    pub name: String,
    /// How long connecting may take; `None` waits until the other side comes.
    pub deadline: Option<Duration>,
    /// How long a message is kept back after it was received: what shows whether latencies are measured right.
    pub delay: Duration,
    /// What ends waiting from another thread, if there is something.
    pub stop: Option<Stop>,
}

impl ConnectOptions {
    /// Detector `main` of camera `cam0` in the domain of this name (`tagbus` unless the others were told another),
    /// however long it takes.
    pub fn new(domain: &str) -> Result<Self, DomainError> {
        Ok(Self::in_domain(Domain::new(domain)?))
    }

    /// As [`ConnectOptions::new`] in a domain that is there already.
    #[must_use]
    pub fn in_domain(domain: Domain) -> Self {
        let (camera, detector) = ("cam0".to_owned(), "main".to_owned());
        Self {
            domain,
            camera,
            detector,
            name: program_name(),
            deadline: None,
            delay: Duration::ZERO,
            stop: None,
        }
    }

    /// Another name where clients are listed; what is longer than 64 bytes is cut.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        name.clone_into(&mut self.name);
        self
    }

    /// Another camera.
    #[must_use]
    pub fn camera(mut self, name: &str) -> Self {
        name.clone_into(&mut self.camera);
        self
    }

    /// Another detector.
    #[must_use]
    pub fn detector(mut self, name: &str) -> Self {
        name.clone_into(&mut self.detector);
        self
    }

    /// A limit to waiting for the other side.
    #[must_use]
    pub fn deadline(mut self, deadline: Duration) -> Self {
        self.deadline = Some(deadline);
        self
    }

    /// Ends waiting when this is triggered.
    #[must_use]
    pub fn stop(mut self, stop: Stop) -> Self {
        self.stop = Some(stop);
        self
    }
}

/// The file name of the running program.
fn program_name() -> String {
    let path = std::env::args_os().next().map(PathBuf::from).unwrap_or_default();
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
