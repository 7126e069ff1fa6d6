//! Form factors against what is known about them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod closed_form;
mod formulas;
mod truth;
