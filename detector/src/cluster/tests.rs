use super::*;
use crate::simd::Level;
use crate::threads::Threads;

/// A plane drawn with `#` for set pixels.
fn drawn(picture: &str) -> (Vec<u64>, usize, usize) {
    let rows: Vec<&str> = picture.split_whitespace().collect();
    let width = rows[0].len();
    let words = width / 64 + 1;
    let mut bits = vec![0; words * rows.len()];
    for (y, row) in rows.iter().enumerate() {
        for (x, letter) in row.bytes().enumerate() {
            bits[y * words + x / 64] |= u64::from(letter == b'#') << (x % 64);
        }
    }
    (bits, width, rows.len())
}

const ALL: Limits = Limits { side: 1, area: 1 };

fn plane(bits: &[u64], width: usize, height: usize, connectivity: Connectivity) -> Plane<'_> {
    // What is not known to be blank is looked at.
    static NOT_BLANK: [bool; 4096] = [false; 4096];
    Plane { bits, blank: &NOT_BLANK[..height], words: width / 64 + 1, width, height, connectivity }
}

fn clusters(bits: &[u64], width: usize, height: usize, connectivity: Connectivity, level: Level) -> Clusters {
    let mut clusters = Clusters::default();
    let mut threads = Threads::start(1).unwrap();
    clusters.fill(level, &mut threads, &plane(bits, width, height, connectivity), &ALL);
    clusters
}

/// Pixels at random: `density` of four are set.
fn random_bits(width: usize, height: usize, density: u64, state: &mut u64) -> Vec<u64> {
    let words = width / 64 + 1;
    let mut bits = vec![0u64; words * height];
    for y in 0..height {
        for x in 0..width {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            bits[y * words + x / 64] |= u64::from((*state >> 60) < 4 * density) << (x % 64);
        }
    }
    bits
}

#[test]
fn a_ring_and_the_dot_inside_it_are_two_components_with_their_outlines() {
    let (bits, width, height) = drawn(
        "..........
         ..#####...
         ..#...##..
         ..#.#..#..
         ..#....#..
         ..######..
         ..........",
    );
    let found = clusters(&bits, width, height, Connectivity::Four, Level::SCALAR);
    let [ring, dot] = found.components() else { panic!("{:?}", found.components()) };
    assert_eq!(found.profile(ring).spans, [[2, 7], [2, 8], [2, 8], [2, 8], [2, 8]]);
    assert_eq!((found.profile(dot).top, found.profile(dot).spans), (3, &[[4, 5]][..]));
}

#[test]
fn corners_connect_bright_pixels_but_not_dark_ones() {
    let (bits, width, height) = drawn(
        "......
         .#..#.
         ..##..
         .#....
         ......",
    );
    let count = |connectivity| clusters(&bits, width, height, connectivity, Level::SCALAR).components().len();
    assert_eq!(count(Connectivity::Four), 4);
    assert_eq!(count(Connectivity::Eight), 1);
}

#[test]
fn a_component_that_two_rims_of_the_frame_cut_is_dropped() {
    let (bits, width, height) = drawn(
        "##....
         ##....
         ......
         ##....
         ##....
         ......",
    );
    assert_eq!(clusters(&bits, width, height, Connectivity::Four, Level::SCALAR).components().len(), 1);
}

