//! Plays known pictures to a camera in a virtual machine, and judges what clients get of them. Called by `tests/vm/run`.
//!
//! ```text
//! host:   tagbus-vm scene   WxH FOLDER           numbered pictures and what is to be found in them
//! guest:  tagbus-vm convert WxH FORMAT FOLDER    the same pictures as a driver's bytes, on the standard output
//!         tagbus-vm prove   PROCESS TRACE        shows that a detector reads where the camera's driver wrote
//!         tagbus-vm hold    FILE                 keeps two frames as long as there is a file
//!         tagbus-vm tell    WxH FOLDER           the pictures again and again, with the time as a number in each, on the standard output
//!         tagbus-vm clock                        how long after that time frames are stamped, sent and at a client
//!         tagbus-vm judge   WxH FOLDER ...       receives frames and detections, and holds both against the truth
//! ```
#![forbid(unsafe_code)]

mod clock;
mod convert;
mod hold;
mod judge;
mod pictures;
mod place;
mod proof;

use std::process::ExitCode;

/// What went wrong, in words.
type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "usage: tagbus-vm scene WxH FOLDER | convert WxH FORMAT FOLDER | prove PROCESS TRACE | hold FILE | tell WxH FOLDER | clock | judge WxH FOLDER --copies N --same PERCENT --kind KIND --domain NAME --frames N --seconds N";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["scene", size, folder] => pictures::paint(size, folder),
        ["convert", size, format, folder] => convert::play(size, format, folder),
        ["tell", size, folder] => clock::tell(size, folder),
        ["clock"] => clock::read(),
        ["hold", sign] => hold::hold(sign),
        ["prove", camera, trace] => proof::prove(camera, trace),
        ["judge", size, folder, options @ ..] => judge::judge(size, folder, options),
        _ => Err(USAGE.into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tagbus-vm: {error}");
            ExitCode::FAILURE
        }
    }
}
