//! A test file per stage.

mod smoke;
