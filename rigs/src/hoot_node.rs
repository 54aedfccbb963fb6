//! A hoot node: a rig of three motors in microsteps, and a camera.
