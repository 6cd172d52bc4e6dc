//! What each attack costs the honest ones, as a table.

use std::fmt::Write as _;

use super::run::{Attacked, Outcome, Window};
use super::verdict::faults;
use crate::median::median;

/// CPU time of the honest ones may rise by this part.
const GOAL: f64 = 0.05;

/// How a record of this is made.
pub(crate) const HOW: &str = "an honest camera (one picture of the set `base`, 480x360, again and again), a process with two detectors \
    (tag36h11, one thread each: that of the honest camera and that of the hostile one, pinned to a core), two honest clients, and one within \
    the bench that counts; attackers are processes of the same domain on the other cores, one at a time. frames: 200 frames a second of \
    a camera whose headers, lengths and strides lie; detections: as many messages whose counts lie, to an honest client; hoard: 24 subscribers \
    of detections and 3 of frames that borrow all they can; deaf: as many that never receive; requests: fuzzed requests to detector and \
    camera without a pause; visits: coming, subscribing and leaving without a pause. Tame: the same publisher telling the truth, or the same \
    deeds in another domain, so that what a busy machine costs is not taken for the attack's work. CPU time from schedstat (of \
    the honest detector its thread) for each message; medians of the rounds; the rise is the median of those of the rounds, \
    each against its tame twin";

/// The verdict, then a line for each attack.
pub(crate) fn page(outcome: &Outcome) -> String {
    let faults = faults(outcome);
    let mut text = match faults.is_empty() {
        true => "Nobody ended, every frame that was searched arrived or was counted, nothing was left.\n"
            .to_owned(),
        false => faults.iter().map(|fault| format!("* FAULT: {fault}\n")).collect(),
    };
    text += "\n| attack | deeds | detector us: tame | hostile | rise | camera us: tame | hostile | rise | client us: tame | hostile | rise | received, missed, skipped: tame | hostile |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|---|\n";
    let quiet = Sums::of(&outcome.quiet);
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "| (nobody) | | {:.1} | | | {:.1} | | | {:.1} | | | {} | |",
        quiet.detector_us, quiet.camera_us, quiet.client_us, quiet.delivery
    );
    for attacked in &outcome.attacks {
        text += &line(attacked);
    }
    let _ = writeln!(text, "\n{}", verdict(outcome));
    text
}

/// Medians and sums over the rounds.
struct Sums {
    detector_us: f64,
    camera_us: f64,
    client_us: f64,
    delivery: String,
}

impl Sums {
    fn of(windows: &[Window]) -> Self {
        let middle = |value: fn(&Window) -> f64| median(windows.iter().map(value));
        let sum = |count: fn(&Window) -> u64| windows.iter().map(count).sum::<u64>();
        Self {
            detector_us: middle(|window| window.detector_us),
            camera_us: middle(|window| window.camera_us),
            client_us: middle(|window| window.client_us),
            delivery: format!(
                "{}, {}, {}",
                sum(|window| window.received),
                sum(|window| window.missed),
                sum(|window| window.skipped)
            ),
        }
    }
}

impl Attacked {
    /// How much more was taken than beside the tame twin, as a part of it.
    fn rise(&self, value: fn(&Window) -> f64) -> f64 {
        median(self.tame.iter().zip(&self.hostile).map(|(tame, hostile)| value(hostile) / value(tame) - 1.0))
    }

    fn rises(&self) -> [f64; 3] {
        [
            |window: &Window| window.detector_us,
            |window: &Window| window.camera_us,
            |window: &Window| window.client_us,
        ]
        .map(|value| self.rise(value))
    }
}

fn line(attacked: &Attacked) -> String {
    let (tame, hostile) = (Sums::of(&attacked.tame), Sums::of(&attacked.hostile));
    let [detector, camera, client] = attacked.rises().map(|rise| format!("{:+.1} %", 100.0 * rise));
    let deeds = median(attacked.hostile.iter().map(|window| window.deeds as f64));
    format!(
        "| {} | {deeds:.0} | {:.1} | {:.1} | {detector} | {:.1} | {:.1} | {camera} | {:.1} | {:.1} | {client} | {} | {} |\n",
        attacked.attack.name(),
        tame.detector_us,
        hostile.detector_us,
        tame.camera_us,
        hostile.camera_us,
        tame.client_us,
        hostile.client_us,
        tame.delivery,
        hostile.delivery,
    )
}

/// The attacks that cost the honest ones too much.
fn verdict(outcome: &Outcome) -> String {
    let names = ["detector", "camera", "client"];
    let above = outcome.attacks.iter().flat_map(|attacked| {
        let rises = attacked.rises().into_iter().zip(names);
        rises
            .filter(|(rise, _)| *rise > GOAL)
            .map(|(rise, name)| format!("{} costs the {name} {:.1} %", attacked.attack.name(), 100.0 * rise))
    });
    let above: Vec<String> = above.collect();
    match above.is_empty() {
        true => "CPU time of nobody honest rises by more than 5 %: met.".to_owned(),
        false => format!("CPU time of honest ones rises by more than 5 %: {}.", above.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::attack::Attack;
    use super::*;

    #[test]
    fn the_rise_is_the_middle_of_those_of_the_rounds() {
        let windows = |values: [f64; 3]| {
            let window = |us| Window { detector_us: us, camera_us: us, client_us: 1.0, ..Window::default() };
            values.map(window).to_vec()
        };
        let attacked = Attacked {
            attack: Attack::Visits,
            tame: windows([100.0, 200.0, 100.0]),
            hostile: windows([104.0, 210.0, 190.0]),
        };
        let [detector, camera, client] = attacked.rises();
        assert!((detector - 0.05).abs() < 1e-12 && detector == camera && client == 0.0);
    }
}
