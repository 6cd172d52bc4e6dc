//! Everything that a change of parameters changes, in one piece: it is replaced between two frames, whole.

use tagbus_detector::{Detector, Refinement, Sampling, Search, Settings};
use tagbus_family::Family;
use tagbus_message::control::{DetectorParameters, RefinementChoice, Region, SamplingChoice, SearchChoice};
use tagbus_message::detection::DetectionsHeader;

use crate::convert::{self, FamilyName};
use crate::report::ServiceError;

/// What a detector is made of.
#[derive(Clone, Debug)]
pub(crate) struct Wish {
    pub(crate) families: Vec<Family>,
    pub(crate) settings: Settings,
    pub(crate) region: Option<Region>,
}

/// One set of parameters with the detector that obeys them and the header that names them.
pub(crate) struct InForce {
    pub(crate) detector: Detector,
    pub(crate) wish: Wish,
    pub(crate) names: Vec<FamilyName>,
    /// The part of a message's header that does not change from frame to frame.
    pub(crate) template: DetectionsHeader,
    /// As they are told.
    pub(crate) parameters: DetectorParameters,
}

impl InForce {
    /// Builds the detector; nothing of an older one is touched.
    pub(crate) fn new(wish: Wish, detector_epoch: u64, control_number: u64) -> Result<Self, ServiceError> {
        let names = convert::family_names(&wish.families).map_err(ServiceError::Family)?;
        let detector = Detector::new(&wish.families, &wish.settings).map_err(ServiceError::Settings)?;
        let template = DetectionsHeader {
            detector_epoch,
            control_number,
            ..convert::header_template(&wish.settings, &names, wish.region)
        };
        let parameters = parameters(&wish);
        Ok(Self { detector, wish, names, template, parameters })
    }

    pub(crate) fn control_number(&self) -> u64 {
        self.template.control_number
    }
}

fn parameters(wish: &Wish) -> DetectorParameters {
    let settings = &wish.settings;
    DetectorParameters {
        decimation: settings.decimation.factor() as f32,
        sampling: told_sampling(settings.sampling),
        search: told_search(settings.search),
        threads: settings.threads as u32,
        hamming: settings.hamming,
        refinement: told_refinement(settings.refinement),
        sharpening: settings.sharpening,
        min_margin: settings.min_margin,
        region: wish.region,
        families: wish.families.iter().map(|family| family.name().to_owned()).collect(),
        ids: ranges_of(&settings.ids),
    }
}

/// Ids as ranges, in rising order.
fn ranges_of(ids: &[u32]) -> Vec<(u32, u32)> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    let mut ranges: Vec<(u32, u32)> = Vec::new();
    for id in ids {
        match ranges.last_mut() {
            Some((_, last)) if id <= last.saturating_add(1) => *last = id,
            _ => ranges.push((id, id)),
        }
    }
    ranges
}

fn told_sampling(sampling: Sampling) -> SamplingChoice {
    match sampling {
        Sampling::Point => SamplingChoice::Point,
        Sampling::Mean => SamplingChoice::Mean,
        Sampling::Darkest => SamplingChoice::Darkest,
    }
}

fn told_search(search: Search) -> SearchChoice {
    match search {
        Search::Quick => SearchChoice::Quick,
        Search::Fine => SearchChoice::Fine,
        Search::Thorough => SearchChoice::Thorough,
    }
}

fn told_refinement(refinement: Refinement) -> RefinementChoice {
    match refinement {
        Refinement::None => RefinementChoice::None,
        Refinement::Edges => RefinementChoice::Edges,
        Refinement::Tag => RefinementChoice::Tag,
    }
}

/// The detector's word for a choice.
pub(crate) fn sampling(choice: SamplingChoice) -> Sampling {
    match choice {
        SamplingChoice::Point => Sampling::Point,
        SamplingChoice::Mean => Sampling::Mean,
        SamplingChoice::Darkest => Sampling::Darkest,
    }
}

/// The detector's word for a choice.
pub(crate) fn search(choice: SearchChoice) -> Search {
    match choice {
        SearchChoice::Quick => Search::Quick,
        SearchChoice::Fine => Search::Fine,
        SearchChoice::Thorough => Search::Thorough,
    }
}

/// The detector's word for a choice.
pub(crate) fn refinement(choice: RefinementChoice) -> Refinement {
    match choice {
        RefinementChoice::None => Refinement::None,
        RefinementChoice::Edges => Refinement::Edges,
        RefinementChoice::Tag => Refinement::Tag,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_have_the_detectors_names_and_come_back() {
        for (choice, name) in Sampling::NAMES {
            assert_eq!((sampling(told_sampling(choice)), told_sampling(choice).name()), (choice, name));
        }
        for (choice, name) in Search::NAMES {
            assert_eq!((search(told_search(choice)), told_search(choice).name()), (choice, name));
        }
        for (choice, name) in Refinement::NAMES {
            assert_eq!((refinement(told_refinement(choice)), told_refinement(choice).name()), (choice, name));
        }
    }

    #[test]
    fn ids_are_told_as_ranges() {
        assert_eq!(ranges_of(&[5, 1, 2, 3, 2, 9, u32::MAX]), [(1, 3), (5, 5), (9, 9), (u32::MAX, u32::MAX)]);
        assert_eq!(ranges_of(&[]), []);
    }
}
