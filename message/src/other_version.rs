//! Why a topic does not come: it is there in another version, which nobody of this one sees.

use std::fs;

use crate::domain::{Domain, SHARED_MEMORY};
use crate::sweep;

/// What names of topics begin with, up to the version's number.
const FAMILY: &str = "tagbus/v";
/// How the name of a topic is written in its description.
const NAME_KEY: &str = "service_name = \"";
/// Digits of iceoryx2's minor in a domain's prefix, after `tb`.
const DIGITS: std::ops::Range<usize> = 2..5;

/// What of another version is there instead of `topic`, in words; `None` when nothing is.
pub(crate) fn instead_of(domain: &Domain, topic: &str) -> Option<String> {
    other_layout(domain, topic).or_else(|| other_generation(domain))
}

/// The same topic with another number in its name.
fn other_layout(domain: &Domain, topic: &str) -> Option<String> {
    let rest = without_version(topic)?;
    let is_other = |name: &str| name != topic && without_version(name) == Some(rest);
    sweep::descriptions(domain).into_iter().find_map(|text| name_in(&text).filter(|name| is_other(name)))
}

/// `cam0/frames` of `tagbus/v1/cam0/frames`.
fn without_version(topic: &str) -> Option<&str> {
    let (version, rest) = topic.strip_prefix(FAMILY)?.split_once('/')?;
    version.bytes().all(|byte| byte.is_ascii_digit()).then_some(rest)
}

/// The name of the topic that is described.
pub(crate) fn name_in(description: &str) -> Option<String> {
    let line = description.lines().find_map(|line| line.trim().strip_prefix(NAME_KEY))?;
    Some(line.trim_end_matches('"').to_owned())
}

/// Files of the same domain that were made by another minor of iceoryx2.
fn other_generation(domain: &Domain) -> Option<String> {
    let own = domain.prefix();
    let is_other = |name: &str| {
        let same_domain = name.starts_with("tb") && name.get(DIGITS.end..)?.starts_with(&own[DIGITS.end..]);
        let digits = name.get(DIGITS)?;
        let other = same_domain && digits != &own[DIGITS] && digits.bytes().all(|byte| byte.is_ascii_digit());
        other.then(|| digits.to_owned())
    };
    let names =
        fs::read_dir(SHARED_MEMORY).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let digits = names.filter_map(|name| is_other(&name)).next()?;
    let version = |digits: &str| format!("{}.{}", &digits[..1], digits[1..].trim_start_matches('0'));
    Some(format!("programs of iceoryx2 {} (this one is of {})", version(&digits), version(&own[DIGITS])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_told_apart_by_the_number_in_the_name_only() {
        assert_eq!(without_version("tagbus/v12/cam0/frames"), Some("cam0/frames"));
        assert_eq!(without_version("tagbus/vx/cam0/frames"), None);
        assert_eq!(without_version("other/v1/cam0/frames"), None);
    }
}
