//! What one process of the machine is told.

use std::collections::BTreeMap;

use serde::Serialize;

use super::child::Role;
use crate::config::{arguments, values};
use crate::flags::BusFlags;
use crate::outcome::Failure;
use crate::service::ServiceFlags;

/// A process of the machine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    /// As users read it, such as "camera front". No other part has the same name.
    pub(super) name: String,
    pub(super) role: Role,
    /// Its command line without the subcommand.
    pub(super) arguments: Vec<String>,
    /// The detectors in it.
    pub(super) detectors: Vec<DetectorPart>,
}

/// A detector of a part.
#[derive(Clone, Debug)]
pub(super) struct DetectorPart {
    pub(super) bus: BusFlags,
    pub(super) name: String,
    /// Every flag that has a value, as text.
    pub(super) values: BTreeMap<String, String>,
}

impl PartialEq for DetectorPart {
    /// The place on the bus is among the values.
    fn eq(&self, other: &Self) -> bool {
        self.values == other.values
    }
}

impl Part {
    /// The only process of its role.
    pub(super) fn only<F: clap::Args + Serialize>(role: Role, flags: &F) -> Result<Self, Failure> {
        Self::named(role.to_string(), role, flags)
    }

    /// One of several.
    pub(super) fn named<F: clap::Args + Serialize>(
        name: String,
        role: Role,
        flags: &F,
    ) -> Result<Self, Failure> {
        Ok(Self { name, role, arguments: arguments(flags)?, detectors: Vec::new() })
    }

    /// A process with one detector or more.
    pub(super) fn service(name: String, detectors: &[ServiceFlags]) -> Result<Self, Failure> {
        let Some((first, others)) = detectors.split_first() else {
            return Err(Failure::new(format!("{name} has no detector")));
        };
        let mut part = Self::named(name, Role::Service, first)?;
        for other in others {
            part.arguments.push(format!("--also={}", other.as_toml()?));
        }
        part.detectors = detectors.iter().map(DetectorPart::of).collect::<Result<_, _>>()?;
        Ok(part)
    }
}

impl DetectorPart {
    fn of(flags: &ServiceFlags) -> Result<Self, Failure> {
        Ok(Self { bus: flags.bus.clone(), name: flags.name.detector.clone(), values: values(flags)? })
    }
}
