//! `tagbus top`: what everybody on the bus counts about himself.

mod json;
mod look;
mod metrics;
mod process;
mod rows;
mod screen;
mod seen;
mod server;
mod track;

use std::io::{self, IsTerminal, Write};
use std::net::SocketAddr;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_message::clock::monotonic_ns;

use crate::command::Invocation;
use crate::config::text;
use crate::flags::PlaceFlags;
use crate::outcome::{Failure, Outcome};
use crate::role;
use look::Look;

/// Show how long every hop takes, rates, drops, memory, and who is stuck
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus top                                     until q, Esc or Ctrl-C
  tagbus top | less                              once, as text
  tagbus top --json | jq '.detectors[].hops.detect.p99_us'
  tagbus top --metrics 127.0.0.1:9464            a page for Prometheus: http://127.0.0.1:9464/metrics

Times are those of the last 5 seconds. How to read them, and the names of the metrics: docs/latency.md.")]
pub(crate) struct TopCommand {
    #[command(flatten)]
    flags: TopFlags,
}

/// Which bus, and for whom.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct TopFlags {
    #[command(flatten)]
    #[serde(flatten)]
    bus: PlaceFlags,
    /// Print all of it once as one JSON object and end
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    json: bool,
    /// Show nothing, and serve a page for Prometheus at this address, at /metrics
    #[arg(long, value_name = "IP:PORT", conflicts_with = "json", value_parser = server::address)]
    #[serde(default, with = "text::optional")]
    metrics: Option<SocketAddr>,
}

/// Looks once, or until somebody ends it.
pub(crate) fn execute(command: TopCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let stop = role::stop(invocation.parent())?;
    let domain = flags.bus.domain()?;
    // Before the bus: an address that cannot be had is said at once.
    let server = flags.metrics.map(server::Server::start).transpose()?;
    let mut look = Look::start(&domain, &stop)?;
    if let Some(server) = server {
        return server.serve(&mut look, &stop);
    }
    if !flags.json && io::stdout().is_terminal() {
        return screen::show(&mut look, domain.name(), &stop);
    }
    let seen = look.settled(&stop);
    let mut out = io::stdout().lock();
    if flags.json {
        writeln!(out, "{}", json::object(seen, domain.name(), monotonic_ns()))?;
    } else {
        for row in rows::of(seen, domain.name(), monotonic_ns()) {
            writeln!(out, "{}", row.text)?;
        }
    }
    Ok(Outcome::Done)
}
