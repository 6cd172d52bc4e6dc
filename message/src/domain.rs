//! One machine's bus: its name, the directory and the prefix of its files, who may use it, and how it is left clean.

use std::fmt;
use std::fs::DirBuilder;
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use iceoryx2::prelude::{Config, FileName, SemanticString};

use crate::gate::{self, Company, Pass};
use crate::qos;
use crate::sweep;

/// The domain of everybody who names none.
pub const DEFAULT_DOMAIN: &str = "tagbus";
/// Letters that a name of a domain, camera or detector may have.
pub const NAME_LIMIT: usize = 32;

/// Where the system keeps shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Where an administrator makes a directory for a domain of the whole machine.
const SYSTEM_ROOT: &str = "/run/tagbus";
/// Bytes of a Unix socket's path, without its final zero.
const SOCKET_PATH_LIMIT: usize = 107;
/// What iceoryx2 adds to root and prefix for its longest socket: '/', 39 digits, ".event".
const SOCKET_NAME_BYTES: usize = 1 + 39 + 6;

/// A domain: every role that names it (with the same user and the same root) talks to every other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Domain {
    name: String,
    prefix: String,
    root: PathBuf,
    root_text: String,
    keeps_root: bool,
    uid: u32,
}

impl Domain {
    /// The domain of this name, with its root in the first of these places: `/run/tagbus/NAME` if an administrator
    /// made it, `$XDG_RUNTIME_DIR/tagbus/NAME` (`/run/user/UID` when the variable is not set), and
    /// `tagbus-UID/NAME` in the temporary directory.
    ///
    /// Refused when the name has other letters than `a-z0-9_-`, or when that place is another user's.
    pub fn new(name: &str) -> Result<Self, DomainError> {
        check_name(name)?;
        let uid = own_uid().map_err(|error| DomainError::io("/proc/self/status", error))?;
        let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
        let places = Places { system: SYSTEM_ROOT.into(), runtime, temporary: std::env::temp_dir() };
        let (root, keeps_root) = places.choose(name, uid)?;
        Self::build(name, root, keeps_root, uid)
    }

    /// The domain of this name with its files in `root`, an absolute path, which is made when it is not there and
    /// removed with the last role.
    pub fn with_root(name: &str, root: impl Into<PathBuf>) -> Result<Self, DomainError> {
        check_name(name)?;
        let uid = own_uid().map_err(|error| DomainError::io("/proc/self/status", error))?;
        Self::build(name, root.into(), false, uid)
    }

    fn build(name: &str, root: PathBuf, keeps_root: bool, uid: u32) -> Result<Self, DomainError> {
        // An underscore of the name is doubled, so that no domain's prefix is the beginning of another's files.
        let prefix = format!("tb010_{}_", name.replace('_', "__"));
        let Some(root_text) = root.to_str().filter(|_| root.is_absolute()).map(str::to_owned) else {
            return Err(DomainError::RootPath(root));
        };
        let socket_bytes = root_text.len() + prefix.len() + SOCKET_NAME_BYTES;
        if socket_bytes > SOCKET_PATH_LIMIT {
            return Err(DomainError::TooLong { root, prefix, socket_bytes });
        }
        Ok(Self { name: name.to_owned(), prefix, root, root_text, keeps_root, uid })
    }

    /// The domain's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The directory of the domain's small files and sockets.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What the names of the domain's files in shared memory begin with.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// The user of this process, who must be that of every role.
    #[must_use]
    pub fn uid(&self) -> u32 {
        self.uid
    }

    /// What iceoryx2 has to know about the domain.
    pub fn config(&self) -> Result<Config, DomainError> {
        let mut config = Config::default();
        let unusable = || DomainError::RootPath(self.root.clone());
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(|_| unusable())?;
        let root = iceoryx2::prelude::Path::new(self.root_text.as_bytes()).map_err(|_| unusable())?;
        config.global.set_root_path(&root);
        config.global.creation_timeout = qos::CREATION_TIMEOUT;
        Ok(config)
    }

    /// Names of what the domain has left in shared memory. Empty once its last role has ended.
    pub fn leftovers(&self) -> io::Result<Vec<String>> {
        sweep::shared_memory_of(self)
    }

    /// Removes what killed roles left if no role lives. Roles do this by themselves when they start and end; this is
    /// for a supervisor that had to kill the last of them.
    pub fn clean_up_if_unused(&self) -> Result<(), DomainError> {
        let pass = self.enter(Company::Alone)?;
        sweep::end_if_last(self, pass);
        Ok(())
    }

    pub(crate) fn keeps_root(&self) -> bool {
        self.keeps_root
    }

