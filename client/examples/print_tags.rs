//! Prints every tag that a running detector finds: `cargo run --release -p tagbus-client --example print_tags`.

use std::time::Duration;

use tagbus_client::{Client, ConnectOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut client = Client::connect(&ConnectOptions::new("tagbus")?)?;
    loop {
        let Some(detections) = client.receive(Duration::from_secs(2))? else {
            println!("no message for 2 s");
            continue;
        };
        let header = detections.header();
        let age_us = detections.client_ns().saturating_sub(header.publish_ns) / 1000;
        println!("frame {} ({age_us} us old): {} tags", header.sequence, header.count);
        for tag in detections.tags() {
            println!("  {} {} at {:.1}, {:.1}", tag.family(), tag.id, tag.center[0], tag.center[1]);
        }
    }
}
