//! The configuration file: where it is looked for, and that it has no unknown keys.

use std::env;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tagbus_family::nearest_name;
use toml::Table;

/// Where it lies below a directory for configuration.
const NAME: &str = "tagbus/tagbus.toml";
/// The directory for the whole machine.
const SYSTEM: &str = "/etc";

/// The table of a whole machine's cameras, which is no flag.
pub(super) const MACHINE: &str = "cameras";

/// The configuration file, or an empty one where there is none.
#[derive(Debug, Default)]
pub(crate) struct File {
    /// Where it was read.
    pub(crate) path: Option<PathBuf>,
    /// Its keys.
    pub(crate) keys: Table,
}

impl File {
    /// The file that was named, else the first of the usual places that has one.
    pub(crate) fn find(named: Option<&Path>, known: &[String]) -> Result<Self, FileError> {
        match named {
            Some(path) => Self::read(path, known),
            None => match usual_places().into_iter().find(|path| path.is_file()) {
                Some(path) => Self::read(&path, known),
                None => Ok(Self::default()),
            },
        }
    }

    /// The same file as it is now.
    pub(crate) fn again(&self, known: &[String]) -> Result<Self, FileError> {
        self.path.as_ref().map_or_else(|| Ok(Self::default()), |path| Self::read(path, known))
    }

    fn read(path: &Path, known: &[String]) -> Result<Self, FileError> {
        let io_error = |error| FileError::Io { path: path.to_owned(), error };
        let text = fs::read_to_string(path).map_err(io_error)?;
        let syntax = |error| FileError::Syntax { path: path.to_owned(), error };
        let keys: Table = text.parse().map_err(syntax)?;
        match keys.keys().find(|&key| key != MACHINE && !known.contains(key)) {
            Some(key) => Err(FileError::unknown_key(path, key, known)),
            None => Ok(Self { path: Some(path.to_owned()), keys }),
        }
    }
}

/// The user's place and then the machine's.
fn usual_places() -> Vec<PathBuf> {
    let absolute = |variable| env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let user = absolute("XDG_CONFIG_HOME").or_else(|| absolute("HOME").map(|home| home.join(".config")));
    user.into_iter().chain([PathBuf::from(SYSTEM)]).map(|directory| directory.join(NAME)).collect()
}

/// Why a configuration file was refused.
#[derive(Debug)]
pub(crate) enum FileError {
    /// It cannot be read.
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It is no TOML.
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        error: toml::de::Error,
    },
    /// A key that is no flag.
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// The key.
        key: String,
        /// The key that was probably meant.
        nearest: String,
    },
}

impl FileError {
    fn unknown_key(path: &Path, key: &str, known: &[String]) -> Self {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let nearest = nearest_name(key, &known).unwrap_or_default().to_owned();
        Self::UnknownKey { path: path.to_owned(), key: key.to_owned(), nearest }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: cannot be read: {error}", path.display()),
            Self::Syntax { path, error } => write!(f, "{}: {}", path.display(), error.to_string().trim_end()),
            Self::UnknownKey { path, key, nearest } => {
                write!(f, "{}: unknown key \"{key}\", did you mean {nearest}?", path.display())
            }
        }
    }
}

impl std::error::Error for FileError {}
