//! What each attack costs the honest ones, as a table.

use std::fmt::Write as _;

use super::run::{Attacked, Outcome, Window};
use super::verdict::faults;
use crate::median::{median, median_interval};

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
    each against its tame twin, and in brackets where the median of endless rounds lies (95 %, order statistics)";

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

/// How much more was taken than beside the tame twin, as a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rise {
    median: f64,
    /// Where the median of endless rounds lies.
    interval: [f64; 2],
}

impl Rise {
    fn text(self) -> String {
        let [median, least, most] =
            [self.median, self.interval[0], self.interval[1]].map(|part| 100.0 * part);
        format!("{median:+.1} % ({least:+.1} to {most:+.1})")
    }
}

impl Attacked {
    fn rise(&self, value: fn(&Window) -> f64) -> Rise {
        let pairs = self.tame.iter().zip(&self.hostile);
        let rises: Vec<f64> = pairs.map(|(tame, hostile)| value(hostile) / value(tame) - 1.0).collect();
        Rise { median: median(rises.iter().copied()), interval: median_interval(rises) }
    }

    fn rises(&self) -> [Rise; 3] {
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
    let [detector, camera, client] = attacked.rises().map(Rise::text);
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

/// What each measurement of each round took, for whoever wants to see how much they differ.
pub(crate) fn csv(outcome: &Outcome) -> String {
    let mut text = "attack,manner,round,detector_us,camera_us,client_us,received,deeds\n".to_owned();
    add_rows(&mut text, "nobody", "quiet", &outcome.quiet);
    for attacked in &outcome.attacks {
        add_rows(&mut text, attacked.attack.name(), "tame", &attacked.tame);
        add_rows(&mut text, attacked.attack.name(), "hostile", &attacked.hostile);
    }
    text
}

fn add_rows(text: &mut String, attack: &str, manner: &str, windows: &[Window]) {
    for (round, window) in windows.iter().enumerate() {
        let Window { detector_us, camera_us, client_us, received, deeds, .. } = window;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{attack},{manner},{round},{detector_us:.2},{camera_us:.2},{client_us:.2},{received},{deeds}"
        );
    }
}

/// The attacks that cost the honest ones too much, and those of which the rounds do not tell.
fn verdict(outcome: &Outcome) -> String {
    let names = ["detector", "camera", "client"];
    let named = |attacked: &Attacked| {
        let attack = attacked.attack.name();
        attacked.rises().into_iter().zip(names).map(move |(rise, who)| (rise, format!("{attack}: the {who}")))
    };
    let rises: Vec<(Rise, String)> = outcome.attacks.iter().flat_map(named).collect();
    let those = |is_one: fn(&Rise) -> bool| {
        let those = rises.iter().filter(|(rise, _)| is_one(rise));
        those.map(|(rise, who)| format!("{who} {}", rise.text())).collect::<Vec<_>>().join("; ")
    };
    let (above, unknown) = (
        those(|rise| rise.interval[0] > GOAL || rise.median > GOAL),
        those(|rise| rise.median <= GOAL && rise.interval[1] > GOAL),
    );
    match (above.is_empty(), unknown.is_empty()) {
        (true, true) => "CPU time of nobody honest rises by more than 5 %: met.".to_owned(),
        (true, false) => format!(
            "CPU time of honest ones rises by at most 5 %: met; more rounds are needed to be sure of {unknown}."
        ),
        (false, _) => format!("CPU time of honest ones rises by more than 5 %: {above}."),
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
        assert!((detector.median - 0.05).abs() < 1e-12 && detector == camera && client.median == 0.0);
        assert_eq!(detector.interval.map(|part| (100.0 * part).round()), [4.0, 90.0]);
    }

    #[test]
    fn the_verdict_says_what_rounds_do_not_tell() {
        let outcome = |hostile: [f64; 9]| {
            let windows = |values: &[f64]| {
                let window = |&us: &f64| Window {
                    detector_us: us,
                    camera_us: 1.0,
                    client_us: 1.0,
                    ..Window::default()
                };
                values.iter().map(window).collect()
            };
            Outcome {
                quiet: Vec::new(),
                attacks: vec![Attacked {
                    attack: Attack::Deaf,
                    tame: windows(&[100.0; 9]),
                    hostile: windows(&hostile),
                }],
                tallies: Vec::new(),
                no_loan: 0,
                searched_and_sent: [0; 2],
                stored: Default::default(),
                left: Vec::new(),
            }
        };
        let [met, unsure, above] = [
            [100.0, 101.0, 102.0, 103.0, 104.0, 99.0, 98.0, 100.0, 120.0],
            [100.0, 101.0, 112.0, 113.0, 104.0, 99.0, 98.0, 100.0, 120.0],
            [110.0, 111.0, 112.0, 113.0, 104.0, 99.0, 98.0, 100.0, 120.0],
        ]
        .map(outcome);
        assert!(verdict(&met).ends_with("5 %: met."), "{}", verdict(&met));
        assert!(
            verdict(&unsure).contains("deaf: the detector +1.0 % (-1.0 to +13.0)"),
            "{}",
            verdict(&unsure)
        );
        assert!(
            verdict(&above).starts_with("CPU time of honest ones rises by more than 5 %: deaf: the detector")
        );
        assert_eq!(csv(&met).lines().count(), 1 + 18);
    }
}
