//! How long a frame takes from one process to others, how long their answer takes, and what else there is.

mod copied;
mod figures;
mod floor;
mod noise;
mod pipeline;
mod plot;
mod receiver;
mod report;
mod run;
mod sender;
mod sleepers;
mod verdict;
mod way;
mod zeromq;

/// What the record says of how it was made.
pub(crate) const HOW: &str = "in each round every line once, beginning with another one each time; every receiver and client is a process of \
    its own; a frame is grey, its sender copies it once into shared memory or into each socket (ZeroMQ: into a message), a receiver \
    reads all of it after it has taken the time; with more than six receivers the frames topic is made for so many, which a camera \
    does not do; the first 20 frames of each line and round do not count; polling is measured with up to four receivers, because each \
    takes a whole processor; pipes hold 1 MiB, sockets a whole frame (SO_SNDBUFFORCE, as root only); a sender \
    writes to one receiver after the other";

pub(crate) use floor::{EchoOrder, echo};
pub(crate) use pipeline::{ListenOrder, listen};
pub(crate) use plot::figure;
pub(crate) use receiver::{ReceiveOrder, receive};
pub(crate) use report::{csv, page};
pub(crate) use run::{Plan, run};
pub(crate) use sleepers::sleep;
pub(crate) use way::Way;
