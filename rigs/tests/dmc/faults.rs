//! The same with all that can go wrong: nothing is told as done that is not, and nothing moves behind a stop.