/// The plain way: flood fill, pixel by pixel.
fn flood_boxes(bits: &[u64], width: usize, height: usize, eight: bool) -> Vec<[usize; 4]> {
    let words = width / 64 + 1;
    let set = |x: usize, y: usize| bits[y * words + x / 64] >> (x % 64) & 1 == 1;
    let mut seen = vec![false; width * height];
    let mut boxes = Vec::new();
    for start in 0..width * height {
        let (mut stack, mut extent) = (vec![start], [usize::MAX, usize::MAX, 0, 0]);
        while let Some(at) = stack.pop() {
            let (x, y) = (at % width, at / width);
            if seen[at] || !set(x, y) {
                continue;
            }
            seen[at] = true;
            extent = [extent[0].min(x), extent[1].min(y), extent[2].max(x), extent[3].max(y)];
            for (dx, dy) in [(-1i32, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
                let (nx, ny) = (x as i32 + dx, y as i32 + dy);
                let inside = (0..width as i32).contains(&nx) && (0..height as i32).contains(&ny);
                if inside && (eight || dx == 0 || dy == 0) {
                    stack.push(ny as usize * width + nx as usize);
                }
            }
        }
        let rims = [extent[0] == 0, extent[1] == 0, extent[2] == width - 1, extent[3] == height - 1];
        if extent[0] != usize::MAX && rims.iter().filter(|t| **t).count() <= 1 {
            boxes.push(extent);
        }
    }
    boxes.sort_unstable();
    boxes
}

#[test]
fn random_planes_have_the_components_that_a_flood_fill_finds_at_every_level() {
    let mut state = 42u64;
    for width in [1, 7, 63, 64, 65, 130, 200] {
        for density in [1, 2, 3] {
            let height = 40;
            let bits = random_bits(width, height, density, &mut state);
            for connectivity in [Connectivity::Four, Connectivity::Eight] {
                let expected = flood_boxes(&bits, width, height, connectivity == Connectivity::Eight);
                for level in Level::available() {
                    let found = clusters(&bits, width, height, connectivity, level);
                    let mut boxes: Vec<[usize; 4]> = found
                        .components()
                        .iter()
                        .map(|c| [c.left, c.top, c.right - 1, c.bottom].map(usize::from))
                        .collect();
                    boxes.sort_unstable();
                    assert_eq!(
                        boxes, expected,
                        "width {width}, density {density}, {connectivity:?}, {level}"
                    );
                }
            }
        }
    }
}

#[test]
fn noise_has_the_same_components_without_its_specks() {
    let (width, height) = (200, 70);
    let mut state = 44u64;
    let mut threads = Threads::start(1).unwrap();
    for density in [1, 2, 3] {
        let bits = random_bits(width, height, density, &mut state);
        let plane = plane(&bits, width, height, Connectivity::Four);
        let mut kept = |area| {
            let mut clusters = Clusters::default();
            clusters.fill(Level::best(), &mut threads, &plane, &Limits { side: 1, area });
            let large = clusters.components().iter().filter(|component| component.area > 1);
            let of = |component: &Component| {
                (
                    component.area,
                    component.left,
                    clusters.profile(component).top,
                    clusters.profile(component).spans.to_vec(),
                )
            };
            large.map(of).collect::<Vec<_>>()
        };
        assert_eq!(kept(2), kept(1), "density {density}");
    }
}

/// Everything that is known of the kept components, in their order.
fn outlines(clusters: &Clusters) -> Vec<([u16; 4], usize, Vec<[u16; 2]>)> {
    let of = |component: &Component| {
        let Component { left, top, right, bottom, .. } = *component;
        let profile = clusters.profile(component);
        ([left, top, right, bottom], profile.top, profile.spans.to_vec())
    };
    clusters.components().iter().map(of).collect()
}

#[test]
fn planes_cut_into_bands_have_the_same_components_in_the_same_order() {
    let mut state = 43u64;
    let mut threads = Threads::start(2).unwrap();
    let mut cut_up = Clusters::default();
    for (width, height) in [(1, 9), (40, 37), (64, 40), (130, 23), (5, 100)] {
        // Few pixels give small components, many give a few that wind through all bands.
        for density in [1, 2, 3] {
            let bits = random_bits(width, height, density, &mut state);
            for connectivity in [Connectivity::Four, Connectivity::Eight] {
                let plane = plane(&bits, width, height, connectivity);
                for limits in [ALL, Limits { side: 3, area: 6 }] {
                    let mut whole = Clusters::default();
                    whole.cut.evenly(height, 1);
                    whole.fill_cut(Level::best(), &mut threads, &plane, &limits);
                    for bands in 2..=height.min(12) {
                        cut_up.cut.evenly(height, bands);
                        cut_up.fill_cut(Level::best(), &mut threads, &plane, &limits);
                        assert_eq!(
                            outlines(&cut_up),
                            outlines(&whole),
                            "{width}x{height}, density {density}, {connectivity:?}, {limits:?}, {bands} bands"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn bands_are_cut_where_the_frame_before_had_as_many_runs() {
    // Nothing but the lower third has runs: a hundred in each row.
    let (width, height) = (200, 300);
    let words = width / 64 + 1;
    let bits: Vec<u64> = (0..words * height)
        .map(|word| if word < words * 200 || word % words == words - 1 { 0 } else { 0x5555_5555_5555_5555 })
        .collect();
    let plane = plane(&bits, width, height, Connectivity::Four);
    let mut threads = Threads::start(1).unwrap();
    let mut clusters = Clusters::default();
    clusters.cut.evenly(height, 2);
    clusters.fill_cut(Level::best(), &mut threads, &plane, &ALL);
    let Clusters { cut, bands, .. } = &mut clusters;
    cut.by_runs(height, 2, bands);
    let [upper, lower] = [0, 1].map(|band| cut.rows(band));
    assert!(upper.start == 0 && upper.end == lower.start && lower.end == height, "{upper:?} {lower:?}");
    assert!((235..255).contains(&upper.end), "{upper:?}");
    assert!((0..height).all(|row| cut.rows(cut.band_of(row)).contains(&row)));
    // Of a plane of another height nothing is known.
    cut.by_runs(100, 2, bands);
    assert_eq!([cut.rows(0), cut.rows(1)], [0..50, 50..100]);
}

#[test]
fn a_frame_has_the_same_components_whatever_the_frame_before_it_held() {
    let mut state = 45u64;
    let (width, height) = (900, 400);
    let mut threads = Threads::start(3).unwrap();
    let mut used = Clusters::default();
    for density in [1, 3, 2, 1] {
        // Half of it empty, so that the next one is cut elsewhere.
        let mut bits = random_bits(width, height, density, &mut state);
        bits[..(width / 64 + 1) * height / 2].fill(0);
        bits.rotate_left((width / 64 + 1) * 90 * density as usize);
        let plane = plane(&bits, width, height, Connectivity::Four);
        used.fill(Level::best(), &mut threads, &plane, &ALL);
        let mut new = Clusters::default();
        new.fill(Level::best(), &mut Threads::start(1).unwrap(), &plane, &ALL);
        assert_eq!(outlines(&used), outlines(&new), "density {density}");
    }
}
