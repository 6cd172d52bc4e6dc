//! What a tag looks like.

/// A tag family (being written).
pub struct Family {}
