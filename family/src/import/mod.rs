//! Tables of other programs become families: pure functions of their text.
//!
//! Three forms are read: the C tables of the AprilTag library ([`Format::C`], also those of AprilTag 2), the Java
//! classes of the tag generators ([`Format::Java`]) and dictionaries of OpenCV in YAML or JSON ([`Format::OpenCv`]).
//! What a table states about its distance is not believed but measured.
//!
//! ```
//! use tagbus_family::import;
//!
//! let java = "public class Tag16h5 extends TagFamily { public Tag16h5() { super(16, 5, new long[] { 0x231bL, 0x2ea5L }); } }";
//! let imported = import::read(java, None, "mine")?;
//! assert_eq!((imported.family.name(), imported.family.codes().len()), ("tag16h5", 2));
//! assert_eq!((imported.stated_distance, imported.family.distance()), (Some(5), 7));
//! # Ok::<(), tagbus_family::import::ImportError>(())
//! ```

mod tokens;

mod read;
pub use read::{Format, Imported, read};

mod cells;

mod c_table;
mod java;
mod opencv;

mod error;
pub use error::{ImportError, Problem};
