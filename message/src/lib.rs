//! Room `message` (under construction).
