//! Room `service` (under construction).
