//! A kOS device: a rig of motors in rotations, cameras, and up to four clients.
