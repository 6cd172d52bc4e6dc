//! A folder for one test, removed when it is dropped.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

static COUNT: AtomicU32 = AtomicU32::new(0);

pub(crate) struct TestFolder(PathBuf);

impl TestFolder {
    pub(crate) fn new(purpose: &str) -> TestFolder {
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path =
            std::env::temp_dir().join(format!("tagbus-camera-{purpose}-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        TestFolder(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file and says where it is.
    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, content).unwrap();
        path
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A file of the real data, or `None` with a loud remark where the data is not there.
pub(crate) fn real_data(file: &str) -> Option<PathBuf> {
    let path = std::env::var_os("TAGBUS_TEST_DATA").map(|data| Path::new(&data).join("real").join(file));
    let path = path.filter(|path| path.exists());
    if path.is_none() {
        eprintln!("SKIPPED: TAGBUS_TEST_DATA does not lead to real/{file}");
    }
    path
}