    pub(crate) fn gate_path(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(format!("{}{}", self.prefix, sweep::GATE_NAME))
    }

    /// Passes the gate; an error about a file of another user names both users.
    pub(crate) fn enter(&self, company: Company) -> Result<Pass, DomainError> {
        let path = self.gate_path();
        // A privileged user could open what is not his: so the owner is asked for in any case, and not after waiting.
        check_owner(&path, self.uid)?;
        gate::enter(&path, company).map_err(|error| DomainError::io(path, error))
    }

    /// Makes the root, for this user only, and makes sure that every role has the same one.
    pub(crate) fn prepare(&self, pass: &mut Pass) -> Result<(), DomainError> {
        let gate_path = self.gate_path();
        let agreed = pass.read_root().map_err(|error| DomainError::io(&gate_path, error))?;
        if !agreed.is_empty() && agreed != self.root_text {
            self.take_over(&agreed)?;
        }
        check_owner(&self.root, self.uid)?;
        self.make_root().map_err(|error| DomainError::io(&self.root, error))?;
        check_owner(&self.root, self.uid)?;
        if agreed != self.root_text {
            pass.write_root(&self.root_text).map_err(|error| DomainError::io(gate_path, error))?;
        }
        Ok(())
    }

    /// Another domain that ends may remove the directory above while it is empty: then it is made again.
    fn make_root(&self) -> io::Result<()> {
        let make = || DirBuilder::new().recursive(true).mode(0o700).create(&self.root);
        match make() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => make(),
            made => made,
        }
    }

    /// The domain was last used with another root: fine when nobody is there any more.
    fn take_over(&self, agreed: &str) -> Result<(), DomainError> {
        let other = Self::build(&self.name, agreed.into(), true, self.uid)?;
        if sweep::has_living_nodes(&other) {
            let (here, there) = (self.root.clone(), other.root);
            return Err(DomainError::OtherRoot { domain: self.name.clone(), here, there });
        }
        sweep::remove_leftovers(&other);
        Ok(())
    }
}

/// The places where a root can be.
struct Places {
    system: PathBuf,
    runtime: Option<PathBuf>,
    temporary: PathBuf,
}

impl Places {
    /// The root of a domain, and whether its directory stays when the last role ends.
    fn choose(&self, name: &str, uid: u32) -> Result<(PathBuf, bool), DomainError> {
        let system = self.system.join(name);
        if system.is_dir() {
            check_owner(&system, uid)?;
            return Ok((system, true));
        }
        let of_system = PathBuf::from(format!("/run/user/{uid}"));
        for runtime in self.runtime.iter().chain([&of_system]) {
            if runtime.is_absolute() && owner(runtime).is_some_and(|owner| owner == uid) {
                return Ok((runtime.join("tagbus").join(name), false));
            }
        }
        let own = self.temporary.join(format!("tagbus-{uid}"));
        check_owner(&own, uid)?;
        Ok((own.join(name), false))
    }
}

/// Checks a name of a domain, camera or detector: it becomes a part of file names and topics.
pub fn check_name(name: &str) -> Result<(), DomainError> {
    let allowed =
        |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || "_-".contains(letter);
    if (1..=NAME_LIMIT).contains(&name.len()) && name.chars().all(allowed) {
        Ok(())
    } else {
        Err(DomainError::Name(name.to_owned()))
    }
}

fn owner(path: &Path) -> Option<u32> {
    path.symlink_metadata().ok().map(|metadata| metadata.uid())
}

/// What does not exist has no owner and is fine.
fn check_owner(path: &Path, own: u32) -> Result<(), DomainError> {
    match owner(path) {
        Some(owner) if owner != own => Err(DomainError::OtherOwner { path: path.to_owned(), owner, own }),
        _ => Ok(()),
    }
}

/// The effective user of this process.
fn own_uid() -> io::Result<u32> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("Uid:"));
    line.and_then(|line| line.split_whitespace().nth(1))
        .and_then(|uid| uid.parse().ok())
        .ok_or_else(|| io::Error::other("no line \"Uid:\" in /proc/self/status"))
}

/// Why a domain cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum DomainError {
    /// A name of a domain, camera or detector with letters that are not allowed, or too many of them.
    Name(String),
    /// A root that is not an absolute path in UTF-8.
    RootPath(PathBuf),
    /// Sockets in this root would have too long a path.
    TooLong {
        /// The root.
        root: PathBuf,
        /// The prefix of files.
        prefix: String,
        /// Bytes that the longest path would take.
        socket_bytes: usize,
    },
    /// The domain is another user's.
    OtherOwner {
        /// What the other user owns.
        path: PathBuf,
        /// The other user.
        owner: u32,
        /// The user of this process.
        own: u32,
    },
    /// Roles of the domain run with another root.
    OtherRoot {
        /// The domain.
        domain: String,
        /// The root of this process.
        here: PathBuf,
        /// The root of those that run.
        there: PathBuf,
    },
    /// The world said no.
    Io {
        /// The file that it is about.
        path: PathBuf,
        /// What it said.
        error: io::Error,
    },
}

