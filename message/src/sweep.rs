//! What a domain leaves behind, and its removal: by the last role that ends, the first that starts, and on healing.

use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use iceoryx2::prelude::{CallbackProgression, Node, NodeState, ipc};

use crate::domain::{Domain, SHARED_MEMORY};
use crate::gate::Pass;
use crate::qos;

/// What follows the prefix in the name of the gate's file.
pub(crate) const GATE_NAME: &str = "gate";
/// iceoryx2's directories within a root.
const SERVICES: &str = "services";
const NODES: &str = "nodes";
/// Bytes of the unit in which Linux counts a file's room.
const BLOCK: u64 = 512;
/// Owner may write: iceoryx2 takes this bit away when a topic's description is complete.
const OWNER_WRITE: u32 = 0o200;

/// Whether a role of the domain lives. What cannot be judged counts as living: then nothing is removed.
pub(crate) fn has_living_nodes(domain: &Domain) -> bool {
    if !domain.root().join(NODES).is_dir() {
        return false;
    }
    let Ok(config) = domain.config() else { return true };
    let mut living = false;
    let listed = Node::<ipc::Service>::list(&config, |state| {
        living |= matches!(state, NodeState::Alive(_) | NodeState::Inaccessible(_));
        if living { CallbackProgression::Stop } else { CallbackProgression::Continue }
    });
    living || listed.is_err()
}

/// Ends the domain if its last role has ended: nothing stays in shared memory or in the root.
///
/// The caller is alone at the gate, so no role is half way through its start.
pub(crate) fn end_if_last(domain: &Domain, pass: Pass) {
    if has_living_nodes(domain) {
        return;
    }
    remove_leftovers(domain);
    // Whoever finds the directory gone, or not empty, has been faster or needs it: both are fine.
    if !domain.keeps_root() && fs::remove_dir(domain.root()).is_ok() {
        remove_default_parent(domain);
    }
    let _ = pass.remove();
}

/// `tagbus` or `tagbus-UID`, which only this crate makes; not empty while another domain uses it.
fn remove_default_parent(domain: &Domain) {
    let Some(parent) = domain.root().parent() else { return };
    let name = parent.file_name().and_then(OsStr::to_str).unwrap_or_default();
    if name == "tagbus" || name == format!("tagbus-{}", domain.uid()) {
        let _ = fs::remove_dir(parent);
    }
}

/// Removes every file of a domain in which nobody lives, but not its root and its gate.
pub(crate) fn remove_leftovers(domain: &Domain) {
    for name in shared_memory_of(domain).unwrap_or_default() {
        if name != format!("{}{GATE_NAME}", domain.prefix()) {
            let _ = fs::remove_file(Path::new(SHARED_MEMORY).join(name));
        }
    }
    let root = domain.root();
    for node in entries(&root.join(NODES)) {
        // A node keeps its details in a directory named by its number.
        if node.file_name().to_str().is_some_and(|name| name.bytes().all(|byte| byte.is_ascii_digit())) {
            remove_directory(domain, &node.path());
        }
    }
    remove_directory(domain, &root.join(NODES));
    remove_directory(domain, &root.join(SERVICES));
    remove_files(domain, root);
}

fn remove_directory(domain: &Domain, directory: &Path) {
    remove_files(domain, directory);
    let _ = fs::remove_dir(directory);
}

fn remove_files(domain: &Domain, directory: &Path) {
    for entry in entries(directory).filter(|entry| is_of(domain, &entry.file_name())) {
        let _ = fs::remove_file(entry.path());
    }
}

/// Names of the domain's files in shared memory, of this user only.
pub(crate) fn shared_memory_of(domain: &Domain) -> io::Result<Vec<String>> {
    let own = |entry: &DirEntry| entry.metadata().is_ok_and(|metadata| metadata.uid() == domain.uid());
    let names = fs::read_dir(SHARED_MEMORY)?
        .filter_map(Result::ok)
        .filter(|entry| is_of(domain, &entry.file_name()) && own(entry))
        .filter_map(|entry| entry.file_name().into_string().ok());
    Ok(names.collect())
}

/// The domain's shared memory file with this end of its name.
pub(crate) fn file_of(domain: &Domain, end: &str) -> Option<PathBuf> {
    let name = shared_memory_of(domain).ok()?.into_iter().find(|name| name.ends_with(end))?;
    Some(Path::new(SHARED_MEMORY).join(name))
}

/// Room that a file in shared memory takes.
pub(crate) fn bytes_in_use(file: &Path) -> Option<u64> {
    Some(fs::metadata(file).ok()?.blocks() * BLOCK)
}

