//! Which instructions the search may use: a value, chosen once and passed in. The codes that are found never depend on it.

use std::fmt;

/// A set of instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Popcnt,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Work that is compiled once for each level. `run` must be `#[inline(always)]`, so that it is compiled with the
/// instructions of the wrapper that it is inlined into.
pub trait Kernel {
    /// What comes of the work, at every level the same.
    type Output;
    /// Does it.
    fn run(self) -> Self::Output;
}

impl Level {
    /// What every processor of this architecture has.
    pub const PORTABLE: Level = Level(Kind::Portable);

    /// The levels that this processor can run, best last.
    #[must_use]
    pub fn available() -> Vec<Level> {
        #[allow(unused_mut, reason = "only pushed to on processors with levels of their own")]
        let mut levels = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            let counts_bits = is_x86_feature_detected!("popcnt");
            let avx2 = counts_bits && is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512vpopcntdq");
            if counts_bits {
                levels.push(Level(Kind::Popcnt));
            }
            if avx2 {
                levels.push(Level(Kind::Avx2));
            }
            if avx2 && avx512 {
                levels.push(Level(Kind::Avx512));
            }
        }
        levels
    }

    /// The best level of this processor.
    #[must_use]
    pub fn best() -> Level {
        Self::available().last().copied().unwrap_or(Self::PORTABLE)
    }

    /// The level of this name.
    ///
    /// # Errors
    /// [`UnknownLevel`] when there is none or this processor does not have it.
    pub fn named(name: &str) -> Result<Level, UnknownLevel> {
        let named = Self::available().into_iter().find(|level| level.name() == name);
        named.ok_or_else(|| UnknownLevel(name.to_owned()))
    }

    /// `portable`, `popcnt`, `avx2` or `avx512`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Popcnt => "popcnt",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// Runs `kernel`, compiled for this level.
    #[allow(unsafe_code, reason = "calls functions that are compiled for instructions found to be there")]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Kind::Portable => kernel.run(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this level is only made where the processor has these instructions (Level::available).
            Kind::Popcnt => unsafe { run_popcnt(kernel) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this level is only made where the processor has these instructions (Level::available).
            Kind::Avx2 => unsafe { run_avx2(kernel) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this level is only made where the processor has these instructions (Level::available).
            Kind::Avx512 => unsafe { run_avx512(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "popcnt")]
fn run_popcnt<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,popcnt,bmi1")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vpopcntdq,avx2,popcnt,bmi1")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

impl fmt::Display for Level {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// A level of this name does not exist or this processor does not have it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownLevel(pub String);

impl fmt::Display for UnknownLevel {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let here: Vec<&str> = Level::available().into_iter().map(Level::name).collect();
        write!(out, "this processor has no level {:?}: use one of {}", self.0, here.join(", "))
    }
}

impl std::error::Error for UnknownLevel {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_found_by_their_names_and_no_others() {
        for level in Level::available() {
            assert_eq!(Level::named(level.name()), Ok(level));
        }
        assert!(Level::named("fast").unwrap_err().to_string().contains("portable"));
        assert_eq!(Level::available().last(), Some(&Level::best()));
    }
}
