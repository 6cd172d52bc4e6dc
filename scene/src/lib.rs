//! Room `scene` (under construction).
