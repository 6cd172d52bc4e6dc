//! Room `client` (under construction).
