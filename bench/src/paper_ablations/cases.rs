//! The lines of the record.

use tagbus_paper::{Filter, LineError, Options, Refinement, Sampling, SortKey, Unions};

/// The paper's pipeline, or that with one step changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) options: Options,
}

/// The name of the lines that others are compared with, one for each decimation.
pub(super) const PAPER: &str = "the paper";

/// All cases; the paper's own come before what is compared with them.
pub(super) fn all() -> Vec<Case> {
    let paper = Options::default();
    let halved = Options { decimation: 2, ..paper };
    let case = |name, options| Case { name, options };
    vec![
        case(PAPER, paper),
        case("all unions (figure 5 without line 6)", Options { unions: Unions::All, ..paper }),
        case("sorted by atan2 (instead of equation 2)", Options { sort_key: SortKey::Atan2, ..paper }),
        case("line error by the normal's angle", Options { line_error: LineError::Normal, ..paper }),
        case("nearest pixel (instead of bilinear)", Options { sampling: Sampling::Nearest, ..paper }),
        case("no sharpening (equation 5 with 0)", Options { sharpening: 0.0, ..paper }),
        case("corners not refined", Options { refinement: Refinement::None, ..paper }),
        case(PAPER, halved),
        case("box filter (instead of point sampling)", Options { filter: Filter::Box, ..halved }),
        case("corners not refined", Options { refinement: Refinement::None, ..halved }),
    ]
}
