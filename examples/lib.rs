//! Modules that the example programs share.

pub mod cli;
#[cfg(feature = "terminal")]
pub mod print;
pub mod program;
pub mod record;
#[cfg(feature = "terminal")]
pub mod show;
pub mod tap;
pub mod text;

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
