//! A kOS client.
