//! Room `camera` (under construction).
