//! How long before its stamp a frame really was, and how old it is at a client: measured with something to be seen whose state
//! is known by time.
//!
//! ```text
//!   shown or switched              stamp               client
//! ──────┬─────────────────────────────┬───────────────────┬──────▶ CLOCK_MONOTONIC
//!       │◀── what nobody else knows ─▶│◀─ what stamps say ▶│
//! ```
//!
//! Three things can be seen: a tag whose id counts time (on a screen, or from a stand-in for a camera), a number that does so in the corner of
//! frames that a program plays, and a light.

mod check;
mod interval;
mod light;
mod numbered;
mod pattern;
mod report;
mod screen;
mod stand_in;
mod watch;

pub(crate) use check::{Check, Found, check};
pub(crate) use light::{Switch, light};
pub(crate) use pattern::Pattern;
pub(crate) use report::{light_page, shown_page};
pub(crate) use screen::Screen;
pub(crate) use stand_in::{StandInOrder, stand_in};
pub(crate) use watch::watch;
