//! What the detector says about one tag.

/// One tag found in one frame. Coordinates: `docs/coordinates.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Which of the detector's families, by its place in the list given to [`crate::Detector::new`].
    pub family: usize,
    /// The tag's id: its place in the family's code table.
    pub id: u32,
    /// How many bits were corrected.
    pub hamming: u32,
    /// Decision margin in grey levels: mean distance of the bits from their threshold, the worse of black and white.
    pub margin: f32,
    /// The margin divided by half the tag's contrast: about 1 for a clean tag.
    pub relative_margin: f32,
    /// Where the tag's middle is seen, pixels of the full-resolution frame.
    pub center: [f64; 2],
    /// Bottom-left, bottom-right, top-right, top-left of the upright tag's border edge.
    pub corners: [[f64; 2]; 4],
    /// Row-major, tag square [-1,1]^2 to full-resolution pixels, last element 1.
    pub homography: [f64; 9],
    /// What to be careful about.
    pub flags: Flags,
}

/// Warnings about a detection, as bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(pub u32);

impl Flags {
    /// A corner lies outside the frame or within a pixel of its rim.
    pub const TOUCHES_EDGE: Flags = Flags(1);
    /// Fewer than 2 pixels a cell: corners are less certain.
    pub const SMALL: Flags = Flags(2);
    /// Fewer than 20 grey levels between black and white.
    pub const DIM: Flags = Flags(4);
    /// White (or black) is clipped by the sensor.
    pub const SATURATED: Flags = Flags(8);

    /// Each flag's bit and its name in JSON.
    pub const NAMES: [(Flags, &'static str); 4] = [
        (Self::TOUCHES_EDGE, "touches_edge"),
        (Self::SMALL, "small"),
        (Self::DIM, "dim"),
        (Self::SATURATED, "saturated"),
    ];

    /// Whether all bits of `other` are set.
    #[must_use]
    pub fn contains(self, other: Flags) -> bool {
        self.0 & other.0 == other.0
    }

    /// The names of the flags that are set.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(flag, _)| self.contains(*flag)).map(|(_, name)| name)
    }
}
