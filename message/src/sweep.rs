//! What a domain leaves behind, and its removal: by the last role that ends, the first that starts, and on healing.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, DirEntry, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::NodeView;
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
/// Owner may read: iceoryx2 adds this bit when a node's monitor is complete.
const OWNER_READ: u32 = 0o400;

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

/// The file that describes the topic of this hash.
pub(crate) fn description_of(domain: &Domain, hash: &str) -> PathBuf {
    domain.root().join(SERVICES).join(format!("{}{hash}.service", domain.prefix()))
}

/// Removes descriptions of topics that nobody will ever complete or use, which iceoryx2 does not do by itself:
///
/// * A creator that is killed leaves one that can be written still, and everybody who opens it waits for ever.
/// * The last user that is killed between marking the topic for removal and removing it leaves one that nobody can open.
///
/// The caller is alone at the gate, so no role of ours is making a topic. A description that is younger than iceoryx2's
/// own patience may be in work by a foreign program.
pub(crate) fn heal(domain: &Domain) {
    for entry in entries(&domain.root().join(SERVICES)) {
        let Ok(metadata) = entry.metadata() else { continue };
        let incomplete = metadata.mode() & OWNER_WRITE != 0;
        if !is_of(domain, &entry.file_name()) || age(&metadata) < qos::CREATION_TIMEOUT {
            continue;
        }
        let memory = memory_of(domain, &entry.path());
        if incomplete || !is_tagged(domain, &entry.file_name()) {
            // Nobody has it open.
            let _ = memory.flatten().map(fs::remove_file);
            let _ = fs::remove_file(entry.path());
        } else if memory == Some(None) {
            // It was removed from shared memory by force: nobody can open that topic any more.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The texts of all descriptions of topics.
pub(crate) fn descriptions(domain: &Domain) -> Vec<String> {
    let services = domain.root().join(SERVICES);
    let own = entries(&services).filter(|entry| is_of(domain, &entry.file_name()));
    own.filter_map(|entry| fs::read_to_string(entry.path()).ok()).collect()
}

/// The file in shared memory that a complete description stands for, if it is there; `None` when the description or shared memory cannot
/// be read.
fn memory_of(domain: &Domain, description: &Path) -> Option<Option<PathBuf>> {
    let number = number_of(&fs::read_to_string(description).ok()?)?;
    let end = format!("_{number}.dynamic");
    let file = shared_memory_of(domain).ok()?.into_iter().find(|name| name.ends_with(&end));
    Some(file.map(|name| Path::new(SHARED_MEMORY).join(name)))
}

/// The number of a topic in the names of its files: the two parts of its `unique_service_id`.
fn number_of(description: &str) -> Option<u128> {
    let part = |name: &str| -> Option<u128> {
        let line = description.lines().find_map(|line| line.trim().strip_prefix(name))?;
        line.trim().strip_prefix('=')?.trim().parse::<u64>().ok().map(u128::from)
    };
    Some(part("unique_value")? << 64 | part("payload_value")?)
}

/// What iceoryx2 keeps of each node beside its directory: by the locks of these it knows who lives.
const MONITOR_ENDS: [&str; 3] = ["node_monitor", "node_monitor_context", "node_monitor_owner_lock"];

/// Removes what is left of nodes that iceoryx2 never cleans up, and makes it able to clean up others:
///
/// * Who is killed between the first and the last file of its monitor, before the last of them is complete, or cleaning up another,
///   leaves files that make no node.
/// * Who is killed while it writes a tag leaves one that is not complete. iceoryx2 does not list it, so it cannot empty the node's
///   directory; when it fails to remove that, the node's details are gone already, and without them nobody tries again.
///
/// The caller is alone at the gate, so no role of ours is making a node. What is younger than iceoryx2's own patience may be
/// in work by a foreign program.
pub(crate) fn bury(domain: &Domain) {
    let nodes = domain.root().join(NODES);
    for number in node_numbers(domain, &nodes) {
        let monitor = monitor_files(domain, &nodes, &number);
        let settled = monitor.iter().chain([&nodes.join(&number)]).all(|path| is_settled(path));
        if settled && !makes_a_node(&monitor) {
            remove_node(domain, &nodes, &number);
        }
    }
    for (number, details) in dead_nodes(domain) {
        match details {
            Details::Known => remove_incomplete_tags(&nodes.join(number)),
            Details::Gone => remove_node(domain, &nodes, &number),
        }
    }
    // Where tags cannot be read nothing may be taken for untagged.
    let _ = remove_untagged_listeners(domain, &nodes);
}

/// Who is killed between the making of a listener's files and its entry in the topic leaves them: iceoryx2 removes them by the
/// entry only.
fn remove_untagged_listeners(domain: &Domain, nodes: &Path) -> io::Result<()> {
    // Files first, tags afterwards: a port's tag is made before its files.
    let files = listener_files(domain)?;
    let tagged = tagged_ports(domain, nodes)?;
    for (port, path) in files {
        if !tagged.contains(&port) && is_settled(&path) {
            let _ = fs::remove_file(path);
        }
    }
    Ok(())
}

/// `PREFIX_PORT.event` in the root and `PREFIX_HASH_PORT.event_mgmt` in shared memory, by port.
fn listener_files(domain: &Domain) -> io::Result<Vec<(String, PathBuf)>> {
    let mut names: Vec<_> =
        shared_memory_of(domain)?.into_iter().map(|name| (Path::new(SHARED_MEMORY), name)).collect();
    for entry in fs::read_dir(domain.root())? {
        let name = entry?.file_name().into_string().unwrap_or_default();
        if is_of(domain, OsStr::new(&name)) {
            names.push((domain.root(), name));
        }
    }
    let listener = |(folder, name): (&Path, String)| {
        let rest = name.strip_prefix(domain.prefix())?;
        let rest = rest.strip_suffix(".event").or_else(|| rest.strip_suffix(".event_mgmt"))?;
        Some((rest.rsplit('_').next()?.to_owned(), folder.join(&name)))
    };
    Ok(names.into_iter().filter_map(listener).collect())
}

/// Ports of all nodes, dead or alive.
fn tagged_ports(domain: &Domain, nodes: &Path) -> io::Result<BTreeSet<String>> {
    let mut ports = BTreeSet::new();
    for node in fs::read_dir(nodes)? {
        let directory = node?.path();
        let entries = match fs::read_dir(&directory) {
            Ok(entries) => entries,
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                continue;
            }
            Err(error) => return Err(error),
        };
        for entry in entries {
            ports.extend(port_of_tag(domain, &entry?.file_name()));
        }
    }
    Ok(ports)
}

fn port_of_tag(domain: &Domain, name: &OsStr) -> Option<String> {
    let port = name.to_str()?.strip_suffix(".port_tag")?.strip_prefix(domain.prefix())?;
    Some(port.to_owned())
}

/// Whether iceoryx2 knows how to clean up a dead node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Details {
    Known,
    Gone,
}

fn dead_nodes(domain: &Domain) -> Vec<(String, Details)> {
    let mut dead = Vec::new();
    let Ok(config) = domain.config() else { return dead };
    // What cannot be listed is left as it is.
    let _ = Node::<ipc::Service>::list(&config, |state| {
        if let NodeState::Dead(node) = state {
            let details = if node.details().is_some() { Details::Known } else { Details::Gone };
            dead.push((node.id().value().to_string(), details));
        }
        CallbackProgression::Continue
    });
    dead
}

/// Numbers of all nodes of which there is a directory or a file.
fn node_numbers(domain: &Domain, nodes: &Path) -> BTreeSet<String> {
    let number = |entry: DirEntry| {
        let name = entry.file_name().into_string().ok()?;
        let number = name.strip_prefix(domain.prefix()).unwrap_or(&name).split('.').next()?;
        number.bytes().all(|byte| byte.is_ascii_digit()).then(|| number.to_owned())
    };
    entries(nodes).filter_map(number).collect()
}

/// Whether all files of a monitor are there, and complete: of the second nobody may read until then, and iceoryx2 takes such a node for
/// one that is starting.
fn makes_a_node(monitor: &[PathBuf; 3]) -> bool {
    let is_readable =
        |path: &PathBuf| path.symlink_metadata().is_ok_and(|metadata| metadata.mode() & OWNER_READ != 0);
    monitor.iter().all(|path| path.exists()) && is_readable(&monitor[1])
}

fn monitor_files(domain: &Domain, nodes: &Path, number: &str) -> [PathBuf; 3] {
    MONITOR_ENDS.map(|end| nodes.join(format!("{}{number}.{end}", domain.prefix())))
}

/// Not there, or not touched for as long as iceoryx2 waits.
fn is_settled(path: &Path) -> bool {
    let Ok(metadata) = path.symlink_metadata() else { return true };
    age(&metadata) >= qos::CREATION_TIMEOUT
}

/// Zero for what is from the future.
fn age(metadata: &Metadata) -> Duration {
    metadata.modified().ok().and_then(|time| time.elapsed().ok()).unwrap_or_default()
}

fn remove_incomplete_tags(directory: &Path) {
    for entry in entries(directory).filter(|entry| entry.file_name().to_string_lossy().ends_with("_tag")) {
        if entry.metadata().is_ok_and(|metadata| metadata.mode() & OWNER_WRITE != 0) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Removes a node's ports, its directory and its monitor.
fn remove_node(domain: &Domain, nodes: &Path, number: &str) {
    let directory = nodes.join(number);
    for entry in entries(&directory) {
        if let Some(port) = port_of_tag(domain, &entry.file_name()) {
            remove_port(domain, &port);
        }
    }
    remove_directory(domain, &directory);
    for path in monitor_files(domain, nodes, number) {
        let _ = fs::remove_file(path);
    }
}

/// Files of a port: its number, which is used once, is in their names.
fn remove_port(domain: &Domain, port: &str) {
    let is_port = |name: &str| name.split(['_', '.']).any(|word| word == port);
    for name in shared_memory_of(domain).unwrap_or_default().iter().filter(|name| is_port(name)) {
        let _ = fs::remove_file(Path::new(SHARED_MEMORY).join(name));
    }
    for entry in entries(domain.root()) {
        let name = entry.file_name();
        if is_of(domain, &name) && name.to_str().is_some_and(is_port) {
            let _ = fs::remove_file(entry.path());
        }
    }
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
        let path = description_of(domain, hash);
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
        let young = description_of(&domain, "dd");
        let file = fs::File::create(&young).unwrap();
        file.set_modified(SystemTime::now() + Duration::from_secs(60)).unwrap();
        heal(&domain);
        assert!(!incomplete.exists() && !orphaned.exists());
        assert!(used.exists() && young.exists());
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn a_description_is_healed_away_when_its_memory_was_removed_and_memory_when_nobody_has_it_open() {
        let domain = domain("lost");
        let describe = |hash: &str, value: u64, tag: &str| {
            let path = description_of(&domain, hash);
            fs::write(&path, format!("[unique_service_id]\npayload_value = {value}\nunique_value = 1\n"))
                .unwrap();
            let file = fs::File::open(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(3)).unwrap();
            file.set_permissions(fs::Permissions::from_mode(0o400)).unwrap();
            let tag = format!("{}{hash}.{tag}", domain.prefix());
            fs::write(domain.root().join(NODES).join("123").join(tag), "").unwrap();
            path
        };
        let tag = "service_tag";
        let [kept, lost, unused] =
            [describe("aa", 5, tag), describe("bb", 6, tag), describe("cc", 7, "other")];
        let memory = [5, 7].map(|value| {
            let name = format!("{}ff_{}.dynamic", domain.prefix(), (1u128 << 64) + value);
            let path = Path::new(SHARED_MEMORY).join(name);
            fs::write(&path, "x").unwrap();
            path
        });
        heal(&domain);
        assert!(kept.exists() && !lost.exists() && !unused.exists());
        assert!(memory[0].exists() && !memory[1].exists());
        fs::remove_file(&memory[0]).unwrap();
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn files_that_make_no_node_are_removed_with_what_its_ports_keep() {
        let domain = domain("bury");
        let (prefix, nodes) = (domain.prefix().to_owned(), domain.root().join(NODES));
        let old = |path: PathBuf| {
            let file = fs::File::create(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(3)).unwrap();
            path
        };
        let tag = old(nodes.join("123").join(format!("{prefix}77.port_tag")));
        let lock = old(nodes.join(format!("{prefix}123.node_monitor_owner_lock")));
        let event = old(domain.root().join(format!("{prefix}77.event")));
        let connection = old(Path::new(SHARED_MEMORY).join(format!("{prefix}ab_88_77.connection")));
        let other = old(Path::new(SHARED_MEMORY).join(format!("{prefix}ab_88_770.connection")));
        let young = nodes.join("456");
        fs::create_dir_all(&young).unwrap();
        bury(&domain);
        assert!(tag.exists(), "its directory is young");
        std::thread::sleep(qos::CREATION_TIMEOUT);
        fs::remove_dir(&young).unwrap();
        fs::create_dir_all(&young).unwrap();
        bury(&domain);
        assert!(!tag.exists() && !lock.exists() && !event.exists() && !connection.exists());
        assert!(other.exists() && young.exists() && !nodes.join("123").exists());
        fs::remove_file(other).unwrap();
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn a_node_whose_monitor_was_never_completed_is_removed_and_a_complete_one_is_not() {
        let domain = domain("monitor");
        let nodes = domain.root().join(NODES);
        fs::remove_dir(nodes.join("123")).unwrap();
        let make = |number: &str, mode: u32| {
            let files = monitor_files(&domain, &nodes, number);
            for path in &files {
                fs::File::create(path)
                    .unwrap()
                    .set_modified(SystemTime::now() - Duration::from_secs(3))
                    .unwrap();
            }
            fs::set_permissions(&files[1], fs::Permissions::from_mode(mode)).unwrap();
            files
        };
        let (half, whole) = (make("55", 0o200), make("66", 0o400));
        assert!(!makes_a_node(&half) && makes_a_node(&whole));
        bury(&domain);
        assert!(!half.iter().any(|path| path.exists()));
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn files_of_listeners_that_no_node_has_are_removed() {
        let domain = domain("listeners");
        let (prefix, nodes) = (domain.prefix().to_owned(), domain.root().join(NODES));
        let file = |folder: &Path, name: &str, age: Duration| {
            let path = folder.join(format!("{prefix}{name}"));
            fs::File::create(&path).unwrap().set_modified(SystemTime::now() - age).unwrap();
            path
        };
        let (shared, old) = (Path::new(SHARED_MEMORY), Duration::from_secs(3));
        file(&nodes.join("123"), "77.port_tag", old);
        let used = [file(domain.root(), "77.event", old), file(shared, "ab_77.event_mgmt", old)];
        let left = [file(domain.root(), "78.event", old), file(shared, "ab_78.event_mgmt", old)];
        let others = [file(shared, "ab_78.dynamic", old), file(domain.root(), "79.event", Duration::ZERO)];
        remove_untagged_listeners(&domain, &nodes).unwrap();
        assert!(!left.iter().any(|path| path.exists()));
        assert!(used.iter().chain(&others).all(|path| path.exists()));
        used.iter().chain(&others).for_each(|path| fs::remove_file(path).unwrap());
        assert!(remove_untagged_listeners(&domain, &nodes.join("none")).is_err());
        fs::remove_dir_all(domain.root()).unwrap();
    }

    #[test]
    fn tags_that_are_not_complete_do_not_keep_the_directory_of_a_dead_node() {
        let domain = domain("tags");
        let directory = domain.root().join(NODES).join("123");
        let [complete, incomplete] = ["1.port_tag", "2.service_tag"].map(|name| directory.join(name));
        for (path, mode) in [(&complete, 0o400), (&incomplete, 0o600)] {
            fs::File::create(path).unwrap().set_permissions(fs::Permissions::from_mode(mode)).unwrap();
        }
        remove_incomplete_tags(&directory);
        assert!(complete.exists() && !incomplete.exists());
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
