//! What families are held to: every metric at about the same strictness, and the Ising energy once more where whole
//! numbers leave it stricter or looser than another metric.

use tagbus_family::Layout;
use tagbus_family::complexity::{Metric, Rule};
use tagbus_scene::Stream;

/// Random codes by which the share that passes is told.
pub(super) const SHARE_SAMPLE: usize = 20_000;
/// Where in [`Field::contenders`] stand those that the library's defaults give; the others come after them.
pub(super) const DEFAULTS: std::ops::Range<usize> = 0..4;
/// Where the metric that the paper chose stands, with the limit of the published families.
const ISING: usize = 3;

/// One way to choose the codes of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contender {
    /// `None`: every code is complex enough.
    pub(super) metric: Option<Metric>,
    /// The least complexity.
    pub(super) least: u32,
}

impl Contender {
    fn default_of(metric: Option<Metric>, layout: &Layout) -> Contender {
        Contender { metric, least: metric.map_or(0, |metric| metric.default_least(layout)) }
    }

    pub(super) fn rule(self) -> Rule {
        Rule { metric: self.metric.unwrap_or(Metric::Ising), least: self.least }
    }

    pub(super) fn name(self) -> String {
        match self.metric {
            None => "no metric".to_owned(),
            Some(Metric::Ising) => format!("Ising >= {}", self.least),
            Some(metric) => format!("{metric} >= {}", self.least),
        }
    }

    /// The share of these codes that it lets pass.
    fn share(self, layout: &Layout, sample: &[u64]) -> f64 {
        let passing = sample.iter().filter(|&&code| self.rule().allows(layout, code)).count();
        passing as f64 / sample.len() as f64
    }
}

fn random_codes(layout: &Layout, count: usize) -> Vec<u64> {
    let (mut random, unused) = (Stream::new(1), 64 - layout.bit_count());
    (0..count).map(|_| random.bits() >> unused).collect()
}

/// Two contenders that are compared, by their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    pub(super) ising: usize,
    pub(super) other: usize,
}

/// All contenders of a layout and what is compared.
pub(super) struct Field {
    pub(super) contenders: Vec<Contender>,
    /// The share of random codes that each lets pass.
    pub(super) shares: Vec<f64>,
    pub(super) pairs: Vec<Pair>,
}

impl Field {
    /// No metric and those of the paper in the order of its tables, each with the library's default; Ising beside each of
    /// the others; and Ising with the highest limit that lets pass no less than rectangles, and than components, do. So many
    /// random codes, the same for all, tell what passes.
    pub(super) fn new(layout: &Layout, sample: usize) -> Field {
        let sample = random_codes(layout, sample);
        let metrics = [None, Some(Metric::Rectangles), Some(Metric::Components), Some(Metric::Ising)];
        let mut contenders = metrics.map(|metric| Contender::default_of(metric, layout)).to_vec();
        let mut shares: Vec<f64> =
            contenders.iter().map(|contender| contender.share(layout, &sample)).collect();
        let mut pairs: Vec<Pair> = (0..ISING).map(|other| Pair { ising: ISING, other }).collect();
        for (other, &share) in shares.iter().enumerate().take(ISING).skip(1) {
            let least = ising_passing(share, layout, &sample);
            let ising = place_of(Contender { metric: Some(Metric::Ising), least }, &mut contenders);
            if ising != ISING {
                pairs.push(Pair { ising, other });
            }
        }
        let added = contenders[shares.len()..].iter().map(|contender| contender.share(layout, &sample));
        shares.extend(added.collect::<Vec<_>>());
        Field { contenders, shares, pairs }
    }
}

/// The highest limit to the Ising energy that at least this share of the codes passes.
fn ising_passing(share: f64, layout: &Layout, sample: &[u64]) -> u32 {
    let energy = |&code: &u64| Metric::Ising.of(layout, code, u32::MAX);
    let mut energies: Vec<u32> = sample.iter().map(energy).collect();
    energies.sort_unstable_by_key(|&energy| std::cmp::Reverse(energy));
    let wanted = (share * sample.len() as f64).round() as usize;
    energies.get(wanted.saturating_sub(1)).copied().unwrap_or(0)
}

fn place_of(contender: Contender, contenders: &mut Vec<Contender>) -> usize {
    contenders.iter().position(|known| *known == contender).unwrap_or_else(|| {
        contenders.push(contender);
        contenders.len() - 1
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counting rectangles takes its time.
    const FEW: usize = 500;

    fn layouts() -> [Layout; 2] {
        [Layout::circle(9).unwrap(), Layout::standard(9).unwrap()]
    }

    #[test]
    fn the_defaults_are_no_metric_and_those_of_the_paper_about_as_strict_as_each_other() {
        for layout in layouts() {
            let Field { contenders, shares, .. } = Field::new(&layout, FEW);
            assert_eq!(contenders[ISING].metric, Some(Metric::Ising));
            assert_eq!((contenders[0].metric, shares[0]), (None, 1.0));
            let metrics = &shares[1..DEFAULTS.end];
            assert!(metrics.iter().all(|share| (share - shares[ISING]).abs() < 0.15), "{shares:?}");
        }
    }

    #[test]
    fn every_metric_also_meets_an_ising_limit_that_is_no_stricter_and_by_one_more_would_be() {
        for layout in layouts() {
            let Field { contenders, shares, pairs } = Field::new(&layout, FEW);
            let sample = random_codes(&layout, FEW);
            for other in 1..ISING {
                let is_fair = |pair: &&Pair| {
                    let ising = contenders[pair.ising];
                    let stricter = Contender { least: ising.least + 1, ..ising };
                    shares[pair.ising] >= shares[other] && stricter.share(&layout, &sample) < shares[other]
                };
                let fair = pairs.iter().filter(|pair| pair.other == other).find(is_fair);
                assert!(fair.is_some(), "{} of {contenders:?}", contenders[other].name());
            }
        }
    }

    #[test]
    fn no_contender_stands_twice_and_each_has_its_share() {
        for layout in layouts() {
            let Field { contenders, shares, .. } = Field::new(&layout, FEW);
            let is_new = |place: usize| !contenders[..place].contains(&contenders[place]);
            assert!((0..contenders.len()).all(is_new), "{contenders:?}");
            let sample = random_codes(&layout, FEW);
            let again: Vec<f64> =
                contenders.iter().map(|contender| contender.share(&layout, &sample)).collect();
            assert_eq!(shares, again);
        }
    }
}
