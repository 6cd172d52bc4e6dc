//! What a device offers: formats, sizes, rates, controls.

use std::io;
use std::path::Path;

use tagbus_message::frame::Fourcc;

use super::controls;
use super::kernel::{Listed, Port};
use crate::devices::{Answer, FormatInfo, RateInfo, SizeInfo};

/// Longer lists are a driver's fault.
const MOST_ENTRIES: u32 = 1024;

/// What a device captures and what can be set, or why it does not tell.
pub(crate) fn ask(path: &Path) -> Result<Answer, String> {
    query(path).map_err(|error| error.to_string())
}

fn query(path: &Path) -> io::Result<Answer> {
    let mut port = Port::open(path)?;
    if port.about()?.captures.is_none() {
        return Ok(Answer::default());
    }
    let formats = entries(|index| port.format_at(index))?;
    let describe = |(format, description)| {
        // A driver may know no sizes for a format; that is no reason to leave the format out.
        let sizes = entries(|index| port.size_at(format, index)).unwrap_or_default();
        let sizes = sizes.into_iter().map(|size| size_info(&port, format, size)).collect();
        FormatInfo { format, description, sizes }
    };
    let formats = formats.into_iter().map(describe).collect();
    Ok(Answer { formats, controls: controls::list(&port)? })
}

/// A list of the driver's from its first entry to its end.
pub(super) fn entries<T>(at: impl Fn(u32) -> io::Result<Option<T>>) -> io::Result<Vec<T>> {
    let mut entries = Vec::new();
    for index in 0..MOST_ENTRIES {
        let Some(entry) = at(index)? else { break };
        entries.push(entry);
    }
    Ok(entries)
}

fn size_info(port: &Port, format: Fourcc, size: Listed<[u32; 2]>) -> SizeInfo {
    let pair = |[width, height]: [u32; 2]| (width, height);
    let (min, max, step) = match size {
        Listed::One(one) => (one, one, [0, 0]),
        Listed::Range { min, max, step } => (min, max, step),
    };
    let mut intervals = Vec::new();
    for index in 0..MOST_ENTRIES {
        match port.interval_at(format, min, index) {
            Ok(Some(interval @ Listed::One(_))) => intervals.push(interval),
            // A range is the whole list.
            Ok(Some(range)) => {
                intervals.push(range);
                break;
            }
            Ok(None) | Err(_) => break,
        }
    }
    let rates = intervals.into_iter().map(rate_info).collect();
    SizeInfo { min: pair(min), max: pair(max), step: pair(step), rates }
}

/// The shortest interval is the highest rate.
fn rate_info(interval: Listed<[u32; 2]>) -> RateInfo {
    let rate = |[numerator, denominator]: [u32; 2]| f64::from(denominator) / f64::from(numerator.max(1));
    match interval {
        Listed::One(one) => RateInfo { min: rate(one), max: rate(one) },
        Listed::Range { min, max, .. } => RateInfo { min: rate(max), max: rate(min) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_the_inverse_of_intervals_also_for_a_range() {
        assert_eq!(rate_info(Listed::One([1, 30])), RateInfo { min: 30.0, max: 30.0 });
        let range = Listed::Range { min: [1, 60], max: [1, 1], step: [1, 1] };
        assert_eq!(rate_info(range), RateInfo { min: 1.0, max: 60.0 });
        assert_eq!(rate_info(Listed::One([0, 30])).max, 30.0);
    }

    #[test]
    fn a_list_without_an_end_is_cut() {
        assert_eq!(entries(|index| Ok(Some(index))).unwrap().len(), MOST_ENTRIES as usize);
        assert_eq!(entries(|index| Ok((index < 3).then_some(index))).unwrap(), [0, 1, 2]);
    }
}
