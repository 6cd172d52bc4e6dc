//! Ports and services of a topic that go without harm to one that took its place.
//!
//! iceoryx2 removes the description of a topic by its name when the last who has it open goes. Where files were removed by force the
//! topic was made anew under the same name: then that name is another topic's by now, which nobody would find any more, and
//! its owner would have to make it once more, again and again.

use std::fs;
use std::path::PathBuf;

use crate::description::Description;
use crate::domain::Domain;
use crate::gate::Company;

/// What a role has of a topic. It is dropped in the order of its fields, with the descriptions of others laid aside.
#[derive(Debug)]
pub(crate) struct Held<P> {
    /// Only `None` while this is dropped.
    parts: Option<P>,
    descriptions: Vec<Description>,
    domain: Domain,
}

impl<P> Held<P> {
    /// Takes ports and services with the descriptions of these services.
    pub(crate) fn new(parts: P, descriptions: impl Into<Vec<Description>>, domain: &Domain) -> Self {
        Self { parts: Some(parts), descriptions: descriptions.into(), domain: domain.clone() }
    }

    pub(crate) fn get(&self) -> &P {
        self.parts.as_ref().expect("parts are taken only when this is dropped")
    }

    pub(crate) fn get_mut(&mut self) -> &mut P {
        self.parts.as_mut().expect("parts are taken only when this is dropped")
    }

    /// Whether the topic of this name is still this one; costs one system call.
    pub(crate) fn is_current(&self) -> bool {
        self.descriptions.first().is_none_or(Description::is_unchanged)
    }
}

impl<P> Drop for Held<P> {
    fn drop(&mut self) {
        let changed: Vec<_> = self.descriptions.iter().filter(|one| !one.is_unchanged()).collect();
        if changed.is_empty() {
            self.parts = None;
            return;
        }
        // Where the gate is not to be had, the harm is that a topic is made once more.
        let _alone = self.domain.enter(Company::Alone);
        let aside: Vec<_> = changed.into_iter().map(Aside::lay).collect();
        self.parts = None;
        drop(aside);
    }
}

/// A file under another name until this is dropped.
struct Aside {
    path: PathBuf,
    aside: PathBuf,
}

impl Aside {
    fn lay(description: &Description) -> Self {
        let path = description.path().to_owned();
        let aside = path.with_extension("laid_aside");
        // Where nothing is, nothing has to be saved.
        let _ = fs::rename(&path, &aside);
        Self { path, aside }
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        let _ = fs::rename(&self.aside, &self.path);
    }
}
