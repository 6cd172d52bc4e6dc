//! A client that keeps what it gets: the camera has to write elsewhere.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::{ConnectOptions, FrameClient};

use crate::Failure;

/// Frames that are kept; no client may keep more.
const KEPT: usize = 2;

/// Long enough for an emulated processor.
const PATIENCE: Duration = Duration::from_secs(60);

/// Connects, waits until there is a file `sign`, then keeps two frames until the file is gone; what is kept must not change.
pub(crate) fn hold(sign: &str) -> Result<(), Failure> {
    let (sign, deadline) = (Path::new(sign), Instant::now() + PATIENCE);
    let mut client = FrameClient::connect(&ConnectOptions::new("tagbus")?.deadline(PATIENCE))?;
    println!("hold: connected");
    // What comes before the sign is given back at once.
    while !sign.exists() {
        client.receive(Duration::from_millis(50))?;
        in_time(deadline)?;
    }
    let mut kept = Vec::new();
    while sign.exists() {
        if kept.len() < KEPT
            && let Some(frame) = client.receive(Duration::from_millis(50))?
        {
            let bytes = frame.bytes().to_vec();
            kept.push((frame, bytes));
            println!("hold: keeps {} frames", kept.len());
        }
        in_time(deadline)?;
    }
    let changed = kept.iter().filter(|(frame, bytes)| frame.bytes() != bytes).count();
    if changed == 0 { Ok(()) } else { Err(format!("{changed} frames changed while they were held").into()) }
}

fn in_time(deadline: Instant) -> Result<(), Failure> {
    thread::sleep(Duration::from_millis(1));
    if Instant::now() < deadline { Ok(()) } else { Err("nobody gave a sign in time".into()) }
}
