//! Which instructions may be used: a value, chosen once and passed in.

use std::fmt;

/// A set of instructions that this processor has. Results never depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// Work that is compiled once for each level. `run` must be `#[inline(always)]`, so that it is compiled with the
/// instructions of the wrapper that it is inlined into.
pub(crate) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

impl Level {
    /// Plain Rust, without special instructions.
    pub const SCALAR: Level = Level(Kind::Scalar);

    /// The levels that this processor can run, best last.
    #[must_use]
    pub fn available() -> Vec<Level> {
        #[allow(unused_mut, reason = "only pushed to on processors with levels of their own")]
        let mut levels = vec![Self::SCALAR];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if avx2 {
                levels.push(Level(Kind::Avx2));
            }
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512vbmi2");
            if avx2 && avx512 {
                levels.push(Level(Kind::Avx512));
            }
        }
        // Every processor of this architecture has it, and the target's baseline says so.
        #[cfg(target_arch = "aarch64")]
        levels.push(Level(Kind::Neon));
        levels
    }

    /// The best level of this processor.
    #[must_use]
    pub fn best() -> Level {
        Self::available().last().copied().unwrap_or(Self::SCALAR)
    }

    /// The level of this name, if this processor has it.
    pub fn named(name: &str) -> Result<Level, UnknownLevel> {
        Self::available()
            .into_iter()
            .find(|level| level.name() == name)
            .ok_or_else(|| UnknownLevel(name.to_owned()))
    }

    /// `scalar`, `avx2`, `avx512` or `neon`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
        }
    }

    pub(super) fn kind(self) -> Kind {
        self.0
    }

    /// Runs `kernel`, compiled for this level.
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Kind::Scalar => kernel.run(),
            // Wider vectors than AVX2 gain nothing in compiler-made loops here and cost clock on some processors.
            #[cfg(target_arch = "x86_64")]
            // SAFETY: levels of these kinds are only made where the processor has these features (Level::available).
            Kind::Avx2 | Kind::Avx512 => unsafe { super::x86::run_avx2(kernel) },
            // Needs no wrapper: everything is compiled with NEON there.
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => kernel.run(),
        }
    }

    /// The same with this level's widest vectors: for arithmetic on long rows of numbers, where it was measured that they pay.
    pub(crate) fn run_wide<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: levels of this kind are only made where the processor has these features (Level::available).
            Kind::Avx512 => unsafe { super::x86::run_avx512(kernel) },
            _ => self.run(kernel),
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A level of this name does not exist or this processor does not have it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownLevel(pub String);

impl fmt::Display for UnknownLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let here: Vec<&str> = Level::available().into_iter().map(Level::name).collect();
        write!(f, "this processor has no level {:?}: use one of {}", self.0, here.join(", "))
    }
}

impl std::error::Error for UnknownLevel {}
