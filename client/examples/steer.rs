//! Follows a tag: says where to turn so that it gets to the middle of the picture. `steer [ID]`, 0 by default.

use std::time::Duration;

use tagbus_client::{Client, ConnectOptions};

/// Of half the picture's width: closer to the middle than this is straight ahead.
const STRAIGHT: f64 = 0.1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wanted: u32 = std::env::args().nth(1).map_or(Ok(0), |id| id.parse())?;
    let mut client = Client::connect(&ConnectOptions::new("tagbus")?)?;
    loop {
        // What was seen before the last turn is of no use: wait for news, then take the newest.
        let Some(first) = client.receive(Duration::from_secs(1))? else {
            println!("stop: the camera is silent");
            continue;
        };
        let newest = client.latest()?.unwrap_or(first);
        let half_width = f64::from(newest.header().width) / 2.0;
        let tag =
            newest.tags().iter().filter(|tag| tag.id == wanted).max_by(|a, b| a.margin.total_cmp(&b.margin));
        match tag.map(|tag| tag.center[0] / half_width - 1.0) {
            None => println!("stop: tag {wanted} is not seen"),
            Some(aside) if aside < -STRAIGHT => println!("turn left  {:3.0} %", -100.0 * aside),
            Some(aside) if aside > STRAIGHT => println!("turn right {:3.0} %", 100.0 * aside),
            Some(_) => println!("straight ahead"),
        }
    }
}