/// Removes descriptions of topics that nobody will ever complete or use, which iceoryx2 does not do by itself:
/// a creator that is killed leaves one that can be written still, and everybody who opens it waits for ever.
///
/// The caller is alone at the gate, so no role of ours is making a topic. A description that is younger than iceoryx2's
/// own patience may be in work by a foreign program.
pub(crate) fn heal(domain: &Domain) {
    for entry in entries(&domain.root().join(SERVICES)) {
        let Ok(metadata) = entry.metadata() else { continue };
        let age = metadata.modified().ok().and_then(|time| time.elapsed().ok()).unwrap_or_default();
        let incomplete = metadata.mode() & OWNER_WRITE != 0;
        if is_of(domain, &entry.file_name())
            && age >= qos::CREATION_TIMEOUT
            && (incomplete
                || !is_tagged(domain, &entry.file_name())
                || lost_its_memory(domain, &entry.path()))
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether what a complete description stands for was removed from shared memory by force: nobody can open that topic any more.
fn lost_its_memory(domain: &Domain, description: &Path) -> bool {
    let number = fs::read_to_string(description).ok().and_then(|text| number_of(&text));
    number.is_some_and(|number| {
        let end = format!("_{number}.dynamic");
        shared_memory_of(domain).is_ok_and(|names| !names.iter().any(|name| name.ends_with(&end)))
    })
}

/// The number of a topic in the names of its files: the two parts of its `unique_service_id`.
fn number_of(description: &str) -> Option<u128> {
    let part = |name: &str| -> Option<u128> {
        let line = description.lines().find_map(|line| line.trim().strip_prefix(name))?;
        line.trim().strip_prefix('=')?.trim().parse::<u64>().ok().map(u128::from)
    };
    Some(part("unique_value")? << 64 | part("payload_value")?)
}

/// Whether a node, alive or not yet cleaned up, says that it uses the topic with this description.
fn is_tagged(domain: &Domain, description: &OsStr) -> bool {
    let tag = Path::new(description).with_extension("service_tag");
    entries(&domain.root().join(NODES)).any(|node| node.path().join(&tag).exists())
}

/// The prefix is followed by a number or a hash, or by the gate's name; never by an underscore (see [`Domain`]).
fn is_of(domain: &Domain, name: &OsStr) -> bool {
    let rest = name.to_str().and_then(|name| name.strip_prefix(domain.prefix()));
    rest.is_some_and(|rest| !rest.starts_with('_'))
}

fn entries(directory: &Path) -> impl Iterator<Item = DirEntry> {
    fs::read_dir(directory).into_iter().flatten().filter_map(Result::ok)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::time::{Duration, SystemTime};

    fn domain(name: &str) -> Domain {
        let name = format!("{name}{}", std::process::id());
        let domain = Domain::with_root(&name, std::env::temp_dir().join(&name)).unwrap();
        fs::create_dir_all(domain.root().join(SERVICES)).unwrap();
        fs::create_dir_all(domain.root().join(NODES).join("123")).unwrap();
        domain
    }

    fn old_description(domain: &Domain, hash: &str, mode: u32) -> std::path::PathBuf {
        let path = domain.root().join(SERVICES).join(format!("{}{hash}.service", domain.prefix()));
        let file = fs::File::create(&path).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(3)).unwrap();
        file.set_permissions(fs::Permissions::from_mode(mode)).unwrap();
        path
    }

    #[test]
    fn healing_removes_what_nobody_will_complete_and_nothing_else() {
        let domain = domain("heal");
        let incomplete = old_description(&domain, "aa", 0o600);
        let orphaned = old_description(&domain, "bb", 0o400);
        let used = old_description(&domain, "cc", 0o400);
        let tag = format!("{}cc.service_tag", domain.prefix());
        fs::write(domain.root().join(NODES).join("123").join(tag), "").unwrap();
        let young = domain.root().join(SERVICES).join(format!("{}dd.service", domain.prefix()));
        let file = fs::File::create(&young).unwrap();
        file.set_modified(SystemTime::now() + Duration::from_secs(60)).unwrap();
        heal(&domain);
        assert!(!incomplete.exists() && !orphaned.exists());
        assert!(used.exists() && young.exists());
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn a_description_is_healed_away_when_its_memory_was_removed() {
        let domain = domain("lost");
        let describe = |hash: &str, value: u64| {
            let path = domain.root().join(SERVICES).join(format!("{}{hash}.service", domain.prefix()));
            fs::write(&path, format!("[unique_service_id]\npayload_value = {value}\nunique_value = 1\n"))
                .unwrap();
            let file = fs::File::open(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(3)).unwrap();
            file.set_permissions(fs::Permissions::from_mode(0o400)).unwrap();
            let tag = format!("{}{hash}.service_tag", domain.prefix());
            fs::write(domain.root().join(NODES).join("123").join(tag), "").unwrap();
            path
        };
        let (kept, lost) = (describe("aa", 5), describe("bb", 6));
        let memory = format!("{}ff_{}.dynamic", domain.prefix(), (1u128 << 64) + 5);
        let memory = Path::new(SHARED_MEMORY).join(memory);
        fs::write(&memory, "x").unwrap();
        heal(&domain);
        assert!(kept.exists() && !lost.exists());
        fs::remove_file(memory).unwrap();
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn a_domain_without_life_is_removed_and_strangers_files_stay() {
        let domain = domain("ends");
        old_description(&domain, "aa", 0o400);
        let stranger = domain.root().join("thesis.txt");
        fs::write(&stranger, "mine").unwrap();
        let shared = Path::new(SHARED_MEMORY).join(format!("{}1_2.connection", domain.prefix()));
        let neighbour = Path::new(SHARED_MEMORY).join(format!("{}_b_1.data", domain.prefix()));
        fs::write(&shared, "x").unwrap();
        fs::write(&neighbour, "x").unwrap();
        domain.clean_up_if_unused().unwrap();
        assert!(!shared.exists() && neighbour.exists() && stranger.exists());
        assert!(domain.leftovers().unwrap().is_empty());
        assert!(!domain.root().join(SERVICES).exists());
        fs::remove_file(neighbour).unwrap();
        fs::remove_dir_all(domain.root()).unwrap();
    }
}