impl DomainError {
    fn io(path: impl Into<PathBuf>, error: io::Error) -> Self {
        Self::Io { path: path.into(), error }
    }
}

impl fmt::Display for DomainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(
                f,
                "the name \"{name}\" is not possible: use 1 to {NAME_LIMIT} of the letters a-z, 0-9, _ and -"
            ),
            Self::RootPath(root) => {
                write!(f, "{} cannot be a domain's directory: name an absolute path", root.display())
            }
            Self::TooLong { root, prefix, socket_bytes } => write!(
                f,
                "sockets in {} with names that begin with {prefix} take {socket_bytes} bytes of path but Linux allows {SOCKET_PATH_LIMIT}: use a shorter domain name or directory",
                root.display()
            ),
            Self::OtherOwner { path, owner, own } => write!(
                f,
                "{} belongs to uid {owner} but this process runs as uid {own}, and all roles of a domain must run under one uid: run this as uid {owner} (sudo -u '#{owner}', or User= in its systemd unit), or use another --domain",
                path.display()
            ),
            Self::OtherRoot { domain, here, there } => write!(
                f,
                "domain {domain} is running in {} but this process would use {}: give all its roles the same XDG_RUNTIME_DIR and directory, or use another --domain",
                there.display(),
                here.display()
            ),
            Self::Io { path, error } => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl std::error::Error for DomainError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("tagbus-domain-{}-{name}", std::process::id()))
    }

    #[test]
    fn names_are_checked() {
        for name in ["a", "cam0", "left_eye-2", &"x".repeat(32)] {
            assert!(check_name(name).is_ok(), "{name}");
        }
        for name in ["", "A", "a/b", "a b", "ä", "..", &"x".repeat(33)] {
            assert!(check_name(name).unwrap_err().to_string().contains(name), "{name}");
        }
    }

    #[test]
    fn no_domain_has_a_prefix_that_begins_another_domains_files() {
        let prefix = |name| Domain::with_root(name, "/tmp/t").unwrap().prefix;
        assert_eq!(prefix("tagbus"), "tb010_tagbus_");
        let (short, long) = (prefix("a"), prefix("a_b"));
        assert!(long.strip_prefix(&short).unwrap().starts_with('_'));
    }

    #[test]
    fn a_root_that_is_too_long_for_sockets_is_refused_with_the_numbers() {
        let error = Domain::with_root("a", format!("/{}", "r".repeat(60))).unwrap_err().to_string();
        assert!(error.contains("115 bytes") && error.contains("107"), "{error}");
        assert!(Domain::with_root("a", "relative").is_err());
    }

    #[test]
    fn the_first_place_that_is_ours_is_taken() {
        let uid = own_uid().unwrap();
        let base = scratch("places");
        let places = Places {
            system: base.join("system"),
            runtime: Some(base.join("runtime")),
            temporary: base.join("temporary"),
        };
        std::fs::create_dir_all(base.join("runtime")).unwrap();
        assert_eq!(places.choose("d", uid).unwrap(), (base.join("runtime/tagbus/d"), false));
        std::fs::create_dir_all(base.join("system/d")).unwrap();
        assert_eq!(places.choose("d", uid).unwrap(), (base.join("system/d"), true));
        std::fs::remove_dir_all(&base).unwrap();
    }

    #[test]
    fn another_users_directory_is_refused_with_both_uids() {
        let directory = scratch("other");
        std::fs::create_dir_all(&directory).unwrap();
        let own = own_uid().unwrap();
        if std::os::unix::fs::chown(&directory, Some(12345), None).is_err() {
            eprintln!("SKIPPED: only root can give a directory to another user");
        } else {
            let domain = Domain::with_root("other-owner", &directory).unwrap();
            let mut pass = domain.enter(Company::Alone).unwrap();
            let error = domain.prepare(&mut pass).unwrap_err().to_string();
            assert!(error.contains("uid 12345") && error.contains(&format!("uid {own}")), "{error}");
            std::os::unix::fs::chown(domain.gate_path(), Some(12345), None).unwrap();
            let refused = domain.enter(Company::Shared).err().unwrap().to_string();
            assert!(refused.contains("uid 12345") && refused.contains("--domain"), "{refused}");
            pass.remove().unwrap();
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
