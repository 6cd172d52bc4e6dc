//! Intervals by the bootstrap: places and families are drawn again, with replacement, and everything is counted anew.

use tagbus_scene::Stream;

use super::matches::LEVELS;

/// Draws.
pub(super) const DRAWS: usize = 2000;

/// For each seed and place the quads by corrected bits.
pub(super) type Counts = Vec<Vec<[u32; LEVELS]>>;

/// How often each place and each seed is taken in one draw.
struct Draw {
    places: Vec<f64>,
    seeds: Vec<f64>,
}

/// What is measured and the ends of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Estimate {
    /// As a multiple of a number above 0.
    pub(super) fn over(self, whole: f64) -> Estimate {
        Estimate { value: self.value / whole, low: self.low / whole, high: self.high / whole }
    }
}

/// The draws, the same for all contenders, so that differences are between counts at the same places with the same seeds.
pub(super) struct Bootstrap {
    /// Quads of each place.
    quads: Vec<f64>,
    whole: Draw,
    draws: Vec<Draw>,
}

impl Bootstrap {
    pub(super) fn new(quads: &[usize], seeds: usize, seed: u64) -> Bootstrap {
        let mut random = Stream::new(seed);
        let mut draw = |count: usize| {
            let mut times = vec![0.0; count];
            for _ in 0..count {
                times[random.below(count as u64) as usize] += 1.0;
            }
            times
        };
        let draws = (0..DRAWS).map(|_| Draw { places: draw(quads.len()), seeds: draw(seeds) }).collect();
        let whole = Draw { places: vec![1.0; quads.len()], seeds: vec![1.0; seeds] };
        Bootstrap { quads: quads.iter().map(|count| *count as f64).collect(), whole, draws }
    }

    /// False positives a family with exactly so many corrected bits, for as many quads as there are.
    pub(super) fn estimate(&self, counts: &Counts, bits: usize) -> Estimate {
        self.estimate_of(|draw| self.count(counts, bits, draw))
    }

    /// How many fewer or more the first has than the second.
    pub(super) fn difference(&self, [first, second]: [&Counts; 2], bits: usize) -> Estimate {
        self.estimate_of(|draw| self.count(first, bits, draw) - self.count(second, bits, draw))
    }

    fn estimate_of(&self, value: impl Fn(&Draw) -> f64) -> Estimate {
        let mut values: Vec<f64> = self.draws.iter().map(&value).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        Estimate { value: value(&self.whole), low: at(0.025), high: at(0.975) }
    }

    /// Draws differ in how many quads they have, so what is found is related to them.
    fn count(&self, counts: &Counts, bits: usize, draw: &Draw) -> f64 {
        let quads: f64 = self.quads.iter().zip(&draw.places).map(|(quads, times)| quads * times).sum();
        let of_seed = |of_places: &Vec<[u32; LEVELS]>| {
            let places = of_places.iter().zip(&draw.places);
            places.map(|(counts, times)| f64::from(counts[bits]) * times).sum::<f64>()
        };
        let found: f64 = counts.iter().zip(&draw.seeds).map(|(seed, times)| of_seed(seed) * times).sum();
        found / counts.len() as f64 * self.quads.iter().sum::<f64>() / quads.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(of_places: &[u32]) -> Counts {
        vec![of_places.iter().map(|&count| [count; LEVELS]).collect(); 3]
    }

    #[test]
    fn places_that_agree_have_no_interval_and_those_that_differ_have_one() {
        let bootstrap = Bootstrap::new(&[10; 30], 3, 1);
        let estimate = bootstrap.estimate(&counts(&[2; 30]), 0);
        assert!(
            [estimate.value, estimate.low, estimate.high].iter().all(|value| (value - 60.0).abs() < 1e-9)
        );
        let mut mixed = [1; 30];
        mixed[..15].fill(3);
        let estimate = bootstrap.estimate(&counts(&mixed), 0);
        // Thirty places, standard deviation 1 each: 60 +- 2 * sqrt(30).
        assert!((estimate.value - 60.0).abs() < 1e-9);
        assert!((-13.0..-9.0).contains(&(estimate.low - 60.0)), "{estimate:?}");
        assert!((9.0..13.0).contains(&(estimate.high - 60.0)), "{estimate:?}");
    }

    #[test]
    fn what_all_places_share_cancels_in_a_difference() {
        let bootstrap = Bootstrap::new(&[10; 12], 3, 1);
        let many: Vec<u32> = (0..12).map(|place| place * 50).collect();
        let fewer: Vec<u32> = many.iter().map(|count| count.saturating_sub(1)).collect();
        let (many, fewer) = (counts(&many), counts(&fewer));
        assert!(bootstrap.difference([&fewer, &many], 2).high < 0.0);
        assert_eq!(bootstrap.difference([&many, &many], 2).high, 0.0);
        let [a, b] = [&fewer, &many].map(|counts| bootstrap.estimate(counts, 2));
        assert!(a.high > b.low, "alone they cannot be told apart");
    }

    #[test]
    fn families_that_differ_widen_the_interval_where_places_agree() {
        let bootstrap = Bootstrap::new(&[10; 30], 20, 1);
        let counts: Counts = (0..20).map(|seed| vec![[seed % 2 * 4; LEVELS]; 30]).collect();
        let estimate = bootstrap.estimate(&counts, 1);
        // Twenty families, standard deviation 60 each: 60 +- 2 * 60 / sqrt(20).
        assert!((estimate.value - 60.0).abs() < 1e-9);
        assert!((-33.0..-20.0).contains(&(estimate.low - 60.0)), "{estimate:?}");
        assert!((20.0..33.0).contains(&(estimate.high - 60.0)), "{estimate:?}");
    }

    #[test]
    fn what_is_found_is_related_to_the_quads_of_a_draw() {
        // One in ten quads everywhere, however many a place has: drawing other places changes nothing.
        let quads = [10, 1000, 50, 200, 70];
        let bootstrap = Bootstrap::new(&quads, 2, 1);
        let counts: Counts = vec![quads.iter().map(|&quads| [quads as u32 / 10; LEVELS]).collect(); 2];
        let estimate = bootstrap.estimate(&counts, 3);
        assert!([estimate.low, estimate.high].iter().all(|end| (end - 133.0).abs() < 1e-9), "{estimate:?}");
    }
}
